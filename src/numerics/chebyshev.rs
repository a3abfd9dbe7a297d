//! Smooth functions as series of Chebyshev polynomials.

use std::f64::consts::PI;

/// sum c_k T_k(t) with t from -1 to 1 over the interval.
#[derive(Clone, Debug)]
pub struct Chebyshev {
    low: f64,
    high: f64,
    coefficients: Vec<f64>,
}

impl Chebyshev {
    /// The polynomial of `points` terms that agrees with `f` at as many points between `low` and
    /// `high`.
    pub fn interpolate(low: f64, high: f64, points: usize, f: impl Fn(f64) -> f64) -> Self {
        let angle = |i: usize| PI * (i as f64 + 0.5) / points as f64;
        let values: Vec<f64> = (0..points)
            .map(|i| f(low + (high - low) * 0.5 * (1.0 + angle(i).cos())))
            .collect();
        let coefficient = |k: usize| {
            let sum: f64 = values
                .iter()
                .enumerate()
                .map(|(i, v)| v * (k as f64 * angle(i)).cos())
                .sum();
            sum * if k == 0 { 1.0 } else { 2.0 } / points as f64
        };
        Self {
            low,
            high,
            coefficients: (0..points).map(coefficient).collect(),
        }
    }

    /// Its derivative.
    pub fn derivative(&self) -> Self {
        let n = self.coefficients.len();
        // c'_{k-1} = c'_{k+1} + 2 k c_k.
        let mut slope = vec![0.0; n + 1];
        for k in (1..n).rev() {
            slope[k - 1] =
                slope.get(k + 1).copied().unwrap_or(0.0) + 2.0 * k as f64 * self.coefficients[k];
        }
        slope[0] *= 0.5;
        slope.truncate(n.saturating_sub(1).max(1));
        slope
            .iter_mut()
            .for_each(|c| *c *= 2.0 / (self.high - self.low));
        Self {
            coefficients: slope,
            ..*self
        }
    }

    /// Its value at `x`, by Clenshaw's recurrence.
    pub fn at(&self, x: f64) -> f64 {
        let t = (2.0 * x - self.low - self.high) / (self.high - self.low);
        let (mut b1, mut b2) = (0.0, 0.0);
        for c in self.coefficients.iter().skip(1).rev() {
            (b1, b2) = (2.0 * t * b1 - b2 + c, b1);
        }
        t * b1 - b2 + self.coefficients[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_exponential_and_its_derivatives_are_met() {
        let series = Chebyshev::interpolate(-0.5, 2.0, 20, |x| (1.3 * x).exp());
        let (slope, curvature) = (series.derivative(), series.derivative().derivative());
        for x in [-0.5, 0.1, 0.77, 2.0_f64] {
            let expected = (1.3 * x).exp();
            assert!((series.at(x) - expected).abs() < 1e-13 * 14.0);
            assert!((slope.at(x) / 1.3 - expected).abs() < 1e-11);
            assert!((curvature.at(x) / 1.69 - expected).abs() < 1e-9);
        }
    }

    #[test]
    fn a_cubic_needs_four_points() {
        let series = Chebyshev::interpolate(1.0, 4.0, 4, |x| x * x * x - 2.0 * x);
        assert!((series.at(2.5) - 10.625).abs() < 1e-13);
        assert!((series.derivative().at(2.5) - 16.75).abs() < 1e-12);
    }
}
