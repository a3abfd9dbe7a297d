//! The mesh rule and the laws.

use super::{Erratum, Evidence};
use crate::physics::grid::Grid;
use crate::physics::indenter::Indenter;
use crate::physics::law::{Cosine, Law, Morse, Shape};
use crate::physics::mesh_rule;
use crate::physics::system::System;
use std::f64::consts::{FRAC_PI_2, PI, SQRT_2};

const POINTS: usize = 16;

fn morse(range: f64) -> Law {
    Law {
        shape: Shape::Morse(Morse),
        surface_energy: 1.0,
        range,
    }
}

/// The elastic stiffness q E*/2 of a mesh of unit spacing, smallest and largest.
fn stiffness(grid: Grid) -> [f64; 2] {
    let system = System::new(grid, morse(1.0), &Indenter::Flat);
    // What has no wave has no stiffness either.
    let waves = system.elastic().iter().copied().filter(|e| *e > 0.0);
    waves.fold([f64::INFINITY, 0.0], |[low, high], e| {
        [low.min(e), high.max(e)]
    })
}

/// mu_rho at which softening overcomes the stiffest wave of the mesh, read off the mesh itself.
fn limit(grid: Grid) -> f64 {
    // max(-gamma'') = mu_rho^2 E*/da with da = 1.
    stiffness(grid)[1].sqrt()
}

pub(super) fn equation_9() -> Erratum {
    let spacing = 1.0;
    let range = (1.0 / (4.0 * PI) * spacing).sqrt();
    Erratum {
        place: "Eqs 9 to 11",
        printed: "Eq. 10 translates (back) to the rule of Eq. 9",
        right: "Eq. 9 is mu_rho = sqrt(pi) = 1.772, beyond the mesh's own limit of 1.2533 (line) or 1.4905 (square); mu_rho = 0.5 \
                keeps the shortest unstable wave at 4 pi da",
        because: "A mesh that obeys Eq. 9 to the letter is unstable on the scale of its own spacing.",
        evidence: vec![
            Evidence {
                quantity: "mu_rho by Eq. 10 of a Morse law with the range of Eq. 9 (the print recommends 0.5)",
                found: mesh_rule::mu_rho(&morse(range), spacing),
                printed: mesh_rule::SAFE,
                right: PI.sqrt(),
                tolerance: 1e-12,
            },
            Evidence {
                quantity: "largest mu_rho that a line's stiffest wave bears, from the spectrum of a mesh",
                found: limit(Grid::line(POINTS as f64, POINTS)),
                printed: PI.sqrt(),
                right: FRAC_PI_2.sqrt(),
                tolerance: 1e-12,
            },
            Evidence {
                quantity: "the same of a square mesh",
                found: limit(Grid::square(POINTS as f64, POINTS)),
                printed: PI.sqrt(),
                right: (SQRT_2 * FRAC_PI_2).sqrt(),
                tolerance: 1e-12,
            },
        ],
    }
}

pub(super) fn equation_33() -> Erratum {
    let law = morse(mesh_rule::range_for_mu_rho(
        &morse(1.0),
        1.0,
        mesh_rule::SAFE,
    ));
    // The largest softening by looking for it, not by its formula.
    let softening = (0..40_000)
        .map(|i| -law.at(f64::from(i) * 2e-4 * law.range).stiffness)
        .fold(0.0, f64::max);
    Erratum {
        place: "Eq. 33",
        printed: "max(-gamma'') <= E*/da",
        right: "max(-gamma'') <= E*/(4 da) at the recommended mu_rho = 0.5",
        because: "E*/da is mu_rho = 1, at which edges of contact already jump from one mesh point to the next.",
        evidence: vec![Evidence {
            quantity: "max(-gamma'') da/E* of a Morse law with mu_rho = 0.5, searched for on a fine raster",
            found: softening,
            printed: 1.0,
            right: 0.25,
            tolerance: 1e-6,
        }],
    }
}

pub(super) fn equation_31() -> Erratum {
    // Stiffness from differences of the traction on either side of zero.
    let jump = |smooth: bool| {
        let law = Law {
            shape: Shape::Cosine(Cosine { smooth }),
            surface_energy: 1.0,
            range: 1.0,
        };
        let traction = |gap: f64| law.at(gap).traction;
        let step = 1e-4;
        (traction(-step) - traction(-2.0 * step)) / (traction(2.0 * step) - traction(step))
    };
    Erratum {
        place: "Eq. 31",
        printed: "{1 - (pi g/g_c)^2/2} for g < 0",
        right: "{1 - (pi g/g_c)^2/4}, if the stiffness is to be continuous",
        because: "As printed, gamma'' jumps by a factor of two at contact. The program offers both; the paper's is the default.",
        evidence: vec![
            Evidence {
                quantity: "gamma''(0-)/gamma''(0+) of the law as printed, from differences of its traction (continuous: 1)",
                found: jump(false),
                printed: 1.0,
                right: 2.0,
                tolerance: 1e-5,
            },
            Evidence {
                quantity: "the same of the variant with continuous stiffness (printed: 2)",
                found: jump(true),
                printed: 2.0,
                right: 1.0,
                tolerance: 1e-5,
            },
        ],
    }
}

/// The smallest wave number of a cell, from its stiffness.
pub(super) fn wave_number() -> Evidence {
    let length = POINTS as f64;
    let [smallest, _] = stiffness(Grid::line(length, POINTS));
    Evidence {
        quantity: "smallest wave number q_1 of a cell times its side, from the stiffness q E*/2 of its longest wave",
        found: 2.0 * smallest * length,
        printed: 1.0 / (2.0 * PI),
        right: 2.0 * PI,
        tolerance: 1e-12,
    }
}
