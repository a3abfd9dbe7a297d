//! Numbers that stop being numbers.

use super::common::{Bench, LAW, N, bulge, dimple, fig2, looped, walk_by};
use crate::loops::go;
use tackscope::follow::flat_branch::FlatBranch;
use tackscope::follow::walk::Progress;
use tackscope::numerics::dense::{add, norm};
use tackscope::numerics::precision::Precision;
use tackscope::physics::control::Control;
use tackscope::physics::law::{Law, Mie, Shape};
use tackscope::scene::{LawChoice, Range, Turn};
use tackscope::solver::gfmd::{Gfmd, GfmdBudget, time_step_limit};
use tackscope::solver::mechanics::{Mechanics, Slides};
use tackscope::solver::method::{Lost, Stop};
use tackscope::solver::methods::MethodKind;
use tackscope::solver::newton::{NewtonLimits, descend, solve};
use tackscope::solver::release::{Release, Slice};

fn budget(time_step: f64, temperature: f64) -> GfmdBudget {
    GfmdBudget {
        time_step,
        temperature,
        ..GfmdBudget::default()
    }
}

#[track_caller]
fn stuck(end: &Progress, word: &str) {
    let Progress::Stuck(reason) = end else {
        panic!("{end:?}")
    };
    assert!(reason.to_string().contains(word), "{reason}");
}

#[test]
fn gfmd_beyond_its_time_step_is_named_and_leaves_no_nan_state() {
    let mut walk = walk_by(&fig2(24, 0.1), Gfmd::with_budget(budget(2.1, 1e-4), 1));
    let way = go(&mut walk, 0.2);
    stuck(&way.end, "NaN: time step beyond its limit");
    assert!(
        way.states
            .iter()
            .all(|s| s.stress.is_finite() && s.energy.is_finite())
    );
    assert!(walk.record().stress.is_finite() && norm(&walk.here().state.amplitudes).is_finite());
}

#[test]
fn the_limit_of_the_time_step_is_where_the_formula_says() {
    let mut bench = Bench::new();
    let q1 = bench.mechanics.system.grid().q1();
    let k = 1.0
        / bench
            .mechanics
            .preconditioner
            .diagonal()
            .iter()
            .cloned()
            .fold(0.0, f64::max)
        - q1 / 2.0;
    let limit = time_step_limit(&bench.mechanics.system, LAW.at(0.0).stiffness, k);
    let mut z = vec![0.0; bench.mechanics.system.dimension()];
    z[2] = 1e-9;
    bench.mechanics.system.make_real(&mut z);
    let from = bench.state(z, 0.0);
    let calm = GfmdBudget {
        relax: 2000,
        temperature: 0.0,
        damping: 1e-3,
        ..GfmdBudget::default()
    };
    let below = Gfmd::with_budget(
        GfmdBudget {
            time_step: 0.97 * limit,
            ..calm
        },
        1,
    );
    let above = Gfmd::with_budget(
        GfmdBudget {
            time_step: 1.03 * limit,
            ..calm
        },
        1,
    );
    assert!(bench.relax(&mut { below }, &from, 0.0).is_ok());
    assert_eq!(
        bench.relax(&mut { above }, &from, 0.0).err(),
        Some(Lost::Diverged("time step beyond its limit"))
    );
}

#[test]
fn a_thermostat_that_is_too_hot_is_named() {
    let way = go(
        &mut walk_by(&fig2(24, 0.1), Gfmd::with_budget(budget(0.5, 10.0), 1)),
        0.2,
    );
    stuck(&way.end, "too hot a thermostat");
}

