//! From a finished walk to its files: numbers put together for `summary.json`, tables, pictures.

use crate::experiment::ledger::Ledger;
use crate::experiment::plan::{Plan, Road};
use crate::experiment::record::StateRecord;
use crate::experiment::run::{Landing, LoopRun, Outcome};
use crate::experiment::scene::{Model, Scene};
use crate::physics::pattern::Pattern;
use crate::solver::Stop;
use crate::storage::summary::{CountSummary, Number, PlanSummary, SceneSummary, Summary, Yardstick};
use crate::storage::{Failure, export, files, picture, scene_file};
use std::path::Path;

/// A walk with what it took.
pub(super) struct Timed {
    pub(super) run: LoopRun,
    pub(super) wall_seconds: f64,
    pub(super) processor_seconds: f64,
}

/// The word of the summary for an outcome.
pub(super) fn stop_word(outcome: &Outcome) -> &'static str {
    match outcome {
        Outcome::Completed => "completed",
        Outcome::NotConverged { .. } => "not converged",
        Outcome::Cancelled => "cancelled",
    }
}

/// Everything for `summary.json` but the yardstick.
pub(super) fn summary(given: &str, scene: &Scene, model: &Model, plan: &Plan, method: &'static str, timed: &Timed) -> Summary {
    let run = &timed.run;
    let states = &run.record.states;
    let ledger = run.ledger(model.law.surface_energy);
    let of = |number: fn(&Ledger) -> Option<f64>| Number::from(ledger.as_ref().and_then(number));
    let largest = |value: fn(&StateRecord) -> f64| Number(states.iter().map(value).reduce(nan_max).unwrap_or(f64::NAN));
    Summary {
        tackscope: env!("CARGO_PKG_VERSION"),
        scene: SceneSummary {
            given: given.to_owned(),
            title: scene.title.clone(),
            source: scene.source.clone(),
            toml: scene_file::to_text(scene),
        },
        plan: plan_summary(model, plan, run.deviation.as_deref()),
        predicted_error: Number(plan.predicted_error),
        measured_error: Number(f64::NAN),
        method,
        completed: run.outcome == Outcome::Completed,
        stop: stop_word(&run.outcome),
        stop_reason: stop_reason(run),
        closed: ledger.as_ref().is_some_and(|ledger| ledger.open.is_none()),
        open_reason: ledger.as_ref().and_then(|ledger| ledger.open.as_ref().map(|open| open.reason.clone())),
        open_remedy: ledger.as_ref().and_then(|ledger| ledger.open.as_ref().map(|open| open.remedy.clone())),
        dissipated_energy: of(Ledger::dissipated_energy),
        stated_error: ledger.as_ref().and_then(|ledger| ledger.stated_error(plan.predicted_error)).into(),
        released_energy_sum: Number(run.record.released_energy_sum()),
        released_energy_error: of(|ledger| Some(ledger.released_energy_error)),
        loop_integral: of(|ledger| Some(ledger.loop_integral).filter(|_| ledger.open.is_none())),
        ledger_mismatch: of(Ledger::mismatch),
        warnings: model.warning().into_iter().chain(ledger.as_ref().and_then(Ledger::warning)).collect(),
        counts: counts(run),
        stiffness_min_least: Number(-largest(|s| -s.stiffness_min).0),
        stiffness_error_max: largest(|s| s.stiffness_error),
        residual_max: largest(|s| s.residual),
        wall_seconds: Number(timed.wall_seconds),
        processor_seconds: Number(timed.processor_seconds),
        yardstick: None,
    }
}

