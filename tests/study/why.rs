//! Why a surface snapped: the numbers of the sentence against theory, and its words against what
//! the walk finds.

use crate::loops::{preset, preset_on};
use std::f64::consts::PI;
use tackscope::follow::flat_branch::FlatBranch;
use tackscope::follow::record::{Cause, Direction, JumpRecord, LoopRecord, Share, StateRecord};
use tackscope::follow::walk::{Observed, Progress, Walk, WalkOptions};
use tackscope::numerics::threads::Cancel;
use tackscope::physics::body::{Body, Layer};
use tackscope::physics::control::Control;
use tackscope::physics::pattern::Pattern;
use tackscope::physics::theory::{critical_length, flat_limits};
use tackscope::scene::{Part, Points, Scene};
use tackscope::study::forecast::{ahead, calm};
use tackscope::study::why::{Balance, Criterion, Evidence, Explanation, Holder, Shape, explain};

fn jump(cause: Cause, u0: f64, control: f64) -> JumpRecord {
    JumpRecord {
        direction: Direction::Approach,
        control,
        mean_displacement: u0,
        mean_displacement_after: u0,
        from: Pattern::Flat,
        to: Pattern::Bulge,
        stress_before: 0.1,
        stress_after: 0.2,
        released_energy: 0.01,
        release_error: 0.0,
        cause,
        landings: Vec::new(),
    }
}

/// Why the flat surface of a scene gives way where it does, on approach and on retraction.
fn flat_explained(scene: &Scene) -> [Explanation; 2] {
    let model = scene.model().unwrap();
    let control = scene.control();
    let branch = FlatBranch::new(model.law, model.equivalent_length, control);
    let (lower, upper) = branch.unstable_gaps().unwrap();
    [(Direction::Approach, upper), (Direction::Retraction, lower)].map(|(direction, u0)| {
        let jump = JumpRecord {
            direction,
            ..jump(Cause::FlatLimit, u0, u0)
        };
        let evidence = Evidence {
            jump: &jump,
            fields: None,
        };
        explain(scene, &model, evidence)
    })
}

#[test]
fn the_why_of_a_flat_limit_quotes_eq_8() {
    for length in [128.0, 256.0, 700.0] {
        let mut scene = preset("fig2");
        scene.cell.length = length;
        let model = scene.model().unwrap();
        let (lower, upper) = flat_limits(&model.law, length).unwrap();
        let [approach, retraction] = flat_explained(&scene);
        for (why, u0, side) in [(&approach, upper, "Below"), (&retraction, lower, "Above")] {
            let Criterion::Flat { law, holder, held } = why.criterion else {
                panic!("{why:?}")
            };
            assert_eq!(holder, Holder::LongestWave);
            // gamma''(u0) = -pi E*/L, both in E*/L.
            assert!(
                (law + PI).abs() < 1e-6 && (held - PI).abs() < 1e-12,
                "{why:?}"
            );
            let place = format!("{side} {:.3} ranges", u0 / model.law.range);
            for words in [&place, "γ″ + πE*/L < 0", "−3.1416 + 3.1416"] {
                assert!(why.sentence.contains(words), "{words} in {}", why.sentence);
            }
        }
    }
}

#[test]
fn under_a_layer_a_soft_spring_or_a_load_their_own_stiffness_is_quoted() {
    let mut layer = preset("fig2");
    layer.body = Body::Layer(Layer {
        thickness: 60.0,
        poisson: 0.5,
    });
    let model = layer.model().unwrap();
    let [why, _] = flat_explained(&layer);
    // An incompressible film gives way where -gamma'' = 6.22 G/t, with G = E*/4.
    let theory = 6.22 * 0.25 / 60.0 * model.grid.length;
    let Criterion::Flat { law, holder, held } = why.criterion else {
        panic!("{why:?}")
    };
    assert_eq!(holder, Holder::SoftestWave);
    assert!(
        (held / theory - 1.0).abs() < 0.01 && (law + held).abs() < 1e-5 * held,
        "{why:?}"
    );

    let mut spring = preset("fig2");
    spring.drive.control = Control::Spring { stiffness: 0.005 };
    let [why, _] = flat_explained(&spring);
    let Criterion::Flat { law, holder, held } = why.criterion else {
        panic!("{why:?}")
    };
    assert_eq!(holder, Holder::Spring);
    assert!(
        (held - 0.005 * 256.0).abs() < 1e-12 && (law + held).abs() < 1e-5,
        "{why:?}"
    );
    assert!(why.sentence.contains("as a block"), "{}", why.sentence);

    let mut load = preset("fig2");
    load.drive.control = Control::Load;
    let [_, why] = flat_explained(&load);
    let Criterion::Flat { law, holder, held } = why.criterion else {
        panic!("{why:?}")
    };
    assert_eq!((holder, held), (Holder::Nothing, 0.0));
    assert!(law.abs() < 1e-5, "{why:?}");
}

