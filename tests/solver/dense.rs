//! The Hessian as a dense matrix in real space, assembled from sums of cosines and the gap alone:
//! no transform, mode or vector of the solver is in it.

use nalgebra::{DMatrix, DVector};
use ndarray::Array2;
use std::f64::consts::{PI, TAU};
use tackscope::physics::law::Law;
use tackscope::physics::mesh::Grid;

/// Stiffness (E*/L) of a sliding mode below which the record leaves it out where the mesh may pin
/// patterns.
const PINNED: f64 = 0.02;

/// The Hessian per area in the metric mean(v^2), over the whole cell.
pub struct Dense {
    grid: Grid,
    kernel: Array2<f64>,
    /// The mean of the displacement is no unknown.
    fixed: bool,
}

impl Dense {
    /// With the mean displacement held by a machine of this `stiffness` (E* per length); infinite
    /// where it is fixed.
    pub fn new(grid: Grid, stiffness: f64) -> Self {
        let fixed = stiffness.is_infinite();
        let spring = if fixed { 0.0 } else { stiffness };
        let (ny, nx) = grid.shape();
        let signed = |k: usize, n: usize| {
            if 2 * k > n {
                k as f64 - n as f64
            } else {
                k as f64
            }
        };
        let cosines = |n: usize| {
            (0..n)
                .map(|i| (TAU * i as f64 / n as f64).cos())
                .collect::<Vec<_>>()
        };
        let (cx, cy) = (cosines(nx), cosines(ny));
        // Even in k and l, so that products of cosines are all that is left.
        let kernel = Array2::from_shape_fn((ny, nx), |(j, i)| {
            let mut sum = 0.0;
            for l in 0..ny {
                for k in 0..nx {
                    let q = TAU / grid.length * signed(k, nx).hypot(signed(l, ny));
                    sum += 0.5 * q * cx[(k * i) % nx] * cy[(l * j) % ny];
                }
            }
            (sum + spring) / (nx * ny) as f64
        });
        Self {
            grid,
            kernel,
            fixed,
        }
    }

    /// The matrix (E* per length) at a gap field, the uniform field, where it is fixed, and the
    /// patterns' sliding lifted out of the way.
    pub fn at(
        &self,
        gap: &Array2<f64>,
        displacement: &Array2<f64>,
        law: &Law,
        uniform: [bool; 2],
        freely: bool,
    ) -> DMatrix<f64> {
        let (ny, nx) = self.grid.shape();
        let n = nx * ny;
        let mut a = DMatrix::from_fn(n, n, |r, s| {
            self.kernel[[(r / nx + ny - s / nx) % ny, (r % nx + nx - s % nx) % nx]]
        });
        for (r, g) in gap.iter().enumerate() {
            a[(r, r)] += law.at(*g).stiffness;
        }
        // Above every eigenvalue, and no larger than needed: it costs digits.
        let far = 2.0
            * (2.0 * PI / self.grid.spacing()
                + gap
                    .iter()
                    .fold(0.0, |most: f64, g| most.max(law.at(*g).stiffness.abs())));
        let mut lifted = vec![DVector::from_element(n, (n as f64).sqrt().recip())];
        if !self.fixed {
            lifted.clear();
        }
        for axis in (0..2).filter(|&axis| uniform[axis]) {
            let mut slide = derivative(displacement, axis);
            for known in &lifted {
                slide -= known * known.dot(&slide);
            }
            let mean = displacement.mean().unwrap();
            let pattern = displacement
                .iter()
                .map(|u| (u - mean).powi(2))
                .sum::<f64>()
                .sqrt();
            let length = slide.norm();
            if length <= 1e-3 * pattern {
                continue;
            }
            slide /= length;
            let pinning = slide.dot(&(&a * &slide)) * self.grid.length;
            if freely || pinning.abs() < PINNED {
                lifted.push(slide);
            }
        }
        // P A P + far, P without the lifted vectors.
        for v in &lifted {
            let av = &a * v;
            let vav = v.dot(&av);
            a.ger(-1.0, v, &av, 1.0);
            a.ger(-1.0, &av, v, 1.0);
            a.ger(vav + far, v, v, 1.0);
        }
        a
    }
}

/// The derivative of a periodic field along x (0) or y (1), in units of the first wave number,
/// exact for every wave but the shortest.
fn derivative(field: &Array2<f64>, axis: usize) -> DVector<f64> {
    let (ny, nx) = field.dim();
    let n = [nx, ny][axis];
    let weight = |d: usize| {
        if d == 0 {
            0.0
        } else {
            0.5 * f64::powi(-1.0, d as i32) / (PI * d as f64 / n as f64).tan()
        }
    };
    DVector::from_iterator(
        nx * ny,
        (0..nx * ny).map(|r| {
            let (j, i) = (r / nx, r % nx);
            let at = |m: usize| {
                if axis == 0 {
                    field[[j, m]]
                } else {
                    field[[m, i]]
                }
            };
            (0..n)
                .map(|m| weight(([i, j][axis] + n - m) % n) * at(m))
                .sum()
        }),
    )
}
