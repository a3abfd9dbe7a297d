//! Where a surface lands when its branch ends: the same place for every seed, on every strategy, or
//! several that are said.

use crate::loops::{planned, walked};
use tackscope::follow::record::Cause;
use tackscope::follow::run::LoopRun;
use tackscope::physics::law::{Mie, Morse, Shape};
use tackscope::physics::pattern::Pattern;
use tackscope::scene::{Part, Points, Scene};

fn scene(shape: Mie, periods: f64, n: usize, seed: u64) -> Scene {
    Scene {
        seed,
        ..crate::loops::flat_ground(Shape::Mie(shape), periods, Points::Square(n))
    }
}

fn visited(run: &LoopRun) -> Vec<Pattern> {
    run.record.jumps.iter().map(|jump| jump.to).collect()
}

#[test]
fn every_seed_and_both_strategies_pass_the_same_patterns() {
    // With inertia in the release seeds parted at the flat limit of the first and at the end of the
    // ridge of the second.
    for (shape, periods, n) in [
        (Mie { m: 9.37, n: 2.61 }, 3.0, 56),
        (Mie { m: 3.703, n: 2.46 }, 2.2, 40),
    ] {
        let expected = visited(&planned(&scene(shape, periods, n, 1)));
        assert_eq!(expected.len(), 8, "{expected:?}");
        for seed in 1..=10 {
            assert_eq!(
                visited(&walked(&scene(shape, periods, n, seed), Part::Quarter)),
                expected,
                "{shape:?}, seed {seed}"
            );
        }
    }
}

#[test]
fn next_to_a_saddle_every_part_of_the_cell_lands_where_most_mixtures_do() {
    // A release of the walk alone passed the bulge by some seeds: next to pure waves in the first, from
    // the middle of all mixtures that lead there in the others.
    for (shape, periods, n) in [
        (
            Mie {
                m: 5.3413,
                n: 2.0916,
            },
            4.73,
            80,
        ),
        (
            Mie {
                m: 9.3262,
                n: 3.8394,
            },
            4.776,
            64,
        ),
        (
            Mie {
                m: 10.3413,
                n: 3.821,
            },
            4.153,
            64,
        ),
    ] {
        let first = |run: &LoopRun| run.record.jumps[0].to;
        assert_eq!(
            first(&planned(&scene(shape, periods, n, 1))),
            Pattern::Bulge
        );
        for (part, seed) in [(Part::Quarter, 1), (Part::Quarter, 2), (Part::Whole, 3)] {
            let run = walked(&scene(shape, periods, n, seed), part);
            assert_eq!(
                first(&run),
                Pattern::Bulge,
                "{shape:?}, {part:?}, seed {seed}"
            );
        }
    }
}

#[test]
fn a_bulge_that_lives_but_a_thousandth_of_a_range_is_read_off_an_atlas() {
    // Its states are far from all others as they are close to a fold.
    let scene = scene(
        Mie {
            m: 5.7877,
            n: 3.7311,
        },
        4.765,
        72,
        1,
    );
    let run = planned(&scene);
    assert_eq!(run.deviation, None);
    let [.., ridge, bulge] = &run.record.jumps[..] else {
        panic!("{:?}", run.record.jumps)
    };
    assert_eq!([ridge.to, bulge.to], [Pattern::Bulge, Pattern::Flat]);
    let lives = bulge.mean_displacement - ridge.mean_displacement;
    assert!(lives > 0.0 && lives < 1e-3, "{lives}");
}

#[test]
fn fig_2_is_not_contested() {
    let run = planned(&crate::loops::flat_ground(
        Shape::Morse(Morse),
        3.0,
        Points::Square(48),
    ));
    assert!(run.record.jumps.iter().all(|jump| jump.landings.is_empty()) && run.rivals.is_empty());
    assert_eq!(run.record.jumps[0].cause_words(), "flat limit");
}

#[test]
fn a_contested_landing_is_said_with_its_shares_and_the_loss_of_the_other() {
    let scene = scene(
        Mie {
            m: 9.4735,
            n: 3.7287,
        },
        4.009,
        72,
        100,
    );
    let run = planned(&scene);
    let jump = &run.record.jumps[0];
    assert!(
        jump.landings.len() == 2 && jump.cause == Cause::FlatLimit,
        "{jump:?}"
    );
    let all: f64 = jump.landings.iter().map(|share| share.share).sum();
    assert!((all - 1.0).abs() < 1e-12 && jump.landings[0].share > jump.landings[1].share);
    assert!(
        jump.cause_words().starts_with("flat limit; contested: "),
        "{}",
        jump.cause_words()
    );
    let [rival] = &run.rivals[..] else {
        panic!("{:?}", run.rivals)
    };
    assert_ne!(rival.landing.pattern, jump.to);
    // From the same state to the same state: what one way releases in one jump the other releases
    // in two, and they differ by the work between them.
    let (usual, other) = (
        run.record.released_energy_sum(),
        rival.dissipated_energy.unwrap(),
    );
    assert!(
        (usual - other).abs() > 1e-4 * usual && (usual - other).abs() < 0.05 * usual,
        "{usual} {other}"
    );
}

#[test]
fn a_dimple_that_ends_beyond_the_flat_limit_jumps_and_does_not_fade() {
    // A step as long as this has gone from the dimple to the flat state unseen; it releases little.
    let scene = scene(
        Mie {
            m: 6.0125,
            n: 2.6546,
        },
        1.671,
        24,
        22,
    );
    let (walk, atlas) = (walked(&scene, Part::Quarter), planned(&scene));
    assert_eq!(visited(&walk), visited(&atlas));
    let last = |run: &LoopRun| {
        run.record
            .jumps
            .iter()
            .find(|jump| jump.to == Pattern::Flat)
            .cloned()
            .unwrap()
    };
    let (a, b) = (last(&walk), last(&atlas));
    assert_eq!((a.cause, b.cause), (Cause::Fold, Cause::Fold));
    assert!(
        (a.mean_displacement - b.mean_displacement).abs() < 2e-4,
        "{} {}",
        a.mean_displacement,
        b.mean_displacement
    );
    assert!((a.released_energy / b.released_energy - 1.0).abs() < 0.01);
}
