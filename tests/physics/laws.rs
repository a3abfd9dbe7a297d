//! Cohesive laws against finite differences, independent scans and the values of the literature.

use crate::near;
use proptest::prelude::*;
use std::f64::consts::{LN_2, PI};
use tackscope::physics::law::{Cosine, DoubleExponential, Law, Mie, Morse, Shape};

/// Every law with odd scales (so that a forgotten factor shows), and smooth pieces of its gaps in
/// units of the range.
fn cases() -> Vec<(Law, Vec<(f64, f64)>)> {
    let law = |shape| Law {
        shape,
        surface_energy: 0.15,
        range: 1.7,
    };
    vec![
        (law(Shape::Morse(Morse)), vec![(-3.0, 9.0)]),
        (law(Shape::Mie(Mie { m: 8.0, n: 2.0 })), vec![(0.8, 9.0)]),
        (law(Shape::Mie(Mie { m: 12.0, n: 6.0 })), vec![(0.85, 5.0)]),
        (law(Shape::Mie(Mie { m: 9.0, n: 3.0 })), vec![(0.8, 6.0)]),
        (
            law(Shape::Cosine(Cosine { smooth: false })),
            vec![(-2.0, -0.1), (0.1, 0.9), (1.1, 2.0)],
        ),
        (
            law(Shape::Cosine(Cosine { smooth: true })),
            vec![(-2.0, -0.1), (0.1, 0.9), (1.1, 2.0)],
        ),
        (
            law(Shape::DoubleExponential(DoubleExponential { ratio: 0.4 })),
            vec![(-2.0, 9.0)],
        ),
        (
            law(Shape::DoubleExponential(DoubleExponential { ratio: 0.9 })),
            vec![(-2.0, 9.0)],
        ),
    ]
}

/// Evenly spaced points of an interval, both ends included.
fn scan((a, b): (f64, f64), points: usize) -> impl Iterator<Item = f64> {
    (0..=points).map(move |i| a + (b - a) * i as f64 / points as f64)
}

/// Largest error of traction and stiffness against central differences of step `h` ranges, in units
/// of gamma and range.
fn difference_error(law: &Law, pieces: &[(f64, f64)], h: f64) -> [f64; 2] {
    let (gamma, rho) = (law.surface_energy, law.range);
    let mut worst = [0.0_f64; 2];
    for x in pieces.iter().flat_map(|&piece| scan(piece, 400)) {
        let (here, right, left) = (
            law.at(x * rho),
            law.at((x + h) * rho),
            law.at((x - h) * rho),
        );
        let first = (right.energy - left.energy) / (2.0 * h * rho) - here.traction;
        let second = (right.traction - left.traction) / (2.0 * h * rho) - here.stiffness;
        worst = [
            worst[0].max(first.abs() * rho / gamma),
            worst[1].max(second.abs() * rho * rho / gamma),
        ];
    }
    worst
}

#[test]
fn traction_and_stiffness_are_the_derivatives_and_the_error_falls_as_h_squared() {
    for (law, pieces) in cases() {
        let (coarse, fine) = (
            difference_error(&law, &pieces, 2e-3),
            difference_error(&law, &pieces, 1e-3),
        );
        for (order, (coarse, fine)) in coarse.into_iter().zip(fine).enumerate() {
            // A central difference is wrong by h^2/6 times the third derivative; the next term is
            // h^4, a few per cent here.
            let ratio = coarse / fine;
            assert!(
                (3.9..4.1).contains(&ratio),
                "{:?}, derivative {order}: {coarse:e} over {fine:e} is {ratio}",
                law.shape
            );
        }
    }
}

