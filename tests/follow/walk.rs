//! The walk on real scenes: which patterns, where they jump, and that the ledger closes.

use crate::loops::{
    accounts, assert_same_jumps, assert_stable, driven, on, preset, preset_on, reach, sequence,
    start, walked,
};
use std::sync::OnceLock;
use tackscope::follow::record::{Cause, Direction};
use tackscope::follow::run::{LoopRun, Outcome, run_loop};
use tackscope::numerics::threads::Cancel;
use tackscope::physics::control::Control;
use tackscope::physics::pattern::Pattern::{self, Bulge, Dimple, Flat, Ridge};
use tackscope::physics::theory::{critical_length, flat_limits, ridge};
use tackscope::scene::{Part, Points, Scene};
use tackscope::solver::Stop;
use tackscope::solver::methods::MethodKind;
use tackscope::storage::scene_file;

/// The loop of the preset fig2, computed once for all tests.
pub fn fig2() -> &'static LoopRun {
    static RUN: OnceLock<LoopRun> = OnceLock::new();
    RUN.get_or_init(|| walked(&preset("fig2"), Part::Whole))
}

fn dissipated(run: &LoopRun, scene: &Scene) -> f64 {
    accounts(scene, run).0
}

fn assert_same_loop(a: &LoopRun, b: &LoopRun, scene: &Scene, what: &str) {
    let (da, db) = (dissipated(a, scene), dissipated(b, scene));
    assert!(
        (da / db - 1.0).abs() < 5e-3,
        "{what}: dissipated {da} and {db}"
    );
    assert_same_jumps(&a.record.jumps, &b.record.jumps, 0.01);
}

#[test]
fn fig_2_shows_flat_bulge_ridge_dimple_flat_and_the_same_backwards() {
    let [down, up] = Direction::BOTH.map(|way| sequence(fig2(), way));
    assert_eq!(down, [Flat, Bulge, Ridge, Dimple, Flat]);
    assert_eq!(up, [Flat, Dimple, Ridge, Bulge, Flat]);
}

#[test]
fn flat_state_loses_stability_at_eq_8() {
    let gamma_per_length = 0.15 * 256.0;
    let eq_8 = |sign: f64| {
        -((1.0 + sign * (1.0 - 4.0 * std::f64::consts::PI / gamma_per_length).sqrt()) / 4.0).ln()
    };
    let jumps = fig2().record.jumps.iter();
    let limits: Vec<f64> = jumps
        .filter(|j| j.cause == Cause::FlatLimit)
        .map(|j| j.mean_displacement)
        .collect();
    assert_eq!(limits.len(), 2);
    for (limit, sign) in limits.iter().zip([-1.0, 1.0]) {
        assert!((limit - eq_8(sign)).abs() < 1e-6, "{limits:?}");
    }
}

#[test]
fn every_recorded_state_of_fig_2_is_a_stable_equilibrium() {
    assert_stable(fig2(), 1e-6);
}

#[test]
fn released_energies_add_up_to_the_loop_integral_and_none_is_negative() {
    let (work, released) = accounts(&preset("fig2"), fig2());
    assert!((work - released).abs() < 2e-3 * work, "{work} {released}");
    assert!(fig2().record.jumps.iter().all(|j| j.released_energy > 0.0));
}

#[test]
fn along_branches_stress_is_the_derivative_of_the_energy() {
    let states = &fig2().record.states;
    let mut checked = 0;
    for three in states.windows(3) {
        let [a, b, c] = [&three[0], &three[1], &three[2]].map(|s| s.mean_displacement);
        // Simpson's rule needs equal steps on one branch; within half a range of a fold its own
        // error is not small.
        let near_a_jump =
            fig2().record.jumps.iter().any(|j| {
                j.direction == three[2].direction && (j.mean_displacement - b).abs() < 0.5
            });
        if near_a_jump || three[0].pattern != three[2].pattern || ((b - a) - (c - b)).abs() > 1e-9 {
            continue;
        }
        let work = (c - a) / 6.0 * (three[0].stress + 4.0 * three[1].stress + three[2].stress);
        let missing = three[2].energy - three[0].energy - work;
        assert!(missing.abs() < 1e-9 * 0.15, "{missing:e} at {b}");
        checked += 1;
    }
    assert!(checked > 100, "{checked}");
}

