//! Dense vectors as slices, inner products and updates written so that the compiler vectorises
//! them; and small dense symmetric matrices: their factors L D L^T, and their eigenpairs.

/// Independent partial sums: enough to hide the latency of an addition in every vector width.
const LANES: usize = 8;

/// Entries of each vector that are worked on together where there are many vectors: a dozen such
/// blocks fit the first cache.
const BLOCK: usize = 256;

/// Inner product.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; LANES];
    accumulate(&mut lanes, a, b);
    let whole = a.len() - a.len() % LANES;
    let rest: f64 = a[whole..].iter().zip(&b[whole..]).map(|(x, y)| x * y).sum();
    lanes.iter().sum::<f64>() + rest
}

/// Adds the products of whole groups of entries to the partial sums.
fn accumulate(lanes: &mut [f64; LANES], a: &[f64], b: &[f64]) {
    for (x, y) in a.chunks_exact(LANES).zip(b.chunks_exact(LANES)) {
        for l in 0..LANES {
            lanes[l] += x[l] * y[l];
        }
    }
}

/// All inner products of the vectors `a` (rows) with the vectors `b` (columns): the same as by
/// [`dot`] to the last bit, in one pass over memory.
pub fn products<A: AsRef<[f64]>, B: AsRef<[f64]>>(a: &[A], b: &[B]) -> Vec<Vec<f64>> {
    let length = a.first().map_or(0, |a| a.as_ref().len());
    let whole = length - length % LANES;
    let mut lanes = vec![vec![[0.0; LANES]; b.len()]; a.len()];
    for start in (0..whole).step_by(BLOCK) {
        let range = start..(start + BLOCK).min(whole);
        for (a, lanes) in a.iter().zip(&mut lanes) {
            for (b, lanes) in b.iter().zip(lanes) {
                accumulate(
                    lanes,
                    &a.as_ref()[range.clone()],
                    &b.as_ref()[range.clone()],
                );
            }
        }
    }
    let rest = |a: &[f64], b: &[f64]| {
        a[whole..]
            .iter()
            .zip(&b[whole..])
            .map(|(x, y)| x * y)
            .sum::<f64>()
    };
    let rows = a.iter().zip(&lanes);
    rows.map(|(a, lanes)| {
        b.iter()
            .zip(lanes)
            .map(|(b, lanes)| lanes.iter().sum::<f64>() + rest(a.as_ref(), b.as_ref()))
            .collect()
    })
    .collect()
}

/// y += sum of `coefficients` x `vectors`, in one pass over memory.
pub fn add_all(y: &mut [f64], coefficients: &[f64], vectors: &[Vec<f64>]) {
    for (block, y) in y.chunks_mut(BLOCK).enumerate() {
        for (c, v) in coefficients.iter().zip(vectors) {
            add(y, *c, &v[block * BLOCK..block * BLOCK + y.len()]);
        }
    }
}

/// Euclidean norm.
pub fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// y += s x.
pub fn add(y: &mut [f64], s: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += s * x;
    }
}

/// Cubic Hermite between two ends a distance `h` apart, at a share `t` of the way (beyond them
/// too): of value and derivative at the first, and value and derivative at the second.
pub fn hermite(ends: [&[f64]; 4], h: f64, t: f64) -> Vec<f64> {
    let (t2, t3) = (t * t, t * t * t);
    let weights = [
        2.0 * t3 - 3.0 * t2 + 1.0,
        (t3 - 2.0 * t2 + t) * h,
        3.0 * t2 - 2.0 * t3,
        (t3 - t2) * h,
    ];
    let mut sum = vec![0.0; ends[0].len()];
    for (weight, end) in weights.into_iter().zip(ends) {
        add(&mut sum, weight, end);
    }
    sum
}

/// x *= s.
pub fn scale(x: &mut [f64], s: f64) {
    x.iter_mut().for_each(|x| *x *= s);
}

/// Removes from `x` its components along the orthonormal vectors `basis`.
pub fn project_out(x: &mut [f64], basis: &[Vec<f64>]) {
    if !basis.is_empty() {
        let along: Vec<f64> = products(basis, &[&*x]).iter().map(|c| -c[0]).collect();
        add_all(x, &along, basis);
    }
}

/// Orthonormalises `vectors` in order (twice-applied Gram-Schmidt), dropping those that add less
/// than `tiny` of their length.
pub fn orthonormalise(vectors: Vec<Vec<f64>>, tiny: f64) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::with_capacity(vectors.len());
    for mut v in vectors {
        let before = norm(&v);
        project_out(&mut v, &basis);
        project_out(&mut v, &basis);
        let after = norm(&v);
        if after > tiny * before {
            scale(&mut v, 1.0 / after);
            basis.push(v);
        }
    }
    basis
}

