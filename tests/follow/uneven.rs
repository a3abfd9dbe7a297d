//! Loops on wavy and rough ground: they close, their ledger closes, nothing gains energy, and parts
//! of the cell agree with the whole.

use crate::loops::{
    accounts, assert_same_jumps, assert_stable, on, preset, preset_on, reach, start, walked,
};
use std::sync::OnceLock;
use tackscope::follow::record::{Direction, StateRecord};
use tackscope::follow::run::{LoopRun, Outcome, run_loop};
use tackscope::follow::walk::Walk;
use tackscope::numerics::threads::Cancel;
use tackscope::paper::measured_law::MeasuredLaw;
use tackscope::physics::indenter::{Indenter, Measured, Wave};
use tackscope::physics::topography::{Periodic, Topography, Unit};
use tackscope::scene::{Part, Points, Range, Scene, Strategy, Turn};
use tackscope::solver::Stop;
use tackscope::study::plan::plan;

/// The loops of the presets on uneven ground, computed once for all tests.
fn loops() -> &'static [(Scene, LoopRun); 2] {
    static RUNS: OnceLock<[(Scene, LoopRun); 2]> = OnceLock::new();
    RUNS.get_or_init(|| {
        ["wavy", "rough"].map(|name| {
            let scene = preset(name);
            let run = walked(&scene, Part::Whole);
            (scene, run)
        })
    })
}

/// No jump of a loop gains energy.
fn none_gains(run: &LoopRun) {
    let jumps = &run.record.jumps;
    assert!(jumps.iter().all(|j| j.released_energy >= 0.0), "{jumps:?}");
}

#[test]
fn every_state_is_a_stable_equilibrium_and_no_jump_gains_energy() {
    for (scene, run) in loops() {
        assert_stable(run, 1e-6);
        assert!(run.record.jumps.len() >= 10, "{}", scene.title);
        none_gains(run);
    }
}

#[test]
fn the_ledger_closes_to_a_thousandth_of_the_surface_energy() {
    // Events that release less than the audit of a step can see pass unrecorded: each some 1e-5
    // gamma.
    for (scene, run) in loops() {
        let (work, released) = accounts(scene, run);
        assert!(
            (work - released).abs() < 1e-3,
            "{}: {work} {released}",
            scene.title
        );
        assert!(released > 4e-3 && work > 0.0, "{}: {released}", scene.title);
    }
}

#[test]
fn the_surface_closes_its_loop_where_it_began() {
    for (scene, run) in loops() {
        let (first, last) = (
            run.record.states.first().unwrap(),
            run.record.states.last().unwrap(),
        );
        assert_eq!(first.mean_displacement, last.mean_displacement);
        assert!(
            (first.energy - last.energy).abs() < 1e-9 && (first.stress - last.stress).abs() < 1e-7,
            "{}",
            scene.title
        );
    }
}

#[test]
fn stress_is_the_derivative_of_the_energy() {
    for name in ["wavy", "rough"] {
        let mut scene = preset(name);
        scene.drive.step = 0.05;
        let sigma = scene.model().unwrap().law.traction_max();
        let mut walk = start(&scene, Part::Whole);
        let mut checked = 0;
        for i in 0..12 {
            let (u0, short) = (1.2 - 0.2 * f64::from(i), 2e-3);
            let [(before, _), (here, one), (after, other)] = [u0 + short, u0, u0 - short]
                .map(|u0| (reach(&mut walk, u0), walk.record().clone()))
                .map(|(jumps, record)| (record, !jumps.is_empty()));
            if one || other {
                continue;
            }
            let [a, b, c] = [&before, &here, &after].map(|s| s.stress);
            let difference = (before.energy - after.energy) / (2.0 * short);
            // Simpson's rule, whose error is far below its own correction of the middle value, and
            // the tolerance of the states.
            let (simpson, correction) = ((a + 4.0 * b + c) / 6.0, (a - 2.0 * b + c).abs() / 6.0);
            assert!(
                (difference - simpson).abs() < 0.1 * correction + 1e-6 * sigma,
                "{name} at {u0}: {difference} {simpson}"
            );
            checked += 1;
        }
        assert!(checked >= 10, "{name}: {checked}");
    }
}

#[test]
fn retraction_holds_at_least_as_strongly_as_approach_on_the_whole() {
    let (scene, run) = &loops()[1];
    let Indenter::Rough(rough) = scene.indenter else {
        panic!("not rough")
    };
    let law = MeasuredLaw::of(
        &run.record,
        rough.mean_height(&scene.model().unwrap().grid),
        100,
    );
    let lost: f64 = law
        .rows
        .iter()
        .map(|row| row.retraction - row.approach)
        .sum();
    assert!(lost > 0.0, "{lost}");
    // Rough ground holds far less than the law it is made of, and well outside the law's own range.
    let (gap, most) = law.strongest();
    let sigma = scene.model().unwrap().law.traction_max();
    assert!(
        most < 0.3 * sigma && gap > 2.0 * 0.23,
        "{gap} {most} {sigma}"
    );
    assert_eq!(
        law.window(most).last().map(|point| point[1] > -most),
        Some(true)
    );
}