#[test]
fn fig_2_costs_at_most_60_transforms_per_patterned_increment_and_as_many_again_to_prove_it_stable()
{
    let counts = fig2().counts;
    assert!(counts.patterned_increments >= 200);
    assert!(
        counts.transforms - counts.proof_transforms <= 60 * counts.patterned_increments,
        "{counts:?}"
    );
    assert!(
        counts.proof_transforms <= 70 * counts.patterned_increments,
        "{counts:?}"
    );
}

#[test]
fn fig_2_does_not_depend_on_mesh_or_step() {
    let scene = preset("fig2");
    let fine = walked(&preset_on("fig2", Points::Square(128)), Part::Whole);
    assert_same_loop(fig2(), &fine, &scene, "n = 64 and 128");
    let mut short = scene.clone();
    short.drive.step = 0.01;
    let short = walked(&short, Part::Whole);
    assert_same_loop(fig2(), &short, &scene, "step 0.02 and 0.01");
}

#[test]
fn fig_2_is_the_same_loop_for_at_least_10_seeds_of_12() {
    let scene = preset("fig2");
    let same = (1..=12).filter(|seed| {
        let mut other = scene.clone();
        other.seed = *seed;
        let run = walked(&other, Part::Whole);
        run.record.jumps.len() == fig2().record.jumps.len()
            && (dissipated(&run, &scene) / dissipated(fig2(), &scene) - 1.0).abs() < 5e-3
            && run
                .record
                .jumps
                .iter()
                .zip(&fig2().record.jumps)
                .all(|(a, b)| {
                    (a.from, a.to) == (b.from, b.to)
                        && (a.mean_displacement - b.mean_displacement).abs() < 0.01
                })
    });
    assert!(same.count() >= 10);
}

#[test]
fn the_same_seed_gives_the_same_loop_to_the_last_bit() {
    let mut scene = preset_on("fig2", Points::Square(32));
    scene.drive.step = 0.05;
    let states = |run: LoopRun| {
        run.record
            .states
            .iter()
            .map(|s| (s.mean_displacement, s.stress, s.energy))
            .collect::<Vec<_>>()
    };
    assert_eq!(
        states(walked(&scene, Part::Whole)),
        states(walked(&scene, Part::Whole))
    );
}

#[test]
fn fig_3_has_no_bulge_and_loses_three_to_four_times_as_much() {
    let mut scene = preset("fig3");
    // Jumps are located whatever the step; between them half a range shows enough.
    scene.drive.step = 0.5;
    let run = walked(&scene, Part::Whole);
    let [down, up] = Direction::BOTH.map(|way| sequence(&run, way));
    assert_eq!(down, [Flat, Ridge, Dimple, Flat]);
    assert_eq!(up, [Flat, Dimple, Ridge, Flat]);
    let ratio = dissipated(&run, &scene) / dissipated(fig2(), &preset("fig2"));
    assert!((3.0..=4.0).contains(&ratio), "{ratio}");
}

#[test]
fn a_cell_below_the_critical_length_has_no_hysteresis() {
    let scene = preset("no-hysteresis");
    let model = scene.model().unwrap();
    assert!(scene.cell.length < critical_length(&model.law));
    let run = walked(&scene, Part::Whole);
    assert!(run.record.jumps.is_empty());
    assert!(dissipated(&run, &scene).abs() < 1e-6);
}

/// Largest deviation of p~ from the exact zero-range ridge over u~ in [0.3, 0.5], both directions.
fn deviation_from_the_exact_ridge(length: f64, points: usize) -> f64 {
    let mut scene = preset_on("ridge-line", Points::Line(points));
    scene.cell.length = length;
    let unit = (0.15 * length).sqrt();
    let start = 0.75 * unit;
    let scene = driven(scene, Control::Displacement, [start, 0.2, start / 200.0]);
    let run = walked(&scene, Part::Whole);
    let ridges = run.record.states.iter().filter(|s| s.pattern == Ridge);
    let deviations: Vec<f64> = ridges
        .map(|s| {
            (
                s.mean_displacement / unit,
                -s.stress * s.mean_displacement / 0.15,
            )
        })
        .filter(|(u, _)| (0.3..0.5).contains(u))
        .map(|(u, p)| (p / ridge::pressure(u).unwrap() - 1.0).abs())
        .collect();
    assert!(deviations.len() > 50);
    deviations.into_iter().fold(0.0, f64::max)
}

