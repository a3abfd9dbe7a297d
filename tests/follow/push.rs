//! A push by hand: its energy, and where the surface comes to rest when it is let go.

use crate::loops::{preset_on, reach, start};
use std::f64::consts::{PI, TAU};
use tackscope::follow::record::{Cause, StateRecord};
use tackscope::follow::walk::{Push, Walk};
use tackscope::physics::pattern::Pattern;
use tackscope::scene::{Part, Points, Scene};
use tackscope::solver::Stop;

/// Fig. 2 on n x n points, and a walk at rest at its start.
fn fig2(n: usize) -> (Scene, Walk) {
    let scene = preset_on("fig2", Points::Square(n));
    let walk = start(&scene, Part::Whole);
    (scene, walk)
}

fn push(scene: &Scene, width: f64, depth: f64) -> Push {
    Push {
        at: [0.5 * scene.cell.length; 2],
        width: width * scene.cell.length,
        depth,
    }
}

/// Energy per area of a gap over flat ground by the definition, its waves one by one.
fn energy(scene: &Scene, gap: &ndarray::Array2<f64>) -> f64 {
    let (n, law) = (gap.nrows(), scene.model().unwrap().law);
    let cohesive = gap.iter().map(|g| law.at(*g).energy).sum::<f64>() / (n * n) as f64;
    let mut elastic = 0.0;
    let signed = |k: usize| {
        if 2 * k > n {
            k as f64 - n as f64
        } else {
            k as f64
        }
    };
    for k in 0..n {
        for l in 0..n {
            let [mut re, mut im] = [0.0; 2];
            for ((j, i), g) in gap.indexed_iter() {
                let phase = TAU * ((k * i + l * j) % n) as f64 / n as f64;
                re += g * phase.cos();
                im -= g * phase.sin();
            }
            let q = TAU / scene.cell.length * signed(k).hypot(signed(l));
            elastic += q / 4.0 * (re * re + im * im) / ((n * n) as f64).powi(2);
        }
    }
    elastic + cohesive
}

#[test]
fn the_energy_of_a_push_is_that_of_the_pressed_surface_less_that_of_the_state() {
    let (scene, mut walk) = fig2(32);
    reach(&mut walk, 2.0);
    let still = energy(&scene, &walk.gap_here());
    for (width, depth) in [(0.1, 0.5), (0.25, -0.8), (0.05, 1.5)] {
        let push = push(&scene, width, depth);
        let pressed = walk.pressed(&push);
        let said = pressed.state.energy - walk.here().state.energy;
        let found = energy(&scene, &pressed.fields.gap) - still;
        assert!(
            (said - found).abs() < 1e-12 && said > 1e-6,
            "{said} {found}"
        );
        let mean = pressed.fields.gap.mean().unwrap();
        assert!((mean - 2.0).abs() < 1e-12, "u0 stays: {mean}");
        // In the middle it is pressed by its depth, less the mean.
        let moved = &walk.gap_here() - &pressed.fields.gap;
        let most = moved
            .iter()
            .fold(0.0f64, |a, b| if b.abs() > a.abs() { *b } else { a });
        let mean = PI * width * width;
        assert!(
            (most - depth * (1.0 - mean)).abs() < 0.02 * depth.abs(),
            "{most}"
        );
    }
}

/// What a state is, but for where it lies in the cell.
fn apart(a: &StateRecord, b: &StateRecord) -> [f64; 2] {
    [
        (a.energy - b.energy).abs(),
        (a.stress_over_max - b.stress_over_max).abs(),
    ]
}

#[test]
fn a_small_push_goes_back_to_the_same_state() {
    let (scene, mut walk) = fig2(48);
    let gamma = scene.law.surface_energy;
    for (u0, pattern) in [
        (3.3, Pattern::Flat),
        (3.0, Pattern::Bulge),
        (2.0, Pattern::Ridge),
        (1.0, Pattern::Dimple),
    ] {
        reach(&mut walk, u0);
        let before = walk.record().clone();
        assert_eq!(before.pattern, pattern);
        for depth in [0.1, -0.1] {
            walk.let_go(&push(&scene, 0.1, depth));
            assert!(walk.is_jumping());
            assert_eq!(reach(&mut walk, u0), [], "{pattern}, {depth}");
            let after = walk.record();
            assert_eq!(
                (after.pattern, after.control, after.stop),
                (pattern, u0, Stop::Stable)
            );
            assert!(after.residual <= 1e-6, "{after:?}");
            let [energy, stress] = apart(&before, after);
            assert!(energy < 1e-8 * gamma && stress < 1e-5, "{energy} {stress}");
        }
    }
}

#[test]
fn a_large_push_close_before_a_jump_leads_where_the_jump_does() {
    let (scene, mut pushed) = fig2(48);
    let gamma = scene.law.surface_energy;
    // Just above the limit of the flat state, which gives way to a bulge below it.
    assert_eq!(reach(&mut pushed, 3.12), []);
    let before = pushed.record().clone();
    pushed.let_go(&push(&scene, 0.2, 1.5));
    let jumps = reach(&mut pushed, 3.12);
    let [jump] = &jumps[..] else {
        panic!("{jumps:?}")
    };
    let (_, mut jumped) = fig2(48);
    let first = &reach(&mut jumped, 3.09)[0];
    assert_eq!((jump.from, jump.to), (first.from, first.to));
    assert_eq!(jump.cause, Cause::Push);
    // Back on the branch on which the jump has landed.
    assert_eq!(reach(&mut jumped, 3.12), []);
    let [energy, stress] = apart(pushed.record(), jumped.record());
    assert!(energy < 1e-8 * gamma && stress < 1e-5, "{energy} {stress}");
    let released = (before.energy - pushed.record().energy) / gamma;
    assert!((jump.released_energy - released).abs() < 1e-12);
    // It goes on from there as from any other state.
    let jumps = reach(&mut pushed, 2.0);
    assert!(
        jumps.iter().any(|jump| jump.to == Pattern::Ridge),
        "{jumps:?}"
    );
}

#[test]
fn a_push_that_the_law_does_not_allow_is_made_less_deep() {
    let (scene, mut walk) = fig2(32);
    reach(&mut walk, 1.0);
    let pressed = walk.pressed(&push(&scene, 0.1, 1e6));
    let gamma = scene.law.surface_energy;
    let energy = pressed.state.energy - walk.here().state.energy;
    assert!(energy > gamma && energy <= 10.0 * gamma, "{energy}");
}
