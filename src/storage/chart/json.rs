//! `chart.json`: what the chart says, in short.

use crate::scene::Scene;
use crate::storage::summary::{Number, SceneSummary};
use crate::storage::{Failure, files, scene_file};
use crate::study::chart::{Chart, Judged, Verdict};
use serde::Serialize;
use std::path::Path;

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
        tackscope: env!("CARGO_PKG_VERSION"),
        scene: SceneSummary {
            given: given.to_owned(),
            title: scene.title.clone(),
            source: scene.source.clone(),
            toml: scene_file::to_text(scene),
        },
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
    let mut text =
        serde_json::to_string_pretty(&told).map_err(|error| Failure::write(path, error))?;
    text.push('\n');
    files::write_whole(path, text.as_bytes())
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
