//! Every table as CSV: what a walk went through, every branch, the chart of speed against accuracy,
//! the paper's figures, tables and findings.
//!
//! Of a scene with units what has a dimension is in them, under the same names; ratios (over gamma,
//! sigma_max, E*/L) stay ratios. Numbers are written with as many digits as bring back the same number; one that is not finite is
//! written `NaN` or `inf`.

mod studies;

pub use studies::{
    BARRIER_COLUMNS, MAP_COLUMNS, write_barriers_csv, write_branches_csv, write_chart_json,
    write_convergence_csv, write_ground_json, write_heights_csv, write_map_csv, write_points_csv,
    write_spectrum_csv,
};

use super::{Failure, files};
use crate::follow::record::{JumpRecord, StateRecord};
use crate::paper::{Figure, Finding, Table};
use crate::physics::parameter::Dimension;
use crate::plot::panel::{Axis, Content, Panel, Role, Spread, letter};
use crate::scene::Scene;
use crate::study::chart::{Chart, Errors, Judged, Point, Reference, Verdict};
use ndarray::Array2;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// First line of `loop.csv`.
const LOOP_COLUMNS: &str = "branch,mean_displacement,stress,stress_over_max,contact_area,\
    pattern,residual,stiffness_min,energy,model,milliseconds,control";

/// First line of `events.csv`.
const EVENT_COLUMNS: &str =
    "branch,mean_displacement,from,to,released_energy,cause,control,mean_displacement_after";

/// First line of `chart.csv`.
pub const CHART_COLUMNS: &str = "method,model,points,precision,step,dissipated_energy,\
    error_dissipated_energy,error_jumps,error_stress,transforms,transforms_per_increment,seconds,\
    processor_seconds,pareto,plan,paper_budget,outcome,message";

/// First line of `figure-N.csv` after its comments.
pub(super) const FIGURE_COLUMNS: &str = "panel,series,role,x,y,x_to,y_to";

/// First line of `findings.csv`.
const FINDING_COLUMNS: &str = "where,quantity,found,expected,source,deviation,tolerance,agrees";

/// Writes `loop.csv`.
///
/// # Errors
/// A file that cannot be written.
pub fn write_loop_csv(path: &Path, scene: &Scene, states: &[StateRecord]) -> Result<(), Failure> {
    files::write_whole(path, loop_csv(scene, states).as_bytes())
}

/// The states in order; u0 in the scene's length, stress in E*, stiffness in E*/L, energy per area
/// in E* times length; `control` is what is driven: u0, the position of the stage, or the load per
/// area.
pub(super) fn loop_csv(scene: &Scene, states: &[StateRecord]) -> String {
    let given = |of, value| number(scene.number_given(of, value));
    let row = |s: &StateRecord| {
        vec![
            s.direction.to_string(),
            number(s.mean_displacement),
            given(Dimension::Stress, s.stress),
            number(s.stress_over_max),
            number(s.contact_area),
            s.pattern.to_string(),
            number(s.residual),
            number(s.stiffness_min),
            given(Dimension::SurfaceEnergy, s.energy),
            quoted(&s.part.to_string()),
            format!("{:.4}", s.milliseconds),
            given(Dimension::Driven, s.control),
        ]
    };
    table(LOOP_COLUMNS, states.iter().map(row))
}

/// Writes `events.csv`.
///
/// # Errors
/// A file that cannot be written.
pub fn write_events_csv(path: &Path, scene: &Scene, jumps: &[JumpRecord]) -> Result<(), Failure> {
    files::write_whole(path, events_csv(scene, jumps).as_bytes())
}

/// The jumps in order; u0 before (and after) in the scene's length, released energy per area in
/// units of gamma.
pub(super) fn events_csv(scene: &Scene, jumps: &[JumpRecord]) -> String {
    let row = |jump: &JumpRecord| {
        let control = scene.number_given(Dimension::Driven, jump.control);
        let more = [control, jump.mean_displacement_after].map(number);
        cells_of(jump).into_iter().chain(more).collect()
    };
    table(EVENT_COLUMNS, jumps.iter().map(row))
}

/// Direction, u0 before, both patterns, released energy and cause.
fn cells_of(jump: &JumpRecord) -> [String; 6] {
    [
        jump.direction.to_string(),
        number(jump.mean_displacement),
        jump.from.to_string(),
        jump.to.to_string(),
        number(jump.released_energy),
        quoted(&jump.cause_words()),
    ]
}

