//! Studies: where their loops lie, what a key does to a scene, and how numbers converge.

use crate::loops::preset;
use proptest::prelude::*;
use std::collections::HashSet;
use tackscope::numerics::threads::Cancel;
use tackscope::physics::theory::flat_limits;
use tackscope::scene::{Points, Range, Scene};
use tackscope::study::map::{convergences, estimate, ladder};
use tackscope::study::plan::read_off;
use tackscope::study::sweep::{Point, Row, Sequence, Spacing, Span, Study, column, grid};

fn study(scene: Scene, keys: &[&str], places: Vec<Vec<f64>>) -> Study {
    Study {
        title: String::new(),
        scene,
        keys: keys.iter().map(|key| (*key).to_owned()).collect(),
        places,
        record: vec![
            column("dissipated_energy").unwrap(),
            column("approach_jumps").unwrap(),
        ],
        plot: Default::default(),
    }
}

#[test]
fn a_grid_has_every_combination_once_and_its_last_axis_goes_fastest() {
    let places = grid(&[vec![1.0, 2.0], vec![3.0, 4.0, 5.0]]);
    let flat: Vec<[f64; 2]> = places.iter().map(|p| [p[0], p[1]]).collect();
    assert_eq!(
        flat,
        [
            [1.0, 3.0],
            [1.0, 4.0],
            [1.0, 5.0],
            [2.0, 3.0],
            [2.0, 4.0],
            [2.0, 5.0]
        ]
    );
}

