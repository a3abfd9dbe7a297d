//! Diagrams and tables as pictures, SVG and PNG. The same value gives the same bytes.
//!
//! Everything is drawn once, onto a sheet that is the SVG; the PNG is that SVG rendered.

mod panel;
mod svg;
#[cfg(test)]
mod tests;

pub(super) use svg::escaped;

use super::picture::write_png;
use super::{Failure, files};
use crate::paper::figure::Table;
use crate::plot::panel::{Page, Panel};
use image::RgbImage;
use panel::Legend;
use std::path::Path;
use svg::{Anchor, RULE, Sheet, ink, set, solid, width};

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
