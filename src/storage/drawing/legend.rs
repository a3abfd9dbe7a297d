//! The legend: beneath its diagram or, where all diagrams of a page speak of the same, beneath the
//! page. So it covers nothing.

use super::svg::{Anchor, GROUND, Place, Sheet, frame, ink, rectangle, set, solid, width};
use crate::plot::panel::{Colour, Fill, Look, Panel, Symbol, entries};
use crate::plot::style::{Rgb, Stroke, pointing, stroke};

/// The entries in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Legend {
    entries: Vec<(String, Look)>,
    /// 1 in a diagram of full size.
    size: f64,
}

/// Radii of symbols, and of the marks along a line.
pub(super) const SYMBOL: f64 = 4.2;
pub(super) const MARK: f64 = 4.0;
/// Length of a sample, its distance to the word, the distance to the next sample, the height of a
/// row.
const SAMPLE: f64 = 30.0;
const GAP: f64 = 7.0;
const NEXT: f64 = 20.0;
const ROW: f64 = 20.0;
const TEXT: f64 = 12.5;

impl Legend {
    /// The legend of one diagram.
    pub(super) fn of(panel: &Panel, size: f64) -> Self {
        Self {
            entries: entries(panel),
            size,
        }
    }

    /// One legend for all diagrams, if it says nothing twice in two ways: no look has two names.
    pub(super) fn common(panels: &[Panel]) -> Option<Self> {
        let mut entries: Vec<(String, Look)> = Vec::new();
        for entry in panels.iter().flat_map(|panel| Self::of(panel, 1.0).entries) {
            if entries.contains(&entry) {
                continue;
            }
            if entries
                .iter()
                .any(|known| known.1 == entry.1 || known.0 == entry.0)
            {
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
                let middle = [0.5 * (left + right), y];
                match *look {
                    Look::Line(role, colour, direction) => {
                        let stroke = stroke(role, colour, GROUND);
                        sheet.line(&[[left, y], [right, y]], scaled(stroke, self.size));
                        if let Some(direction) = direction {
                            sheet.symbol(
                                pointing(direction),
                                middle,
                                stroke.colour,
                                MARK * self.size,
                                Fill::Filled,
                            );
                        }
                    }
                    Look::Symbol(shape, colour, fill) => {
                        // Large symbols go around others.
                        let large = matches!(shape, Symbol::Ring | Symbol::Frame);
                        let radius = SYMBOL * self.size * if large { 0.6 } else { 1.0 };
                        sheet.symbol(shape, middle, colour.on(GROUND), radius, fill);
                    }
                    Look::Area(colour) => {
                        let half = 6.0 * self.size;
                        let sides = [left, y - half, right, y + half];
                        sheet.fill(&rectangle(sides), colour.on(GROUND), GROUND.opacity());
                        sheet.line(&frame(sides), solid(colour.on(GROUND), 0.8 * self.size));
                    }
                    Look::Arrow(colour) => {
                        arrow(
                            sheet,
                            [middle[0], y + 8.0 * self.size],
                            [middle[0], y - 8.0 * self.size],
                            colour,
                            self.size,
                        );
                    }
                }
                sheet.words(
                    [right + self.size * GAP, y],
                    &set(name),
                    self.size * TEXT,
                    ink(),
                    Anchor::Start,
                );
            }
        }
    }
}

/// A stroke in a diagram of this size.
pub(super) fn scaled(stroke: Stroke, size: f64) -> Stroke {
    Stroke {
        width: size * stroke.width,
        dash: stroke.dash.map(|dash| dash.map(|length| size * length)),
        ..stroke
    }
}

/// Draws an arrow.
pub(super) fn arrow(sheet: &mut Sheet, tail: Place, tip: Place, colour: Colour, size: f64) {
    let colour = colour.on(GROUND);
    sheet.line(&[tail, tip], solid(colour, 1.3 * size));
    head(sheet, tail, tip, colour, size);
}

/// Draws the head of an arrow that arrives at `tip` from `from`.
fn head(sheet: &mut Sheet, from: Place, tip: Place, colour: Rgb, size: f64) {
    let (dx, dy) = (tip[0] - from[0], tip[1] - from[1]);
    let length = dx.hypot(dy);
    if length < 1e-6 {
        return;
    }
    let long = (9.0 * size).min(length.max(4.0 * size));
    let (ux, uy) = (long * dx / length, long * dy / length);
    let (wx, wy) = (-0.4 * uy, 0.4 * ux);
    sheet.fill(
        &[
            tip,
            [tip[0] - ux + wx, tip[1] - uy + wy],
            [tip[0] - ux - wx, tip[1] - uy - wy],
        ],
        colour,
        1.0,
    );
}
