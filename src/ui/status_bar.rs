//! What is shown is an equilibrium, and stable, or is labelled otherwise: this is the label.
//! Failures stand above it with their remedy.

use super::action::Action;
use super::theme;
use super::view_state::ViewState;
use crate::follow::record::StateRecord;
use crate::lessons::Hidden;
use crate::physics::grid::Grid;
use crate::physics::parameter::Dimension;
use crate::scene::part::{Part, Strategy};
use crate::solver::Stop;
use crate::study::plan::promise;
use crate::worker::protocol::{ModelChoice, Ready};
use egui::{RichText, Ui};

/// The bar; a failure takes a line of its own.
pub fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let palette = theme::palette(ui);
    if let Some(failure) = &state.messages.failure {
        ui.horizontal_wrapped(|ui| {
            ui.label(RichText::new("⚠").color(palette.warn).strong());
            ui.label(RichText::new(&failure.message).color(palette.warn).strong());
            ui.label(&failure.remedy);
            if ui.small_button("Dismiss").clicked() {
                actions.push(Action::DismissFailure);
            }
            if state.history.can_undo() && ui.small_button("Undo edit").clicked() {
                actions.push(Action::Undo);
            }
        });
    } else if let Some(notice) = &state.messages.notice {
        ui.horizontal_wrapped(|ui| {
            ui.label(RichText::new("✔").color(palette.good));
            ui.label(notice);
        });
    }
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 5.0;
        let shown = state
            .run
            .shown
            .as_ref()
            .filter(|_| state.jumping().is_none());
        let shown = shown.and_then(|frame| frame.state.as_ref());
        match shown.or(state.run.state.as_ref()) {
            Some(now) => facts(ui, state, now),
            None => {
                ui.label(RichText::new("waiting for the solver").weak());
            }
        }
        model(ui, state);
        let live = state.plots.live.as_ref();
        if let Some(live) = live.filter(|_| !state.hides(Hidden::Forecast)) {
            part(ui, "");
            let colour = theme::palette(ui).live;
            ui.label(RichText::new(live.words(&state.model)).color(colour));
        }
    });
}

fn facts(ui: &mut Ui, state: &ViewState, now: &StateRecord) {
    let palette = theme::palette(ui);
    let word = state
        .shown_word()
        .map_or_else(String::new, |word| word.to_owned() + " ");
    let pattern = ui.label(RichText::new(word + now.pattern.word()).strong());
    // Only read aloud: the last jump, not more often than the ear can follow.
    ui.ctx().accesskit_node_builder(pattern.id, |node| {
        node.set_live(egui::accesskit::Live::Polite);
        node.set_description(state.messages.announced.clone());
    });
    let (text, colour) = match state.jumping() {
        Some(frame) => {
            let u0 = frame.mean_displacement / state.rho();
            let unit = state.model.unit(Dimension::Length);
            let what = if state.is_pressed() {
                "pressed"
            } else {
                "jumping"
            };
            (
                format!("{what} at u₀ = {}, no equilibrium", unit.say(u0, 3, "ρ")),
                palette.jump,
            )
        }
        None => stability(now, &palette),
    };
    part(ui, "");
    ui.label(RichText::new(text).color(colour).strong())
        .on_hover_text(format!(
            "stiffness_min: smallest eigenvalue of the energy's Hessian per area, ± {:.1e} E*/L; \
         residual {:.1e} σₘₐₓ",
            now.stiffness_error, now.residual
        ));
    part(ui, &now.part.to_string());
    part(ui, state.method.title());
    part(ui, "");
    let plural = if now.iterations == 1 { "" } else { "s" };
    ui.label(format!(
        "{} iteration{plural}, {:.1} ms",
        now.iterations, now.milliseconds
    ))
    .on_hover_text(format!(
        "for the last increment: {} Fourier transforms",
        now.transforms
    ));
}

/// A dot and a word.
fn part(ui: &mut Ui, text: &str) {
    ui.label(RichText::new("·").weak());
    if !text.is_empty() {
        ui.label(text);
    }
}

/// The honest word on stability.
fn stability(now: &StateRecord, palette: &theme::Palette) -> (String, egui::Color32) {
    match now.stop {
        Stop::Stable => (
            format!("stable, stiffness_min {:.3} E*/L", now.stiffness_min),
            palette.good,
        ),
        Stop::Unstable => (
            format!("{}, stiffness_min {:.3} E*/L", now.stop, now.stiffness_min),
            palette.warn,
        ),
        _ => (
            format!("{}, residual {:.1e}", now.stop, now.residual),
            palette.warn,
        ),
    }
}

/// The model in use and the error it is expected to have; the plan's sentence on hover.
fn model(ui: &mut Ui, state: &ViewState) {
    let grid = &state.model.grid;
    let Some(ready) = &state.run.ready else {
        return part(ui, &format!("mesh {} × {}", grid.nx, grid.ny));
    };
    part(ui, "");
    ui.label(model_words(&ready.choice, grid))
        .on_hover_text(model_sentence(ready));
}

/// In a few words: "quarter of 64 × 64, expected error 0.005 %".
pub fn model_words(choice: &ModelChoice, grid: &Grid) -> String {
    let place = match (choice.part.is_even(), grid.is_line()) {
        (false, true) => format!("line of {}", grid.nx),
        (true, true) => format!("half a line of {}", grid.nx),
        (false, false) => format!("whole cell {} × {}", grid.nx, grid.ny),
        (true, false) => format!("quarter of {} × {}", grid.nx, grid.ny),
    };
    format!("{place}, {}", promise(Some(choice.plan.predicted_error)))
}

fn model_sentence(ready: &Ready) -> String {
    let ModelChoice {
        plan,
        part,
        because,
    } = &ready.choice;
    let mut words = format!("Plan: {}.", plan.words);
    if let Some(because) = because {
        words += &format!(" The walk runs on the whole cell: {because}.");
    } else if matches!(plan.strategy, Strategy::Atlas) && *part == Part::Quarter {
        words += " Here the walk solves every state that is shown on the quarter; the atlas says \
            what is ahead and draws the live loop.";
    }
    format!("{words} Mesh: {}.", ready.model.reason)
}
