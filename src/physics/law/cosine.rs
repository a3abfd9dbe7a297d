//! The cosine law with a true cut-off (Eq. 31), as printed and with a continuous stiffness.

use super::Form;
use crate::physics::parameter::{Dimension, Value, own};
use std::f64::consts::PI;

/// f = -(1 + cos pi x)/2 for 0 < x < 1, 0 beyond, and a parabola for x < 0. The range is the
/// cut-off g_c.
///
/// As printed the parabola is -(1 - (pi x)^2/2), and f'' jumps by a factor 2 at x = 0; `smooth`
/// halves the wall, which makes f twice continuously differentiable there. At the cut-off f'' jumps
/// from -pi^2/2 to 0 in both variants; x = 1 itself is beyond.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cosine {
    /// True for the variant with continuous stiffness at x = 0.
    pub smooth: bool,
}

own! { Cosine {
    smooth: Flag = "law.smooth", "Smooth at contact (C2)", "", Dimension::Pure(""),
        0.0..=1.0, Some(Value::Flag(false)), "true or false";
}}

impl Form for Cosine {
    fn at(&self, x: f64) -> [f64; 3] {
        if x >= 1.0 {
            return [0.0; 3];
        }
        if x > 0.0 {
            let (s, c) = (PI * x).sin_cos();
            return [-(1.0 + c) / 2.0, PI / 2.0 * s, PI * PI / 2.0 * c];
        }
        let wall = if self.smooth { PI * PI / 2.0 } else { PI * PI };
        [-1.0 + wall * x * x / 2.0, wall * x, wall]
    }

    fn formula(&self) -> String {
        "(-1 - cos(pi g/rho))/2 (0 < g < rho)".to_owned()
    }

    fn strongest(&self) -> (f64, f64) {
        (0.5, PI / 2.0)
    }

    fn is_smooth(&self) -> bool {
        false
    }

    fn softest(&self) -> (f64, f64) {
        (1.0, PI * PI / 2.0)
    }
}
