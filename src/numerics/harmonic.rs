//! Harmonic filling: Laplace's equation over the holes of a field.

use super::cancel::Cancel;
use super::krylov::{CgLimits, conjugate_gradients};
use ndarray::Array2;

/// Residual of the equation over its right-hand side: beyond it rounding is all that changes.
const TOLERANCE: f64 = 1e-12;

/// Most products with the matrix; a hole takes about as many as it is points wide.
const PRODUCTS_MAX: usize = 20_000;

/// No unknown.
const KNOWN: usize = usize::MAX;

/// Puts into every point of `field` that is not finite the solution of the discrete Laplace
/// equation (five points, spacings `pitch` along x and y) with the finite points as boundary values
/// and no slope across the border of the field; returns how many it filled.
///
/// # Panics
/// If no point is finite.
pub fn fill(field: &mut Array2<f64>, [dx, dy]: [f64; 2]) -> usize {
    let (rows, columns) = field.dim();
    let mut number = Array2::from_elem((rows, columns), KNOWN);
    let mut holes = Vec::new();
    for ((j, i), h) in field.indexed_iter() {
        if !h.is_finite() {
            number[[j, i]] = holes.len();
            holes.push((j, i));
        }
    }
    if holes.is_empty() {
        return 0;
    }
    assert!(holes.len() < field.len(), "no point is known");
    // The equation in units of the stiffer link, about the mean of what is known.
    let stiff = dx.min(dy);
    let (across, up) = ((stiff / dx).powi(2), (stiff / dy).powi(2));
    let known = (field.len() - holes.len()) as f64;
    let mean = field.iter().filter(|h| h.is_finite()).sum::<f64>() / known;
    let neighbours = |(j, i): (usize, usize)| {
        let left = (i > 0).then(|| ((j, i - 1), across));
        let right = (i + 1 < columns).then(|| ((j, i + 1), across));
        let below = (j > 0).then(|| ((j - 1, i), up));
        let above = (j + 1 < rows).then(|| ((j + 1, i), up));
        [left, right, below, above].into_iter().flatten()
    };
    let links: Vec<f64> = holes
        .iter()
        .map(|&hole| neighbours(hole).map(|(_, weight)| weight).sum())
        .collect();
    let b: Vec<f64> = holes
        .iter()
        .map(|&hole| {
            let known = neighbours(hole).filter(|(at, _)| number[*at] == KNOWN);
            known.map(|(at, weight)| weight * (field[at] - mean)).sum()
        })
        .collect();
    let apply = |x: &[f64], ax: &mut [f64]| {
        for (k, &hole) in holes.iter().enumerate() {
            let pulls = neighbours(hole).filter(|(at, _)| number[*at] != KNOWN);
            let pull: f64 = pulls.map(|(at, weight)| weight * x[number[at]]).sum();
            ax[k] = links[k] * x[k] - pull;
        }
    };
    let precondition = |r: &[f64], z: &mut [f64]| {
        for ((z, r), links) in z.iter_mut().zip(r).zip(&links) {
            *z = r / links;
        }
    };
    let limits = CgLimits::new(TOLERANCE, PRODUCTS_MAX);
    let never = Cancel::default();
    let solution = conjugate_gradients(apply, &b, precondition, &[], limits, &never);
    for (&hole, value) in holes.iter().zip(&solution.x) {
        field[hole] = mean + value;
    }
    holes.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 32, ..ProptestConfig::default() })]

        #[test]
        fn holes_in_a_harmonic_function_are_filled_by_it(
            holes in prop::collection::vec((1..23_usize, 1..17_usize), 1..120),
            scale in 1e-3..1e3,
        ) {
            // x^2 - y^2 and x y are discrete harmonic, whatever the spacings.
            let (dx, dy) = (0.7, 0.4);
            let exact = Array2::from_shape_fn((18, 24), |(j, i)| {
                let (x, y) = (i as f64 * dx, j as f64 * dy);
                scale * (x * x - y * y + 0.3 * x * y + 2.0 * x - y + 5.0)
            });
            let mut field = exact.clone();
            holes.iter().for_each(|&(i, j)| field[[j, i]] = f64::NAN);
            let missing = field.iter().filter(|h| h.is_nan()).count();
            prop_assert_eq!(fill(&mut field, [dx, dy]), missing);
            for (filled, exact) in field.iter().zip(&exact) {
                prop_assert!((filled - exact).abs() < 1e-8 * scale, "{} {}", filled, exact);
            }
        }

        #[test]
        fn what_is_filled_lies_between_what_is_around_it(
            values in prop::collection::vec(prop::option::weighted(0.4, -1.0..1.0), 80),
        ) {
            prop_assume!(values.iter().any(Option::is_some));
            let known = || values.iter().flatten().copied();
            let (low, high) = (known().fold(1.0, f64::min), known().fold(-1.0, f64::max));
            let nan: Vec<f64> = values.iter().map(|h| h.unwrap_or(f64::NAN)).collect();
            let mut field = Array2::from_shape_vec((8, 10), nan).unwrap();
            fill(&mut field, [1.0, 2.0]);
            for (filled, given) in field.iter().zip(&values) {
                prop_assert!(*filled >= low - 1e-9 && *filled <= high + 1e-9);
                prop_assert!(given.is_none_or(|given| given == *filled));
            }
        }
    }
}
