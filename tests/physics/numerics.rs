//! The transforms and the iterative linear algebra, against slow and obvious versions of
//! themselves.

use crate::near;
use ndarray::Array2;
use proptest::prelude::*;
use rayon::ThreadPoolBuilder;
use rustfft::num_complex::Complex;
use std::f64::consts::TAU;
use tackscope::numerics::dense::{
    add, add_all, dot, hermite, max_abs, norm, products, symmetric_eigen,
};
use tackscope::numerics::eigen::{EigenLimits, smallest};
use tackscope::numerics::fourier::Fourier;
use tackscope::numerics::fourier::Real;
use tackscope::numerics::krylov::{CgEnd, CgLimits, CgSolution, conjugate_gradients};
use tackscope::numerics::threads::{Cancel, POINTS_MIN, each, lanes, piece};

fn naive(field: &Array2<f64>) -> Array2<Complex<f64>> {
    let (ny, nx) = field.dim();
    Array2::from_shape_fn((nx / 2 + 1, ny), |(k, l)| {
        let terms = field.indexed_iter().map(|((j, i), u)| {
            Complex::cis(-TAU * (k * i) as f64 / nx as f64)
                * Complex::cis(-TAU * (l * j) as f64 / ny as f64)
                * u
        });
        terms.sum::<Complex<f64>>() / (nx * ny) as f64
    })
}

