//! The m-n Mie law (8-2 between half-spaces with Lennard-Jones interactions).

use super::Form;

/// f = mn/(m-n) (x^-m/m - x^-n/n) with m > n > 0. For x <= 0 every value is NaN: the law is singular at zero gap,
/// and even exponents would give a plausible number on the wrong side of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mie {
    /// Exponent m of the repulsion.
    pub m: f64,
    /// Exponent n of the attraction, smaller than m.
    pub n: f64,
}

impl Form for Mie {
    fn at(&self, x: f64) -> [f64; 3] {
        if x <= 0.0 {
            return [f64::NAN; 3];
        }
        let (m, n) = (self.m, self.n);
        let c = m * n / (m - n);
        let l = x.ln();
        let (a, b) = ((-m * l).exp(), (-n * l).exp());
        [c * (a / m - b / n), c * (b - a) / x, c * ((m + 1.0) * a - (n + 1.0) * b) / (x * x)]
    }

    fn strongest(&self) -> (f64, f64) {
        let (m, n) = (self.m, self.n);
        let x = ((m + 1.0) / (n + 1.0)).powf(1.0 / (m - n));
        (x, self.at(x)[1])
    }

    fn softest(&self) -> (f64, f64) {
        let (m, n) = (self.m, self.n);
        let x = ((m + 1.0) * (m + 2.0) / ((n + 1.0) * (n + 2.0))).powf(1.0 / (m - n));
        (x, -self.at(x)[2])
    }

    fn equilibrium(&self) -> f64 {
        1.0
    }
}
