//! Krylov methods: conjugate gradients that notice negative curvature, and minimal residuals for
//! matrices that are neither positive nor symmetric.

use super::dense::{add, dot, norm, project_out, scale};
use super::threads::Cancel;

/// Why the iteration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CgEnd {
    /// Residual below the asked share of the right-hand side.
    Converged,
    /// The solution would be longer than allowed: it ends on the edge.
    Edge,
    /// A direction p with p A p <= 0: the matrix is not positive definite. Within a radius the
    /// solution ends on its edge, along p.
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
    /// Longest solution (T. Steihaug, SIAM J. Numer. Anal. 20, 626 (1983)).
    pub radius: f64,
}

impl CgLimits {
    /// With solutions of any length.
    pub fn new(tolerance: f64, products: usize) -> Self {
        Self {
            tolerance,
            products,
            radius: f64::INFINITY,
        }
    }
}

/// `x` + t p with t > 0 and norm `radius`, no less than that of `x`.
fn go_to_edge(x: &mut [f64], p: &[f64], radius: f64) {
    let (pp, xp, xx) = (dot(p, p), dot(x, p), dot(x, x));
    let t = (-xp + (xp * xp + pp * (radius * radius - xx).max(0.0)).sqrt()) / pp;
    add(x, t, p);
}

/// Solves A x = b from x = 0 for a symmetric A given by `apply`, with the approximate inverse
/// `precondition` (symmetric positive definite) and in the complement of the orthonormal `removed`
/// directions.
///
/// At negative curvature the solution so far is kept (it is a descent direction, or zero), with
/// the way along it to the edge where there is a radius.
pub fn conjugate_gradients(
    mut apply: impl FnMut(&[f64], &mut [f64]),
    b: &[f64],
    mut precondition: impl FnMut(&[f64], &mut [f64]),
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
    let mut end = CgEnd::Budget;
    for _ in 0..limits.products {
        if cancel.requested() {
            end = CgEnd::Cancelled;
            break;
        }
        apply(&p, &mut ap);
        project_out(&mut ap, removed);
        let curvature = dot(&p, &ap);
        // NaN must not pass as positive.
        if !(curvature > 0.0) {
            if limits.radius.is_finite() {
                go_to_edge(&mut x, &p, limits.radius);
            }
            end = CgEnd::NegativeCurvature;
            break;
        }
        let alpha = rz / curvature;
        if limits.radius.is_finite() {
            let after = dot(&x, &x) + alpha * (2.0 * dot(&x, &p) + alpha * dot(&p, &p));
            if after >= limits.radius * limits.radius {
                go_to_edge(&mut x, &p, limits.radius);
                end = CgEnd::Edge;
                break;
            }
        }
        add(&mut x, alpha, &p);
        add(&mut r, -alpha, &ap);
        if norm(&r) <= goal {
            end = CgEnd::Converged;
            break;
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
    CgSolution { x, end }
}

/// Solves A x = b from x = 0 for any regular A given by `apply`: least residual over the space of
/// all directions so far (Y. Saad and M. H. Schultz, SIAM J. Sci. Stat. Comput. 7, 856 (1986)),
/// with the approximate inverse `precondition` on the right. Returns the solution, or as far as it
/// came, and its residual over that of zero.
pub fn minimal_residual(
    mut apply: impl FnMut(&[f64], &mut [f64]),
    b: &[f64],
    precondition: impl Fn(&[f64], &mut [f64]),
    limits: CgLimits,
    cancel: &Cancel,
) -> (Vec<f64>, f64) {
    let (n, size) = (b.len(), norm(b));
    let mut x = vec![0.0; n];
    if !(size > 0.0) {
        return (x, 0.0);
    }
    let mut basis = vec![b.iter().map(|b| b / size).collect::<Vec<_>>()];
    // The upper triangle R of the Hessenberg matrix by columns, the rotations that made it, and the
    // right-hand side rotated with it: its last entry is the residual.
    let (mut columns, mut rotations): (Vec<Vec<f64>>, Vec<[f64; 2]>) = (Vec::new(), Vec::new());
    let mut rhs = vec![size];
    let (mut direction, mut image) = (vec![0.0; n], vec![0.0; n]);
    while columns.len() < limits.products && rhs[columns.len()].abs() > limits.tolerance * size {
        if cancel.requested() {
            break;
        }
        let k = columns.len();
        precondition(&basis[k], &mut direction);
        apply(&direction, &mut image);
        let mut column = Vec::with_capacity(k + 2);
        for v in &basis {
            let along = dot(v, &image);
            add(&mut image, -along, v);
            column.push(along);
        }
        let left = norm(&image);
        for (i, [cos, sin]) in rotations.iter().enumerate() {
            let (a, b) = (column[i], column[i + 1]);
            (column[i], column[i + 1]) = (cos * a + sin * b, cos * b - sin * a);
        }
        let radius = column[k].hypot(left);
        if !(radius > 0.0) {
            break;
        }
        let [cos, sin] = [column[k] / radius, left / radius];
        column[k] = radius;
        rhs.push(-sin * rhs[k]);
        rhs[k] *= cos;
        rotations.push([cos, sin]);
        columns.push(column);
        let mut next = std::mem::replace(&mut image, vec![0.0; n]);
        scale(&mut next, 1.0 / left);
        basis.push(next);
        if !(left > 0.0) {
            break;
        }
    }
    let steps = columns.len();
    let mut y = rhs[..steps].to_vec();
    for i in (0..steps).rev() {
        y[i] /= columns[i][i];
        for j in 0..i {
            y[j] -= columns[i][j] * y[i];
        }
    }
    direction.fill(0.0);
    for (y, v) in y.iter().zip(&basis) {
        add(&mut direction, *y, v);
    }
    precondition(&direction, &mut x);
    (x, rhs[steps].abs() / size)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// A random matrix, neither symmetric nor positive, is solved in as many products as it has
        /// rows.
        #[test]
        fn any_regular_matrix_is_solved(
            entries in prop::collection::vec(-1.0..1.0_f64, 64), x in prop::collection::vec(-1.0..1.0_f64, 8),
        ) {
            // Diagonally dominant with signs that differ.
            let at = |i: usize, j: usize| {
                entries[8 * i + j] + if i == j { [9.0, -9.0][i % 2] } else { 0.0 }
            };
            let product = |x: &[f64], out: &mut [f64]| {
                for (i, out) in out.iter_mut().enumerate() {
                    *out = (0..8).map(|j| at(i, j) * x[j]).sum();
                }
            };
            let mut b = vec![0.0; 8];
            product(&x, &mut b);
            let halved = |r: &[f64], out: &mut [f64]| out.iter_mut().zip(r).for_each(|(o, r)| *o = 0.5 * r);
            let limits = CgLimits::new(1e-12, 8);
            let (found, residual) = minimal_residual(product, &b, halved, limits, &Cancel::default());
            prop_assert!(residual < 1e-10, "{residual}");
            prop_assert!(found.iter().zip(&x).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?} {x:?}");
        }
    }
}
