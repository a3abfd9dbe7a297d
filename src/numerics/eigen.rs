//! Smallest eigenpairs of a symmetric operator: block LOBPCG, and Jacobi rotations for the small
//! dense problem inside.

use super::cancel::Cancel;
use super::vector::{add, add_all, norm, orthonormalise, products, project_out, scale};

/// Approximate eigenpairs, smallest first.
#[derive(Clone, Debug, Default)]
pub struct EigenPairs {
    /// Rayleigh quotients; each is an upper bound of the eigenvalue of the same rank.
    pub values: Vec<f64>,
    /// Orthonormal vectors.
    pub vectors: Vec<Vec<f64>>,
    /// |A x - value x| of the first pair: some eigenvalue lies within it of the first value.
    pub residual: f64,
}

/// Budget of one call of [`smallest`].
#[derive(Clone, Copy, Debug)]
pub struct EigenLimits {
    /// Pairs wanted; only their residuals are iterated on. Further start vectors only widen the
    /// first subspace.
    pub pairs: usize,
    /// Iterations that are always done (unless the residual vanishes).
    pub least: usize,
    /// Iterations that are done while the first residual is above `relative` x |value|, or above
    /// `absolute`.
    pub most: usize,
    /// Goal for residual over |value|.
    pub relative: f64,
    /// A residual below this is good enough in any case.
    pub absolute: f64,
}

