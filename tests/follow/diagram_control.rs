//! The diagram under a spring or a load: the same equilibria, other indices, folds and equal
//! energies.

use crate::control::{soft, sprung, tip};
use crate::diagram::{branch, dense_indices, diagram, events, modes_are_as_many_as_the_index};
use crate::loops::{driven, flat_ground, reach, start, walked};
use std::f64::consts::PI;
use tackscope::follow::diagram::{Branch, Diagram, Kind};
use tackscope::follow::record::{Cause, JumpRecord};
use tackscope::physics::control::Control;
use tackscope::physics::law::{Mie, Morse, Shape};
use tackscope::physics::pattern::Pattern;
use tackscope::scene::{Part, Points};

const DRIVE: [f64; 3] = [4.2, 0.2, 0.1];

/// The diagram of Fig. 2 under a control.
fn fig2(control: Control) -> Diagram {
    let drive = match control {
        Control::Load => [0.1, -0.02, 0.001],
        Control::Spring { stiffness } if stiffness < 1.0 => [6.0, -2.0, 0.1],
        _ => DRIVE,
    };
    diagram(&driven(sprung(1.0, DRIVE), control, drive), Part::Whole)
}

#[test]
fn a_spring_of_a_million_has_the_indices_and_the_folds_of_a_driven_displacement() {
    let stiff = fig2(Control::Spring { stiffness: 1e6 });
    let fixed = fig2(Control::Displacement);
    let pairs = || stiff.branches.iter().zip(&fixed.branches);
    assert_eq!(stiff.branches.len(), fixed.branches.len());
    for (a, b) in pairs() {
        assert_eq!(a.points.len(), b.points.len(), "{}", a.name);
        for (p, q) in a.points.iter().zip(&b.points) {
            assert_eq!((p.kind, p.index), (q.kind, q.index), "{}", a.name);
            let apart = (p.state.control - q.state.control).abs();
            assert!(apart < 2e-7, "{}: {apart:e}", a.name);
        }
    }
    let folds = pairs().flat_map(|(a, _)| events(a));
    assert!(folds.filter(|(kind, ..)| *kind == Kind::Fold).count() > 4);
    for (a, b) in stiff.equal_energies.iter().zip(&fixed.equal_energies) {
        assert_eq!(a.branches, b.branches);
        assert!((a.control - b.control).abs() < 1e-6, "{a:?} {b:?}");
    }
    assert_eq!(stiff.equal_energies.len(), fixed.equal_energies.len());
}

#[test]
fn under_a_load_no_state_of_a_pattern_is_stable_and_the_flat_one_is_up_to_the_largest_traction() {
    let found = fig2(Control::Load);
    let law = *found.branches[0].system.law();
    for branch in &found.branches {
        for point in &branch.points {
            let state = &point.state;
            assert_eq!(state.control, state.stress);
            let held = branch.name == "flat" && state.mean_displacement <= law.contact_gap();
            let stable = point.index.contains(&0);
            assert_eq!(stable, held, "{} {state:?}", branch.name);
        }
    }
    let fold = events(branch(&found, "flat")).into_iter().last().unwrap();
    assert_eq!(fold, (Kind::Fold, [1, 0], law.contact_gap()));
}

/// Every kind of state, under machines whose own folds lie between those of u0.
#[test]
fn every_index_under_a_machine_is_that_of_the_dense_hessian_with_u0_as_an_unknown() {
    let shapes = [Shape::Morse(Morse), Shape::Mie(Mie { m: 8.0, n: 2.0 })];
    for (shape, periods) in shapes.into_iter().zip([2.2, 1.7]) {
        let scene = flat_ground(shape, periods, Points::Square(24));
        let softest = scene.model().unwrap().law.softening_max();
        let [start, turn, _] = DRIVE;
        for (control, drive) in [
            (
                Control::Spring {
                    stiffness: 0.7 * softest,
                },
                [start + 4.0, turn - 2.0, 0.1],
            ),
            (Control::Load, [0.1, -0.02, 0.001]),
        ] {
            let (names, seen) = dense_indices(&driven(scene.clone(), control, drive));
            for name in ["flat", "square", "ridge", "mixed_1"] {
                assert!(names.contains(name), "{names:?}");
            }
            assert!(seen.len() > 3, "{seen:?}");
        }
    }
}

#[test]
fn the_modes_of_a_state_that_is_unstable_under_a_machine_are_as_many_as_its_index() {
    for control in [Control::Spring { stiffness: 0.03 }, Control::Load] {
        let drive = [6.0, -2.0, 0.1];
        let seen = modes_are_as_many_as_the_index(&driven(sprung(1.0, DRIVE), control, drive));
        assert!(seen.contains(&1) && seen.contains(&2), "{seen:?}");
    }
}

/// Those of these jumps that come of a fold lie at one where a stable piece ends; returns how many.
fn hold(found: &Diagram, jumps: &[JumpRecord]) -> usize {
    let law = *found.branches[0].system.law();
    let within = 2e-5 * found.control.unit(&law);
    let of_fold: Vec<_> = jumps.iter().filter(|j| j.cause == Cause::Fold).collect();
    for jump in &of_fold {
        let points = found.events().map(|(_, point)| point);
        let folds = points.filter(|p| p.kind == Kind::Fold && p.index.contains(&0));
        let far = folds.map(|p| (p.state.control - jump.control).abs());
        let nearest = far.fold(f64::INFINITY, f64::min);
        assert!(nearest < within, "{jump:?}: {nearest:e}");
    }
    of_fold.len()
}

