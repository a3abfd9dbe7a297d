//! The atlas of branches against the walk on the whole cell, and against itself on finer meshes.

use crate::dense::Dense;
use crate::loops::{assert_same_jumps, assert_stable, driven, preset, preset_on, walked};
use crate::walk::fig2;
use ndarray::Array2;
use std::sync::{Arc, OnceLock};
use tackscope::follow::atlas::{Atlas, Branch, Cycle, End, Meshes};
use tackscope::follow::record::{JumpRecord, StateRecord};
use tackscope::follow::run::LoopRun;
use tackscope::physics::control::Control;
use tackscope::physics::law::{Law, Mie, Morse, Shape};
use tackscope::physics::mesh::{Grid, mesh_error, mu_rho, next_fast};
use tackscope::physics::theory::critical_length;
use tackscope::scene::{Part, Points, Scene, Strategy, Turn};
use tackscope::solver::Stop;
use tackscope::solver::sector::{Sector, Side};
use tackscope::study::plan::plan;

fn morse(range: f64) -> Law {
    Law {
        shape: Shape::Morse(Morse),
        surface_energy: 0.15,
        range,
    }
}

fn planned(scene: &Scene) -> LoopRun {
    let plan = plan(scene, &scene.model().unwrap(), None);
    assert!(matches!(plan.strategy, Strategy::Atlas), "{}", plan.words());
    let run = crate::loops::planned(scene);
    assert_eq!(run.deviation, None);
    run
}

/// Of the preset fig2, computed once for all tests.
fn of_fig2() -> &'static LoopRun {
    static RUN: OnceLock<LoopRun> = OnceLock::new();
    RUN.get_or_init(|| planned(&preset("fig2")))
}

/// The same jumps, each within the walk's bracket of 1e-4 ranges and the asked share, and energies
/// within what they state.
fn assert_same(atlas: &[JumpRecord], walk: &[JumpRecord], share: f64) {
    let name = |j: &JumpRecord| (j.direction, j.from, j.to, j.cause);
    assert_eq!(
        atlas.iter().map(name).collect::<Vec<_>>(),
        walk.iter().map(name).collect::<Vec<_>>()
    );
    for (a, b) in atlas.iter().zip(walk) {
        let off = (a.control - b.control).abs();
        assert!(off < 1.1e-4 + share * b.control.abs(), "{a:?} {b:?}");
        let stated = a.release_error + b.release_error;
        assert!(
            (a.released_energy - b.released_energy).abs()
                < 1e-5 + share * b.released_energy + stated,
            "{a:?} {b:?}"
        );
    }
}

#[test]
fn atlas_and_walk_agree_on_every_jump_of_fig_2() {
    let [atlas, walk] = [of_fig2(), fig2()].map(|run| &run.record);
    assert_same(&atlas.jumps, &walk.jumps, 1e-4);
    let (a, b) = (atlas.released_energy_sum(), walk.released_energy_sum());
    assert!((a / b - 1.0).abs() < 1e-4, "{a} {b}");
}

/// The curves themselves: at every u0 both strategies stopped at, the stress, the pattern and the
/// energy.
#[test]
fn atlas_and_walk_agree_on_the_states_between_the_jumps() {
    let (walk, atlas) = (fig2(), of_fig2());
    let strongest = morse(1.0).traction_max();
    let mut compared = 0;
    for a in &atlas.record.states {
        let same = |b: &&StateRecord| {
            b.direction == a.direction
                && (b.mean_displacement - a.mean_displacement).abs() < 1e-9
                && b.pattern == a.pattern
        };
        if let Some(b) = walk.record.states.iter().find(same) {
            compared += 1;
            assert!(
                (a.stress - b.stress).abs() < 1e-4 * strongest,
                "{a:?} {b:?}"
            );
            assert!((a.energy - b.energy).abs() < 1e-6 * 0.15, "{a:?} {b:?}");
            // Both are Rayleigh quotients, so upper bounds: the lower one is the better one. Next
            // to a fold the walk may hold on to a mode that is not the softest.
            assert!(
                a.stiffness_min < b.stiffness_min + 0.02 + a.stiffness_error,
                "{a:?} {b:?}"
            );
        }
    }
    assert!(compared > 350, "{compared}");
}

