//! The Tabor parameter: the height to which adhesion pulls up a tip's neck, over the range of the
//! adhesion.

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
