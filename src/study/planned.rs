//! A loop on the strategy of its plan, with its error bar and the loops of other landings.

use super::error_bar::error_bar;
use super::plan::Plan;
use crate::follow::atlas::{Atlas, Cycle, Meshes, Unmapped};
use crate::follow::record::JumpRecord;
use crate::follow::run::{LoopRun, Report, RivalLoop, run_loop, walked_after_all};
use crate::follow::walk::WalkOptions;
use crate::numerics::cancel::Cancel;
use crate::physics::parameter::Refusal;
use crate::scene::part::Strategy;
use crate::scene::{Model, Scene, Turn};
use crate::solver::methods::MethodKind;

/// Runs the closed loop on the strategy of `plan`, with its error bar and the loops of other
/// landings; where an atlas finds that it does not hold this scene, on the whole cell.
///
/// # Errors
/// As [`run_loop`].
pub fn run_planned(
    scene: &Scene,
    method: MethodKind,
    plan: &Plan,
    cancel: &Cancel,
    observe: &mut dyn FnMut(Report<'_>),
) -> Result<LoopRun, Refusal> {
    let (mut run, model) = (
        run_as_planned(scene, method, plan, cancel, observe)?,
        scene.model()?,
    );
    run.error_bar = error_bar(scene, &model, &run, cancel);
    run.rivals = rival_loops(scene, &model, &run, cancel);
    Ok(run)
}

/// The loops of other landings of a contested one.
fn rival_loops(scene: &Scene, model: &Model, run: &LoopRun, cancel: &Cancel) -> Vec<RivalLoop> {
    let Turn::At(turn) = scene.drive.turn else {
        return Vec::new();
    };
    if run.record.jumps.iter().all(|jump| jump.landings.is_empty()) {
        return Vec::new();
    }
    let mut atlas = Atlas::new(Meshes::new(&model.law, model.grid.length, model.grid.nx));
    atlas.obey(cancel);
    // Its landings are known once it has been round.
    let _ = atlas.cycle(scene.drive.start, turn);
    rivals(&mut atlas, &run.record.jumps, scene.drive.start, turn)
}

/// The loops from `start` to `turn` and back that `atlas` knows beside the one with these `jumps`.
pub(super) fn rivals(
    atlas: &mut Atlas,
    jumps: &[JumpRecord],
    start: f64,
    turn: f64,
) -> Vec<RivalLoop> {
    let contested: Vec<_> = jumps
        .iter()
        .filter(|jump| !jump.landings.is_empty())
        .collect();
    let loss = |cycle: Result<Cycle, Unmapped>| cycle.ok().map(|cycle| cycle.dissipated_energy);
    let others = atlas.contested_cycles(start, turn).into_iter();
    let others =
        others.filter(|(landing, _)| contested.iter().all(|jump| jump.to != landing.pattern));
    others
        .map(|(landing, cycle)| RivalLoop {
            landing,
            dissipated_energy: loss(cycle),
        })
        .collect()
}

fn run_as_planned(
    scene: &Scene,
    method: MethodKind,
    plan: &Plan,
    cancel: &Cancel,
    observe: &mut dyn FnMut(Report<'_>),
) -> Result<LoopRun, Refusal> {
    if let Strategy::Walk(part) = plan.strategy {
        return run_loop(
            scene,
            WalkOptions {
                part,
                ..method.into()
            },
            cancel,
            observe,
        );
    }
    let model = scene.model()?;
    let mut atlas = Atlas::new(Meshes::new(&model.law, model.grid.length, model.grid.nx));
    let toured = match scene.drive.turn {
        Turn::At(turn) => atlas.tour(scene, turn, &model, cancel, observe),
        Turn::ZeroLoad => Err(Unmapped::anywhere(
            "the turn at zero load is for uneven ground",
        )),
    };
    toured.or_else(|reason| {
        let run = run_loop(scene, method.into(), cancel, observe)?;
        Ok(LoopRun {
            deviation: Some(walked_after_all(&reason.to_string())),
            ..run
        })
    })
}
