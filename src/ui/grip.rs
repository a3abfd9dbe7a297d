//! The body as its own handle: dragged up and down it moves what is driven. Until first used its
//! grip pulses, and a bubble at it says what to do.
//!
//! Alt and a drag on the map press the surface: down a bump towards the ground, up a dimple off it;
//! the wheel changes how wide. Let go, it relaxes, back or into another state.

use super::action::{Action, ViewOptions};
use super::gap_picture::GapPicture;
use super::theme;
use super::view_state::{Hint, ViewState};
use super::widgets::described;
use crate::follow::walk::Push;
use crate::worker::protocol::Play;
use egui::{
    Color32, CursorIcon, Event, FontId, Id, Pos2, Rect, Response, Sense, Shape, Slider, Stroke,
    StrokeKind, Ui, pos2, vec2,
};
use std::f64::consts::TAU;
use std::ops::RangeInclusive;
use std::time::Duration;

/// Half of width and height of the grip (points).
const HALF: egui::Vec2 = vec2(21.0, 8.0);
/// Seconds of one pulse, and between two pictures of it.
const PULSE: f64 = 1.6;
const PICTURE: Duration = Duration::from_millis(40);
/// Length of the bubble's arrow below a grip (points).
const ARROW: f32 = 12.0;
/// Between a grip and the bubble beside it.
const NEAR: f32 = 6.0;
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

