//! The error bar of a finished loop, and what it rests on: ends of branches that are where a dense
//! matrix has them.

use crate::loops::{flat_ground, planned, walked};
use nalgebra::DMatrix;
use std::f64::consts::TAU;
use tackscope::follow::atlas::{Atlas, End, Meshes};
use tackscope::follow::walk::{Progress, Walk, WalkOptions};
use tackscope::numerics::cancel::Cancel;
use tackscope::physics::indenter::{Indenter, Wave};
use tackscope::physics::law::{DoubleExponential, Law, Mie, Morse, Shape};
use tackscope::physics::pattern::Pattern;
use tackscope::scene::part::{Part, Strategy};
use tackscope::scene::{Cell, Points, Scene, Turn};
use tackscope::solver::methods::MethodKind::NewtonKrylov;
use tackscope::study::error_bar::measured_error;
use tackscope::study::plan::plan;
use tackscope::study::plan::run_planned;

#[test]
fn the_error_bar_holds_against_a_walk_on_a_mesh_twice_as_fine() {
    let laws = [
        Shape::Morse(Morse),
        Shape::Mie(Mie { m: 6.0, n: 2.5 }),
        Shape::DoubleExponential(DoubleExponential { ratio: 0.4 }),
    ];
    for (shape, (asked, points, finer)) in laws.iter().flat_map(|shape| {
        let square = (Points::Square(24), Points::Square(48));
        let line = (Points::Line(32), Points::Line(64));
        [
            (None, square),
            (Some(Strategy::QUARTER), square),
            (None, line),
        ]
        .map(|(asked, (points, finer))| (*shape, (asked, points, finer)))
    }) {
        let scene = flat_ground(shape, 1.9, points);
        let plan = plan(&scene, &scene.model().unwrap(), asked);
        let run =
            run_planned(&scene, NewtonKrylov, &plan, &Cancel::default(), &mut |_| {}).unwrap();
        let bar = run.error_bar.expect("a smooth law on flat ground");
        let finer = Scene {
            cell: Cell {
                points: finer,
                ..scene.cell
            },
            ..scene.clone()
        };
        let better = walked(&finer, Part::Quarter);
        let error = measured_error(&run.record.jumps, &better.record.jumps);
        assert!(
            error <= bar && bar < 0.01,
            "{shape:?} {asked:?}: {error:e} measured, {bar:e} stated"
        );
    }
}

#[test]
fn nothing_is_measured_where_nothing_is_promised() {
    let mut scene = flat_ground(Shape::Morse(Morse), 1.9, Points::Square(24));
    scene.indenter = Indenter::Wave(Wave {
        amplitude: 0.01,
        periods: [1, 1],
    });
    assert_eq!(planned(&scene).error_bar, None);
}

/// The smallest eigenvalue among the modulations of a ridge with one period along y, from a dense
/// matrix over the gap along x.
fn softest_modulation(gap: &[f64], law: &Law, length: f64) -> f64 {
    let n = gap.len();
    let a = DMatrix::from_fn(n, n, |i, j| {
        let wave = |k: usize| {
            let signed = if 2 * k > n {
                k as f64 - n as f64
            } else {
                k as f64
            };
            0.5 * TAU / length
                * signed.hypot(1.0)
                * (TAU * (k * (i + n - j) % n) as f64 / n as f64).cos()
                / n as f64
        };
        (0..n).map(wave).sum::<f64>()
            + if i == j {
                law.at(gap[i]).stiffness
            } else {
                0.0
            }
    });
    a.symmetric_eigenvalues().min()
}

#[test]
fn a_ridge_breaks_up_where_a_dense_matrix_says_so() {
    let scene = flat_ground(
        Shape::DoubleExponential(DoubleExponential { ratio: 0.63 }),
        1.53,
        Points::Square(32),
    );
    let model = scene.model().unwrap();
    let Turn::At(turn) = scene.drive.turn else {
        unreachable!()
    };
    let mut atlas = Atlas::new(Meshes::new(&model.law, model.grid.length, 32));
    atlas.cycle(scene.drive.start, turn).unwrap();
    let ridge = atlas
        .branches()
        .iter()
        .find(|branch| branch.pattern == Pattern::Ridge)
        .unwrap();
    assert_eq!(ridge.ends[0], End::Breaking);
    let end = ridge.extent().0;
    let mut walk = Walk::start(
        &scene,
        WalkOptions {
            part: Part::Whole,
            ..NewtonKrylov.into()
        },
        &Cancel::default(),
    )
    .unwrap();
    let [far, near] = [2e-3, 1e-3].map(|before| {
        walk.set_target(end + before);
        while let Progress::Working = walk.step(&Cancel::default(), &mut |_| {}) {}
        assert_eq!(walk.record().pattern, Pattern::Ridge);
        let gap = walk.gap();
        let (along_x, along_y): (Vec<f64>, Vec<f64>) =
            (gap.row(0).to_vec(), gap.column(0).to_vec());
        let varies = |line: &[f64]| line.iter().any(|g| (g - line[0]).abs() > 1e-3);
        softest_modulation(
            if varies(&along_x) { &along_x } else { &along_y },
            &model.law,
            model.grid.length,
        )
    });
    // It vanishes where the line through both values does.
    let beyond = near / (far - near) * 1e-3 - 1e-3;
    assert!(
        beyond.abs() < 2e-5 * model.law.range,
        "{beyond:e} beyond {end}"
    );
}
