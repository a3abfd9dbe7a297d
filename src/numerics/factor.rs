//! Small dense symmetric matrices, factorised as L D L^T.

use super::vector::dot;

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
