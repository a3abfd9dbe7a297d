//! Numbers of fewer bits: what they change, and what they must not.

use super::common::{LAW, N, fig2};
use crate::loops::{assert_same_jumps, assert_stable, on};
use tackscope::follow::run::{LoopRun, Outcome, run_loop};
use tackscope::follow::walk::WalkOptions;
use tackscope::numerics::dense::{add, max_abs, norm, scale};
use tackscope::numerics::precision::Precision;
use tackscope::numerics::threads::Cancel;
use tackscope::physics::indenter::Indenter;
use tackscope::physics::mesh::Grid;
use tackscope::physics::system::System;
use tackscope::scene::Part;
use tackscope::solver::stability::random_smooth;

fn looped(precision: Precision, part: Part) -> LoopRun {
    let options = WalkOptions {
        precision,
        ..on(part)
    };
    let run = run_loop(&fig2(N, 0.04), options, &Cancel::default(), &mut |_| {}).unwrap();
    assert_eq!(run.outcome, Outcome::Completed, "{precision:?}");
    run
}

/// A loop on either part of the cell, held to have the jumps of double precision within `distance`
/// of u0, the same loss within the share `loss`, and only stable states within the `tolerance`.
fn agrees(precision: Precision, [distance, loss, tolerance]: [f64; 3]) {
    for part in [Part::Whole, Part::Quarter] {
        let [run, double] = [precision, Precision::Double].map(|p| looped(p, part));
        assert_stable(&run, tolerance);
        let (run, double) = (run.record, double.record);
        assert_same_jumps(&run.jumps, &double.jumps, distance);
        let (ours, theirs) = (run.released_energy_sum(), double.released_energy_sum());
        assert!((ours / theirs - 1.0).abs() < loss, "{ours} {theirs}");
    }
}

#[test]
fn mixed_precision_gives_the_jumps_of_double_precision_and_meets_its_tolerance() {
    agrees(Precision::Mixed, [2e-4, 1e-4, 1e-6]);
}

#[test]
fn single_precision_gives_the_same_jumps_at_the_tolerance_it_can_meet() {
    agrees(Precision::Single, [1e-3, 1e-3, 1e-4]);
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
