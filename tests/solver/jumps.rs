//! Jumps that pass unnoticed, and what is carried over them.

use super::common::{Bench, N, bulge, fig2, history, looped, ridge, walk_by};
use crate::loops::{go, preset_on};
use std::process::{Command, Stdio};
use tackscope::follow::walk::{Progress, Stuck, Walk};
use tackscope::numerics::dense::norm;
use tackscope::numerics::threads::Cancel;
use tackscope::physics::system::State;
use tackscope::scene::{Points, Range, Scene};
use tackscope::solver::descent::Descent;
use tackscope::solver::mechanics::{Mechanics, centred};
use tackscope::solver::method::{Cost, Equilibrium, History, Lost, Method, Stop, distance};
use tackscope::solver::methods::MethodKind;
use tackscope::solver::newton::{NewtonLimits, descend, solve};
use tackscope::storage::scene_file;

/// A method that climbs: each state is rougher than the one before, and said to be converged.
struct Climber;

impl Method for Climber {
    fn name(&self) -> &'static str {
        "climber"
    }

    fn locates(&self) -> bool {
        false
    }

    fn follow(
        &mut self,
        mechanics: &mut Mechanics,
        _branch: &History,
        from: &Equilibrium,
        u0: f64,
    ) -> Result<Equilibrium, Lost> {
        let mut climbed = from.state.amplitudes.clone();
        climbed[2 * mechanics.system.grid().ny] += 1.0;
        Ok(Equilibrium::unmeasured(
            mechanics.at(climbed, u0),
            0.0,
            Stop::Stable,
            Cost::default(),
        ))
    }
}

#[test]
fn a_negative_release_is_a_failure_and_not_a_jump() {
    let way = go(&mut walk_by(&fig2(24, 0.1), Climber), 0.2);
    let Progress::Stuck(reason) = &way.end else {
        panic!("{:?}", way.end)
    };
    assert!(
        matches!(
            reason,
            Stuck::EnergyGained {
                method: "climber",
                ..
            }
        ),
        "{reason}"
    );
    assert!(way.jumps.iter().all(|jump| jump.released_energy > -1e-2));
}

/// No method that locates takes a step from the end of this branch to `u0`.
fn all_refuse(bench: &mut Bench, branch: &History, from: &Equilibrium, u0: f64) {
    for kind in MethodKind::ALL {
        let mut method = kind.build(1);
        if method.locates() {
            let lost = bench.follow(&mut *method, branch, from, u0).err();
            assert!(
                matches!(lost, Some(Lost::Gone | Lost::Unstable)),
                "{kind:?}: {lost:?}"
            );
        }
    }
}

#[test]
fn a_step_over_a_fold_that_converges_to_the_flat_state_is_refused() {
    let (from, u0) = (bulge().last().unwrap(), 4.02);
    let mut bench = Bench::new();
    let guess = history(bulge()).predict(u0).unwrap();
    // Beyond the bulge's fold at 3.974 the only minimum near is flat, and a descent that only minds
    // its residual ends there.
    let limits = NewtonLimits {
        steps: 400,
        ..NewtonLimits::default()
    };
    let fallen = descend(&mut bench.mechanics, guess, u0, 1.0, limits);
    assert!(
        fallen.end.is_ok()
            && norm(&fallen.at.state.amplitudes) < 1e-2 * norm(&from.state.amplitudes),
        "{:?}",
        fallen.end
    );
    all_refuse(&mut bench, &history(bulge()), from, u0);
}

/// A history with a jump in it: two bulges and a ridge.
fn torn() -> History {
    let mut torn = History::default();
    for (i, state) in [&bulge()[0], &bulge()[1]].into_iter().enumerate() {
        torn.push(&State {
            mean_displacement: 2.5 - 0.05 * i as f64,
            ..state.state.clone()
        });
    }
    torn.push(&ridge()[2].state);
    torn
}

#[test]
fn an_extrapolation_over_a_jump_is_of_neither_branch_and_nothing_found_from_it_is_accepted() {
    let from = ridge().last().unwrap();
    let u0 = from.state.mean_displacement - 0.05;
    let mut bench = Bench::new();
    let clean = bench
        .follow(
            &mut *MethodKind::NewtonKrylov.build(1),
            &history(ridge()),
            from,
            u0,
        )
        .unwrap();
    let (good, bad) = (
        history(ridge()).predict(u0).unwrap(),
        torn().predict(u0).unwrap(),
    );
    assert!(
        distance(&bad, &clean.state.amplitudes) > 100.0 * distance(&good, &clean.state.amplitudes)
    );
    all_refuse(&mut bench, &torn(), from, u0);
}

