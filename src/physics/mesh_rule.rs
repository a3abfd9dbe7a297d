//! The mesh rule (Eqs 9 to 11 and 33): max(-gamma'') = mu_rho^2 E*/da, for every law.

use super::law::Law;

/// mu_rho of `law` on a mesh of `spacing` da.
pub fn mu_rho(law: &Law, spacing: f64) -> f64 {
    (law.softening_max() * spacing).sqrt()
}

/// The range at which a law like this one (its own range is ignored) has `mu_rho` on a mesh of `spacing` da.
pub fn range_for_mu_rho(law: &Law, spacing: f64, mu_rho: f64) -> f64 {
    let unit = Law { range: 1.0, ..*law };
    (unit.softening_max() * spacing).sqrt() / mu_rho
}

/// The number of points n = L/da (not rounded) at which `law` has `mu_rho` in a cell of side `length`.
pub fn points_for_mu_rho(law: &Law, length: f64, mu_rho: f64) -> f64 {
    law.softening_max() * length / (mu_rho * mu_rho)
}