#[test]
fn every_state_of_the_plan_is_converged_and_stable_and_its_ledger_closes() {
    let run = of_fig2();
    assert_stable(run, 1e-6);
    let mismatch = run.record.work() / 0.15 / run.record.released_energy_sum() - 1.0;
    assert!(mismatch.abs() < 1e-3, "{mismatch}");
}

#[test]
fn a_longer_cell_and_another_law_agree_with_the_walk_too() {
    let mut long = preset_on("fig2", Points::Square(96));
    long.cell.length = 512.0;
    let long = driven(long, Control::Displacement, [6.5, 0.2, 0.1]);
    // Under the walk's pattern a mesh point lies in the centre, under the atlas' none: their mesh
    // errors have opposite signs.
    assert_same(
        &planned(&long).record.jumps,
        &walked(&long, Part::Whole).record.jumps,
        1.5e-3,
    );

    let mut mie = preset_on("fig2", Points::Square(64));
    mie.law.shape = Shape::Mie(Mie { m: 8.0, n: 2.0 });
    mie.cell.length = 60.0;
    let mut mie = driven(mie, Control::Displacement, [4.0, 1.01, 0.05]);
    // On this flat ground the perturbation chooses between bulge and ridge: some seed makes the
    // walk choose as the atlas did.
    let atlas = planned(&mie).record.jumps;
    let walk = (1..=8)
        .map(|seed| {
            mie.seed = seed;
            walked(&mie, Part::Whole).record.jumps
        })
        .find(|jumps| jumps[0].to == atlas[0].to);
    assert_same(&atlas, &walk.unwrap(), 5e-4);
}

#[test]
fn a_drive_that_turns_in_mid_branch_is_read_off_too() {
    let mut scene = preset("fig2");
    for turn in [2.0, 2.95, 0.7] {
        scene.drive.turn = Turn::At(turn);
        assert_same(
            &planned(&scene).record.jumps,
            &walked(&scene, Part::Whole).record.jumps,
            1e-4,
        );
    }
}

#[test]
fn the_walk_on_the_even_quarter_agrees_with_the_whole_cell_on_flat_ground() {
    let quarter = walked(&preset("fig2"), Part::Quarter);
    assert_same(&quarter.record.jumps, &fig2().record.jumps, 1e-4);
}

#[test]
fn a_cell_below_the_critical_length_has_no_jump() {
    let law = morse(1.0);
    let length = 0.99 * critical_length(&law);
    let cycle = Atlas::new(Meshes::new(&law, length, 32))
        .cycle(4.0, 0.2)
        .unwrap();
    assert!(cycle.jumps.is_empty() && cycle.dissipated_energy == 0.0);
}

fn cycle(law: &Law, n: usize) -> (Atlas, Cycle) {
    let mut atlas = Atlas::new(Meshes::new(law, 256.0, n));
    let cycle = atlas.cycle(4.4, 0.2).unwrap();
    (atlas, cycle)
}

