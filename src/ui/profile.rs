//! The profile along the line drawn on the map: elastomer above, rigid indenter below, as in the
//! paper's Fig. 1, and between them where they pull at each other and where they push. Its scale is
//! the scene's. The elastomer is the handle of what is driven.
//!
//! Under it the path as a strip: a row for each direction, coloured and lettered by pattern, over the
//! axis of what is driven. It is time line and scrubber in one: a press or a drag shows the stored
//! state there. What the live loop foresees is paler, where nothing was walked yet.

use super::action::Action;
use super::gap_map::{self, STRIP};
use super::gap_picture::GapPicture;
use super::grip;
use super::theme::{self, Palette};
use super::view_state::{Span, ViewState, foreseen, spans};
use super::widgets::described;
use crate::follow::record::{Direction, StateRecord};
use crate::physics::control::Control;
use crate::physics::indenter::Indenter;
use crate::physics::law::Law;
use crate::physics::parameter::Dimension;
use crate::plot::panel::Colour;
use crate::plot::scale;
use crate::scene::parameter::fixed;
use egui::{
    Align2, Color32, CursorIcon, FontId, Mesh, Pos2, Rect, Sense, Stroke, StrokeKind, Ui, pos2,
    vec2,
};
use ndarray::{Array2, Axis};

/// Least height of what shows pull and push: where the surfaces touch there is hardly a gap.
const BAND: f32 = 5.0;

/// Draws the profile in the rest of the column.
pub fn show(
    ui: &mut Ui,
    state: &ViewState,
    picture: Option<&GapPicture>,
    actions: &mut Vec<Action>,
) {
    let height = (ui.available_height() - STRIP).clamp(70.0, 300.0);
    let (_, area) = ui.allocate_space(vec2(ui.available_width(), height));
    let frame = Rect::from_min_max(area.min + vec2(34.0, 4.0), area.max - vec2(6.0, 20.0));
    let (low, high) = heights(state);
    let unit = state.model.unit(Dimension::Length);
    let one = state.rho() / unit.scale;
    let picture = picture.filter(|_| !state.is_waiting());
    let cut = picture.map(|p| gap_map::cut(&state.view, p));
    let name = match cut {
        Some((true, row)) => {
            format!("Profile along x through row {row}: elastomer above, indenter below")
        }
        Some((false, column)) => {
            format!("Profile along y through column {column}: elastomer above, indenter below")
        }
        None => "Profile: waiting for the solver …".to_owned(),
    };
    let response = ui.interact(frame, gap_map::profile_id(), Sense::drag());
    described(&response, &name);
    // The body keeps to the hand; a load has no height of its own.
    let driven = if state.scene.control() == Control::Load {
        state.limits.1 - state.limits.0
    } else {
        high - low
    };
    let per_point = driven / f64::from(frame.height());
    grip::drag(ui, state, &response, per_point, actions);
    ui.painter()
        .rect_filled(frame, 0.0, ui.visuals().extreme_bg_color);
    if let (Some(picture), Some(cut)) = (picture, cut) {
        bodies(ui, state, picture, cut, frame, (low, high));
    }
    ui.painter().rect_stroke(
        frame,
        0.0,
        gap_map::frame_stroke(ui, state),
        StrokeKind::Outside,
    );
    axes(
        ui,
        state,
        frame,
        (low / one, high / one),
        cut.is_none_or(|(along_x, _)| along_x),
    );
}

/// Lower and upper end of the height axis.
fn heights(state: &ViewState) -> (f64, f64) {
    let rho = state.rho();
    match state.model.indenter {
        Indenter::Flat => {
            let top = scale::gap_scale(&state.scene, &state.model);
            (-0.22 * top, 1.22 * top)
        }
        _ => {
            let depth = state.model.indenter.ground().relief(&state.model.law);
            (
                -2.0 * depth - 3.0 * rho,
                state.scene.drive.start.max(0.0) + depth + 3.0 * rho,
            )
        }
    }
}

