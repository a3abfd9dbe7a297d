//! Boundary elements at zero range against the exact ridge and the reference tables of dimple and
//! bulge.

use tackscope::numerics::cancel::Cancel;
use tackscope::paper::boundary_elements as be;
use tackscope::physics::theory::discs::Kind;
use tackscope::physics::theory::{circular, ridge};

fn free_run() -> Cancel {
    Cancel::default()
}

#[test]
fn the_extrapolated_ridge_is_the_exact_one_within_its_own_error() {
    for free in [4, 8, 16, 24, 28, 30] {
        let exact = ridge::elastic_energy(free as f64 / 32.0)[0];
        for levels in [4, 5] {
            let found = be::ridge_extrapolated(32, free, levels, &free_run()).unwrap();
            let off = (found.value - exact).abs();
            assert!(
                off < 1e-4 * exact && off <= found.error,
                "{free} {levels}: {found:?} for {exact}"
            );
        }
    }
}

#[test]
fn the_slope_of_the_ridge_is_the_exact_one() {
    for free in [52, 128, 200, 232, 246] {
        let exact = ridge::elastic_energy(free as f64 / 256.0)[1];
        let found = be::ridge_slope(256, free, 4, &free_run()).unwrap();
        let off = (found.value - exact).abs();
        assert!(
            off < found.error && off < 5e-4 * -exact,
            "{free}: {found:?} for {exact}"
        );
        // In the wide middle better than a tenth of that.
        assert!(
            free == 246 || off < 5e-5 * -exact,
            "{free}: {found:?} for {exact}"
        );
    }
}

#[test]
fn straight_edges_lie_0_19_spacings_beyond_the_free_pixels() {
    // The project's notes.
    for free in [128, 512, 896] {
        let [vhat, slope, ..] = ridge::elastic_energy(free as f64 / 1024.0);
        let shift = (be::ridge(1024, free, &free_run()).unwrap() - vhat) / slope * 1024.0 / 2.0;
        assert!((shift - 0.19).abs() < 0.005, "{free}: {shift}");
    }
}

#[test]
fn round_edges_lie_0_127_spacings_beyond_a_dimple_s_pixels_and_within_a_bulge_s() {
    // The project's notes: 0.127(8), contact -0.127.
    for (kind, pattern, sign) in [
        (Kind::Dimple, circular::dimple(), 1.0),
        (Kind::Bulge, circular::bulge(), -1.0),
    ] {
        for size in [0.3, 0.6] {
            let [vhat, slope, _] = pattern.elastic_energy(size);
            let mesh = be::disc_on_mesh(kind, size, 256, 8, &free_run()).unwrap();
            let shift = (mesh.value - vhat) / slope * 256.0 / 2.0;
            assert!(
                (shift - sign * 0.127).abs() < 0.008,
                "{kind:?} {size}: {shift}"
            );
        }
    }
}

#[test]
fn extrapolated_discs_are_the_reference_ones_within_the_stated_error() {
    // Rows of the project's reference files dimple.csv and bulge.csv (uncertainty 1e-10).
    let rows = [
        (Kind::Dimple, 0.3, 55.18755396),
        (Kind::Dimple, 0.5, 11.61466963),
        (Kind::Dimple, 0.7, 3.954593912),
        (Kind::Dimple, 0.9, 1.565718848),
        (Kind::Bulge, 0.3, 0.2365500907),
        (Kind::Bulge, 0.5, 0.6091606128),
        (Kind::Bulge, 0.7, 1.592886579),
        (Kind::Bulge, 0.9, 5.513620535),
    ];
    for (kind, size, vhat) in rows {
        let found = be::disc_extrapolated(kind, size, 64, 8, &free_run()).unwrap();
        println!(
            "{kind:?} {size}: {:.1e} +- {:.1e}",
            found.value / vhat - 1.0,
            found.error / vhat
        );
        assert!(
            (found.value - vhat).abs() < found.error && found.error < 5e-3 * vhat,
            "{kind:?} {size}: {found:?} for {vhat}"
        );
    }
}

#[test]
fn a_request_to_stop_is_heard() {
    let cancel = Cancel::default();
    cancel.request();
    assert_eq!(be::ridge(64, 32, &cancel), None);
    assert_eq!(
        be::disc_extrapolated(Kind::Bulge, 0.5, 32, 2, &cancel),
        None
    );
}
