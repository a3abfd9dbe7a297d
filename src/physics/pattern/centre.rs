//! A pattern on flat ground may sit anywhere; pictures show it in the middle.

use ndarray::Array2;
use std::f64::consts::TAU;

/// The roll (rows, columns) that brings the island to the middle of the picture, by the phase of
/// the first harmonic: the contact, or where `hole` is true the largest gap.
pub fn shift_to_middle(gap: &Array2<f64>, hole: bool) -> (usize, usize) {
    let (ny, nx) = gap.dim();
    let sign = if hole { 1.0 } else { -1.0 };
    let row_means = gap.rows().into_iter().map(|r| r.sum()).collect::<Vec<_>>();
    let column_means = gap
        .columns()
        .into_iter()
        .map(|c| c.sum())
        .collect::<Vec<_>>();
    let scale = gap.iter().map(|g| g.abs()).sum::<f64>();
    let shift = |sums: &[f64], n: usize| {
        let (mut re, mut im) = (0.0, 0.0);
        for (k, s) in sums.iter().enumerate() {
            let phase = TAU * k as f64 / n as f64;
            re += sign * s * phase.cos();
            im += sign * s * phase.sin();
        }
        if n < 2 || re.hypot(im) < 1e-3 * scale {
            return 0;
        }
        let peak = im.atan2(re).rem_euclid(TAU) / TAU * n as f64;
        (n as f64 / 2.0 - peak).round().rem_euclid(n as f64) as usize % n
    };
    (shift(&row_means, ny), shift(&column_means, nx))
}

/// The field moved by `dy` rows and `dx` columns around the cell.
pub fn rolled(gap: &Array2<f64>, dy: usize, dx: usize) -> Array2<f64> {
    let (ny, nx) = gap.dim();
    if (dy, dx) == (0, 0) {
        return gap.clone();
    }
    Array2::from_shape_fn((ny, nx), |(j, i)| {
        gap[((j + ny - dy) % ny, (i + nx - dx) % nx)]
    })
}
