//! Lecture mode: map, curve and one line of words, large and on white, for a room.

use super::action::Action;
use super::gap_picture::Maps;
use super::headline::capital;
use super::layout::surface;
use super::loop_plot;
use super::view_state::ViewState;
use super::widgets::described;
use crate::scene::units::fixed;
use crate::solver::Stop;
use egui::{CentralPanel, Context, Label, Panel, RichText, Theme, Ui, Vec2, vec2};
use serde::{Deserialize, Serialize};

/// How much larger everything is at most: words of 15 points become 21, lines of 2 points 3.
const ZOOM: f32 = 1.4;
/// The size from which it is: in a smaller window there would be no room for map and curve.
const LARGE: Vec2 = vec2(880.0, 580.0);

/// How the window looked before.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Before {
    zoom: f32,
    dark: bool,
}

impl Before {
    /// Makes everything large and light; returns how it was.
    pub fn enlarge(ctx: &Context) -> Self {
        let before = Self {
            zoom: ctx.zoom_factor(),
            dark: ctx.theme() == Theme::Dark,
        };
        let share = ctx.content_rect().size() * before.zoom / LARGE;
        ctx.set_zoom_factor((ZOOM * share.min_elem()).clamp(1.0, ZOOM));
        ctx.set_theme(Theme::Light);
        before
    }

    /// Brings the look back.
    pub fn restore(self, ctx: &Context) {
        ctx.set_zoom_factor(self.zoom);
        ctx.set_theme(if self.dark { Theme::Dark } else { Theme::Light });
    }
}

/// Draws all of the window.
pub fn show(ui: &mut Ui, state: &ViewState, maps: &Maps, actions: &mut Vec<Action>) {
    Panel::bottom("words").show(ui, |ui| {
        ui.horizontal(|ui| {
            let words = words(state);
            let label = ui.add(Label::new(RichText::new(&words)).truncate());
            described(&label, &words);
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                if ui.small_button("Leave (F11)").clicked() {
                    actions.push(Action::ToggleLecture);
                }
            });
        });
    });
    let half = 0.5 * ui.available_width();
    Panel::right("lecture").exact_size(half).show(ui, |ui| {
        let height = ui.available_height() - 12.0;
        loop_plot::show(ui, state, actions, height);
    });
    CentralPanel::default().show(ui, |ui| surface(ui, state, maps, actions));
}

/// What there is to see, in one line.
fn words(state: &ViewState) -> String {
    let jumps = &state.run.record.jumps;
    if state.jumping().is_some() {
        return "It jumps.".to_owned();
    }
    let Some(now) = &state.run.state else {
        return "Waiting for the solver.".to_owned();
    };
    let stable = if now.stop == Stop::Stable {
        "stable"
    } else {
        "not stable"
    };
    let u0 = now.mean_displacement / state.rho();
    let mut words = format!(
        "{} at u₀ = {} ρ, {stable}.",
        capital(now.pattern.words()),
        fixed(u0, 2)
    );
    let closed = state.run.closed_loop.as_ref();
    let loss = closed.and_then(|closed| closed.summary.ledger.dissipated_energy());
    match (loss, jumps.last()) {
        (Some(loss), _) => words += &format!(" The loop lost {} γ.", fixed(loss, 3)),
        (None, Some(jump)) => {
            words += &format!(
                " {} set free {} γ.",
                capital(&jump.change()),
                fixed(jump.released_energy, 3)
            );
        }
        (None, None) if state.plots.guesses.is_empty() => {
            words += " Where will it snap? Click your guesses into the plot.";
        }
        (None, None) => {
            let guesses: Vec<String> = state
                .plots
                .guesses
                .iter()
                .map(|g| format!("{g:.2}"))
                .collect();
            words += &format!(" Guesses: {} ρ.", guesses.join(", "));
        }
    }
    words
}