#[test]
fn after_a_jump_that_an_increment_hid_the_extrapolation_starts_afresh() {
    // Steps so long that tuned GFMD jumps within an increment: with the old history it would jump
    // back and forth.
    let scene = fig2(N, 0.1);
    let mut walk = Walk::start(&scene, MethodKind::GfmdTuned.into(), &Cancel::default()).unwrap();
    let way = go(&mut walk, 1.5);
    let patterns: Vec<_> = way.jumps.iter().map(|j| j.to).collect();
    let again = (1..patterns.len()).any(|i| patterns[..i].contains(&patterns[i]));
    assert!(
        way.end == Progress::Resting && patterns.len() >= 2 && !again,
        "{patterns:?}"
    );
}

#[test]
fn lbfgs_drops_its_memory_where_it_did_not_end_itself() {
    let from = ridge().last().unwrap();
    let u0 = from.state.mean_displacement - 0.05;
    let mut bench = Bench::new();
    let mut used = Descent::lbfgs();
    let previous = &bulge()[1];
    bench
        .follow(
            &mut used,
            &history(&bulge()[..2]),
            previous,
            previous.state.mean_displacement + 0.01,
        )
        .unwrap();
    let after_a_jump = bench
        .follow(&mut used, &history(ridge()), from, u0)
        .unwrap();
    let fresh = bench
        .follow(&mut Descent::lbfgs(), &history(ridge()), from, u0)
        .unwrap();
    assert_eq!(
        after_a_jump.state.amplitudes, fresh.state.amplitudes,
        "to the last bit"
    );
    assert_eq!(after_a_jump.cost, fresh.cost);
}

#[test]
fn newton_labours_on_a_pattern_between_mesh_points_and_not_on_a_centred_one() {
    let state = &bulge()[0];
    let system = Bench::new().mechanics.system;
    let spacing = system.grid().spacing();
    let drifted = system.moved(&state.state.amplitudes, 0.3 * spacing, 0.2 * spacing);
    let tight = NewtonLimits {
        tolerance: 1e-10,
        steps: 12,
        ..NewtonLimits::default()
    };
    let cost = |z: Vec<f64>| {
        let mut mechanics = Bench::new().mechanics;
        let found = solve(&mut mechanics, z, state.state.mean_displacement, tight);
        (found.end, mechanics.transforms())
    };
    let (end, transforms) = cost(drifted.clone());
    assert!(
        end.is_err(),
        "the mesh pulls along the sliding modes, which no step may use: {end:?}"
    );
    let (good_end, good) = cost(centred(&system, &drifted, [false; 2]));
    assert_eq!(good_end, Ok(()));
    assert!(good < transforms, "{good} {transforms}");
}

/// A line of 16 points with the range that `mu_rho` gives.
fn line(mu_rho: f64) -> Scene {
    let mut scene = preset_on("ridge-line", Points::Line(16));
    scene.law.range = Range::MuRho(mu_rho);
    let range = scene.model().unwrap().law.range;
    scene.drive.start = 4.0 * range + 3.0;
    scene.drive.step = 0.02 * range;
    scene
}

#[test]
fn mesh_trapping_begins_above_one_half_and_the_model_says_so() {
    let mut extra = Vec::new();
    for mu_rho in [0.5, 0.75, 1.0, 1.5] {
        let scene = line(mu_rho);
        let run = looped(&scene, MethodKind::NewtonKrylov);
        // The snap into contact, the closing, and their way back are physics: four jumps.
        extra.push(run.record.jumps.len().saturating_sub(4));
        let warning = scene.model().unwrap().warning();
        assert_eq!(warning.is_some(), mu_rho > 0.5, "{mu_rho}: {warning:?}");
        assert!(warning.is_none_or(|words| words.contains("belong to the mesh")));
    }
    assert_eq!(extra[0], 0, "{extra:?}");
    // A line of 16 points can let go of them one by one on the way down and on the way up.
    assert!(extra[1..].iter().all(|jumps| *jumps >= 10), "{extra:?}");
}

#[test]
fn a_run_on_too_coarse_a_mesh_says_so() {
    let home = tempfile::tempdir().unwrap();
    let path = home.path().join("coarse.toml");
    std::fs::write(&path, scene_file::to_text(&line(1.0))).unwrap();
    let run = |points: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tackscope"));
        command
            .arg("run")
            .arg(&path)
            .args(["--points", points, "--out"])
            .arg(home.path().join("out"))
            .stdin(Stdio::null());
        let output = command.output().unwrap();
        assert_eq!(output.status.code(), Some(0));
        let summary: serde_json::Value =
            serde_json::from_slice(&std::fs::read(home.path().join("out/summary.json")).unwrap())
                .unwrap();
        (
            String::from_utf8(output.stderr).unwrap(),
            summary["plan"]["warning"].clone(),
        )
    };
    let (told, written) = run("16");
    assert!(told.contains("jumps may belong to the mesh"), "{told}");
    assert!(
        written
            .as_str()
            .is_some_and(|words| words.contains("mu_rho = 1.000")),
        "{written}"
    );
}
