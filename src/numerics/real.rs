//! The numbers that a transform may be made of.

use realfft::{ComplexToReal, FftNum, RealFftPlanner, RealToComplex};
use rustfft::{Fft, FftPlanner};
use std::sync::Arc;

/// Plans along one axis, forward and inverse.
pub type Pair<F, I> = (Arc<F>, Arc<I>);

/// A floating-point number: `f64` or `f32`.
pub trait Real: FftNum + Default {
    /// The nearest number to `x`.
    fn rounded(x: f64) -> Self;

    /// The same value with 64 bits.
    fn widened(self) -> f64;

    /// Plans for rows of `n` numbers. Not generic, so that the transforms are compiled once, here,
    /// and not for every crate that asks.
    fn row_plans(n: usize) -> Pair<dyn RealToComplex<Self>, dyn ComplexToReal<Self>>;

    /// Plans for columns of `n` complex numbers.
    fn column_plans(n: usize) -> Pair<dyn Fft<Self>, dyn Fft<Self>>;
}

impl Real for f64 {
    fn rounded(x: f64) -> Self {
        x
    }

    fn widened(self) -> f64 {
        self
    }

    fn row_plans(n: usize) -> Pair<dyn RealToComplex<Self>, dyn ComplexToReal<Self>> {
        let mut planner = RealFftPlanner::new();
        (planner.plan_fft_forward(n), planner.plan_fft_inverse(n))
    }

    fn column_plans(n: usize) -> Pair<dyn Fft<Self>, dyn Fft<Self>> {
        let mut planner = FftPlanner::new();
        (planner.plan_fft_forward(n), planner.plan_fft_inverse(n))
    }
}

impl Real for f32 {
    fn rounded(x: f64) -> Self {
        x as f32
    }

    fn widened(self) -> f64 {
        f64::from(self)
    }

    fn row_plans(n: usize) -> Pair<dyn RealToComplex<Self>, dyn ComplexToReal<Self>> {
        let mut planner = RealFftPlanner::new();
        (planner.plan_fft_forward(n), planner.plan_fft_inverse(n))
    }

    fn column_plans(n: usize) -> Pair<dyn Fft<Self>, dyn Fft<Self>> {
        let mut planner = FftPlanner::new();
        (planner.plan_fft_forward(n), planner.plan_fft_inverse(n))
    }
}