/// Writes the chart, a row per point, failures and points left out included, the reference last:
/// energies over gamma, their errors relative, errors of jumps in ranges, of the stress over
/// sigma_max, times in seconds. `pareto` is `none`, `transforms`, `time` or `both`. What does not
/// exist is `NaN`.
///
/// # Errors
/// A file that cannot be written.
pub fn write_chart_csv(path: &Path, chart: &Chart) -> Result<(), Failure> {
    let measured = chart
        .rows
        .iter()
        .map(|row| judged(row, row.point.method.word(), pareto(row)));
    let skipped = chart.skipped.iter().map(|skipped| {
        let mut cells = settings(skipped.point.method.word(), &skipped.point);
        cells.extend(std::iter::repeat_n("NaN".to_owned(), 8));
        cells.extend(["none", "false", "false", "skipped"].map(str::to_owned));
        cells.push(quoted(&skipped.to_string()));
        cells
    });
    let reference = chart.reference.as_ref().map(of_reference);
    let rows = measured.chain(skipped).chain(reference);
    write_rows(path, CHART_COLUMNS, rows)
}

fn settings(method: &str, point: &Point) -> Vec<String> {
    vec![
        method.to_owned(),
        point.model_word().to_owned(),
        point.points.to_string(),
        point.precision.word().to_owned(),
        number(point.step),
    ]
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
    let Errors {
        dissipated_energy,
        jumps,
        stress,
    } = row.errors;
    let message = match &row.verdict {
        Verdict::Failed { message, .. } => message,
        _ => "",
    };
    let mut cells = settings(method, &row.point);
    cells.extend([row.dissipated_energy, dissipated_energy, jumps, stress].map(number));
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
        quoted(&row.verdict.to_string()),
        quoted(message),
    ]);
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

/// Writes everything that is drawn as one long table, and each gap map as a matrix beside it
/// (`figure-02-map-a.csv`: a row for each y, from the lowest up).
///
/// Lines that begin with `#` say what the axes are. `role` is simulation, unstable, forecast,
/// theory, printed or guide for curves and symbols, area (from y to `y_to`) and arrow (from x, y to
/// `x_to`, `y_to`).
///
/// # Errors
/// A file that cannot be written.
pub fn write_figure_csv(path: &Path, figure: &Figure) -> Result<(), Failure> {
    let heading = format!("Fig. {}: {}", figure.number, figure.title);
    write_panels_csv(path, &heading, &figure.panels)
}

/// Writes what diagrams show as [`write_figure_csv`] does, in the units of their axes, under a
/// heading as a comment.
///
/// # Errors
/// A file that cannot be written.
pub fn write_panels_csv(path: &Path, heading: &str, panels: &[Panel]) -> Result<(), Failure> {
    let mut text = format!("# {}\n", one_line(heading));
    let panels = named_panels(panels);
    for (name, panel) in &panels {
        let _ = writeln!(
            text,
            "# panel {name}: x = {}, y = {}{}",
            axis(&panel.x),
            axis(&panel.y),
            titled(panel)
        );
    }
    let _ = writeln!(text, "{FIGURE_COLUMNS}");
    for (name, panel) in &panels {
        rows(&mut text, name, panel);
    }
    let mut written = files::write_whole(path, text.as_bytes());
    for (name, gap) in maps(&panels) {
        // One that cannot be written does not keep the others.
        written = written.and(write_matrix(&beside(path, &name), "", gap));
    }
    written
}

/// Writes the table: its title as a comment, headings, rows.
///
/// # Errors
/// A file that cannot be written.
pub fn write_table_csv(path: &Path, table: &Table) -> Result<(), Failure> {
    let title = format!("# Table {}: {}", table.number, one_line(&table.title));
    let rows = std::iter::once(&table.columns).chain(&table.rows);
    let cells = rows.map(|row| row.iter().map(|cell| quoted(cell)).collect());
    write_rows(path, &title, cells)
}

