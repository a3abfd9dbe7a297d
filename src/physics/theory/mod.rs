//! Closed forms and fast series: production code and oracles at once. Here what they share, and the
//! flat state (Eqs 5 to 8): where it stops being stable.
//!
//! Contact modulus E* = 1 throughout. What is written with a tilde in the paper is made
//! dimensionless by [`Units`].

pub mod circular;
pub mod jkr;
pub mod ridge;

use super::law::Law;
use std::f64::consts::PI;

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

/// The stability of the flat state at gap `u0`: its smallest Hessian eigenvalue pi + L
/// gamma''(u0)/E*, in units of E*/L.
pub fn flat_stiffness(law: &Law, length: f64, u0: f64) -> f64 {
    PI + length * law.at(u0).stiffness
}

/// The side L_c (length) of the smallest cell in which the flat state can become unstable (Eq. 7),
/// pi E*/max(-gamma'').
///
/// Morse: 4 pi rho^2 E*/gamma. The same for a square and a line cell, whose longest waves are the
/// same.
pub fn critical_length(law: &Law) -> f64 {
    PI / law.softening_max()
}

/// The (lower, upper) gaps between which the flat state of a half-space in a cell of side `length`
/// is unstable: pi E*/L + gamma'' = 0. That of a layer is in a cell of its equivalent length
/// ([`Body::equivalent_length`](crate::physics::body::Body::equivalent_length)).
///
/// Upper is met on approach, lower on retraction; for Morse they are Eq. 8. `None` where the cell
/// is too small to become unstable, L <= L_c ([`critical_length`]). Exact to rounding, of which the
/// conditioning near L_c leaves half the digits. In an infinite cell from the largest traction on.
pub fn flat_limits(law: &Law, length: f64) -> Option<(f64, f64)> {
    if length.is_infinite() {
        return Some((law.contact_gap(), f64::INFINITY));
    }
    if length <= critical_length(law) {
        return None;
    }
    let stable = |gap: f64| flat_stiffness(law, length, gap) > 0.0;
    let softest = law.softest_gap();
    // The law is stiff at its equilibrium, so that this bracket holds, and a Mie law is never asked
    // at or below zero gap.
    let lower = boundary(law.equilibrium_gap(), softest, stable);
    if stable(softest) {
        // The stiffness jumps here (the cosine's cut-off): unstable just below, free of forces from
        // here on.
        return Some((lower, softest));
    }
    let mut width = law.range;
    // Ends: gamma'' fades away, and pi E*/L does not. A law that overflows is no number anywhere.
    while width.is_finite() && !stable(softest + width) {
        width *= 2.0;
    }
    Some((
        lower,
        boundary(softest, softest + width, |gap| !stable(gap)),
    ))
}
