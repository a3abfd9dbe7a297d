//! Rigid indenters: height h(x, y) with its highest point at h = 0.

use super::grid::Grid;
use super::roughness::Roughness;
use ndarray::Array2;
use std::f64::consts::TAU;

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
    /// Sinusoidal waves, h = -amplitude sum_i (1 - cos(2 pi periods_i r_i/L)), a crest in the middle of the cell.
    Wave {
        /// Half the height from trough to crest of each wave (length).
        amplitude: f64,
        /// Waves along x and along y on the side of the cell; 0 is none.
        periods: [usize; 2],
    },
    /// A random surface.
    Rough(Roughness),
}

impl Indenter {
    /// Height field h <= 0 (length) of shape (ny, nx), or `None` where it is zero everywhere.
    pub fn height(&self, grid: &Grid) -> Option<Array2<f64>> {
        match self {
            Indenter::Rough(roughness) => Some(roughness.height(grid)),
            _ => self.height_at(grid, grid.shape(), centred),
        }
    }

    /// True if h(-x, y) = h(x, -y) = h(x, y) about the middle of the cell.
    pub fn is_even(&self) -> bool {
        !matches!(self, Indenter::Rough(_))
    }

    /// Points along a side that show its shape in a cell of side `length`; 0 where any will do.
    pub fn points_needed(&self, length: f64) -> usize {
        match *self {
            Indenter::Flat | Indenter::Hertz { .. } => 0,
            Indenter::Wave { periods: [x, y], .. } => x.max(y).saturating_mul(8),
            Indenter::Rough(roughness) => (4.0 * length / roughness.shortest).ceil() as usize,
        }
    }

    /// Along which of x and y the ground is the same everywhere, so that patterns can slide.
    pub fn is_uniform(&self) -> [bool; 2] {
        match *self {
            Indenter::Flat => [true; 2],
            Indenter::Wave { periods, .. } => periods.map(|periods| periods == 0),
            Indenter::Hertz { .. } | Indenter::Rough(_) => [false; 2],
        }
    }

    /// The same on the even part of the cell, whose corner is the middle: there the apex lies half a spacing off the points.
    ///
    /// # Panics
    /// On ground that is not [`Indenter::is_even`].
    pub fn even_height(&self, grid: &Grid) -> Option<Array2<f64>> {
        let shape = (grid.ny.div_ceil(2), grid.nx / 2);
        self.height_at(grid, shape, |i, n| if n == 1 { 0.0 } else { i as f64 + 0.5 })
    }

    fn height_at(&self, grid: &Grid, shape: (usize, usize), centred: impl Fn(usize, usize) -> f64) -> Option<Array2<f64>> {
        let field = |h: &dyn Fn(f64, f64) -> f64| {
            Some(Array2::from_shape_fn(shape, |(j, i)| {
                h(centred(i, shape.1) * grid.spacing(), centred(j, shape.0) * grid.spacing())
            }))
        };
        match *self {
            Indenter::Flat => None,
            Indenter::Hertz { radius } => field(&|x, y| -(x * x + y * y) / (2.0 * radius)),
            Indenter::Wave { amplitude, periods } => {
                let depth = |r: f64, periods: usize| 2.0 * (0.5 * TAU * periods as f64 * r / grid.length).sin().powi(2);
                field(&|x, y| -amplitude * (depth(x, periods[0]) + depth(y, periods[1])))
            }
            Indenter::Rough(_) => panic!("a rough surface is not even"),
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

    #[test]
    fn waves_have_their_crest_in_the_middle_and_their_troughs_two_amplitudes_below() {
        let grid = Grid::square(8.0, 16);
        let height = Indenter::Wave { amplitude: 0.5, periods: [2, 0] }.height(&grid).unwrap();
        assert!(height[[3, 8]] == 0.0 && height[[3, 0]].abs() < 1e-15);
        assert!((height[[5, 4]] + 1.0).abs() < 1e-15 && height[[0, 2]] < 0.0);
        assert!((height[[5, 2]] + 0.5).abs() < 1e-15);
        let both = Indenter::Wave { amplitude: 0.5, periods: [1, 1] }.height(&grid).unwrap();
        assert!((both[[0, 0]] + 2.0).abs() < 1e-15 && both.t() == both);
    }

    #[test]
    fn the_even_part_of_a_wave_is_the_wave_between_the_points() {
        let grid = Grid::square(8.0, 16);
        let wave = Indenter::Wave { amplitude: 0.5, periods: [1, 2] };
        let (even, whole) = (wave.even_height(&grid).unwrap(), wave.height(&Grid::square(8.0, 32)).unwrap());
        for ((j, i), h) in even.indexed_iter() {
            assert!((h - whole[[16 + 2 * j + 1, 16 + 2 * i + 1]]).abs() < 1e-15);
        }
    }
}
