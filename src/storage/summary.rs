//! `summary.json`: what was computed, how well, and at what cost.

use super::{Failure, VERSION, files, scene_file};
use crate::follow::ledger::Ledger;
use crate::follow::run::{LoopRun, Outcome, RivalLoop};
use crate::physics::parameter::Dimension;
use crate::scene::parameter::Units;
use crate::scene::{Model, Points, Scene};
use crate::study::plan::{Plan, predicted_error, promise, reference};
use crate::study::sweep::{Cell, Measured, column};
use serde::{Serialize, Serializer};
use std::path::Path;

/// What stands in place of a number that does not exist.
pub const NOT_AVAILABLE: &str = "not available";

/// A number, or the words "not available" where it is not finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Number(pub f64);

impl Serialize for Number {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        // Adding zero turns -0.0, the sum of nothing, into 0.0.
        if self.0.is_finite() {
            serializer.serialize_f64(self.0 + 0.0)
        } else {
            serializer.serialize_str(NOT_AVAILABLE)
        }
    }
}

impl From<Option<f64>> for Number {
    fn from(value: Option<f64>) -> Self {
        Self(value.unwrap_or(f64::NAN))
    }
}

/// Everything in `summary.json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Version of the program.
    pub tackscope: &'static str,
    /// The scene as it was computed.
    pub scene: SceneSummary,
    /// The model that was chosen, and why.
    pub plan: PlanSummary,
    /// Relative error to be expected of the dissipated energy and of the jumps' places, as a finer mesh
    /// tells it (what the plan expects, where that was not asked); not available where nothing is
    /// known.
    pub predicted_error: Number,
    /// The same against a walk on the next finer mesh; not available unless asked for with
    /// --verify.
    pub measured_error: Number,
    /// "newton", "gfmd" or another method's word.
    pub method: &'static str,
    /// How it ended.
    #[serde(flatten)]
    pub end: EndSummary,
    /// What it loses, counted twice.
    #[serde(flatten)]
    pub loss: Quantities,
    /// What a reader of these numbers must know.
    pub warnings: Vec<String>,
    /// Other landings of a contested jump, and what the loop then loses.
    pub contested: Vec<Contested>,
    /// What was counted.
    pub counts: Quantities,
    /// How stable its states are, and how well they were solved.
    #[serde(flatten)]
    pub quality: Quantities,
    /// Time on the wall.
    pub wall_seconds: Number,
    /// Time of the processor, all threads.
    pub processor_seconds: Number,
    /// The paper's method on the same loop, if asked for.
    pub yardstick: Option<Yardstick>,
    /// What the numbers of a scene with units are in, and its results in SI; else it is not there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub units: Option<UnitsSummary>,
}

/// What it loses.
const LOSS: [&str; 6] = [
    "dissipated_energy",
    "stated_error",
    "released_energy_sum",
    "released_energy_error",
    "loop_integral",
    "ledger_mismatch",
];
/// What was counted.
const COUNTS: [&str; 10] = [
    "states",
    "states_not_stable",
    "jumps",
    "mesh_jumps",
    "transitions",
    "patterned_increments",
    "transforms",
    "proof_transforms",
    "transforms_per_patterned_increment",
    "iterations",
];
/// How stable its states are, and how well they were solved.
const QUALITY: [&str; 3] = ["stiffness_min_least", "stiffness_error_max", "residual_max"];

/// Numbers that a study can record too, by the names of its [columns](crate::study::sweep::COLUMNS).
#[derive(Clone, Debug, PartialEq)]
pub struct Quantities(Vec<(&'static str, Cell)>);

impl Quantities {
    fn of(names: &[&'static str], measured: &Measured<'_>) -> Self {
        let cell = |name: &&'static str| Some((*name, column(name)?.of(measured)));
        Self(names.iter().filter_map(cell).collect())
    }

    /// That of this name; NaN where it does not exist.
    pub fn number(&self, name: &str) -> f64 {
        let found = self.0.iter().find(|(known, _)| *known == name);
        let numbers = found.map_or_else(Vec::new, |(_, cell)| cell.numbers());
        numbers.first().copied().unwrap_or(f64::NAN)
    }
}

impl Serialize for Quantities {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, cell)| (name, cell)))
    }
}

