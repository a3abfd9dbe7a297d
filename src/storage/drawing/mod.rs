//! Diagrams and tables as pictures, SVG and PNG; and the report, every figure with its words and
//! findings, the tables, the errata, as one HTML page that needs nothing else. The same value gives
//! the same bytes.
//!
//! Everything is drawn once, onto a sheet that is the SVG; the PNG is that SVG rendered.

mod panel;
mod svg;
#[cfg(test)]
mod tests;

use super::picture::write_png;
use super::{Failure, VERSION, files};
use crate::paper::errata::Erratum;
use crate::paper::{Figure, Finding, Table};
use crate::plot::panel::{Page, Panel};
use crate::plot::typeset::{Script, number, runs};
use image::RgbImage;
use panel::Legend;
use std::fmt::Write;
use std::path::Path;
use svg::{Anchor, RULE, Sheet, escaped, ink, set, solid, width};

/// Edge of the sheet, sizes of its title and of the lines beneath, and the distance to the
/// diagrams.
const EDGE: f64 = 16.0;
const TITLE: f64 = 18.0;
const CAPTION: f64 = 13.0;
const LINE: f64 = 18.0;
const BELOW_TITLE: f64 = 10.0;
/// Distance between diagrams.
const BETWEEN: f64 = 20.0;

/// Writes the page beside `stem`, a path without an ending, as an SVG and as a PNG at least 1800
/// pixels wide.
///
/// # Errors
/// Of either file that cannot be written.
pub fn write_page(stem: &Path, page: &Page<'_>) -> [Result<(), Failure>; 2] {
    write_sheet(stem, &page_sheet(page))
}

/// The same of a table.
///
/// # Errors
/// As [`write_page`].
pub fn write_table(stem: &Path, table: &Table) -> [Result<(), Failure>; 2] {
    write_sheet(stem, &table_sheet(table))
}

fn write_sheet(stem: &Path, sheet: &Sheet) -> [Result<(), Failure>; 2] {
    let [svg, png] = ["svg", "png"].map(|end| stem.with_extension(end));
    [
        files::write_whole(&svg, sheet.svg().as_bytes()),
        write_pixels(&png, sheet),
    ]
}

/// Writes the page as a PNG alone.
///
/// # Errors
/// A file that cannot be written.
pub fn write_page_png(path: &Path, page: &Page<'_>) -> Result<(), Failure> {
    write_pixels(path, &page_sheet(page))
}

fn write_pixels(path: &Path, sheet: &Sheet) -> Result<(), Failure> {
    let pixels = sheet.pixels();
    write_png(path, &pixels.map_err(|error| Failure::write(path, error))?)
}

/// Writes the page as an SVG alone.
///
/// # Errors
/// A file that cannot be written.
pub fn write_page_svg(path: &Path, page: &Page<'_>) -> Result<(), Failure> {
    files::write_whole(path, page_svg(page).as_bytes())
}

/// The page as the text of an SVG.
pub fn page_svg(page: &Page<'_>) -> String {
    page_sheet(page).svg()
}

/// The page as an image, at least 1800 pixels wide.
///
/// # Errors
/// A page that cannot be drawn.
pub fn page_image(page: &Page<'_>) -> Result<RgbImage, String> {
    let image = page_sheet(page).pixels();
    image.map_err(|error| error.to_string())
}

