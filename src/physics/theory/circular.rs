//! Dimple and bulge of an adhesion without range (Griffith), in a periodic square cell.
//!
//! A dimple of diameter alpha L is out of contact, or a bulge of diameter abar L in contact; `size`
//! is either. With u~ = u0/sqrt(gamma L/E*), energies per area in units of gamma and W = 0 for the
//! flat separated state,
//!
//! ```text
//! W = u~^2 vhat(size) - ahat(size),   ahat = 1 - pi alpha^2/4 (dimple), pi abar^2/4 (bulge),
//! ```
//!
//! and equilibrium is dW/dsize = 0 (Eq. 17), with p~ = -2 u~^2 vhat (Eqs 18 and 19). Each pattern
//! has one fold: a largest u~. The dimple is stable against growing and shrinking below the fold's
//! size, the bulge above it.

use super::boundary;
use super::discs::{self, Kind};
use crate::numerics::chebyshev::Chebyshev;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
use std::sync::OnceLock;

/// The largest diameter in units of L: neighbours that touch are singular.
pub const SIZE_MAX: f64 = 0.976;
/// The smallest diameter of which [`Pattern::size`] knows.
const SIZE_MIN: f64 = 1e-4;
/// Points of the interpolant: its relative error is below 1e-8, as that of the values.
const POINTS: usize = 24;

/// vhat of a pattern as a function of its size, and what follows.
#[derive(Debug)]
pub struct Pattern {
    kind: Kind,
    /// vhat times size^3 (dimple) or over size (bulge) and its two derivatives, as functions of
    /// -ln(1 - size): smooth up to 1.
    scaled: [Chebyshev; 3],
}

/// A state at zero range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// alpha of a dimple, abar of a bulge.
    pub size: f64,
    /// u~ = u0/sqrt(gamma L/E*).
    pub displacement: f64,
    /// p~ = p u0/gamma, negative in tension.
    pub pressure: f64,
    /// W, in units of gamma per area.
    pub energy: f64,
}

/// The dimple. The first call computes its table (a third of a second).
pub fn dimple() -> &'static Pattern {
    static PATTERN: OnceLock<Pattern> = OnceLock::new();
    PATTERN.get_or_init(|| Pattern::new(Kind::Dimple))
}

/// The bulge; as [`dimple`].
pub fn bulge() -> &'static Pattern {
    static PATTERN: OnceLock<Pattern> = OnceLock::new();
    PATTERN.get_or_init(|| Pattern::new(Kind::Bulge))
}

impl Pattern {
    fn new(kind: Kind) -> Self {
        let scaled = Chebyshev::interpolate(0.0, -(1.0 - SIZE_MAX).ln(), POINTS, |x| {
            // Nodes keep off the end x = 0.
            let size = -(-x).exp_m1();
            let vhat = discs::elastic_energy(kind, size);
            if kind == Kind::Dimple {
                vhat * size.powi(3)
            } else {
                vhat / size
            }
        });
        let slope = scaled.derivative();
        let curvature = slope.derivative();
        Self {
            kind,
            scaled: [scaled, slope, curvature],
        }
    }

    /// vhat and its first two derivatives by size, for 0 < size <= [`SIZE_MAX`].
    pub fn elastic_energy(&self, size: f64) -> [f64; 3] {
        let x = -(-size).ln_1p();
        let [f, fx, fxx] = [0, 1, 2].map(|i| self.scaled[i].at(x));
        // dx/dsize = 1/(1 - size).
        let g = 1.0 / (1.0 - size);
        let (f1, f2) = (fx * g, (fxx + fx) * g * g);
        match self.kind {
            Kind::Dimple => {
                let s = 1.0 / size;
                let cube = s * s * s;
                [
                    f * cube,
                    (f1 - 3.0 * f * s) * cube,
                    (f2 - 6.0 * f1 * s + 12.0 * f * s * s) * cube,
                ]
            }
            Kind::Bulge => [f * size, f1 * size + f, f2 * size + 2.0 * f1],
        }
    }

