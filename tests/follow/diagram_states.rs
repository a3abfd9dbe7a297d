//! The curves of the diagram between its points, and events that hide between them, against the loops
//! of the walk.

use crate::control::sprung;
use crate::diagram::{diagram, holds_jumps_of};
use crate::loops::{flat_ground, preset_on, walked};
use tackscope::follow::diagram::{Diagram, EqualEnergy, Kind};
use tackscope::follow::run::LoopRun;
use tackscope::physics::indenter::{Indenter, Wave};
use tackscope::physics::law::{DoubleExponential, Mie, Morse, Shape};
use tackscope::scene::{Part, Points, Range, Scene, Turn};

/// How far the states of a loop are from the stable pieces of a diagram at the same value of the
/// control: stress in sigma_max and energy in gamma, whichever is more. Those so near to an event
/// that its place matters, which for ridges is known on a finer mesh, are left out.
fn farthest(scene: &Scene, found: &Diagram, run: &LoopRun) -> f64 {
    let (law, control) = (scene.model().unwrap().law, scene.control());
    let near = 1e-3 * control.unit(&law);
    let clear = |control: f64| {
        let mut events = found.events();
        events.all(|(_, event)| (event.state.control - control).abs() > near)
    };
    let states = run
        .record
        .states
        .iter()
        .filter(|state| clear(state.control));
    let off = states.map(|state| {
        let energy = state.energy + control.energy(state.control, state.mean_displacement);
        let pieces = found.pieces(0).filter(|piece| {
            let [low, high] = piece.extent();
            (low..=high).contains(&state.control)
        });
        let apart = pieces.map(|piece| {
            let at = piece.at(state.control);
            let stress = (at.stress - state.stress) / law.traction_max();
            let energy = (at.energy - energy) / law.surface_energy;
            stress.abs().max(energy.abs())
        });
        apart.fold(f64::INFINITY, f64::min)
    });
    off.fold(0.0, f64::max)
}

/// Next to a fold the stress goes with the root of the distance, whatever turns back there.
#[test]
fn the_states_of_a_walk_lie_on_the_curves_between_points_up_to_the_folds() {
    let shape = Shape::DoubleExponential(DoubleExponential { ratio: 0.389 });
    let mut line = flat_ground(shape, 2.0, Points::Line(40));
    line.law.surface_energy = 0.095;
    let sprung = sprung(0.24, [4.2, 0.2, 0.02]);
    for (scene, part) in [(line, Part::Line), (sprung, Part::Quarter)] {
        let mut scene = scene;
        scene.drive.step = 0.02;
        let off = farthest(&scene, &diagram(&scene, Part::Whole), &walked(&scene, part));
        assert!(off < 1e-3, "{off:e} under {}", scene.control());
    }
}

/// A ridge that fades at the lower limit of the flat state turns back a thousandth of a range before.
#[test]
fn a_fold_next_to_the_limit_of_the_flat_state_is_found() {
    let shape = Shape::Mie(Mie {
        m: 10.024238700339758,
        n: 3.186921737512362,
    });
    let mut scene = flat_ground(shape, 1.98, Points::Line(48));
    scene.law.surface_energy = 0.16;
    scene.cell.length = 13.784288827598107;
    let found = diagram(&scene, Part::Line);
    let folds = found.events().filter(|(_, point)| point.kind == Kind::Fold);
    assert_eq!(folds.count(), 2);
    holds_jumps_of(&found, &walked(&scene, Part::Line), 1.0);
}

/// Crests on which contact begins and ends within less than a range.
fn crests() -> Scene {
    let mut scene = preset_on("wavy", Points::Square(32));
    (scene.cell.length, scene.law.shape) = (139.57812033383712, Shape::Morse(Morse));
    (scene.law.surface_energy, scene.law.range) = (0.195386027544044, Range::Length(1.0));
    scene.indenter = Indenter::Wave(Wave {
        amplitude: 0.5045589938512984,
        periods: [1, 2],
    });
    (scene.drive.start, scene.drive.turn) = (6.423454738076012, Turn::At(-0.3));
    scene.drive.step = 0.13446909476152025;
    scene
}

#[test]
fn every_event_of_a_loop_over_crests_is_found() {
    let scene = crests();
    let found = diagram(&scene, Part::Whole);
    holds_jumps_of(&found, &walked(&scene, Part::Whole), 1.0);
}

/// Copies of a branch by symmetry have the same energy everywhere, which is no crossing.
#[test]
fn states_of_equal_energy_are_different_ones_and_listed_once() {
    let equal = diagram(&crests(), Part::Whole).equal_energies;
    assert!(!equal.is_empty());
    for (i, pair) in equal.iter().enumerate() {
        let [a, b] = pair.stresses;
        assert!((a - b).abs() > 1e-4, "{pair:?}");
        let again = |other: &EqualEnergy| {
            let same = |k: usize| (other.stresses[k] - pair.stresses[k]).abs() < 1e-5;
            (other.control - pair.control).abs() < 1e-5 && same(0) && same(1)
        };
        assert!(!equal[..i].iter().any(again), "{pair:?}");
    }
}
