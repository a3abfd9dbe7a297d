//! Measurements beside the walk: partial results as they come.

use super::aside::Aside;
use super::protocol::{ChartSoFar, Errand, Event, RunId};
use crate::experiment::chart::{self, Effort, News};
use crate::experiment::scene::Scene;
use crate::experiment::time_step_map::{Progress, Survey};
use crate::numerics::cancel::Cancel;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Shortest time between two partial results.
const PACE: Duration = Duration::from_millis(80);

/// Starts the thread.
pub(super) fn spawn(tell: impl Fn(Event) + Send + 'static) -> Aside<(RunId, Errand)> {
    Aside::spawn("measurements", move |(run, errand), cancel| {
        let measured = catch_unwind(AssertUnwindSafe(|| match errand {
            Errand::TimeSteps { scene, turn } => match Survey::new(&scene, turn) {
                Ok(survey) => time_steps(run, survey, &tell, cancel),
                Err(error) => Some(error.to_string()),
            },
            Errand::Chart { scene, effort } => chart(run, &scene, effort, &tell, cancel),
        }));
        let stuck = measured.unwrap_or_else(|_| Some("the solver stopped with a fault of its own".to_owned()));
        tell(Event::Measured { run, stuck });
    })
}

/// Returns why it could not be finished, if so.
fn time_steps(run: RunId, mut survey: Survey, tell: &dyn Fn(Event), cancel: &Cancel) -> Option<String> {
    let mut told = Instant::now();
    let mut stuck = None;
    while !cancel.requested() {
        match survey.step(cancel) {
            Progress::Working => {}
            Progress::Done | Progress::Cancelled => break,
            Progress::Stuck(message) => {
                stuck = Some(message);
                break;
            }
        }
        if told.elapsed() >= PACE {
            told = Instant::now();
            tell(Event::TimeSteps { run, map: Arc::new(survey.map().clone()) });
        }
    }
    tell(Event::TimeSteps { run, map: Arc::new(survey.map().clone()) });
    stuck
}

/// Returns why it could not be finished, if so.
fn chart(run: RunId, scene: &Scene, effort: Effort, tell: &dyn Fn(Event), cancel: &Cancel) -> Option<String> {
    let mut so_far = ChartSoFar::default();
    let mut told = Instant::now();
    let finished = chart::run(scene, effort, cancel, &mut |news| {
        let mut at_once = true;
        match news {
            News::Begun { what, reference: true } => so_far.now = format!("reference: {what}"),
            News::Begun { what, reference: false } => so_far.now = what.to_string(),
            News::Measured(row) => so_far.rows.push(row.clone()),
            News::Skipped(_) => so_far.skipped += 1,
            News::Fraction(fraction) => {
                so_far.fraction = fraction;
                at_once = told.elapsed() >= PACE;
            }
        }
        if at_once {
            told = Instant::now();
            tell(Event::Chart { run, chart: Arc::new(so_far.clone()) });
        }
    });
    so_far.now.clear();
    let stuck = match finished {
        Ok(chart) => {
            so_far.rows = chart.rows;
            so_far.floor = chart.reference.map(|reference| reference.errors.dissipated_energy);
            None
        }
        Err(error) => Some(error.to_string()),
    };
    tell(Event::Chart { run, chart: Arc::new(so_far) });
    stuck
}
