//! Cells little longer than the critical length, where patterns come out of the flat state
//! continuously or next to it: the atlas against the Landau energy and against the walk.

use crate::loops::{driven, flat_ground, planned, walked};
use std::f64::consts::{PI, SQRT_2};
use tackscope::follow::atlas::{Atlas, End};
use tackscope::follow::record::{Cause, Direction, JumpRecord};
use tackscope::follow::run::LoopRun;
use tackscope::physics::control::Control;
use tackscope::physics::law::{DoubleExponential, Law, Mie, Morse, Shape};
use tackscope::physics::pattern::Pattern;
use tackscope::physics::theory::flat_limits;
use tackscope::scene::{Part, Points, Scene};
use tackscope::solver::sector::Side;
use tackscope::study::plan::measured_error;

fn short(shape: Shape, periods: f64) -> Scene {
    flat_ground(shape, periods, Points::Square(16))
}

/// The loop of the plan, off its atlas.
fn off_the_atlas(scene: &Scene) -> LoopRun {
    let run = planned(scene);
    assert_eq!(run.deviation, None);
    run
}

/// The smaller of the fourth-order coefficients, per (mean square)^2, of a wave along x and of waves
/// along x and y alike at a limit of the flat state: the waves of twice the length that they call up
/// are eliminated.
fn landau(law: &Law, length: f64, limit: f64) -> f64 {
    let (q, h) = (2.0 * PI / length, 1e-3 * law.range);
    let [below, at, above] = [-h, 0.0, h].map(|off| law.at(limit + off).stiffness);
    let (third, fourth) = (
        (above - below) / (2.0 * h),
        (above - 2.0 * at + below) / (h * h),
    );
    let called_up = third * third / q;
    let along_x = fourth / 16.0 - called_up / 8.0;
    let alike = 3.0 / 32.0 * fourth - (0.25 / (SQRT_2 - 1.0) + 0.0625) * called_up;
    along_x.min(alike)
}

/// The jumps and transitions out of the flat state: at its upper and its lower limit.
fn out_of_flat(run: &LoopRun) -> [&JumpRecord; 2] {
    Direction::BOTH.map(|direction| {
        let leaves = |jump: &&JumpRecord| jump.direction == direction && jump.from == Pattern::Flat;
        run.record.jumps.iter().find(leaves).unwrap()
    })
}

#[test]
fn a_limit_gives_way_continuously_where_the_landau_energy_has_a_positive_fourth_order() {
    let mut seen = [0, 0];
    for periods in [1.03, 1.06, 1.075, 1.1, 1.14, 1.165, 1.22, 1.26] {
        let scene = short(Shape::Morse(Morse), periods);
        let law = scene.model().unwrap().law;
        let (lower, upper) = flat_limits(&law, scene.cell.length).unwrap();
        let run = off_the_atlas(&scene);
        for (jump, limit) in out_of_flat(&run).into_iter().zip([upper, lower]) {
            let fourth = landau(&law, scene.cell.length, limit);
            assert_eq!(
                jump.cause == Cause::Transition,
                fourth > 0.0,
                "{periods}: {jump:?}"
            );
            assert!((jump.mean_displacement - limit).abs() < 1e-9, "{jump:?}");
            assert_eq!(jump.released_energy == 0.0, fourth > 0.0, "{jump:?}");
            seen[usize::from(fourth > 0.0)] += 1;
        }
    }
    assert!(seen.iter().all(|count| *count > 4), "{seen:?}");
}

#[test]
fn where_patterns_fade_the_atlas_has_the_loop_of_the_walk() {
    for (shape, periods) in [
        (Shape::Morse(Morse), 1.06),
        (Shape::Morse(Morse), 1.1568),
        (Shape::Mie(Mie { m: 6.93, n: 1.9646 }), 1.1581),
        (
            Shape::DoubleExponential(DoubleExponential { ratio: 0.2838 }),
            1.15,
        ),
    ] {
        let scene = short(shape, periods);
        let (atlas, walk) = (off_the_atlas(&scene), walked(&scene, Part::Quarter));
        let tallies = [&atlas, &walk].map(|run| run.record.tally());
        assert_eq!(tallies[0], tallies[1], "{shape:?} {periods}");
        let error = measured_error(&atlas.record.jumps, &walk.record.jumps);
        // Some of these loops lose less than a millionth of gamma, and ends are found within 1e-5 ranges.
        let located = [&atlas, &walk]
            .map(|run| run.ledger(0.15).unwrap().stated_error(0.0).unwrap())
            .iter()
            .sum::<f64>();
        assert!(error < 3e-5 + located, "{shape:?} {periods}: {error}");
        assert_eq!(atlas.ledger(0.15).unwrap().open, None);
    }
}