/// Warm and cold agree far within the target; both through quite different sequences of solves.
#[test]
fn an_adapted_atlas_is_the_one_made_afresh() {
    let (first, _) = cycle(&morse(1.0), 48);
    for change in [1.01, 0.99, 1.003, 1.02] {
        let law = morse(change);
        let (anew, fresh) = cycle(&law, 48);
        let mut adapted = first.adapted(Meshes::new(&law, 256.0, 48)).unwrap();
        let warm = adapted.cycle(4.4, 0.2).unwrap();
        assert_eq!(warm.jumps.len(), fresh.jumps.len());
        for (a, b) in warm.jumps.iter().zip(&fresh.jumps) {
            assert!(
                (a.mean_displacement - b.mean_displacement).abs() < 1e-4 * b.mean_displacement,
                "{change}: {a:?} {b:?}"
            );
        }
        assert!(
            (warm.dissipated_energy / fresh.dissipated_energy - 1.0).abs() < 1e-4,
            "{change}"
        );
        let spent = |atlas: &Atlas| atlas.transforms().iter().sum::<usize>();
        assert!(
            2 * spent(&adapted) < spent(&anew),
            "{} transforms of {}",
            spent(&adapted),
            spent(&anew)
        );
    }
}

#[test]
fn mesh_error_falls_exponentially_and_stays_below_what_is_predicted() {
    let (_, fine) = cycle(&morse(1.0), 96);
    let mut last = f64::INFINITY;
    for n in [24, 32, 40, 48, 64] {
        let (_, this) = cycle(&morse(1.0), n);
        let jumps = this
            .jumps
            .iter()
            .zip(&fine.jumps)
            .map(|(a, b)| (a.mean_displacement / b.mean_displacement - 1.0).abs());
        let error = jumps.fold(
            (this.dissipated_energy / fine.dissipated_energy - 1.0).abs(),
            f64::max,
        );
        let mu_rho = mu_rho(&morse(1.0), 256.0 / n as f64);
        let predicted = mesh_error(&morse(1.0), 256.0, mu_rho);
        println!("n = {n}: measured {error:.1e}, predicted {predicted:.1e}");
        assert!(error <= predicted, "{n}: {error:e} > {predicted:e}");
        assert!(error < last || error < 5e-5, "{n}");
        last = error;
    }
}

/// The scene of Fig. 2 under a spring of this stiffness, from flat to flat and back.
fn sprung(stiffness: f64) -> Scene {
    let spring = Control::Spring { stiffness };
    driven(preset("fig2"), spring, [9.0, -6.0, 0.25])
}

#[test]
fn the_loop_integral_along_the_atlas_is_what_the_jumps_release_under_every_machine() {
    let load = driven(preset("fig2"), Control::Load, [0.12, -0.05, 0.002]);
    for scene in [sprung(0.3), sprung(0.01), load] {
        let run = planned(&scene);
        let ledger = run.record.ledger(scene.law.surface_energy);
        let off = (ledger.loop_integral - ledger.released_energy_sum).abs();
        let stated = ledger.integral_error + 1e-3 * ledger.released_energy_sum;
        assert!(off < stated, "{:?}: {ledger:?}", scene.drive.control);
    }
}

/// All kinds of machine: a spring under which every pattern is met, those that skip the bulge and
/// the ridge, one under which the flat state falls as a block, and a load.
#[test]
fn atlas_and_walk_agree_under_springs_and_a_load() {
    let load = driven(preset("fig2"), Control::Load, [0.12, -0.05, 0.01]);
    let springs = [1e6, 10.0, 0.3, 0.05, 0.02, 0.01].map(sprung);
    for scene in springs.into_iter().chain([load]) {
        let (atlas, walk) = (planned(&scene), walked(&scene, Part::Quarter));
        assert_same(&atlas.record.jumps, &walk.record.jumps, 1e-5);
        let unit = scene.control().unit(&morse(1.0));
        for (a, b) in atlas.record.jumps.iter().zip(&walk.record.jumps) {
            assert!((a.control - b.control).abs() < 1e-5 * unit, "{a:?} {b:?}");
            let landed = [a, b].map(|jump| jump.mean_displacement_after);
            assert!((landed[0] - landed[1]).abs() < 3e-5, "{a:?} {b:?}");
        }
        let mut compared = 0;
        // Where it jumps it stands twice.
        let jumps = |control: f64| {
            let at = |jump: &JumpRecord| (jump.control - control).abs() < 1e-3 * unit;
            atlas.record.jumps.iter().any(at)
        };
        for a in atlas.record.states.iter().filter(|a| !jumps(a.control)) {
            let same = |b: &&StateRecord| {
                (b.direction, b.pattern) == (a.direction, a.pattern)
                    && (b.control - a.control).abs() < 1e-12
            };
            let Some(b) = walk.record.states.iter().find(same) else {
                continue;
            };
            compared += 1;
            assert!((a.stress - b.stress).abs() < 1e-5 * 0.075, "{a:?} {b:?}");
            // With the machine it is stationary in u0, which the residual leaves open a little.
            let [one, other] = [a, b].map(|state| {
                state.energy
                    + scene
                        .control()
                        .energy(state.control, state.mean_displacement)
            });
            assert!((one - other).abs() < 1e-7 * 0.15, "{a:?} {b:?}");
            assert!(a.stop == Stop::Stable && a.residual <= 1e-6, "{a:?}");
            let upper = b.stiffness_min + 0.02 + a.stiffness_error;
            assert!(a.stiffness_min < upper, "{a:?} {b:?}");
        }
        assert!(compared > 25, "{compared}");
    }
}