impl Serialize for Cell {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Cell::Number(x) => Number(*x).serialize(serializer),
            Cell::Count(n) => n.serialize(serializer),
            Cell::Numbers(all) => all.serialize(serializer),
            Cell::Word(word) => word.serialize(serializer),
        }
    }
}

/// How the loop ended.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EndSummary {
    /// True if the drive went all the way.
    pub completed: bool,
    /// "completed", "not converged" or "cancelled".
    pub stop: &'static str,
    /// Where and why it stopped, if it did not complete.
    pub stop_reason: Option<String>,
    /// True if it was completed and ends in the state with which it began.
    pub closed: bool,
    /// How its end differs from its beginning, if it was completed but is not closed.
    pub open_reason: Option<String>,
    /// What to change then.
    pub open_remedy: Option<String>,
}

/// The scene, in words and as a file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SceneSummary {
    /// The word given on the command line.
    pub given: String,
    /// Title.
    pub title: String,
    /// Where it comes from.
    pub source: String,
    /// The scene file that computes the same again.
    pub toml: String,
}

impl SceneSummary {
    /// Of `scene`, which was `given` by this word or path.
    pub fn new(given: &str, scene: &Scene) -> Self {
        Self {
            given: given.to_owned(),
            title: scene.title.clone(),
            source: scene.source.clone(),
            toml: scene_file::to_text(scene),
        }
    }
}

/// Units of the tables and of this file, and what the loop is in SI. A line cell has no depth, and
/// so no force and no energy.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct UnitsSummary {
    /// Of lengths, u0 among them.
    pub length: String,
    /// Of stresses and of a load.
    pub stress: String,
    /// Of energies per area, gamma among them.
    pub energy: String,
    /// Of a spring's stiffness per area, and of `wave_stiffness` in `fields.npz`.
    pub stiffness: String,
    /// E* in units of stress.
    pub contact_modulus: Number,
    /// Temperature.
    pub temperature_kelvin: Number,
    /// What the loop loses per area; not available unless it is closed.
    pub loss_joule_per_square_metre: Number,
    /// The same of the square cell.
    pub loss_joule: Number,
    /// Largest mean stress, in tension.
    pub pull_off_pascal: Number,
    /// The same times the area of the square cell.
    pub pull_off_newton: Number,
}

/// The chosen model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlanSummary {
    /// "atlas", or the part of the cell that was walked: "quarter", "whole".
    #[serde(rename = "road")]
    pub strategy: &'static str,
    /// Which models on which meshes, and why.
    pub words: String,
    /// Seconds expected, to a factor of two or three.
    pub predicted_seconds: Number,
    /// Why this mesh.
    pub reason: String,
    /// Side L of the cell.
    pub length: Number,
    /// Points along x and y.
    pub points: [usize; 2],
    /// Spacing da.
    pub spacing: Number,
    /// The law's word.
    pub law: &'static str,
    /// gamma.
    pub surface_energy: Number,
    /// rho.
    pub range: Number,
    /// mu_rho of Eq. 10.
    pub mu_rho: Number,
    /// What a reader must know of this mesh.
    pub warning: Option<String>,
}

/// Another landing of a contested jump.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Contested {
    /// The pattern.
    pub landing: &'static str,
    /// The share of all mixtures of the soft modes that lead there, 0 to 1.
    pub share: Number,
    /// What the loop then loses, over gamma.
    pub dissipated_energy: Number,
}

/// The paper's method on the same loop in the same process.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Yardstick {
    /// "gfmd".
    pub method: &'static str,
    /// True if its drive went all the way.
    pub completed: bool,
    /// "completed", "not converged" or "cancelled".
    pub stop: &'static str,
    /// Its loss over gamma: its loop integral.
    pub dissipated_energy: Number,
    /// Its jumps.
    pub jumps: usize,
    /// Its Fourier transforms.
    pub transforms: usize,
    /// Its time on the wall.
    pub wall_seconds: Number,
    /// Its time of the processor.
    pub processor_seconds: Number,
    /// Its processor time over that of the main run; not available unless both are complete.
    pub processor_time_ratio: Number,
}

/// Writes the summary as JSON.
///
/// # Errors
/// A file that cannot be written.
pub fn write_summary(path: &Path, summary: &Summary) -> Result<(), Failure> {
    write_json(path, summary)
}

