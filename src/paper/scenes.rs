//! The scenes of the paper as values, for the figures and for the window.

use crate::physics::body::Body;
use crate::physics::grid::Grid;
use crate::physics::indenter::{Hertz, Indenter, Rough};
use crate::physics::law::{Morse, Shape};
use crate::scene::{Cell, Drive, LawChoice, Points, Range, Scene, Turn};

/// gamma of the flat scenes in units of E* rho.
pub const SURFACE_ENERGY: f64 = 0.15;

fn morse(surface_energy: f64, range: Range) -> LawChoice {
    LawChoice {
        shape: Shape::Morse(Morse),
        surface_energy,
        range,
    }
}

/// Flat ground with the Morse law of range 1 and gamma = 0.15, as in Figs 2 to 4: a cell of side
/// `length` on `points`, driven from `start` to `turn` and back.
pub fn flat(title: &str, length: f64, points: Points, start: f64, turn: f64, step: f64) -> Scene {
    Scene {
        title: title.to_owned(),
        source: "Wang, Zhou, Mueser 2020".to_owned(),
        cell: Cell { length, points },
        body: Body::HalfSpace,
        law: morse(SURFACE_ENERGY, Range::Length(1.0)),
        indenter: Indenter::Flat,
        drive: Drive {
            control: Default::default(),
            start,
            turn: Turn::At(turn),
            step,
        },
        accuracy: 0.01,
        seed: 1,
        units: None,
    }
}

/// Fig. 2, as the preset `fig2`.
pub fn figure_2() -> Scene {
    flat(
        "Fig. 2: four patterns",
        256.0,
        Points::Square(64),
        4.2,
        0.2,
        0.02,
    )
}

/// Fig. 3, as the preset `fig3`.
pub fn figure_3() -> Scene {
    flat(
        "Fig. 3: a longer cell, no bulge",
        1024.0,
        Points::Square(256),
        9.0,
        0.2,
        0.04,
    )
}

/// The ridge alone, as the preset `ridge-line`: fields uniform along y.
pub fn ridge_line() -> Scene {
    flat(
        "A line cell: only the ridge",
        256.0,
        Points::Line(256),
        4.4,
        0.2,
        0.02,
    )
}

/// Root mean square height of the rough ground of Fig. 14: the unit of length there.
pub const ROUGH_RMS: f64 = 1.0;
/// The range of Fig. 14 in units of the root mean square height, as the paper gives it.
pub const ROUGH_RANGE: f64 = 0.23;

/// Rough ground for Fig. 14, `waves` of the longest self-affine waves along a side. The drive goes
/// from 1.5 above the crest down to a mean gap of `turn`, both in root mean square heights.
///
/// The paper leaves surface and gamma open. Here the Hurst exponent is 0.8, the self-affine
/// wavelengths go from 8 to 2 root mean square heights, which makes a root mean square gradient
/// near 1, and gamma = 0.2 E* h_rms, which makes a small hysteresis.
pub fn rough(waves: usize, seed: u64, turn: f64) -> Scene {
    let length = 8.0 * waves as f64 * ROUGH_RMS;
    let points = 32 * waves;
    let surface = Rough {
        hurst: 0.8,
        rms: ROUGH_RMS,
        longest: 8.0 * ROUGH_RMS,
        shortest: 2.0 * ROUGH_RMS,
        seed,
    };
    let mean = surface.mean_height(&Grid::square(length, points));
    let (start, turn, step) = (1.5 * ROUGH_RMS, mean + turn * ROUGH_RMS, 0.01 * ROUGH_RMS);
    let mesh = Points::Square(points);
    Scene {
        law: morse(0.2 * ROUGH_RMS, Range::Length(ROUGH_RANGE * ROUGH_RMS)),
        indenter: Indenter::Rough(surface),
        ..flat("Fig. 14: rough ground", length, mesh, start, turn, step)
    }
}

/// gamma of the tip in units of E* R.
pub const TIP_SURFACE_ENERGY: f64 = 0.5859e-3;

/// The tip of Sect. 4 in a cell with L = R = 1, driven by displacement to zero load and back.
pub fn tip(points: usize, mu_rho: f64) -> Scene {
    let range = (TIP_SURFACE_ENERGY / points as f64).sqrt() / (2.0 * mu_rho);
    // Single points that let go are close together on the way.
    let step = if mu_rho < 0.75 { 0.15 } else { 0.05 };
    // JKR lets go at 0.0113; a longer range acts from farther off, and a mesh that traps the edge of
    // the contact holds on for longer.
    let start = 0.012 + 4.0 * range + 0.02 * (mu_rho - 0.7).max(0.0);
    let title = format!("A Hertzian tip: mu_rho = {mu_rho}");
    let mut scene = Scene {
        source: "Wang, Zhou, Mueser 2020, Figs 12 and 13".to_owned(),
        law: morse(TIP_SURFACE_ENERGY, Range::MuRho(mu_rho)),
        indenter: Indenter::Hertz(Hertz { radius: 1.0 }),
        ..flat(
            &title,
            1.0,
            Points::Square(points),
            start,
            f64::NAN,
            step * range,
        )
    };
    scene.drive.turn = Turn::ZeroLoad;
    scene
}

/// A cylinder under tension, for the schematic of Fig. 1.
pub fn figure_1() -> Scene {
    let title = "Fig. 1: a cylinder, seen from the side";
    Scene {
        source: "Wang, Zhou, Mueser 2020, Fig. 1".to_owned(),
        law: morse(0.3, Range::Length(0.2)),
        indenter: Indenter::Hertz(Hertz { radius: 4.0 }),
        ..flat(title, 8.0, Points::Line(256), 1.0, -0.6, 0.02)
    }
}