#[test]
fn the_folds_under_a_machine_are_where_its_walk_jumps() {
    let found = fig2(Control::Spring { stiffness: 0.03 });
    assert_eq!(hold(&found, &soft().record.jumps), 1);
    let (stiffness, drive) = (0.1, [4.8, 0.0, 0.1]);
    let run = walked(&sprung(stiffness, drive), Part::Quarter);
    let found = fig2(Control::Spring { stiffness });
    assert_eq!(hold(&found, &run.record.jumps), 2);
    let scene = tip(32);
    let largest = scene.model().unwrap().law.traction_max();
    let drive = [0.1, -0.02, 0.005].map(|share| share * largest);
    let load = driven(scene, Control::Load, drive);
    let run = walked(&load, Part::Quarter);
    // The first is from the stop, which is no equilibrium of the body alone.
    let pull_off = &run.record.jumps[1..];
    assert_eq!(hold(&diagram(&load, Part::Quarter), pull_off), 1);
}

#[test]
fn under_a_machine_softer_than_the_longest_wave_the_flat_state_ends_where_gamma_is_as_soft() {
    let stiffness = 0.01;
    let scene = sprung(stiffness, [10.0, -4.0, 0.1]);
    assert!(stiffness < PI / scene.cell.length);
    let found = diagram(&scene, Part::Whole);
    let flat = branch(&found, "flat");
    let ends: Vec<_> = events(flat)
        .into_iter()
        .filter(|(_, index, _)| index.contains(&0))
        .collect();
    assert_eq!(ends.len(), 2);
    for (kind, _, u0) in ends {
        assert_eq!(kind, Kind::Fold);
        let off = flat.system.law().at(u0).stiffness / -stiffness - 1.0;
        assert!(off.abs() < 1e-9, "{off:e}");
    }
}

/// Index of a branch beyond this arc length.
fn index_at(branch: &Branch, arc: f64) -> usize {
    let beyond = branch.points.partition_point(|p| p.arc <= arc);
    branch.points[beyond - 1].index[1]
}

#[test]
fn a_softer_machine_never_makes_a_state_stable() {
    let springs = [1.0, 0.1, 0.03, 0.01].map(|stiffness| Control::Spring { stiffness });
    let softer = springs.into_iter().chain([Control::Load]);
    let mut stiff = fig2(Control::Displacement);
    for control in softer {
        let soft = fig2(control);
        let mut stable = 0;
        for branch in soft.branches.iter().filter(|b| b.name != "flat") {
            let other = self::branch(&stiff, &branch.name);
            let last = other.points.last().unwrap().arc;
            // Arc lengths are sums over steps, and no better than 1e-3.
            let edges: Vec<f64> = other
                .points
                .iter()
                .filter(|p| p.kind != Kind::Regular)
                .map(|p| p.arc)
                .collect();
            for p in branch
                .points
                .iter()
                .filter(|p| p.kind == Kind::Regular && p.arc < last)
            {
                if edges.iter().any(|edge| (edge - p.arc).abs() < 1e-3) {
                    continue;
                }
                let before = index_at(other, p.arc);
                assert!(
                    (before..=before + 1).contains(&p.index[0]),
                    "{control} {} {p:?}",
                    branch.name
                );
                stable += usize::from(p.index[0] == 0);
            }
        }
        assert_eq!(stable > 0, control != Control::Load, "{control}");
        stiff = soft;
    }
}

/// The walk on its way down and on its way up, at the stage that the diagram names.
#[test]
fn states_of_equal_energy_under_a_spring_have_it_in_the_walk() {
    let stiffness = 0.03;
    let found = fig2(Control::Spring { stiffness });
    let pair = ["flat", "ridge"].map(str::to_owned);
    let equal = found
        .equal_energies
        .iter()
        .find(|e| e.branches == pair)
        .unwrap();
    let scene = sprung(stiffness, [6.0, -2.0, 0.1]);
    let mut walk = start(&scene, Part::Quarter);
    let mut at = |target: f64| {
        reach(&mut walk, target);
        let here = walk.record();
        let stretch = target - here.mean_displacement;
        let energy = here.energy + 0.5 * stiffness * stretch * stretch;
        (here.pattern, energy, here.mean_displacement)
    };
    let flat = at(equal.control);
    at(-2.0);
    let ridge = at(equal.control);
    assert_eq!([flat.0, ridge.0], [Pattern::Flat, Pattern::Ridge]);
    let law = scene.law;
    assert!(
        (flat.1 - ridge.1).abs() < 1e-6 * law.surface_energy,
        "{flat:?} {ridge:?}"
    );
    for (u0, there) in [flat.2, ridge.2].into_iter().zip(equal.mean_displacements) {
        assert!((u0 - there).abs() < 1e-5, "{u0} {there}");
    }
}
