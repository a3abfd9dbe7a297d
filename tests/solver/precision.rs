//! Numbers of fewer bits: what they change, and what they must not.

use tackscope::follow::run::{LoopRun, Outcome, run_loop};
use tackscope::follow::walk::WalkOptions;
use tackscope::numerics::dense::{add, max_abs, norm, scale};
use tackscope::numerics::precision::Precision;
use tackscope::numerics::threads::Cancel;
use tackscope::physics::indenter::Indenter;
use tackscope::physics::law::{Law, Morse, Shape};
use tackscope::physics::mesh::Grid;
use tackscope::physics::system::System;
use tackscope::scene::{Part, Points, Scene};
use tackscope::solver::Stop;
use tackscope::solver::methods::MethodKind;
use tackscope::solver::stability::random_smooth;
use tackscope::storage;

const LAW: Law = Law {
    shape: Shape::Morse(Morse),
    surface_energy: 0.15,
    range: 1.0,
};

fn looped(precision: Precision, part: Part) -> LoopRun {
    let mut scene: Scene = storage::resolve("fig2").unwrap();
    scene.cell.points = Points::Square(48);
    scene.drive.step = 0.04;
    let run = run_loop(
        &scene,
        WalkOptions {
            part,
            precision,
            ..MethodKind::NewtonKrylov.into()
        },
        &Cancel::default(),
        &mut |_| {},
    )
    .unwrap();
    assert_eq!(run.outcome, Outcome::Completed, "{precision:?}");
    run
}

/// The same jumps within `distance` of u0, and the same loss within the share `loss`.
fn agree(run: &LoopRun, double: &LoopRun, distance: f64, loss: f64) {
    let what = |run: &LoopRun| {
        run.record
            .jumps
            .iter()
            .map(|j| (j.direction, j.from, j.to))
            .collect::<Vec<_>>()
    };
    assert_eq!(what(run), what(double));
    for (a, b) in run.record.jumps.iter().zip(&double.record.jumps) {
        assert!(
            (a.mean_displacement - b.mean_displacement).abs() < distance,
            "{a:?} {b:?}"
        );
    }
    let (ours, theirs) = (
        run.record.released_energy_sum(),
        double.record.released_energy_sum(),
    );
    assert!((ours / theirs - 1.0).abs() < loss, "{ours} {theirs}");
}

#[test]
fn mixed_precision_gives_the_jumps_of_double_precision_and_meets_its_tolerance() {
    for part in [Part::Whole, Part::Quarter] {
        let mixed = looped(Precision::Mixed, part);
        agree(&mixed, &looped(Precision::Double, part), 2e-4, 1e-4);
        assert!(
            mixed
                .record
                .states
                .iter()
                .all(|s| s.stop == Stop::Stable && s.residual <= 1e-6)
        );
    }
}

#[test]
fn single_precision_gives_the_same_jumps_at_the_tolerance_it_can_meet() {
    for part in [Part::Whole, Part::Quarter] {
        let single = looped(Precision::Single, part);
        agree(&single, &looped(Precision::Double, part), 1e-3, 1e-3);
        assert!(
            single
                .record
                .states
                .iter()
                .all(|s| s.stop == Stop::Stable && s.residual <= 1e-4)
        );
    }
}

#[test]
fn forces_of_singles_are_those_of_doubles_to_seven_digits_and_mixed_forces_to_the_last() {
    for make in [System::new, System::even] {
        let systems = [Precision::Double, Precision::Mixed, Precision::Single]
            .map(|p| make(Grid::square(256.0, 64), LAW, &Indenter::Flat).with_precision(p));
        let mut rng = rand::SeedableRng::seed_from_u64(5);
        let (mut z, v) = (
            random_smooth(&systems[0], &mut rng),
            random_smooth(&systems[0], &mut rng),
        );
        let length = norm(&z);
        scale(&mut z, 0.5 / length);
        let [double, mixed, single] = systems.map(|system| {
            let (mut ws, mut hv) = (system.workspace(), vec![0.0; z.len()]);
            let at = system.at(z.clone(), 1.0, &mut ws);
            system.hessian(&at.fields, &v, &mut hv, &mut ws);
            (at.state.energy, at.gradient, hv)
        });
        let far = |a: &[f64], b: &[f64]| {
            let mut d = a.to_vec();
            add(&mut d, -1.0, b);
            max_abs(&d) / max_abs(b)
        };
        assert_eq!((mixed.0, &mixed.1), (double.0, &double.1));
        assert!((single.0 / double.0 - 1.0).abs() < 1e-6);
        for error in [
            far(&single.1, &double.1),
            far(&single.2, &double.2),
            far(&mixed.2, &double.2),
        ] {
            assert!(error > 0.0 && error < 1e-6, "{error:e}");
        }
    }
}
