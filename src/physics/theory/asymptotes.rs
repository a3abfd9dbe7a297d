//! The paper's asymptotes at zero range (Eqs 22 to 29), right and as printed.
//!
//! Reduced units throughout: vhat per E* u0^2/L, u~ = u0/sqrt(gamma L/E*), p~ = p u0/gamma. Eq. 25
//! is Eq. 26 with dimensions, where the print lacks a square: p/E* = -(4 gamma^2/(pi L E*^2
//! u0))^(1/3).

use super::ridge;
use std::f64::consts::{LN_2, PI, SQRT_2};

/// c of the thin ridge, Eq. 22: exactly ln(2)/2.
pub const THIN_CONSTANT: f64 = 0.5 * LN_2;
/// c as printed, from a stress that goes as sqrt(1 - x^2), not 1/sqrt(1 - x^2).
pub const THIN_CONSTANT_PRINTED: f64 = 0.3079;

/// vhat of the thick ridge, alpha -> 0 (Eq. 22): 2/(pi alpha^2). The next term is smaller by (pi
/// alpha)^2/24.
pub fn ridge_thick(alpha: f64) -> f64 {
    2.0 / (PI * alpha * alpha)
}

/// vhat of the thin ridge, abar = 1 - alpha -> 0 (Eq. 22 as meant, Eq. A7): -pi/(4 ln(pi abar) - 8
/// c).
///
/// The print has ln(pi alpha) + 8 c, which is negative near alpha = 1.
pub fn ridge_thin(abar: f64, c: f64) -> f64 {
    -PI / (4.0 * (PI * abar).ln() - 8.0 * c)
}

/// alpha of the thick ridge (Eq. 23): (4 u~^2/pi)^(1/3).
pub fn ridge_thick_alpha(displacement: f64) -> f64 {
    (4.0 * displacement * displacement / PI).cbrt()
}

/// p~ of the thick ridge (Eq. 26): -(4/pi)^(1/3) u~^(2/3).
pub fn ridge_thick_pressure(displacement: f64) -> f64 {
    -(4.0 / PI).cbrt() * displacement.powf(2.0 / 3.0)
}

/// The ridge next to the point where it flattens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flattening {
    /// alpha_c.
    pub alpha: f64,
    /// vhat there.
    pub elastic_energy: f64,
    /// vhat' there, its maximum.
    pub slope: f64,
    /// vhat''' there.
    pub third: f64,
    /// u_c~.
    pub displacement: f64,
    /// p_c~.
    pub pressure: f64,
    /// p^(1/2) of Eq. 27.
    pub pressure_root: f64,
}

/// As printed in and after Eqs 24 and 27. (p^(1/2) lacks the root of -2/u''; in p_c a digit of
/// vhat_c went astray.)
pub const FLATTENING_PRINTED: Flattening = Flattening {
    alpha: 0.909,
    elastic_energy: 0.4204,
    slope: -2.26,
    third: -145.0,
    displacement: 0.6656,
    pressure: -0.3937,
    pressure_root: -0.360,
};

/// From the exact ridge.
pub fn flattening() -> Flattening {
    let exact = ridge::critical();
    Flattening {
        alpha: exact.alpha,
        elastic_energy: exact.elastic_energy[0],
        slope: exact.elastic_energy[1],
        third: exact.elastic_energy[3],
        displacement: exact.displacement,
        pressure: exact.pressure,
        pressure_root: exact.pressure_root,
    }
}

impl Flattening {
    /// vhat'(alpha) to second order (Eq. 24), so that vhat is a polynomial of third.
    pub fn slope_at(&self, alpha: f64) -> f64 {
        self.slope + 0.5 * self.third * (alpha - self.alpha).powi(2)
    }

    /// alpha on the stable side from Eq. 24; NaN beyond the flattening point.
    pub fn alpha_at(&self, displacement: f64) -> f64 {
        self.alpha - (-2.0 / self.third * (1.0 / (displacement * displacement) + self.slope)).sqrt()
    }

    /// p~ on the stable side (Eq. 27); NaN beyond u_c~.
    pub fn pressure_at(&self, displacement: f64) -> f64 {
        self.pressure + self.pressure_root * (self.displacement - displacement).sqrt()
    }
}

/// vhat of a small dimple (Eq. 28 corrected): 3/(2 alpha^3).
pub fn dimple(alpha: f64) -> f64 {
    1.5 / alpha.powi(3)
}

/// vhat of a small dimple as printed in Eq. 28: 8/(sqrt(3 pi) alpha^3), 1.74 times too large.
pub fn dimple_printed(alpha: f64) -> f64 {
    8.0 / ((3.0 * PI).sqrt() * alpha.powi(3))
}

/// vhat of a small bulge (Eq. 28 corrected): abar/2.
pub fn bulge(abar: f64) -> f64 {
    0.5 * abar
}

/// vhat of a small bulge as printed in Eq. 28: sqrt(2) abar^(3/2).
pub fn bulge_printed(abar: f64) -> f64 {
    SQRT_2 * abar.powf(1.5)
}

/// p~ of a small dimple (Eq. 29 corrected): -3 (pi/9)^(3/5) u~^(4/5) = -(1.79301 u~)^(4/5).
pub fn dimple_pressure(displacement: f64) -> f64 {
    -3.0 * (PI / 9.0).powf(0.6) * displacement.powf(0.8)
}

/// p~ of a small dimple as printed in Eq. 29: -(4 u~/3)^(4/5).
pub fn dimple_pressure_printed(displacement: f64) -> f64 {
    -(4.0 * displacement / 3.0).powf(0.8)
}