/// Why each jump of a loop down to `turn` and back happened, with the jump.
fn walked(scene: &Scene, turn: f64) -> Vec<(JumpRecord, Explanation)> {
    let model = scene.model().unwrap();
    let options = WalkOptions {
        part: Part::Quarter,
        ..WalkOptions::default()
    };
    let mut walk = Walk::start(scene, options, &Cancel::default()).unwrap();
    let stands = |walk: &mut Walk| (walk.record().clone(), walk.gap_here(), walk.soft_mode());
    let mut before = stands(&mut walk);
    let mut found = Vec::new();
    for target in [turn, scene.drive.start] {
        walk.set_target(target);
        loop {
            let mut seen = Vec::new();
            let progress = walk.step(&Cancel::default(), &mut |observed| seen.push(observed));
            for observed in seen {
                match observed {
                    Observed::Jump(jump) => {
                        let (state, gap, mode) = &before;
                        let evidence = Evidence {
                            jump: &jump,
                            fields: mode.as_ref().map(|mode| [gap, mode]),
                        };
                        let why = explain(scene, &model, evidence);
                        if let Some(Balance { body, law }) = why.balance {
                            // Together they are the eigenvalue that the walk has measured.
                            let off = body + law - state.stiffness_min;
                            let near = 1e-5 * body + state.stiffness_error;
                            assert!(off.abs() <= near, "{why:?} {state:?}");
                        }
                        found.push((jump, why));
                    }
                    Observed::State(_) => before = stands(&mut walk),
                    Observed::Moving { .. } => {}
                }
            }
            if progress != Progress::Working {
                assert_eq!(progress, Progress::Resting);
                break;
            }
        }
    }
    found
}

#[test]
fn every_jump_of_fig_2_is_explained_by_its_cause_and_its_mode() {
    let scene = preset_on("fig2", Points::Square(64));
    let found = walked(&scene, 0.2);
    let of = |direction, from| {
        let found = found
            .iter()
            .find(|(jump, _)| (jump.direction, jump.from) == (direction, from));
        found
            .map(|(_, why)| why)
            .unwrap_or_else(|| panic!("{found:?}"))
    };
    use {Direction::*, Pattern::*};
    for (direction, from, wanted) in [
        (Approach, Bulge, Criterion::Symmetry(Shape::Stretching)),
        (
            Approach,
            Ridge,
            Criterion::Symmetry(Shape::BreakUp { waves: 1 }),
        ),
        (Approach, Dimple, Criterion::Fold),
        (
            Retraction,
            Ridge,
            Criterion::Symmetry(Shape::BreakUp { waves: 1 }),
        ),
    ] {
        let why = of(direction, from);
        assert_eq!(why.criterion, wanted, "{why:?}");
        assert!(why.sentence.contains(&format!("the {from}")), "{why:?}");
    }
    let ridge = of(Retraction, Ridge);
    // One wave to the cell of 256 ranges.
    assert!(ridge.sentence.contains("256.0 ranges long"), "{ridge:?}");
    let flat = of(Approach, Flat);
    assert!(matches!(flat.wave, Some([1, 0] | [0, 1])), "{flat:?}");
}

