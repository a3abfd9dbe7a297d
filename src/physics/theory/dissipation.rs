//! What a loop between the flat, separated state and the ridge loses (Eq. 30), in units of gamma
//! per area.
//!
//! On approach the flat state gives way at u_nc, the upper of [`flat::limits`], and becomes a
//! ridge; on retraction the ridge flattens at u_c. The loss is the area between the two branches,
//!
//! ```text
//! gamma_hys/gamma = W(u_c) - W(u_nc) + [gamma(u_nc) - gamma(u_c)]/gamma,
//! ```
//!
//! with W the ridge of an adhesion without range ([`ridge::energy`]). The flat term is added and
//! negative; the text at Eq. 30 subtracts it. All lengths here are reduced by sqrt(gamma L/E*) (see
//! [`Units`]).

use super::{Units, flat, ridge};
use crate::physics::law::Law;
use std::f64::consts::PI;

/// The loss in a cell of side `length`, from the exact ridge of zero range: good to 1 % for a Morse
/// law with rho~ < 0.1.
///
/// `None` where the flat state never gives way.
pub fn loss(law: &Law, length: f64) -> Option<f64> {
    let units = Units {
        length,
        surface_energy: law.surface_energy,
    };
    let (_, approach) = flat::limits(law, length)?;
    let touching = units.reduce(approach);
    let end = ridge::critical();
    let ridge = end.energy - ridge::energy(ridge::alpha(touching)?, touching);
    let separated = law.at(approach).energy - law.at(units.restore(end.displacement)).energy;
    Some(ridge + separated / law.surface_energy)
}

/// Eq. 30c: the ridge as thick as it is at small u~, without the flat term. `zero_range` is the
/// loss without range and `approach` the u~ at which the flat state gives way.
pub fn leading_order(zero_range: f64, approach: f64) -> f64 {
    zero_range - 1.5 * (4.0 / PI * approach * approach).cbrt()
}

/// The loss without range as Eq. 30c prints it, (3/2) alpha_c = 1.365, which takes the thick ridge
/// up to its end. The right one is [`ridge::zero_range_dissipation`], 1.08756.
pub fn printed_zero_range() -> f64 {
    1.5 * ridge::critical().alpha
}

/// The u~ at which the flat state gives way on approach by Eq. 30d, rho~ ln(2/(pi rho~^2)): Eq. 8
/// for a Morse law of small `range` rho~.
pub fn morse_approach(range: f64) -> f64 {
    range * (2.0 / (PI * range * range)).ln()
}
