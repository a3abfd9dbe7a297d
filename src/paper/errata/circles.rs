//! Dimple, bulge, and the Hertzian tip.

use super::{Erratum, Evidence};
use crate::physics::theory::circular::{self, Part};
use crate::physics::theory::jkr::Jkr;
use std::f64::consts::{PI, SQRT_2};

/// The limit at zero of what approaches it linearly (or as the cube) from `at`: by Richardson's
/// rule.
fn limit(at: f64, order: i32, value: impl Fn(f64) -> f64) -> f64 {
    let factor = 2f64.powi(order);
    (factor * value(0.5 * at) - value(at)) / (factor - 1.0)
}

pub(super) fn equation_28() -> Erratum {
    let dimple = |alpha: f64| circular::dimple().elastic_energy(alpha)[0] * alpha.powi(3);
    let bulge = |size: f64| circular::bulge().elastic_energy(size)[0] / size;
    Erratum {
        place: "Eq. 28",
        printed: "dimple 8/(sqrt(3 pi) alpha^3), bulge sqrt(2) (1 - alpha)^{3/2}",
        right: "dimple 3/(2 alpha^3), bulge abar/2",
        because: "A single opened disc, and a single disc pressed on, are textbook solutions; the lattice adds higher orders only.",
        evidence: vec![
            Evidence {
                quantity: "vhat alpha^3 of a small dimple, from a series on the lattice, extrapolated",
                found: limit(0.2, 3, dimple),
                printed: 8.0 / (3.0 * PI).sqrt(),
                right: 1.5,
                tolerance: 1e-4,
            },
            Evidence {
                quantity: "vhat/abar of a small bulge, from a series on the lattice, extrapolated (print: at abar = 0.02)",
                found: limit(0.02, 1, bulge),
                printed: SQRT_2 * 0.02f64.sqrt(),
                right: 0.5,
                tolerance: 1e-3,
            },
        ],
    }
}

pub(super) fn equation_29() -> Erratum {
    // k of p~ = -(k u~)^(4/5), which is approached as alpha^3.
    let factor = |size: f64| {
        let state = circular::dimple().state(size);
        (-state.pressure).powf(1.25) / state.displacement
    };
    Erratum {
        place: "Eq. 29",
        printed: "p~ = -(4 u~/3)^{4/5}",
        right: "p~ = -(1.79301 u~)^{4/5}",
        because: "It follows from the energy of a dimple, and inherits its factor.",
        evidence: vec![Evidence {
            quantity: "k of p~ = -(k u~)^{4/5} of a small dimple, extrapolated",
            found: limit(0.2, 3, factor),
            printed: 4.0 / 3.0,
            right: 1.79300742,
            tolerance: 1e-3,
        }],
    }
}

pub(super) fn after_equation_29() -> Erratum {
    let bulge = circular::bulge();
    let fold = bulge.fold();
    // The energy of neighbouring sizes at u~ = 0.5, on the stable part of the branch.
    let displacement = 0.5;
    let size = bulge.size(displacement, Part::Stable).unwrap_or(f64::NAN);
    let energy = |size: f64| {
        displacement * displacement * bulge.elastic_energy(size)[0] - bulge.contact_area(size)
    };
    let lowest = (1..980)
        .map(|i| 1e-3 * f64::from(i))
        .filter(|s| *s > fold.size)
        .min_by(|a, b| energy(*a).total_cmp(&energy(*b)));
    Erratum {
        place: "after Eq. 29",
        printed: "no stable bulge exists in the continuum limit",
        right: "a bulge is metastable for 0.403 < u~ < 0.620",
        because: "Its energy has a minimum against size where it covers enough of the cell for its neighbours to be felt; below 0.403 \
                  it gives way to an ellipse.",
        evidence: vec![
            Evidence {
                quantity: "largest u~ of a metastable bulge of zero range (print: none)",
                found: fold.displacement,
                printed: 0.0,
                right: 0.620288,
                tolerance: 1e-5,
            },
            Evidence {
                quantity: "diameter over L at which the energy is least at u~ = 0.5, on a raster of 0.001 (print: none)",
                found: lowest.unwrap_or(f64::NAN),
                printed: 0.0,
                right: size,
                tolerance: 1e-3,
            },
        ],
    }
}

pub(super) fn section_4() -> Erratum {
    let tip = Jkr {
        radius: 1.0,
        surface_energy: 0.5859e-3,
    };
    Erratum {
        place: "Sect. 4",
        printed: "contact radii a_c = 0.1278 (load) and 0.06315 (displacement)",
        right: "0.12746 and 0.06128 for gamma = 0.5859e-3 E* R",
        because: "They are the cube roots of (9/8) pi gamma R^2/E* and (1/8) pi gamma R^2/E*.",
        evidence: vec![
            Evidence {
                quantity: "contact radius where the pulling force is largest, searched for",
                found: turning(&tip, 0.10, 0.16, |tip, a| tip.contact(a).force),
                printed: 0.1278,
                right: 0.127460,
                tolerance: 2e-6,
            },
            Evidence {
                quantity: "contact radius where the displacement is largest, searched for",
                found: turning(&tip, 0.04, 0.09, |tip, a| tip.contact(a).displacement),
                printed: 0.06315,
                right: 0.061277,
                tolerance: 2e-6,
            },
        ],
    }
}

/// Where a quantity of the contact turns round between two radii: by golden section, whichever way
/// it turns.
fn turning(tip: &Jkr, low: f64, high: f64, value: impl Fn(&Jkr, f64) -> f64) -> f64 {
    let middle = 0.5 * (low + high);
    let sign = (value(tip, middle) - 0.5 * (value(tip, low) + value(tip, high))).signum();
    let ratio = 0.5 * (5f64.sqrt() - 1.0);
    let (mut a, mut b) = (low, high);
    for _ in 0..80 {
        let (c, d) = (b - ratio * (b - a), a + ratio * (b - a));
        if sign * value(tip, c) > sign * value(tip, d) {
            b = d;
        } else {
            a = c;
        }
    }
    0.5 * (a + b)
}
