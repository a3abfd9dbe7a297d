//! The plan: the cheapest model that meets the asked accuracy, in words, with the error and the
//! cost it expects; and a loop on its strategy, with the loops of other landings and its error bar:
//! how far its loss and its jumps are from those of a finer mesh; and the part of the cell of a walk
//! that a hand leads.
//!
//! What a mesh is worth is known beforehand only as a bound
//! ([`crate::physics::mesh::mesh_error`]): the errors of two scenes on equally fine meshes differ
//! by a factor of ten. Afterwards a second, finer mesh tells. The error falls exponentially with the
//! number of points, so that of the finer mesh hardly counts beside that of the loop.

use crate::follow::atlas::{Atlas, Cycle, Meshes, Unmapped};
use crate::follow::diagram::{Diagram, Observe};
use crate::follow::flat_branch::FlatBranch;
use crate::follow::record::JumpRecord;
use crate::follow::run::{LoopRun, Outcome, Report, RivalLoop, run_loop, walked_after_all};
use crate::follow::walk::WalkOptions;
use crate::numerics::threads::{Cancel, beside};
use crate::physics::body::Body;
use crate::physics::indenter::Indenter;
use crate::physics::mesh::{self, next_fast};
use crate::physics::parameter::Refusal;
use crate::scene::{Model, Part, Range, Scene, Strategy, Turn, no_quarter};
use crate::solver::methods::MethodKind;

/// The decision, with its reason.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// What is done.
    pub strategy: Strategy,
    /// Which models, on which meshes, and why.
    place: String,
    /// Expected relative error of the dissipated energy and of the jumps' places, whichever is larger;
    /// 1 where nothing can be promised (a coarse mesh, a law whose stiffness jumps), NaN where
    /// nothing is known (uneven ground).
    pub predicted_error: f64,
    /// Expected seconds for the loop, to a factor of two or three, on one core.
    pub predicted_seconds: f64,
}

impl Plan {
    /// The same carried out by a method: nothing is promised of states that need not be at rest.
    pub fn by(self, method: MethodKind) -> Self {
        if method == MethodKind::Gfmd {
            return Self {
                predicted_error: f64::NAN,
                ..self
            };
        }
        self
    }

    /// In one sentence: which models, on which meshes, why, and what is promised.
    pub fn words(&self) -> String {
        format!("{}; {}", self.place, promise(Some(self.predicted_error)))
    }

    /// What was done in the end, where a run had to deviate from it.
    pub fn carried_out(&self, deviation: Option<&str>) -> Strategy {
        deviation.map_or(self.strategy, |_| Strategy::WHOLE)
    }
}

/// What is expected of a model on flat ground; of a layer nothing is known, and promised.
fn flat_error(model: &Model) -> f64 {
    if model.body == Body::HalfSpace {
        mesh::flat_error(&model.law, model.grid.length, model.mu_rho)
    } else {
        1.0
    }
}

/// Largest mu_rho at which a tip may be left to its even quarter.
const EVEN_TIP: f64 = 0.9;