/// Writes findings, each with the place it belongs to ("Fig. 4"). `agrees` is yes, no, or stated
/// (nothing was promised).
///
/// # Errors
/// A file that cannot be written.
pub fn write_findings_csv<'a>(
    path: &Path,
    findings: impl IntoIterator<Item = (String, &'a Finding)>,
) -> Result<(), Failure> {
    let row = |(place, finding): (String, &Finding)| {
        let agrees = match finding.agrees() {
            Some(true) => "yes",
            Some(false) => "no",
            None => "stated",
        };
        vec![
            quoted(&place),
            quoted(&finding.quantity),
            number(finding.found),
            number(finding.expected),
            quoted(&finding.source),
            number(finding.found - finding.expected),
            finding.tolerance.map(number).unwrap_or_default(),
            agrees.to_owned(),
        ]
    };
    write_rows(path, FINDING_COLUMNS, findings.into_iter().map(row))
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn axis(axis: &Axis) -> String {
    let scale = if axis.spread == Spread::Logarithmic {
        " (logarithmic)"
    } else {
        ""
    };
    format!("{}{scale}", one_line(&axis.label))
}

fn titled(panel: &Panel) -> String {
    if panel.title.is_empty() {
        String::new()
    } else {
        format!(": {}", one_line(&panel.title))
    }
}

/// The diagrams and those inside them: a, b, b inset 1, ...
fn named_panels(panels: &[Panel]) -> Vec<(String, &Panel)> {
    let mut list = Vec::new();
    for (i, panel) in panels.iter().enumerate() {
        let name = letter(i).to_string();
        let inner = panel
            .insets
            .iter()
            .filter_map(|inset| match &inset.content {
                Content::Diagram(panel) => Some(&**panel),
                Content::Map { .. } => None,
            });
        list.push((name.clone(), panel));
        list.extend(
            inner
                .enumerate()
                .map(|(k, panel)| (format!("{name} inset {}", k + 1), panel)),
        );
    }
    list
}

fn rows(text: &mut String, name: &str, panel: &Panel) {
    let mut row = |series: &str, role: &str, from: [f64; 2], to: [Option<f64>; 2]| {
        let units = [panel.x.unit, panel.y.unit];
        let [x, y] = [0, 1].map(|k| number(from[k] * units[k]));
        let [x_to, y_to] = [0, 1].map(|k| {
            let told = to[k].map(|value| number(value * units[k]));
            told.unwrap_or_default()
        });
        let series = quoted(series);
        let _ = writeln!(text, "{name},{series},{role},{x},{y},{x_to},{y_to}");
    };
    for series in &panel.series {
        let role = match series.role {
            Role::Simulation => "simulation",
            Role::Unstable => "unstable",
            Role::Theory => "theory",
            Role::Printed => "printed",
            Role::Forecast => "forecast",
            Role::Guide => "guide",
            Role::Kept(_) => "kept",
        };
        for point in &series.points {
            row(&series.name, role, *point, [None, None]);
        }
    }
    for area in &panel.areas {
        for span in &area.spans {
            let (near, far) = (area.edge(span, 1), area.edge(span, 2));
            let [across, upright] = [0, 1].map(|k| (far[k] != near[k]).then_some(far[k]));
            row(&area.name, "area", near, [across, upright]);
        }
    }
    for arrow in &panel.arrows {
        row(
            &arrow.direction.to_string(),
            "arrow",
            arrow.tail,
            arrow.head.map(Some),
        );
    }
}

/// The gap maps by the ends of their files' names.
fn maps<'a>(panels: &[(String, &'a Panel)]) -> Vec<(String, &'a Array2<f64>)> {
    let mut list: Vec<(String, &Array2<f64>)> = Vec::new();
    for (name, panel) in panels {
        for inset in &panel.insets {
            if let Content::Map { letter, gap } = &inset.content {
                let letter: String = letter.chars().filter(char::is_ascii_alphanumeric).collect();
                let prefix = if panels.len() > 1 {
                    format!("{}-", name.replace(' ', "-"))
                } else {
                    String::new()
                };
                let mut end = format!("{prefix}map-{letter}");
                if letter.is_empty() || list.iter().any(|known| known.0 == end) {
                    end = format!("{prefix}map-{letter}{}", list.len() + 1);
                }
                list.push((end, gap));
            }
        }
    }
    list
}

fn beside(path: &Path, end: &str) -> PathBuf {
    let stem = path
        .file_stem()
        .map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    path.with_file_name(format!("{stem}-{end}.csv"))
}

/// Writes a field, a row for each y from the lowest up, after what the file begins with.
fn write_matrix(path: &Path, head: &str, field: &Array2<f64>) -> Result<(), Failure> {
    let mut text = head.to_owned();
    for row in field.rows() {
        let cells: Vec<String> = row.iter().map(|value| number(*value)).collect();
        push_row(&mut text, &cells);
    }
    files::write_whole(path, text.as_bytes())
}

/// Writes a first line and rows of cells.
fn write_rows(
    path: &Path,
    first: &str,
    cells: impl Iterator<Item = Vec<String>>,
) -> Result<(), Failure> {
    files::write_whole(path, table(first, cells).as_bytes())
}

fn table(first: &str, rows: impl Iterator<Item = Vec<String>>) -> String {
    let mut text = format!("{first}\n");
    rows.for_each(|cells| push_row(&mut text, &cells));
    text
}

pub(super) fn push_row(text: &mut String, cells: &[String]) {
    text.push_str(&cells.join(","));
    text.push('\n');
}

/// The shortest text that reads back as the same number.
pub(super) fn number(value: f64) -> String {
    format!("{value:?}")
}

/// A cell in quotes if it needs them.
pub(super) fn quoted(cell: &str) -> String {
    if cell.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", cell.replace('"', "\"\""))
    } else {
        cell.to_owned()
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::scene::Strategy;
    use crate::solver::methods::MethodKind;
    use crate::study::chart::{Precision, Skipped};

    #[test]
    fn numbers_read_back_exactly() {
        for value in [0.1, 4.2, 1e-300, -3.0, 1.0 / 3.0] {
            assert_eq!(number(value).parse::<f64>(), Ok(value));
        }
    }

    #[test]
    fn a_cell_with_a_comma_is_quoted() {
        assert_eq!(quoted("flat, closed form"), "\"flat, closed form\"");
        assert_eq!(quoted("line"), "line");
    }

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
            lines[4].contains(
                ",NaN: time step beyond its limit,\"NaN: time step beyond its limit, \
                with \"\"quotes\"\"\""
            ),
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
