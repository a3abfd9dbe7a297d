//! The live loop against the walk: the same curve, the same jumps, and the right answer before the
//! walk has got there.

use crate::loops::{assert_same_jumps, preset, preset_on, walked};
use std::sync::Arc;
use std::time::{Duration, Instant};
use tackscope::follow::record::{Direction, JumpRecord, StateRecord};
use tackscope::follow::run::LoopRun;
use tackscope::follow::walk::{Progress, Walk};
use tackscope::numerics::threads::Cancel;
use tackscope::physics::control::Control;
use tackscope::scene::{Part, Points, Range, Scene, Turn};
use tackscope::solver::Stop;
use tackscope::solver::methods::MethodKind;
use tackscope::study::live_loop::{Fineness, LiveLoop, LiveLoops, Spot};
use tackscope::worker;
use tackscope::worker::background::Wanted;
use tackscope::worker::job::Job;
use tackscope::worker::protocol::{LiveState, Stored};

fn fig2() -> Scene {
    preset("fig2")
}

fn live(scene: &Scene, fineness: Fineness) -> LiveLoop {
    LiveLoops::default()
        .next(scene, &scene.model().unwrap(), fineness)
        .unwrap()
}

/// The live loop has the jumps, the loss and the stress of the walked one, to these shares; every
/// walked state lies on the drawn curve, away from the very ends of the branches.
fn is_as_walked(scene: &Scene, run: &LoopRun, fineness: Fineness, within: [f64; 3]) -> LiveLoop {
    let began = Instant::now();
    let live = live(scene, fineness);
    let (loss, found) = (run.record.released_energy_sum(), live.dissipated_energy);
    let (points, took) = (live.points, began.elapsed());
    println!("{fineness:?}: {points} points, {took:?}, {found} against {loss}");
    let off = (found / loss - 1.0).abs();
    assert!(off < within[0], "{fineness:?}: {off:e}");
    assert_same_jumps(&live.jumps, &run.record.jumps, within[1]);
    for state in &run.record.states {
        let near = |jump: &JumpRecord| (state.control - jump.control).abs() < 0.02;
        if run.record.jumps.iter().any(near) {
            continue;
        }
        let leg = live.legs.iter().find(|leg| {
            let ends = leg.from.min(leg.to) - 1e-9..=leg.from.max(leg.to) + 1e-9;
            leg.direction == state.direction && ends.contains(&state.control)
        });
        let leg = leg.unwrap_or_else(|| panic!("{state:?} in {:?}", live.legs));
        let at = live.segments[leg.segment].at(state.control);
        let off = (at.stress - state.stress).abs() / live.law.traction_max();
        assert!(off < within[2], "{fineness:?}: {off} at {state:?}");
    }
    live
}

#[test]
fn the_live_loop_has_the_jumps_the_energy_and_the_stress_of_the_walked_loop() {
    let scene = fig2();
    let run = walked(&scene, Part::Whole);
    let work = run.record.work() / scene.law.surface_energy;
    for (fineness, tolerance) in [(Fineness::Coarse, 0.01), (Fineness::Fine, 2e-3)] {
        let live = is_as_walked(&scene, &run, fineness, [tolerance, 0.02, 5e-3]);
        assert!((live.dissipated_energy / work - 1.0).abs() < tolerance);
    }
}

/// The patterns in which the walk stands at the `targets`, each as the live loop has foretold it.
fn foretold(scene: &Scene, targets: &[f64], within: f64) -> Vec<&'static str> {
    let live = live(scene, Fineness::Fine);
    let mut walk = Walk::start(scene, MethodKind::NewtonKrylov.into(), &Cancel::default()).unwrap();
    let stands = |target: &f64| {
        let reading = live.reading(walk.record(), *target);
        let (pattern, sample) = reading.expect("the walk stands on a known branch");
        walk.set_target(*target);
        while walk.step(&Cancel::default(), &mut |_| {}) == Progress::Working {}
        let there = walk.record();
        assert_eq!((there.control, there.pattern), (*target, pattern));
        let off = (sample.stress - there.stress).abs() / live.law.traction_max();
        assert!(off < within, "{off} at {target}");
        assert!(sample.stiffness_min > 0.0);
        pattern.word()
    };
    targets.iter().map(stands).collect()
}