fn bodies(
    ui: &Ui,
    state: &ViewState,
    picture: &GapPicture,
    (along_x, index): (bool, usize),
    frame: Rect,
    (low, high): (f64, f64),
) {
    let lane = |field: &Array2<f64>| {
        let axis = Axis(usize::from(!along_x));
        field.index_axis(axis, index).to_vec()
    };
    let gap = lane(&picture.gap);
    let n = gap.len();
    // The map is not rolled on uneven ground, so that the height belongs to the same row.
    let height: Vec<f64> = match state
        .run
        .ready
        .as_ref()
        .and_then(|ready| ready.height.as_ref())
    {
        Some(h) if h.dim() == picture.gap.dim() => lane(h),
        _ => vec![0.0; n],
    };
    let y_of = |z: f64| {
        frame.bottom() - ((z - low) / (high - low)).clamp(0.0, 1.0) as f32 * frame.height()
    };
    let x_of = |i: usize| frame.left() + i as f32 / n as f32 * frame.width();
    // Periodic: the first point comes again at the right edge.
    let along = |z: &dyn Fn(usize) -> f64| -> Vec<Pos2> {
        (0..=n).map(|i| pos2(x_of(i), y_of(z(i % n)))).collect()
    };
    let soft = along(&|i| gap[i] + height[i]);
    let rigid = along(&|i| height[i]);
    let palette = theme::palette(ui);
    fill(ui, &soft, frame.top(), palette.elastomer);
    fill(ui, &rigid, frame.bottom(), palette.indenter);
    traction(ui, (&soft, &rigid), &gap, &state.model.law, &palette);
    let painter = ui.painter().with_clip_rect(frame);
    let edge = ui.visuals().strong_text_color();
    painter.line(rigid, Stroke::new(1.2, edge.gamma_multiply(0.7)));
    let middle = soft[n / 2];
    painter.line(soft, Stroke::new(1.8, edge));
    let grip = grip::grip(ui, state, frame, middle);
    let per_x = state.model.grid.length / f64::from(frame.width());
    let stretch = per_x / ((high - low) / f64::from(frame.height()));
    let words = [
        (Align2::LEFT_TOP, "elastomer".to_owned()),
        (Align2::LEFT_BOTTOM, "rigid indenter".to_owned()),
        (Align2::RIGHT_TOP, format!("heights ×{stretch:.0}")),
    ];
    let ink = if ui.visuals().dark_mode {
        Color32::WHITE
    } else {
        Color32::BLACK
    };
    let words = words.map(|(corner, words)| {
        let galley = painter.layout_no_wrap(words, theme::small(), ink);
        let inside = frame.shrink2(vec2(8.0, 3.0));
        (corner.align_size_within_rect(galley.size(), inside), galley)
    });
    let written = [0, 1, 2].map(|i| words[i].0);
    let taken = [Some(grip), grip::bubble(ui, state, frame, grip, &written)];
    for (area, galley) in words {
        // What is to be done goes before what a body is called.
        if !taken.iter().flatten().any(|taken| taken.intersects(area)) {
            painter.galley(area.min, galley, ink);
        }
    }
    let mut at = frame.right_bottom() - vec2(8.0, 3.0);
    for (word, colour) in [("push", palette.push), ("pull", palette.pull)] {
        let galley = painter.layout_no_wrap(word.to_owned(), theme::small(), ink);
        let area = Align2::RIGHT_BOTTOM.anchor_size(at, galley.size());
        let square = Rect::from_center_size(area.left_center() - vec2(9.0, 0.0), vec2(9.0, 9.0));
        let whole = area.union(square);
        if taken.iter().flatten().any(|taken| taken.intersects(whole)) {
            break;
        }
        painter.rect(
            square,
            1.0,
            colour,
            Stroke::new(1.0, ink),
            StrokeKind::Outside,
        );
        painter.galley(area.min, galley, ink);
        at.x = square.left() - 10.0;
    }
}

