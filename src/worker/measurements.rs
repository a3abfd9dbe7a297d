//! What is measured beside the walk: which time steps GFMD survives, and speed against accuracy.
//! Partial results as they come.

use super::job::Reporter;
use super::protocol::ChartSoFar;
use crate::scene::Scene;
use crate::study::chart::{self, Effort, News};
use crate::study::time_step_map::{Progress, Survey, TimeStepMap};

/// Measures the time-step map along an approach that ends at `turn` (length).
///
/// # Errors
/// Why it could not be finished, in words.
pub(super) fn time_steps(
    scene: &Scene,
    turn: f64,
    report: &Reporter<TimeStepMap>,
) -> Result<(), String> {
    let mut survey = Survey::new(scene, turn).map_err(|error| error.to_string())?;
    let mut end = Ok(());
    while !report.cancel.requested() {
        match survey.step(&report.cancel) {
            Progress::Working => {}
            Progress::Done | Progress::Cancelled => break,
            Progress::Stuck(message) => {
                end = Err(message);
                break;
            }
        }
        if report.is_due() {
            report.progress(survey.map().fraction(), "time steps");
            report.result(survey.map().clone());
        }
    }
    report.result(survey.map().clone());
    end
}

/// Measures the chart of speed against accuracy.
///
/// # Errors
/// Why it could not be finished, in words.
pub(super) fn chart(
    scene: &Scene,
    effort: Effort,
    report: &Reporter<ChartSoFar>,
) -> Result<(), String> {
    let mut so_far = ChartSoFar::default();
    let (mut done, mut doing) = (0.0, String::new());
    let chart = chart::run(scene, effort, &report.cancel, &mut |news| {
        match news {
            News::Begun {
                what,
                reference: true,
            } => doing = format!("reference: {what}"),
            News::Begun {
                what,
                reference: false,
            } => doing = what.to_string(),
            News::Measured(row) => so_far.rows.push(row.clone()),
            News::Skipped(_) => return,
            News::Fraction(fraction) => {
                done = fraction;
                if !report.is_due() {
                    return;
                }
            }
        }
        report.progress(done, &doing);
        report.result(so_far.clone());
    })
    .map_err(|error| error.to_string())?;
    let floor = chart
        .reference
        .map(|reference| reference.errors.dissipated_energy);
    report.result(ChartSoFar {
        rows: chart.rows,
        floor,
    });
    Ok(())
}
