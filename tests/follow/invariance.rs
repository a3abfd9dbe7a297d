//! What a loop must not depend on: the axis, the seed, the step, the part of the cell.

use crate::loops::{driven, flat_ground, preset_on, reach, start, walked};
use ndarray::Array2;
use tackscope::follow::record::{Cause, JumpRecord};
use tackscope::follow::run::LoopRun;
use tackscope::follow::walk::{Observed, Progress, Walk};
use tackscope::numerics::threads::Cancel;
use tackscope::physics::control::Control;
use tackscope::physics::indenter::{Indenter, Wave};
use tackscope::physics::law::{Mie, Shape};
use tackscope::scene::{Part, Points, Range, Scene, Turn};

fn wavy() -> Scene {
    let mut scene = preset_on("wavy", Points::Square(32));
    scene.law.range = Range::Length(0.3);
    scene
}

/// The same jumps at the same places, in ranges, with the same releases.
fn assert_same(one: &LoopRun, other: &LoopRun, within: f64, range: f64, what: &str) {
    let [a, b] = [one, other].map(|run| -> Vec<f64> {
        let jumps = run.record.jumps.iter();
        jumps.map(|j| j.mean_displacement / range).collect()
    });
    assert_eq!(a.len(), b.len(), "{what}: {a:?} {b:?}");
    let near = a.iter().zip(&b).all(|(a, b)| (a - b).abs() < within);
    assert!(near, "{what}, in ranges: {a:?} {b:?}");
    let [a, b] = [one, other].map(|run| run.record.released_energy_sum());
    assert!((a - b).abs() < within * a.abs(), "{what}: {a} {b}");
}

#[test]
fn a_turn_of_the_ground_by_90_degrees_changes_nothing() {
    let mut scene = wavy();
    (scene.drive.turn, scene.drive.step) = (Turn::At(-0.2), 0.03);
    let mut run = |periods, seed| {
        scene.indenter = Indenter::Wave(Wave {
            amplitude: 0.3,
            periods,
        });
        scene.seed = seed;
        walked(&scene, Part::Whole)
    };
    let along_x = run([3, 0], 1);
    assert!(!along_x.record.jumps.is_empty());
    for seed in 1..4 {
        let turned = run([0, 3], seed);
        assert_same(&along_x, &turned, 1e-3, 0.3, &format!("seed {seed}"));
    }
}

#[test]
fn jumps_on_waves_do_not_depend_on_seed_or_step() {
    let scene = wavy();
    let first = walked(&scene, Part::Whole);
    assert!(first.record.jumps.len() >= 8);
    for (seed, step) in [2, 3]
        .map(|seed| (seed, scene.drive.step))
        .into_iter()
        .chain([0.011, 0.05].map(|step| (scene.seed, step)))
    {
        let mut other = scene.clone();
        (other.seed, other.drive.step) = (seed, step);
        let what = format!("seed {seed}, step {step}");
        assert_same(&first, &walked(&other, Part::Whole), 1e-3, 0.3, &what);
    }
}

#[test]
fn gentle_ground_jumps_where_flat_ground_does() {
    let gentle = |amplitude| {
        let mut scene = preset_on("fig2", Points::Square(48));
        scene.drive.step = 0.05;
        (scene.drive.start, scene.drive.turn) = (3.3, Turn::At(2.75));
        scene.indenter = if amplitude == 0.0 {
            Indenter::Flat
        } else {
            Indenter::Wave(Wave {
                amplitude,
                periods: [1, 1],
            })
        };
        walked(&scene, Part::Whole)
    };
    let (right, found) = (gentle(0.0), gentle(1e-4));
    assert_eq!(right.record.jumps.len(), 2, "to a bulge and to a ridge");
    // The crest pulls the ends of branches along by the square root of its height at most: a
    // hundredth of a range.
    assert_same(&right, &found, 0.02, 1.0, "amplitude 1e-4");
}

#[test]
fn steps_longer_than_a_pattern_lives_find_every_pattern() {
    let run = |step| {
        let mut scene = preset_on("fig2", Points::Square(48));
        scene.drive.step = step;
        walked(&scene, Part::Whole)
    };
    let short = run(0.05);
    assert_eq!(short.record.jumps.len(), 8);
    for step in [1.0, 4.0] {
        assert_same(&short, &run(step), 1e-3, 1.0, &format!("step {step}"));
    }
}

