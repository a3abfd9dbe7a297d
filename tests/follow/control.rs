//! What a soft machine does instead of a stiff one: the same equilibria, other ends.

use crate::loops::{driven, preset_on, reach, sequence, start, walked};
use std::sync::OnceLock;
use tackscope::follow::flat_branch::FlatBranch;
use tackscope::follow::record::{Cause, Direction, JumpRecord, LOCATED, StateRecord};
use tackscope::follow::run::LoopRun;
use tackscope::follow::walk::Progress;
use tackscope::numerics::threads::Cancel;
use tackscope::physics::control::Control;
use tackscope::physics::indenter::{Hertz, Indenter};
use tackscope::physics::law::{Cosine, Law, Shape};
use tackscope::physics::pattern::Pattern::{self, Bulge, Dimple, Flat, Ridge};
use tackscope::physics::theory::jkr::Jkr;
use tackscope::scene::{Cell, Part, Points, Range, Scene};
use tackscope::solver::mechanics::{Mechanics, Slides};
use tackscope::solver::stability::Tracker;

/// The scene of Fig. 2 under a spring.
pub fn sprung(stiffness: f64, drive: [f64; 3]) -> Scene {
    let scene = preset_on("fig2", Points::Square(48));
    driven(scene, Control::Spring { stiffness }, drive)
}

/// Its loop under a spring on which patterns are skipped.
pub fn soft() -> &'static LoopRun {
    static RUN: OnceLock<LoopRun> = OnceLock::new();
    RUN.get_or_init(|| walked(&sprung(0.03, [6.0, -2.0, 0.1]), Part::Quarter))
}

fn find(run: &LoopRun, from: Pattern, direction: Direction) -> &JumpRecord {
    let found = |j: &&JumpRecord| j.from == from && j.direction == direction;
    run.record.jumps.iter().find(found).expect("such a jump")
}

/// How far the loop integral is off the sum of releases, and its stated error, over that.
fn off(run: &LoopRun, law: &Law) -> (f64, f64) {
    let ledger = run.record.ledger(law.surface_energy);
    let sum = ledger.released_energy_sum;
    let off = ledger.loop_integral / sum - 1.0;
    (off.abs(), ledger.integral_error / sum)
}

#[test]
fn a_spring_of_a_million_is_a_driven_displacement_to_1e_6() {
    let drive = [4.2, 0.2, 0.1];
    let stiff = walked(&sprung(1e6, drive), Part::Quarter);
    let scene = driven(sprung(1.0, drive), Control::Displacement, drive);
    let fixed = walked(&scene, Part::Quarter);
    assert_eq!(stiff.record.jumps.len(), fixed.record.jumps.len());
    for (a, b) in stiff.record.jumps.iter().zip(&fixed.record.jumps) {
        assert_eq!((a.from, a.to, a.cause), (b.from, b.to, b.cause));
        assert!((a.control - b.control).abs() < 2e-7, "{a:?} {b:?}");
        assert!(
            (a.released_energy - b.released_energy).abs() < 5e-9,
            "{a:?} {b:?}"
        );
    }
    let mut compared = 0;
    for a in &stiff.record.states {
        let same = |b: &&StateRecord| b.control == a.control && b.direction == a.direction;
        let Some(b) = fixed.record.states.iter().find(same) else {
            continue;
        };
        compared += 1;
        assert!((a.stress - b.stress).abs() < 3e-8, "{a:?} {b:?}");
    }
    assert!(compared > 60, "{compared}");
}

#[test]
fn broken_symmetries_stay_at_their_u0_and_patterns_are_skipped_under_a_soft_spring() {
    let run = soft();
    let [down, up] = Direction::BOTH.map(|way| sequence(run, way));
    assert_eq!(down, [Flat, Ridge, Dimple, Flat]);
    assert_eq!(up, [Flat, Dimple, Ridge, Flat]);
    let drive = [4.2, 0.2, 0.1];
    let fixed = walked(
        &driven(sprung(1.0, drive), Control::Displacement, drive),
        Part::Quarter,
    );
    // The bulge is skipped because no state of it has the stage at which the surface jumps: on the way
    // down all break up before, on the way up all fold before.
    for (from, direction, side) in [
        (Flat, Direction::Approach, 1.0),
        (Ridge, Direction::Retraction, -1.0),
    ] {
        let jump = find(run, from, direction);
        let states = fixed.record.states.iter();
        let bulges = states.filter(|s| s.pattern == Bulge && s.direction == direction);
        let beyond =
            |s: &StateRecord| side * (s.mean_displacement + s.stress / 0.03 - jump.control);
        let all: Vec<f64> = bulges.map(beyond).collect();
        assert!(
            all.len() > 2 && all.iter().all(|w| *w > 0.0),
            "{direction} {all:?}"
        );
    }
    for (from, direction) in [
        (Ridge, Direction::Approach),
        (Dimple, Direction::Retraction),
        (Ridge, Direction::Retraction),
    ] {
        let [here, there] = [run, &fixed].map(|run| find(run, from, direction));
        assert_eq!(here.cause, Cause::SymmetryBreaking);
        assert!(
            (here.mean_displacement - there.mean_displacement).abs() < 3e-7,
            "{here:?} {there:?}"
        );
    }
}