/// Largest absolute value; NaN if any entry is NaN (`fold(f64::max)` would swallow it).
pub fn max_abs(x: &[f64]) -> f64 {
    let mut largest = 0.0_f64;
    for &v in x {
        if v.is_nan() {
            return v;
        }
        largest = largest.max(v.abs());
    }
    largest
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

/// The factors of a symmetric matrix, pivots in the order of its rows; empty until
/// [`Factor::factorise`].
///
/// Negative pivots, as many as the matrix has negative eigenvalues (Sylvester's law of inertia),
/// are kept as they are, so that the factors serve two ends: the matrix itself, and |matrix| = L
/// |D| L^T, which is positive and so a preconditioner.
#[derive(Clone, Debug, Default)]
pub struct Factor {
    /// L below the diagonal, D on it; row by row, 1 + 2 + ... + n entries.
    rows: Vec<f64>,
    size: usize,
    negative: usize,
}

impl Factor {
    /// Factorises the matrix of `size` whose lower triangle is `lower`, row by row. Pivots smaller
    /// than `floor` are taken for `floor`, which bounds the inverse along a vector that the matrix
    /// nearly annihilates.
    pub fn factorise(&mut self, lower: &[f64], size: usize, floor: f64) {
        assert_eq!(lower.len(), start(size));
        (self.size, self.negative) = (size, 0);
        self.rows.clear();
        self.rows.extend_from_slice(lower);
        // Entry j holds L_ij D_j until row i is complete.
        let mut scaled = vec![0.0; size];
        for i in 0..size {
            let (above, row) = self.rows.split_at_mut(start(i));
            for j in 0..i {
                let other = &above[start(j)..];
                scaled[j] = row[j] - dot(&scaled[..j], &other[..j]);
            }
            let mut pivot = row[i];
            for j in 0..i {
                let l = scaled[j] / above[start(j) + j];
                pivot -= l * scaled[j];
                row[j] = l;
            }
            self.negative += usize::from(pivot < 0.0);
            row[i] = if pivot.abs() < floor { floor } else { pivot };
        }
    }

    /// Forgets the matrix.
    pub fn clear(&mut self) {
        self.rows.clear();
        (self.size, self.negative) = (0, 0);
    }

    /// Rows of the matrix.
    pub fn size(&self) -> usize {
        self.size
    }

    /// True while there is no matrix.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Number of negative pivots, as they came before the floor.
    pub fn negative(&self) -> usize {
        self.negative
    }

    /// x = A^-1 x in place, for the matrix A itself.
    pub fn solve(&self, x: &mut [f64]) {
        self.forward(x);
        self.divide(x, |pivot| pivot);
        self.backward(x);
    }

    /// x = |A|^-1 x in place.
    pub fn solve_positive(&self, x: &mut [f64]) {
        self.forward(x);
        self.divide(x, f64::abs);
        self.backward(x);
    }

    /// x = F x in place, for the factors F F^T = |A|^-1.
    pub fn spread(&self, x: &mut [f64]) {
        self.divide(x, |pivot| pivot.abs().sqrt());
        self.backward(x);
    }

    /// x = F^T x in place.
    pub fn gather(&self, x: &mut [f64]) {
        self.forward(x);
        self.divide(x, |pivot| pivot.abs().sqrt());
    }

    fn row(&self, i: usize) -> &[f64] {
        &self.rows[start(i)..=start(i) + i]
    }

    /// x = L^-1 x.
    fn forward(&self, x: &mut [f64]) {
        for i in 0..self.size {
            x[i] -= dot(&self.row(i)[..i], &x[..i]);
        }
    }

    fn divide(&self, x: &mut [f64], of: impl Fn(f64) -> f64) {
        for (i, x) in x.iter_mut().enumerate() {
            *x /= of(self.row(i)[i]);
        }
    }

    /// x = L^-T x.
    fn backward(&self, x: &mut [f64]) {
        for i in (0..self.size).rev() {
            let xi = x[i];
            for (x, l) in x[..i].iter_mut().zip(self.row(i)) {
                *x -= l * xi;
            }
        }
    }
}

/// Entries before row `i` of a triangle.
fn start(i: usize) -> usize {
    i * (i + 1) / 2
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lower(n: usize, entry: impl Fn(usize, usize) -> f64 + Copy) -> Vec<f64> {
        (0..n)
            .flat_map(|i| (0..=i).map(move |j| entry(i, j)))
            .collect()
    }

    fn of(n: usize, entry: impl Fn(usize, usize) -> f64 + Copy) -> Factor {
        let mut factor = Factor::default();
        factor.factorise(&lower(n, entry), n, 0.0);
        factor
    }

    #[test]
    fn the_solution_of_a_hilbert_matrix_is_found() {
        let n = 5;
        let entry = |i: usize, j: usize| 1.0 / (i + j + 1) as f64;
        let x = [1.0, -2.0, 0.5, 3.0, -1.0];
        let mut b: Vec<f64> = (0..n)
            .map(|i| (0..n).map(|j| entry(i, j) * x[j]).sum())
            .collect();
        let factor = of(n, entry);
        factor.solve(&mut b);
        assert_eq!(factor.negative(), 0);
        // Condition 5e5.
        assert!(b.iter().zip(x).all(|(b, x)| (b - x).abs() < 1e-10), "{b:?}");
    }

    #[test]
    fn an_indefinite_matrix_has_as_many_negative_pivots_as_eigenvalues_and_both_inverses() {
        // Eigenvalues 3 and -1.
        let factor = of(2, |i, j| if i == j { 1.0 } else { 2.0 });
        assert_eq!(factor.negative(), 1);
        let mut x = [5.0, 4.0];
        factor.solve(&mut x);
        assert!(
            (x[0] - 1.0).abs() < 1e-14 && (x[1] - 2.0).abs() < 1e-14,
            "{x:?}"
        );
        // F F^T is the inverse with the pivots made positive.
        let (mut once, mut twice) = ([0.3, -0.7], [0.3, -0.7]);
        factor.solve_positive(&mut once);
        factor.gather(&mut twice);
        assert!(dot(&twice, &twice) > 0.0);
        factor.spread(&mut twice);
        assert!(
            once.iter().zip(twice).all(|(a, b)| (a - b).abs() < 1e-14),
            "{once:?} {twice:?}"
        );
    }

    #[test]
    fn a_pivot_below_the_floor_is_the_floor() {
        let mut factor = Factor::default();
        factor.factorise(&[1.0, 1.0, 1.0], 2, 0.25);
        let mut x = [0.0, 1.0];
        factor.solve(&mut x);
        assert_eq!(x, [-4.0, 4.0]);
    }
}