pub(super) fn write_json(path: &Path, told: &impl Serialize) -> Result<(), Failure> {
    let mut text =
        serde_json::to_string_pretty(told).map_err(|error| Failure::write(path, error))?;
    text.push('\n');
    files::write_whole(path, text.as_bytes())
}

/// A walk with what it took.
pub struct Timed {
    /// It.
    pub run: LoopRun,
    /// Time on the wall.
    pub wall_seconds: f64,
    /// Time of the processor, all threads.
    pub processor_seconds: f64,
}

impl Summary {
    /// What stands in `summary.json` until all is computed and written, and so beside whatever a killed
    /// run has left.
    pub fn begun(
        given: &str,
        scene: &Scene,
        model: &Model,
        plan: &Plan,
        method: &'static str,
    ) -> Self {
        let run = LoopRun {
            outcome: Outcome::Cancelled,
            ..LoopRun::of(scene.control())
        };
        let nothing = Timed {
            run,
            wall_seconds: f64::NAN,
            processor_seconds: f64::NAN,
        };
        let mut summary = Self::of(given, scene, model, plan, method, &nothing);
        summary.end.stop = "running";
        summary.end.stop_reason =
            Some("not finished: it is still running, or was killed".to_owned());
        // The sum of nothing yet is none.
        for (name, cell) in &mut summary.loss.0 {
            if *name == "released_energy_sum" {
                *cell = None.into();
            }
        }
        summary
    }

    /// Everything for `summary.json` but the yardstick.
    pub fn of(
        given: &str,
        scene: &Scene,
        model: &Model,
        plan: &Plan,
        method: &'static str,
        timed: &Timed,
    ) -> Self {
        let run = &timed.run;
        let measured = Measured::new(scene, model, plan, run, timed.wall_seconds);
        let ledger = measured.ledger.as_ref();
        Self {
            tackscope: VERSION,
            scene: SceneSummary::new(given, scene),
            plan: plan_summary(scene, model, plan, run.deviation.as_deref()),
            predicted_error: Number(predicted_error(plan, run)),
            measured_error: Number(f64::NAN),
            method,
            end: end(run, ledger),
            loss: Quantities::of(&LOSS, &measured),
            warnings: warnings(scene, model, run, ledger),
            contested: run.rivals.iter().map(contested).collect(),
            counts: Quantities::of(&COUNTS, &measured),
            quality: Quantities::of(&QUALITY, &measured),
            wall_seconds: Number(timed.wall_seconds),
            processor_seconds: Number(timed.processor_seconds),
            yardstick: None,
            units: scene.units.map(|units| in_si(&units, model, run, ledger)),
        }
    }
}

/// What a loop is in SI.
fn in_si(units: &Units, model: &Model, run: &LoopRun, ledger: Option<&Ledger>) -> UnitsSummary {
    let word = |of| units.word(of);
    let loss = ledger.and_then(Ledger::dissipated_energy);
    let loss = loss.map(|loss| loss * model.law.surface_energy);
    let pull = run.pull_off();
    let si = |of, value: Option<f64>| Number::from(value.map(|value| value * units.si(of)));
    let of_cell = |value: Option<f64>| model.of_cell(value?);
    UnitsSummary {
        length: word(Dimension::Length),
        stress: word(Dimension::Stress),
        energy: word(Dimension::SurfaceEnergy),
        stiffness: word(Dimension::Stiffness),
        contact_modulus: Number(units.contact_modulus),
        temperature_kelvin: Number(units.temperature),
        loss_joule_per_square_metre: si(Dimension::SurfaceEnergy, loss),
        loss_joule: si(Dimension::Energy, of_cell(loss)),
        pull_off_pascal: si(Dimension::Stress, pull),
        pull_off_newton: si(Dimension::Force, of_cell(pull)),
    }
}

fn end(run: &LoopRun, ledger: Option<&Ledger>) -> EndSummary {
    let open = ledger.and_then(|ledger| ledger.open.as_ref());
    EndSummary {
        completed: run.outcome == Outcome::Completed,
        stop: run.outcome.word(),
        stop_reason: run.stop_reason(),
        closed: ledger.is_some_and(|ledger| ledger.open.is_none()),
        open_reason: open.map(|open| open.reason.clone()),
        open_remedy: open.map(|open| open.remedy.clone()),
    }
}

