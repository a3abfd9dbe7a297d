//! The mesh rule (Eqs 9 to 11 and 33): max(-gamma'') = mu_rho^2 E*/da, for every law.
//!
//! A mesh of spacing da resists a wave of wave number q with q E*/2. The larger mu_rho, the shorter the waves that a softening law
//! makes unstable: at [`grid_limit`] the shortest one the mesh has, and jumps then belong to the mesh, not to the physics.

use super::law::Law;
use std::f64::consts::{FRAC_PI_2, PI, SQRT_2};

/// mu_rho that other cohesive-zone models use implicitly (Table 1): name, year, value.
///
/// Each equals [`mu_rho_of_zone`] with that model's length of the cohesive zone.
pub const TABLE_1: [(&str, u16, f64); 6] = [
    ("Dugdale", 1960, 0.798),
    ("Hillerborg", 1976, 0.5),
    ("Irwin", 1997, 0.886),
    ("Falk", 2001, 0.532),
    ("Hui", 2003, 1.09),
    ("Popov", 2015, 0.729),
];

/// The value the paper calls safe: the shortest unstable wave is 4 pi da.
pub const SAFE: f64 = 0.5;

/// mu_rho of `law` on a mesh of `spacing` da (Eq. 10 with E* = 1).
pub fn mu_rho(law: &Law, spacing: f64) -> f64 {
    (law.softening_max() * spacing).sqrt()
}

/// The range (length) at which a law like this one (its own range is ignored) has `mu_rho` on a mesh of `spacing` da (Eq. 11).
pub fn range_for_mu_rho(law: &Law, spacing: f64, mu_rho: f64) -> f64 {
    let unit = Law { range: 1.0, ..*law };
    (unit.softening_max() * spacing).sqrt() / mu_rho
}

/// The number of points n = L/da (not rounded) at which `law` has `mu_rho` in a cell of side `length`.
pub fn points_for_mu_rho(law: &Law, length: f64, mu_rho: f64) -> f64 {
    law.softening_max() * length / (mu_rho * mu_rho)
}

/// The wavelength pi da/mu_rho^2 (length) above which a flat surface can be unstable on a mesh of `spacing` da.
pub fn shortest_unstable_wave(spacing: f64, mu_rho: f64) -> f64 {
    PI * spacing / (mu_rho * mu_rho)
}

/// mu_rho at which even the mesh's largest wave number becomes unstable: pi/da on a line, sqrt(2) pi/da on a square.
pub fn grid_limit(line: bool) -> f64 {
    if line { FRAC_PI_2.sqrt() } else { (SQRT_2 * FRAC_PI_2).sqrt() }
}

/// mu_rho = 1/(2 sqrt(M)) of a model whose cohesive zone is l_cz = M E* gamma/sigma_max^2 long.
///
/// With Eq. 11 that is rho = sqrt(M gamma da/E*). All six entries of [`TABLE_1`] follow so from the published values of M.
pub fn mu_rho_of_zone(zone: f64) -> f64 {
    0.5 / zone.sqrt()
}