#[test]
fn the_reading_says_where_the_walk_will_stand_also_after_turning_round_in_the_middle() {
    let targets = [3.0, 2.0, 3.3, 2.0, 1.0, 0.3, 1.5, 3.0, 3.9, 4.2];
    assert_eq!(
        foretold(&fig2(), &targets, 5e-3),
        [
            "bulge", "ridge", "ridge", "ridge", "dimple", "flat", "dimple", "ridge", "bulge",
            "flat"
        ]
    );
}

#[test]
fn a_leg_is_drawn_in_the_direction_it_is_gone() {
    let live = live(&fig2(), Fineness::Coarse);
    for leg in &live.legs {
        let points = live.points_of(leg);
        let ordered = points.windows(2).all(|w| {
            if leg.direction == Direction::Approach {
                w[1][0] <= w[0][0]
            } else {
                w[1][0] >= w[0][0]
            }
        });
        assert!(ordered && points.len() > 3, "{leg:?}");
        assert!(
            (points[0][0] - leg.from).abs() < 1e-12
                && (points[points.len() - 1][0] - leg.to).abs() < 1e-12
        );
    }
}

#[test]
fn what_the_atlas_does_not_hold_is_refused_in_words() {
    let scene = preset_on("fig2", Points::Line(64));
    let words = LiveLoops::default()
        .next(&scene, &scene.model().unwrap(), Fineness::Coarse)
        .unwrap_err()
        .to_string();
    assert!(words.contains("the atlas holds square cells"), "{words}");
}

#[test]
fn a_loop_taken_over_from_a_law_a_little_different_is_the_loop_made_afresh() {
    let mut loops = LiveLoops::default();
    let mut took = [Duration::ZERO; 2];
    for i in 0..=12 {
        let mut scene = fig2();
        scene.law.range = Range::Length(if i < 12 {
            1.0 + 0.002 * f64::from(i)
        } else {
            1.1
        });
        let model = scene.model().unwrap();
        let mut both = [&mut loops, &mut LiveLoops::default()];
        let [quick, slow] = [0, 1].map(|k| {
            let began = Instant::now();
            let live = both[k].next(&scene, &model, Fineness::Coarse).unwrap();
            took[k] += if i > 0 {
                began.elapsed()
            } else {
                Duration::ZERO
            };
            live
        });
        let off = (quick.dissipated_energy / slow.dissipated_energy - 1.0).abs();
        assert!(off < 2e-3, "{off} at {i}");
        assert_same_jumps(&quick.jumps, &slow.jumps, 5e-3);
    }
    let [taken_over, afresh] = took.map(|time| time / 12);
    println!("a loop taken over: {taken_over:?}, afresh: {afresh:?}");
}

/// The scene of Fig. 2 under a spring on which the bulge is skipped.
fn sprung() -> Scene {
    let mut scene = preset("soft-machine");
    scene.drive.step = 0.1;
    scene
}

#[test]
fn the_live_loop_under_a_spring_is_that_of_the_walk_on_the_scenes_own_mesh() {
    let scene = sprung();
    let run = walked(&scene, Part::Quarter);
    for (fineness, tolerance) in [(Fineness::Coarse, 3e-4), (Fineness::Fine, 1e-4)] {
        let live = is_as_walked(&scene, &run, fineness, [tolerance, tolerance, 1e-2]);
        // Flat far away and pressed, ridge, and dimple on both ways.
        assert!((4..=6).contains(&live.segments.len()), "{:?}", live.legs);
    }
}

#[test]
fn the_reading_under_a_spring_says_where_the_walk_will_stand() {
    let targets = [4.0, 3.4, 3.0, 2.75, 1.0, 3.3, 4.0, 5.0];
    assert_eq!(
        foretold(&sprung(), &targets, 1e-2),
        [
            "flat", "ridge", "ridge", "dimple", "flat", "dimple", "ridge", "flat"
        ]
    );
}