fn noise(ny: usize, nx: usize, seed: u64) -> Array2<f64> {
    // A linear congruential sequence is random enough for a field of test values.
    let mut x = seed.wrapping_mul(2).wrapping_add(1);
    Array2::from_shape_fn((ny, nx), |_| {
        x = x
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (x >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    })
}

#[test]
fn transform_agrees_with_the_naive_sum_for_squares_lines_and_awkward_sizes() {
    for (ny, nx) in [
        (2, 2),
        (4, 4),
        (6, 10),
        (16, 16),
        (14, 22),
        (1, 2),
        (1, 64),
        (1, 34),
        (30, 30),
    ] {
        let field = noise(ny, nx, 7);
        let plan = Fourier::new(ny, nx);
        let (mut spectrum, mut scratch) = (plan.spectrum(), plan.scratch());
        plan.forward(&field, &mut spectrum, &mut scratch);
        let worst = spectrum
            .iter()
            .zip(&naive(&field))
            .map(|(a, b)| (a - b).norm())
            .fold(0.0, f64::max);
        assert!(worst < 1e-15 * (nx * ny) as f64, "{ny} x {nx}: {worst:e}");
    }
}

proptest! {
    /// Through values and derivatives of a cubic goes that cubic, between its ends and beyond.
    #[test]
    fn a_cubic_is_found_from_its_ends(
        c in prop::array::uniform4(-2.0..2.0_f64), from in -2.0..2.0_f64, h in 0.1..3.0_f64, t in -1.0..2.0_f64,
    ) {
        let value = |x: f64| c[0] + x * (c[1] + x * (c[2] + x * c[3]));
        let slope = |x: f64| c[1] + x * (2.0 * c[2] + 3.0 * x * c[3]);
        let to = from + h;
        let ends = [[value(from)], [slope(from)], [value(to)], [slope(to)]];
        let found = hermite([&ends[0], &ends[1], &ends[2], &ends[3]], h, t)[0];
        let size = 1.0 + value(from).abs() + value(to).abs() + h * (slope(from).abs() + slope(to).abs());
        prop_assert!((found - value(from + t * h)).abs() < 1e-12 * size, "{found}");
    }

    #[test]
    fn inverse_undoes_forward_and_keeps_the_mean_square(half_x in 1usize..40, half_y in 0usize..24, seed in 0u64..1000) {
        let (nx, ny) = (2 * half_x, if half_y == 0 { 1 } else { 2 * half_y });
        let field = noise(ny, nx, seed);
        let plan = Fourier::new(ny, nx);
        let (mut spectrum, mut scratch) = (plan.spectrum(), plan.scratch());
        plan.forward(&field, &mut spectrum, &mut scratch);
        let parseval: f64 = spectrum.indexed_iter().map(|((k, _), u)| if k == 0 || 2 * k == nx { 1.0 } else { 2.0 } * u.norm_sqr()).sum();
        let mean_square = field.iter().map(|u| u * u).sum::<f64>() / (nx * ny) as f64;
        prop_assert!((parseval - mean_square).abs() < 1e-14);
        let mut back = Array2::zeros((ny, nx));
        plan.inverse(&mut spectrum, &mut back, &mut scratch);
        prop_assert!(max_abs((&back - &field).as_slice().unwrap()) < 1e-14);
    }
}

/// Spectrum of `field` by `plan`, and the field that it gives back.
fn there_and_back<T: Real>(
    plan: &Fourier<T>,
    field: &Array2<T>,
) -> (Array2<Complex<T>>, Array2<T>) {
    let (mut spectrum, mut scratch) = (plan.spectrum(), plan.scratch());
    plan.forward(field, &mut spectrum, &mut scratch);
    let mut back = Array2::zeros(field.dim());
    plan.inverse(&mut spectrum.clone(), &mut back, &mut scratch);
    (spectrum, back)
}

#[test]
fn threads_do_not_change_a_transform_by_a_single_bit() {
    let threads = ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    for (ny, nx) in [(256, 256), (270, 300), (256, 320)] {
        assert!(ny * nx >= POINTS_MIN);
        let field = noise(ny, nx, 11);
        let single = field.mapv(|x| x as f32);
        let alone = there_and_back(&Fourier::with_lanes(ny, nx, 1), &field);
        let alone_single = there_and_back(&Fourier::with_lanes(ny, nx, 1), &single);
        // Also more lanes than there is work for.
        for lanes in [2, 5, 12, 400] {
            threads.install(|| {
                assert_eq!(
                    there_and_back(&Fourier::with_lanes(ny, nx, lanes), &field),
                    alone
                );
                assert_eq!(
                    there_and_back(&Fourier::with_lanes(ny, nx, lanes), &single),
                    alone_single
                );
            });
        }
        assert_eq!(
            threads.install(|| there_and_back(&Fourier::new(ny, nx), &field)),
            alone
        );
    }
}

#[test]
fn a_transform_of_256_points_a_side_finds_the_waves_a_field_was_made_of() {
    let n = 256;
    let waves = [
        (0, 0, 0.7, 0.0),
        (1, 0, 1.0, 0.3),
        (3, 250, 0.2, -1.0),
        (100, 77, 0.5, 2.0),
        (127, 129, 0.1, 1.5),
    ];
    let angle =
        |k: usize, l: usize, j: usize, i: usize| TAU * ((k * i + l * j) % n) as f64 / n as f64;
    let field: Array2<f64> = Array2::from_shape_fn((n, n), |(j, i)| {
        waves
            .iter()
            .map(|&(k, l, a, phase)| a * (angle(k, l, j, i) + phase).cos())
            .sum()
    });
    let (spectrum, back) = there_and_back(&Fourier::new(n, n), &field);
    for ((k, l), u) in spectrum.indexed_iter() {
        let wanted = |&(wk, wl, a, phase): &(usize, usize, f64, f64)| match (wk, wl) {
            (0, 0) => {
                if (k, l) == (0, 0) {
                    Complex::from(a)
                } else {
                    Complex::from(0.0)
                }
            }
            _ if (k, l) == (wk, wl) => Complex::from_polar(a / 2.0, phase),
            // Both halves are stored in the row k = 0 alone, where no wave but the mean is.
            _ => Complex::from(0.0),
        };
        let wanted: Complex<f64> = waves.iter().map(wanted).sum();
        assert!((u - wanted).norm() < 1e-15, "{k} {l}: {u} {wanted}");
    }
    assert!(max_abs((&back - &field).as_slice().unwrap()) < 1e-14);
}

#[test]
fn tasks_on_threads_are_all_done_once() {
    let threads = ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    let mut done = vec![0; 1000];
    threads.install(|| {
        each(done.chunks_mut(7).enumerate(), |(i, part)| {
            part.iter_mut().for_each(|x| *x += i + 1);
        });
    });
    assert!(done.iter().enumerate().all(|(i, x)| *x == i / 7 + 1));
    assert_eq!((lanes(POINTS_MIN - 1), piece(100)), (1, 100));
    assert!(threads.install(|| lanes(POINTS_MIN)) > 1 && piece(POINTS_MIN) < POINTS_MIN);
}

/// A symmetric matrix with the given eigenvalues, by Householder reflections of the diagonal.
fn matrix(eigenvalues: &[f64]) -> Vec<Vec<f64>> {
    let n = eigenvalues.len();
    let mut a: Vec<Vec<f64>> = (0..n)
        .map(|i| {
            (0..n)
                .map(|j| if i == j { eigenvalues[i] } else { 0.0 })
                .collect()
        })
        .collect();
    for seed in 1..4 {
        let mut v = noise(1, n, seed).into_raw_vec_and_offset().0;
        let length = norm(&v);
        v.iter_mut().for_each(|v| *v /= length);
        let av: Vec<f64> = a.iter().map(|row| dot(row, &v)).collect();
        let vav = dot(&v, &av);
        for i in 0..n {
            for j in 0..n {
                a[i][j] += -2.0 * v[i] * av[j] - 2.0 * av[i] * v[j] + 4.0 * vav * v[i] * v[j];
            }
        }
    }
    a
}

fn times(a: &[Vec<f64>]) -> impl FnMut(&[f64], &mut [f64]) + '_ {
    move |v, out| out.iter_mut().zip(a).for_each(|(o, row)| *o = dot(row, v))
}

