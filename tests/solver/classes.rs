//! Modes over even patterns, class by class: together they are the modes of the whole cell, and a
//! class is bounded from below by its longest waves alone.

use super::common::LAW;
use nalgebra::DMatrix;
use ndarray::Array2;
use proptest::prelude::*;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use std::f64::consts::PI;
use tackscope::physics::body::{Body, Layer};
use tackscope::physics::control::Control;
use tackscope::physics::indenter::Indenter;
use tackscope::physics::low_block::{Class, LowBlock};
use tackscope::physics::mesh::Grid;
use tackscope::physics::system::{Fields, System};
use tackscope::solver::class_proof::{ClassProof, Known};
use tackscope::solver::mechanics::{Mechanics, Slides};
use tackscope::solver::stability::Tracker;

const N: usize = 16;
const PARITIES: [[bool; 2]; 4] = [[false, false], [true, false], [false, true], [true, true]];

/// The Hessian of a `system`, column by column. Amplitudes that belong to no real field are left at
/// zero.
fn dense(system: &System, stiffness: &Array2<f64>) -> DMatrix<f64> {
    let (n, fields) = (system.dimension(), Fields::of(stiffness.clone()));
    let (mut workspace, mut image) = (system.workspace(), vec![0.0; n]);
    let mut matrix = DMatrix::zeros(n, n);
    for column in 0..n {
        let mut unit = vec![0.0; n];
        unit[column] = 1.0;
        system.make_real(&mut unit);
        system.hessian(&fields, &unit, &mut image, &mut workspace);
        system.make_real(&mut image);
        matrix.column_mut(column).copy_from_slice(&image);
    }
    0.5 * (&matrix + matrix.transpose())
}

/// All eigenvalues, smallest first, but those of amplitudes without a field, which are zero.
fn eigenvalues(matrix: DMatrix<f64>) -> Vec<f64> {
    let mut values: Vec<f64> = matrix
        .symmetric_eigen()
        .eigenvalues
        .iter()
        .copied()
        .collect();
    values.retain(|value| value.abs() > 1e-12);
    values.sort_by(f64::total_cmp);
    values
}

/// gamma'' on a quarter of the cell (E* per length): waves of any length, and x <-> y if wanted.
fn stiffness(numbers: &[f64], is_square: bool) -> Array2<f64> {
    let m = N / 2;
    let at = |i: usize, j: usize| numbers[i * m + j];
    Array2::from_shape_fn((m, m), |(i, j)| {
        if is_square {
            0.5 * (at(i, j) + at(j, i))
        } else {
            at(i, j)
        }
    })
}

/// [`LowBlock::most_below`] a shift, of waves as long as `reach`.
fn most_below(
    even: &System,
    class: Class,
    reach: f64,
    stiffness: &Array2<f64>,
) -> impl FnMut(f64) -> usize + use<> {
    let mut workspace = even.workspace();
    let mut amplitudes = |stiffness: Array2<f64>| {
        let mut out = vec![0.0; even.dimension()];
        let mean = even.stiffness_amplitudes(&Fields::of(stiffness), &mut out, &mut workspace);
        (out, mean)
    };
    let (once, mean) = amplitudes(stiffness.clone());
    let (twice, mean_square) = amplitudes(stiffness * stiffness);
    let least = stiffness.fold(f64::INFINITY, |least: f64, k| least.min(*k));
    let mut block = LowBlock::new(even, class, reach);
    block.bound(even, None, [&once, &twice], [mean, mean_square]);
    move |shift| block.most_below(least, shift)
}

