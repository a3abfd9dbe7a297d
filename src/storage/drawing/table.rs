//! A table as a drawing: heading, columns as wide as they need, thin rules.

use super::svg::{Anchor, RULE, Sheet, ink, set, solid, width};
use crate::paper::Table;

const TITLE: f64 = 17.0;
const TEXT: f64 = 13.5;
const ROW: f64 = 24.0;
const EDGE: f64 = 24.0;
const GAP: f64 = 26.0;
const WIDTH_MIN: f64 = 480.0;

/// The drawing.
pub(super) fn sheet(table: &Table) -> Sheet {
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
