//! Figures, tables and findings as CSV.

use crate::paper::figure::{Figure, Finding, Table};
use crate::plot::panel::{Axis, Content, Panel, Role, letter};
use crate::storage::export::{number, quoted};
use crate::storage::{Failure, files};
use ndarray::Array2;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// First line of `figure-N.csv` after its comments.
pub const FIGURE_COLUMNS: &str = "panel,series,role,x,y,x_to,y_to";

/// First line of `findings.csv`.
pub const FINDING_COLUMNS: &str = "where,quantity,found,expected,source,deviation,tolerance,agrees";

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
    let mut text = format!("# Fig. {}: {}\n", figure.number, one_line(&figure.title));
    let panels = named_panels(figure);
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
        written = written.and(write_matrix(&beside(path, &name), gap));
    }
    written
}

/// Writes the table: its title as a comment, headings, rows.
///
/// # Errors
/// A file that cannot be written.
pub fn write_table_csv(path: &Path, table: &Table) -> Result<(), Failure> {
    let mut text = format!("# Table {}: {}\n", table.number, one_line(&table.title));
    for row in std::iter::once(&table.columns).chain(&table.rows) {
        let cells: Vec<String> = row.iter().map(|cell| quoted(cell)).collect();
        let _ = writeln!(text, "{}", cells.join(","));
    }
    files::write_whole(path, text.as_bytes())
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
    let mut text = format!("{FINDING_COLUMNS}\n");
    for (place, finding) in findings {
        let agrees = match finding.agrees() {
            Some(true) => "yes",
            Some(false) => "no",
            None => "stated",
        };
        let cells = [
            quoted(&place),
            quoted(&finding.quantity),
            number(finding.found),
            number(finding.expected),
            quoted(&finding.source),
            number(finding.found - finding.expected),
            finding.tolerance.map(number).unwrap_or_default(),
            agrees.to_owned(),
        ];
        let _ = writeln!(text, "{}", cells.join(","));
    }
    files::write_whole(path, text.as_bytes())
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn axis(axis: &Axis) -> String {
    format!(
        "{}{}",
        one_line(&axis.label),
        if axis.logarithmic {
            " (logarithmic)"
        } else {
            ""
        }
    )
}

fn titled(panel: &Panel) -> String {
    if panel.title.is_empty() {
        String::new()
    } else {
        format!(": {}", one_line(&panel.title))
    }
}

/// The diagrams and those inside them: a, b, b inset 1, ...
fn named_panels(figure: &Figure) -> Vec<(String, &Panel)> {
    let mut list = Vec::new();
    for (i, panel) in figure.panels.iter().enumerate() {
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
        let [x_to, y_to] = to.map(|v| v.map(number).unwrap_or_default());
        let _ = writeln!(
            text,
            "{name},{},{role},{},{},{x_to},{y_to}",
            quoted(series),
            number(from[0]),
            number(from[1])
        );
    };
    for series in &panel.series {
        let role = match series.role {
            Role::Simulation => "simulation",
            Role::Unstable => "unstable",
            Role::Theory => "theory",
            Role::Printed => "printed",
            Role::Forecast => "forecast",
            Role::Guide => "guide",
        };
        for point in &series.points {
            row(&series.name, role, *point, [None, None]);
        }
    }
    for area in &panel.areas {
        for [x, low, high] in &area.spans {
            row(&area.name, "area", [*x, *low], [None, Some(*high)]);
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

fn write_matrix(path: &Path, gap: &Array2<f64>) -> Result<(), Failure> {
    let mut text = String::new();
    for row in gap.rows() {
        let cells: Vec<String> = row.iter().map(|g| number(*g)).collect();
        let _ = writeln!(text, "{}", cells.join(","));
    }
    files::write_whole(path, text.as_bytes())
}