proptest! {
    #[test]
    fn values_go_from_end_to_end_by_equal_steps_or_factors(
        from in 0.01..100.0f64, ratio in 1.01..50.0f64, count in 2usize..40,
    ) {
        let to = from * ratio;
        for spacing in [Spacing::Linear, Spacing::Logarithmic] {
            let values = Span { from, to, spacing }.values(count);
            prop_assert_eq!((values.len(), values[0], values[count - 1]), (count, from, to));
            let step = |pair: &[f64]| match spacing {
                Spacing::Linear => (pair[1] - pair[0]) / (to - from),
                Spacing::Logarithmic => (pair[1] / pair[0]).ln() / ratio.ln(),
            };
            for pair in values.windows(2) {
                prop_assert!((step(pair) * (count - 1) as f64 - 1.0).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn the_first_places_of_a_sequence_stay_when_there_are_more(seed in 0u32..1000, few in 1usize..50) {
        let spans = [Span { from: -1.0, to: 2.0, spacing: Spacing::Linear }; 3];
        for sequence in [Sequence::Random, Sequence::Sobol] {
            let many = sequence.places(&spans, 64, seed);
            prop_assert_eq!(&sequence.places(&spans, few, seed)[..], &many[..few]);
            prop_assert!(many.iter().flatten().all(|x| (-1.0..2.0).contains(x)));
        }
    }
}

/// The property that makes it a (0, m, 2)-net: each of 64 equal boxes of any shape has one of the
/// first 64 points.
#[test]
fn a_sobol_sequence_fills_every_box_of_equal_area_once() {
    let spans = [Span {
        from: 0.0,
        to: 1.0,
        spacing: Spacing::Linear,
    }; 2];
    for seed in 0..5 {
        let places = Sequence::Sobol.places(&spans, 64, seed);
        for across in [1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0] {
            let cell = |p: &Vec<f64>| ((p[0] * across) as usize, (p[1] * 64.0 / across) as usize);
            let cells: HashSet<_> = places.iter().map(cell).collect();
            assert_eq!(cells.len(), 64, "boxes {across} across, seed {seed}");
        }
    }
}

#[test]
fn a_key_changes_its_number_and_the_drive_goes_beyond_every_jump() {
    let mut scene = preset("fig2");
    scene.cell.points = Points::Auto;
    let study = study(
        scene.clone(),
        &["law.range", "cell.length"],
        vec![vec![0.8, 400.0]],
    );
    let there = study.scene_at(&[0.8, 400.0]).unwrap();
    assert_eq!(
        (there.law.range, there.cell.length),
        (Range::Length(0.8), 400.0)
    );
    assert_eq!(there.cell.points, Points::Auto);
    assert_eq!(
        (&there.law.shape, there.seed),
        (&scene.law.shape, scene.seed)
    );
    let model = there.model().unwrap();
    let (lower, upper) = flat_limits(&model.law, 400.0).unwrap();
    let turn = there.turn_of_u0().unwrap();
    assert!(
        there.drive.start > upper && turn < lower,
        "{:?}",
        there.drive
    );
    // Where the ends of the drive go they are what is asked.
    let study = self::study(scene, &["law.range", "drive.start"], Vec::new());
    assert_eq!(study.scene_at(&[0.8, 3.9]).unwrap().drive.start, 3.9);
}

#[test]
fn whole_numbers_are_told_as_the_scene_has_them_and_an_unknown_key_with_all_keys() {
    let places = vec![vec![33.4], vec![48.0]];
    let study = study(preset("fig2"), &["cell.points"], places);
    let values: Vec<f64> = study.points().iter().map(|point| point.values[0]).collect();
    assert_eq!(values, [34.0, 48.0]);
    let wrong = self::study(preset("fig2"), &["law.rage"], Vec::new());
    let refusal = wrong.check().unwrap_err().to_string();
    assert!(
        refusal.contains("law.rage") && refusal.contains("law.range"),
        "{refusal}"
    );
}

#[test]
fn cheap_loops_come_first_each_once_and_a_refused_one_says_why() {
    let mut scene = preset("fig2");
    scene.drive.step = 0.2;
    let study = study(
        scene,
        &["cell.points"],
        grid(&[vec![64.0, 40.0, 1e9, 48.0]]),
    );
    let points = study.points();
    let all: Vec<&Point> = points.iter().collect();
    let (mut rows, mut shares) = (Vec::new(), Vec::new());
    study.compute(&all, &Cancel::default(), &mut |row: Row, share| {
        rows.push(row);
        shares.push(share);
    });
    let mut seen: Vec<usize> = rows.iter().map(|row| row.index).collect();
    assert_eq!(rows[0].index, 2, "what is refused costs nothing");
    assert!(rows[0].reason.contains("cell.points") && !rows[0].is_complete());
    assert!(rows[0].cells.iter().all(|cell| cell.numbers().is_empty()));
    seen.sort_unstable();
    assert_eq!(seen, [0, 1, 2, 3]);
    assert!(shares.windows(2).all(|pair| pair[0] <= pair[1]));
    assert!((shares[3] - 1.0).abs() < 1e-12);
    let cost = |i: usize| points[i].cost;
    assert!(cost(1) < cost(3) && cost(3) < cost(0));
}

#[test]
fn a_cancelled_loop_has_no_row() {
    let study = study(preset("fig2"), &["cell.points"], vec![vec![32.0]]);
    let cancel = Cancel::default();
    cancel.request();
    assert_eq!(study.row(&study.points()[0], &cancel), None);
    study.compute(&[&study.points()[0]], &cancel, &mut |row, _| {
        panic!("{row:?}")
    });
}

proptest! {
    #[test]
    fn richardson_finds_limit_and_order_of_any_power(
        limit in -5.0..5.0f64, error in 0.1..2.0f64, order in 0.5..8.0f64, first in 8usize..64,
    ) {
        let points = [1.0, 1.4, 2.1, 3.0].map(|factor| (first as f64 * factor).round());
        let values = points.map(|n| [n, limit + error * (n / points[0]).powf(-order)]);
        let found = estimate(&values, 0.0);
        let left = (values[3][1] - limit).abs();
        prop_assert!((found.order.unwrap() - order).abs() < 1e-4 * order, "{found:?}");
        prop_assert!((found.limit - limit).abs() < 1e-3 * left + 1e-12, "{found:?}");
        prop_assert!(found.error_bar >= left - 1e-12);
    }

    /// Faster than any power: the limit is off by less than the error bar.
    #[test]
    fn the_error_bar_holds_where_the_error_falls_exponentially(
        limit in -5.0..5.0f64, rate in 0.05..0.25f64,
    ) {
        let values = [32.0, 45.0, 64.0, 90.0].map(|n: f64| [n, limit + (-rate * n).exp()]);
        let found = estimate(&values, 0.0);
        prop_assert!((found.limit - limit).abs() <= found.error_bar + 1e-14, "{found:?}");
    }
}

#[test]
fn what_does_not_converge_has_no_order_and_the_error_bar_of_its_differences() {
    let found = estimate(&[[8.0, 1.0], [16.0, 1.1], [32.0, 0.9]], 0.0);
    assert_eq!((found.order, found.limit), (None, 0.9));
    assert!(found.error_bar >= 0.2);
    assert!(estimate(&[[8.0, 1.0]], 0.0).error_bar.is_nan());
}

/// The limits of the flat state are Eq. 8, whatever the mesh; the loss is that of an atlas on a mesh
/// finer than all of the ladder.
#[test]
fn the_error_bars_of_a_ladder_hold_against_theory_and_a_finer_mesh() {
    let mut scene = preset("fig2");
    scene.cell.points = Points::Square(32);
    scene.drive.step = 0.2;
    let study = ladder(&scene).unwrap();
    let points = study.points();
    let mut rows = Vec::new();
    let all: Vec<&Point> = points.iter().collect();
    study.compute(&all, &Cancel::default(), &mut |row, _| rows.push(row));
    let found = convergences(&study, &rows);
    let of = |name: &str| {
        &found
            .iter()
            .find(|one| one.quantity == name)
            .unwrap()
            .estimate
    };
    let law = scene.model().unwrap().law;
    let (lower, upper) = flat_limits(&law, 256.0).unwrap();
    scene.cell.points = Points::Square(120);
    let jumps = &read_off(&scene, &Cancel::default()).unwrap()[0];
    let loss: f64 = jumps.iter().map(|jump| jump.released_energy).sum();
    let ways = ["approach_jumps", "retraction_jumps"]
        .map(|way| (1..=4).map(move |k| format!("{way} {k}")));
    let jumps = jumps.iter().map(|jump| jump.mean_displacement);
    let mut right: Vec<(String, f64)> = ways.into_iter().flatten().zip(jumps).collect();
    assert_eq!(right.len(), 8);
    let names = [
        "approach_jumps 1",
        "retraction_jumps 1",
        "dissipated_energy",
    ]
    .map(str::to_owned);
    right.extend(names.into_iter().zip([upper, lower, loss]));
    for (name, right) in &right {
        let estimate = of(name);
        assert!(
            (estimate.limit - right).abs() <= estimate.error_bar,
            "{name}: {estimate:?}, right {right}"
        );
        assert!(estimate.error_bar < 1e-3, "{name}: {estimate:?}");
    }
}