/// By a second method: along the branch at fixed u0 the stage w = u0 + stress/k has its least
/// value.
#[test]
fn a_fold_under_a_spring_is_where_the_stage_turns_back_along_the_branch() {
    let (stiffness, drive) = (0.03, [4.2, 0.2, 0.1]);
    let fold = find(soft(), Dimple, Direction::Approach);
    assert_eq!(fold.cause, Cause::Fold);
    let scene = driven(sprung(1.0, drive), Control::Displacement, drive);
    let mut walk = start(&scene, Part::Quarter);
    let h = 1e-2;
    let stage = [h, 0.0, -h].map(|away| {
        reach(&mut walk, fold.mean_displacement + away);
        let here = walk.record();
        assert_eq!(here.pattern, Dimple);
        here.mean_displacement + here.stress / stiffness
    });
    // The lowest point of the parabola through the three.
    let (slope, bend) = (
        0.5 * (stage[0] - stage[2]),
        stage[0] - 2.0 * stage[1] + stage[2],
    );
    let lowest = stage[1] - 0.5 * slope * slope / bend;
    assert!(bend > 0.0 && slope.abs() < bend, "{slope} {bend}");
    let unit = scene.model().unwrap().law;
    let unit = Control::Spring { stiffness }.unit(&unit);
    assert!(
        (fold.control - lowest).abs() < 1e-5 * unit,
        "{} {lowest}",
        fold.control
    );
}

#[test]
fn a_machine_softer_than_the_longest_wave_snaps_as_one_block_where_gamma_is_as_soft() {
    let stiffness = 0.01;
    let scene = sprung(stiffness, [10.0, -4.0, 0.1]);
    let law = scene.model().unwrap().law;
    assert!(stiffness < std::f64::consts::PI / scene.cell.length);
    let run = walked(&scene, Part::Whole);
    assert!(run.record.states.iter().all(|s| s.pattern == Flat));
    assert_eq!(run.record.jumps.len(), 2);
    for jump in &run.record.jumps {
        let [u0, after] = [jump.mean_displacement, jump.mean_displacement_after];
        assert!(
            (law.at(u0).stiffness / -stiffness - 1.0).abs() < 1e-6,
            "{jump:?}"
        );
        let energy = |u: f64| law.at(u).energy + 0.5 * stiffness * (jump.control - u).powi(2);
        let released = (energy(u0) - energy(after)) / law.surface_energy;
        assert!(
            (jump.released_energy - released).abs() < 1e-6,
            "{jump:?} {released}"
        );
        assert!((law.at(after).traction - stiffness * (jump.control - after)).abs() < 1e-7);
    }
    let (off, _) = off(&run, &law);
    assert!(off < 1e-4, "{off}");
}

#[test]
fn however_long_the_steps_no_energy_is_missing_where_a_block_lets_go() {
    for step in [0.5, 2.0] {
        let mut scene = sprung(0.011, [18.0, -2.0, step]);
        scene.cell.points = Points::Line(96);
        let run = walked(&scene, Part::Whole);
        // Long steps may be too few to integrate over; what that leaves open is known.
        let warning = run.record.ledger(scene.law.surface_energy).warning();
        let missing = warning.filter(|words| words.contains("missing"));
        assert_eq!(missing, None, "step {step}");
    }
}

