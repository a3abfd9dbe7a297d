//! The path as a strip under the profile: a row for each direction, coloured and lettered by
//! pattern, over the axis of what is driven. It is time line and scrubber in one: a press or a drag
//! shows the stored state there. What the live loop foresees is paler, where nothing was walked
//! yet.

use super::action::Action;
use super::machine;
use super::theme;
use super::view_state::{Stretch, ViewState, foreseen, stretches};
use super::widgets::described;
use crate::follow::record::{Direction, StateRecord};
use crate::plot::panel::Colour;
use crate::scene::units::fixed;
use egui::{Align2, CursorIcon, FontId, Pos2, Rect, Sense, Stroke, Ui, pos2, vec2};

/// Height with its margins (points).
pub const HEIGHT: f32 = 54.0;
/// Height of a row, and the room between the two.
const ROW: f32 = 20.0;
const BETWEEN: f32 = 3.0;
/// Size of the letters, and the least width of a stretch that has one.
const LETTER: f32 = 13.0;
const WIDE: f32 = 12.0;
/// How much of its colour a stretch keeps that is only foreseen.
const PALE: f32 = 0.28;

/// The rows from above, with the mark of each.
const ROWS: [(Direction, &str); 2] = [(Direction::Approach, "◀"), (Direction::Retraction, "▶")];

/// Draws the strip at the foot of the column.
pub fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let (_, area) = ui.allocate_space(vec2(ui.available_width(), HEIGHT));
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
fn all(state: &ViewState) -> (Vec<Stretch>, Vec<Stretch>) {
    let ahead = state.live().map_or_else(Vec::new, foreseen);
    (stretches(&state.run.record), ahead)
}

/// Both rows in letters.
fn sentence(walked: &[Stretch], ahead: &[Stretch]) -> String {
    let letters = |of: &[Stretch], direction: Direction| {
        let row = of.iter().filter(|stretch| stretch.direction == direction);
        let letters: Vec<&str> = row.map(Stretch::letter).collect();
        if letters.is_empty() {
            "nothing".to_owned()
        } else {
            letters.join(" ")
        }
    };
    let both = |of: &[Stretch]| {
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
        walked: &[Stretch],
        ahead: &[Stretch],
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
        let of_row = |stretches: &[Stretch]| {
            let here = stretches.iter().filter(|s| s.direction == direction);
            here.copied().collect::<Vec<_>>()
        };
        let walked = of_row(walked);
        for (stretches, above, strength, ink) in [
            (&of_row(ahead), &walked[..], PALE, ui.visuals().text_color()),
            (&walked, &[], 0.62, ink),
        ] {
            for stretch in stretches {
                let colour = theme::rgb(Colour::of_pattern(stretch.pattern).on(ground));
                let fill = paper.lerp_to_gamma(colour, strength);
                let rect = self.place(row, stretch);
                ui.painter().rect_filled(rect, 0.0, fill);
                let edge = Stroke::new(1.0, paper);
                ui.painter().vline(rect.left(), row.y_range(), edge);
                let letter = Rect::from_center_size(rect.center(), vec2(WIDE, ROW));
                let covers = |other: &Stretch| self.place(row, other).intersects(letter);
                if rect.width() >= WIDE && !above.iter().any(covers) {
                    ui.painter().text(
                        rect.center(),
                        Align2::CENTER_CENTER,
                        stretch.letter(),
                        FontId::proportional(LETTER),
                        ink,
                    );
                }
            }
        }
    }

    /// Where a stretch lies in its row.
    fn place(&self, row: Rect, stretch: &Stretch) -> Rect {
        let [a, b] = stretch.ends.map(|control| self.x_of(control));
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
    fn reading(&self, at: Pos2, walked: &[Stretch], ahead: &[Stretch]) -> String {
        let (value, direction) = (self.value(at), self.direction(at));
        let told = machine::told(self.state);
        let place = format!(
            "{} = {}{}",
            told.symbol,
            fixed(value / told.unit, 3),
            told.suffix
        );
        let here = |stretch: &&Stretch| {
            let [a, b] = stretch.ends;
            stretch.direction == direction && (a.min(b)..=a.max(b)).contains(&value)
        };
        if let Some(stretch) = walked.iter().rev().find(here) {
            let states = self.state.run.record.states.iter().rev();
            let off = |s: &&StateRecord| (s.control - value).abs();
            let of_row = states.filter(|s| s.direction == direction);
            let stress = of_row
                .min_by(|a, b| off(a).total_cmp(&off(b)))
                .map_or(String::new(), |s| {
                    format!(", stress {} σₘₐₓ", fixed(s.stress_over_max, 3))
                });
            return format!("{} on {direction}, {place}{stress}", stretch.pattern);
        }
        ahead.iter().find(here).map_or_else(
            || format!("{direction}, {place}: not walked yet"),
            |stretch| {
                let pattern = stretch.pattern;
                format!("{pattern} foreseen on {direction}, {place}: a click shows it")
            },
        )
    }
}
