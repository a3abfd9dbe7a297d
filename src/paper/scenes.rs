//! The scenes of the paper as values, for the figures and for the window.

use crate::experiment::scene::{Cell, Drive, LawChoice, Points, Range, Scene, Turn};
use crate::physics::indenter::Indenter;
use crate::physics::law::{Morse, Shape};

/// gamma of the flat scenes in units of E* rho.
pub const SURFACE_ENERGY: f64 = 0.15;

/// Flat ground with the Morse law of range 1 and gamma = 0.15, as in Figs 2 to 4: a cell of side `length` on `points`, driven from
/// `start` to `turn` and back.
pub fn flat(title: &str, length: f64, points: Points, start: f64, turn: f64, step: f64) -> Scene {
    Scene {
        title: title.to_owned(),
        source: "Wang, Zhou, Mueser 2020".to_owned(),
        cell: Cell { length, points },
        law: LawChoice { shape: Shape::Morse(Morse), surface_energy: SURFACE_ENERGY, range: Range::Length(1.0) },
        indenter: Indenter::Flat,
        drive: Drive { start, turn: Turn::At(turn), step },
        accuracy: 0.01,
        seed: 1,
    }
}

/// Fig. 2, as the preset `fig2`.
pub fn figure_2() -> Scene {
    flat("Fig. 2: four patterns", 256.0, Points::Square(64), 4.2, 0.2, 0.02)
}

/// Fig. 3, as the preset `fig3`.
pub fn figure_3() -> Scene {
    flat("Fig. 3: a longer cell, no bulge", 1024.0, Points::Square(256), 9.0, 0.2, 0.04)
}