#[test]
fn a_quarter_of_the_cell_jumps_where_the_whole_does() {
    // One crest, on a mesh point here and between points there: that far apart are the meshes.
    let mut scene = wavy();
    scene.indenter = Indenter::Wave(Wave {
        amplitude: 0.5,
        periods: [1, 1],
    });
    scene.cell.points = Points::Square(48);
    scene.drive.step = 0.05;
    let (whole, quarter) = (walked(&scene, Part::Whole), walked(&scene, Part::Quarter));
    assert!(!whole.record.jumps.is_empty());
    assert_same(&whole, &quarter, 5e-3, 0.3, "48 points");
}

#[test]
fn a_faint_jump_over_faint_waves_is_met_with_any_step() {
    let mut scene = wavy();
    scene.cell.length = 36.0;
    scene.cell.points = Points::Square(36);
    (scene.law.surface_energy, scene.law.range) = (0.032374, Range::Length(0.26196));
    scene.indenter = Indenter::Wave(Wave {
        amplitude: 0.009428,
        periods: [1, 1],
    });
    (scene.drive.start, scene.drive.turn) = (1.4192, Turn::At(-0.05733));
    let run = |step| {
        let mut scene = scene.clone();
        scene.drive.step = step;
        walked(&scene, Part::Quarter)
    };
    let [long, short] = [0.055934, 0.027967].map(run);
    let faint = |jump: &JumpRecord| jump.released_energy < 1e-4;
    assert!(
        long.record.jumps.iter().any(faint),
        "{:?}",
        long.record.jumps
    );
    assert_same(&long, &short, 1e-3, 0.26196, "half the step");
}

/// The next jump on the way from where `walk` stands to `target`.
fn next_jump(mut walk: Walk, target: f64) -> JumpRecord {
    walk.set_target(target);
    let mut found = None;
    while found.is_none() {
        let progress = walk.step(&Cancel::default(), &mut |observed| {
            if let Observed::Jump(jump) = observed {
                found = Some(jump);
            }
        });
        assert!(
            found.is_some() || progress == Progress::Working,
            "{progress:?}"
        );
    }
    found.unwrap()
}

/// A walk that has been to `places` in turn.
fn standing_at(scene: &Scene, places: &[f64]) -> Walk {
    let mut walk = start(scene, Part::Whole);
    for &place in places {
        reach(&mut walk, place);
    }
    walk
}

/// A walk through another scene from where one stands.
fn from(there: &Walk, scene: &Scene) -> Walk {
    start(scene, Part::Whole).standing_on(there.here().clone(), there.record().clone())
}

#[test]
fn steps_of_any_size_find_the_same_end_for_the_same_cause() {
    let mut scene = preset_on("fig2", Points::Square(40));
    scene.drive.step = 0.1;
    let (down, up) = (scene.depth(), scene.drive.start);
    // Bulge, ridge and dimple on the way down, dimple, ridge and bulge on the way up, each some 0.2
    // ranges before its end: two thousand of the smallest steps.
    let broken = |cause| cause == Cause::SymmetryBreaking;
    for (places, target, breaks) in [
        (&[3.09][..], down, true),
        (&[1.53], down, true),
        (&[0.79], down, false),
        (&[down, 2.03], up, true),
        (&[down, 3.64], up, true),
        (&[down, 3.86], up, false),
    ] {
        let there = standing_at(&scene, places);
        let with_step = |step: f64| {
            let mut scene = scene.clone();
            scene.drive.step = step;
            next_jump(from(&there, &scene), target)
        };
        let usual = with_step(0.05);
        assert_eq!(broken(usual.cause), breaks, "{usual:?}");
        for step in [7e-3, 1e-3, 1e-4] {
            let found = with_step(step);
            let off = (found.mean_displacement - usual.mean_displacement).abs();
            assert!(off < 2e-5, "step {step}: {off} ranges from {usual:?}");
            assert_eq!(
                (found.from, found.to, found.cause),
                (usual.from, usual.to, usual.cause),
                "step {step}"
            );
        }
    }
}

#[test]
fn a_thousand_extrapolations_leave_a_real_field_in_its_place() {
    let mut scene = preset_on("fig2", Points::Square(48));
    scene.drive.step = 0.1;
    let there = standing_at(&scene, &[3.09]);
    scene.drive.step = 1e-4;
    let mut walk = from(&there, &scene);
    reach(&mut walk, 2.99);
    let amplitudes = &walk.here().state.amplitudes;
    // There and back through a field: what no field has is lost on the way.
    let (system, mut ws) = (walk.system(), walk.system().workspace());
    let field = system.field(amplitudes, &mut ws).clone();
    let real = system.amplitudes(&field, &mut ws);
    let unreal = real
        .iter()
        .zip(amplitudes)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    assert!(unreal < 1e-13, "{unreal}");
    // Its longest waves along x and y tell where the bulge is: on a point of the mesh or between
    // two.
    for pair in [48, 1] {
        let place =
            amplitudes[2 * pair + 1].atan2(amplitudes[2 * pair]) * 48.0 / std::f64::consts::PI;
        assert!(
            (place - place.round()).abs() < 1e-4,
            "{place} half spacings"
        );
    }
}