/// By hand: the spring holds sigma_max but for k^2/(2 |gamma'''|), 5e-5 of it at k = 1e-3, until it
/// snaps, and lets go of sigma_max^2/2k.
#[test]
fn a_spring_however_soft_pulls_off_at_the_largest_traction_and_comes_to_rest_at_its_stage() {
    for stiffness in [1e-3, 1e-5, 1e-8] {
        let scene = sprung(stiffness, [0.8, -0.15, 0.05].map(|pull| pull / stiffness));
        let law = scene.model().unwrap().law;
        let run = walked(&scene, Part::Whole);
        let jump = run.record.jumps.last().expect("it pulls off");
        let pulled = stiffness * (jump.control - jump.mean_displacement);
        assert!((pulled / law.traction_max() - 1.0).abs() < 1e-4, "{jump:?}");
        assert!(
            (jump.mean_displacement_after / jump.control - 1.0).abs() < 1e-9,
            "{jump:?}"
        );
        let held = 0.5 * pulled * pulled / stiffness + law.at(jump.mean_displacement).energy;
        let released = jump.released_energy * law.surface_energy;
        assert!((released / held - 1.0).abs() < 1e-6, "{jump:?} {held}");
    }
}

#[test]
fn under_a_load_contact_forms_at_once_at_zero_stress_and_breaks_at_the_largest_traction() {
    let scene = driven(sprung(1.0, [0.0; 3]), Control::Load, [0.1, -0.02, 0.001]);
    let law = scene.model().unwrap().law;
    let run = walked(&scene, Part::Whole);
    assert!(run.record.states.iter().all(|s| s.pattern == Flat));
    let [touch, pull_off] = &run.record.jumps[..] else {
        panic!("{:?}", run.record.jumps)
    };
    let largest = law.traction_max();
    assert!(touch.control.abs() < 2e-5 * largest, "{touch:?}");
    // From far away, without energy, into the well of the law.
    assert!((touch.released_energy - 1.0).abs() < 1e-3, "{touch:?}");
    assert!(
        (pull_off.control / largest - 1.0).abs() < 1e-8,
        "{pull_off:?}"
    );
    assert!((pull_off.mean_displacement - law.contact_gap()).abs() < 1e-6);
    let (off, _) = off(&run, &law);
    assert!(off < 1e-6, "{off}");
}

/// On a fine mesh soft modes are looked for on a coarser one, and the machine must be there too.
#[test]
fn next_to_a_fold_under_a_spring_the_smallest_eigenvalue_vanishes_on_fine_meshes_too() {
    let mut scene = sprung(0.03, [6.0, 1.0, 0.1]);
    scene.cell.points = Points::Square(192);
    let run = walked(&scene, Part::Quarter);
    let last = |jump: &JumpRecord| {
        let before = |s: &&StateRecord| (s.direction, s.pattern) == (jump.direction, jump.from);
        run.record.states.iter().rfind(before).expect("a state")
    };
    let folds = run.record.jumps.iter();
    let folds: Vec<_> = folds.filter(|j| j.cause == Cause::Fold).collect();
    assert!(!folds.is_empty());
    for fold in folds {
        let state = last(fold);
        assert!((0.0..0.1).contains(&state.stiffness_min), "{state:?}");
    }
}

/// A tip small beside its cell.
pub fn tip(points: usize) -> Scene {
    preset_on("hertz", Points::Square(points))
}

/// A release comes to rest within its residual; the energy of a machine goes with what u0 is off.
#[test]
fn a_surface_that_lands_flat_has_the_energy_of_the_flat_state_at_its_control() {
    let stiffness = 0.1;
    let walk = start(&sprung(stiffness, [6.0, 0.2, 0.1]), Part::Quarter);
    let model = walk.model();
    let flat = FlatBranch::new(model.law, model.equivalent_length, walk.control());
    for gap in [0.5, 4.0] {
        let response = model.law.at(gap);
        let stretched = response.traction / stiffness;
        let energy = response.energy + 0.5 * stiffness * stretched * stretched;
        for off in [-1e-3, 1e-3] {
            let landed = flat.state_at(walk.system(), gap + off, gap + stretched);
            assert_eq!(landed.state.control, gap + stretched);
            assert!((landed.state.energy - energy).abs() < 1e-13, "{gap} {off}");
        }
    }
}

#[test]
fn a_dead_weight_pulls_a_tip_off_at_the_largest_tension_of_the_driven_loop() {
    let scene = tip(64);
    let law = scene.model().unwrap().law;
    let fixed = walked(&scene, Part::Quarter);
    let states = fixed.record.states.iter();
    let largest = states.map(|s| s.stress).fold(0.0, f64::max);
    let load = driven(
        scene,
        Control::Load,
        [2.0 * largest, -0.2 * largest, 0.05 * largest],
    );
    let run = walked(&load, Part::Quarter);
    let [touch, pull_off] = &run.record.jumps[..] else {
        panic!("{:?}", run.record.jumps)
    };
    assert!(touch.control.abs() < 2e-5 * law.traction_max(), "{touch:?}");
    // The driven loop has no state just at its largest tension.
    let off = pull_off.control / largest - 1.0;
    let located = LOCATED * law.traction_max() / largest;
    assert!((-located..2e-3).contains(&off), "{off}");
    let (off, stated) = self::off(&run, &law);
    assert!(off < stated + 1e-6 && off < 1e-4, "{off} {stated}");
}

