//! The numbers that a transform may be made of.

use realfft::FftNum;

/// A floating-point number: `f64` or `f32`.
pub trait Real: FftNum + Default {
    /// The nearest number to `x`.
    fn rounded(x: f64) -> Self;

    /// The same value with 64 bits.
    fn widened(self) -> f64;
}

impl Real for f64 {
    fn rounded(x: f64) -> Self {
        x
    }

    fn widened(self) -> f64 {
        self
    }
}

impl Real for f32 {
    fn rounded(x: f64) -> Self {
        x as f32
    }

    fn widened(self) -> f64 {
        f64::from(self)
    }
}