#[test]
fn a_surface_shifted_and_mirrored_with_its_ground_jumps_at_the_same_place() {
    // Four crests: the ground comes back after half a cell along x or y, and is its own mirror
    // image; the contact has fewer symmetries.
    let mut scene = wavy();
    scene.indenter = Indenter::Wave(Wave {
        amplitude: 0.4,
        periods: [2, 2],
    });
    let (there, n) = (standing_at(&scene, &[-0.2]), 32);
    let (system, mut ws) = (there.system(), there.system().workspace());
    let field = system
        .field(&there.here().state.amplitudes, &mut ws)
        .clone();
    let broken = (0..n)
        .map(|i| (field[[0, i]] - field[[0, (i + 16) % n]]).abs())
        .fold(0.0, f64::max);
    assert!(broken > 0.1, "{broken}");
    let jumps: Vec<JumpRecord> = [(0, 0, false), (16, 0, false), (0, 0, true), (16, 16, true)]
        .into_iter()
        .map(|(along_x, along_y, mirrored)| {
            let moved = Array2::from_shape_fn((n, n), |(j, i)| {
                let i = if mirrored { n - i } else { i };
                field[[(j + along_y) % n, (i + along_x) % n]]
            });
            let mut state = there.here().clone();
            state.state.amplitudes = system.amplitudes(&moved, &mut ws);
            let walk = start(&scene, Part::Whole).standing_on(state, there.record().clone());
            next_jump(walk, scene.drive.start)
        })
        .collect();
    for jump in &jumps[1..] {
        let off = (jump.mean_displacement - jumps[0].mean_displacement).abs() / 0.3;
        assert!(off < 1e-5, "{off} ranges: {jump:?} for {:?}", jumps[0]);
        assert!(
            (jump.released_energy / jumps[0].released_energy - 1.0).abs() < 1e-4,
            "{jump:?} for {:?}",
            jumps[0]
        );
    }
}

#[test]
fn ends_are_found_within_the_error_that_is_stated_with_any_step() {
    let shape = Shape::Mie(Mie {
        m: 10.275,
        n: 3.686,
    });
    let mut scene = flat_ground(shape, 1.678, Points::Square(24));
    scene.drive.control = Control::Spring { stiffness: 1.6 };
    (scene.drive.start, scene.drive.turn) = (4.5, Turn::At(1.05));
    let runs = [0.05, 0.13, 0.3].map(|step| {
        scene.drive.step = step;
        walked(&scene, Part::Whole).record.jumps
    });
    for jumps in &runs[1..] {
        assert_eq!(jumps.len(), runs[0].len());
        for (a, b) in jumps.iter().zip(&runs[0]) {
            let off = (a.released_energy - b.released_energy).abs();
            assert!(
                off < 0.2 * (a.release_error + b.release_error) + 1e-10,
                "{a:?} {b:?}"
            );
            // A symmetry breaks where its eigenvalue vanishes, which is linear there.
            if a.cause == Cause::SymmetryBreaking {
                assert!((a.control - b.control).abs() < 1e-6, "{a:?} {b:?}");
            }
        }
    }
}

#[test]
fn under_a_load_a_loop_over_waves_takes_the_same_states_in_any_unit_of_length() {
    let states = |unit: f64| {
        let mut scene = preset_on("wavy", Points::Square(16));
        scene.cell.length *= unit;
        scene.law.surface_energy *= unit;
        scene.law.range = Range::Length(0.3 * unit);
        scene.indenter = Indenter::Wave(Wave {
            amplitude: 0.3 * unit,
            periods: [2, 0],
        });
        let largest = scene.model().unwrap().law.traction_max();
        let from = 0.2 * largest;
        let scene = driven(scene, Control::Load, [from, -0.8 * largest, 0.05 * largest]);
        let run = walked(&scene, Part::Whole);
        assert!(!run.record.jumps.is_empty());
        run.record.states.len()
    };
    let counts = [1.0, 1.0 / 1024.0, 1024.0].map(states);
    assert!(counts.iter().all(|count| *count == counts[0]), "{counts:?}");
}