#[test]
fn the_strongest_and_the_softest_point_are_the_maxima_of_a_scan() {
    for (law, pieces) in cases() {
        let (rho, sigma, kappa) = (law.range, law.traction_max(), law.softening_max());
        let points = || {
            pieces
                .iter()
                .flat_map(|&piece| scan(piece, 100_000))
                .map(|x| law.at(x * rho))
        };
        let strongest = points().map(|r| r.traction).fold(f64::MIN, f64::max);
        let softest = points().map(|r| -r.stiffness).fold(f64::MIN, f64::max);
        // A scan of 1e-4 ranges finds a smooth maximum to 1e-8 of a curvature of order ten, and
        // never above it.
        assert!(
            strongest <= sigma * (1.0 + 1e-12) && strongest > sigma * (1.0 - 1e-6),
            "{:?}",
            law.shape
        );
        assert!(
            (law.at(law.contact_gap()).traction - sigma).abs() <= 1e-14 * sigma,
            "{:?}",
            law.shape
        );
        if let Shape::Cosine(_) = law.shape {
            // Its largest softening is the limit at the cut-off from inside.
            let inside = -law.at(law.softest_gap() * (1.0 - 1e-9)).stiffness;
            assert!((inside - kappa).abs() < 1e-12 * kappa && softest <= kappa);
        } else {
            assert!(
                softest <= kappa * (1.0 + 1e-12) && softest > kappa * (1.0 - 1e-6),
                "{:?}",
                law.shape
            );
            assert!(
                (law.at(law.softest_gap()).stiffness + kappa).abs() <= 1e-14 * kappa,
                "{:?}",
                law.shape
            );
        }
    }
}

#[test]
fn strengths_and_softenings_are_the_published_ones() {
    // Shape, gap and value of the largest traction, gap and value of the largest softening, in
    // units of gamma and range. Closed forms for Morse and cosine; the Mie values were computed
    // with 40 digits from the roots of the derivatives.
    let mie = |m, n| Shape::Mie(Mie { m, n });
    let table = [
        (Shape::Morse(Morse), LN_2, 0.5, 2.0 * LN_2, 0.25),
        (
            mie(8.0, 2.0),
            1.20093695518,
            1.02640047856,
            1.39908320717,
            1.25275764517,
        ),
        (
            mie(12.0, 6.0),
            1.10868341797,
            2.6899008972,
            1.21706533687,
            7.47810145306,
        ),
        (
            mie(9.0, 3.0),
            1.16499305075,
            1.46578551296,
            1.32859857281,
            2.37171315476,
        ),
        (
            mie(4.0, 2.0),
            1.29099444874,
            0.743612802472,
            1.58113883008,
            0.64,
        ),
        (
            Shape::Cosine(Cosine { smooth: false }),
            0.5,
            PI / 2.0,
            1.0,
            PI * PI / 2.0,
        ),
        (
            Shape::Cosine(Cosine { smooth: true }),
            0.5,
            PI / 2.0,
            1.0,
            PI * PI / 2.0,
        ),
    ];
    for (shape, strongest, sigma, softest, kappa) in table {
        let law = Law {
            shape,
            surface_energy: 1.0,
            range: 1.0,
        };
        let found = [
            law.contact_gap(),
            law.traction_max(),
            law.softest_gap(),
            law.softening_max(),
        ];
        for (found, expected) in found.into_iter().zip([strongest, sigma, softest, kappa]) {
            // The table is printed to twelve digits.
            assert!(
                (found - expected).abs() < 1e-11 * expected,
                "{shape:?}: {found} for {expected}"
            );
        }
    }
}

#[test]
fn the_energy_is_least_at_equilibrium_where_it_is_minus_gamma_without_traction() {
    for (law, pieces) in cases() {
        let rest = law.at(law.equilibrium_gap());
        let gamma = law.surface_energy;
        assert!((rest.energy + gamma).abs() <= 1e-15, "{:?}", law.shape);
        assert!(rest.traction.abs() <= 1e-15, "{:?}", law.shape);
        assert!(rest.stiffness > 0.0, "{:?}", law.shape);
        let expected = if let Shape::Mie(_) = law.shape {
            law.range
        } else {
            0.0
        };
        assert_eq!(law.equilibrium_gap(), expected);
        for x in pieces.iter().flat_map(|&piece| scan(piece, 1000)) {
            assert!(
                law.at(x * law.range).energy >= -gamma * (1.0 + 1e-15),
                "{:?} at {x}",
                law.shape
            );
        }
    }
}

