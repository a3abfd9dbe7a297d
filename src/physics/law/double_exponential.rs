//! The difference of two exponentials (Fig. 14), the coarse-grained law of a rough interface.

use super::Form;
use crate::numerics::exponential::{dispatch, exp, map_sum};

/// f = (r e^{-x/r} - e^{-x}) / (1 - r) with 0 < r < 1, the ratio of the repulsive to the attractive range.
///
/// Its minimum is -1 at x = 0 for every r; r = 1/2 is the Morse law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DoubleExponential {
    /// Range of the repulsion over the range of the attraction.
    pub ratio: f64,
}

impl Form for DoubleExponential {
    fn at(&self, x: f64) -> [f64; 3] {
        let r = self.ratio;
        let (a, b) = ((-x / r).exp(), (-x).exp());
        let c = 1.0 / (1.0 - r);
        [c * (r * a - b), c * (b - a), c * (a / r - b)]
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

    fn fill(&self, gap: &[f64], range: f64, first: &mut [f64], second: &mut [f64]) -> f64 {
        let r = self.ratio;
        let c = 1.0 / (1.0 - r);
        let (inverse, inverse_repulsive) = (-1.0 / range, -1.0 / (range * r));
        dispatch(
            #[inline(always)]
            || {
                map_sum(
                    gap,
                    first,
                    second,
                    #[inline(always)]
                    |g| {
                        let (a, b) = (exp(g * inverse_repulsive), exp(g * inverse));
                        [c * (r * a - b), c * (b - a), c * (a / r - b)]
                    },
                )
            },
        )
    }
}
