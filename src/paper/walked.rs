//! A closed loop, run for a figure.

use super::task::{Stopped, Task};
use crate::follow::run::{LoopRun, Outcome, Report, run_loop};
use crate::follow::walk::WalkOptions;
use crate::physics::parameter::Refusal;
use crate::scene::Scene;

/// Runs the closed loop of `scene` by a walk with these options, and tells how far it is.
pub(super) fn run(
    scene: &Scene,
    options: WalkOptions,
    task: &mut Task<'_>,
) -> Result<LoopRun, Stopped> {
    task.tell(0.0, &scene.title)?;
    let cancel = task.cancel;
    let run = run_loop(scene, options, cancel, &mut |report| {
        if let Report::State { fraction, .. } = report {
            // A request to stop ends the loop by itself.
            let _ = task.tell(fraction, &scene.title);
        }
    });
    completed(run.map_err(|error| refused(scene, error))?, scene)
}

/// The loop if it is closed.
pub(super) fn completed(run: LoopRun, scene: &Scene) -> Result<LoopRun, Stopped> {
    match &run.outcome {
        Outcome::Completed => match run.record.ledger(1.0).open {
            None => Ok(run),
            Some(open) => Err(Stopped::Failed(format!(
                "{}: loop not closed: {}",
                scene.title, open.reason
            ))),
        },
        Outcome::Cancelled => Err(Stopped::Cancelled),
        Outcome::NotConverged {
            mean_displacement,
            reason,
        } => Err(Stopped::Failed(format!(
            "{}: stopped at u0 = {mean_displacement}: {reason}",
            scene.title
        ))),
    }
}

/// A value of the scene that is not allowed.
pub(super) fn refused(scene: &Scene, error: Refusal) -> Stopped {
    Stopped::Failed(format!("{}: {error}", scene.title))
}
