//! An elastic layer on a rigid plate.

use super::{Body, Elastic};
use crate::physics::mesh::Grid;
use crate::physics::parameter::{BELOW_ONE, Dimension, LENGTHS, POSITIVE, Refusal, number, own};

/// A layer of uniform thickness t, bonded to a rigid plate; its surface is free of friction.
///
/// E* = E/(1 - nu^2) = 1 is the contact modulus of its material, M = (1 - nu)^2/(1 - 2 nu) E* the
/// one of uniaxial compression, and G = (1 - nu) E*/2 the shear modulus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// Thickness t (length).
    pub thickness: f64,
    /// Poisson's ratio nu.
    pub poisson: f64,
}

/// The thinnest layer over the side of the cell: the stiffness of long waves goes with the inverse
/// cube of the thickness, and stays within the digits of a double.
const THINNEST: f64 = 1e-5;

impl Default for Layer {
    fn default() -> Self {
        Self {
            thickness: 1.0,
            poisson: 0.5,
        }
    }
}

own! { Layer {
    thickness: Number = "body.thickness", "Layer thickness", "t", Dimension::Length,
        LENGTHS, None, POSITIVE;
    poisson: Number = "body.poisson", "Poisson's ratio", "ν", Dimension::Pure(""),
        -BELOW_ONE..=0.5, None, "a number above -1, at most 0.5 (incompressible), {range}";
}}

impl Layer {
    /// f(x) of x = q t > 0: the displacement of a wave over that of a half-space under the same
    /// traction, below 1.
    ///
    /// f = [(3 - 4 nu) sinh 2x - 2x]/[(3 - 4 nu) cosh 2x + 2 x^2 + 5 - 12 nu + 8 nu^2], to a few
    /// roundings: in powers of x where the numerator cancels, in exp(-2x) where both overflow.
    pub fn compliance(&self, x: f64) -> f64 {
        let (nu, y) = (self.poisson, 2.0 * x);
        let a = 3.0 - 4.0 * nu;
        if y < 1.0 {
            // sinh y - y, from its smallest term on.
            let steps = (1..=8).rev().map(|i| f64::from(2 * i * (2 * i + 1)));
            let tail = steps.fold(0.0, |sum, step| y * y / step * (1.0 + sum));
            let numerator = a * y * tail + 2.0 * (1.0 - 2.0 * nu) * y;
            let denominator = 2.0 * a * x.sinh().powi(2) + 2.0 * x * x + 8.0 * (1.0 - nu).powi(2);
            return numerator / denominator;
        }
        let s = (-y).exp();
        // In this order no factor is infinite where the other vanishes.
        let rest = 4.0 * (s * x) * x + 2.0 * s * (5.0 - 12.0 * nu + 8.0 * nu * nu);
        (a * (1.0 - s * s) - 2.0 * y * s) / (a * (1.0 + s * s) + rest)
    }
}

impl Elastic for Layer {
    fn name(&self) -> &'static str {
        "layer"
    }

    /// As thick as an eighth of the cell, incompressible: its softest wave is then the second or
    /// third.
    fn suited(&self, grid: &Grid) -> Body {
        Body::Layer(Self {
            thickness: grid.length / 8.0,
            ..*self
        })
    }

    fn stiffness(&self, q: f64) -> f64 {
        q / 2.0 / self.compliance(q * self.thickness)
    }

    /// M/t: the machine holds the plate.
    fn mean_stiffness(&self) -> f64 {
        (1.0 - self.poisson).powi(2) / (1.0 - 2.0 * self.poisson) / self.thickness
    }

    fn check_in(&self, length: f64) -> Result<(), Refusal> {
        if self.thickness < THINNEST * length {
            let allowed = format!("at least {THINNEST:e} of cell.length = {}", number(length));
            return Err(Refusal::new(
                "body.thickness",
                number(self.thickness),
                &allowed,
            ));
        }
        Ok(())
    }
}
