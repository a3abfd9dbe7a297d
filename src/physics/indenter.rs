//! Rigid indenters: height h(x, y) with its highest point at h = 0.

use super::grid::Grid;
use ndarray::Array2;

/// Shape of the rigid counter-surface.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum Indenter {
    /// h = 0 everywhere.
    #[default]
    Flat,
    /// A Hertzian tip h = -r^2/(2R), its apex on the point (n/2, n/2) of the mesh (for a line cell a cylinder).
    Hertz {
        /// Radius of curvature R (length).
        radius: f64,
    },
}

impl Indenter {
    /// Height field h <= 0 (length) of shape (ny, nx), or `None` where it is zero everywhere.
    pub fn height(&self, grid: &Grid) -> Option<Array2<f64>> {
        self.height_at(grid.shape(), grid.spacing(), centred)
    }

    /// The same on the even part of the cell, whose corner is the middle: there the apex lies half a spacing off the points.
    pub fn even_height(&self, grid: &Grid) -> Option<Array2<f64>> {
        let shape = (grid.ny.div_ceil(2), grid.nx / 2);
        self.height_at(shape, grid.spacing(), |i, n| if n == 1 { 0.0 } else { i as f64 + 0.5 })
    }

    fn height_at(&self, shape: (usize, usize), spacing: f64, centred: impl Fn(usize, usize) -> f64) -> Option<Array2<f64>> {
        match *self {
            Indenter::Flat => None,
            Indenter::Hertz { radius } => Some(Array2::from_shape_fn(shape, |(j, i)| {
                let (x, y) = (centred(i, shape.1), centred(j, shape.0));
                -(x * x + y * y) * spacing.powi(2) / (2.0 * radius)
            })),
        }
    }
}

/// Index distance from the middle point of `n` points (0 for a single point).
fn centred(i: usize, n: usize) -> f64 {
    i as f64 - (n / 2) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flat_ground_has_no_height_field() {
        assert_eq!(Indenter::Flat.height(&Grid::square(1.0, 8)), None);
    }

    #[test]
    fn the_tip_is_highest_in_the_middle_and_falls_as_a_parabola() {
        let grid = Grid::square(2.0, 8);
        let height = Indenter::Hertz { radius: 3.0 }.height(&grid).unwrap();
        assert_eq!(height[[4, 4]], 0.0);
        assert!(height.iter().all(|&h| h <= 0.0));
        // Two and three spacings of 0.25 away: r^2 = 0.0625 (4 + 9); rounding only.
        assert!((height[[2, 7]] + 0.0625 * 13.0 / 6.0).abs() < 1e-15);
        assert_eq!(height.t(), height);
    }

    #[test]
    fn on_a_line_cell_the_tip_is_a_cylinder() {
        let grid = Grid::line(2.0, 8);
        let height = Indenter::Hertz { radius: 3.0 }.height(&grid).unwrap();
        assert_eq!(height.dim(), (1, 8));
        assert_eq!(height[[0, 4]], 0.0);
        assert!((height[[0, 0]] + 1.0 / 6.0).abs() < 1e-15);
    }
}
