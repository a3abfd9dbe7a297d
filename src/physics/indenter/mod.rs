//! Rigid indenters: height h(x, y) with its highest point at h = 0.
//!
//! A new ground is one file with a [`Ground`] and an [`Own`], its `mod` and its line in `kinds!`.

mod hertz;
mod measured;
mod rough;
mod wave;

pub use rough::WAVES_MAX;

use super::law::Law;
use super::mesh::Grid;
use super::parameter::{Own, Parameter, Refusal, Value, kinds};
use ndarray::Array2;
use std::f64::consts::TAU;

kinds! {
    /// Shape of the rigid counter-surface.
    #[derive(Clone, Debug, PartialEq)]
    Indenter: ground -> Ground [Flat = "flat"]
    hertz::Hertz = "hertz",
    wave::Wave = "wave",
    rough::Rough = "rough",
    measured::Measured = "measured"
}

/// What a ground says of itself.
pub trait Ground {
    /// Its name on the screen.
    fn name(&self) -> &'static str;

    /// Height, 0 to 1, of a sketch of its kind at a share of the width; here of any uneven ground.
    fn outline(&self, share: f64) -> f64 {
        let waves = [
            (1.0, 0.30, 0.3),
            (2.0, 0.17, 2.1),
            (5.0, 0.11, 4.0),
            (9.0, 0.08, 1.2),
        ];
        let heights = waves.map(|(k, height, phase)| height * (TAU * k * share + phase).sin());
        0.5 + heights.iter().sum::<f64>()
    }

    /// The same kind with numbers that suit a law and a mesh.
    fn suited(&self, law: &Law, grid: &Grid) -> Indenter;

    /// Height at (x, y) from the middle of a cell of side `length`; at most 0. All lengths.
    fn at(&self, x: f64, y: f64, length: f64) -> f64;

    /// Height field (length) of shape (ny, nx), or `None` where it is zero everywhere; its middle
    /// on the point (n/2, n/2).
    fn height(&self, grid: &Grid) -> Option<Array2<f64>> {
        Some(sampled(
            grid,
            grid.shape(),
            |i, n| i as f64 - (n / 2) as f64,
            |x, y| self.at(x, y, grid.length),
        ))
    }

    /// [`Indenter::even_height`] of even ground.
    fn even_height(&self, grid: &Grid) -> Option<Array2<f64>> {
        let shape = (grid.ny.div_ceil(2), grid.nx / 2);
        let place = |i: usize, n: usize| if n == 1 { 0.0 } else { i as f64 + 0.5 };
        Some(sampled(grid, shape, place, |x, y| {
            self.at(x, y, grid.length)
        }))
    }

    /// True if h(-x, y) = h(x, -y) = h(x, y) about the middle of the cell.
    fn is_even(&self) -> bool {
        true
    }

    /// Points along a side that show its shape in a cell of side `length`; 0 where any will do.
    fn points_needed(&self, _length: f64) -> usize {
        0
    }

    /// Along which of x and y it is the same everywhere, so that patterns can slide.
    fn is_uniform(&self) -> [bool; 2] {
        [false; 2]
    }

    /// True if it has one crest in a square cell: then nothing tells its sides apart. Two crests
    /// may take turns.
    fn has_one_crest(&self) -> bool {
        false
    }

    /// True if a loop is driven down to zero load, and not to a depth.
    fn turns_at_zero_load(&self) -> bool {
        false
    }

    /// Depth of its mean height below the crest, or of what a contact presses in at zero load
    /// (length): it scales pictures. 0 on flat ground.
    fn relief(&self, law: &Law) -> f64;

    /// Largest mean stress (E*) to be expected, if anything is known of it.
    fn pull_off(&self, _law: &Law, _grid: &Grid) -> Option<f64> {
        None
    }

    /// Side of the only cell that it repeats in (length); `None` where any will do.
    fn period(&self) -> Option<f64> {
        None
    }

    /// Checks it in a cell of side `length`.
    ///
    /// # Errors
    /// The first value that is not allowed.
    fn check_in(&self, _length: f64) -> Result<(), Refusal> {
        Ok(())
    }

    /// Checks that a mesh can be found for it.
    ///
    /// # Errors
    /// The first value that is not allowed with `cell.points = "auto"`.
    fn check_auto(&self) -> Result<(), Refusal> {
        Ok(())
    }

    /// Checks it on a mesh.
    ///
    /// # Errors
    /// The first value that is not allowed.
    fn check_on(&self, _grid: &Grid) -> Result<(), Refusal> {
        Ok(())
    }

    /// What a mesh cannot show of it, in words.
    fn left_out(&self, _grid: &Grid) -> Option<String> {
        None
    }
}

/// Flat ground, h = 0 everywhere.
struct Flat;

impl Ground for Flat {
    fn name(&self) -> &'static str {
        "flat"
    }

    fn outline(&self, _share: f64) -> f64 {
        0.45
    }

    fn suited(&self, _law: &Law, _grid: &Grid) -> Indenter {
        Indenter::Flat
    }

    fn at(&self, _x: f64, _y: f64, _length: f64) -> f64 {
        0.0
    }

    fn height(&self, _grid: &Grid) -> Option<Array2<f64>> {
        None
    }

    fn even_height(&self, _grid: &Grid) -> Option<Array2<f64>> {
        None
    }

    fn is_uniform(&self) -> [bool; 2] {
        [true; 2]
    }

    fn relief(&self, _law: &Law) -> f64 {
        0.0
    }
}

impl Indenter {
    /// Height field h <= 0 (length) of shape (ny, nx), or `None` where it is zero everywhere.
    pub fn height(&self, grid: &Grid) -> Option<Array2<f64>> {
        self.ground().height(grid)
    }

    /// The same on the even part of the cell, whose corner is the middle: there the apex lies half
    /// a spacing off the points.
    ///
    /// # Panics
    /// On ground that is not [`Ground::is_even`].
    pub fn even_height(&self, grid: &Grid) -> Option<Array2<f64>> {
        let ground = self.ground();
        assert!(ground.is_even(), "a {} surface is not even", ground.name());
        ground.even_height(grid)
    }
}

/// A height at every point of a mesh of this shape, `place` telling how many spacings a point lies
/// from the middle.
fn sampled(
    grid: &Grid,
    shape: (usize, usize),
    place: impl Fn(usize, usize) -> f64,
    height: impl Fn(f64, f64) -> f64,
) -> Array2<f64> {
    Array2::from_shape_fn(shape, |(j, i)| {
        height(
            place(i, shape.1) * grid.spacing(),
            place(j, shape.0) * grid.spacing(),
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flat_ground_has_no_height_field() {
        assert_eq!(Indenter::Flat.height(&Grid::square(1.0, 8)), None);
        assert_eq!(Indenter::Flat.even_height(&Grid::square(1.0, 8)), None);
    }

    #[test]
    fn the_even_part_of_a_wave_is_the_wave_between_the_points() {
        let grid = Grid::square(8.0, 16);
        let wave = Indenter::Wave(Wave {
            amplitude: 0.5,
            periods: [1, 2],
        });
        let (even, whole) = (
            wave.even_height(&grid).unwrap(),
            wave.height(&Grid::square(8.0, 32)).unwrap(),
        );
        for ((j, i), h) in even.indexed_iter() {
            assert!((h - whole[[16 + 2 * j + 1, 16 + 2 * i + 1]]).abs() < 1e-15);
        }
    }
}