#[test]
fn deep_compression_never_gives_nan_for_laws_with_a_soft_wall() {
    for (law, _) in cases() {
        if let Shape::Mie(_) = law.shape {
            continue;
        }
        for x in [-1.0, -30.0, -300.0, -355.0, -1e4, -1e300] {
            let r = law.at(x * law.range);
            assert!(
                !r.energy.is_nan() && !r.traction.is_nan() && !r.stiffness.is_nan(),
                "{:?} at {x}: {r:?}",
                law.shape
            );
            assert!(
                r.energy > -law.surface_energy && r.traction < 0.0 && r.stiffness > 0.0,
                "{:?} at {x}: {r:?}",
                law.shape
            );
        }
    }
    let law = Law {
        shape: Shape::Morse(Morse),
        surface_energy: 0.15,
        range: 1.0,
    };
    assert!(law.at(-300.0).energy.is_finite());
}

#[test]
fn every_law_fades_at_a_large_gap() {
    for (law, _) in cases() {
        let far = law.at(1e6 * law.range);
        // The slowest is the 8-2 Mie law, whose energy falls as (4/3) x^-2.
        assert!(
            far.energy.abs() < 1e-11 && far.traction.abs() < 1e-17 && far.stiffness.abs() < 1e-22,
            "{:?}: {far:?}",
            law.shape
        );
    }
}

#[test]
fn mie_at_or_below_zero_gap_is_nan_and_never_a_plausible_number() {
    for (m, n) in [(8.0, 2.0), (12.0, 6.0), (9.0, 3.0), (7.5, 1.5)] {
        let law = Law {
            shape: Shape::Mie(Mie { m, n }),
            surface_energy: 0.15,
            range: 1.0,
        };
        for g in [
            0.0,
            -0.0,
            -1e-300,
            -0.5,
            -1.0,
            -100.0,
            f64::NEG_INFINITY,
            f64::NAN,
        ] {
            let r = law.at(g);
            assert!(
                r.energy.is_nan() && r.traction.is_nan() && r.stiffness.is_nan(),
                "{m}-{n} at {g}: {r:?}"
            );
        }
        let near = law.at(1e-200);
        assert!(
            !near.energy.is_finite() && !near.traction.is_finite() && !near.stiffness.is_finite()
        );
    }
}

#[test]
fn the_cosine_as_printed_doubles_its_stiffness_at_zero_gap_and_the_smooth_one_does_not() {
    let ratio = |smooth| {
        let law = Law {
            shape: Shape::Cosine(Cosine { smooth }),
            surface_energy: 0.3,
            range: 2.0,
        };
        law.at(-1e-9).stiffness / law.at(1e-9).stiffness
    };
    near(ratio(false), 2.0, 1e-12);
    assert!((ratio(true) - 1.0).abs() < 1e-12);
}

#[test]
fn the_cosine_is_continuous_in_energy_and_traction_at_both_joints() {
    for smooth in [false, true] {
        let law = Law {
            shape: Shape::Cosine(Cosine { smooth }),
            surface_energy: 1.0,
            range: 1.0,
        };
        for joint in [0.0, 1.0] {
            let (left, right) = (law.at(joint - 1e-9), law.at(joint + 1e-9));
            // Slopes of at most pi^2 over 2e-9.
            assert!(
                (left.energy - right.energy).abs() < 2e-8
                    && (left.traction - right.traction).abs() < 2e-8
            );
        }
        let beyond = law.at(1.0);
        assert_eq!(
            (beyond.energy, beyond.traction, beyond.stiffness),
            (0.0, 0.0, 0.0)
        );
    }
}

#[test]
fn the_cosine_as_printed_is_equation_31() {
    let law = Law {
        shape: Shape::Cosine(Cosine { smooth: false }),
        surface_energy: 0.3,
        range: 2.0,
    };
    for g in [0.1, 0.7, 1.0, 1.9] {
        assert!((law.at(g).energy + 0.3 * (1.0 + (PI * g / 2.0).cos()) / 2.0).abs() < 1e-15);
        assert!((law.at(-g).energy + 0.3 * (1.0 - (PI * g / 2.0).powi(2) / 2.0)).abs() < 1e-14);
    }
}

#[test]
fn morse_is_equation_3() {
    let law = Law {
        shape: Shape::Morse(Morse),
        surface_energy: 0.15,
        range: 1.7,
    };
    for g in [-2.0, -0.1, 0.0, 0.4, 1.0, 5.0_f64] {
        let expected = 0.15 * ((-2.0 * g / 1.7).exp() - 2.0 * (-g / 1.7).exp());
        assert!((law.at(g).energy - expected).abs() <= 1e-14 * expected.abs().max(0.15));
    }
}

