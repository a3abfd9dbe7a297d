//! The flat state (Eqs 5 to 8): closed form, and where it stops being stable.

use crate::physics::law::Law;

/// The stability of the flat state at gap `u0`: its smallest Hessian eigenvalue pi + L gamma''(u0)/E*, in units of E*/L.
pub fn stiffness_min(law: &Law, length: f64, u0: f64) -> f64 {
    std::f64::consts::PI + length * law.at(u0).stiffness
}