/// Decides how to compute the loop of `scene`, whose open choices are made in `model`; what is
/// `asked` overrules the plan.
pub fn plan(scene: &Scene, model: &Model, asked: Option<Strategy>) -> Plan {
    let n = model.grid.nx;
    let flat = model.indenter == Indenter::Flat;
    let whole = if model.grid.is_line() {
        format!("line cell of {n} points")
    } else {
        format!("whole cell of {n} x {n} points")
    };
    let (no_atlas, obstacle) = (no_atlas(scene, model), obstacle(scene, model));
    let one_crest = model.body == Body::HalfSpace
        && model.indenter.ground().has_one_crest()
        && !model.grid.is_line();
    let mesh = if flat { flat_error(model) } else { f64::NAN };
    let increments = 2.0 * travel(scene, model) / scene.drive.step;
    let transform = |points: f64| 2.5e-9 * points * points.log2().max(1.0);
    let points = (model.grid.points()) as f64;
    let by_walk = |part: Part, why: &str| {
        let (place, seconds) = if part.is_even() {
            (
                format!("even quarter of {n} x {n} points"),
                60.0 * transform(points / 4.0),
            )
        } else {
            (whole.clone(), 45.0 * transform(points))
        };
        Plan {
            strategy: Strategy::Walk(part),
            place: format!("{place}: {why}"),
            predicted_error: mesh,
            predicted_seconds: increments * seconds,
        }
    };
    match (asked, obstacle) {
        (Some(Strategy::Walk(part)), _) if part.is_even() && !model.indenter.ground().is_even() => {
            by_walk(Part::Whole, "rough ground has no mirror symmetry")
        }
        (Some(Strategy::Walk(part)), _) => by_walk(part, "asked for"),
        (None, Some(why)) if one_crest && model.mu_rho <= EVEN_TIP && n.is_multiple_of(4) => {
            by_walk(
                Part::Quarter,
                &format!("{why}, and a single crest keeps its mirror symmetry at this mu_rho"),
            )
        }
        (None, Some(why)) => by_walk(Part::Whole, &why),
        // What is asked overrules the plan, not the scene.
        (Some(Strategy::Atlas), _) if no_atlas.is_some() => {
            by_walk(Part::Whole, &no_atlas.unwrap_or_default())
        }
        (Some(Strategy::Atlas), _) | (None, None) => {
            let meshes = Meshes::new(&model.law, model.grid.length, n);
            let side = meshes.square;
            Plan {
                strategy: Strategy::Atlas,
                place: format!(
                    "flat in closed form, ridge on half a line of {} points, bulge and dimple on a \
                     quarter of {side} x {side} points, f64",
                    meshes.line,
                ),
                predicted_error: mesh,
                predicted_seconds: (3000.0 + 20.0 * increments) * transform(points / 4.0),
            }
        }
    }
}

/// Every branch of the scene, on the part of the cell on which its loop would be walked.
///
/// # Errors
/// The first value of the scene that is not allowed.
pub fn diagram(scene: &Scene, cancel: &Cancel, observe: Observe<'_>) -> Result<Diagram, Refusal> {
    let part = match plan(scene, &scene.model()?, None).strategy {
        Strategy::Walk(part) => part,
        Strategy::Atlas => Part::Whole,
    };
    Diagram::of(scene, part, cancel, observe)
}

/// What is promised of a number, in words; `error` is relative.
pub fn promise(error: Option<f64>) -> String {
    promise_as("expected error", error)
}

/// The same, an error named in other `words`.
pub fn promise_as(words: &str, error: Option<f64>) -> String {
    let Some(error) = error.filter(|error| *error < 1.0) else {
        return "no accuracy is promised".to_owned();
    };
    // One significant digit.
    let percent = 100.0 * error;
    let digits = (-percent.log10().floor()).max(0.0) as usize;
    format!("{words} {percent:.digits$} %")
}

/// The relative error to be expected of loss and jumps: as a finer mesh tells it, or else as the plan
/// expects it; NaN where nothing is known.
pub fn predicted_error(plan: &Plan, run: &LoopRun) -> f64 {
    run.error_bar.unwrap_or(plan.predicted_error)
}

/// The relative error to be stated of the loss: what a finer mesh tells, or else what the plan
/// expects; `None` where nothing is promised.
pub fn stated_error(model: &Model, plan: &Plan, run: &LoopRun) -> Option<f64> {
    let expected = || {
        run.ledger(model.law.surface_energy)?
            .stated_error(plan.predicted_error)
    };
    run.error_bar
        .map_or_else(expected, |error| Some(error).filter(|error| *error < 1.0))
}

/// Why the strategy that is asked for cannot hold the scene; `None` if it can.
pub fn refusal(scene: &Scene, model: &Model, asked: Option<Strategy>) -> Option<String> {
    no_atlas(scene, model).filter(|_| asked == Some(Strategy::Atlas))
}

/// Why the scene has no atlas; `None` if it can have one, wise or not.
fn no_atlas(scene: &Scene, model: &Model) -> Option<String> {
    let refusal = Atlas::refusal(scene).map(|reason| reason.to_string());
    refusal.or_else(|| no_quarter(model.grid.nx))
}

/// Why an atlas will not do; `None` if it will.
fn obstacle(scene: &Scene, model: &Model) -> Option<String> {
    if let Some(reason) = no_atlas(scene, model) {
        Some(reason)
    } else if !model.law.is_smooth() {
        Some("this law's stiffness jumps, and branches with it".to_owned())
    } else if !mesh::is_safe(model.mu_rho) {
        Some(format!(
            "at mu_rho = {:.2} the mesh makes jumps of its own",
            model.mu_rho
        ))
    } else {
        None
    }
}

