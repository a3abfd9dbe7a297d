//! The scenes of the paper as values, for the figures and for the window; and the closed loops behind
//! the figures, run by a walk or as planned, with what is read off them, reduced by [`Units`].

use super::figure::{Stopped, Task};
use crate::follow::record::{Direction, StateRecord};
use crate::follow::run::{LoopRun, Outcome, Report, run_loop};
use crate::follow::walk::WalkOptions;
use crate::numerics::cancel::Cancel;
use crate::physics::body::Body;
use crate::physics::grid::Grid;
use crate::physics::indenter::{Hertz, Indenter, Rough};
use crate::physics::law::{Morse, Shape};
use crate::physics::parameter::Refusal;
use crate::physics::pattern::Pattern;
use crate::physics::theory::Units;
use crate::scene::part::Part;
use crate::scene::{Cell, Drive, LawChoice, Model, Points, Range, Scene, Turn};
use crate::solver::methods::MethodKind;
use crate::study::plan::{plan, run_as_planned};
use ndarray::Array2;

/// gamma of the flat scenes in units of E* rho.
pub const SURFACE_ENERGY: f64 = 0.15;

fn morse(surface_energy: f64, range: Range) -> LawChoice {
    LawChoice {
        shape: Shape::Morse(Morse),
        surface_energy,
        range,
    }
}

/// Flat ground with the Morse law of range 1 and gamma = 0.15, as in Figs 2 to 4: a cell of side
/// `length` on `points`, driven from `start` to `turn` and back.
pub fn flat(title: &str, length: f64, points: Points, start: f64, turn: f64, step: f64) -> Scene {
    Scene {
        title: title.to_owned(),
        source: "Wang, Zhou, Mueser 2020".to_owned(),
        cell: Cell { length, points },
        body: Body::HalfSpace,
        law: morse(SURFACE_ENERGY, Range::Length(1.0)),
        indenter: Indenter::Flat,
        drive: Drive {
            control: Default::default(),
            start,
            turn: Turn::At(turn),
            step,
        },
        accuracy: 0.01,
        seed: 1,
        units: None,
    }
}

/// Fig. 2, as the preset `fig2`.
pub fn figure_2() -> Scene {
    flat(
        "Fig. 2: four patterns",
        256.0,
        Points::Square(64),
        4.2,
        0.2,
        0.02,
    )
}

/// Fig. 3, as the preset `fig3`.
pub fn figure_3() -> Scene {
    flat(
        "Fig. 3: a longer cell, no bulge",
        1024.0,
        Points::Square(256),
        9.0,
        0.2,
        0.04,
    )
}

/// The ridge alone, as the preset `ridge-line`: fields uniform along y.
pub fn ridge_line() -> Scene {
    flat(
        "A line cell: only the ridge",
        256.0,
        Points::Line(256),
        4.4,
        0.2,
        0.02,
    )
}

/// Rough ground for Fig. 14, `waves` of the longest self-affine waves along a side. The drive goes
/// from 1.5 above the crest down to a mean gap of `turn`. Lengths are in root mean square heights.
///
/// The paper gives the range, 0.23, and leaves surface and gamma open. Here the Hurst exponent is
/// 0.8, the self-affine wavelengths go from 8 to 2, which makes a root mean square gradient near 1,
/// and gamma = 0.2 E* h_rms, which makes a small hysteresis.
pub fn rough(waves: usize, seed: u64, turn: f64) -> Scene {
    let length = 8.0 * waves as f64;
    let points = 32 * waves;
    let surface = Rough {
        hurst: 0.8,
        rms: 1.0,
        longest: 8.0,
        shortest: 2.0,
        seed,
    };
    let mean = surface.mean_height(&Grid::square(length, points));
    let (start, turn, step) = (1.5, mean + turn, 0.01);
    let mesh = Points::Square(points);
    Scene {
        law: morse(0.2, Range::Length(0.23)),
        indenter: Indenter::Rough(surface),
        ..flat("Fig. 14: rough ground", length, mesh, start, turn, step)
    }
}

/// gamma of the tip in units of E* R.
pub const TIP_SURFACE_ENERGY: f64 = 0.5859e-3;

/// The tip of Sect. 4 in a cell with L = R = 1, driven by displacement to zero load and back.
pub fn tip(points: usize, mu_rho: f64) -> Scene {
    let range = (TIP_SURFACE_ENERGY / points as f64).sqrt() / (2.0 * mu_rho);
    // Single points that let go are close together on the way.
    let step = if mu_rho < 0.75 { 0.15 } else { 0.05 };
    // JKR lets go at 0.0113; a longer range acts from farther off, and a mesh that traps the edge of
    // the contact holds on for longer.
    let start = 0.012 + 4.0 * range + 0.02 * (mu_rho - 0.7).max(0.0);
    let title = format!("A Hertzian tip: mu_rho = {mu_rho}");
    let mut scene = Scene {
        source: "Wang, Zhou, Mueser 2020, Figs 12 and 13".to_owned(),
        law: morse(TIP_SURFACE_ENERGY, Range::MuRho(mu_rho)),
        indenter: Indenter::Hertz(Hertz { radius: 1.0 }),
        ..flat(
            &title,
            1.0,
            Points::Square(points),
            start,
            f64::NAN,
            step * range,
        )
    };
    scene.drive.turn = Turn::ZeroLoad;
    scene
}

/// A cylinder under tension, for the schematic of Fig. 1.
pub fn figure_1() -> Scene {
    let title = "Fig. 1: a cylinder, seen from the side";
    Scene {
        source: "Wang, Zhou, Mueser 2020, Fig. 1".to_owned(),
        law: morse(0.3, Range::Length(0.2)),
        indenter: Indenter::Hertz(Hertz { radius: 4.0 }),
        ..flat(title, 8.0, Points::Line(256), 1.0, -0.6, 0.02)
    }
}

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

/// The units of a cell of side `length` with that gamma.
pub(super) fn units(length: f64) -> Units {
    Units {
        length,
        surface_energy: SURFACE_ENERGY,
    }
}

/// The units of a scene.
pub(super) fn units_of(model: &Model) -> Units {
    Units::of(&model.law, model.grid.length)
}

/// A line cell, which has the ridge alone: without a width it has no room for bulges and dimples. Of
/// side `length` on `points`, driven from `start` to `turn` and back in steps of
/// `step` (all three u~).
pub(super) fn line_cell(
    title: &str,
    length: f64,
    points: usize,
    [start, turn, step]: [f64; 3],
) -> Scene {
    let unit = units(length).displacement();
    flat(
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