#[test]
fn line_cell_follows_the_exact_ridge_within_a_difference_that_shrinks_with_the_range() {
    // rho~ = 0.161, 0.0807, 0.0403: the range halves each time, at equal mu_rho.
    let d: Vec<f64> = [(256.0, 64), (1024.0, 256), (4096.0, 1024)]
        .map(|(l, n)| deviation_from_the_exact_ridge(l, n))
        .to_vec();
    assert!(d[1] < 0.6 * d[0] && d[2] < 0.6 * d[1], "{d:?}");
    assert!(d[2] < 0.05, "{d:?}");
}

#[test]
fn a_cancelled_loop_keeps_what_was_computed() {
    let (cancel, mut seen) = (Cancel::default(), 0);
    let run = run_loop(&preset("fig2"), on(Part::Whole), &cancel, &mut |_| {
        seen += 1;
        if seen == 80 {
            cancel.request();
        }
    })
    .unwrap();
    assert_eq!(run.outcome, Outcome::Cancelled);
    assert!(run.record.states.len() > 60);
}

#[test]
fn a_walk_along_the_flat_state_obeys_a_stop_too() {
    let scene = driven(preset("fig2"), Control::Displacement, [24.0, 4.0, 2e-4]);
    let (cancel, mut seen) = (Cancel::default(), 0);
    let run = run_loop(&scene, on(Part::Whole), &cancel, &mut |_| {
        seen += 1;
        cancel.request();
    })
    .unwrap();
    assert_eq!((run.outcome, seen), (Outcome::Cancelled, 1));
}

#[test]
fn the_papers_method_stands_behind_the_same_interface_and_says_that_it_has_not_converged() {
    let mut scene = preset_on("fig2", Points::Square(32));
    scene.drive.step = 0.05;
    let run = run_loop(
        &scene,
        MethodKind::Gfmd.into(),
        &Cancel::default(),
        &mut |_| {},
    )
    .unwrap();
    assert_eq!(run.outcome, Outcome::Completed);
    // A thermostat keeps every state above the tolerance, and the record admits it.
    assert!(
        run.record
            .states
            .iter()
            .skip(1)
            .all(|s| s.stop == Stop::NotConverged && s.residual > 1e-6)
    );
    let loss = dissipated(&run, &scene);
    // Late instabilities of a finite budget can only add to the loss.
    assert!(
        loss > dissipated(fig2(), &scene) && loss < 1.5 * dissipated(fig2(), &scene),
        "{loss}"
    );
}

#[test]
fn a_trace_of_the_softest_modulation_on_a_ridge_is_not_taken_for_a_sliding_mode() {
    use tackscope::numerics::dense::{add, dot, norm};
    use tackscope::solver::mechanics::{Mechanics, Slides};
    let mut walk = start(&preset("fig2"), Part::Whole);
    reach(&mut walk, 1.34);
    assert_eq!(walk.record().pattern, Ridge);
    let (system, soft) = (walk.system(), walk.here().soft_mode.clone());
    let mut z = walk.here().state.amplitudes.clone();
    // Just above the break-up; the modulation at the level at which residuals are accepted.
    add(&mut z, 1e-5, &soft);
    let mut mechanics = Mechanics::new(system.clone(), Slides::Freely);
    let basis = mechanics.sliding_basis(&z, &walk.here().fields);
    assert_eq!(basis.len(), 1, "a ridge slides in one direction");
    let derivatives = system.sliding_modes(&soft);
    assert!(
        derivatives
            .iter()
            .all(|d| (dot(&basis[0], d) / norm(d)).abs() < 0.1),
        "and not along its modulation"
    );
}

