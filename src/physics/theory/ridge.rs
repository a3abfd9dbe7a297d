//! The ridge of an adhesion without range (Griffith), exact in a periodic cell; its asymptotes (Eqs
//! 22 to 27), right and as printed; and what a loop between it and the flat state loses (Eq. 30).
//!
//! A share alpha of the cell is out of contact. With u~ = u0/sqrt(gamma L/E*) and energies per area
//! in units of gamma,
//!
//! ```text
//! W = u~^2 vhat(alpha) - (1 - alpha),   vhat = -pi/(4 ln cos(pi alpha/2)),
//! ```
//!
//! and equilibrium is dW/dalpha = 0. It is stable where vhat'' > 0, which ends at alpha_c: there
//! the ridge flattens. p~ = p u0/gamma. Eq. 25 is Eq. 26 with dimensions, where the print lacks a
//! square: p/E* = -(4 gamma^2/(pi L E*^2 u0))^(1/3).

use super::{Units, boundary, flat_limits};
use crate::physics::law::Law;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, LN_2, PI};

/// The elastic energy vhat(alpha) and its first three derivatives, for 0 < alpha < 1.
pub fn elastic_energy(alpha: f64) -> [f64; 4] {
    let k = FRAC_PI_2;
    let (sin, cos) = ((k * alpha).sin(), (k * (1.0 - alpha)).sin());
    // l = ln cos(pi alpha/2); the first form keeps its digits for small alpha.
    let l = if alpha < 0.5 {
        0.5 * (-sin * sin).ln_1p()
    } else {
        cos.ln()
    };
    let tan = sin / cos;
    let l1 = -k * tan;
    let l2 = -k * k * (1.0 + tan * tan);
    let l3 = 2.0 * k * tan * l2;
    let c = FRAC_PI_4 / (l * l);
    [
        -FRAC_PI_4 / l,
        c * l1,
        c * (l2 - 2.0 * l1 * l1 / l),
        c * (l3 - 6.0 * l1 * l2 / l + 6.0 * l1 * l1 * l1 / (l * l)),
    ]
}

/// The point where the stable ridge ends (vhat'' = 0), and the square-root law next to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Critical {
    /// Share of the cell out of contact.
    pub alpha: f64,
    /// u~ = u0/sqrt(gamma L/E*).
    pub displacement: f64,
    /// vhat, vhat', vhat'' (zero but for rounding) and vhat'''.
    pub elastic_energy: [f64; 4],
    /// p~ = p u0/gamma, negative in tension.
    pub pressure: f64,
    /// p^(1/2) of p~ = p_c~ + p^(1/2) sqrt(u_c~ - u~) on the stable branch, leading order (Eqs 25
    /// and 27, corrected).
    pub pressure_root: f64,
}

/// As printed in and after Eqs 24 and 27. (p^(1/2) lacks the root of -2/u''; in p_c a digit of
/// vhat_c went astray.)
pub const FLATTENING_PRINTED: Critical = Critical {
    alpha: 0.909,
    displacement: 0.6656,
    elastic_energy: [0.4204, -2.26, 0.0, -145.0],
    pressure: -0.3937,
    pressure_root: -0.360,
};

/// The flattening point, found as the root of vhat''.
pub fn critical() -> Critical {
    // vhat'' falls from plus infinity at alpha = 0 to minus infinity at alpha = 1.
    let alpha = boundary(0.5, 1.0, |alpha| elastic_energy(alpha)[2] > 0.0);
    let vhat = elastic_energy(alpha);
    let displacement = (-1.0 / vhat[1]).sqrt();
    Critical {
        alpha,
        displacement,
        elastic_energy: vhat,
        pressure: -2.0 * displacement * displacement * vhat[0],
        pressure_root: -4.0 * (vhat[1] / (vhat[3] * displacement)).sqrt(),
    }
}

impl Critical {
    /// vhat'(alpha) to second order (Eq. 24), so that vhat is a polynomial of third.
    pub fn slope_at(&self, alpha: f64) -> f64 {
        let [_, slope, _, third] = self.elastic_energy;
        slope + 0.5 * third * (alpha - self.alpha).powi(2)
    }

    /// alpha on the stable side from Eq. 24; NaN beyond the flattening point.
    pub fn alpha_at(&self, displacement: f64) -> f64 {
        let [_, slope, _, third] = self.elastic_energy;
        self.alpha - (-2.0 / third * (1.0 / (displacement * displacement) + slope)).sqrt()
    }

    /// p~ on the stable side (Eq. 27); NaN beyond u_c~.
    pub fn pressure_at(&self, displacement: f64) -> f64 {
        self.pressure + self.pressure_root * (self.displacement - displacement).sqrt()
    }
}

