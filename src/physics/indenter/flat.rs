//! Flat ground.

use super::{Ground, Indenter};
use crate::physics::grid::Grid;
use crate::physics::law::Law;
use ndarray::Array2;

/// h = 0 everywhere.
pub(super) struct Flat;

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
