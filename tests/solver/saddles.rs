//! A small residual is not stability.

use super::common::{Bench, N, bulge, dimple, fig2, history, walk_by};
use crate::loops::{go, start};
use rand::SeedableRng;
use tackscope::follow::walk::{Progress, Walk};
use tackscope::numerics::dense::{add, dot, norm};
use tackscope::numerics::eigen::{EigenLimits, smallest};
use tackscope::numerics::threads::Cancel;
use tackscope::physics::pattern::Pattern;
use tackscope::scene::Part;
use tackscope::solver::descent::Descent;
use tackscope::solver::gfmd::{Gfmd, GfmdBudget};
use tackscope::solver::method::{Lost, Stop};
use tackscope::solver::methods::MethodKind;
use tackscope::solver::stability::{Tracker, random_smooth};

#[test]
fn a_flat_saddle_that_a_residual_accepts_at_two_and_a_half_ranges_is_labelled_unstable() {
    // Next to no noise, and no time for it to grow.
    let faint = GfmdBudget {
        temperature: 1e-24,
        ramp: 5,
        relax: 5,
        ..GfmdBudget::default()
    };
    let way = go(
        &mut walk_by(&fig2(24, 0.1), Gfmd::with_budget(faint, 1)),
        2.5,
    );
    let last = way.states.last().unwrap();
    assert_eq!(last.pattern, Pattern::Flat);
    assert!(
        last.residual <= 1e-6,
        "to a residual it is converged: {}",
        last.residual
    );
    assert_eq!(last.stop, Stop::Unstable);
    for state in &way.states {
        assert_eq!(
            state.stop == Stop::Unstable,
            state.mean_displacement < 3.10228,
            "{state:?}"
        );
    }
    let mut newton = start(&fig2(24, 0.1), Part::Whole);
    let way = go(&mut newton, 2.5);
    assert!(
        way.states.iter().all(|s| s.stop == Stop::Stable)
            && newton.record().pattern != Pattern::Flat
    );
}

#[test]
fn without_a_thermostat_there_is_no_hysteresis_and_the_states_say_that_they_are_unstable() {
    let cold = GfmdBudget {
        temperature: 0.0,
        ..GfmdBudget::default()
    };
    // On 32 points sums of equal numbers are exact: on 24 rounding is noise enough.
    let mut walk = walk_by(&fig2(32, 0.1), Gfmd::with_budget(cold, 1));
    let mut states = Vec::new();
    for target in [0.2, 4.2] {
        let way = go(&mut walk, target);
        assert!(way.end == Progress::Resting && way.jumps.is_empty());
        states.extend(way.states);
    }
    // Between the limits of Eq. 8 a flat surface stands only because nothing ever pushes it.
    for state in states {
        let between = (0.78734..3.10228).contains(&state.mean_displacement);
        assert_eq!(
            state.stop,
            if between {
                Stop::Unstable
            } else {
                Stop::Stable
            },
            "{state:?}"
        );
    }
}

#[test]
fn a_dimple_that_methods_without_noise_keep_beyond_2_23_is_labelled_unstable() {
    let mut bench = Bench::new();
    for mut method in [Descent::lbfgs(), Descent::conjugate(), Descent::fire()] {
        let mut branch = history(dimple());
        let mut state = dimple().last().unwrap().clone();
        for u0 in [2.22, 2.24, 2.26, 2.28] {
            state = bench.follow(&mut method, &branch, &state, u0).unwrap();
            branch.push(&state.state);
            assert!(state.residual <= 1e-6 && bench.pattern(&state) == Pattern::Dimple);
            bench.label(&mut state);
            assert_eq!(
                state.stop,
                if u0 < 2.228 {
                    Stop::Stable
                } else {
                    Stop::Unstable
                },
                "{method:?} at {u0}"
            );
        }
    }
}

