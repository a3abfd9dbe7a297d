//! The body as its own handle: dragged up and down it moves what is driven. Until first used its
//! grip pulses, and a bubble at it says what to do.

use super::action::Action;
use super::theme;
use super::view_state::{Hint, ViewState};
use super::widgets::described;
use egui::{
    Color32, CursorIcon, FontId, Id, Pos2, Rect, Response, Sense, Shape, Stroke, StrokeKind, Ui,
    pos2, vec2,
};
use std::f64::consts::TAU;
use std::time::Duration;

/// Half of width and height of the grip (points).
const HALF: egui::Vec2 = vec2(21.0, 8.0);
/// Seconds of one pulse, and between two pictures of it.
const PULSE: f64 = 1.6;
const PICTURE: Duration = Duration::from_millis(40);
/// Length of the bubble's arrow below a grip (points).
const ARROW: f32 = 12.0;
/// Size of the bubble's words.
const WORDS: f32 = 13.0;

/// Moves what is driven with a drag up and down on `response`; one point of the screen is so much
/// of it, with Shift a tenth of that.
pub fn drag(
    ui: &Ui,
    state: &ViewState,
    response: &Response,
    per_point: f64,
    actions: &mut Vec<Action>,
) {
    // Not `dragged()`, which waits for six pixels: the body must move within the frame.
    let held = response.is_pointer_button_down_on();
    if held || response.hovered() {
        ui.ctx().set_cursor_icon(if held {
            CursorIcon::Grabbing
        } else {
            CursorIcon::Grab
        });
    }
    let (down, fine) = ui.input(|input| {
        // The way to the body is none of the body's.
        let held = !input.pointer.any_pressed();
        let down = if held { input.pointer.delta().y } else { 0.0 };
        (down, input.modifiers.shift)
    });
    if held && down != 0.0 {
        let share = if fine { 0.1 } else { 1.0 };
        let wanted = state.target - share * per_point * f64::from(down);
        actions.push(Action::SetTarget(wanted));
    }
}

/// Draws the grip inside `frame`, in the body above the place `at` of its surface.
pub fn grip(ui: &Ui, state: &ViewState, frame: Rect, at: Pos2) -> Rect {
    let inside = frame.shrink2(HALF + vec2(4.0, 4.0));
    let middle = inside.clamp(at - vec2(0.0, HALF.y + 5.0));
    let rect = Rect::from_center_size(middle, 2.0 * HALF);
    let painter = ui.painter().with_clip_rect(frame);
    let palette = theme::palette(ui);
    if state.messages.hint == Some(Hint::Grab) {
        let time = ui.input(|input| input.time);
        let wide = 0.5 - 0.5 * (TAU * time / PULSE).cos();
        let ring = rect.expand(1.0 + 6.0 * wide as f32);
        painter.rect_stroke(
            ring,
            ring.height() / 2.0,
            Stroke::new(2.0, palette.now.gamma_multiply(1.0 - 0.7 * wide as f32)),
            StrokeKind::Inside,
        );
        ui.ctx().request_repaint_after(PICTURE);
    }
    let (fill, ink) = (ui.visuals().window_fill, palette.now);
    painter.rect(
        rect,
        HALF.y,
        fill,
        Stroke::new(1.2, ink),
        StrokeKind::Inside,
    );
    for (x, way) in [(-8.0, -1.0), (8.0, 1.0)] {
        let tip = middle + vec2(x, 4.5 * way);
        let arrow = vec![
            tip,
            tip + vec2(-5.0, -8.0 * way),
            tip + vec2(5.0, -8.0 * way),
        ];
        painter.add(Shape::convex_polygon(arrow, ink, Stroke::NONE));
    }
    rect
}

/// The hint in a bubble with an arrow at the `grip`, above it or, where `frame` has no room there,
/// below it; its place, if there is one.
pub fn bubble(ui: &Ui, state: &ViewState, frame: Rect, grip: Rect) -> Option<Rect> {
    let words = state.hint()?;
    let ink = theme::palette(ui).now;
    let galley = ui.painter().layout(
        words.clone(),
        FontId::proportional(WORDS),
        ink,
        frame.width() - 24.0,
    );
    let size = galley.size() + vec2(16.0, 7.0);
    let strip = frame.shrink(3.0);
    let left = (grip.center().x - size.x / 2.0).min(strip.right() - size.x);
    let above = grip.top() - ARROW - size.y;
    let (top, tip) = if above >= strip.top() {
        (above, grip.center_top())
    } else {
        (grip.bottom() + ARROW, grip.center_bottom())
    };
    let area = Rect::from_min_size(pos2(left.max(strip.left()), top), size);
    let painter = ui.painter();
    let (fill, edge) = (ui.visuals().window_fill, Stroke::new(1.2, ink));
    arrow(ui, area, tip, edge.color);
    painter.rect(area, 7.0, fill, edge, StrokeKind::Inside);
    painter.galley(
        area.center() - galley.size() / 2.0,
        galley,
        Color32::PLACEHOLDER,
    );
    let response = ui.interact(area, Id::unique("hint"), Sense::hover());
    described(&response, &words);
    Some(area)
}

/// The arrow of a bubble: from the nearest place of its edge to the tip.
fn arrow(ui: &Ui, area: Rect, tip: Pos2, colour: Color32) {
    let foot = area.shrink(9.0).clamp(tip);
    let across = (tip - foot).normalized().rot90() * 7.0;
    let corners = vec![tip, foot + across, foot - across];
    ui.painter()
        .add(Shape::convex_polygon(corners, colour, Stroke::NONE));
}
