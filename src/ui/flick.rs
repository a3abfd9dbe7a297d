//! Alt and a drag on the map press the surface: down a bump towards the ground, up a dimple off it;
//! the wheel changes how wide. Let go, it relaxes, back or into another state.

use super::action::{Action, ViewOptions};
use super::gap_picture::GapPicture;
use super::theme;
use super::view_state::ViewState;
use crate::follow::walk::Push;
use crate::worker::protocol::Play;
use egui::{Color32, CursorIcon, Event, Rect, Response, Slider, Stroke, Ui};
use std::ops::RangeInclusive;

/// Widths of a push, in shares of the cell, and how much one notch of the wheel changes it.
const WIDTHS: RangeInclusive<f64> = 0.02..=0.5;
const NOTCH: f64 = 1.12;
/// Depth of the push of a command (ranges).
const DEPTH: f64 = 1.5;

/// True while drags on the map press the surface.
pub fn is_on(ui: &Ui, state: &ViewState) -> bool {
    state.is_pressed() || ui.input(|input| input.modifiers.alt) && state.can_press()
}

/// Presses, where the map is drawn in `band`; one point of the screen is so much depth (length).
pub fn drag(
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
    let colour = theme::palette_on(crate::plot::style::Ground::Dark).jump;
    for (width, ink) in [(4.0, Color32::from_black_alpha(120)), (2.0, colour)] {
        painter.circle_stroke(at, right - left, Stroke::new(width, ink));
    }
}

/// In place of the map's options: what can be done, and the width.
pub fn options(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
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
pub fn command(state: &ViewState, sign: f64) -> Vec<Action> {
    let grid = &state.model.grid;
    let push = Push {
        at: [0.5 * grid.length; 2],
        width: state.view.push_width * grid.length,
        depth: sign * DEPTH * state.rho(),
    };
    vec![Action::Press(push), Action::LetGo]
}

/// The word over the map while the surface is no equilibrium.
pub fn word(state: &ViewState) -> Option<&'static str> {
    state.jumping().map(|_| match state.run.play {
        Play::Pressed(_) => "pressed, no equilibrium",
        Play::LetGo(_) => "let go, no equilibrium",
        _ => "jumping, no equilibrium",
    })
}
