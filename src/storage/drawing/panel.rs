//! One diagram: frame and ticks, areas, curves, symbols, arrows, words, the pictures inside it, and
//! its legend: beneath it or, where all diagrams of a page speak of the same, beneath the page. So it
//! covers nothing.

use super::svg::{
    Anchor, GRID, GROUND, Place, RULE, Sheet, Sides, cut_line, cut_polygon, cut_segment, frame,
    ink, rectangle, set, solid, width,
};
use crate::plot::panel::{
    Area, Arrow, Axis, Colour, Content, Fill, Inset, Label, Look, Panel, Role, Series, Symbol,
    entries,
};
use crate::plot::scale::{Scale, scales, ticks};
use crate::plot::style::{Colours, MARKS, Rgb, Stroke, marked, pointing, stroke};
use crate::storage::picture::{common_scale, gap_pixels};

/// Sizes of letters: ticks, names of axes, headings, words in the diagram.
const TICK: f64 = 12.5;
const NAME: f64 = 14.5;
const HEADING: f64 = 14.5;
const WORD: f64 = 12.5;

/// A diagram placed on the sheet.
struct Plot<'a> {
    panel: &'a Panel,
    x: Scale,
    y: Scale,
    /// Left, top, right, bottom of the frame.
    sides: Sides,
    /// 1 in a diagram of full size.
    size: f64,
}

/// Draws a diagram into a place given by left, top, right, bottom, with its `legend` beneath it in
/// a strip `room` high.
pub(super) fn draw(
    sheet: &mut Sheet,
    panel: &Panel,
    heading: &str,
    place: Sides,
    (legend, room): (&Legend, f64),
    size: f64,
) {
    let [left, top, right, bottom] = place;
    let [x, y] = scales(panel);
    let labels = ticks(&y).0.into_iter().filter_map(|tick| tick.label);
    let widest = labels
        .map(|label| width(&set(&label), TICK * size))
        .fold(0.0, f64::max);
    let named = |axis: &Axis| {
        if axis.label.is_empty() {
            0.0
        } else {
            (NAME + 8.0) * size
        }
    };
    let above = if heading.is_empty() {
        8.0 * size
    } else {
        (HEADING + 14.0) * size
    };
    let inside = [
        left + widest + 12.0 * size + named(&panel.y),
        top + above,
        right - 12.0 * size,
        bottom - (TICK + 12.0) * size - named(&panel.x) - room,
    ];
    let plot = Plot {
        panel,
        x,
        y,
        sides: inside,
        size,
    };
    if !heading.is_empty() {
        sheet.words(
            [inside[0], top + 0.5 * above],
            &set(heading),
            HEADING * size,
            ink(),
            Anchor::Start,
        );
    }
    plot.axes(sheet, left);
    plot.contents(sheet);
    let beneath = inside[3] + (TICK + 12.0) * size + named(&panel.x);
    legend.draw(
        sheet,
        [left + 6.0 * size, beneath],
        right - left - 12.0 * size,
    );
}