/// A branch under a spring ends where the stage, u0 + stress/k, turns back, by differences of the
/// curve, or where symmetry breaks, which no machine moves.
#[test]
fn a_spring_ends_a_branch_where_the_stage_turns_back() {
    let stiffness = 0.05;
    let meshes = Meshes::new(&morse(1.0), 256.0, 48);
    let mut soft = Atlas::new(meshes.under(Control::Spring { stiffness }));
    soft.cycle(9.0, -6.0).unwrap();
    let (stiff, _) = cycle(&morse(1.0), 48);
    let mut folds = 0;
    for branch in soft.branches() {
        for (side, end) in Side::BOTH.into_iter().zip(branch.ends) {
            let node = branch.end(side);
            if end == End::Fold {
                folds += 1;
                assert!(node.breaking > 0.0 && node.own > 0.0);
                let stage = |d: f64| {
                    let u0 = node.state.mean_displacement - side.sign() * d;
                    u0 + branch.at(u0).stress / stiffness
                };
                // A parabola: twice the distance, four times the change.
                let ratio = (stage(0.02) - stage(0.0)) / (stage(0.01) - stage(0.0));
                assert!((ratio - 4.0).abs() < 0.3, "{ratio}");
            } else {
                let same = |other: &&Arc<Branch>| {
                    (other.pattern, other.ends[side.index()]) == (branch.pattern, end)
                };
                let other = stiff.branches().iter().find(same).unwrap().end(side);
                let off = node.state.mean_displacement - other.state.mean_displacement;
                assert!(off.abs() < 1e-5, "{off}");
            }
        }
    }
    assert!(folds > 0);
}

#[test]
fn an_adapted_atlas_under_a_spring_is_the_one_made_afresh() {
    let made = |range: f64, stiffness: f64| {
        let meshes = Meshes::new(&morse(range), 256.0, 48);
        meshes.under(Control::Spring { stiffness })
    };
    let mut first = Atlas::new(made(1.0, 0.03));
    first.cycle(9.0, -6.0).unwrap();
    for (range, stiffness) in [(1.01, 0.03), (1.0, 0.0305), (0.99, 0.0295)] {
        let mut anew = Atlas::new(made(range, stiffness));
        let mut adapted = first.adapted(made(range, stiffness)).unwrap();
        let [warm, fresh] = [&mut adapted, &mut anew].map(|atlas| atlas.cycle(9.0, -6.0).unwrap());
        assert_same_jumps(&warm.jumps, &fresh.jumps, 1e-4);
        let off = warm.dissipated_energy / fresh.dissipated_energy - 1.0;
        assert!(off.abs() < 1e-4, "{range} {stiffness}: {off}");
        let spent = |atlas: &Atlas| atlas.transforms().iter().sum::<usize>();
        assert!(2 * spent(&adapted) < spent(&anew));
    }
}