#[test]
fn damped_dynamics_with_a_fixed_time_step_runs_into_the_wall_and_the_release_does_not() {
    // Deep in the unstable range a flat surface falls far: fast enough to overshoot into the wall.
    let mut bench = Bench::new();
    let mut kicked = vec![0.0; bench.mechanics.system.dimension()];
    let (first, u0) = (2 * bench.mechanics.system.grid().ny, 1.2);
    kicked[first] = 0.1;
    let start = bench.state(kicked.clone(), u0);
    let free = GfmdBudget {
        ramp: 1,
        relax: 3000,
        time_step: 1.2,
        damping: 0.0,
        temperature: 0.0,
    };
    assert!(matches!(
        bench.relax(&mut Gfmd::with_budget(free, 1), &start, u0),
        Err(Lost::Diverged(_))
    ));
    let mut release = Release::new(bench.mechanics.at(kicked, u0));
    let settled = loop {
        match release.advance(&mut bench.mechanics, 50) {
            Slice::Moving => {}
            Slice::Settled(state) => break state,
            other => panic!("{other:?}"),
        }
    };
    assert!(settled.residual <= 1e-6 && settled.at.state.energy < start.state.energy);
}

#[test]
fn nan_never_counts_as_converged() {
    let mut bench = Bench::new();
    let mut z = dimple()[0].state.amplitudes.clone();
    z[7] = f64::NAN;
    let from = bench.state(z.clone(), 2.0);
    assert!(
        from.residual.is_nan(),
        "a maximum that swallows NaN would say {}",
        from.residual
    );
    let solved = solve(
        &mut bench.mechanics,
        z.clone(),
        2.0,
        NewtonLimits::default(),
    );
    let descended = descend(&mut bench.mechanics, z, 2.0, 0.05, NewtonLimits::default());
    assert_eq!(
        (solved.end, descended.end),
        (Err(Lost::Gone), Err(Lost::Gone))
    );
    for kind in MethodKind::ALL {
        assert!(
            bench.relax(&mut *kind.build(1), &from, 2.02).is_err(),
            "{kind:?}"
        );
    }
}

#[test]
fn overflow_in_deep_compression_is_refused_by_the_scene_and_labelled_on_the_flat_branch() {
    let deep = -400.0;
    assert!(!LAW.at(deep).energy.is_finite(), "e^800 overflows");
    let mut scene = fig2(24, 1.0);
    scene.drive.turn = Turn::At(deep);
    let refusal = scene.validate().unwrap_err();
    assert_eq!(refusal.key, "drive.turn");
    let mut bench = Bench::new();
    let flat = FlatBranch::new(LAW, 256.0, Control::Displacement);
    assert_eq!(
        flat.state(&bench.mechanics.system, deep).stop,
        Stop::NotConverged
    );
    assert_eq!(
        flat.state(&bench.mechanics.system, -40.0).stop,
        Stop::Stable
    );
    let from = bench.state(bulge()[0].state.amplitudes.clone(), deep);
    for kind in MethodKind::ALL {
        assert!(
            bench.relax(&mut *kind.build(1), &from, deep).is_err(),
            "{kind:?}"
        );
    }
}

#[test]
fn a_mie_law_is_never_evaluated_across_zero_gap() {
    let mie = Law {
        shape: Shape::Mie(Mie { m: 8.0, n: 2.0 }),
        surface_energy: 0.15,
        range: 1.0,
    };
    let mut bench = Bench::of(mie, N);
    let mut z = vec![0.0; bench.mechanics.system.dimension()];
    z[2 * bench.mechanics.system.grid().ny] = 1.0;
    let across = bench.state(z.clone(), 0.9);
    assert!(across.state.energy.is_nan());
    for kind in MethodKind::ALL {
        assert!(
            bench.relax(&mut *kind.build(1), &across, 0.9).is_err(),
            "{kind:?}"
        );
    }
    // A ripple just clear of the singularity: the first full Newton step goes through it, and is
    // shortened.
    z[2 * bench.mechanics.system.grid().ny] = 0.17;
    let near = bench.state(z, 1.0);
    assert!(near.state.energy.is_finite());
    for kind in [
        MethodKind::NewtonKrylov,
        MethodKind::Lbfgs,
        MethodKind::ConjugateGradients,
        MethodKind::GfmdTuned,
    ] {
        match bench.relax(&mut *kind.build(1), &near, 1.0) {
            Ok(state) => assert!(
                state.state.energy.is_finite() && state.residual <= 1e-6,
                "{kind:?}"
            ),
            Err(lost) => assert_ne!(lost, Lost::Cancelled),
        }
    }
    let mut scene = fig2(24, 0.1);
    scene.law = LawChoice {
        shape: mie.shape,
        surface_energy: 0.15,
        range: Range::Length(1.0),
    };
    scene.drive.turn = Turn::At(-0.5);
    assert!(scene.validate().unwrap_err().allowed.contains("above 0"));
}

