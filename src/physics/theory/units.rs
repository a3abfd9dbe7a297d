//! The dimensionless numbers of the flat problem: u~, rho~, p~ and L/L_c, with E* = 1.

/// The units made of the cell and the surface energy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// Side L of the cell (length).
    pub length: f64,
    /// Work of adhesion gamma (E* times length).
    pub surface_energy: f64,
}

impl Units {
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

/// L/L_c = 1/(4 pi rho~^2) for the Morse law; other laws: length over
/// [`super::flat::critical_length`].
pub fn length_ratio(range: f64) -> f64 {
    1.0 / (4.0 * std::f64::consts::PI * range * range)
}

/// mu_rho = 1/(2 rho~ sqrt(n)) of the Morse law on a mesh with n = L/da points along a side.
pub fn mu_rho(range: f64, points: f64) -> f64 {
    0.5 / (range * points.sqrt())
}