fn page_sheet(page: &Page<'_>) -> Sheet {
    let panels = &*page.panels;
    let columns = match panels.len() {
        0 | 1 => 1,
        2..=4 => 2,
        _ => 3,
    };
    let rows = panels.len().div_ceil(columns);
    let [wide, high] = match columns {
        1 => [900.0, 560.0],
        2 => [600.0, 430.0],
        _ => [500.0, 370.0],
    };
    let across = columns as f64 * wide + (columns - 1) as f64 * BETWEEN;
    let common = if panels.len() > 1 {
        Legend::common(panels)
    } else {
        None
    };
    let own = |panel: &Panel| {
        if common.is_some() {
            Legend::default()
        } else {
            Legend::of(panel, 1.0)
        }
    };
    let below = common
        .as_ref()
        .map_or(0.0, |legend| legend.height(across) + 8.0);
    // A long legend makes its whole row taller, and covers nothing.
    let room = |row: usize| {
        let legends = panels
            .iter()
            .skip(row * columns)
            .take(columns)
            .map(|panel| own(panel).height(wide - 12.0));
        legends.fold(0.0, f64::max)
    };
    let tall = |row: usize| high + room(row);
    let top = EDGE + TITLE + BELOW_TITLE + LINE * page.caption.len() as f64;
    let height = top
        + (0..rows).map(tall).sum::<f64>()
        + rows.saturating_sub(1) as f64 * BETWEEN
        + below
        + EDGE;
    let mut sheet = Sheet::new(across + 2.0 * EDGE, height.ceil());
    let lines = std::iter::once((&page.title, TITLE))
        .chain(page.caption.iter().map(|line| (line, CAPTION)));
    let mut y = EDGE + 0.5 * TITLE;
    for (text, size) in lines {
        let text = set(text);
        let fits = (across / width(&text, size)).min(1.0);
        sheet.words([EDGE, y], &text, size * fits, ink(), Anchor::Start);
        y += if size == TITLE {
            0.5 * (TITLE + LINE) + 4.0
        } else {
            LINE
        };
    }
    let mut y = top;
    for row in 0..rows {
        for column in 0..columns {
            let index = row * columns + column;
            let Some(panel) = panels.get(index) else {
                break;
            };
            let x = EDGE + column as f64 * (wide + BETWEEN);
            let sides = [x, y, x + wide, y + tall(row)];
            panel::draw(
                &mut sheet,
                panel,
                &panel.heading(index, panels.len()),
                sides,
                (&own(panel), room(row)),
                1.0,
            );
        }
        y += tall(row) + BETWEEN;
    }
    if let Some(legend) = common {
        legend.draw(&mut sheet, [EDGE + 6.0, y - BETWEEN + 8.0], across);
    }
    sheet
}

/// The table: heading, columns as wide as they need, thin rules.
fn table_sheet(table: &Table) -> Sheet {
    const TITLE: f64 = 17.0;
    const TEXT: f64 = 13.5;
    const ROW: f64 = 24.0;
    const EDGE: f64 = 24.0;
    const GAP: f64 = 26.0;
    const WIDTH_MIN: f64 = 480.0;

    let rows = || std::iter::once(&table.columns).chain(&table.rows);
    let columns = rows().map(Vec::len).max().unwrap_or(0);
    let widest = |k: usize| {
        rows()
            .filter_map(|row| row.get(k))
            .map(|cell| width(&set(cell), TEXT))
            .fold(0.0, f64::max)
    };
    let widths: Vec<f64> = (0..columns).map(widest).collect();
    let title = set(&format!("Table {}: {}", table.number, table.title));
    let needed = widths.iter().sum::<f64>() + GAP * columns.saturating_sub(1) as f64;
    let across = needed.max(width(&title, TITLE)).max(WIDTH_MIN) + 2.0 * EDGE;
    let top = EDGE + TITLE + 18.0;
    let mut sheet = Sheet::new(
        across.ceil(),
        (top + ROW * (table.rows.len() + 1) as f64 + EDGE).ceil(),
    );
    sheet.words(
        [EDGE, EDGE + 0.5 * TITLE],
        &title,
        TITLE,
        ink(),
        Anchor::Start,
    );
    for (r, row) in rows().enumerate() {
        let y = top + ROW * r as f64;
        let mut x = EDGE;
        for (cell, wide) in row.iter().zip(&widths) {
            sheet.words([x, y + 0.5 * ROW], &set(cell), TEXT, ink(), Anchor::Start);
            x += wide + GAP;
        }
        let (colour, thick) = if r == 0 || r == table.rows.len() {
            (ink(), 1.2)
        } else {
            (RULE, 0.5)
        };
        sheet.line(
            &[[EDGE, y + ROW], [across - EDGE, y + ROW]],
            solid(colour, thick),
        );
    }
    sheet.line(&[[EDGE, top], [across - EDGE, top]], solid(ink(), 1.2));
    sheet
}

/// What the report holds.
#[derive(Default)]
pub struct Report<'a> {
    /// The figures with what to look for in each.
    pub figures: Vec<(&'a Figure, &'a str)>,
    /// The tables.
    pub tables: Vec<&'a Table>,
    /// What the print got wrong.
    pub errata: &'a [Erratum],
    /// What is missing, in words, and why.
    pub missing: Vec<String>,
}

