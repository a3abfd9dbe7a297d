//! Eq. 30, what a loop between flat and ridge loses: limits, orders, and what the print got wrong.

use std::f64::consts::{PI, SQRT_2};
use tackscope::physics::law::{Cosine, Law, Morse, Shape};
use tackscope::physics::theory::{Units, flat_limits, ridge};

/// Laws in a cell of side 1 with gamma = 1, where lengths are reduced ones.
fn morse(range: f64) -> Law {
    Law {
        shape: Shape::Morse(Morse),
        surface_energy: 1.0,
        range,
    }
}

fn cosine(range: f64) -> Law {
    Law {
        shape: Shape::Cosine(Cosine { smooth: false }),
        ..morse(range)
    }
}

#[test]
fn without_range_the_loss_is_1_087557() {
    // The project's physics notes: 1.087557130, by quadrature of the exact ridge.
    for law in [morse(1e-9), cosine(1e-9)] {
        let loss = ridge::loss(&law, 1.0).unwrap();
        assert!((loss - 1.087_557_130).abs() < 2e-5, "{loss}");
    }
    assert!((ridge::zero_range_dissipation() - 1.087_557_130).abs() < 1e-9);
}

#[test]
fn the_print_takes_a_quarter_too_much_for_the_loss_without_range() {
    let printed = ridge::printed_zero_range();
    assert!((printed - 1.365).abs() < 5e-4, "{printed}");
    assert!((printed / ridge::zero_range_dissipation() - 1.255).abs() < 1e-3);
}

#[test]
fn the_loss_is_the_area_between_the_ridge_and_the_flat_surface() {
    // Simpson's rule over the stress, tensile positive: -p~/u~ of the exact ridge less gamma' of
    // the flat surface.
    for law in [morse(0.02), morse(0.08), cosine(0.1), cosine(0.3)] {
        let from = flat_limits(&law, 1.0).unwrap().1;
        let to = ridge::critical().displacement;
        // u = to - (to - from) s^2 takes the square root off the upper end.
        let n = 2000;
        let integrand = |i: usize| {
            let s = i as f64 / n as f64;
            let u = (to - (to - from) * s * s).min(to);
            2.0 * s * (to - from) * (-ridge::pressure(u).unwrap() / u - law.at(u).traction)
        };
        let weight = |i: usize| {
            if i == 0 || i == n {
                1.0
            } else if i % 2 == 1 {
                4.0
            } else {
                2.0
            }
        };
        let area: f64 = (0..=n).map(|i| weight(i) * integrand(i)).sum::<f64>() / (3 * n) as f64;
        let loss = ridge::loss(&law, 1.0).unwrap();
        assert!((loss - area).abs() < 1e-6, "{law:?}: {loss} {area}");
    }
}

#[test]
fn the_leading_order_meets_the_whole_as_the_range_shrinks_and_the_printed_one_does_not() {
    let zero = ridge::zero_range_dissipation();
    for (make, ranges) in [
        (morse as fn(f64) -> Law, [1e-2, 1e-3, 1e-4, 1e-5]),
        (cosine, [4e-2, 4e-3, 4e-4, 4e-5]),
    ] {
        let differences = ranges.map(|range| {
            let law = make(range);
            let approach = flat_limits(&law, 1.0).unwrap().1;
            let whole = ridge::loss(&law, 1.0).unwrap();
            let printed = ridge::leading_order(ridge::printed_zero_range(), approach);
            assert!(printed - whole > 0.27, "{range}: {printed} {whole}");
            (ridge::leading_order(zero, approach) - whole).abs()
        });
        // The next order of the ridge is u~^2, with logarithms for the Morse law.
        assert!(
            differences.windows(2).all(|w| w[1] < 0.1 * w[0]),
            "{differences:?}"
        );
        assert!(differences[3] < 1e-6, "{differences:?}");
    }
}

#[test]
fn eq_30d_has_the_upper_limit_of_eq_8_for_small_ranges() {
    for range in [1e-2, 1e-3, 1e-4] {
        let exact = flat_limits(&morse(range), 1.0).unwrap().1;
        // Eq. 8 expanded: relative corrections of order rho~^2.
        assert!(
            (ridge::morse_approach(range) / exact - 1.0).abs() < 4.0 * range * range,
            "{range}"
        );
    }
    // 30d as printed: 3/2 {alpha_c - [2 rho~/sqrt(pi) ln(2/(pi rho~^2))]^(2/3)}.
    let range: f64 = 0.01;
    let printed = 1.5
        * (0.910_058_79
            - (2.0 * range / PI.sqrt() * (2.0 / (PI * range * range)).ln()).powf(2.0 / 3.0));
    let ours = ridge::leading_order(ridge::printed_zero_range(), ridge::morse_approach(range));
    assert!((printed - ours).abs() < 1e-8, "{printed} {ours}");
}

#[test]
fn the_flat_term_is_negative_and_the_loss_does_not_depend_on_the_units() {
    let law = morse(0.0807);
    let (_, approach) = flat_limits(&law, 1.0).unwrap();
    let end = ridge::critical();
    let ridge_alone = ridge::energy(end.alpha, end.displacement)
        - ridge::energy(ridge::alpha(approach).unwrap(), approach);
    assert!(ridge::loss(&law, 1.0).unwrap() < ridge_alone);
    let (length, surface_energy) = (1024.0, 0.15);
    let scaled = Law {
        surface_energy,
        range: Units {
            length,
            surface_energy,
        }
        .restore(0.0807),
        ..law
    };
    let (a, b) = (
        ridge::loss(&law, 1.0).unwrap(),
        ridge::loss(&scaled, length).unwrap(),
    );
    assert!((a - b).abs() < 1e-12, "{a} {b}");
}

#[test]
fn the_cosine_law_gets_nearer_to_the_loss_without_range_on_fine_meshes_and_no_loss_is_foretold_below_l_c()
 {
    // Equal largest softening: g_c = sqrt2 pi rho. The cut-off then wins where rho ln(2/(pi
    // rho~^2)) > g_c: rho~ < 0.087.
    let gain = |range: f64| {
        ridge::loss(&cosine(SQRT_2 * PI * range), 1.0).unwrap()
            - ridge::loss(&morse(range), 1.0).unwrap()
    };
    assert!(gain(0.01) > 0.05 && gain(0.05) > 0.0);
    assert_eq!(ridge::loss(&morse(0.29), 1.0), None);
}