fn warnings(scene: &Scene, model: &Model, run: &LoopRun, ledger: Option<&Ledger>) -> Vec<String> {
    let contested = run
        .record
        .jumps
        .iter()
        .filter(|jump| !jump.landings.is_empty())
        .map(|jump| {
            let losses: Vec<String> = run
                .rivals
                .iter()
                .filter_map(|rival| Some(format!("{:.4}", rival.dissipated_energy?)))
                .collect();
            let or = if losses.is_empty() {
                "is not known".to_owned()
            } else {
                format!("is {} gamma", losses.join(" or "))
            };
            format!(
                "u0 = {}: {}; the loss of the other landing {or}",
                jump.mean_displacement,
                jump.cause_words()
            )
        });
    let missed = run
        .error_bar
        .filter(|error| *error > scene.accuracy)
        .map(|error| {
            let points = reference(scene, model).cell.points;
            let finer = match points {
                Points::Line(n) => format!("[{n}, 1]"),
                Points::Square(n) => n.to_string(),
                Points::Auto => "\"auto\"".to_owned(),
            };
            let (bar, target) = (promise(Some(error)), scene.accuracy);
            format!(
                "accuracy.target = {target} is not met ({bar}); cell.points = {finer} comes closer"
            )
        });
    model
        .warning()
        .into_iter()
        .chain(ledger.and_then(Ledger::warning))
        .chain(contested)
        .chain(missed)
        .collect()
}

fn contested(rival: &RivalLoop) -> Contested {
    Contested {
        landing: rival.landing.pattern.word(),
        share: Number(rival.landing.share),
        dissipated_energy: Number::from(rival.dissipated_energy),
    }
}

fn plan_summary(scene: &Scene, model: &Model, plan: &Plan, deviation: Option<&str>) -> PlanSummary {
    let given = scene.number_given(Dimension::SurfaceEnergy, model.law.surface_energy);
    PlanSummary {
        strategy: plan.carried_out(deviation).word(),
        words: deviation.map_or_else(|| plan.words(), |why| format!("{}; {why}", plan.words())),
        predicted_seconds: Number(plan.predicted_seconds),
        reason: model.reason.clone(),
        length: Number(model.grid.length),
        points: [model.grid.nx, model.grid.ny],
        spacing: Number(model.grid.spacing()),
        law: model.law.shape.word(),
        surface_energy: Number(given),
        range: Number(model.law.range),
        mu_rho: Number(model.mu_rho),
        warning: model.warning(),
    }
}

impl Yardstick {
    /// The yardstick's numbers beside those of the main run.
    pub fn of(model: &Model, main: &Timed, other: &Timed) -> Self {
        let both =
            main.run.outcome == Outcome::Completed && other.run.outcome == Outcome::Completed;
        Self {
            method: "gfmd",
            completed: other.run.outcome == Outcome::Completed,
            stop: other.run.outcome.word(),
            dissipated_energy: other
                .run
                .ledger(model.law.surface_energy)
                .and_then(|ledger| ledger.dissipated_energy())
                .into(),
            jumps: other.run.record.tally().jumps,
            transforms: other.run.counts.transforms,
            wall_seconds: Number(other.wall_seconds),
            processor_seconds: Number(other.processor_seconds),
            processor_time_ratio: both
                .then(|| other.processor_seconds / main.processor_seconds)
                .into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::follow::run::nan_max;

    #[test]
    fn a_number_that_is_not_finite_is_said_in_words() {
        let json = serde_json::to_string(&[
            Number(0.5),
            Number(f64::NAN),
            Number(f64::INFINITY),
            Number::from(None),
        ]);
        assert_eq!(
            json.ok().as_deref(),
            Some(r#"[0.5,"not available","not available","not available"]"#)
        );
    }

    #[test]
    fn nan_is_never_swallowed_by_a_maximum() {
        assert!(
            [1.0, f64::NAN, 2.0]
                .into_iter()
                .reduce(nan_max)
                .is_some_and(f64::is_nan)
        );
        assert_eq!([1.0, 3.0, 2.0].into_iter().reduce(nan_max), Some(3.0));
    }
}