#[test]
fn the_walk_leaves_the_dimple_at_its_true_limit_whatever_the_method() {
    for kind in [
        MethodKind::NewtonKrylov,
        MethodKind::Lbfgs,
        MethodKind::ConjugateGradients,
        MethodKind::Fire,
    ] {
        let scene = fig2(N, 0.05);
        let mut start = Walk::start(&scene, kind.into(), &Cancel::default()).unwrap();
        go(&mut start, 0.3);
        let way = go(&mut start, 2.4);
        let limit = way
            .jumps
            .iter()
            .find(|j| j.from == Pattern::Dimple)
            .expect("it gives way");
        assert!(
            (limit.mean_displacement - 2.2281).abs() < 5e-4,
            "{kind:?}: {}",
            limit.mean_displacement
        );
        assert!(
            way.states.iter().all(|s| s.stop == Stop::Stable),
            "{kind:?}"
        );
    }
}

#[test]
fn negative_curvature_ends_conjugate_gradients_and_lbfgs_and_gives_no_nan() {
    let mut bench = Bench::new();
    let mut rng = rand_pcg::Pcg64::seed_from_u64(3);
    let mut z = random_smooth(&bench.mechanics.system, &mut rng);
    let length = norm(&z);
    z.iter_mut().for_each(|z| *z *= 0.01 / length);
    // Nearly flat at 2.5 ranges: the longest waves have negative curvature, and a step of the
    // textbook goes to plus infinity along them.
    let from = bench.state(z, 2.5);
    for mut method in [Descent::conjugate(), Descent::lbfgs()] {
        assert_eq!(
            bench.relax(&mut method, &from, 2.5).err(),
            Some(Lost::Unstable),
            "{method:?}"
        );
    }
    assert_eq!(
        bench
            .relax(&mut *MethodKind::NewtonKrylov.build(1), &from, 2.5)
            .err(),
        Some(Lost::Unstable)
    );
}

#[test]
fn a_mode_of_another_symmetry_is_missed_by_a_tracked_vector_and_found_by_the_tracker() {
    let mut bench = Bench::new();
    let state = bench
        .follow(
            &mut Descent::lbfgs(),
            &history(dimple()),
            dimple().last().unwrap(),
            2.26,
        )
        .unwrap();
    // The dimple's own change with u0 has all of its symmetry; the mode that goes soft is its
    // elongation.
    let mut own = dimple()[2].state.amplitudes.clone();
    add(&mut own, -1.0, &dimple()[0].state.amplitudes);
    let removed = bench
        .mechanics
        .sliding_basis(&state.state.amplitudes, &state.fields);
    let limits = EigenLimits {
        pairs: 1,
        least: 2,
        most: 2,
        relative: 0.25,
        absolute: 1e-6,
    };
    let preconditioner = bench.mechanics.preconditioner.clone();
    let apply = |v: &[f64], out: &mut [f64]| bench.mechanics.hessian(&state.fields, v, out);
    let tracked = smallest(
        apply,
        vec![own],
        &removed,
        |r, out| preconditioner.apply(r, out),
        limits,
        &Cancel::default(),
    );
    assert!(tracked.values[0] > 0.0, "{}", tracked.values[0]);
    let mut tracker = Tracker::new(rand_pcg::Pcg64::seed_from_u64(1));
    let (found, _) = tracker.check(&mut bench.mechanics, &state.state.amplitudes, &state.fields);
    assert!(!found.is_stable(), "{found:?}");
}

#[test]
fn sliding_modes_would_always_read_zero_and_are_left_out() {
    let mut bench = Bench::new();
    let state = bulge()[0].clone();
    let slides = bench
        .mechanics
        .sliding_basis(&state.state.amplitudes, &state.fields);
    assert_eq!(slides.len(), 2, "a bulge slides in both directions");
    let mut image = vec![0.0; state.state.amplitudes.len()];
    for mode in &slides {
        bench.mechanics.hessian(&state.fields, mode, &mut image);
        let stiffness = dot(mode, &image) * 256.0;
        assert!(stiffness.abs() < 0.02, "{stiffness}");
    }
    let mut labelled = state;
    bench.label(&mut labelled);
    assert!(
        labelled.stiffness_min.unwrap().value * 256.0 > 0.05,
        "{:?}",
        labelled.stiffness_min
    );
}
