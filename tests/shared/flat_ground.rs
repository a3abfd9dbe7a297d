//! Scenes on flat ground for the tests of whole loops.

use tackscope::physics::indenter::Indenter;
use tackscope::physics::law::{Law, Shape};
use tackscope::physics::theory::flat;
use tackscope::scene::{Cell, Drive, LawChoice, Points, Range, Scene, Turn};

/// L = `periods` L_c, driven from beyond every jump to half the way between the lower limit of the
/// flat state and its rest.
pub fn scene(shape: Shape, periods: f64, points: Points) -> Scene {
    let law = Law {
        shape,
        surface_energy: 0.15,
        range: 1.0,
    };
    let length = periods * flat::critical_length(&law);
    let (low, high) = flat::limits(&law, length).unwrap();
    Scene {
        title: String::new(),
        source: String::new(),
        cell: Cell { length, points },
        law: LawChoice {
            shape,
            surface_energy: law.surface_energy,
            range: Range::Length(law.range),
        },
        indenter: Indenter::Flat,
        drive: Drive {
            start: 2.2 * high + 1.0,
            turn: Turn::At(0.5 * (low + law.equilibrium_gap())),
            step: 0.2,
        },
        accuracy: 0.01,
        seed: 1,
    }
}
