//! The difference of two exponentials (Fig. 14), the coarse-grained law of a rough interface.

use super::{Form, fill_by_point};
use crate::numerics::functions::{exp, map_sum};
use crate::physics::parameter::{BELOW_ONE, Dimension, own};

/// Largest ratio at which the difference of two exponentials, each to 4e-16, is still good to
/// 1e-14.
const APART: f64 = 0.95;

/// f = (r e^{-x/r} - e^{-x}) / (1 - r) with 0 < r < 1, the ratio of the repulsive to the attractive
/// range.
///
/// Its minimum is -1 at x = 0 for every r; r = 1/2 is the Morse law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DoubleExponential {
    /// Range of the repulsion over the range of the attraction.
    pub ratio: f64,
}

impl Default for DoubleExponential {
    fn default() -> Self {
        Self { ratio: 0.4 }
    }
}

own! { DoubleExponential {
    ratio: Number = "law.ratio", "Ratio of ranges", "", Dimension::Pure(""),
        1e-6..=BELOW_ONE, None, "a number above 0 and below 1, {range} (repulsive over attractive range)";
}}

impl Form for DoubleExponential {
    fn at(&self, x: f64) -> [f64; 3] {
        // With m = e^{-x(1-r)/r} - 1 nothing cancels, neither as r -> 1 nor as infinity minus
        // infinity deep in compression.
        let r = self.ratio;
        let (b, m) = ((-x).exp(), (-x * (1.0 - r) / r).exp_m1());
        let cm = m / (1.0 - r);
        [b * (r * cm - 1.0), -b * cm, b * (cm + 1.0) / r]
    }

    fn formula(&self) -> String {
        let r = self.ratio;
        format!("({r} e^{{-g/{r}rho}} - e^{{-g/rho}})/(1 - {r})")
    }

    fn strongest(&self) -> (f64, f64) {
        let r = self.ratio;
        let x = -r.ln() * r / (1.0 - r);
        (x, self.at(x)[1])
    }

    fn softest(&self) -> (f64, f64) {
        let r = self.ratio;
        let x = -2.0 * r.ln() * r / (1.0 - r);
        (x, -self.at(x)[2])
    }

    fn fill(&self, gap: &[f64], range: f64, scale: [f64; 3], out: [&mut [f64]; 2]) -> f64 {
        let r = self.ratio;
        if r > APART {
            return fill_by_point(self, gap, range, scale, out);
        }
        let [s, s1, s2] = scale.map(|s| s / (1.0 - r));
        let (inverse, inverse_repulsive) = (-1.0 / range, -1.0 / (range * r));
        map_sum(
            gap,
            out,
            #[inline(always)]
            |g| {
                let (a, b) = (exp(g * inverse_repulsive), exp(g * inverse));
                [s * (r * a - b), s1 * (b - a), s2 * (a / r - b)]
            },
        )
    }
}
