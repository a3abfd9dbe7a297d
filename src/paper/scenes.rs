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

/// The ridge alone, as the preset `ridge-line`: fields uniform along y.
pub fn ridge_line() -> Scene {
    flat("A line cell: only the ridge", 256.0, Points::Line(256), 4.4, 0.2, 0.02)
}

/// gamma of the tip in units of E* R.
pub const TIP_SURFACE_ENERGY: f64 = 0.5859e-3;

/// The tip of Sect. 4 in a cell with L = R = 1, driven by displacement to zero load and back.
pub fn tip(points: usize, mu_rho: f64) -> Scene {
    let range = (TIP_SURFACE_ENERGY / points as f64).sqrt() / (2.0 * mu_rho);
    // Single points that let go are close together on the way.
    let step = if mu_rho < 0.75 { 0.15 } else { 0.05 };
    Scene {
        title: format!("A Hertzian tip: mu_rho = {mu_rho}"),
        source: "Wang, Zhou, Mueser 2020, Figs 12 and 13".to_owned(),
        cell: Cell { length: 1.0, points: Points::Square(points) },
        law: LawChoice { shape: Shape::Morse(Morse), surface_energy: TIP_SURFACE_ENERGY, range: Range::MuRho(mu_rho) },
        indenter: Indenter::Hertz { radius: 1.0 },
        // JKR lets go at 0.0113; a longer range acts from farther off, and a mesh that traps the edge of the contact holds on for longer.
        drive: Drive { start: 0.012 + 4.0 * range + 0.02 * (mu_rho - 0.7).max(0.0), turn: Turn::ZeroLoad, step: step * range },
        accuracy: 0.01,
        seed: 1,
    }
}