#[test]
fn a_coarse_mesh_jumps_where_the_continuum_does_not_and_its_ledger_still_closes() {
    let scene = preset("coarse-mesh");
    let run = walked(&scene, Part::Whole);
    let (work, released) = accounts(&scene, &run);
    assert!(run.record.jumps.len() > 50, "{}", run.record.jumps.len());
    assert!((work - released).abs() < 2e-3 * work, "{work} {released}");
    // More than a ridge of zero range can lose: no continuum does that.
    assert!(work > ridge::zero_range_dissipation(), "{work}");
}

#[test]
fn every_law_runs_the_four_patterns_on_flat_ground() {
    use tackscope::physics::law::{Cosine, DoubleExponential, Mie, Shape};
    use tackscope::scene::Range;
    let shapes = [
        Shape::Mie(Mie { m: 8.0, n: 2.0 }),
        Shape::Cosine(Cosine { smooth: false }),
        Shape::Cosine(Cosine { smooth: true }),
        Shape::DoubleExponential(DoubleExponential { ratio: 0.4 }),
    ];
    for shape in shapes {
        let mut scene = preset("fig2");
        scene.law.shape = shape;
        scene.law.range = Range::MuRho(0.387);
        let model = scene.model().unwrap();
        let (lower, upper) = flat_limits(&model.law, model.grid.length).unwrap();
        let (rest, width) = (model.law.equilibrium_gap(), upper - lower);
        let (start, turn) = (upper + 0.7 * width, rest + 0.25 * (lower - rest));
        let scene = driven(scene, Control::Displacement, [start, turn, width / 100.0]);
        let run = walked(&scene, Part::Whole);
        // Small mesh jumps within a pattern (the cosine law has them at its cut-off) are left out.
        let mut seen = sequence(&run, Direction::Approach);
        seen.dedup();
        assert_eq!(seen, [Flat, Bulge, Ridge, Dimple, Flat], "{shape:?}");
        let (work, released) = accounts(&scene, &run);
        assert!(
            (work - released).abs() < 5e-3 * work,
            "{shape:?}: {work} {released}"
        );
    }
}

#[test]
fn a_hertzian_tip_jumps_into_contact_once_and_out_once() {
    let text = "format = 1\n[cell]\nlength = 1.0\npoints = 64\n[law]\nkind = \"morse\"\nsurface_energy = 0.5859e-3\nmu_rho = 0.5\n\
                [indenter]\nkind = \"hertz\"\nradius = 1.0\n[drive]\nstart = 0.05\nturn = \"zero_load\"\nstep = 0.0001\n";
    let scene = scene_file::parse(text, "hertz").unwrap();
    let run = walked(&scene, Part::Whole);
    let [down, up] = Direction::BOTH.map(|way| sequence(&run, way));
    assert_eq!(down, [Pattern::Other, Pattern::Contact]);
    assert_eq!(up, [Pattern::Contact, Pattern::Other]);
    // The pull-off force of JKR, (3/2) pi gamma R, within the few per cent that a range this long
    // costs.
    let pull = run.pull_off().unwrap();
    let jkr = 1.5 * std::f64::consts::PI * 0.5859e-3;
    assert!((pull / jkr - 1.0).abs() < 0.1, "{}", pull / jkr);
    let (work, released) = accounts(&scene, &run);
    assert!((work - released).abs() < 1e-2 * work, "{work} {released}");
}

#[test]
fn after_landing_flat_the_walk_goes_on_in_the_steps_of_the_scene() {
    let mut scene = preset_on("fig2", Points::Square(24));
    scene.drive.step = 0.1;
    let run = walked(&scene, Part::Whole);
    let landed = run
        .record
        .jumps
        .iter()
        .rev()
        .find(|jump| jump.to == Flat)
        .unwrap()
        .mean_displacement;
    let after = run
        .record
        .states
        .iter()
        .filter(|s| s.direction == Direction::Retraction && s.mean_displacement > landed);
    let expected = ((scene.drive.start - landed) / scene.drive.step).ceil() as usize;
    assert_eq!(after.count(), expected);
}