/// The hint in a bubble with an arrow at the `grip`, above it or, where `frame` has no room there, beside
/// it in two lines, clear of the words that are `written`, or below it; its place, if there is one.
pub fn bubble(
    ui: &Ui,
    state: &ViewState,
    frame: Rect,
    grip: Rect,
    written: &[Rect],
) -> Option<Rect> {
    let words = state.hint()?;
    let ink = theme::palette(ui).now;
    let font = FontId::proportional(WORDS);
    let laid = |width: f32| {
        let galley = ui.painter().layout(words.clone(), font.clone(), ink, width);
        (galley.size() + vec2(16.0, 7.0), galley)
    };
    let strip = frame.shrink(3.0);
    let whole = laid(frame.width() - 24.0);
    let folded = laid(0.5 * whole.0.x + NEAR);
    let over = |top: f32| {
        let left = (grip.center().x - whole.0.x / 2.0).min(strip.right() - whole.0.x);
        Rect::from_min_size(pos2(left.max(strip.left()), top), whole.0)
    };
    let beside = |left: f32| {
        let top = (grip.center().y - folded.0.y / 2.0).min(strip.bottom() - folded.0.y);
        Rect::from_min_size(pos2(left, top.max(strip.top())), folded.0)
    };
    let above = over(grip.top() - ARROW - whole.0.y);
    let clear = |area: &Rect| {
        strip.contains_rect(*area) && !written.iter().any(|words| words.intersects(*area))
    };
    let sides = [
        (beside(grip.left() - NEAR - folded.0.x), grip.left_center()),
        (beside(grip.right() + NEAR), grip.right_center()),
    ];
    let side = sides.into_iter().find(|(area, _)| clear(area));
    let (area, tip, galley) = if above.top() >= strip.top() {
        (above, grip.center_top(), whole.1)
    } else if let Some((area, tip)) = side {
        (area, tip, folded.1)
    } else {
        let below = over(grip.bottom() + ARROW);
        (below, grip.center_bottom(), whole.1)
    };
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

/// Widths of a push, in shares of the cell, and how much one notch of the wheel changes it.
const WIDTHS: RangeInclusive<f64> = 0.02..=0.5;
const NOTCH: f64 = 1.12;
/// Depth of the push of a command (ranges).
const DEPTH: f64 = 1.5;

/// True while drags on the map press the surface.
pub fn presses(ui: &Ui, state: &ViewState) -> bool {
    state.is_pressed() || ui.input(|input| input.modifiers.alt) && state.can_press()
}

/// Presses, where the map is drawn in `band`; one point of the screen is so much depth (length).
pub fn press(
    ui: &Ui,
    state: &ViewState,
    (response, band): (&Response, Rect),
    picture: &GapPicture,
    per_point: f64,
    actions: &mut Vec<Action>,
) {
    if !response.hovered() && !state.is_pressed() {
        return;
    }
    ui.ctx().set_cursor_icon(CursorIcon::Crosshair);
    let (origin, began, held) = ui.input(|input| {
        let pointer = &input.pointer;
        (
            pointer.press_origin(),
            pointer.any_pressed(),
            pointer.any_down(),
        )
    });
    wheel(ui, state, actions);
    let width = state.view.push_width * state.model.grid.length;
    let at = response.interact_pointer_pos().or(response.hover_pos());
    if let (Some(at), Some(origin)) = (at, origin)
        && response.is_pointer_button_down_on()
        && (began || state.is_pressed())
    {
        let push = Push {
            at: picture.place_of(band, origin, &state.model.grid),
            width,
            depth: f64::from(at.y - origin.y) * per_point,
        };
        if state.run.play != Play::Pressed(push) {
            actions.push(Action::Press(push));
        }
    }
    if state.is_pressed() && !held {
        actions.push(Action::LetGo);
    }
    ring(ui, state, picture, band, origin.filter(|_| held).or(at));
}

/// The wheel changes the width.
fn wheel(ui: &Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let turned: f32 = ui.input(|input| {
        let turn = |event: &Event| match event {
            Event::MouseWheel { delta, .. } => delta.y.clamp(-1.0, 1.0),
            _ => 0.0,
        };
        input.events.iter().map(turn).sum()
    });
    if turned != 0.0 {
        let width = state.view.push_width * NOTCH.powf(f64::from(turned));
        set(state, width, actions);
    }
}

fn set(state: &ViewState, width: f64, actions: &mut Vec<Action>) {
    let push_width = width.clamp(*WIDTHS.start(), *WIDTHS.end());
    actions.push(Action::SetView(ViewOptions {
        push_width,
        ..state.view
    }));
}

/// How wide the push is.
fn ring(ui: &Ui, state: &ViewState, picture: &GapPicture, band: Rect, at: Option<egui::Pos2>) {
    let Some(at) = at else { return };
    let columns = picture.gap.ncols() as f32;
    let [left, right] =
        [0.0, state.view.push_width as f32 * columns].map(|x| picture.to_screen(band, [x, 0.0]).x);
    let painter = ui.painter().with_clip_rect(band);
    let colour = theme::over_maps().jump;
    for (width, ink) in [(4.0, Color32::from_black_alpha(120)), (2.0, colour)] {
        painter.circle_stroke(at, right - left, Stroke::new(width, ink));
    }
}

/// In place of the map's options: what can be done, and the width.
pub fn press_options(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let mut width = state.view.push_width;
    let slider = Slider::new(&mut width, WIDTHS)
        .logarithmic(true)
        .show_value(false);
    ui.spacing_mut().slider_width = 80.0;
    let slider = ui.add(slider);
    slider.widget_info(|| egui::WidgetInfo::slider(true, width, "Width of the push"));
    if slider.changed() {
        set(state, width, actions);
    }
    let words = "Drag down: a bump. Up: a dimple. Wheel: width.";
    ui.add(egui::Label::new(words).truncate());
}

/// A push into the middle of the cell that is let go at once, for the palette of commands; `sign` 1
/// towards the ground.
pub fn press_command(state: &ViewState, sign: f64) -> Vec<Action> {
    let grid = &state.model.grid;
    let push = Push {
        at: [0.5 * grid.length; 2],
        width: state.view.push_width * grid.length,
        depth: sign * DEPTH * state.rho(),
    };
    vec![Action::Press(push), Action::LetGo]
}

/// The word over the map while the surface is no equilibrium.
pub fn press_word(state: &ViewState) -> Option<&'static str> {
    state.jumping().map(|_| match state.run.play {
        Play::Pressed(_) => "pressed, no equilibrium",
        Play::LetGo(_) => "let go, no equilibrium",
        _ => "jumping, no equilibrium",
    })
}
