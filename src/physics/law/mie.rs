//! The m-n Mie law (8-2 between half-spaces with Lennard-Jones interactions).

use super::Form;
use crate::physics::parameter::{Dimension, Refusal, number, own};

/// f = mn/(m-n) (x^-m/m - x^-n/n) with m > n > 0. For x <= 0 every value is NaN: the law is
/// singular at zero gap, and even exponents would give a plausible number on the wrong side of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mie {
    /// Exponent m of the repulsion.
    pub m: f64,
    /// Exponent n of the attraction, smaller than m.
    pub n: f64,
}

impl Default for Mie {
    fn default() -> Self {
        Self { m: 8.0, n: 2.0 }
    }
}

own! { Mie {
    m: Number = "law.m", "Mie exponent", "m", Dimension::Pure(""),
        1e-9..=100.0, None, "a number above law.n, {range}, as in 8";
    n: Number = "law.n", "Mie exponent", "n", Dimension::Pure(""),
        1e-9..=100.0, None, "a finite number above 0, {range}, as in 2";
}
    fn check(&self) -> Result<(), Refusal> {
        let (m, n, most) = (self.m, self.n, Self::PARAMETERS[0].range.end());
        if m > n {
            Ok(())
        } else {
            Err(Refusal::new(
                "law.m",
                number(m),
                &format!("a number above law.n = {n}, at most {most}"),
            ))
        }
    }
}

impl Mie {
    /// (1 - e^{-(m - n) l})/(m - n): the difference of the two powers without cancellation, l where
    /// the exponents are one.
    fn split(&self, l: f64) -> f64 {
        let d = self.m - self.n;
        -(-d * l).exp_m1() / d
    }

    /// The gap x at which x^{m - n} is the product of (m + k)/(n + k).
    fn balance(&self, ks: &[f64]) -> f64 {
        let (n, d) = (self.n, self.m - self.n);
        (ks.iter().map(|k| (d / (n + k)).ln_1p()).sum::<f64>() / d).exp()
    }
}

impl Form for Mie {
    fn at(&self, x: f64) -> [f64; 3] {
        if x <= 0.0 {
            return [f64::NAN; 3];
        }
        let (m, n) = (self.m, self.n);
        let l = x.ln();
        // With s = (1 - x^{n-m})/(m - n) nothing cancels as m -> n, where s -> ln x.
        let (b, s) = ((-n * l).exp(), self.split(l));
        [
            -b * (n * s + 1.0),
            m * n * b * s / x,
            m * n * b * (1.0 - (m + 1.0) * s) / (x * x),
        ]
    }

    fn formula(&self) -> String {
        let (m, n) = (self.m, self.n);
        format!("{m}·{n}/({m} - {n}) ((rho/g)^{{{m}}}/{m} - (rho/g)^{{{n}}}/{n})")
    }

    fn strongest(&self) -> (f64, f64) {
        let x = self.balance(&[1.0]);
        (x, self.at(x)[1])
    }

    fn softest(&self) -> (f64, f64) {
        let x = self.balance(&[1.0, 2.0]);
        (x, -self.at(x)[2])
    }

    fn equilibrium(&self) -> f64 {
        1.0
    }
}
