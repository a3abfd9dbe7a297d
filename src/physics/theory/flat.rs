//! The flat state (Eqs 5 to 8): closed form, and where it stops being stable.

use super::boundary;
use crate::physics::law::Law;
use std::f64::consts::PI;

/// The stability of the flat state at gap `u0`: its smallest Hessian eigenvalue pi + L
/// gamma''(u0)/E*, in units of E*/L.
pub fn stiffness_min(law: &Law, length: f64, u0: f64) -> f64 {
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
pub fn limits(law: &Law, length: f64) -> Option<(f64, f64)> {
    if length.is_infinite() {
        return Some((law.contact_gap(), f64::INFINITY));
    }
    if length <= critical_length(law) {
        return None;
    }
    let stable = |gap: f64| stiffness_min(law, length, gap) > 0.0;
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