/// u0 from the start to the turn, or what it may be for a tip (length).
fn travel(scene: &Scene, model: &Model) -> f64 {
    match scene.drive.turn {
        Turn::At(turn) => scene.drive.start - turn,
        Turn::ZeroLoad => 10.0 * model.law.range,
    }
}

/// On flat ground the drive goes at least so many units of the control beyond the limits of the
/// flat state, so that the loop closes and holds every pattern; and no deeper than this share of the
/// lower limit. The flat state beyond costs nothing.
const FARTHER: f64 = 8.0;
const DEEPER: f64 = 0.5;
const DEEPEST: f64 = 0.2;

/// Makes the drive of a `scene` on flat ground go beyond every jump, if it does not.
pub(super) fn enclose(scene: &mut Scene, model: &Model) {
    let (law, control) = (&model.law, scene.control());
    let flat = FlatBranch::new(*law, model.equivalent_length, control);
    let (Turn::At(turn), Some(limits), Some((gap, _))) =
        (scene.drive.turn, flat.limits(), flat.unstable_gaps())
    else {
        return;
    };
    // A Mie law has no gap at or below zero.
    let deep = (gap - DEEPER * law.range).max(DEEPEST * gap);
    let [deep, _] = control.balanced(deep, law.at(deep).traction);
    let unit = control.unit(law);
    scene.drive.turn = Turn::At(turn.min(deep).min(limits.1 - DEEPER * unit));
    let far = limits.0.max(limits.1) + FARTHER * unit;
    scene.drive.start = scene.drive.start.max(far);
}

/// On what a loop runs.
enum Way {
    /// The branches of an atlas that has all of the loop.
    Atlas(Box<Atlas>),
    /// A walk on a part of the cell, with the reason where none was planned.
    Walk(Part, Option<String>),
}

impl Way {
    fn of(scene: &Scene, model: &Model, plan: &Plan, cancel: &Cancel) -> Self {
        match plan.strategy {
            Strategy::Walk(part) => Way::Walk(part, None),
            Strategy::Atlas => {
                atlas_of_loop(scene, model, cancel).map_or_else(Way::after_all, Way::Atlas)
            }
        }
    }

    fn after_all(reason: Unmapped) -> Self {
        Way::Walk(Part::Whole, Some(walked_after_all(&reason.to_string())))
    }