#[test]
fn every_law_of_the_picker_has_its_own_word() {
    let mut words: Vec<_> = Shape::all().iter().map(Shape::word).collect();
    words.sort_unstable();
    assert_eq!(words, ["cosine", "double_exponential", "mie", "morse"]);
}

#[test]
fn the_field_kernel_gives_what_the_single_point_gives() {
    for (law, pieces) in cases() {
        let gap: Vec<f64> = pieces
            .iter()
            .flat_map(|&piece| scan(piece, 333))
            .map(|x| x * law.range)
            .collect();
        let (mut traction, mut stiffness) = (vec![0.0; gap.len()], vec![0.0; gap.len()]);
        let energy = law.fill(&gap, &mut traction, &mut stiffness);
        let (sigma, kappa) = (
            law.surface_energy / law.range,
            law.surface_energy / law.range.powi(2),
        );
        let mut sum = 0.0;
        for (i, &g) in gap.iter().enumerate() {
            let r = law.at(g);
            sum += r.energy;
            // A vectorised exponential may differ in the last digits: relative to the value, or to
            // the law's scale near a zero.
            assert!(
                (traction[i] - r.traction).abs() <= 4e-15 * (sigma + 4.0 * r.traction.abs()),
                "{:?} at {g}",
                law.shape
            );
            assert!(
                (stiffness[i] - r.stiffness).abs() <= 4e-15 * (kappa + 4.0 * r.stiffness.abs()),
                "{:?} at {g}",
                law.shape
            );
        }
        let scale: f64 = gap.iter().map(|&g| law.at(g).energy.abs()).sum();
        assert!((energy - sum).abs() <= 1e-13 * scale, "{:?}", law.shape);
    }
}

#[test]
fn laws_whose_two_parts_nearly_coincide_are_their_analytic_limit() {
    let (n, law) = (2.0_f64, |shape| Law {
        shape,
        surface_energy: 1.0,
        range: 1.0,
    });
    // As m -> n, f = -x^-n (1 + n ln x); as the ratio goes to 1, f = -(1 + x) e^-x. Both differ
    // from the limit by the distance.
    let power = |x: f64| {
        let (l, b) = (x.ln(), x.powf(-n));
        [
            -b * (1.0 + n * l),
            n * n * b * l / x,
            n * n * b * (1.0 - (n + 1.0) * l) / (x * x),
        ]
    };
    let exponential = |x: f64| {
        [
            -(1.0 + x) * (-x).exp(),
            x * (-x).exp(),
            (1.0 - x) * (-x).exp(),
        ]
    };
    for distance in [4.5e-16, 2e-15, 1e-13, 1e-10, 1e-7] {
        let mie = law(Shape::Mie(Mie { m: n + distance, n }));
        let double = law(Shape::DoubleExponential(DoubleExponential {
            ratio: 1.0 - distance,
        }));
        let softest = (7.0_f64 / 12.0).exp();
        near(mie.softest_gap(), softest, 1e-14 + 2.0 * distance);
        assert!((mie.softening_max() + power(softest)[2]).abs() < 1e-14 + 10.0 * distance);
        near(double.softest_gap(), 2.0, 1e-14 + 2.0 * distance);
        for x in scan((0.3, 6.0), 100) {
            for (law, limit) in [(mie, power(x)), (double, exponential(x))] {
                let (at, mut first, mut second) = (law.at(x), [0.0], [0.0]);
                let energy = law.fill(&[x], &mut first, &mut second);
                let size = 1.0 + limit.iter().map(|f| f.abs()).fold(0.0, f64::max);
                for (found, right) in [
                    at.energy,
                    at.traction,
                    at.stiffness,
                    energy,
                    first[0],
                    second[0],
                ]
                .iter()
                .zip(limit.iter().cycle())
                {
                    assert!(
                        (found - right).abs() < size * (1e-14 + 20.0 * distance),
                        "{:?} at {x}: {found} for {right}",
                        law.shape
                    );
                }
            }
        }
    }
}

fn any_shape() -> impl Strategy<Value = Shape> {
    prop_oneof![
        Just(Shape::Morse(Morse)),
        (0.5..8.0_f64, 0.3..10.0_f64).prop_map(|(n, more)| Shape::Mie(Mie { m: n + more, n })),
        any::<bool>().prop_map(|smooth| Shape::Cosine(Cosine { smooth })),
        (0.05..0.999_f64).prop_map(|ratio| Shape::DoubleExponential(DoubleExponential { ratio })),
    ]
}

