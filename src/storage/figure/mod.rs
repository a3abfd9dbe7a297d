//! Figures and tables of the paper as files: data as CSV, pictures as SVG and PNG. The same figure gives the same bytes.
//!
//! A figure is drawn once, onto a sheet of marks; `svg` and `bitmap` turn the sheet into a file.

mod bitmap;
mod clip;
mod csv;
mod legend;
mod marks;
mod panel;
mod sheet;
mod svg;
mod table;
#[cfg(test)]
mod tests;

pub use csv::{FIGURE_COLUMNS, FINDING_COLUMNS, write_figure_csv, write_findings_csv, write_table_csv};
pub(super) use svg::escaped;

use super::picture::write_png;
use super::{Failure, files};
use crate::paper::figure::{Figure, Panel, Table};
use legend::Legend;
use marks::INK;
use sheet::{Anchor, Sheet, set, width};
use std::path::Path;

/// Edge of the sheet, size of its title, and its distance to the diagrams.
const EDGE: f64 = 16.0;
const TITLE: f64 = 18.0;
const BELOW_TITLE: f64 = 10.0;
/// Distance between diagrams.
const BETWEEN: f64 = 20.0;

/// Writes the figure as an SVG.
///
/// # Errors
/// A file that cannot be written.
pub fn write_figure_svg(path: &Path, figure: &Figure) -> Result<(), Failure> {
    files::write_whole(path, figure_svg(figure).as_bytes())
}

/// Writes the figure as a PNG, at least 1800 pixels wide.
///
/// # Errors
/// A file that cannot be written.
pub fn write_figure_png(path: &Path, figure: &Figure) -> Result<(), Failure> {
    write_pixels(path, &figure_sheet(figure))
}

/// Writes the table as an SVG.
///
/// # Errors
/// A file that cannot be written.
pub fn write_table_svg(path: &Path, table: &Table) -> Result<(), Failure> {
    files::write_whole(path, svg::text(&table::sheet(table)).as_bytes())
}

/// Writes the table as a PNG, at least 1800 pixels wide.
///
/// # Errors
/// A file that cannot be written.
pub fn write_table_png(path: &Path, table: &Table) -> Result<(), Failure> {
    write_pixels(path, &table::sheet(table))
}

/// The figure as the text of an SVG.
pub fn figure_svg(figure: &Figure) -> String {
    svg::text(&figure_sheet(figure))
}

fn write_pixels(path: &Path, sheet: &Sheet) -> Result<(), Failure> {
    write_png(path, &bitmap::pixels(sheet).map_err(|error| Failure::write(path, error))?)
}

/// a, b, c, ...
fn letter(index: usize) -> String {
    char::from_u32('a' as u32 + index.min(25) as u32).unwrap_or('z').to_string()
}

/// The heading of a diagram: with its letter where there are several and it has none of its own.
fn heading(panel: &Panel, index: usize, several: bool) -> String {
    let (title, letter) = (panel.title.trim(), letter(index));
    if !several || title.starts_with('(') {
        return title.to_owned();
    }
    format!("({letter}) {title}").trim_end().to_owned()
}

fn figure_sheet(figure: &Figure) -> Sheet {
    let panels = &figure.panels;
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
    let common = if panels.len() > 1 { Legend::common(panels) } else { None };
    let own = |panel: &Panel| if common.is_some() { Legend::default() } else { Legend::of(panel, 1.0) };
    let below = common.as_ref().map_or(0.0, |legend| legend.height(across) + 8.0);
    // A long legend makes its whole row taller, and covers nothing.
    let room = |row: usize| {
        let legends = panels.iter().skip(row * columns).take(columns).map(|panel| own(panel).height(wide - 12.0));
        legends.fold(0.0, f64::max)
    };
    let tall = |row: usize| high + room(row);
    let top = EDGE + TITLE + BELOW_TITLE;
    let height = top + (0..rows).map(tall).sum::<f64>() + rows.saturating_sub(1) as f64 * BETWEEN + below + EDGE;
    let mut sheet = Sheet::new(across + 2.0 * EDGE, height.ceil());
    let title = set(&format!("Fig. {}: {}", figure.number, figure.title));
    let fits = (across / width(&title, TITLE)).min(1.0);
    sheet.words([EDGE, EDGE + 0.5 * TITLE], &title, TITLE * fits, INK, Anchor::Start);
    let mut y = top;
    for row in 0..rows {
        for column in 0..columns {
            let index = row * columns + column;
            let Some(panel) = panels.get(index) else { break };
            let x = EDGE + column as f64 * (wide + BETWEEN);
            let sides = [x, y, x + wide, y + tall(row)];
            panel::draw(&mut sheet, panel, &heading(panel, index, panels.len() > 1), sides, (&own(panel), room(row)), 1.0);
        }
        y += tall(row) + BETWEEN;
    }
    if let Some(legend) = common {
        legend.draw(&mut sheet, [EDGE + 6.0, y - BETWEEN + 8.0], across);
    }
    sheet
}
