//! The map of patterns: against closed forms, against loops made afresh, and where none is known. And
//! the measured stability of GFMD against the bound, on the approach of Fig. 2.

use crate::loops::{assert_same_jumps, flat_ground, preset, preset_on, walked};
use tackscope::follow::record::{Cause, Direction, JumpRecord};
use tackscope::numerics::threads::Cancel;
use tackscope::physics::law::{Morse, Shape};
use tackscope::physics::theory::{critical_length, flat_limits};
use tackscope::scene::{Part, Points, Range, Scene, Turn};
use tackscope::study::live_loop::{Fineness, LiveLoops};
use tackscope::study::map::{PatternMap, Vary};
use tackscope::study::time_step_map::{Progress, Survey, TimeStepMap};

fn map(key: &str, from: f64, to: f64, count: usize) -> PatternMap {
    let vary = Vary {
        key: key.to_owned(),
        from,
        to,
    };
    PatternMap::of(
        &preset("fig2"),
        &vary,
        count,
        &Cancel::default(),
        &mut |_, _| {},
    )
    .unwrap()
}

#[test]
fn the_flat_limits_of_every_row_are_those_of_eq_8_and_the_loss_is_the_sum_of_the_releases() {
    let map = map("law.range", 0.8, 1.25, 8);
    assert_eq!(map.rows.len(), 8);
    for row in &map.rows {
        let (law, found) = (row.law.unwrap(), row.found.as_ref().unwrap());
        assert_eq!(law.range, row.value);
        let (lower, upper) = flat_limits(&law, 256.0).unwrap();
        for (direction, limit) in [(Direction::Approach, upper), (Direction::Retraction, lower)] {
            let jump = found
                .jumps
                .iter()
                .find(|j| j.direction == direction)
                .unwrap();
            assert_eq!(jump.cause, Cause::FlatLimit);
            assert!(
                (jump.mean_displacement - limit).abs() < 1e-8,
                "{jump:?} {limit}"
            );
        }
        let sum: f64 = found.jumps.iter().map(|j| j.released_energy).sum();
        assert!((sum - found.dissipated_energy).abs() < 1e-12);
    }
}

/// Carried landings are not asked for again: where another one takes over the map must know.
#[test]
fn every_row_is_the_loop_made_afresh_also_where_the_order_of_the_patterns_changes() {
    let map = map("law.range", 0.6, 1.5, 49);
    let order = |jumps: &[JumpRecord]| -> Vec<_> {
        jumps.iter().map(|j| (j.direction, j.from, j.to)).collect()
    };
    let mut orders = Vec::new();
    for row in map.rows.iter().step_by(3) {
        let mut scene = preset("fig2");
        scene.law.range = Range::Length(row.value);
        let limits = flat_limits(&row.law.unwrap(), 256.0).unwrap();
        scene.drive.start = limits.1 + 8.0 * row.value;
        scene.drive.turn = Turn::At(limits.0 - row.value);
        let fresh = LiveLoops::default()
            .next(&scene, &scene.model().unwrap(), Fineness::Coarse)
            .unwrap();
        let found = row.found.as_ref().unwrap();
        assert_same_jumps(&found.jumps, &fresh.jumps, 1e-4);
        orders.push(order(&fresh.jumps));
    }
    orders.dedup();
    assert!(orders.len() > 1, "the order does not change");
}

/// What somebody saw of a map who heard of each row is the map, coarse at first.
#[test]
fn rows_are_told_from_few_to_many_and_together_are_the_map_up_and_down() {
    for vary in ["law.range=0.9..1.1", "law.range=1.1..0.9"] {
        let vary: Vary = vary.parse().unwrap();
        let mut seen = PatternMap {
            vary: vary.clone(),
            rows: Vec::new(),
            cancelled: false,
        };
        let mut gaps = Vec::new();
        let cancel = Cancel::default();
        let map = PatternMap::of(&preset("fig2"), &vary, 33, &cancel, &mut |row, _| {
            seen.insert(row.clone());
            let steps = seen
                .rows
                .windows(2)
                .map(|w| (w[1].value - w[0].value).abs());
            gaps.push(steps.fold(0.0, f64::max));
        });
        let map = map.unwrap();
        let loops = |map: &PatternMap| -> Vec<_> {
            map.rows
                .iter()
                .map(|row| (row.value, row.found.clone()))
                .collect()
        };
        assert_eq!(loops(&seen), loops(&map));
        assert_eq!(map.rows.len(), 33);
        // After a sixth of the rows none is farther from its neighbours than a quarter of the way.
        assert!(gaps[5] < 0.0501, "{gaps:?}");
    }
}

#[test]
fn below_the_critical_length_nothing_jumps_and_nothing_is_lost() {
    let critical = critical_length(&preset("fig2").model().unwrap().law);
    let map = map("cell.length", 0.8 * critical, 1.27 * critical, 6);
    for row in &map.rows {
        let found = row.found.as_ref().unwrap();
        assert_eq!(found.jumps.is_empty(), row.value < critical, "{row:?}");
        assert_eq!(found.dissipated_energy == 0.0, row.value < critical);
    }
}

/// Of some of these cells the atlas does not hold the loop, and they are walked.
#[test]
fn the_mesh_of_a_square_scene_does_not_enter_its_map() {
    let on = |points| {
        let mut scene = flat_ground(Shape::Morse(Morse), 1.46, Points::Square(points));
        scene.law.surface_energy = 0.1452633258432881;
        scene.drive.step = 0.1;
        let vary = "cell.length=80.4459..184.8818".parse::<Vary>().unwrap();
        let map = PatternMap::of(&scene, &vary, 17, &Cancel::default(), &mut |_, _| {});
        let rows = map.unwrap().rows.into_iter();
        rows.map(|row| row.found.unwrap()).collect::<Vec<_>>()
    };
    // The first is too coarse for an atlas.
    assert_eq!(on(16), on(32));
}