/// A surface in contact is pulled out: it is held where a flat one at the same u0 feels nothing.
#[test]
fn a_load_lets_go_of_a_tip_beyond_the_end_of_a_law_and_releases_what_its_loop_loses() {
    let mut scene = tip(16);
    scene.cell = Cell {
        length: 80.0,
        points: Points::Line(80),
    };
    scene.law.shape = Shape::Cosine(Cosine { smooth: true });
    (scene.law.surface_energy, scene.law.range) = (0.2328, Range::Length(2.1413));
    scene.indenter = Indenter::Hertz(Hertz { radius: 75.74 });
    let scene = driven(scene, Control::Load, [0.24, -0.09, 2e-3]);
    let run = walked(&scene, Part::Whole);
    let pull_off = find(&run, Pattern::Contact, Direction::Retraction);
    assert!(pull_off.released_energy > 0.0, "{pull_off:?}");
    assert!(run.record.jumps.iter().all(|j| j.released_energy > 0.0));
    let (off, stated) = off(&run, &scene.model().unwrap().law);
    assert!(off < stated, "{off} {stated}");
}

#[test]
fn the_pull_off_force_under_a_load_tends_to_that_of_jkr_as_the_range_shrinks() {
    let off = [32, 64].map(|points| {
        let scene = tip(points);
        let Indenter::Hertz(hertz) = scene.indenter else {
            panic!("a tip")
        };
        let jkr = Jkr {
            radius: hertz.radius,
            surface_energy: scene.law.surface_energy,
        };
        let stress = jkr.pull_off_force() / scene.cell.length.powi(2);
        let load = driven(
            scene,
            Control::Load,
            [2.0 * stress, -0.1 * stress, 0.05 * stress],
        );
        let run = walked(&load, Part::Quarter);
        let pull_off = run.record.jumps.last().expect("a pull-off");
        pull_off.control / stress - 1.0
    });
    // The range is halved; what is left of it, and the cell's images, add a few per cent.
    assert!(
        off[1] > 0.0 && off[1] < 0.8 * off[0] && off[1] < 0.1,
        "{off:?}"
    );
}

/// Every state of a loop under a spring, looked at by itself.
#[test]
fn no_state_called_stable_under_a_spring_is_unstable_at_fixed_u0_nor_steeper_than_the_spring() {
    let stiffness = 0.02;
    let mut scene = sprung(stiffness, [7.0, -1.0, 0.1]);
    scene.cell.points = Points::Line(64);
    let mut walk = start(&scene, Part::Whole);
    let mut fixed = Mechanics::new(
        walk.system().clone().with_control(Control::Displacement),
        Slides::Freely,
    );
    let (mut before, mut looked_at) = (walk.record().clone(), 0);
    for target in [-1.0, 7.0] {
        walk.set_target(target);
        while walk.step(&Cancel::default(), &mut |_| {}) == Progress::Working {
            let (here, state) = (walk.record().clone(), walk.here().state.clone());
            if here.pattern == before.pattern && here.mean_displacement != before.mean_displacement
            {
                let secant = (here.stress - before.stress)
                    / (here.mean_displacement - before.mean_displacement);
                assert!(
                    secant > -stiffness || here.direction != before.direction,
                    "{here:?}"
                );
            }
            let mut z = state.amplitudes;
            z[0] = 0.0;
            let at = fixed.at(z, state.mean_displacement);
            fixed.refresh(&at.fields);
            let mut tracker = Tracker::new(rand::SeedableRng::seed_from_u64(7));
            let (seen, _) = tracker.check(&mut fixed, &at.state.amplitudes, &at.fields);
            assert!(
                seen.is_stable() && seen.value >= walk.here().stiffness_min.unwrap().value - 1e-6,
                "{here:?} {seen:?}"
            );
            looked_at += usize::from(here.pattern == Ridge);
            before = here;
        }
    }
    assert!(looked_at > 20, "{looked_at}");
}
