//! The elastic body that carries the surface: how stiffly it holds each wave and the mean.
//!
//! All that the mechanics know of a body is one stiffness per wave, which takes the place of q E*/2
//! everywhere. A new body is one file with an [`Elastic`] and an [`Own`], its `mod` and its line in
//! `kinds!`.

mod layer;

use super::mesh::Grid;
use super::parameter::{Own, Parameter, Refusal, Value, kinds};
use std::f64::consts::PI;

kinds! {
    /// The elastic body, of contact modulus E* = 1.
    #[derive(Clone, Copy, Debug, PartialEq)]
    Body: elastic -> Elastic [HalfSpace = "half_space"]
    layer::Layer = "layer"
}

/// What a body says of itself.
pub trait Elastic {
    /// Its name on the screen.
    fn name(&self) -> &'static str;

    /// The same kind with numbers that suit a mesh.
    fn suited(&self, grid: &Grid) -> Body;

    /// Stiffness (E* per length) of a wave of wave number `q` > 0 (per length): the amplitude of
    /// the traction over that of the displacement. At least q E*/2, that of a half-space.
    fn stiffness(&self, q: f64) -> f64;

    /// Stiffness (E* per length) of the mean displacement against what the machine holds; infinite
    /// where that is the mean displacement itself.
    fn mean_stiffness(&self) -> f64;

    /// Checks it under a cell of side `length`.
    ///
    /// # Errors
    /// The first value that is not allowed.
    fn check_in(&self, _length: f64) -> Result<(), Refusal> {
        Ok(())
    }
}

/// The half-space: its mean displacement is measured against nothing, and is what is driven.
struct HalfSpace;

impl Elastic for HalfSpace {
    fn name(&self) -> &'static str {
        "half-space"
    }

    fn suited(&self, _grid: &Grid) -> Body {
        Body::HalfSpace
    }

    fn stiffness(&self, q: f64) -> f64 {
        q / 2.0
    }

    fn mean_stiffness(&self) -> f64 {
        f64::INFINITY
    }
}

impl Body {
    /// The side (length) of the cell in which the longest wave of a half-space, of stiffness pi
    /// E*/L, is as stiff as a wave of this body with so many `periods` along a side of the cell.
    pub fn equivalent(&self, grid: &Grid, periods: f64) -> f64 {
        match self {
            Body::HalfSpace => grid.length / periods,
            _ => PI / self.elastic().stiffness(grid.q1() * periods),
        }
    }

    /// The same of the softest wave of a mesh: the length of the cell itself for a half-space, less
    /// for a layer.
    pub fn equivalent_length(&self, grid: &Grid) -> f64 {
        let mut longest = 0.0;
        for k in 1..=grid.nx / 2 {
            let waves = (0..=k.min(grid.ny / 2)).map(|l| (k as f64).hypot(l as f64));
            for periods in waves {
                // No wave is softer than that of a half-space.
                if grid.length / periods <= longest {
                    break;
                }
                longest = self.equivalent(grid, periods).max(longest);
            }
        }
        longest
    }

    /// True if the longest waves of the cell are its softest.
    pub fn is_softest_at_its_longest(&self, grid: &Grid) -> bool {
        self.equivalent(grid, 1.0) >= self.equivalent_length(grid)
    }
}
