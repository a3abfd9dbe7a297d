//! The forecast of the next jump against exact theory, and against the jumps the walk finds later.

use crate::loops::{preset_on, walked};
use tackscope::follow::record::{Direction, LoopRecord, StateRecord};
use tackscope::follow::run::LoopRun;
use tackscope::follow::walk::Walk;
use tackscope::numerics::threads::Cancel;
use tackscope::physics::pattern::Pattern;
use tackscope::physics::theory::{flat_limits, flat_stiffness};
use tackscope::scene::{Model, Part, Points, Scene};
use tackscope::solver::methods::MethodKind;
use tackscope::study::forecast::{Forecast, forecast};

fn fig2(points: usize) -> Scene {
    preset_on("fig2", Points::Square(points))
}

/// The limit of the flat state on a way, by Eq. 8.
fn limit(model: &Model, branch: Direction) -> f64 {
    let (lower, upper) = flat_limits(&model.law, model.grid.length).unwrap();
    match branch {
        Direction::Approach => upper,
        Direction::Retraction => lower,
    }
}

fn contains(forecast: &Forecast, u0: f64) -> bool {
    let Forecast { nearest, farthest } = *forecast;
    let (low, high) = (nearest.min(farthest), nearest.max(farthest));
    // The walk bisects the flat state's limit to 1e-9 ranges.
    (low - 1e-6..=high + 1e-6).contains(&u0)
}

/// The record as it stood after each state, with the jump that followed.
fn before_each_jump(run: &LoopRun) -> Vec<(Vec<LoopRecord>, f64)> {
    let record = &run.record;
    let mut begin = 0;
    let mut all = Vec::new();
    for (k, jump) in record.jumps.iter().enumerate() {
        let lands = |s: &StateRecord| {
            s.direction == jump.direction && s.mean_displacement == jump.mean_displacement
        };
        let end = begin + record.states[begin..].iter().rposition(lands).unwrap();
        let stood = |last: usize| LoopRecord {
            control: record.control,
            states: record.states[..=last].to_vec(),
            jumps: record.jumps[..k].to_vec(),
        };
        let branch: Vec<_> = (begin..end)
            .filter(|i| record.states[*i].direction == jump.direction)
            .map(stood)
            .collect();
        all.push((branch, jump.mean_displacement));
        begin = end;
    }
    all
}

/// (forecasts made within 0.15 ranges of a jump that the eigenvalue announces, those that contain
/// it, states without a forecast).
fn score(points: usize) -> (usize, usize, usize) {
    let scene = fig2(points);
    let (run, model) = (walked(&scene, Part::Whole), scene.model().unwrap());
    let (mut made, mut right, mut none) = (0, 0, 0);
    for (stood, jump) in before_each_jump(&run) {
        // Where a coarse mesh pins the pattern, its jump is not announced by the eigenvalue that is
        // recorded.
        let last = stood
            .last()
            .and_then(|record| record.states.last())
            .unwrap();
        if last.stiffness_min > 0.2 {
            continue;
        }
        for record in stood {
            let u0 = record.states.last().unwrap().mean_displacement;
            if (u0 - jump).abs() > 0.15 * model.law.range {
                continue;
            }
            match forecast(&record, &model) {
                Some(forecast) => {
                    made += 1;
                    right += usize::from(contains(&forecast, jump));
                    if !contains(&forecast, jump) {
                        println!("{points} points: from {u0:.4} {forecast:?}, found {jump:.4}");
                    }
                }
                None => none += 1,
            }
        }
    }
    println!(
        "{points} points: {right} of {made} forecasts contain the jump found later, {none} states without a forecast"
    );
    (made, right, none)
}

#[test]
fn on_the_mesh_of_fig_2_every_forecast_contains_the_jump_that_is_found_later() {
    let (made, right, none) = score(64);
    assert!(made >= 40 && none < made, "{made} {none}");
    assert_eq!(right, made);
}

#[test]
fn on_a_coarse_mesh_that_pins_the_ridge_all_but_a_few_forecasts_contain_the_jump() {
    let (made, right, none) = score(32);
    assert!(made >= 50 && none < made, "{made} {none}");
    // A ridge that the mesh pins gives way a little sooner or later, by where it stands.
    assert!(50 * (made - right) <= 3 * made, "{right} of {made}");
}

/// A record of flat states on the way to `u0`, as the walk would leave it.
fn flat_states(direction: Direction, path: &[f64], pattern: Pattern) -> (LoopRecord, Model) {
    let scene = fig2(16);
    let model = scene.model().unwrap();
    let first = Walk::start(&scene, MethodKind::NewtonKrylov.into(), &Cancel::default())
        .unwrap()
        .record()
        .clone();
    let states = path
        .iter()
        .map(|&mean_displacement| StateRecord {
            direction,
            control: mean_displacement,
            mean_displacement,
            pattern,
            stiffness_min: flat_stiffness(&model.law, model.grid.length, mean_displacement),
            ..first.clone()
        })
        .collect();
    (
        LoopRecord {
            control: Default::default(),
            states,
            jumps: Vec::new(),
        },
        model,
    )
}

#[test]
fn the_limit_of_the_flat_state_is_foreseen_exactly_from_both_sides() {
    for (branch, path) in [
        (Direction::Approach, [3.4, 3.38, 3.36]),
        (Direction::Retraction, [0.5, 0.52, 0.54]),
    ] {
        let (record, model) = flat_states(branch, &path, Pattern::Flat);
        let limit = limit(&model, branch);
        assert_eq!(
            forecast(&record, &model),
            Some(Forecast {
                nearest: limit,
                farthest: limit
            })
        );
        // Eq. 8.
        let root = (1.0 - 4.0 * std::f64::consts::PI / (0.15f64 * 256.0)).sqrt();
        let sign = if branch == Direction::Approach {
            -1.0
        } else {
            1.0
        };
        assert!(
            (limit + ((1.0 + sign * root) / 4.0).ln()).abs() < 1e-9,
            "{limit}"
        );
    }
}

#[test]
fn the_extrapolation_alone_brackets_the_limits_of_eq_8_too() {
    // The same eigenvalues under another name, so that the closed form is not used.
    for (branch, sign) in [(Direction::Approach, 1.0), (Direction::Retraction, -1.0)] {
        for distance in [0.15, 0.1, 0.05, 0.02, 0.005] {
            let (_, model) = flat_states(branch, &[3.0], Pattern::Flat);
            let limit = limit(&model, branch);
            let path = [2.0, 1.0, 0.0].map(|k| limit + sign * (distance + 0.02 * k));
            let (record, model) = flat_states(branch, &path, Pattern::Bulge);
            let forecast = forecast(&record, &model).unwrap();
            assert!(
                contains(&forecast, limit),
                "{limit} {forecast:?} from {distance}"
            );
            assert!(
                (forecast.farthest - forecast.nearest).abs() < 1.2 * distance + 1e-3,
                "{forecast:?} from {distance}"
            );
        }
    }
}

#[test]
fn no_limit_is_foreseen_on_the_way_out_of_the_attraction() {
    let (record, model) = flat_states(Direction::Retraction, &[3.4, 3.42, 3.44], Pattern::Flat);
    assert_eq!(forecast(&record, &model), None);
}
