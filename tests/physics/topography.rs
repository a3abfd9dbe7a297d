//! Measured heights against closed forms: statistics, trends, holes, periods and waves.

use crate::{close, near};
use ndarray::Array2;
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};
use std::path::PathBuf;
use tackscope::numerics::fourier::amplitudes;
use tackscope::physics::indenter::{Indenter, Measured};
use tackscope::physics::mesh::Grid;
use tackscope::physics::parameter::Own;
use tackscope::physics::topography::{Border, Detrend, Periodic, Statistics, Topography, Unit};
use tackscope::study::ground::GroundReport;

/// Heights on a square of this side.
fn map(heights: Array2<f64>, side: f64) -> Topography {
    Topography {
        file: PathBuf::from("map"),
        format: "test",
        heights,
        size: Some([side; 2]),
        unit: Unit::Scene,
    }
}

/// A sum of a few waves of whole periods on n x n points of a square of side `side`.
fn waves(n: usize, side: f64, list: &[([i32; 2], f64, f64)]) -> Array2<f64> {
    Array2::from_shape_fn((n, n), |(j, i)| {
        let at = [i as f64, j as f64].map(|i| i * side / n as f64);
        list.iter()
            .map(|([k, l], amplitude, phase)| {
                let turn = (f64::from(*k) * at[0] + f64::from(*l) * at[1]) / side;
                amplitude * (TAU * turn + phase).cos()
            })
            .sum::<f64>()
    })
}

fn some_waves() -> impl Strategy<Value = Vec<([i32; 2], f64, f64)>> {
    let wave = ((1..6, -5..6), 0.1..2.0, 0.0..TAU);
    prop::collection::vec(wave.prop_map(|((k, l), a, phase)| ([k, l], a, phase)), 1..6)
}

#[test]
fn a_sinusoid_has_the_root_mean_squares_of_its_closed_form() {
    let (n, side, amplitude, periods) = (256, 7.0, 0.3, 3);
    let h = waves(n, side, &[([periods, 0], amplitude, 0.4)]);
    let found = Statistics::of(&h, [side / n as f64; 2], Border::Periodic);
    let q = TAU * f64::from(periods) / side;
    // Differences over the spacing a see sin(q a/2)/(q a/2) of the slope, the square of that of the
    // curvature: 2.3e-4 and 4.5e-4 less.
    let phase = 0.5 * q * side / n as f64;
    let seen = phase.sin() / phase;
    let root = amplitude / 2f64.sqrt();
    close(found.height, root, 1e-12);
    close(found.gradient, root * q * seen, 1e-12);
    close(found.laplacian, root * q * q * seen * seen, 1e-10);
    assert!(seen > 0.999);
}

#[test]
fn statistics_of_an_open_map_leave_out_what_reaches_over_its_border() {
    // A paraboloid: its Laplacian is the same everywhere, the slope by forward differences exact.
    let (n, d) = (9, 0.5);
    let h = Array2::from_shape_fn((n, n), |(j, i)| {
        let (x, y) = (i as f64 * d, j as f64 * d);
        x * x + 3.0 * y
    });
    let found = Statistics::of(&h, [d, d], Border::Open);
    near(found.laplacian, 2.0, 1e-10);
    let slope = (0..n - 1).map(|i| (2.0 * i as f64 * d + d).powi(2) + 9.0);
    let exact = (slope.sum::<f64>() / (n - 1) as f64).sqrt();
    near(found.gradient, exact, 1e-12);
    let profile = h.row(0).to_owned().insert_axis(ndarray::Axis(0));
    let profile = Statistics::of(&profile, [d, d], Border::Open);
    near(profile.laplacian, 2.0, 1e-10);
}