/// Block LOBPCG from the vectors `start`, orthogonal to the orthonormal vectors `removed`.
///
/// A. V. Knyazev, SIAM J. Sci. Comput. 23, 517 (2001), with an orthonormalised basis (robust
/// against nearly dependent vectors). `precondition` is an approximate inverse, symmetric positive
/// definite.
pub fn smallest(
    mut apply: impl FnMut(&[f64], &mut [f64]),
    start: Vec<Vec<f64>>,
    removed: &[Vec<f64>],
    precondition: impl Fn(&[f64], &mut [f64]),
    limits: EigenLimits,
    cancel: &Cancel,
) -> EigenPairs {
    let mut image = |v: &Vec<f64>| {
        let mut out = vec![0.0; v.len()];
        apply(v, &mut out);
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
    // The subspace of the last iteration, from which the conjugate directions come, and how the
    // vectors were made of it.
    let mut last: Option<(Subspace, Vec<Vec<f64>>)> = None;
    let mut residual = f64::INFINITY;
    for iteration in 0..=limits.most {
        let error = |i: usize| {
            let mut r = ax[i].clone();
            add(&mut r, -values[i], &x[i]);
            // Images may point along removed directions; what counts is their part beside them.
            project_out(&mut r, removed);
            r
        };
        let first = (!x.is_empty()).then(|| error(0));
        residual = first.as_ref().map_or(residual, |r| norm(r));
        let good = residual
            <= (limits.relative * values.first().map_or(0.0, |v| v.abs())).max(limits.absolute);
        if cancel.requested() || iteration == limits.most || (good && iteration >= limits.least) {
            break;
        }
        let errors = first.into_iter().chain((1..x.len()).map(error));
        let steps: Vec<_> = errors
            .map(|r| {
                let mut step = vec![0.0; r.len()];
                precondition(&r, &mut step);
                project_out(&mut step, removed);
                step
            })
            .collect();
        let width = x.len();
        let conjugate = last
            .take()
            .map(|(space, rotation)| space.conjugate(&rotation, width))
            .unwrap_or_default();
        let mut space = Subspace {
            basis: x,
            images: ax,
        };
        for v in steps {
            space.add(v, None, &mut image);
        }
        for (v, av) in conjugate {
            space.add(v, Some(av), &mut image);
        }
        let rotation;
        (values, rotation) = rayleigh_ritz(&space.basis, &space.images);
        x = combine(&space.basis, &rotation, width);
        ax = combine(&space.images, &rotation, width);
        last = Some((space, rotation));
    }
    values.truncate(x.len());
    EigenPairs {
        values,
        vectors: x,
        residual,
    }
}

/// An orthonormal basis with its images under the operator.
struct Subspace {
    basis: Vec<Vec<f64>>,
    images: Vec<Vec<f64>>,
}

impl Subspace {
    /// What the first `width` Ritz vectors owe to the part outside the first `width` vectors, with
    /// its image.
    fn conjugate(&self, rotation: &[Vec<f64>], width: usize) -> Vec<(Vec<f64>, Vec<f64>)> {
        if self.basis.len() == width {
            return Vec::new();
        }
        let outside = |vectors: &[Vec<f64>]| {
            let rotation: Vec<_> = rotation.iter().map(|c| c[width..].to_vec()).collect();
            combine(&vectors[width..], &rotation, width)
        };
        outside(&self.basis)
            .into_iter()
            .zip(outside(&self.images))
            .collect()
    }

    /// Adds the part of `v` that is new, unless it is nearly nothing. A known image is carried
    /// along, which saves a product.
    fn add(
        &mut self,
        mut v: Vec<f64>,
        known: Option<Vec<f64>>,
        image: &mut impl FnMut(&Vec<f64>) -> Vec<f64>,
    ) {
        let before = norm(&v);
        let mut carried = known;
        for _twice in 0..2 {
            let along: Vec<f64> = products(&self.basis, std::slice::from_ref(&v))
                .iter()
                .map(|c| -c[0])
                .collect();
            add_all(&mut v, &along, &self.basis);
            if let Some(av) = &mut carried {
                add_all(av, &along, &self.images);
            }
        }
        let after = norm(&v);
        // A carried image loses digits to cancellation: it is dropped earlier than a fresh vector.
        let tiny = if carried.is_some() { 1e-5 } else { 1e-10 };
        if !(after > tiny * before) {
            return;
        }
        scale(&mut v, 1.0 / after);
        let av = match carried {
            Some(mut av) => {
                scale(&mut av, 1.0 / after);
                av
            }
            None => image(&v),
        };
        self.basis.push(v);
        self.images.push(av);
    }
}

/// Eigen-decomposition of the operator in the span of an orthonormal basis: values ascending, and
/// one coefficient column each.
fn rayleigh_ritz(basis: &[Vec<f64>], images: &[Vec<f64>]) -> (Vec<f64>, Vec<Vec<f64>>) {
    let a = products(basis, images);
    let symmetric = |i: usize, j: usize| 0.5 * (a[i][j] + a[j][i]);
    symmetric_eigen(
        (0..a.len())
            .map(|i| (0..a.len()).map(|j| symmetric(i, j)).collect())
            .collect(),
    )
}

fn combine(vectors: &[Vec<f64>], rotation: &[Vec<f64>], count: usize) -> Vec<Vec<f64>> {
    rotation
        .iter()
        .take(count)
        .map(|coefficients| {
            let mut sum = vec![0.0; vectors.first().map_or(0, Vec::len)];
            add_all(&mut sum, coefficients, vectors);
            sum
        })
        .collect()
}

/// All eigenpairs of a small dense symmetric matrix by cyclic Jacobi rotations: values ascending,
/// `vectors[k]` belonging to `values[k]`.
pub fn symmetric_eigen(mut a: Vec<Vec<f64>>) -> (Vec<f64>, Vec<Vec<f64>>) {
    let n = a.len();
    let mut v: Vec<Vec<f64>> = (0..n)
        .map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect())
        .collect();
    for _sweep in 0..60 {
        let off: f64 = (0..n)
            .flat_map(|i| (0..i).map(move |j| (i, j)))
            .map(|(i, j)| a[i][j] * a[i][j])
            .sum();
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
    (
        order.iter().map(|&k| a[k][k]).collect(),
        order.iter().map(|&k| v[k].clone()).collect(),
    )
}

/// One Jacobi rotation that annihilates a[i][j]; row k of `v` is the k-th eigenvector in the
/// making.
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