#[test]
fn under_a_load_the_live_loop_is_flat_both_ways() {
    let mut scene = fig2();
    scene.drive.control = Control::Load;
    (scene.drive.start, scene.drive.turn, scene.drive.step) = (0.1, Turn::At(-0.02), 0.001);
    let live = live(&scene, Fineness::Coarse);
    let [touch, pull_off] = &live.jumps[..] else {
        panic!("{:?}", live.jumps)
    };
    let largest = live.law.traction_max();
    assert!(touch.control.abs() < 2e-5 * largest, "{touch:?}");
    assert!(
        (pull_off.control / largest - 1.0).abs() < 1e-6,
        "{pull_off:?}"
    );
}

/// The state that a live loop foresees at a place, or why there is none.
fn foreseen(scene: &Scene, live: &LiveLoop, part: Part, spot: Spot) -> Result<Arc<Stored>, String> {
    let state = LiveState {
        found: Ok(live.clone()),
        fineness: Fineness::Fine,
        milliseconds: 0.0,
    };
    let wanted = Wanted {
        scene: Arc::new(scene.clone()),
        part,
        live: Arc::new(state),
        spot,
    };
    let (mut job, report) = Job::new(Arc::new(|| {}));
    let found = worker::background::foreseen(&wanted, &report);
    job.poll();
    found.map(|()| job.so_far.take().expect("a state"))
}

/// Every tenth walked state away from the jumps is foreseen where the walk met it.
fn is_met(scene: &Scene, part: Part) {
    let run = walked(scene, part);
    let (live, law) = (live(scene, Fineness::Fine), scene.model().unwrap().law);
    let mut compared = 0;
    for state in run.record.states.iter().step_by(10) {
        let near = |jump: &JumpRecord| (jump.control - state.control).abs() < 0.02;
        if run.record.jumps.iter().any(near) {
            continue;
        }
        let spot = live.spot(state.direction, state.control).expect("a place");
        let found = foreseen(scene, &live, part, spot).expect("a state");
        let StateRecord {
            stop,
            pattern,
            direction,
            control,
            residual,
            stiffness_min,
            ..
        } = found.record;
        assert_eq!(
            (stop, pattern, direction, control),
            (Stop::Stable, state.pattern, state.direction, state.control)
        );
        assert!(residual <= 1e-6 && stiffness_min > 0.0, "{state:?}");
        let stress = (found.record.stress - state.stress).abs() / law.traction_max();
        // Under a spring they differ in u0 by what the residual leaves open, and so by work.
        let work = state.stress * (found.record.mean_displacement - state.mean_displacement);
        let energy = (found.record.energy - state.energy - work).abs() / law.surface_energy;
        // Residuals of a millionth, over a stiffness that vanishes at the ends of the branches.
        assert!(
            stress < 1e-4 && energy < 1e-8,
            "{stress} {energy} at {state:?}"
        );
        compared += 1;
    }
    assert!(compared >= 20, "{compared}");
}

#[test]
fn a_foreseen_state_is_the_one_that_the_walk_meets_there() {
    let scene = preset_on("fig2", Points::Square(48));
    // Between mesh points, as on the quarter, or on them, as here: each has an energy of its own.
    for part in [Part::Quarter, Part::Whole] {
        is_met(&scene, part);
    }
}

#[test]
fn a_foreseen_state_under_a_spring_is_the_one_that_the_walk_meets_there() {
    let mut scene = preset_on("fig2", Points::Square(48));
    scene.drive.control = Control::Spring { stiffness: 0.2 };
    is_met(&scene, Part::Quarter);
}

#[test]
fn the_place_nearest_to_a_point_of_the_curve_is_that_of_the_point() {
    let live = live(&fig2(), Fineness::Coarse);
    for (leg, piece) in live.legs.iter().enumerate() {
        let samples = live.samples_of(piece);
        let sample = samples[samples.len() / 2];
        let at = [sample.mean_displacement, sample.stress];
        let (off, spot) = live.nearest(at, [0.1, 0.01]).expect("a place");
        assert!(
            off < 1e-9 && (spot.control - sample.control).abs() < 1e-9,
            "{leg}: {spot:?}"
        );
    }
}
