//! The legend: beneath its diagram or, where all diagrams of a figure speak of the same, beneath the figure. So it covers nothing.

use super::marks::{INK, shade, stroke, symbol};
use super::sheet::{Anchor, Place, Sheet, rectangle, set, width};
use crate::paper::figure::{Colour, Panel, Role, Symbol};

/// How an entry looks.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Look {
    Line(Role, Colour),
    Symbol(Symbol, Colour),
    Area(Colour),
}

/// The entries in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Legend {
    entries: Vec<(String, Look)>,
    /// 1 in a diagram of full size.
    size: f64,
}

/// Length of a sample, its distance to the word, the distance to the next sample, the height of a row.
const SAMPLE: f64 = 30.0;
const GAP: f64 = 7.0;
const NEXT: f64 = 20.0;
const ROW: f64 = 20.0;
const TEXT: f64 = 12.5;

impl Legend {
    /// The legend of one diagram.
    pub(super) fn of(panel: &Panel, size: f64) -> Self {
        let series = panel.series.iter().map(|s| {
            let look = s.symbol.map_or(Look::Line(s.role, s.colour), |symbol| Look::Symbol(symbol, s.colour));
            (s.name.clone(), look)
        });
        let areas = panel.areas.iter().map(|area| (area.name.clone(), Look::Area(area.colour)));
        let mut entries: Vec<(String, Look)> = Vec::new();
        for entry in series.chain(areas) {
            if !entry.0.is_empty() && !entries.contains(&entry) {
                entries.push(entry);
            }
        }
        Self { entries, size }
    }

    /// One legend for all diagrams, if it says nothing twice in two ways: no look has two names.
    pub(super) fn common(panels: &[Panel]) -> Option<Self> {
        let mut entries: Vec<(String, Look)> = Vec::new();
        for entry in panels.iter().flat_map(|panel| Self::of(panel, 1.0).entries) {
            if entries.contains(&entry) {
                continue;
            }
            if entries.iter().any(|known| known.1 == entry.1 || known.0 == entry.0) {
                return None;
            }
            entries.push(entry);
        }
        Some(Self { entries, size: 1.0 })
    }

    /// Rows of entries that fit into a width: where each stands along its row.
    fn rows(&self, available: f64) -> Vec<Vec<(f64, usize)>> {
        let mut rows: Vec<Vec<(f64, usize)>> = Vec::new();
        let mut x = f64::INFINITY;
        for (i, (name, _)) in self.entries.iter().enumerate() {
            let wide = self.size * (SAMPLE + GAP) + width(&set(name), self.size * TEXT);
            if x + wide > available {
                rows.push(Vec::new());
                x = 0.0;
            }
            if let Some(row) = rows.last_mut() {
                row.push((x, i));
            }
            x += wide + self.size * NEXT;
        }
        rows
    }

    /// Height at this width; zero if there is nothing to say.
    pub(super) fn height(&self, available: f64) -> f64 {
        self.size * ROW * self.rows(available).len() as f64
    }

    /// Draws it with its upper left corner at `corner`.
    pub(super) fn draw(&self, sheet: &mut Sheet, corner: Place, available: f64) {
        for (r, row) in self.rows(available).into_iter().enumerate() {
            let y = corner[1] + self.size * ROW * (r as f64 + 0.5);
            for (x, i) in row {
                let (name, look) = &self.entries[i];
                let (left, right) = (corner[0] + x, corner[0] + x + self.size * SAMPLE);
                match *look {
                    Look::Line(role, colour) => sheet.line([[left, y], [right, y]], stroke(role, colour, self.size)),
                    Look::Symbol(shape, colour) => symbol(sheet, shape, [0.5 * (left + right), y], colour, 4.5 * self.size),
                    Look::Area(colour) => {
                        let half = 6.0 * self.size;
                        sheet.fill(rectangle([left, y - half, right, y + half]), shade(colour), 0.5);
                    }
                }
                sheet.words([right + self.size * GAP, y], &set(name), self.size * TEXT, INK, Anchor::Start);
            }
        }
    }
}