#[test]
fn deep_compression_gives_no_jumps_of_rounding_because_tolerances_follow_the_tractions_that_act() {
    let text = "format = 1\n[cell]\nlength = 1.0\npoints = 32\n[law]\nkind = \"morse\"\nsurface_energy = 0.5859e-3\n\
                mu_rho = 0.5\n[indenter]\nkind = \"hertz\"\nradius = 1.0\n[drive]\nstart = 0.05\nturn = -0.12\nstep = 0.002\n";
    let scene = tackscope::storage::scene_file::parse(text, "deep").unwrap();
    let run = looped(&scene, MethodKind::NewtonKrylov);
    let law = scene.model().unwrap().law;
    let deepest = run
        .record
        .states
        .iter()
        .min_by(|a, b| a.mean_displacement.total_cmp(&b.mean_displacement))
        .unwrap();
    let pressed = -deepest.stress / law.traction_max();
    // Rounding alone, of tractions so large, would be a residual beyond the tolerance on the scale
    // of the largest tension.
    assert!(
        pressed > 1e6 && deepest.residual <= 1e-6,
        "{pressed} {}",
        deepest.residual
    );
    // A tip on a mesh this coarse does not jump at all.
    assert_eq!(run.record.jumps, []);
}

#[test]
fn single_precision_stalls_near_1e_6_sigma_max_and_says_so() {
    let mut bench = Bench::new();
    bench.mechanics = Mechanics::new(
        bench.mechanics.system.with_precision(Precision::Single),
        Slides::Freely,
    );
    for start in [&dimple()[0], &bulge()[0]] {
        let u0 = start.state.mean_displacement + 0.02;
        let exact = Bench::new()
            .relax(&mut *MethodKind::NewtonKrylov.build(1), start, u0)
            .unwrap();
        let mut floors = Vec::new();
        for tolerance in [1e-8, 1e-12] {
            let limits = NewtonLimits {
                tolerance,
                ..NewtonLimits::default()
            };
            let solved = solve(
                &mut bench.mechanics,
                start.state.amplitudes.clone(),
                u0,
                limits,
            );
            let descended = descend(
                &mut bench.mechanics,
                start.state.amplitudes.clone(),
                u0,
                0.05,
                limits,
            );
            for state in [solved, descended] {
                assert_eq!(state.end, Err(Lost::Gone));
                assert!(
                    state.residual > tolerance && state.residual < 1e-5,
                    "{:e}",
                    state.residual
                );
                // What was asked too much of is still the solution.
                let mut away = state.at.state.amplitudes.clone();
                add(&mut away, -1.0, &exact.state.amplitudes);
                assert!(
                    norm(&away) < 1e-3 && state.at.state.energy.is_finite(),
                    "{:e}",
                    norm(&away)
                );
                floors.push(state.residual);
            }
        }
        let floor = floors.iter().cloned().fold(f64::INFINITY, f64::min);
        assert!(floor > 1e-7 && floor < 4e-6, "{floors:?}");
        // The default of doubles lies within the noise: it may be met by luck, and where it is not
        // that is said.
        let limits = NewtonLimits::default();
        let default = solve(
            &mut bench.mechanics,
            start.state.amplitudes.clone(),
            u0,
            limits,
        );
        assert_eq!(default.end.is_ok(), default.residual <= limits.tolerance);
        assert!(default.residual < 1e-5, "{:e}", default.residual);
        // What the walk asks of it is met with room to spare.
        let mut state = bench
            .relax(&mut *MethodKind::NewtonKrylov.build(1), start, u0)
            .unwrap();
        bench.label(&mut state);
        assert!(
            state.stop == Stop::Stable && state.residual <= 1e-4,
            "{:?} {:e}",
            state.stop,
            state.residual
        );
    }
}