    /// Share of the cell in contact, ahat (Eq. 16).
    pub fn contact_area(&self, size: f64) -> f64 {
        let disc = FRAC_PI_4 * size * size;
        if self.kind == Kind::Dimple {
            1.0 - disc
        } else {
            disc
        }
    }

    /// The equilibrium of this `size` (Eqs 17 and 18), 0 < size <= [`SIZE_MAX`].
    pub fn state(&self, size: f64) -> State {
        let vhat = self.elastic_energy(size);
        let contact = FRAC_PI_2 * size * if self.kind == Kind::Dimple { -1.0 } else { 1.0 };
        let square = contact / vhat[1];
        let energy = square * vhat[0] - self.contact_area(size);
        State {
            size,
            displacement: square.sqrt(),
            pressure: -2.0 * square * vhat[0],
            energy,
        }
    }

    /// The fold: the largest u~ at which the pattern exists.
    pub fn fold(&self) -> State {
        // 1/u~^2 = vhat'/ahat' is least where vhat''/vhat' = 1/size; it falls before and rises
        // after.
        self.state(boundary(0.1, SIZE_MAX, |size| {
            let vhat = self.elastic_energy(size);
            vhat[2] / vhat[1] < 1.0 / size
        }))
    }

    /// Size of the pattern at `displacement` u~, on the part of its branch whose energy is smallest
    /// among neighbouring sizes; `None` where there is none, or beyond [`SIZE_MAX`].
    pub fn size(&self, displacement: f64) -> Option<f64> {
        let fold = self.fold();
        if !(displacement > 0.0 && displacement <= fold.displacement) {
            return None;
        }
        let below = |size: f64| self.state(size).displacement < displacement;
        let small = self.kind == Kind::Dimple;
        let end = if small { SIZE_MIN } else { SIZE_MAX };
        if !below(end) {
            return None;
        }
        Some(if small {
            boundary(end, fold.size, below)
        } else {
            boundary(fold.size, end, |size| !below(size))
        })
    }

    /// The equilibrium at `displacement` u~; `None` as in [`Pattern::size`].
    pub fn at(&self, displacement: f64) -> Option<State> {
        self.size(displacement).map(|size| self.state(size))
    }

    /// The equilibrium whose circle begins to give way to an ellipse (axes along the cell's): the
    /// curvature of vhat against the stretch at constant area vanishes. The dimple is stable below
    /// this size, the bulge above the fold and below this size.
    ///
    /// An upper estimate of the limit: edges may bend in other ways too. Takes a tenth of a second,
    /// once.
    pub fn elliptic_limit(&self) -> State {
        static LIMITS: [OnceLock<f64>; 2] = [OnceLock::new(), OnceLock::new()];
        let (dimple, place) = (
            self.kind == Kind::Dimple,
            &LIMITS[usize::from(self.kind == Kind::Dimple)],
        );
        let between = if dimple { [0.86, 0.87] } else { [0.65, 0.66] };
        self.state(
            *place.get_or_init(|| secant(between, |size| ellipse_curvature(self.kind, size))),
        )
    }
}

/// (vhat(stretch) - vhat(0))/stretch^2, which is half the curvature, without its next order.
fn ellipse_curvature(kind: Kind, size: f64) -> f64 {
    let circle = discs::elastic_energy(kind, size);
    let at =
        |stretch: f64| (discs::ellipse_energy(kind, size, stretch) - circle) / (stretch * stretch);
    (4.0 * at(0.005) - at(0.01)) / 3.0
}

/// A root near `a` and `b` of a function that is nearly straight between.
fn secant([mut a, mut b]: [f64; 2], f: impl Fn(f64) -> f64) -> f64 {
    let (mut fa, mut fb) = (f(a), f(b));
    for _ in 0..5 {
        if (b - a).abs() < 1e-5 {
            break;
        }
        (a, b) = (b, b - fb * (b - a) / (fb - fa));
        (fa, fb) = (fb, f(b));
    }
    b
}
