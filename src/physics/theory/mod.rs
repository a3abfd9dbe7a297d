//! Closed forms and fast series: production code and oracles at once.
//!
//! Contact modulus E* = 1 throughout. What is written with a tilde in the paper is made
//! dimensionless by [`Units`].

pub mod circular;
pub mod flat;
pub mod jkr;
pub mod ridge;

use super::law::Law;

/// The point between `below` and `above` where `is_below` turns from true to false, to the last
/// bit.
///
/// `is_below` is never evaluated at the two ends, so that they may lie where it has no meaning.
pub(crate) fn boundary(mut below: f64, mut above: f64, is_below: impl Fn(f64) -> bool) -> f64 {
    loop {
        let middle = 0.5 * (below + above);
        if middle == below || middle == above || middle.is_nan() {
            return middle;
        }
        if is_below(middle) {
            below = middle;
        } else {
            above = middle;
        }
    }
}

/// The units made of the cell and the surface energy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// Side L of the cell (length).
    pub length: f64,
    /// Work of adhesion gamma (E* times length).
    pub surface_energy: f64,
}

impl Units {
    /// Of this law in a cell of side `length`.
    pub fn of(law: &Law, length: f64) -> Self {
        Self {
            length,
            surface_energy: law.surface_energy,
        }
    }

    /// The unit of displacements and ranges, sqrt(gamma L/E*) (length).
    pub fn displacement(&self) -> f64 {
        (self.surface_energy * self.length).sqrt()
    }

    /// u~ = u0/sqrt(gamma L/E*) of a mean displacement; also rho~ of a range.
    pub fn reduce(&self, length: f64) -> f64 {
        length / self.displacement()
    }

    /// The displacement or range (length) of a dimensionless `reduced` one; inverts
    /// [`Units::reduce`].
    pub fn restore(&self, reduced: f64) -> f64 {
        reduced * self.displacement()
    }

    /// p~ = p u0/gamma of a mean `stress` (E*, tensile positive) at `mean_displacement`; the
    /// pressure p is minus the stress.
    pub fn pressure(&self, stress: f64, mean_displacement: f64) -> f64 {
        -stress * mean_displacement / self.surface_energy
    }

    /// The mean stress (E*, tensile positive) of p~ at `mean_displacement` (not zero); inverts
    /// [`Units::pressure`].
    pub fn stress(&self, pressure: f64, mean_displacement: f64) -> f64 {
        -pressure * self.surface_energy / mean_displacement
    }
}

/// mu_T = (R gamma^2/E*^2)^(1/3)/rho of a tip of `radius` R (length), work of adhesion
/// `surface_energy` (E* times length) and Morse `range` rho (length): the definition behind Eq. 32.
pub fn tabor(radius: f64, surface_energy: f64, range: f64) -> f64 {
    (radius * surface_energy * surface_energy).cbrt() / range
}

/// Eq. 32: the same for a Morse law of `mu_rho` on a mesh with `points` = R/da points to the
/// radius, mu_T = 2 mu_rho (gamma/(R E*))^(1/6) sqrt(points).
pub fn tabor_of_mesh(mu_rho: f64, radius: f64, surface_energy: f64, points: f64) -> f64 {
    2.0 * mu_rho * (surface_energy / radius).powf(1.0 / 6.0) * points.sqrt()
}