#[test]
fn a_jump_is_one_to_walk_and_atlas_however_little_it_releases() {
    // Dimples live on for 1e-4 to 1e-3 ranges beyond the limit.
    for (shape, periods) in [
        (Shape::Morse(Morse), 1.196),
        (Shape::Morse(Morse), 1.205),
        (
            Shape::Mie(Mie {
                m: 10.072,
                n: 3.666,
            }),
            1.218,
        ),
    ] {
        let scene = short(shape, periods);
        let (atlas, walk) = (off_the_atlas(&scene), walked(&scene, Part::Quarter));
        let faintest = |run: &LoopRun| {
            let released = run.record.jumps.iter().map(|jump| jump.released_energy);
            released.fold(f64::INFINITY, f64::min)
        };
        assert!(0.0 < faintest(&atlas) && faintest(&atlas) < 1e-6);
        let tallies = [&atlas, &walk].map(|run| run.record.tally());
        assert_eq!(tallies[0], tallies[1], "{shape:?} {periods}");
        for (a, b) in atlas.record.jumps.iter().zip(&walk.record.jumps) {
            let off = (a.released_energy - b.released_energy).abs();
            assert!(
                off < a.release_error + b.release_error + 1e-10,
                "{a:?} {b:?}"
            );
            assert!((a.control - b.control).abs() < 1e-5, "{a:?} {b:?}");
        }
    }
}

#[test]
fn a_dimple_whose_fold_lies_next_to_the_limit_is_traced() {
    for (shape, periods) in [
        (Shape::Morse(Morse), 1.262),
        (Shape::Morse(Morse), 1.285),
        (Shape::Mie(Mie { m: 6.217, n: 2.386 }), 1.2891),
        (
            Shape::DoubleExponential(DoubleExponential { ratio: 0.3475 }),
            1.2864,
        ),
    ] {
        let scene = short(shape, periods);
        let (atlas, walk) = (off_the_atlas(&scene), walked(&scene, Part::Quarter));
        let error = measured_error(&atlas.record.jumps, &walk.record.jumps);
        assert!(error < 3e-5, "{shape:?} {periods}: {error}");
        let law = scene.model().unwrap().law;
        let (lower, _) = flat_limits(&law, scene.cell.length).unwrap();
        let onto_flat = |jump: &&JumpRecord| jump.to == Pattern::Flat;
        let lives = lower - atlas.record.jumps.iter().find(onto_flat).unwrap().control;
        assert!(0.0 < lives && lives < 0.02, "{lives}");
    }
}

#[test]
fn a_branch_under_a_spring_ends_where_the_slope_is_that_of_the_spring() {
    // The dimple's fold of u0 lies 1.6e-5 ranges of the stage beside the end.
    let stiffness = 0.37937;
    let scene = driven(
        flat_ground(Shape::Morse(Morse), 1.54142, Points::Square(24)),
        Control::Spring { stiffness },
        [6.3, 0.104, 0.2],
    );
    let model = scene.model().unwrap();
    let mut atlas = Atlas::of(&scene, &model);
    atlas.cycle(scene.drive.start, scene.depth()).unwrap();
    let mut seen = 0;
    for branch in atlas.branches() {
        for side in Side::BOTH {
            let end = branch.end(side);
            if branch.ends[side.index()] == End::Fold {
                assert!((end.slope / -stiffness - 1.0).abs() < 0.01, "{}", end.slope);
                seen += 1;
            }
        }
    }
    assert!(seen > 0);
}