#[test]
fn under_a_spring_the_machine_is_a_side_of_the_criterion() {
    // Both sides are held against the measured eigenvalue at each jump.
    let scene = preset_on("soft-machine", Points::Square(48));
    let found = walked(&scene, -1.0);
    let by_the_machine = |(_, why): &&(JumpRecord, Explanation)| why.sentence.contains("machine");
    assert!(found.iter().filter(by_the_machine).count() > 0, "{found:?}");
    // The stage is told in ranges, of which one is 1 here.
    let placed = |(jump, why): &(JumpRecord, Explanation)| {
        jump.cause == Cause::FlatLimit
            || why.sentence.contains(&format!("w = {:.3} ρ", jump.control))
    };
    assert!(found.iter().all(placed), "{found:?}");
    assert!(
        found.iter().all(|(_, why)| why.balance.is_some()),
        "{found:?}"
    );
}

#[test]
fn a_jump_of_the_mesh_says_which_mesh_has_none_and_a_contested_one_its_shares() {
    let scene = preset_on("fig2", Points::Square(16));
    let model = scene.model().unwrap();
    assert!(model.mu_rho > 0.5);
    let said = |jump: &JumpRecord| {
        let evidence = Evidence { jump, fields: None };
        explain(&scene, &model, evidence).sentence
    };
    let mesh = said(&jump(Cause::Mesh, 2.0, 2.0));
    // mu_rho goes with the root of the spacing.
    let points = (16.0 * (model.mu_rho / 0.5).powi(2)).ceil();
    for words in [
        "The mesh lies",
        "16.00 ranges",
        &format!("With {points} points"),
    ] {
        assert!(mesh.contains(words), "{words} in {mesh}");
    }
    let share = |pattern, share| Share { pattern, share };
    let landings = vec![share(Pattern::Ridge, 0.57), share(Pattern::Bulge, 0.43)];
    let contested = said(&JumpRecord {
        landings,
        ..jump(Cause::FlatLimit, 3.1, 3.1)
    });
    assert!(contested.contains("ridge 57 % / bulge 43 %"), "{contested}");
}

/// A record of one flat state.
fn at_rest(scene: &Scene, u0: f64, direction: Direction) -> LoopRecord {
    let mut walk = Walk::start(scene, Default::default(), &Cancel::default()).unwrap();
    walk.set_target(u0);
    while walk.step(&Cancel::default(), &mut |_| {}) == Progress::Working {}
    let state = StateRecord {
        direction,
        ..walk.record().clone()
    };
    let mut record = LoopRecord::of(scene.control());
    record.states.push(state);
    record
}

#[test]
fn what_is_ahead_is_told_before_anything_has_snapped() {
    let scene = preset("fig2");
    let model = scene.model().unwrap();
    let (_, upper) = flat_limits(&model.law, model.grid.length).unwrap();
    let record = at_rest(&scene, 3.9, Direction::Approach);
    let words = ahead(&scene, &model, &record);
    assert!(
        words.contains(&format!("It snaps at u₀ = {upper:.4} ρ on the way down")),
        "{words}"
    );
    let record = at_rest(&scene, 3.9, Direction::Retraction);
    let words = ahead(&scene, &model, &record);
    assert!(words.contains("No jump is near on the way up"), "{words}");

    let mut shallow = scene.clone();
    shallow.drive.turn = tackscope::scene::Turn::At(3.5);
    let record = at_rest(&shallow, 3.9, Direction::Approach);
    let words = ahead(&shallow, &model, &record);
    assert!(words.contains("beyond the end of the drive"), "{words}");
}

#[test]
fn below_the_critical_length_nothing_snaps_and_the_remedy_is_said() {
    let mut scene = preset("fig2");
    let critical = critical_length(&scene.model().unwrap().law);
    let calm_at = |scene: &mut Scene, length: f64| {
        scene.cell.length = length;
        calm(scene, &scene.model().unwrap())
    };
    assert_eq!(calm_at(&mut scene, 1.01 * critical), None);
    let calm = calm_at(&mut scene, 0.99 * critical).expect("it is too short");
    assert_eq!(calm.remedy, "Make the cell longer.");
    assert!(
        calm.reason.contains(&format!("L_c = {critical:.1} ranges")),
        "{calm:?}"
    );
    let model = scene.model().unwrap();
    let words = ahead(&scene, &model, &LoopRecord::default());
    assert!(
        words.starts_with("Here nothing snaps. Make the cell longer."),
        "{words}"
    );
}