#[test]
fn in_deep_compression_nothing_jumps() {
    let mut scene = preset("rough");
    // Gaps below -3: tractions a million times the largest tension.
    scene.drive.turn = Turn::At(-4.5);
    scene.drive.step = 0.03;
    let run = walked(&scene, Part::Whole);
    none_gains(&run);
    assert!(run.record.jumps.iter().all(|j| j.mean_displacement > -2.9));
    // Going down and coming up it is the same surface: its softest mode too, which the tracking
    // must not lose.
    let at = |direction: Direction| {
        let near =
            |s: &&StateRecord| s.direction == direction && (s.mean_displacement + 3.0).abs() < 1e-9;
        run.record.states.iter().find(near).cloned().unwrap()
    };
    let (down, up) = (at(Direction::Approach), at(Direction::Retraction));
    assert!((down.stress - up.stress).abs() < 1e-6 && (down.energy - up.energy).abs() < 1e-9);
    let allowed =
        0.3 * down.stiffness_min + down.stiffness_error.min(1.0) + up.stiffness_error.min(1.0);
    assert!(
        (down.stiffness_min - up.stiffness_min).abs() < allowed,
        "{} {}",
        down.stiffness_min,
        up.stiffness_min
    );
}

#[test]
fn rough_ground_and_several_crests_are_left_to_the_whole_cell_and_one_to_its_quarter() {
    let mut crest = preset("wavy");
    crest.indenter = Indenter::Wave(Wave {
        amplitude: 0.5,
        periods: [1, 1],
    });
    let planned = plan(&crest, &crest.model().unwrap(), None);
    assert_eq!(planned.strategy, Strategy::QUARTER);
    for name in ["wavy", "rough"] {
        let scene = preset(name);
        assert_eq!(
            plan(&scene, &scene.model().unwrap(), None).strategy,
            Strategy::WHOLE,
            "{name}"
        );
    }
    let scene = preset("rough");
    let asked = plan(&scene, &scene.model().unwrap(), Some(Strategy::QUARTER));
    assert_eq!(asked.strategy, Strategy::WHOLE);
    assert!(
        asked.words().contains("no mirror symmetry"),
        "{}",
        asked.words()
    );
    let refused = Walk::start(&scene, on(Part::Quarter), &Cancel::default());
    let refused = refused.err().unwrap().to_string();
    assert!(
        refused.contains("indenter.kind") && refused.contains("needs the whole"),
        "{refused}"
    );
}

#[test]
fn waves_along_x_alone_let_patterns_slide_along_y() {
    let mut scene = preset_on("wavy", Points::Square(48));
    scene.indenter = Indenter::Wave(Wave {
        amplitude: 0.25,
        periods: [1, 0],
    });
    scene.drive.step = 0.05;
    let run = walked(&scene, Part::Whole);
    assert_stable(&run, 1e-6);
    // A translation along y costs nothing: were it not left out, it would be taken for an
    // instability wherever a neck has formed.
    assert!(run.record.jumps.len() < 12, "{:?}", run.record.jumps);
    none_gains(&run);
}

#[test]
fn over_a_measured_grating_patterns_slide_as_over_the_waves_it_was_measured_from() {
    let mut scene = preset_on("wavy", Points::Square(32));
    scene.law.range = Range::Length(0.3);
    scene.drive.step = 0.05;
    for periods in [[1, 0], [0, 1]] {
        scene.indenter = Indenter::Wave(Wave {
            amplitude: 0.05,
            periods,
        });
        let model = scene.model().unwrap();
        let map = Topography {
            file: "grating".into(),
            format: "test",
            heights: model.indenter.height(&model.grid).unwrap(),
            size: Some([scene.cell.length; 2]),
            unit: Unit::Scene,
        };
        let measured = Indenter::Measured(Measured::new(map).continued(Periodic::AsIs));
        assert_eq!(measured.ground().is_uniform(), periods.map(|p| p == 0));
        let waves = walked(&scene, Part::Whole);
        let other = Scene {
            indenter: measured,
            ..scene.clone()
        };
        // A pattern breaks the waves up, and slides along them.
        assert!(waves.record.jumps.len() >= 4, "{:?}", waves.record.jumps);
        let grating = walked(&other, Part::Whole);
        assert_same_jumps(&waves.record.jumps, &grating.record.jumps, 1e-4);
    }
}

#[test]
fn line_cells_walk_on_waves_and_on_rough_profiles() {
    for name in ["wavy", "rough"] {
        let mut scene = preset_on(name, Points::Line(128));
        if let Indenter::Wave(Wave { periods, .. }) = &mut scene.indenter {
            *periods = [2, 0];
        }
        scene.drive.turn = Turn::At(-0.8);
        let run = walked(&scene, Part::Whole);
        let (work, released) = accounts(&scene, &run);
        assert!(
            (work - released).abs() < 1e-3 + 5e-3 * released,
            "{name}: {work} {released}"
        );
        none_gains(&run);
    }
}

#[test]
fn a_mesh_too_coarse_for_the_roughness_says_so_and_auto_chooses_one_that_is_not() {
    let mut scene = preset_on("rough", Points::Square(16));
    assert!(
        scene
            .model()
            .unwrap()
            .warning()
            .unwrap()
            .contains("waves of length 2")
    );
    (scene.cell.points, scene.law.range) = (Points::Auto, Range::Length(2.0));
    let model = scene.model().unwrap();
    assert!(
        model.grid.nx >= 32 && model.warning().is_none(),
        "{model:?}"
    );
}

#[test]
fn the_search_for_the_first_state_obeys_a_stop() {
    let cancel = Cancel::default();
    cancel.request();
    let run = run_loop(&preset("rough"), on(Part::Whole), &cancel, &mut |_| {}).unwrap();
    assert_eq!(
        (run.outcome, run.record.states[0].stop),
        (Outcome::Cancelled, Stop::Cancelled)
    );
}