#[test]
fn jacobi_finds_the_eigenvalues_a_matrix_was_made_of() {
    let wanted = [-3.0, -0.5, 0.0, 1e-6, 2.0, 2.0, 7.5];
    let a = matrix(&wanted);
    let (values, vectors) = symmetric_eigen(a.clone());
    for (value, want) in values.iter().zip(wanted) {
        near(*value, want, 1e-13);
    }
    for (value, v) in values.iter().zip(&vectors) {
        let mut av = vec![0.0; v.len()];
        times(&a)(v, &mut av);
        assert!(
            av.iter()
                .zip(v)
                .all(|(av, v)| (av - value * v).abs() < 1e-13)
        );
    }
}

#[test]
fn lobpcg_finds_the_smallest_pair_and_leaves_out_removed_directions() {
    let spectrum: Vec<f64> = (0..40)
        .map(|i| if i == 0 { -0.3 } else { 0.2 + f64::from(i) })
        .collect();
    let a = matrix(&spectrum);
    let limits = EigenLimits {
        pairs: 2,
        least: 2,
        most: 200,
        relative: 1e-9,
        absolute: 1e-9,
    };
    let start = |s| {
        vec![
            noise(1, 40, s).into_raw_vec_and_offset().0,
            noise(1, 40, s + 1).into_raw_vec_and_offset().0,
        ]
    };
    let identity = |r: &[f64], out: &mut [f64]| out.copy_from_slice(r);
    let found = smallest(
        times(&a),
        start(20),
        &[],
        identity,
        limits,
        &Cancel::default(),
    );
    assert!(
        (found.values[0] + 0.3).abs() < 1e-12 && (found.values[1] - 1.2).abs() < 1e-9,
        "{:?}",
        found.values
    );
    let removed = vec![found.vectors[0].clone()];
    let next = smallest(
        times(&a),
        start(30),
        &removed,
        identity,
        limits,
        &Cancel::default(),
    );
    near(next.values[0], 1.2, 1e-9);
}

