//! The asymptotes of Eqs 22 to 29 against what they are asymptotes of: each must be approached at
//! the rate of its next term.

use std::f64::consts::PI;
use tackscope::physics::theory::asymptotes::*;
use tackscope::physics::theory::circular::{self, Part};
use tackscope::physics::theory::discs::{self, Kind};
use tackscope::physics::theory::ridge;

#[test]
fn the_thick_ridge_is_approached_with_the_square_of_alpha() {
    for alpha in [1e-2, 1e-3] {
        let found = ridge_thick(alpha) / ridge::elastic_energy(alpha)[0] - 1.0;
        assert!(
            (found / (PI * PI * alpha * alpha / 24.0) - 1.0).abs() < 1e-2,
            "{alpha}: {found}"
        );
    }
}

#[test]
fn the_thin_ridge_needs_the_constant_ln_2_over_2() {
    for abar in [1e-2, 1e-4] {
        let exact = ridge::elastic_energy(1.0 - abar)[0];
        assert!(
            (ridge_thin(abar, THIN_CONSTANT) / exact - 1.0).abs() < 0.2 * abar * abar + 1e-11,
            "{abar}"
        );
        // With the printed constant the error fades as 1/ln abar only.
        assert!(
            (ridge_thin(abar, THIN_CONSTANT_PRINTED) / exact - 1.0).abs() > 0.005,
            "{abar}"
        );
    }
    // Exactly as printed, with alpha for abar and +8c, the energy is negative.
    let printed = -PI / (4.0 * (PI * 0.99_f64).ln() + 8.0 * THIN_CONSTANT_PRINTED);
    assert!(printed < 0.0 && ridge::elastic_energy(0.99)[0] > 0.0);
}

#[test]
fn equations_23_and_26_hold_for_small_displacements() {
    for u in [1e-4, 1e-3] {
        // Next order alpha^2: relative errors of a few alpha^2.
        let alpha = ridge::alpha(u).unwrap();
        assert!((ridge_thick_alpha(u) / alpha - 1.0).abs() < alpha * alpha);
        assert!(
            (ridge_thick_pressure(u) / ridge::pressure(u).unwrap() - 1.0).abs() < alpha * alpha
        );
    }
}

#[test]
fn equations_24_and_27_meet_the_exact_ridge_at_its_end_and_the_printed_constants_do_not() {
    let right = flattening();
    for distance in [1e-3, 1e-5] {
        let u = right.displacement - distance;
        // Both miss terms of the order of the distance itself.
        let (alpha, pressure) = (ridge::alpha(u).unwrap(), ridge::pressure(u).unwrap());
        assert!(
            (right.alpha_at(u) - alpha).abs() < 2.0 * distance,
            "{distance}: {} {alpha}",
            right.alpha_at(u)
        );
        assert!(
            (right.pressure_at(u) - pressure).abs() < 4.0 * distance,
            "{distance}: {} {pressure}",
            right.pressure_at(u)
        );
        assert!((FLATTENING_PRINTED.pressure_at(u) - pressure).abs() > 0.02);
    }
    let around = ridge::elastic_energy(right.alpha + 1e-3)[1];
    assert!((right.slope_at(right.alpha + 1e-3) - around).abs() < 1e-5);
    assert!(right.alpha_at(right.displacement + 1e-6).is_nan() && right.pressure_at(0.7).is_nan());
}

#[test]
fn the_printed_pressure_root_lacks_a_root() {
    // u~ = u_c~ + u'' (p~ - p_c~)^2/2 gives p^(1/2) = -sqrt(-2/u''). The project's reference
    // constants.json: u'' = -4.86277.
    let curvature = -4.8627675924887_f64;
    assert!((flattening().pressure_root + (-2.0 / curvature).sqrt()).abs() < 1e-9);
    assert!(
        (FLATTENING_PRINTED.pressure_root - 2.0 / curvature).abs() > 0.05,
        "not even -2/|u''|, which is -0.411"
    );
}

#[test]
fn equation_28_corrected_is_the_limit_of_both_series_with_its_next_term() {
    for size in [0.1, 0.05] {
        // The dimple's third term is of relative order alpha^5 or alpha^6; the bulge's of abar^5.
        let vhat = discs::elastic_energy(Kind::Dimple, size);
        assert!(
            (dimple_next(size) / vhat - 1.0).abs() < size.powi(5),
            "{size}"
        );
        assert!(
            (dimple(size) / vhat - 1.0).abs() < 0.25 * size.powi(3)
                && dimple_printed(size) / vhat > 1.7
        );
        let vhat = discs::elastic_energy(Kind::Bulge, size);
        assert!(
            (bulge_next(size) / vhat - 1.0).abs() < size.powi(5),
            "{size}"
        );
        assert!((bulge(size) / vhat - 1.0).abs() < 1.3 * size && bulge_printed(size) / vhat < 0.9);
    }
}

#[test]
fn equation_29_corrected_is_the_limit_of_the_dimple() {
    for u in [1e-4, 1e-3] {
        let exact = circular::dimple().at(u, Part::Stable).unwrap();
        let cube = exact.size.powi(3);
        assert!(
            (dimple_pressure(u) / exact.pressure - 1.0).abs() < cube,
            "{u}"
        );
        assert!((dimple_pressure_printed(u) / exact.pressure - 0.789).abs() < 0.001);
    }
    // The project's notes: -(1.7930074 u~)^(4/5).
    assert!((dimple_pressure(0.3) + (1.7930074_f64 * 0.3).powf(0.8)).abs() < 1e-8);
}