/// An SVD of the normal equations of these points is off by a hundredth.
#[test]
fn a_level_map_stays_level_whatever_is_missing_of_it() {
    let missing = [
        [10, 0],
        [10, 5],
        [0, 12],
        [14, 1],
        [0, 10],
        [0, 6],
        [6, 5],
        [12, 12],
        [18, 16],
        [16, 7],
        [7, 5],
        [9, 12],
        [15, 19],
        [6, 0],
        [14, 12],
        [5, 17],
        [8, 6],
        [16, 10],
        [5, 15],
        [18, 17],
        [4, 17],
        [15, 4],
        [15, 1],
        [16, 14],
        [6, 6],
        [0, 2],
        [8, 15],
        [14, 10],
        [19, 11],
    ];
    for detrend in [Detrend::Tilt, Detrend::Curvature] {
        let mut level = Array2::from_elem((20, 20), 5.0);
        missing.iter().for_each(|at| level[*at] = f64::NAN);
        let found = map(level, 4.0).level(4.0, 1.0, detrend).unwrap().heights;
        assert!(found.iter().all(|h| h.abs() < 1e-12), "{found}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn the_squares_of_the_amplitudes_sum_to_the_mean_square_height(
        values in prop::collection::vec(-1.0..1.0, 35),
    ) {
        let h = Array2::from_shape_vec((5, 7), values).unwrap();
        let powers = amplitudes(&h).mapv(|a| a.norm_sqr());
        let square = h.mapv(|h| h * h).mean().unwrap();
        prop_assert!((powers.sum() - square).abs() < 1e-14);
        // Against the definition, at one wave.
        let found = amplitudes(&h)[[3, 2]];
        let naive: [f64; 2] = h.indexed_iter().fold([0.0; 2], |[re, im], ((j, i), h)| {
            let turn = TAU * (3.0 * j as f64 / 5.0 + 2.0 * i as f64 / 7.0);
            [re + h * turn.cos() / 35.0, im - h * turn.sin() / 35.0]
        });
        prop_assert!((found.re - naive[0]).abs() + (found.im - naive[1]).abs() < 1e-14);
    }

    #[test]
    fn a_band_limited_map_is_shown_exactly_by_every_mesh_that_can(list in some_waves()) {
        let side = 4.0;
        let ground = |n: usize| {
            Indenter::Measured(Measured::new(map(waves(n, side, &list), side)).continued(Periodic::AsIs))
        };
        // Odd and even numbers of points, and meshes finer and coarser than the file.
        for (file, mesh) in [(13, 16), (24, 12), (24, 48), (31, 24)] {
            let (shown, exact) = (
                ground(file).height(&Grid::square(side, mesh)).unwrap(),
                waves(mesh, side, &list),
            );
            let offset = exact[[0, 0]] - shown[[0, 0]];
            for (shown, exact) in shown.iter().zip(&exact) {
                prop_assert!((shown + offset - exact).abs() < 1e-10);
            }
            let highest = shown.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            prop_assert!(highest < 1e-10, "{}", highest);
        }
    }

    #[test]
    fn a_trend_that_is_added_is_taken_away_and_what_was_taken_is_not_taken_twice(
        list in some_waves(),
        (tilt, bend) in ((-3.0..3.0, -3.0..3.0), (-2.0..2.0, -2.0..2.0, -2.0..2.0)),
        missing in prop::collection::vec((0..20_usize, 0..20_usize), 0..30),
    ) {
        let mut plain = waves(20, 4.0, &list);
        missing.iter().for_each(|&(j, i)| plain[[j, i]] = f64::NAN);
        let tilted = Array2::from_shape_fn((20, 20), |(j, i)| {
            let (x, y) = (i as f64 * 0.2, j as f64 * 0.2);
            plain[[j, i]] + 5.0 + tilt.0 * x + tilt.1 * y
        });
        let bent = Array2::from_shape_fn((20, 20), |(j, i)| {
            let (x, y) = (i as f64 * 0.2, j as f64 * 0.2);
            tilted[[j, i]] + bend.0 * x * x + bend.1 * x * y + bend.2 * y * y
        });
        let levelled = |h: &Array2<f64>, detrend| map(h.clone(), 4.0).level(4.0, 1.0, detrend).unwrap();
        for (other, detrend) in [(&tilted, Detrend::Tilt), (&bent, Detrend::Curvature)] {
            let (a, b) = (levelled(&plain, detrend), levelled(other, detrend));
            let again = levelled(&a.heights, detrend);
            prop_assert_eq!(a.filled, plain.iter().filter(|h| h.is_nan()).count());
            for ((a, b), again) in a.heights.iter().zip(&b.heights).zip(&again.heights) {
                prop_assert!((a - b).abs() < 1e-9, "{} {}", a, b);
                // Filled points have a part of their own in a second fit.
                prop_assert!(!missing.is_empty() || (a - again).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn a_mirrored_map_is_even_about_the_middle_of_a_cell_of_twice_its_side(list in some_waves()) {
        let side = 4.0;
        let h = waves(12, side, &list) + &Array2::from_shape_fn((12, 12), |(j, i)| 0.1 * i as f64 - 0.05 * j as f64);
        let ground = Indenter::Measured(Measured::new(map(h.clone(), side)));
        assert_eq!(ground.ground().period(), Some(2.0 * side));
        let grid = Grid::square(2.0 * side, 24);
        let whole = ground.height(&grid).unwrap();
        for ((j, i), height) in whole.indexed_iter() {
            let mirrored = whole[[(24 - j) % 24, (24 - i) % 24]];
            prop_assert!((height - mirrored).abs() < 1e-10);
        }
        // The points of the even quarter are those of the file, but for the last wave.
        let quarter = ground.even_height(&grid).unwrap();
        let shape = |h: &Array2<f64>| {
            let powers = amplitudes(h).mapv(nalgebra::Complex::norm);
            (powers[[1, 1]], powers[[0, 2]])
        };
        let (a, b) = (shape(&quarter), shape(&h.slice(ndarray::s![..;-1, ..;-1]).to_owned()));
        prop_assert!((a.0 - b.0).abs() < 1e-9 && (a.1 - b.1).abs() < 1e-9, "{:?} {:?}", a, b);
    }
}

#[test]
fn a_window_fades_to_the_mean_and_leaves_the_middle_as_it_is() {
    let h = waves(64, 4.0, &[([3, 2], 1.0, 0.7)]);
    let levelled = map(h.clone(), 4.0).level(4.0, 1.0, Detrend::None).unwrap();
    let faded = levelled.periodic(Periodic::Window);
    let level = h[[32, 32]] - faded[[32, 32]];
    for ((j, i), after) in faded.indexed_iter() {
        let inside = [i, j].iter().all(|&k| (8..56).contains(&k));
        assert!(!inside || (after + level - h[[j, i]]).abs() < 1e-12);
    }
    // Half a spacing from the border: (pi/16)^2/4.
    let border = 0.25 * (PI / 16.0 / 2.0).powi(2) * 4.0;
    assert!(faded.row(0).iter().all(|h| h.abs() < 1.1 * border));
    assert!(faded.sum().abs() < 1e-12);
}

#[test]
fn a_map_that_is_no_square_is_cut_to_one_out_of_its_middle() {
    let wide = Array2::from_shape_fn((8, 20), |(_, i)| i as f64);
    let topography = Topography {
        size: Some([10.0, 4.0]),
        ..map(wide, 1.0)
    };
    let levelled = topography.level(20.0, 2.0, Detrend::None).unwrap();
    assert_eq!(levelled.heights.dim(), (8, 8));
    assert_eq!((levelled.side, levelled.cut), (8.0, 96));
    assert_eq!(levelled.heights[[0, 0]], 12.0);
}

#[test]
fn what_a_mesh_leaves_out_of_the_slope_is_said() {
    let h = waves(64, 4.0, &[([1, 0], 1.0, 0.0), ([20, 0], 0.05, 0.0)]);
    let ground = Indenter::Measured(Measured::new(map(h, 4.0)).continued(Periodic::AsIs));
    // Slopes 1 and 20 * 0.05 = 1: one half of the square is lost.
    let words = ground.ground().left_out(&Grid::square(4.0, 32)).unwrap();
    assert!(words.contains("50 %"), "{words}");
    assert_eq!(ground.ground().left_out(&Grid::square(4.0, 64)), None);
    let report = GroundReport::of(&ground, &Grid::square(4.0, 32), None).unwrap();
    assert!(report.words.contains(&words));
    // What is asked to be left out is not missed.
    let Indenter::Measured(measured) = ground else {
        unreachable!()
    };
    let mut values = measured.values();
    values[5] = tackscope::physics::parameter::Value::Number(1.0);
    let smooth = Indenter::Measured(measured.with(&values));
    assert_eq!(smooth.ground().left_out(&Grid::square(4.0, 32)), None);
}

#[test]
fn the_report_of_a_ground_keeps_the_mean_square_in_distribution_and_spectrum() {
    let side = 5.0;
    let list = [([2, 1], 0.7, 0.3), ([0, 4], 0.2, 1.0)];
    let ground = Indenter::Measured(
        Measured::new(map(waves(48, side, &list), side)).continued(Periodic::AsIs),
    );
    let report = GroundReport::of(&ground, &Grid::square(side, 48), None).unwrap();
    let square = 0.5 * (0.7f64.powi(2) + 0.2f64.powi(2));
    close(report.cell.height.powi(2), square, 1e-10);
    let step = report.distribution[1][0] - report.distribution[0][0];
    let total: f64 = report
        .distribution
        .iter()
        .map(|[_, share]| share * step)
        .sum();
    assert!((total - 1.0).abs() < 1e-12);
    // Two rings are not empty: of 12 waves (|k|^2 = 4, 5) and of 32 (13, 16, 17, 18, 20).
    let power = |q: f64| {
        let ring = report
            .spectrum
            .iter()
            .find(|ring| (ring[0] * side / TAU - q).abs() < 0.3);
        ring.unwrap()[1]
    };
    let area = side * side;
    near(power(2.0) * 12.0 / area, 0.5 * 0.7f64.powi(2), 1e-10);
    near(power(4.0) * 32.0 / area, 0.5 * 0.2f64.powi(2), 1e-10);
}
