//! The periodic cell and its mesh.

/// Largest number of points along one side.
pub const POINTS_MAX: usize = 4096;

/// A square cell of `length` x `length` with `nx` = `ny` points, or a line cell with `ny` = 1
/// (fields uniform along y).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Side L of the cell (length unit of the scene).
    pub length: f64,
    /// Points along x.
    pub nx: usize,
    /// Points along y: `nx`, or 1 for a line cell.
    pub ny: usize,
}

impl Grid {
    /// A square cell with n x n points.
    pub fn square(length: f64, n: usize) -> Self {
        Self {
            length,
            nx: n,
            ny: n,
        }
    }

    /// A line cell with n points along x and none along y.
    pub fn line(length: f64, n: usize) -> Self {
        Self {
            length,
            nx: n,
            ny: 1,
        }
    }

    /// Spacing da = L/n of the mesh.
    pub fn spacing(&self) -> f64 {
        self.length / self.nx as f64
    }

    /// Number of points.
    pub fn points(&self) -> usize {
        self.nx * self.ny
    }

    /// Shape of a field, (rows, columns) = (ny, nx).
    pub fn shape(&self) -> (usize, usize) {
        (self.ny, self.nx)
    }

    /// True for a line cell.
    pub fn is_line(&self) -> bool {
        self.ny == 1
    }

    /// The smallest non-zero wave number q1 = 2 pi / L.
    pub fn q1(&self) -> f64 {
        std::f64::consts::TAU / self.length
    }
}
