//! Smallest eigenpairs of a symmetric operator: block LOBPCG, and Jacobi rotations for the small dense problem inside.

use super::cancel::Cancel;
use super::vector::{add, dot, norm, orthonormalise, project_out};

/// Approximate eigenpairs, smallest first.
#[derive(Clone, Debug, Default)]
pub struct EigenPairs {
    /// Rayleigh quotients; each is an upper bound of the eigenvalue of the same rank.
    pub values: Vec<f64>,
    /// Orthonormal vectors.
    pub vectors: Vec<Vec<f64>>,
    /// |A x - value x| of the first pair: some eigenvalue lies within it of the first value.
    pub residual: f64,
    /// Products with the operator spent.
    pub products: usize,
}

/// Budget of one call of [`smallest`].
#[derive(Clone, Copy, Debug)]
pub struct EigenLimits {
    /// Pairs wanted; only their residuals are iterated on. Further start vectors only widen the first subspace.
    pub pairs: usize,
    /// Iterations that are always done (unless the residual vanishes).
    pub least: usize,
    /// Iterations that are done while the first residual is above `relative` x |value|, or above `absolute`.
    pub most: usize,
    /// Goal for residual over |value|.
    pub relative: f64,
    /// A residual below this is good enough in any case.
    pub absolute: f64,
}

/// Block LOBPCG from the vectors `start`, orthogonal to the orthonormal vectors `removed`.
///
/// A. V. Knyazev, SIAM J. Sci. Comput. 23, 517 (2001), with an orthonormalised basis (robust against nearly dependent vectors).
/// `precondition` is an approximate inverse, symmetric positive definite.
pub fn smallest(
    mut apply: impl FnMut(&[f64], &mut [f64]),
    start: Vec<Vec<f64>>,
    removed: &[Vec<f64>],
    precondition: impl Fn(&[f64], &mut [f64]),
    limits: EigenLimits,
    cancel: &Cancel,
) -> EigenPairs {
    let mut products = 0;
    let mut image = |v: &Vec<f64>| {
        products += 1;
        let mut out = vec![0.0; v.len()];
        apply(v, &mut out);
        project_out(&mut out, removed);
        out
    };
    let start = start
        .into_iter()
        .map(|mut v| {
            project_out(&mut v, removed);
            v
        })
        .collect();
    let basis = orthonormalise(start, 1e-10);
    let images: Vec<_> = basis.iter().map(&mut image).collect();
    let (mut values, rotation) = rayleigh_ritz(&basis, &images);
    let pairs = limits.pairs.min(basis.len());
    let mut x = combine(&basis, &rotation, pairs);
    let mut ax = combine(&images, &rotation, pairs);
    let mut p: Vec<Vec<f64>> = Vec::new();
    let mut residual = f64::INFINITY;
    for iteration in 0..=limits.most {
        let mut w: Vec<Vec<f64>> = Vec::new();
        for i in 0..x.len() {
            let mut r = ax[i].clone();
            add(&mut r, -values[i], &x[i]);
            if i == 0 {
                residual = norm(&r);
            }
            let mut step = vec![0.0; r.len()];
            precondition(&r, &mut step);
            project_out(&mut step, removed);
            w.push(step);
        }
        let good = residual <= (limits.relative * values.first().map_or(0.0, |v| v.abs())).max(limits.absolute);
        if cancel.requested() || iteration == limits.most || (good && iteration >= limits.least) {
            break;
        }
        let width = x.len();
        let basis = orthonormalise(x.iter().cloned().chain(w).chain(p).collect(), 1e-8);
        // The first `width` vectors span x itself; their images need no new product.
        let mut images = ax.clone();
        images.extend(basis[width..].iter().map(&mut image));
        let (ritz, rotation) = rayleigh_ritz(&basis, &images);
        let x_new = combine(&basis, &rotation, width);
        ax = combine(&images, &rotation, width);
        p = x_new
            .iter()
            .map(|v| {
                let mut d = v.clone();
                project_out(&mut d, &x);
                d
            })
            .collect();
        x = x_new;
        values = ritz;
    }
    values.truncate(x.len());
    EigenPairs { values, vectors: x, residual, products }
}

/// Eigen-decomposition of the operator in the span of an orthonormal basis: values ascending, and one coefficient column each.
fn rayleigh_ritz(basis: &[Vec<f64>], images: &[Vec<f64>]) -> (Vec<f64>, Vec<Vec<f64>>) {
    let n = basis.len();
    let mut a = vec![vec![0.0; n]; n];
    for i in 0..n {
        for j in 0..=i {
            let h = 0.5 * (dot(&basis[i], &images[j]) + dot(&basis[j], &images[i]));
            a[i][j] = h;
            a[j][i] = h;
        }
    }
    symmetric_eigen(a)
}

fn combine(vectors: &[Vec<f64>], rotation: &[Vec<f64>], count: usize) -> Vec<Vec<f64>> {
    rotation
        .iter()
        .take(count)
        .map(|coefficients| {
            let mut sum = vec![0.0; vectors[0].len()];
            for (c, v) in coefficients.iter().zip(vectors) {
                add(&mut sum, *c, v);
            }
            sum
        })
        .collect()
}

/// All eigenpairs of a small dense symmetric matrix by cyclic Jacobi rotations: values ascending, `vectors[k]` belonging to `values[k]`.
pub fn symmetric_eigen(mut a: Vec<Vec<f64>>) -> (Vec<f64>, Vec<Vec<f64>>) {
    let n = a.len();
    let mut v: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect()).collect();
    for _sweep in 0..60 {
        let off: f64 = (0..n).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| a[i][j] * a[i][j]).sum();
        let diagonal: f64 = (0..n).map(|i| a[i][i] * a[i][i]).sum();
        if !(off > 1e-32 * diagonal) {
            break;
        }
        for i in 1..n {
            for j in 0..i {
                rotate(&mut a, &mut v, i, j);
            }
        }
    }
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| a[i][i].total_cmp(&a[j][j]));
    (order.iter().map(|&k| a[k][k]).collect(), order.iter().map(|&k| v[k].clone()).collect())
}

/// One Jacobi rotation that annihilates a[i][j]; row k of `v` is the k-th eigenvector in the making.
fn rotate(a: &mut [Vec<f64>], v: &mut [Vec<f64>], i: usize, j: usize) {
    if a[i][j] == 0.0 {
        return;
    }
    let theta = (a[j][j] - a[i][i]) / (2.0 * a[i][j]);
    let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
    let t = if theta == 0.0 { 1.0 } else { t };
    let c = 1.0 / (t * t + 1.0).sqrt();
    let s = t * c;
    for row in a.iter_mut() {
        let (x, y) = (row[i], row[j]);
        row[i] = c * x - s * y;
        row[j] = s * x + c * y;
    }
    for k in 0..a.len() {
        let (x, y) = (a[i][k], a[j][k]);
        a[i][k] = c * x - s * y;
        a[j][k] = s * x + c * y;
        let (x, y) = (v[i][k], v[j][k]);
        v[i][k] = c * x - s * y;
        v[j][k] = s * x + c * y;
    }
}
