//! The measured stability of GFMD against the bound, on the approach of Fig. 2.

use crate::loops::preset;
use tackscope::numerics::cancel::Cancel;
use tackscope::physics::theory::flat;
use tackscope::scene::{Points, Scene};
use tackscope::study::time_step_map::{Progress, Survey, TimeStepMap};

fn fig2(points: Points) -> Scene {
    let mut scene = preset("fig2");
    scene.cell.points = points;
    scene
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
    let scene = fig2(Points::Square(32));
    let map = measured(&scene, 0.2);
    assert_eq!(map.displacements.len(), map.columns);
    let model = scene.model().unwrap();
    let (lower, _) = flat::limits(&model.law, model.grid.length).unwrap();
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
    let mut survey = Survey::new(&fig2(Points::Line(32)), 0.2).unwrap();
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