const STYLE: &str = "\
body { font: 16px/1.5 'DejaVu Sans', Verdana, sans-serif; color: #222; background: #fff; \
    max-width: 60rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.7rem; } h2 { font-size: 1.25rem; margin-top: 2.5rem; \
    border-bottom: 1px solid #ccc; }
figure { margin: 1rem 0; } figure svg { width: 100%; height: auto; }
.look { color: #555; font-style: italic; } .missing { color: #a02020; }
table { border-collapse: collapse; font-size: 0.85rem; margin: 0.8rem 0; width: 100%; }
th, td { text-align: left; padding: 0.25rem 0.7rem 0.25rem 0; \
    border-bottom: 1px solid #ddd; vertical-align: top; }
th { border-bottom: 1.5px solid #222; } td.number { font-variant-numeric: tabular-nums; \
    white-space: nowrap; }
.yes { color: #116b3a; } .no { color: #a02020; font-weight: bold; } .stated { color: #777; }
sub, sup { line-height: 0; font-size: 0.72em; }
nav { columns: 2; font-size: 0.9rem; } nav ul { margin: 0; }
@media print {
  body { font-size: 10.5pt; max-width: none; margin: 0; } h2 { break-after: avoid; }
  section.figure { break-inside: avoid-page; } figure { break-inside: avoid; } \
  tr { break-inside: avoid; } thead { display: table-header-group; }
  nav { display: none; } a { color: inherit; text-decoration: none; }
}
";

/// Writes the page.
///
/// # Errors
/// A file that cannot be written.
pub fn write_report(path: &Path, report: &Report<'_>) -> Result<(), Failure> {
    files::write_whole(path, report_page(report).as_bytes())
}

fn report_page(report: &Report<'_>) -> String {
    let mut out = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta \
         name=\"viewport\" content=\"width=device-width\">\n\
         <title>Modeling adhesive hysteresis, figure by \
         figure</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <h1>Modeling adhesive hysteresis, figure by figure</h1>\n\
         <p>The figures of Wang, Zhou and Müser (<i>Lubricants</i> 9 (2021) 17, doi \
         10.3390/lubricants9020017), computed anew by \
         Tackscope {}, beside theory and print.</p>\n",
        VERSION
    );
    summary(&mut out, report);
    for (figure, look_for) in &report.figures {
        figure_section(&mut out, figure, look_for);
    }
    for table in &report.tables {
        table_section(&mut out, table);
    }
    errata(&mut out, report.errata);
    out.push_str("</body>\n</html>\n");
    out
}

/// How many findings agree, what is missing, and where to find what.
fn summary(out: &mut String, report: &Report<'_>) {
    let all = || {
        report
            .figures
            .iter()
            .flat_map(|(f, _)| &f.findings)
            .chain(report.tables.iter().flat_map(|t| &t.findings))
    };
    let judged = all().filter(|f| f.agrees().is_some()).count();
    let agree = all().filter(|f| f.agrees() == Some(true)).count();
    let _ = writeln!(
        out,
        "<p>{} numbers are compared; {judged} of them with a promise how near they must be, and of \
         those {agree} agree. Curves: broad lines and symbols are computed equilibria, thin solid \
         lines theory, dashed lines the print.</p>",
        all().count()
    );
    for missing in &report.missing {
        let _ = writeln!(out, "<p class=\"missing\">Missing: {}</p>", html(missing));
    }
    out.push_str("<nav><ul>\n");
    for (figure, _) in &report.figures {
        let _ = writeln!(
            out,
            "<li><a href=\"#figure-{0}\">Fig. {0}: {1}</a></li>",
            figure.number,
            html(&figure.title)
        );
    }
    for table in &report.tables {
        let _ = writeln!(
            out,
            "<li><a href=\"#table-{0}\">Table {0}: {1}</a></li>",
            table.number,
            html(&table.title)
        );
    }
    if !report.errata.is_empty() {
        out.push_str("<li><a href=\"#errata\">What the print got wrong</a></li>\n");
    }
    out.push_str("</ul></nav>\n");
}

fn figure_section(out: &mut String, figure: &Figure, look_for: &str) {
    let number = figure.number;
    let _ = writeln!(
        out,
        "<section class=\"figure\" id=\"figure-{number}\">\n<h2>Fig. {number}: {}</h2>",
        html(&figure.title)
    );
    let _ = writeln!(out, "<p class=\"look\">{}</p>", html(look_for));
    let _ = writeln!(out, "<figure>\n{}</figure>", page_svg(&figure.page()));
    paragraph(out, &figure.words);
    findings(out, &figure.findings);
    out.push_str("</section>\n");
}

fn table_section(out: &mut String, table: &Table) {
    let number = table.number;
    let _ = writeln!(
        out,
        "<section id=\"table-{number}\">\n<h2>Table {number}: {}</h2>",
        html(&table.title)
    );
    head(out, &table.columns);
    for row in &table.rows {
        let cells: String = row
            .iter()
            .map(|cell| format!("<td>{}</td>", html(cell)))
            .collect();
        let _ = writeln!(out, "<tr>{cells}</tr>");
    }
    out.push_str("</tbody>\n</table>\n");
    paragraph(out, &table.words);
    findings(out, &table.findings);
    out.push_str("</section>\n");
}

/// The beginning of a table: its columns.
fn head(out: &mut String, columns: &[impl AsRef<str>]) {
    let cell = |column: &_| format!("<th>{}</th>", html(AsRef::as_ref(column)));
    let cells: String = columns.iter().map(cell).collect();
    let _ = writeln!(out, "<table>\n<thead><tr>{cells}</tr></thead>\n<tbody>");
}

fn paragraph(out: &mut String, words: &str) {
    if !words.is_empty() {
        let _ = writeln!(out, "<p>{}</p>", html(words));
    }
}

fn findings(out: &mut String, findings: &[Finding]) {
    if findings.is_empty() {
        return;
    }
    head(
        out,
        &[
            "quantity",
            "found",
            "expected",
            "source",
            "deviation",
            "agrees",
        ],
    );
    for finding in findings {
        let (class, word) = match finding.agrees() {
            Some(true) => ("yes", "yes"),
            Some(false) => ("no", "no"),
            None => ("stated", "stated only"),
        };
        let [found, expected, deviation] = [
            finding.found,
            finding.expected,
            finding.found - finding.expected,
        ]
        .map(number);
        let _ = writeln!(
            out,
            "<tr><td>{}</td><td class=\"number\">{found}</td><td \
             class=\"number\">{expected}</td><td>{}</td><td class=\"number\">{deviation}</td><td \
             class=\"{class}\">{word}</td></tr>",
            html(&finding.quantity),
            html(&finding.source)
        );
    }
    out.push_str("</tbody>\n</table>\n");
}

fn errata(out: &mut String, errata: &[Erratum]) {
    if errata.is_empty() {
        return;
    }
    out.push_str("<section id=\"errata\">\n<h2>What the print got wrong</h2>\n");
    out.push_str(
        "<p>The evidence is computed without either formula: by finding roots, integrating, \
         measuring, running a loop.</p>\n",
    );
    for erratum in errata {
        let _ = writeln!(
            out,
            "<h3>{}</h3>\n<p>Printed: {}<br>Right: {}<br>{}</p>",
            html(erratum.place),
            html(erratum.printed),
            html(erratum.right),
            html(erratum.because)
        );
        if erratum.evidence.is_empty() {
            continue;
        }
        head(out, &["evidence", "found", "by the print", "right"]);
        for evidence in &erratum.evidence {
            let [found, printed, right] =
                [evidence.found, evidence.printed, evidence.right].map(number);
            let _ = writeln!(
                out,
                "<tr><td>{}</td><td class=\"number\">{found}</td><td \
                 class=\"number\">{printed}</td><td class=\"number\">{right}</td></tr>",
                html(evidence.quantity)
            );
        }
        out.push_str("</tbody>\n</table>\n");
    }
    out.push_str("</section>\n");
}

/// Text with its formulas set, safe inside HTML.
fn html(text: &str) -> String {
    let mut out = String::new();
    for run in runs(text) {
        let text = escaped(&run.text);
        let _ = match run.script {
            Script::Base => write!(out, "{text}"),
            Script::Sub => write!(out, "<sub>{text}</sub>"),
            Script::Super => write!(out, "<sup>{text}</sup>"),
        };
    }
    out
}
