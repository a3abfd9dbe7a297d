//! The ridge of an adhesion without range (Griffith), exact in a periodic cell.
//!
//! A share alpha of the cell is out of contact. With u~ = u0/sqrt(gamma L/E*) and energies per area
//! in units of gamma,
//!
//! ```text
//! W = u~^2 vhat(alpha) - (1 - alpha),   vhat = -pi/(4 ln cos(pi alpha/2)),
//! ```
//!
//! and equilibrium is dW/dalpha = 0. It is stable where vhat'' > 0, which ends at alpha_c: there
//! the ridge flattens.

use super::boundary;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

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
    /// W, in units of gamma per area.
    pub energy: f64,
}

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
        energy: energy(alpha, displacement),
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
    let thick = (4.0 * displacement * displacement / PI).cbrt();
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
    1.0 + critical().energy
}
