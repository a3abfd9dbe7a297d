//! The Morse law (Eq. 3 of Wang, Zhou, Mueser 2021).

use super::Form;
use crate::numerics::functions::{exp, map_sum};
use crate::physics::parameter::Own;
use std::f64::consts::LN_2;

/// f = e^{-2x} - 2 e^{-x}: largest traction 1/2 at ln 2, largest negative stiffness 1/4 at ln 4.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Morse;

impl Own for Morse {}

impl Form for Morse {
    fn at(&self, x: f64) -> [f64; 3] {
        let e = (-x).exp();
        [
            e * (e - 2.0),
            2.0 * e * (1.0 - e),
            2.0 * e * (2.0 * e - 1.0),
        ]
    }

    fn formula(&self) -> String {
        "(e^{-2g/rho} - 2 e^{-g/rho})".to_owned()
    }

    fn strongest(&self) -> (f64, f64) {
        (LN_2, 0.5)
    }

    fn softest(&self) -> (f64, f64) {
        (2.0 * LN_2, 0.25)
    }

    fn fill(&self, gap: &[f64], range: f64, scale: [f64; 3], out: [&mut [f64]; 2]) -> f64 {
        let inverse = -1.0 / range;
        let [s, s1, s2] = [scale[0], 2.0 * scale[1], 2.0 * scale[2]];
        map_sum(
            gap,
            out,
            #[inline(always)]
            |g| {
                let e = exp(g * inverse);
                [
                    s * e * (e - 2.0),
                    s1 * e * (1.0 - e),
                    s2 * e * (2.0 * e - 1.0),
                ]
            },
        )
    }
}