/// What is between the surfaces, the stronger in colour the stronger they pull at each other or push
/// each other away.
fn traction(ui: &Ui, (soft, rigid): (&[Pos2], &[Pos2]), gap: &[f64], law: &Law, palette: &Palette) {
    let (paper, top) = (ui.visuals().extreme_bg_color, law.traction_max());
    let columns = soft.iter().zip(rigid).zip(gap.iter().cycle());
    let columns = columns.map(|((soft, rigid), gap)| {
        let share = law.at(*gap).traction / top;
        let colour = if share > 0.0 {
            palette.pull
        } else {
            palette.push
        };
        let colour = paper.lerp_to_gamma(colour, share.abs().min(1.0) as f32);
        let (high, low) = (soft.y.min(rigid.y), soft.y.max(rigid.y));
        let more = (0.5 * (BAND - (low - high))).max(0.0);
        ([high - more, low + more].map(|y| pos2(soft.x, y)), colour)
    });
    quads(ui, columns);
}

/// Fills between a curve and a level.
fn fill(ui: &Ui, curve: &[Pos2], level: f32, colour: Color32) {
    let column = |p: &Pos2| ([*p, pos2(p.x, level)], colour);
    quads(ui, curve.iter().map(column));
}

/// Fills a strip from column to column, each with its ends and its colour; of quads, since the
/// outline is not convex.
fn quads(ui: &Ui, columns: impl Iterator<Item = ([Pos2; 2], Color32)>) {
    let mut mesh = Mesh::default();
    for (ends, colour) in columns {
        for end in ends {
            mesh.colored_vertex(end, colour);
        }
    }
    for k in 0..(mesh.vertices.len() as u32 / 2).saturating_sub(1) {
        mesh.add_triangle(2 * k, 2 * k + 1, 2 * k + 2);
        mesh.add_triangle(2 * k + 1, 2 * k + 2, 2 * k + 3);
    }
    ui.painter().add(mesh);
}

fn axes(ui: &Ui, state: &ViewState, frame: Rect, (low, high): (f64, f64), along_x: bool) {
    let colour = ui.visuals().text_color();
    let tick = Stroke::new(1.0, colour);
    let painter = ui.painter();
    let (values, spacing) = scale::within(low, high, 5.0);
    for value in values {
        let y = frame.bottom() - ((value - low) / (high - low)) as f32 * frame.height();
        painter.hline(frame.left() - 4.0..=frame.left(), y, tick);
        // The uppermost number gives way to the name of the axis.
        if y > frame.top() + 26.0 {
            let text = scale::label(value, spacing);
            painter.text(
                pos2(frame.left() - 6.0, y),
                Align2::RIGHT_CENTER,
                text,
                theme::small(),
                colour,
            );
        }
    }
    let [across, up] = [
        state.model.unit_across(),
        state.model.unit(Dimension::Length),
    ];
    let length = state.model.grid.length / state.rho() * across.scale;
    let (values, spacing) = scale::within(0.0, length, 5.5);
    for value in values.into_iter().filter(|value| *value <= 0.9 * length) {
        let x = frame.left() + (value / length) as f32 * frame.width();
        painter.vline(x, frame.bottom()..=frame.bottom() + 4.0, tick);
        let anchor = if value == 0.0 {
            Align2::LEFT_TOP
        } else if value > 0.93 * length {
            Align2::RIGHT_TOP
        } else {
            Align2::CENTER_TOP
        };
        let text = scale::label(value, spacing);
        painter.text(
            pos2(x, frame.bottom() + 5.0),
            anchor,
            text,
            theme::small(),
            colour,
        );
    }
    let name = if along_x {
        across.label("x / ρ", "x")
    } else {
        across.label("y / ρ", "y")
    };
    painter.text(
        pos2(frame.right() + 2.0, frame.bottom() + 5.0),
        Align2::RIGHT_TOP,
        name,
        theme::small(),
        colour,
    );
    painter.text(
        pos2(frame.left() - 32.0, frame.top() + 2.0),
        Align2::LEFT_TOP,
        up.label("z/ρ", "z"),
        theme::small(),
        colour,
    );
}

/// Height of a row, and the room between the two.
const ROW: f32 = 20.0;
const BETWEEN: f32 = 3.0;
/// Size of the letters, and the least width of a span that has one.
const LETTER: f32 = 13.0;
const WIDE: f32 = 12.0;
/// How much of its colour a span keeps that is only foreseen.
const PALE: f32 = 0.28;