/// The two ways a branch can end look as theory says: at a fold the tangent turns into the soft
/// mode and the stress falls like a root, at a breaking of symmetry the branch goes straight on.
#[test]
fn ends_of_branches_are_folds_or_breakings_as_their_nodes_say() {
    let (atlas, _) = cycle(&morse(1.0), 48);
    assert_eq!(atlas.branches().len(), 3);
    for branch in atlas.branches() {
        for (side, end) in Side::BOTH.into_iter().zip(branch.ends) {
            let node = branch.end(side);
            match end {
                End::Fold => {
                    assert!(!node.slope.is_finite() && node.breaking > 0.0);
                    let inside = |d: f64| {
                        branch
                            .at(node.state.mean_displacement - side.sign() * d)
                            .stress
                            - node.state.stress
                    };
                    // A root: four times the distance, twice the change.
                    let ratio = inside(4e-4) / inside(1e-4);
                    assert!((ratio - 2.0).abs() < 0.05, "{ratio}");
                }
                End::Breaking => {
                    assert!(node.slope.is_finite() && node.own > 0.0);
                    assert!(
                        node.breaking.abs() * 256.0 < 2e-3,
                        "{}",
                        node.breaking * 256.0
                    );
                }
                End::Flat => panic!("no pattern of this cell fades"),
            }
        }
        // dV/du0 = stress along the curve, by central differences.
        let (low, high) = branch.extent();
        for share in [0.2, 0.5, 0.8] {
            let (u0, h) = (low + share * (high - low), 1e-4);
            let slope = (branch.at(u0 + h).energy - branch.at(u0 - h).energy) / (2.0 * h);
            assert!(
                (slope - branch.at(u0).stress).abs() < 1e-5 * 0.075,
                "{slope}"
            );
        }
    }
}

#[test]
fn meshes_of_the_plan_are_quick_to_transform_on_a_quarter_cell() {
    for n in [1, 17, 40, 49, 100, 200, 513] {
        let fast = next_fast(n);
        assert!(fast >= n && fast.is_multiple_of(8));
        let mut rest = fast;
        for p in [2, 3, 5] {
            while rest.is_multiple_of(p) {
                rest /= p;
            }
        }
        assert_eq!(rest, 1);
    }
}

/// The blocks are of modulations along y; the matrix knows of none.
#[test]
fn a_ridge_is_as_soft_as_the_dense_hessian_of_the_whole_cell_says_stable_or_not() {
    let (length, n) = (128.0, 24);
    let law = morse(1.0);
    let mut sector = Sector::ridge(length, n, law);
    let dense = Dense::new(Grid::square(length, n), f64::INFINITY);
    let (mut stable, mut unstable) = (0, 0);
    for u0 in [0.7, 0.8, 0.9, 1.0, 1.2, 1.6, 2.0, 2.4, 2.6, 2.8, 2.9] {
        let mut kick = vec![0.0; sector.system().dimension()];
        kick[1] = -law.range;
        let settled = sector.settle(u0, kick).expect("a ridge");
        let found = sector.measure(u0, settled, None, 1e-8).expect("a ridge");
        let line = sector.system().unfolded(&found.fields.gap);
        let gap = Array2::from_shape_fn((n, n), |(_, i)| line[[0, i]]);
        let a = dense.at(&gap, &gap, &law, [true; 2], true);
        let softest = a.symmetric_eigenvalues().min();
        let (value, error) = (found.stiffness.value, found.stiffness.error);
        assert!(
            (value - softest).abs() <= error.max(1e-8),
            "{value:e} +- {error:e}, not {softest:e} at {u0}"
        );
        *(if softest > 0.0 {
            &mut stable
        } else {
            &mut unstable
        }) += 1;
    }
    assert!(stable > 1 && unstable > 1, "{stable} {unstable}");
}