#[test]
fn conjugate_gradients_solve_what_is_definite_and_refuse_what_is_not() {
    let identity = |r: &[f64], out: &mut [f64]| out.copy_from_slice(r);
    let limits = CgLimits::new(1e-12, 200);
    let b = noise(1, 30, 3).into_raw_vec_and_offset().0;
    let good = matrix(&(1..=30).map(f64::from).collect::<Vec<_>>());
    let CgSolution { x, end } =
        conjugate_gradients(times(&good), &b, identity, &[], limits, &Cancel::default());
    let mut ax = vec![0.0; 30];
    times(&good)(&x, &mut ax);
    assert_eq!(end, CgEnd::Converged);
    assert!(ax.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-11));
    let bad = matrix(&(0..30).map(|i| f64::from(i) - 0.5).collect::<Vec<_>>());
    assert_eq!(
        conjugate_gradients(times(&bad), &b, identity, &[], limits, &Cancel::default()).end,
        CgEnd::NegativeCurvature
    );
    let nan = vec![vec![f64::NAN; 30]; 30];
    assert_eq!(
        conjugate_gradients(times(&nan), &b, identity, &[], limits, &Cancel::default()).end,
        CgEnd::NegativeCurvature
    );
    let cancel = Cancel::default();
    cancel.request();
    assert_eq!(
        conjugate_gradients(times(&good), &b, identity, &[], limits, &cancel).end,
        CgEnd::Cancelled
    );
}

/// Of all steps no longer than a radius the one that ends on the edge lowers x A x/2 - b x by no
/// less than the best one along b does (T. Steihaug), whatever the signs of A.
#[test]
fn within_a_radius_conjugate_gradients_gain_no_less_than_the_steepest_way() {
    let identity = |r: &[f64], out: &mut [f64]| out.copy_from_slice(r);
    let b = noise(1, 30, 3).into_raw_vec_and_offset().0;
    for lowest in [-0.5, -20.5, 0.5] {
        let a = matrix(&(0..30).map(|i| f64::from(i) + lowest).collect::<Vec<_>>());
        let energy = |x: &[f64]| {
            let mut ax = vec![0.0; 30];
            times(&a)(x, &mut ax);
            0.5 * dot(x, &ax) - dot(x, &b)
        };
        for radius in [1e-3, 0.1, 0.5] {
            let limits = CgLimits {
                radius,
                ..CgLimits::new(1e-12, 200)
            };
            let CgSolution { x, end } =
                conjugate_gradients(times(&a), &b, identity, &[], limits, &Cancel::default());
            let share = norm(&x) / radius;
            match end {
                CgEnd::Converged => assert!(share < 1.0 && lowest > 0.0),
                _ => assert!((share - 1.0).abs() < 1e-12, "{share}"),
            }
            let steepest = (1..=100)
                .map(|share| {
                    let length = radius * f64::from(share) / 100.0;
                    let size = length / norm(&b);
                    energy(&b.iter().map(|b| b * size).collect::<Vec<_>>())
                })
                .fold(0.0, f64::min);
            assert!(
                energy(&x) <= steepest + 1e-12,
                "{lowest} {radius}: {} {steepest}",
                energy(&x)
            );
        }
    }
}

#[test]
fn the_largest_value_of_a_field_with_nan_is_nan() {
    assert!(max_abs(&[1.0, f64::NAN, 2.0]).is_nan());
    assert_eq!(max_abs(&[1.0, -3.0, 2.0]), 3.0);
}

#[test]
fn many_inner_products_and_sums_at_once_are_those_one_by_one_to_the_last_bit() {
    for length in [0, 5, 8, 256, 1000, 1031] {
        let vectors = |count: u64, salt: u64| -> Vec<Vec<f64>> {
            (0..count)
                .map(|i| noise(1, length, salt + i).into_raw_vec_and_offset().0)
                .collect()
        };
        let (a, b) = (vectors(3, 1), vectors(4, 10));
        let one_by_one: Vec<Vec<f64>> = a
            .iter()
            .map(|a| b.iter().map(|b| dot(a, b)).collect())
            .collect();
        assert_eq!(products(&a, &b), one_by_one);
        let (coefficients, mut y) = ([0.3, -1.2, 2.0, 0.7], a[0].clone());
        let mut wanted = y.clone();
        coefficients
            .iter()
            .zip(&b)
            .for_each(|(c, b)| add(&mut wanted, *c, b));
        add_all(&mut y, &coefficients, &b);
        assert_eq!(y, wanted);
    }
}