/// The rows from above, with the mark of each.
const ROWS: [(Direction, &str); 2] = [(Direction::Approach, "◀"), (Direction::Retraction, "▶")];

/// Draws the strip at the foot of the column.
pub fn strip(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let (_, area) = ui.allocate_space(vec2(ui.available_width(), STRIP));
    let top = area.top() + 4.0;
    let rows = ROWS.len() as f32;
    let band = Rect::from_min_max(
        pos2(area.left() + 34.0, top),
        pos2(
            area.right() - 6.0,
            top + rows * ROW + (rows - 1.0) * BETWEEN,
        ),
    );
    let response = ui.interact(band, egui::Id::unique("strip"), Sense::CLICK | Sense::DRAG);
    let (walked, ahead) = all(state);
    described(&response, &sentence(&walked, &ahead));
    let strip = Strip { state, band };
    for (row, (direction, mark)) in ROWS.into_iter().enumerate() {
        strip.draw_row(ui, row, (direction, mark), &walked, &ahead);
    }
    strip.marks(ui);
    if response.hovered() {
        ui.ctx().set_cursor_icon(CursorIcon::ResizeHorizontal);
    }
    if response.is_pointer_button_down_on()
        && let Some(at) = response.interact_pointer_pos()
        && ui.input(|input| input.pointer.any_pressed() || input.pointer.delta().x != 0.0)
    {
        let pressed = ui.input(|input| input.pointer.press_origin()).unwrap_or(at);
        actions.push(Action::SelectOn(strip.direction(pressed), strip.value(at)));
    }
    if let Some(at) = response.hover_pos() {
        let words = strip.reading(at, &walked, &ahead);
        response.on_hover_text_at_pointer(words);
    }
}

/// What was walked, and what is foreseen.
fn all(state: &ViewState) -> (Vec<Span>, Vec<Span>) {
    let ahead = state.live().map_or_else(Vec::new, foreseen);
    (spans(&state.run.record), ahead)
}

/// Both rows in letters.
fn sentence(walked: &[Span], ahead: &[Span]) -> String {
    let letters = |of: &[Span], direction: Direction| {
        let row = of.iter().filter(|span| span.direction == direction);
        let letters: Vec<&str> = row.map(Span::letter).collect();
        if letters.is_empty() {
            "nothing".to_owned()
        } else {
            letters.join(" ")
        }
    };
    let both = |of: &[Span]| {
        let [down, up] = ROWS.map(|(direction, _)| letters(of, direction));
        format!("{down} on approach, {up} on retraction")
    };
    let mut words = format!("Patterns walked: {}", both(walked));
    if !ahead.is_empty() {
        words += &format!("; foreseen: {}", both(ahead));
    }
    words
}

/// The strip in its place.
struct Strip<'a> {
    state: &'a ViewState,
    band: Rect,
}

