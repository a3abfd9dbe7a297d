//! Diagrams and tables as files: pictures as SVG and PNG, the paper's data as CSV. The same value
//! gives the same bytes.
//!
//! Everything is drawn once, onto a sheet that is the SVG; the PNG is that SVG rendered.

mod clip;
mod csv;
mod legend;
mod panel;
mod svg;
mod table;
#[cfg(test)]
mod tests;

pub use csv::{
    FIGURE_COLUMNS, FINDING_COLUMNS, write_figure_csv, write_findings_csv, write_table_csv,
};
pub(super) use svg::escaped;

use super::picture::write_png;
use super::{Failure, files};
use crate::paper::figure::Table;
use crate::plot::panel::{Page, Panel};
use legend::Legend;
use std::path::Path;
use svg::{Anchor, Sheet, ink, set, width};

/// Edge of the sheet, sizes of its title and of the lines beneath, and the distance to the
/// diagrams.
const EDGE: f64 = 16.0;
const TITLE: f64 = 18.0;
const CAPTION: f64 = 13.0;
const LINE: f64 = 18.0;
const BELOW_TITLE: f64 = 10.0;
/// Distance between diagrams.
const BETWEEN: f64 = 20.0;

/// Writes the page as an SVG.
///
/// # Errors
/// A file that cannot be written.
pub fn write_page_svg(path: &Path, page: &Page<'_>) -> Result<(), Failure> {
    files::write_whole(path, page_svg(page).as_bytes())
}

/// Writes the page as a PNG, at least 1800 pixels wide.
///
/// # Errors
/// A file that cannot be written.
pub fn write_page_png(path: &Path, page: &Page<'_>) -> Result<(), Failure> {
    write_pixels(path, &page_sheet(page))
}

/// Writes the table as an SVG.
///
/// # Errors
/// A file that cannot be written.
pub fn write_table_svg(path: &Path, table: &Table) -> Result<(), Failure> {
    files::write_whole(path, table::sheet(table).svg().as_bytes())
}

/// Writes the table as a PNG, at least 1800 pixels wide.
///
/// # Errors
/// A file that cannot be written.
pub fn write_table_png(path: &Path, table: &Table) -> Result<(), Failure> {
    write_pixels(path, &table::sheet(table))
}

/// The page as the text of an SVG.
pub fn page_svg(page: &Page<'_>) -> String {
    page_sheet(page).svg()
}

fn write_pixels(path: &Path, sheet: &Sheet) -> Result<(), Failure> {
    write_png(
        path,
        &sheet
            .pixels()
            .map_err(|error| Failure::write(path, error))?,
    )
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
