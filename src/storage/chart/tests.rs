//! Charts of invented rows: written, and looked into.

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
        lines[6]
            .contains("skipped,\"it would take 99.0 processor seconds, and 7.0 are left for it\""),
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