/// The larger one; NaN wins, so that it is not swallowed.
fn nan_max(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

fn plan_summary(model: &Model, plan: &Plan, deviation: Option<&str>) -> PlanSummary {
    PlanSummary {
        road: match plan.road {
            _ if deviation.is_some() => "whole",
            Road::Atlas(_) => "atlas",
            Road::Walk(reduction) => reduction.word(),
        },
        words: deviation.map_or_else(|| plan.words.clone(), |why| format!("{}; {why}", plan.words)),
        predicted_seconds: Number(plan.predicted_seconds),
        reason: model.reason.clone(),
        length: Number(model.grid.length),
        points: [model.grid.nx, model.grid.ny],
        spacing: Number(model.grid.spacing()),
        law: model.law.shape.word(),
        surface_energy: Number(model.law.surface_energy),
        range: Number(model.law.range),
        mu_rho: Number(model.mu_rho),
        warning: model.warning(),
    }
}

fn counts(run: &LoopRun) -> CountSummary {
    let (counts, states, tally) = (run.counts, &run.record.states, run.record.tally());
    let per_increment = (counts.patterned_increments > 0).then(|| counts.transforms as f64 / counts.patterned_increments as f64);
    CountSummary {
        states: states.len(),
        states_not_stable: states.iter().filter(|s| s.stop != Stop::Stable).count(),
        jumps: tally.jumps,
        mesh_jumps: tally.of_the_mesh,
        transitions: tally.transitions,
        patterned_increments: counts.patterned_increments,
        transforms: counts.transforms,
        transforms_per_patterned_increment: per_increment.into(),
        iterations: counts.iterations,
    }
}

fn stop_reason(run: &LoopRun) -> Option<String> {
    match &run.outcome {
        Outcome::Completed => None,
        Outcome::NotConverged { mean_displacement, reason } => Some(format!("u0 = {mean_displacement}: {reason}")),
        Outcome::Cancelled => {
            let at =
                run.record.states.last().map_or("before the first state".to_owned(), |s| format!("u0 = {}", s.mean_displacement));
            Some(format!("{at}: interrupted"))
        }
    }
}

/// The yardstick's numbers beside those of the main run.
pub(super) fn yardstick(model: &Model, main: &Timed, other: &Timed) -> Yardstick {
    let both = main.run.outcome == Outcome::Completed && other.run.outcome == Outcome::Completed;
    Yardstick {
        method: "gfmd",
        completed: other.run.outcome == Outcome::Completed,
        stop: stop_word(&other.run.outcome),
        dissipated_energy: other.run.ledger(model.law.surface_energy).and_then(|ledger| ledger.dissipated_energy()).into(),
        jumps: other.run.record.tally().jumps,
        transforms: other.run.counts.transforms,
        wall_seconds: Number(other.wall_seconds),
        processor_seconds: Number(other.processor_seconds),
        processor_time_ratio: both.then(|| other.processor_seconds / main.processor_seconds).into(),
    }
}

/// Writes tables and pictures of a walk, and removes the gap pictures of an earlier one.
pub(super) fn write_results(folder: &Path, scene: &Scene, model: &Model, plan: &Plan, run: &LoopRun) -> Result<(), Failure> {
    export::write_loop_csv(&folder.join("loop.csv"), &run.record.states)?;
    export::write_events_csv(&folder.join("events.csv"), &run.record.jumps)?;
    picture::write_loop_svg(&folder.join("loop.svg"), &run.record, &model.law, &scene.title, plan.predicted_error)?;
    picture::write_loop_png(&folder.join("loop.png"), &run.record, &model.law, &scene.title, plan.predicted_error)?;
    let gaps = folder.join("gaps");
    files::remove_old(&gaps, is_gap_picture)?;
    let scale = picture::common_scale(run.landings.iter().map(|landing| &landing.gap));
    for (i, landing) in run.landings.iter().enumerate() {
        picture::write_gap_png_scaled(&gaps.join(gap_picture(i, landing)), &landing.gap, scale)?;
    }
    Ok(())
}

/// `1-approach-bulge.png` for the first landing, and so on.
fn gap_picture(index: usize, landing: &Landing) -> String {
    format!("{}-{}-{}.png", index + 1, landing.branch, landing.pattern)
}

/// True for a name that [`gap_picture`] can give.
fn is_gap_picture(name: &str) -> bool {
    use Pattern::{Bulge, Contact, Dimple, Flat, Other, Ridge};
    let parts: Vec<_> = name.strip_suffix(".png").unwrap_or_default().split('-').collect();
    matches!(parts.as_slice(), [number, "approach" | "retraction", pattern]
        if number.parse::<usize>().is_ok() && [Flat, Bulge, Ridge, Dimple, Contact, Other].iter().any(|p| p.word() == *pattern))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_our_own_gap_pictures_are_recognised() {
        assert!(is_gap_picture("1-approach-bulge.png") && is_gap_picture("12-retraction-flat.png"));
        assert!(!is_gap_picture("holiday.png") && !is_gap_picture("1-approach-cat.png") && !is_gap_picture("x-approach-flat.png"));
    }

    #[test]
    fn nan_is_never_swallowed_by_a_maximum() {
        assert!([1.0, f64::NAN, 2.0].into_iter().reduce(nan_max).is_some_and(f64::is_nan));
        assert_eq!([1.0, 3.0, 2.0].into_iter().reduce(nan_max), Some(3.0));
    }
}