/// Share alpha out of contact of the stable ridge at `displacement` u~: the root of vhat'(alpha) =
/// -1/u~^2 below alpha_c.
///
/// `None` unless 0 < u~ <= u_c~.
pub fn alpha(displacement: f64) -> Option<f64> {
    let end = critical();
    if !(displacement > 0.0 && displacement <= end.displacement) {
        return None;
    }
    // vhat' rises steadily up to alpha_c. The thick ridge alpha = (4 u~^2/pi)^(1/3) is below the
    // root by at most 10 %.
    let slope = -1.0 / (displacement * displacement);
    let thick = thick_alpha(displacement);
    Some(boundary(0.5 * thick, end.alpha, |alpha| {
        elastic_energy(alpha)[1] < slope
    }))
}

/// Energy W per area, in units of gamma, of a ridge with a share `alpha` out of contact at
/// `displacement` u~.
pub fn energy(alpha: f64, displacement: f64) -> f64 {
    displacement * displacement * elastic_energy(alpha)[0] - (1.0 - alpha)
}

/// Pressure p~ = p u0/gamma = -2 u~^2 vhat of the stable ridge at `displacement` u~; negative is
/// tension. `None` as in [`alpha`].
pub fn pressure(displacement: f64) -> Option<f64> {
    alpha(displacement).map(|alpha| -2.0 * displacement * displacement * elastic_energy(alpha)[0])
}

/// Energy per area, in units of gamma, that a closed loop between full contact and the flat
/// separated state loses in this limit.
///
/// On approach the surfaces jump nowhere before they touch; on retraction the ridge flattens at
/// u_c~ with W + 1 in store, so the loss is 1 + W(u_c~) = 1.08756 (the paper's Eq. 30c prints
/// 1.365).
pub fn zero_range_dissipation() -> f64 {
    let end = critical();
    1.0 + energy(end.alpha, end.displacement)
}

/// c of the thin ridge, Eq. 22: exactly ln(2)/2.
pub const THIN_CONSTANT: f64 = 0.5 * LN_2;
/// c as printed, from a stress that goes as sqrt(1 - x^2), not 1/sqrt(1 - x^2).
pub const THIN_CONSTANT_PRINTED: f64 = 0.3079;

/// vhat of the thick ridge, alpha -> 0 (Eq. 22): 2/(pi alpha^2). The next term is smaller by (pi
/// alpha)^2/24.
pub fn thick(alpha: f64) -> f64 {
    2.0 / (PI * alpha * alpha)
}

/// vhat of the thin ridge, abar = 1 - alpha -> 0 (Eq. 22 as meant, Eq. A7): -pi/(4 ln(pi abar) - 8
/// c).
///
/// The print has ln(pi alpha) + 8 c, which is negative near alpha = 1.
pub fn thin(abar: f64, c: f64) -> f64 {
    -PI / (4.0 * (PI * abar).ln() - 8.0 * c)
}

/// alpha of the thick ridge (Eq. 23): (4 u~^2/pi)^(1/3).
pub fn thick_alpha(displacement: f64) -> f64 {
    (4.0 * displacement * displacement / PI).cbrt()
}

/// p~ of the thick ridge (Eq. 26): -(4/pi)^(1/3) u~^(2/3).
pub fn thick_pressure(displacement: f64) -> f64 {
    -(4.0 / PI).cbrt() * displacement.powf(2.0 / 3.0)
}

/// What a loop between the flat, separated state and the ridge loses in a cell of side `length`
/// (Eq. 30), in units of gamma per area.
///
/// On approach the flat state gives way at u_nc, the upper of [`flat_limits`], and becomes a
/// ridge; on retraction the ridge flattens at u_c. The loss is the area between the two branches,
///
/// ```text
/// gamma_hys/gamma = W(u_c) - W(u_nc) + [gamma(u_nc) - gamma(u_c)]/gamma,
/// ```
///
/// with W the ridge of zero range ([`energy`]): good to 1 % for a Morse law with rho~ < 0.1. The
/// flat term is added and negative; the text at Eq. 30 subtracts it.
///
/// `None` where the flat state never gives way.
pub fn loss(law: &Law, length: f64) -> Option<f64> {
    let units = Units::of(law, length);
    let (_, approach) = flat_limits(law, length)?;
    let touching = units.reduce(approach);
    let end = critical();
    let ridge = energy(end.alpha, end.displacement) - energy(alpha(touching)?, touching);
    let separated = law.at(approach).energy - law.at(units.restore(end.displacement)).energy;
    Some(ridge + separated / law.surface_energy)
}

/// Eq. 30c: the ridge as thick as it is at small u~, without the flat term. `zero_range` is the
/// loss without range and `approach` the u~ at which the flat state gives way.
pub fn leading_order(zero_range: f64, approach: f64) -> f64 {
    zero_range - 1.5 * (4.0 / PI * approach * approach).cbrt()
}

/// The loss without range as Eq. 30c prints it, (3/2) alpha_c = 1.365, which takes the thick ridge
/// up to its end. The right one is [`zero_range_dissipation`], 1.08756.
pub fn printed_zero_range() -> f64 {
    1.5 * critical().alpha
}

/// The u~ at which the flat state gives way on approach by Eq. 30d, rho~ ln(2/(pi rho~^2)): Eq. 8
/// for a Morse law of small `range` rho~.
pub fn morse_approach(range: f64) -> f64 {
    range * (2.0 / (PI * range * range)).ln()
}
