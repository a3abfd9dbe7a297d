//! Preconditioned conjugate gradients that notice negative curvature.

use super::cancel::Cancel;
use super::vector::{add, dot, norm, project_out};

/// Why the iteration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CgEnd {
    /// Residual below the asked share of the right-hand side.
    Converged,
    /// A direction p with p A p <= 0: the matrix is not positive definite.
    NegativeCurvature,
    /// Budget spent.
    Budget,
    /// Somebody asked to stop.
    Cancelled,
}

/// What one solve found.
#[derive(Clone, Debug)]
pub struct CgSolution {
    /// The solution, or as far as it came.
    pub x: Vec<f64>,
    /// The last search direction; after [`CgEnd::NegativeCurvature`] the one of negative curvature,
    /// downhill from `x`.
    pub direction: Vec<f64>,
    /// Why it ended.
    pub end: CgEnd,
}

/// Limits of one solve.
#[derive(Clone, Copy, Debug)]
pub struct CgLimits {
    /// Residual over right-hand side at which to stop.
    pub tolerance: f64,
    /// Most products with the matrix.
    pub products: usize,
}

/// Solves A x = b from x = 0 for a symmetric A given by `apply`, with the approximate inverse
/// `precondition` (symmetric positive definite) and in the complement of the orthonormal `removed`
/// directions.
///
/// At negative curvature the solution so far is kept (it is a descent direction, or zero).
pub fn conjugate_gradients(
    mut apply: impl FnMut(&[f64], &mut [f64]),
    b: &[f64],
    precondition: impl Fn(&[f64], &mut [f64]),
    removed: &[Vec<f64>],
    limits: CgLimits,
    cancel: &Cancel,
) -> CgSolution {
    let n = b.len();
    let mut x = vec![0.0; n];
    let mut r = b.to_vec();
    project_out(&mut r, removed);
    let mut z = vec![0.0; n];
    precondition(&r, &mut z);
    project_out(&mut z, removed);
    let mut p = z.clone();
    let mut ap = vec![0.0; n];
    let mut rz = dot(&r, &z);
    let goal = limits.tolerance * norm(&r);
    for _ in 0..limits.products {
        if cancel.requested() {
            return CgSolution {
                x,
                direction: p,
                end: CgEnd::Cancelled,
            };
        }
        apply(&p, &mut ap);
        project_out(&mut ap, removed);
        let curvature = dot(&p, &ap);
        // NaN must not pass as positive.
        if !(curvature > 0.0) {
            return CgSolution {
                x,
                direction: p,
                end: CgEnd::NegativeCurvature,
            };
        }
        let alpha = rz / curvature;
        add(&mut x, alpha, &p);
        add(&mut r, -alpha, &ap);
        if norm(&r) <= goal {
            return CgSolution {
                x,
                direction: p,
                end: CgEnd::Converged,
            };
        }
        precondition(&r, &mut z);
        project_out(&mut z, removed);
        let rz_new = dot(&r, &z);
        let beta = rz_new / rz;
        rz = rz_new;
        for (p, z) in p.iter_mut().zip(&z) {
            *p = z + beta * *p;
        }
    }
    CgSolution {
        x,
        direction: p,
        end: CgEnd::Budget,
    }
}