impl Strip<'_> {
    fn x_of(&self, control: f64) -> f32 {
        let (low, high) = self.state.limits;
        let share = ((control - low) / (high - low)).clamp(0.0, 1.0);
        self.band.left() + share as f32 * self.band.width()
    }

    fn value(&self, at: Pos2) -> f64 {
        let (low, high) = self.state.limits;
        let share = f64::from((at.x - self.band.left()) / self.band.width());
        low + share.clamp(0.0, 1.0) * (high - low)
    }

    fn row(&self, index: usize) -> Rect {
        let top = self.band.top() + index as f32 * (ROW + BETWEEN);
        Rect::from_x_y_ranges(self.band.x_range(), top..=top + ROW)
    }

    /// The direction of the row that is nearer.
    fn direction(&self, at: Pos2) -> Direction {
        ROWS[usize::from(at.y > self.band.center().y)].0
    }

    fn draw_row(
        &self,
        ui: &Ui,
        index: usize,
        (direction, mark): (Direction, &str),
        walked: &[Span],
        ahead: &[Span],
    ) {
        let row = self.row(index);
        let ground = theme::ground(ui);
        ui.painter()
            .rect_filled(row, 2.0, ui.visuals().extreme_bg_color);
        ui.painter().text(
            row.left_center() - vec2(8.0, 0.0),
            Align2::RIGHT_CENTER,
            mark,
            FontId::proportional(LETTER),
            theme::rgb(Colour::of(direction).on(ground)),
        );
        let paper = ui.visuals().extreme_bg_color;
        let ink = ui.visuals().strong_text_color();
        let of_row = |spans: &[Span]| {
            let here = spans.iter().filter(|s| s.direction == direction);
            here.copied().collect::<Vec<_>>()
        };
        let walked = of_row(walked);
        for (spans, above, strength, ink) in [
            (&of_row(ahead), &walked[..], PALE, ui.visuals().text_color()),
            (&walked, &[], 0.62, ink),
        ] {
            for span in spans {
                let colour = theme::rgb(Colour::of_pattern(span.pattern).on(ground));
                let fill = paper.lerp_to_gamma(colour, strength);
                let rect = self.place(row, span);
                ui.painter().rect_filled(rect, 0.0, fill);
                let edge = Stroke::new(1.0, paper);
                ui.painter().vline(rect.left(), row.y_range(), edge);
                let letter = Rect::from_center_size(rect.center(), vec2(WIDE, ROW));
                let covers = |other: &Span| self.place(row, other).intersects(letter);
                if rect.width() >= WIDE && !above.iter().any(covers) {
                    ui.painter().text(
                        rect.center(),
                        Align2::CENTER_CENTER,
                        span.letter(),
                        FontId::proportional(LETTER),
                        ink,
                    );
                }
            }
        }
    }

    /// Where a span lies in its row.
    fn place(&self, row: Rect, span: &Span) -> Rect {
        let [a, b] = span.ends.map(|control| self.x_of(control));
        Rect::from_x_y_ranges(a.min(b)..=a.max(b).max(a.min(b) + 1.0), row.y_range())
    }

    /// Where the surface is, and the stored state that is looked at.
    fn marks(&self, ui: &Ui) {
        let ink = theme::palette(ui).now;
        let row_of = |direction| usize::from(direction == Direction::Retraction);
        if let Some(now) = &self.state.run.state {
            let row = self.row(row_of(now.direction));
            let x = self.x_of(now.control);
            ui.painter()
                .vline(x, row.expand(2.0).y_range(), Stroke::new(3.0, ink));
        }
        if let Some(selection) = &self.state.run.selection {
            let row = self.row(row_of(selection.state.direction));
            let centre = pos2(self.x_of(selection.state.control), row.center().y);
            let frame = Rect::from_center_size(centre, vec2(9.0, row.height() + 4.0));
            ui.painter()
                .rect_stroke(frame, 2.0, Stroke::new(2.0, ink), egui::StrokeKind::Outside);
        }
    }

    /// What stands at a place, in words.
    fn reading(&self, at: Pos2, walked: &[Span], ahead: &[Span]) -> String {
        let (value, direction) = (self.value(at), self.direction(at));
        let told = self.state.told();
        let place = format!(
            "{} = {}{}",
            told.symbol,
            fixed(value / told.unit, 3),
            told.suffix
        );
        let here = |span: &&Span| {
            let [a, b] = span.ends;
            span.direction == direction && (a.min(b)..=a.max(b)).contains(&value)
        };
        if let Some(span) = walked.iter().rev().find(here) {
            let states = self.state.run.record.states.iter().rev();
            let off = |s: &&StateRecord| (s.control - value).abs();
            let of_row = states.filter(|s| s.direction == direction);
            let stress = of_row
                .min_by(|a, b| off(a).total_cmp(&off(b)))
                .map_or(String::new(), |s| {
                    format!(", stress {} σₘₐₓ", fixed(s.stress_over_max, 3))
                });
            return format!("{} on {direction}, {place}{stress}", span.pattern);
        }
        ahead.iter().find(here).map_or_else(
            || format!("{direction}, {place}: not walked yet"),
            |span| {
                let pattern = span.pattern;
                format!("{pattern} foreseen on {direction}, {place}: a click shows it")
            },
        )
    }
}