fn even(body: Body) -> System {
    System::even(Grid::square(60.0, N), LAW, &Indenter::Flat).with_body(body)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn even_and_odd_modes_are_the_modes_of_the_whole_cell(
        numbers in prop::collection::vec(-0.05f64..0.4, N * N / 4),
        thickness in prop::option::of(5.0f64..50.0),
    ) {
        let body = thickness.map_or(Body::HalfSpace, |thickness| {
            Body::Layer(Layer { thickness, poisson: 0.4 })
        });
        let even = even(body);
        let quarter = stiffness(&numbers, false);
        let mut classes: Vec<f64> = PARITIES
            .into_iter()
            .flat_map(|odd| {
                let system = if odd == [false; 2] { even.clone() } else { System::odd(&even, odd) };
                eigenvalues(dense(&system, &quarter))
            })
            .collect();
        classes.sort_by(f64::total_cmp);
        let whole = eigenvalues(dense(&System::whole(&even), &even.unfolded(&quarter)));
        prop_assert_eq!(whole.len(), N * N - 1);
        prop_assert_eq!(classes.len(), whole.len());
        for (class, whole) in classes.iter().zip(&whole) {
            prop_assert!((class - whole).abs() < 1e-12, "{} {}", class, whole);
        }
    }

    #[test]
    fn what_is_odd_along_an_axis_has_no_less_energy_than_what_is_even_there(
        numbers in prop::collection::vec(-2.0f64..2.0, N * N / 4),
        values in prop::collection::vec(-1.0f64..1.0, N * N / 4),
    ) {
        // Under a load the mean is a mode like the others.
        let even = even(Body::HalfSpace).with_control(Control::Load);
        let fields = Fields::of(stiffness(&numbers, false));
        let mode = stiffness(&values, false);
        let energy = |odd: [bool; 2]| {
            let system = if odd == [false; 2] { even.clone() } else { System::odd(&even, odd) };
            let mut workspace = system.workspace();
            // The odd waves are stored with a sign that changes from point to point.
            let sign = |at: usize, odd: bool| if odd && at % 2 == 1 { -1.0 } else { 1.0 };
            let signed = Array2::from_shape_fn(mode.dim(), |(j, i)| {
                mode[[j, i]] * sign(i, odd[0]) * sign(j, odd[1])
            });
            let v = system.amplitudes(&signed, &mut workspace);
            let mut image = vec![0.0; v.len()];
            system.hessian(&fields, &v, &mut image, &mut workspace);
            v.iter().zip(&image).map(|(v, image)| v * image).sum::<f64>()
        };
        let [even, along_x, along_y, both] = PARITIES.map(energy);
        prop_assert!(along_x.min(along_y) >= even - 1e-12);
        prop_assert!(both >= along_x.max(along_y) - 1e-12);
    }

    /// From the even modes of mean zero, by one solve, against eigenvalues of dense matrices.
    #[test]
    fn odd_modes_are_bounded_by_even_ones_just_where_they_are_no_softer(
        numbers in prop::collection::vec(-0.05f64..0.4, N * N / 4),
        attraction in 0.0f64..0.8,
        share in 0.1f64..0.95,
    ) {
        let even = even(Body::HalfSpace);
        let mut quarter = stiffness(&numbers, false);
        // Attraction in a corner of the quarter.
        let corner = |i: usize, j: usize| i + j < N / 3;
        quarter.indexed_iter_mut().filter(|((j, i), _)| corner(*i, *j)).for_each(|(_, k)| *k -= attraction);
        // Proved of a smaller gamma''.
        let weak = quarter.mapv(|k| k.min(0.3));
        let least = eigenvalues(dense(&even, &weak))[0];
        prop_assume!(least > 1e-3);
        let shift = share * least;
        for odd in &PARITIES[1..] {
            let system = System::odd(&even, *odd);
            let softest = |stiffness| eigenvalues(dense(&system, stiffness))[0];
            let (softest, real) = (softest(&weak), softest(&quarter));
            let mut mechanics = Mechanics::new(system, Slides::Never);
            let ([fields, weakened], flat) = ([&quarter, &weak].map(|k| Fields::of(k.clone())), vec![0.0; even.dimension()]);
            let mut tracker = Tracker::new(Pcg64::seed_from_u64(1));
            let above = tracker.odd_above(&mut mechanics, &flat, [&fields, &weakened], [least, shift]);
            prop_assert!(!above || real >= shift - 1e-12);
            if (softest - shift).abs() > 1e-3 * least {
                prop_assert_eq!(above, softest > shift, "{:?} {} {}", odd, softest, shift);
            }
        }
    }

    #[test]
    fn a_block_never_counts_fewer_modes_below_a_shift_than_there_are(
        numbers in prop::collection::vec(-0.05f64..0.4, N * N / 4),
        reach in 2.0f64..8.0,
        shift in -0.1f64..0.1,
    ) {
        let even = even(Body::HalfSpace);
        let quarter = stiffness(&numbers, true);
        let bound = |classes: &[Class]| {
            let most = classes.iter().map(|class| most_below(&even, *class, reach, &quarter)(shift));
            most.fold(0, usize::saturating_add)
        };
        for (odd, classes) in PARITIES.into_iter().zip([
            &[Class::Symmetric, Class::Antisymmetric][..],
            &[Class::OddAlongX],
            &[Class::OddAlongY],
            &[Class::OddSymmetric, Class::OddAntisymmetric],
        ]) {
            let system = if odd == [false; 2] { even.clone() } else { System::odd(&even, odd) };
            let values = eigenvalues(dense(&system, &quarter));
            let count = values.iter().filter(|value| **value < shift).count();
            prop_assert!(bound(classes) >= count, "{:?}", classes);
        }
    }
}

