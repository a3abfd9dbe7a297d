//! Rigid indenters: height h(x, y) with its highest point at h = 0.

use super::grid::Grid;
use ndarray::Array2;

/// Shape of the rigid counter-surface.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum Indenter {
    /// h = 0 everywhere.
    #[default]
    Flat,
    /// A Hertzian tip h = -r^2/(2R) about the middle of the cell (for a line cell a cylinder).
    Hertz {
        /// Radius of curvature R.
        radius: f64,
    },
}

impl Indenter {
    /// Height field of shape (ny, nx), or `None` where it is zero everywhere.
    pub fn height(&self, grid: &Grid) -> Option<Array2<f64>> {
        match *self {
            Indenter::Flat => None,
            Indenter::Hertz { radius } => Some(Array2::from_shape_fn(grid.shape(), |(j, i)| {
                let (x, y) = (centred(i, grid.nx), centred(j, grid.ny));
                -(x * x + y * y) * grid.spacing().powi(2) / (2.0 * radius)
            })),
        }
    }
}

/// Index distance from the middle point of `n` points (0 for a single point).
fn centred(i: usize, n: usize) -> f64 {
    i as f64 - (n / 2) as f64
}
