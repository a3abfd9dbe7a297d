//! The chart as CSV: a row per point, failures and points left out included, the reference last.

use crate::storage::export::{number, quoted};
use crate::storage::{Failure, files};
use crate::study::chart::{Chart, Errors, Judged, Point, Reference, Verdict};
use std::fmt::Write;
use std::path::Path;

/// First line of `chart.csv`.
pub const CHART_COLUMNS: &str = "method,model,points,precision,step,dissipated_energy,error_dissipated_energy,error_jumps,error_stress,\
     transforms,transforms_per_increment,seconds,processor_seconds,pareto,plan,paper_budget,outcome,message";

/// Writes the chart: energies over gamma, their errors relative, errors of jumps in ranges, of the
/// stress over sigma_max, times in seconds. `pareto` is `none`, `transforms`, `time` or `both`.
/// What does not exist is `NaN`.
///
/// # Errors
/// A file that cannot be written.
pub fn write_chart_csv(path: &Path, chart: &Chart) -> Result<(), Failure> {
    let mut text = format!("{CHART_COLUMNS}\n");
    for row in &chart.rows {
        let _ = writeln!(
            text,
            "{}",
            judged(row, row.point.method.word(), pareto(row)).join(",")
        );
    }
    for skipped in &chart.skipped {
        let mut cells = settings(skipped.point.method.word(), &skipped.point);
        cells.extend(std::iter::repeat_n("NaN".to_owned(), 8));
        cells.extend(["none", "false", "false", "skipped"].map(str::to_owned));
        cells.push(quoted(&skipped.to_string()));
        let _ = writeln!(text, "{}", cells.join(","));
    }
    if let Some(reference) = &chart.reference {
        let _ = writeln!(text, "{}", of_reference(reference).join(","));
    }
    files::write_whole(path, text.as_bytes())
}

fn settings(method: &str, point: &Point) -> Vec<String> {
    let (model, precision) = (
        point.model_word().to_owned(),
        point.precision.word().to_owned(),
    );
    vec![
        method.to_owned(),
        model,
        point.points.to_string(),
        precision,
        number(point.step),
    ]
}

fn distances(errors: Errors) -> [String; 3] {
    [errors.dissipated_energy, errors.jumps, errors.stress].map(number)
}

fn pareto(row: &Judged) -> &'static str {
    match (row.pareto_transforms, row.pareto_time) {
        (true, true) => "both",
        (true, false) => "transforms",
        (false, true) => "time",
        (false, false) => "none",
    }
}

fn judged(row: &Judged, method: &str, pareto: &str) -> Vec<String> {
    let mut cells = settings(method, &row.point);
    cells.push(number(row.dissipated_energy));
    cells.extend(distances(row.errors));
    cells.push(row.transforms.to_string());
    cells.extend(
        [
            row.transforms_per_increment,
            row.seconds,
            row.processor_seconds,
        ]
        .map(number),
    );
    cells.extend([
        pareto.to_owned(),
        row.plan.to_string(),
        row.paper_budget.to_string(),
    ]);
    let message = match &row.verdict {
        Verdict::Failed { message, .. } => message,
        _ => "",
    };
    cells.extend([quoted(&row.verdict.to_string()), quoted(message)]);
    cells
}

/// The last row: its errors are its own estimates.
fn of_reference(reference: &Reference) -> Vec<String> {
    let mut cells = judged(&reference.judged(), "reference", "none");
    let message = format!(
        "errors are estimates, from a coarser mesh and a longer step; loop integral {:.8} gamma",
        reference.integral
    );
    if let Some(last) = cells.last_mut().filter(|last| last.is_empty()) {
        *last = quoted(&message);
    }
    cells
}
