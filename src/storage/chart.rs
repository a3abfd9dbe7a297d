//! The chart of speed against accuracy as data: `chart.csv`, a row per point, failures and points
//! left out included, the reference last; `chart.json`, what the chart says in short.

use super::export::{number, quoted};
use super::summary::{Number, SceneSummary};
use super::{Failure, files};
use crate::scene::Scene;
use crate::study::chart::{Chart, Errors, Judged, Point, Reference, Verdict};
use serde::Serialize;
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

#[cfg(test)]
pub(super) mod tests {
    use super::{CHART_COLUMNS, write_chart_csv};
    use crate::scene::part::Strategy;
    use crate::solver::methods::MethodKind;
    use crate::study::chart::{Chart, Errors, Judged, Point, Precision, Skipped, Verdict};

    fn row(method: MethodKind, transforms: usize, error: f64, verdict: Verdict) -> Judged {
        let point = Point {
            method,
            model: Strategy::WHOLE,
            line: false,
            points: 64,
            precision: Precision::Double,
            step: 0.02,
        };
        Judged {
            point,
            dissipated_energy: 0.1 + error,
            errors: Errors {
                dissipated_energy: error,
                jumps: error,
                stress: error,
            },
            transforms,
            transforms_per_increment: f64::NAN,
            seconds: 1.0,
            processor_seconds: transforms as f64 / 1e4,
            pareto_transforms: verdict == Verdict::Done,
            pareto_time: false,
            plan: method == MethodKind::NewtonKrylov,
            paper_budget: false,
            verdict,
        }
    }

    fn failed(what: &str) -> Verdict {
        Verdict::Failed {
            what: what.to_owned(),
            message: format!("{what}, with \"quotes\""),
        }
    }

    pub(in crate::storage) fn invented() -> Chart {
        let rows = vec![
            row(MethodKind::NewtonKrylov, 9_000, 1e-5, Verdict::Done),
            row(MethodKind::Fire, 30_000, 1e-4, Verdict::Done),
            row(MethodKind::Gfmd, 160_000, 0.1, failed("not converged")),
            row(
                MethodKind::Gfmd,
                100,
                f64::NAN,
                failed("NaN: time step beyond its limit"),
            ),
            row(MethodKind::Lbfgs, 0, f64::NAN, Verdict::Cancelled),
        ];
        let skipped = vec![Skipped {
            point: rows[0].point,
            predicted_seconds: 99.0,
            allowed_seconds: 7.0,
            beyond_reference: false,
        }];
        Chart {
            rows,
            skipped,
            ..Chart::default()
        }
    }

    #[test]
    fn failures_and_points_left_out_are_rows_with_every_column() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("chart.csv");
        write_chart_csv(&path, &invented()).expect("written");
        let text = std::fs::read_to_string(&path).expect("text");
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!((lines[0], lines.len()), (CHART_COLUMNS, 7));
        assert!(
            lines[1].starts_with("newton,whole,64,double,0.02,")
                && lines[1].contains(",transforms,true,false,done,"),
            "{}",
            lines[1]
        );
        assert!(
            lines[4].contains(",NaN: time step beyond its limit,\"NaN: time step beyond its limit, with \"\"quotes\"\"\""),
            "{}",
            lines[4]
        );
        assert!(
            lines[6].contains(
                "skipped,\"it would take 99.0 processor seconds, and 7.0 are left for it\""
            ),
            "{}",
            lines[6]
        );
        let commas = |line: &str| {
            line.split('"')
                .step_by(2)
                .map(|plain| plain.matches(',').count())
                .sum::<usize>()
        };
        assert!(
            lines
                .iter()
                .all(|line| commas(line) == commas(CHART_COLUMNS)),
            "{text}"
        );
    }
}
