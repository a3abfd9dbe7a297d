//! The closed loops behind the figures, run by a walk or as planned; and those of line cells, with
//! what is read off them.
//!
//! A line cell has the ridge alone: without a width it has no room for bulges and dimples. All use
//! a Morse law of range 1 and gamma = 0.15, as in Figs 2 and 3, or another law in its place; the
//! length of the cell then sets rho~. Results are reduced by [`Units`].

use super::scenes;
use super::task::{Stopped, Task};
use crate::follow::record::{Direction, StateRecord};
use crate::follow::run::{LoopRun, Outcome, Report, run_loop};
use crate::follow::walk::WalkOptions;
use crate::numerics::cancel::Cancel;
use crate::physics::parameter::Refusal;
use crate::physics::pattern::Pattern;
use crate::physics::theory::Units;
use crate::scene::part::Part;
use crate::scene::{Model, Points, Scene};
use crate::solver::methods::MethodKind;
use crate::study::plan::{plan, run_as_planned};
use ndarray::Array2;

/// Runs the closed loop of `scene` by a walk with these options, and tells how far it is.
pub(super) fn walked(
    scene: &Scene,
    options: WalkOptions,
    task: &mut Task<'_>,
) -> Result<LoopRun, Stopped> {
    seen(scene, options, task, &mut |_, _| {})
}

/// The same, showing every state with its gap.
pub(super) fn seen(
    scene: &Scene,
    options: WalkOptions,
    task: &mut Task<'_>,
    see: &mut dyn FnMut(&StateRecord, &Array2<f64>),
) -> Result<LoopRun, Stopped> {
    task.tell(0.0, &scene.title)?;
    closed(scene, task, &scene.title, |cancel, observe| {
        run_loop(scene, options, cancel, &mut |report| {
            if let Report::State { record, fields, .. } = &report {
                see(record, fields[0]);
            }
            observe(report);
        })
    })
}

/// The closed loop of `scene` as planned, without an error bar; `what` is told to be done.
pub(super) fn planned(
    scene: &Scene,
    task: &mut Task<'_>,
    what: &str,
) -> Result<(LoopRun, Model), Stopped> {
    let model = scene.model().map_err(|error| refused(scene, error))?;
    let plan = plan(scene, &model, None);
    let run = closed(scene, task, what, |cancel, observe| {
        run_as_planned(scene, MethodKind::NewtonKrylov, &plan, cancel, observe)
    })?;
    Ok((run, model))
}

/// The loop that `run` runs, if it closes.
fn closed(
    scene: &Scene,
    task: &mut Task<'_>,
    what: &str,
    run: impl FnOnce(&Cancel, &mut dyn FnMut(Report<'_>)) -> Result<LoopRun, Refusal>,
) -> Result<LoopRun, Stopped> {
    let cancel = task.cancel;
    let run = run(cancel, &mut |report| {
        if let Report::State { fraction, .. } = report {
            // A request to stop ends the loop by itself.
            let _ = task.tell(fraction, what);
        }
    })
    .map_err(|error| refused(scene, error))?;
    let failed = |why: String| Err(Stopped::Failed(format!("{}: {why}", scene.title)));
    match &run.outcome {
        Outcome::Completed => match run.record.ledger(1.0).open {
            None => Ok(run),
            Some(open) => failed(format!("loop not closed: {}", open.reason)),
        },
        Outcome::Cancelled => Err(Stopped::Cancelled),
        Outcome::NotConverged {
            mean_displacement,
            reason,
        } => failed(format!("stopped at u0 = {mean_displacement}: {reason}")),
    }
}

/// A value of the scene that is not allowed.
pub(super) fn refused(scene: &Scene, error: Refusal) -> Stopped {
    Stopped::Failed(format!("{}: {error}", scene.title))
}

/// The units of a cell of side `length`.
pub(super) fn units(length: f64) -> Units {
    Units {
        length,
        surface_energy: scenes::SURFACE_ENERGY,
    }
}

/// The units of a scene.
pub(super) fn units_of(model: &Model) -> Units {
    Units {
        length: model.grid.length,
        surface_energy: model.law.surface_energy,
    }
}

/// A line cell of side `length` on `points`, driven from `start` to `turn` and back in steps of
/// `step` (all three u~).
pub(super) fn line_cell(
    title: &str,
    length: f64,
    points: usize,
    [start, turn, step]: [f64; 3],
) -> Scene {
    let unit = units(length).displacement();
    scenes::flat(
        title,
        length,
        Points::Line(points),
        start * unit,
        turn * unit,
        step * unit,
    )
}

/// Runs the closed loop of a line cell on this part of it.
pub(super) fn on_part(scene: &Scene, part: Part, task: &mut Task<'_>) -> Result<LoopRun, Stopped> {
    let options = WalkOptions {
        part,
        ..WalkOptions::default()
    };
    walked(scene, options, task)
}

/// (u~, p~) of a state.
pub(super) fn reduced(units: &Units, state: &StateRecord) -> [f64; 2] {
    let u0 = state.mean_displacement;
    [units.reduce(u0), units.pressure(state.stress, u0)]
}

/// (u~, p~) of the ridges of one direction.
pub(super) fn ridges(run: &LoopRun, units: &Units, direction: Direction) -> Vec<[f64; 2]> {
    let states = run
        .record
        .states
        .iter()
        .filter(|s| s.direction == direction && s.pattern == Pattern::Ridge);
    states.map(|state| reduced(units, state)).collect()
}

/// The ends (lowest and highest u~) of the ridge over both directions; `None` if there was none.
pub(super) fn ends(run: &LoopRun, units: &Units) -> Option<[f64; 2]> {
    let ridges = run
        .record
        .states
        .iter()
        .filter(|s| s.pattern == Pattern::Ridge)
        .map(|s| units.reduce(s.mean_displacement));
    ridges.fold(None, |ends, u| {
        ends.map_or(Some([u, u]), |[low, high]: [f64; 2]| {
            Some([low.min(u), high.max(u)])
        })
    })
}

/// At most one of `points` in every interval `spacing` of x, and the last: symbols that do not
/// cover each other.
pub(super) fn thinned(points: Vec<[f64; 2]>, spacing: f64) -> Vec<[f64; 2]> {
    let mut kept: Vec<[f64; 2]> = Vec::new();
    let end = points.last().copied();
    for point in points {
        if kept
            .last()
            .is_none_or(|last| (point[0] - last[0]).abs() >= spacing)
        {
            kept.push(point);
        }
    }
    if kept.last() != end.as_ref() {
        kept.extend(end);
    }
    kept
}