    fn run(
        self,
        scene: &Scene,
        model: &Model,
        method: MethodKind,
        cancel: &Cancel,
        observe: &mut dyn FnMut(Report<'_>),
    ) -> Result<LoopRun, Refusal> {
        match self {
            Way::Atlas(mut atlas) => match atlas.tour(scene, model, cancel, observe) {
                Ok(run) => Ok(run),
                Err(reason) => Way::after_all(reason).run(scene, model, method, cancel, observe),
            },
            Way::Walk(part, because) => {
                let options = WalkOptions {
                    part,
                    ..method.into()
                };
                let mut run = run_loop(scene, options, cancel, observe)?;
                run.deviation = because.or(run.deviation);
                Ok(run)
            }
        }
    }
}

/// The atlas of the loop of `scene`, with all its branches and landings.
fn atlas_of_loop(scene: &Scene, model: &Model, cancel: &Cancel) -> Result<Box<Atlas>, Unmapped> {
    let mut atlas = Box::new(Atlas::of(scene, model));
    atlas.obey(cancel);
    atlas.cycle(scene.drive.start, scene.depth())?;
    Ok(atlas)
}

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
    let model = scene.model()?;
    let way = Way::of(scene, &model, plan, cancel);
    let mut known = match &way {
        Way::Atlas(atlas) => Some(atlas.clone()),
        Way::Walk(..) => None,
    };
    let here = || way.run(scene, &model, method, cancel, observe);
    let (finer, run) = match &mut known {
        Some(known) if is_judged(&model) => {
            let finer_cancel = cancel.part();
            known.obey(&finer_cancel);
            beside(
                || Some(finer_loops(scene, &model, Some(known), &finer_cancel)),
                || {
                    let run = here();
                    let completed = |run: &LoopRun| run.outcome == Outcome::Completed;
                    if !run.as_ref().is_ok_and(completed) {
                        finer_cancel.request();
                    }
                    run
                },
            )
        }
        _ => (None, here()),
    };
    let mut run = run?;
    run.error_bar = error_bar(&model, &run, || {
        finer.unwrap_or_else(|| finer_loops(scene, &model, None, cancel))
    })
    .filter(|_| !cancel.requested());
    let jumps = &run.record.jumps;
    if jumps.iter().any(|jump| !jump.landings.is_empty())
        && let Some(mut atlas) = known.or_else(|| atlas_of_loop(scene, &model, cancel).ok())
    {
        atlas.obey(cancel);
        run.rivals = rivals(&mut atlas, jumps, scene.drive.start, scene.depth());
    }
    Ok(run)
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

/// Runs the closed loop on the strategy of `plan`; where an atlas finds that it does not hold this
/// scene, on the whole cell.
///
/// # Errors
/// As [`run_loop`].
pub fn run_as_planned(
    scene: &Scene,
    method: MethodKind,
    plan: &Plan,
    cancel: &Cancel,
    observe: &mut dyn FnMut(Report<'_>),
) -> Result<LoopRun, Refusal> {
    let model = scene.model()?;
    Way::of(scene, &model, plan, cancel).run(scene, &model, method, cancel, observe)
}

/// The measured difference is stated this many times larger: what a mesh of 4/3 times the points
/// itself is off by, a tenth to a fifth where the error falls by e^2.6 for each unit of 1/mu_rho^2,
/// and as much again.
const SAFETY: f64 = 1.4;
/// Added to it, relative: how well two loops locate the same ends.
const FLOOR: f64 = 4e-6;
/// The share of a bracket within which the end of a branch is found by the eigenvalues at both its
/// sides.
const WITHIN: f64 = 0.2;

/// True where a finer mesh can tell the error of a loop.
fn is_judged(model: &Model) -> bool {
    model.indenter == Indenter::Flat && flat_error(model) < 1.0
}

/// The relative error of loss and jumps of a loop that was completed on flat ground, against those of
/// the `finer` mesh; `None` where that cannot tell, or not in time. Where its jumps are not the same
/// ones nothing can be promised: 1.
fn error_bar(
    model: &Model,
    run: &LoopRun,
    finer: impl FnOnce() -> Option<Vec<Vec<JumpRecord>>>,
) -> Option<f64> {
    let ledger = run
        .ledger(model.law.surface_energy)
        .filter(|ledger| !ledger.viscous && is_judged(model))?;
    let loss = ledger.dissipated_energy()?;
    // Where it is contested which of two loops it is, both meshes have both.
    let error = finer()?
        .iter()
        .map(|jumps| measured_error(&run.record.jumps, jumps))
        .fold(1.0, f64::min);
    let located = if loss > 0.0 {
        WITHIN * ledger.released_energy_error / loss
    } else {
        0.0
    };
    Some(if error < 1.0 {
        SAFETY * error + located + FLOOR
    } else {
        1.0
    })
}

/// The jumps of the loop on the next finer mesh, and those of other landings: read off an atlas, made
/// from that of the loop if it is `known`, or walked where there is none.
fn finer_loops(
    scene: &Scene,
    model: &Model,
    known: Option<&Atlas>,
    cancel: &Cancel,
) -> Option<Vec<Vec<JumpRecord>>> {
    let finer = reference(scene, model);
    let from = known.and_then(|known| known.refined(finer.model().ok()?.grid.nx));
    let told = from.and_then(|mut atlas| loops(&mut atlas, scene));
    if let Some(loops) = told.or_else(|| read_off(&finer, cancel)) {
        return Some(loops);
    }
    let quarter = WalkOptions {
        part: Part::Quarter,
        ..WalkOptions::default()
    };
    let run = run_loop(&finer, quarter, cancel, &mut |_| {}).ok()?;
    (run.outcome == Outcome::Completed).then_some(vec![run.record.jumps])
}

/// The jumps of a loop on flat ground as an atlas on the scene's mesh has them, and those of other
/// landings; `None` if it has none.
pub fn read_off(scene: &Scene, cancel: &Cancel) -> Option<Vec<Vec<JumpRecord>>> {
    let model = scene.model().ok()?;
    if Atlas::refusal(scene).is_some() {
        return None;
    }
    loops(&mut *atlas_of_loop(scene, &model, cancel).ok()?, scene)
}

/// The jumps of the loop of `scene` as its `atlas` has them, and those of other landings.
fn loops(atlas: &mut Atlas, scene: &Scene) -> Option<Vec<Vec<JumpRecord>>> {
    let (start, turn) = (scene.drive.start, scene.depth());
    let usual = atlas.cycle(start, turn).ok()?.jumps;
    let contested = atlas
        .contested_cycles(start, turn)
        .into_iter()
        .filter_map(|(_, cycle)| Some(cycle.ok()?.jumps));
    Some(std::iter::once(usual).chain(contested).collect())
}

/// The scene that judges a loop of `scene`: the same law on the next finer mesh.
pub fn reference(scene: &Scene, model: &Model) -> Scene {
    let n = next_fast(model.grid.nx + model.grid.nx / 3);
    let mut finer = scene.clone();
    finer.cell.points = scene.cell.points.resized(n);
    finer.law.range = Range::Length(model.law.range);
    finer
}

/// The larger of the relative errors of the released energy and of the jumps' places, of a loop with
/// these `jumps` against the better `reference`; 1 where the jumps are not the same ones. Zero if
/// neither has any. Jumps that release less than a thousandth of the whole are the mesh's. A place
/// is u0 or what is driven, whichever is nearer: where that turns back under a spring or a load, a
/// walk knows u0 only to the root of its step.
pub fn measured_error(jumps: &[JumpRecord], reference: &[JumpRecord]) -> f64 {
    let loss = |jumps: &[JumpRecord]| jumps.iter().map(|jump| jump.released_energy).sum::<f64>();
    let least = 1e-3 * loss(reference);
    let [mine, right]: [Vec<_>; 2] = [jumps, reference].map(|jumps| {
        jumps
            .iter()
            .filter(|jump| jump.released_energy > least)
            .collect()
    });
    // Not by the names of the patterns: on which side of a growing dimple's change into a bulge a
    // jump lies may depend on the mesh.
    if !mine
        .iter()
        .map(|jump| jump.direction)
        .eq(right.iter().map(|jump| jump.direction))
    {
        return 1.0;
    }
    let share = |value: f64, right: f64| {
        if right == 0.0 {
            value.abs()
        } else {
            ((value - right) / right).abs()
        }
    };
    let each = mine.iter().zip(&right).map(|(a, b)| {
        let driven = share(a.control, b.control);
        share(a.mean_displacement, b.mean_displacement).min(driven)
    });
    each.fold(share(loss(jumps), loss(reference)), f64::max)
}

/// On which part of the cell a walk runs that a hand leads, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelChoice {
    /// What the plan says of the scene.
    pub plan: Plan,
    /// The part of the cell that the walk represents.
    pub part: Part,
    /// Why the walk runs on the whole cell where the plan or the user would have had a part.
    pub because: Option<String>,
}

impl ModelChoice {
    /// What the plan says, where the user has not `asked` for a strategy, unless a part of the cell
    /// will not do.
    ///
    /// # Errors
    /// The first value of the scene that is not allowed.
    pub fn of(scene: &Scene, method: MethodKind, asked: Option<Strategy>) -> Result<Self, Refusal> {
        let model = scene.model()?;
        let plan = plan(scene, &model, asked).by(method);
        let part = match plan.strategy {
            // A hand may go anywhere, so that the walk solves what is shown; the atlas only says
            // what is ahead.
            Strategy::Atlas => Part::Quarter,
            Strategy::Walk(part) => part,
        };
        let n = model.grid.nx;
        let because = if part != Part::Quarter {
            None
        } else if !n.is_multiple_of(4) {
            Some(format!("{n} points a side are no multiple of 4"))
        } else {
            // The yardstick stays as it was published, unless somebody asks.
            (method == MethodKind::Gfmd && asked != Some(Strategy::QUARTER))
                .then(|| "the paper's method runs as it was published".to_owned())
        };
        Ok(Self {
            plan,
            part: because.as_ref().map_or(part, |_| Part::Whole),
            because,
        })
    }
}