proptest! {
    #[test]
    fn a_double_exponential_with_half_the_range_is_the_morse_law(x in -20.0..40.0_f64, gamma in 0.01..10.0_f64, range in 0.1..10.0_f64) {
        let double = Law { shape: Shape::DoubleExponential(DoubleExponential { ratio: 0.5 }), surface_energy: gamma, range };
        let morse = Law { shape: Shape::Morse(Morse), ..double };
        let (a, b) = (double.at(x * range), morse.at(x * range));
        // Both sum terms no larger than 4 e^-x (1 + e^-x); the argument's own rounding enters times
        // |x|.
        let scale = 1e-15 * (1.0 + x.abs()) * 4.0 * (-x).exp() * (1.0 + (-x).exp());
        prop_assert!((a.energy - b.energy).abs() <= scale * gamma);
        prop_assert!((a.traction - b.traction).abs() <= scale * gamma / range);
        prop_assert!((a.stiffness - b.stiffness).abs() <= scale * gamma / (range * range));
    }

    #[test]
    fn a_change_of_units_changes_nothing(shape in any_shape(), x in 0.3..8.0_f64, lengths in 1e-3..1e3_f64, energies in 1e-3..1e3_f64) {
        let law = Law { shape, surface_energy: 0.15, range: 1.0 };
        let other = Law { shape, surface_energy: 0.15 * energies, range: lengths };
        let (a, b) = (law.at(x), other.at(x * lengths));
        // x lengths / lengths may differ from x by one unit in the last place, which a Mie wall
        // amplifies by its exponent.
        let close = |a: f64, b: f64, scale: f64| (a - b).abs() <= 1e-13 * (a.abs() + scale);
        let size = 1.0 + a.energy.abs() + a.traction.abs() + a.stiffness.abs();
        prop_assert!(close(a.energy, b.energy / energies, size));
        prop_assert!(close(a.traction, b.traction * lengths / energies, size));
        prop_assert!(close(a.stiffness, b.stiffness * lengths * lengths / energies, size));
        prop_assert!(close(law.traction_max(), other.traction_max() * lengths / energies, 0.0));
        prop_assert!(close(law.softening_max(), other.softening_max() * lengths * lengths / energies, 0.0));
        prop_assert!(close(law.contact_gap(), other.contact_gap() / lengths, 0.0));
    }

    #[test]
    fn traction_never_exceeds_its_largest_and_stiffness_never_its_lowest(shape in any_shape(), x in -5.0..30.0_f64) {
        let law = Law { shape, surface_energy: 0.15, range: 1.7 };
        let r = law.at(x * law.range);
        if r.energy.is_nan() {
            prop_assert!(matches!(shape, Shape::Mie(_)) && x <= 0.0);
        } else {
            prop_assert!(r.energy >= -0.15 * (1.0 + 1e-12));
            prop_assert!(r.traction <= law.traction_max() * (1.0 + 1e-12));
            prop_assert!(r.stiffness >= -law.softening_max() * (1.0 + 1e-12));
        }
    }

    #[test]
    fn the_work_of_separation_is_the_surface_energy(shape in any_shape()) {
        // Simpson's rule over the traction from equilibrium outwards, in the variable s = ln(1 +
        // x - x0) that suits slow tails.
        let law = Law { shape, surface_energy: 1.0, range: 1.0 };
        let (start, points) = (law.equilibrium_gap(), 20_000);
        let far = 1e6_f64;
        let step = far.ln() / points as f64;
        let f = |i: usize| { let e = (i as f64 * step).exp(); law.at(start + e - 1.0).traction * e };
        let inside: f64 = (1..points).map(|i| f(i) * if i % 2 == 1 { 4.0 } else { 2.0 }).sum();
        let work = (f(0) + inside + f(points)) * step / 3.0;
        let left = -law.at(start + far - 1.0).energy;
        // Smooth laws: h^4; the cosine's kink at the cut-off costs h^2 = 5e-7.
        prop_assert!((work + left - 1.0).abs() < 1e-6, "{work} + {left}");
    }
}