impl Plot<'_> {
    fn place(&self, [x, y]: Place) -> Option<Place> {
        let [left, top, right, bottom] = self.sides;
        Some([
            left + self.x.place(x)? * (right - left),
            bottom - self.y.place(y)? * (bottom - top),
        ])
    }

    fn axes(&self, sheet: &mut Sheet, outer: f64) {
        let [left, top, right, bottom] = self.sides;
        let size = self.size;
        let (xs, x_factor) = ticks(&self.x);
        let (ys, y_factor) = ticks(&self.y);
        // Both ends of either axis, and where a share of it lies at a place of the other.
        let ends = [[left, right], [bottom, top]];
        let place = |axis: usize, share: f64, other: f64| {
            let [low, high] = ends[axis];
            let mut place = [other; 2];
            place[axis] = low + share * (high - low);
            place
        };
        let across = |axis: usize, share: f64| ends[1 - axis].map(|end| place(axis, share, end));
        for (axis, ticks) in [&xs, &ys].into_iter().enumerate() {
            for tick in ticks.iter().filter(|tick| tick.label.is_some()) {
                sheet.line(&across(axis, tick.at), solid(GRID, size));
            }
        }
        if let Some(zero) = self.y.zero() {
            sheet.line(&across(1, zero), solid(RULE, size));
        }
        let stroke = solid(ink(), size);
        let beyond = [
            (bottom + (6.0 + 0.5 * TICK) * size, Anchor::Middle),
            (left - 6.0 * size, Anchor::End),
        ];
        for (axis, ticks) in [&xs, &ys].into_iter().enumerate() {
            let [edge, far] = ends[1 - axis];
            for tick in ticks {
                let long = if tick.label.is_some() { 5.0 } else { 3.0 } * size;
                let inside = edge + (far - edge).signum() * long;
                let mark = [edge, inside].map(|other| place(axis, tick.at, other));
                sheet.line(&mark, stroke);
                if let Some(label) = &tick.label {
                    let (other, anchor) = beyond[axis];
                    let at = place(axis, tick.at, other);
                    sheet.words(at, &set(label), TICK * size, ink(), anchor);
                }
            }
        }
        let named = |axis: &Axis, factor: i32| match (axis.label.as_str(), factor) {
            (label, 0) => label.to_owned(),
            (label, factor) => format!(
                "{label}  (×10^{{{}}})",
                factor.to_string().replace('-', "\u{2212}")
            ),
        };
        let below = bottom + (12.0 + TICK + 0.5 * NAME) * size;
        let name = |text: &str, room: f64| {
            let runs = set(text);
            let fits = (room / width(&runs, NAME * size)).min(1.0);
            (runs, NAME * size * fits)
        };
        let (runs, letters) = name(&named(&self.panel.x, x_factor), right - outer);
        sheet.words(
            [0.5 * (left + right), below],
            &runs,
            letters,
            ink(),
            Anchor::Middle,
        );
        let (runs, letters) = name(&named(&self.panel.y, y_factor), 1.1 * (bottom - top));
        sheet.upright(
            [outer + (0.5 * NAME + 2.0) * size, 0.5 * (top + bottom)],
            &runs,
            letters,
            ink(),
        );
        sheet.line(&frame(self.sides), stroke);
    }

    fn contents(&self, sheet: &mut Sheet) {
        for area in &self.panel.areas {
            self.area(sheet, area);
        }
        for role in Role::ORDER {
            for series in self
                .panel
                .series
                .iter()
                .filter(|s| s.role == role && s.symbol.is_none())
            {
                self.line(sheet, series);
            }
        }
        for series in &self.panel.series {
            if let Some(shape) = series.symbol {
                let shown = series
                    .points
                    .iter()
                    .filter(|p| self.x.shows(p[0]) && self.y.shows(p[1]));
                for at in shown.filter_map(|p| self.place(*p)) {
                    sheet.symbol(
                        shape,
                        at,
                        series.colour.on(GROUND),
                        SYMBOL * self.size,
                        series.fill,
                    );
                }
            }
        }
        for arrow in &self.panel.arrows {
            self.in_frame(sheet, arrow);
        }
        for inset in &self.panel.insets {
            self.inset(sheet, inset);
        }
        for label in &self.panel.labels {
            self.label(sheet, label);
        }
    }

    fn label(&self, sheet: &mut Sheet, label: &Label) {
        if !(self.x.shows(label.at[0]) && self.y.shows(label.at[1])) {
            return;
        }
        let Some([x, y]) = self.place(label.at) else {
            return;
        };
        let runs = set(&label.text);
        let (half, high) = (
            0.5 * width(&runs, WORD * self.size) + 2.0,
            0.62 * WORD * self.size,
        );
        let [right, up] = label.side.map(f64::from);
        let gap = 4.0 * self.size;
        let [x, y] = [x + right * (half + gap), y - up * (high + gap)];
        let clear = cut_polygon(
            &rectangle([x - half, y - high, x + half, y + high]),
            self.sides,
        );
        sheet.fill(&clear, GROUND.colour(), 0.7);
        sheet.words(
            [x, y],
            &runs,
            WORD * self.size,
            label.colour.on(GROUND),
            Anchor::Middle,
        );
    }

    fn line(&self, sheet: &mut Sheet, series: &Series) {
        let stroke = scaled(stroke(series.role, series.colour, GROUND), self.size);
        for mut piece in cut_line(series.points.iter().map(|p| self.place(*p)), self.sides) {
            thin(&mut piece);
            sheet.line(&piece, stroke);
            if let Some(direction) = series.direction {
                let every = (self.sides[2] - self.sides[0]) / MARKS;
                for at in marked(&piece, every) {
                    sheet.symbol(
                        pointing(direction),
                        at,
                        stroke.colour,
                        MARK * self.size,
                        Fill::Filled,
                    );
                }
            }
        }
    }

    fn area(&self, sheet: &mut Sheet, area: &Area) {
        for piece in area.spans.split(|span| !span.iter().all(|v| v.is_finite())) {
            let edge = |k: usize| {
                piece
                    .iter()
                    .filter_map(move |span| self.place(area.edge(span, k)))
            };
            let mut outline: Vec<Place> = edge(1).collect();
            let mut upper: Vec<Place> = edge(2).collect();
            upper.reverse();
            outline.append(&mut upper);
            let shape = cut_polygon(&outline, self.sides);
            if shape.len() > 2 {
                sheet.fill(&shape, area.colour.on(GROUND), GROUND.opacity());
                let closed: Vec<Place> = shape.iter().chain(shape.first()).copied().collect();
                sheet.line(&closed, solid(area.colour.on(GROUND), 0.8 * self.size));
            }
        }
    }

    fn in_frame(&self, sheet: &mut Sheet, shown: &Arrow) {
        let (Some(tail), Some(tip)) = (self.place(shown.tail), self.place(shown.head)) else {
            return;
        };
        let Some((a, b)) = cut_segment(tail, tip, self.sides) else {
            return;
        };
        if b == tip {
            arrow(sheet, a, b, shown.colour, self.size);
        } else {
            sheet.line(&[a, b], solid(shown.colour.on(GROUND), 1.3 * self.size));
        }
    }

    fn inset(&self, sheet: &mut Sheet, inset: &Inset) {
        let [left, top, right, bottom] = self.sides;
        let [x, y, w, h] = inset.place;
        let (wide, high) = (w * (right - left), h * (bottom - top));
        let (left, top) = (
            left + x * (right - left),
            bottom - y * (bottom - top) - high,
        );
        match &inset.content {
            Content::Diagram(panel) => {
                let sides = [left, top, left + wide, top + high];
                sheet.fill(&rectangle(sides), GROUND.colour(), 0.9);
                let size = 0.8 * self.size;
                let legend = Legend::of(panel, size);
                let room = legend.height(wide - 12.0 * size);
                draw(sheet, panel, &panel.title, sides, (&legend, room), size);
            }
            Content::Map { letter, gap } => {
                let image = gap_pixels(gap, common_scale(self.panel.maps()), Colours::default());
                let (columns, rows) = (
                    f64::from(image.width().max(1)),
                    f64::from(image.height().max(1)),
                );
                // A square cell is a square; a line cell fills its place, and so does a map that has
                // the diagram's own axes.
                let scale = (wide / columns).min(high / rows);
                let (wide, high) = if rows == 1.0 || inset.place == [0.0, 0.0, 1.0, 1.0] {
                    (wide, high)
                } else {
                    (columns * scale, rows * scale)
                };
                sheet.picture([left, top, wide, high], &image);
                sheet.line(
                    &frame([left, top, left + wide, top + high]),
                    solid(ink(), self.size),
                );
                let runs = set(letter);
                let room = width(&runs, WORD * self.size) + 6.0 * self.size;
                if !letter.is_empty() {
                    let tall = 1.3 * WORD * self.size;
                    sheet.fill(
                        &rectangle([left, top, left + room, top + tall]),
                        GROUND.colour(),
                        1.0,
                    );
                    sheet.line(
                        &frame([left, top, left + room, top + tall]),
                        solid(ink(), 0.7 * self.size),
                    );
                    sheet.words(
                        [left + 0.5 * room, top + 0.5 * tall],
                        &runs,
                        WORD * self.size,
                        ink(),
                        Anchor::Middle,
                    );
                }
            }
        }
    }
}

/// Drops points that nobody can see beside their neighbours.
fn thin(piece: &mut Vec<Place>) {
    const NEAR: f64 = 0.15;
    let last = piece.len() - 1;
    let mut kept = [f64::INFINITY; 2];
    let mut i = 0;
    piece.retain(|p| {
        let keep = i == 0 || i == last || (p[0] - kept[0]).abs().max((p[1] - kept[1]).abs()) > NEAR;
        if keep {
            kept = *p;
        }
        i += 1;
        keep
    });
}

/// The entries in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Legend {
    entries: Vec<(String, Look)>,
    /// 1 in a diagram of full size.
    size: f64,
}

/// Radii of symbols, and of the marks along a line.
const SYMBOL: f64 = 4.2;
const MARK: f64 = 4.0;
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
fn scaled(stroke: Stroke, size: f64) -> Stroke {
    Stroke {
        width: size * stroke.width,
        dash: stroke.dash.map(|dash| dash.map(|length| size * length)),
        ..stroke
    }
}

/// Draws an arrow.
fn arrow(sheet: &mut Sheet, tail: Place, tip: Place, colour: Colour, size: f64) {
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
