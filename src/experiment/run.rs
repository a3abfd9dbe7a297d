//! A whole loop in one call: approach, retraction, and what they add up to.

use super::atlas::{Atlas, Unmapped};
use super::plan::{Plan, Reduction, Road};
use super::record::{Branch, JumpRecord, LoopRecord, StateRecord};
use super::scene::{Scene, SceneError, Turn};
use super::walk::{Counts, Happening, Progress, Walk};
use crate::numerics::cancel::Cancel;
use crate::numerics::precision::Precision;
use crate::physics::pattern::Pattern;
use crate::solver::method::MethodKind;
use ndarray::Array2;

/// A loop, complete or as far as it came.
#[derive(Clone, Debug)]
pub struct LoopRun {
    /// States and jumps.
    pub record: LoopRecord,
    /// How it ended.
    pub outcome: Outcome,
    /// What it cost.
    pub counts: Counts,
    /// A picture of each pattern where it was first reached.
    pub landings: Vec<Landing>,
}

/// How a loop ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// Closed.
    Completed,
    /// The solver could not go on; everything before stands.
    NotConverged {
        /// Last u0 reached (length).
        mean_displacement: f64,
        /// What happened.
        reason: String,
    },
    /// Somebody asked to stop; everything before stands.
    Cancelled,
}

/// The surface just after a jump (or at the start).
#[derive(Clone, Debug)]
pub struct Landing {
    /// Direction of the drive.
    pub branch: Branch,
    /// Where (length).
    pub mean_displacement: f64,
    /// What it shows.
    pub pattern: Pattern,
    /// Gap field (length), shape (ny, nx).
    pub gap: Array2<f64>,
}

/// What a loop reports while it runs.
#[derive(Clone, Copy, Debug)]
pub enum Report<'a> {
    /// A new state, and the share of the loop that is done.
    State {
        /// The state.
        record: &'a StateRecord,
        /// 0 to 1.
        fraction: f64,
    },
    /// A jump.
    Jump(&'a JumpRecord),
}

/// Runs the closed loop of `scene` on the whole cell: from the start of its drive to the turning point and back.
///
/// # Errors
/// The first value of the scene that is not allowed. Failures on the way are an [`Outcome`].
pub fn run_loop(
    scene: &Scene,
    method: MethodKind,
    cancel: &Cancel,
    observe: &mut dyn FnMut(Report<'_>),
) -> Result<LoopRun, SceneError> {
    run_reduced(scene, method, Reduction::Whole, cancel, observe)
}

/// Runs the closed loop on the road of `plan`; where an atlas finds that it does not hold this scene, on the whole cell. The second
/// value says in words why, if it did not come as planned.
///
/// # Errors
/// As [`run_loop`].
pub fn run_planned(
    scene: &Scene,
    method: MethodKind,
    plan: &Plan,
    cancel: &Cancel,
    observe: &mut dyn FnMut(Report<'_>),
) -> Result<(LoopRun, Option<String>), SceneError> {
    let chart = match plan.road {
        Road::Walk(reduction) => return run_reduced(scene, method, reduction, cancel, observe).map(|run| (run, None)),
        Road::Atlas(chart) => chart,
    };
    let model = scene.model()?;
    let mut atlas = Atlas::new(chart);
    let toured = match scene.drive.turn {
        Turn::At(turn) => atlas.tour(scene, turn, &model, cancel, observe),
        Turn::ZeroLoad => Err(Unmapped("the turn at zero load is for uneven ground".to_owned())),
    };
    match toured {
        Ok(run) => Ok((run, None)),
        Err(reason) => {
            let run = run_loop(scene, method, cancel, observe)?;
            Ok((run, Some(format!("walked on the whole cell after all: {reason}"))))
        }
    }
}

/// The same on a part of the cell.
///
/// # Errors
/// As [`run_loop`].
pub fn run_reduced(
    scene: &Scene,
    method: MethodKind,
    reduction: Reduction,
    cancel: &Cancel,
    observe: &mut dyn FnMut(Report<'_>),
) -> Result<LoopRun, SceneError> {
    run_in_precision(scene, method, reduction, Precision::Double, cancel, observe)
}

/// The same with other numbers.
///
/// # Errors
/// As [`run_loop`].
pub fn run_in_precision(
    scene: &Scene,
    method: MethodKind,
    reduction: Reduction,
    precision: Precision,
    cancel: &Cancel,
    observe: &mut dyn FnMut(Report<'_>),
) -> Result<LoopRun, SceneError> {
    let walk = Walk::in_precision(scene, method.build(scene.seed), reduction, precision)?;
    Ok(run_walk(walk, scene, cancel, observe))
}

/// The same with a walk that stands at the start of the drive of `scene`.
pub fn run_walk(mut walk: Walk, scene: &Scene, cancel: &Cancel, observe: &mut dyn FnMut(Report<'_>)) -> LoopRun {
    let mut run =
        LoopRun { record: LoopRecord::default(), outcome: Outcome::Completed, counts: Counts::default(), landings: Vec::new() };
    run.record.states.push(walk.record().clone());
    let start = scene.drive.start;
    let (mut turn, wait_for_load) = match scene.drive.turn {
        Turn::At(turn) => (turn, false),
        // Far below anything a tip under tension can need; the sign of the stress ends the approach.
        Turn::ZeroLoad => (start - 1e3 * (start.abs() + scene.cell.length), true),
    };
    let mut lowest = start;
    walk.set_target(turn);
    let mut retracting = false;
    let mut landed = true;
    loop {
        let mut fresh = false;
        let progress = walk.step(cancel, &mut |happening| match happening {
            Happening::Moving { .. } => {}
            Happening::Jump(jump) => {
                landed = true;
                observe(Report::Jump(&jump));
                run.record.jumps.push(jump);
            }
            Happening::State(state) => {
                fresh = true;
                lowest = lowest.min(state.mean_displacement);
                let depth = if wait_for_load { f64::INFINITY } else { start - turn };
                let gone = if retracting {
                    1.0 + (state.mean_displacement - lowest) / (start - lowest)
                } else {
                    (start - state.mean_displacement) / depth
                };
                observe(Report::State { record: &state, fraction: 0.5 * gone.clamp(0.0, 2.0) });
                run.record.states.push(state);
            }
        });
        if fresh && std::mem::take(&mut landed) {
            let gap = walk.gap();
            let record = walk.record();
            run.landings.push(Landing {
                branch: record.branch,
                mean_displacement: record.mean_displacement,
                pattern: record.pattern,
                gap,
            });
        }
        let record = walk.record();
        if fresh && wait_for_load && !retracting && record.pattern == Pattern::Contact && record.stress <= 0.0 {
            turn = record.mean_displacement;
            walk.set_target(turn);
        }
        match progress {
            Progress::Working => {}
            Progress::Resting if retracting => break,
            Progress::Resting => {
                retracting = true;
                walk.set_target(start);
            }
            Progress::Cancelled => {
                run.outcome = Outcome::Cancelled;
                break;
            }
            Progress::Stuck(reason) => {
                run.outcome = Outcome::NotConverged { mean_displacement: walk.record().mean_displacement, reason };
                break;
            }
        }
    }
    run.counts = walk.counts();
    run
}
