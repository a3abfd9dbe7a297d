//! Small symmetric positive definite matrices.

/// Solves A x = b in place of `b`; `a` holds the lower triangle of A row by row, 1 + 2 + ... + n entries, and is overwritten by its
/// factor. `false`, with both spoilt, if A is not positive definite.
pub fn solve(a: &mut [f64], b: &mut [f64]) -> bool {
    let n = b.len();
    assert_eq!(a.len(), n * (n + 1) / 2);
    let row = |i: usize| i * (i + 1) / 2;
    for i in 0..n {
        let (before, rest) = a.split_at_mut(row(i));
        for j in 0..=i {
            let known: f64 = match j == i {
                true => rest[..i].iter().map(|l| l * l).sum(),
                false => rest[..j].iter().zip(&before[row(j)..]).map(|(x, y)| x * y).sum(),
            };
            let left = rest[j] - known;
            if j < i {
                rest[j] = left / before[row(j) + j];
            } else if left > 0.0 {
                rest[i] = left.sqrt();
            } else {
                return false;
            }
        }
    }
    for i in 0..n {
        let known: f64 = a[row(i)..row(i) + i].iter().zip(&*b).map(|(l, x)| l * x).sum();
        b[i] = (b[i] - known) / a[row(i) + i];
    }
    for i in (0..n).rev() {
        b[i] /= a[row(i) + i];
        for j in 0..i {
            b[j] -= a[row(i) + j] * b[i];
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_solution_of_a_hilbert_matrix_is_found() {
        let n = 5;
        let entry = |i: usize, j: usize| 1.0 / (i + j + 1) as f64;
        let mut a: Vec<f64> = (0..n).flat_map(|i| (0..=i).map(move |j| entry(i, j))).collect();
        let x = [1.0, -2.0, 0.5, 3.0, -1.0];
        let mut b: Vec<f64> = (0..n).map(|i| (0..n).map(|j| entry(i, j) * x[j]).sum()).collect();
        assert!(solve(&mut a, &mut b));
        // Condition 5e5.
        assert!(b.iter().zip(x).all(|(b, x)| (b - x).abs() < 1e-10), "{b:?}");
    }

    #[test]
    fn an_indefinite_matrix_is_refused() {
        assert!(!solve(&mut [1.0, 2.0, 1.0], &mut [1.0, 1.0]));
        assert!(!solve(&mut [f64::NAN], &mut [1.0]));
    }
}