/// Squares of wave numbers, summed over the waves as they stand, against the closed form that orders
/// odd and even fields.
#[test]
fn the_squares_of_odd_and_even_waves_differ_by_a_positive_kernel() {
    let m = 7;
    let place = |i: usize| PI * (i as f64 + 0.5) / m as f64;
    for (i, j) in (0..m).flat_map(|i| (0..m).map(move |j| (i, j))) {
        let sum = |from: usize, to: usize, wave: fn(f64) -> f64| -> f64 {
            let term = |k: usize| {
                let weight = if k == 0 || k == m { 1.0 } else { 2.0 } / m as f64;
                weight * (k * k) as f64 * wave(k as f64 * place(i)) * wave(k as f64 * place(j))
            };
            (from..to).map(term).sum()
        };
        let difference = sum(1, m + 1, f64::sin) - sum(0, m, f64::cos);
        let sign = if (i + j) % 2 == 0 { 1.0 } else { -1.0 };
        let kernel = sign / (0.5 * (place(i) + place(j))).sin().powi(2);
        assert!((difference - kernel).abs() < 1e-12, "{i} {j}");
    }
}

/// The bound is worth something: with all waves but the shortest in the block it is the count.
#[test]
fn a_long_block_over_a_smooth_pattern_counts_what_there_is() {
    let even = even(Body::HalfSpace);
    let m = N / 2;
    let wave = |i: usize| (PI * (i as f64 + 0.5) / m as f64).cos();
    let quarter = Array2::from_shape_fn((m, m), |(i, j)| {
        0.05 - 0.1 * (1.0 + wave(i)) * (1.0 + wave(j)) / 4.0
    });
    let values = eigenvalues(dense(&System::odd(&even, [true, false]), &quarter));
    let mut bound = most_below(&even, Class::OddAlongX, 6.0, &quarter);
    // Half way between one eigenvalue and the next.
    for rank in 0..4 {
        let shift = 0.5 * (values[rank] + values[rank + 1]);
        assert_eq!(bound(shift), rank + 1, "{values:?}");
    }
}

/// A smooth gamma'' with x <-> y on a quarter of the cell (E* per length): its longest waves drawn at
/// random, so that some surfaces are stable and some are not.
fn smooth(rng: &mut Pcg64) -> Array2<f64> {
    let m = N / 2;
    let wave = |k: usize, i: usize| (PI * k as f64 * (i as f64 + 0.5) / m as f64).cos();
    let mut quarter = Array2::from_elem((m, m), rng.random_range(-0.04..0.04));
    for (k, l) in [(1, 0), (1, 1), (2, 0), (2, 1), (2, 2)] {
        let size = rng.random_range(-0.03..0.03);
        quarter.indexed_iter_mut().for_each(|((j, i), value)| {
            *value += size * (wave(k, i) * wave(l, j) + wave(l, i) * wave(k, j));
        });
    }
    quarter
}

/// Of modes that are known well and badly, or are not the softest of their class, against all
/// eigenvalues of the whole cell.
#[test]
fn what_blocks_prove_to_be_the_smallest_eigenvalue_is_so_within_its_error() {
    let even = even(Body::HalfSpace);
    let whole = System::whole(&even);
    let mut proof = ClassProof::new(&even, Slides::Never).expect("few waves soften");
    let mut mechanics = Mechanics::new(even.clone(), Slides::Never);
    let mut rng = Pcg64::seed_from_u64(5);
    let (mut proved, mut odd_is_softer) = (0, 0);
    for _ in 0..100 {
        let quarter = smooth(&mut rng);
        let fields = Fields::of(quarter.clone());
        let modes = dense(&even, &quarter).symmetric_eigen();
        let (rank, blur) = (
            [0, 0, 1][rng.random_range(0..3)],
            rng.random_range(0.0..0.1),
        );
        let known = [Class::Symmetric, Class::Antisymmetric].map(|class| {
            let mut of_class: Vec<(f64, Vec<f64>)> = Vec::new();
            for (value, mode) in modes
                .eigenvalues
                .iter()
                .zip(modes.eigenvectors.column_iter())
            {
                let mut part: Vec<f64> = mode.iter().copied().collect();
                class.project(&even, &mut part);
                if value.abs() > 1e-12 && part.iter().map(|v| v * v).sum::<f64>() > 0.5 {
                    of_class.push((*value, part));
                }
            }
            of_class.sort_by(|a, b| a.0.total_cmp(&b.0));
            let [one, next] = [0, 1].map(|more| &of_class[rank + more].1);
            let mode: Vec<f64> = one.iter().zip(next).map(|(a, b)| a + blur * b).collect();
            Known::of(&mut mechanics, &fields, &mode)
        });
        let uniform = vec![0.0; even.dimension()];
        if let Some(found) = proof.least(&mut mechanics, &uniform, &fields, &known) {
            let [softest, softest_even] = [
                eigenvalues(dense(&whole, &even.unfolded(&quarter)))[0],
                eigenvalues(dense(&even, &quarter))[0],
            ];
            proved += 1;
            odd_is_softer += usize::from(softest < softest_even - 1e-6);
            let lower = found.value - found.error;
            assert!(
                lower <= softest + 1e-12 && softest <= found.value + 1e-12,
                "{lower} {softest} {}",
                found.value
            );
        }
    }
    assert!(proved > 20 && odd_is_softer > 2, "{proved} {odd_is_softer}");
}
