//! `summary.json`: what was computed, how well, and at what cost; `chart.json`: what the chart of
//! speed against accuracy says in short.

use super::{Failure, VERSION, files, scene_file};
use crate::scene::Scene;
use crate::study::chart::{Chart, Judged, Verdict};
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
    /// Relative error to be expected of the dissipated energy and of the jumps' u0, as a finer mesh
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
    /// What it loses.
    #[serde(flatten)]
    pub loss: LossSummary,
    /// What a reader of these numbers must know.
    pub warnings: Vec<String>,
    /// Other landings of a contested jump, and what the loop then loses.
    pub contested: Vec<Contested>,
    /// What was counted.
    pub counts: CountSummary,
    /// Least smallest eigenvalue of all states (E*/L).
    pub stiffness_min_least: Number,
    /// Largest error bound of a smallest eigenvalue (E*/L).
    pub stiffness_error_max: Number,
    /// Largest residual of all states.
    pub residual_max: Number,
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

/// What the loop loses, counted twice.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LossSummary {
    /// What the loop loses, per area over gamma: the sum of the energies released in its jumps (of
    /// a method whose states are no equilibria, the loop integral); not available unless the loop
    /// is closed.
    pub dissipated_energy: Number,
    /// Its relative error: that of the mesh and that of locating the jumps; not available where no
    /// accuracy is promised.
    pub stated_error: Number,
    /// Sum of the energies released in jumps, per area over gamma.
    pub released_energy_sum: Number,
    /// How far that sum may be off because ends of branches are located only so well, over gamma.
    pub released_energy_error: Number,
    /// Loop integral of stress du0 over gamma, the check of the loss; not available unless the loop
    /// is closed.
    pub loop_integral: Number,
    /// |loop integral - sum of releases| over the loss; not available where nothing is dissipated.
    pub ledger_mismatch: Number,
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

/// What was counted.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CountSummary {
    /// Recorded states.
    pub states: usize,
    /// Recorded states that are not "converged, stable".
    pub states_not_stable: usize,
    /// Jumps of the physics.
    pub jumps: usize,
    /// Jumps of the mesh.
    pub mesh_jumps: usize,
    /// Transitions without a jump.
    pub transitions: usize,
    /// Increments that ended in a pattern other than flat.
    pub patterned_increments: usize,
    /// Fourier transforms.
    pub transforms: usize,
    /// Those of them that prove that no mode is softer than the ones that are followed.
    pub proof_transforms: usize,
    /// Transforms over patterned increments; not available without any.
    pub transforms_per_patterned_increment: Number,
    /// Iterations of the method.
    pub iterations: usize,
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

#[derive(Serialize)]
struct Short<'a> {
    tackscope: &'static str,
    scene: SceneSummary,
    completed: bool,
    reference: Option<ReferenceShort>,
    counts: Counts,
    pareto_transforms: Vec<PointShort<'a>>,
    pareto_processor_seconds: Vec<PointShort<'a>>,
    plan: Vec<PointShort<'a>>,
    paper_budget: Vec<PointShort<'a>>,
    skipped: Vec<String>,
}

#[derive(Serialize)]
struct ReferenceShort {
    what: String,
    dissipated_energy: Number,
    loop_integral: Number,
    jumps: usize,
    error_dissipated_energy: Number,
    error_jumps: Number,
    error_stress: Number,
    transforms: usize,
    processor_seconds: Number,
    outcome: String,
}

#[derive(Serialize)]
struct Counts {
    points: usize,
    done: usize,
    failed: usize,
    skipped: usize,
}

#[derive(Serialize)]
struct PointShort<'a> {
    method: &'a str,
    model: &'a str,
    points: usize,
    precision: &'a str,
    step: Number,
    error_dissipated_energy: Number,
    transforms: usize,
    processor_seconds: Number,
    outcome: String,
}

/// Writes the chart's summary; `given` is the word on the command line.
///
/// # Errors
/// A file that cannot be written.
pub fn write_chart_json(
    path: &Path,
    given: &str,
    scene: &Scene,
    chart: &Chart,
) -> Result<(), Failure> {
    let of = |which: fn(&Judged) -> bool| {
        chart
            .rows
            .iter()
            .filter(|row| which(row))
            .map(short)
            .collect()
    };
    let count =
        |which: fn(&Verdict) -> bool| chart.rows.iter().filter(|row| which(&row.verdict)).count();
    let told = Short {
        tackscope: VERSION,
        scene: SceneSummary::new(given, scene),
        completed: !chart.cancelled,
        reference: chart.reference.as_ref().map(|reference| ReferenceShort {
            what: reference.point().to_string(),
            dissipated_energy: Number(reference.dissipated_energy),
            loop_integral: Number(reference.integral),
            jumps: reference.finest.record.tally().jumps,
            error_dissipated_energy: Number(reference.errors.dissipated_energy),
            error_jumps: Number(reference.errors.jumps),
            error_stress: Number(reference.errors.stress),
            transforms: reference.finest.counts.transforms,
            processor_seconds: Number(reference.finest.processor_seconds),
            outcome: reference.judged().verdict.to_string(),
        }),
        counts: Counts {
            points: chart.rows.len(),
            done: count(|verdict| *verdict == Verdict::Done),
            failed: count(|verdict| matches!(verdict, Verdict::Failed { .. })),
            skipped: chart.skipped.len(),
        },
        pareto_transforms: of(|row| row.pareto_transforms),
        pareto_processor_seconds: of(|row| row.pareto_time),
        plan: of(|row| row.plan),
        paper_budget: of(|row| row.paper_budget),
        skipped: chart
            .skipped
            .iter()
            .map(|skipped| skipped.point.to_string())
            .collect(),
    };
    write_json(path, &told)
}

fn short(row: &Judged) -> PointShort<'_> {
    PointShort {
        method: row.point.method.word(),
        model: row.point.model_word(),
        points: row.point.points,
        precision: row.point.precision.word(),
        step: Number(row.point.step),
        error_dissipated_energy: Number(row.errors.dissipated_energy),
        transforms: row.transforms,
        processor_seconds: Number(row.processor_seconds),
        outcome: row.verdict.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