#[test]
fn a_map_over_the_spring_has_the_loops_of_the_walk() {
    let scene = preset("soft-machine");
    let vary = "drive.stiffness=0.02..0.2".parse::<Vary>().unwrap();
    let map = PatternMap::of(&scene, &vary, 2, &Cancel::default(), &mut |_, _| {}).unwrap();
    let [soft, stiff] = [0, 1].map(|i| map.rows[i].found.as_ref().unwrap());
    assert!(soft.jumps.len() < stiff.jumps.len());
    assert!(soft.dissipated_energy > stiff.dissipated_energy);
    let model = scene.model().unwrap();
    let control = tackscope::physics::control::Control::Spring { stiffness: 0.2 };
    let alone = walked(
        &tackscope::scene::edit::with_control(&scene, &model, control),
        Part::Quarter,
    );
    // The map is on the mesh of the hand.
    let off = stiff.dissipated_energy / alone.record.released_energy_sum() - 1.0;
    assert!(off.abs() < 1e-5, "{off}");
}

#[test]
fn a_key_that_the_scene_has_not_is_refused_with_those_it_has_and_values_that_are_none_are_said() {
    let vary = "law.rage=1..2".parse::<Vary>().unwrap();
    let cancel = Cancel::default();
    let refused = PatternMap::of(&preset("fig2"), &vary, 3, &cancel, &mut |_, _| {}).unwrap_err();
    assert!(refused.to_string().contains("law.range"), "{refused}");
    let map = map("law.range", -1.0, 1.0, 3);
    let missing: Vec<_> = map.missing().collect();
    assert_eq!(missing.len(), 2, "{missing:?}");
    assert!(missing[0].1.contains("law.range"), "{missing:?}");
    for wrong in [
        "law.range",
        "law.range=1",
        "law.range=1..1",
        "law.range=a..2",
        "=1..2..3",
    ] {
        assert!(wrong.parse::<Vary>().is_err(), "{wrong}");
    }
}

#[test]
fn a_request_to_stop_leaves_the_rows_that_were_found() {
    let (cancel, mut seen) = (Cancel::default(), 0);
    let vary = "law.range=0.9..1.1".parse::<Vary>().unwrap();
    let map = PatternMap::of(&preset("fig2"), &vary, 50, &cancel, &mut |_, _| {
        seen += 1;
        if seen == 3 {
            cancel.request();
        }
    });
    let map = map.unwrap();
    assert!(map.cancelled && map.rows.len() == 3);
}

fn measured(scene: &Scene, turn: f64) -> TimeStepMap {
    let mut survey = Survey::new(scene, turn).unwrap();
    loop {
        match survey.step(&Cancel::default()) {
            Progress::Working => {}
            Progress::Done => return survey.map().clone(),
            other => panic!("{other:?}"),
        }
    }
}

/// The largest stable time step of each column; `None` if all are stable or none is.
fn limits(map: &TimeStepMap) -> Vec<Option<f64>> {
    let rows = map.time_steps.len();
    (0..map.columns)
        .map(|column| {
            let first = (0..rows).find(|row| map.at(column, *row) == Some(false))?;
            assert!(
                (first..rows).all(|row| map.at(column, row) == Some(false)),
                "stable again above the limit in column {column}"
            );
            first.checked_sub(1).map(|row| map.time_steps[row])
        })
        .collect()
}

#[test]
fn the_measured_limit_agrees_with_the_bound_within_one_cell_and_never_lies_below_it() {
    let scene = preset_on("fig2", Points::Square(32));
    let map = measured(&scene, 0.2);
    assert_eq!(map.displacements.len(), map.columns);
    let model = scene.model().unwrap();
    let (lower, _) = flat_limits(&model.law, model.grid.length).unwrap();
    let (mut tight, mut compressed) = (0, 0);
    let ratio = map.time_steps[1] / map.time_steps[0];
    for (column, limit) in limits(&map).into_iter().enumerate() {
        let (u0, bound, limit) = (
            map.displacements[column],
            map.bounds[column],
            limit.unwrap(),
        );
        println!("u0 {u0:.3}: measured {limit:.3}, bound {bound:.3}");
        assert!(
            limit * ratio >= bound,
            "unstable below the bound at {u0}: {limit} {bound}"
        );
        tight += usize::from(limit <= bound * ratio);
        if u0 < lower {
            compressed += 1;
            assert!(limit <= bound * ratio, "at {u0}: {limit} {bound}");
        }
    }
    println!(
        "within one cell in {tight} of {} columns, of which {compressed} are compressed and flat",
        map.columns
    );
    assert!(compressed >= 2 && tight >= map.columns / 2);
}

#[test]
fn a_survey_is_interrupted_within_a_piece_of_work_and_goes_on() {
    let mut survey = Survey::new(&preset_on("fig2", Points::Line(32)), 0.2).unwrap();
    let cancel = Cancel::default();
    while survey.map().stable.len() < 5 {
        assert_eq!(survey.step(&cancel), Progress::Working);
    }
    cancel.request();
    assert!((0..3).any(|_| survey.step(&cancel) == Progress::Cancelled));
    cancel.clear();
    assert_eq!(survey.step(&cancel), Progress::Working);
    assert!(survey.map().fraction() < 0.1);
}
