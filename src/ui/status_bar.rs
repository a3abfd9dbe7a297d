//! What is shown is an equilibrium, and stable, or is labelled otherwise: this is the label. Failures stand above it with their remedy.

use super::action::Action;
use super::theme;
use super::view_state::ViewState;
use crate::experiment::record::StateRecord;
use crate::solver::Stop;
use egui::{RichText, Ui};

/// The bar; a failure takes a line of its own.
pub fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let palette = theme::palette(ui.visuals().dark_mode);
    if let Some(failure) = &state.failure {
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
    } else if let Some(notice) = &state.notice {
        ui.horizontal_wrapped(|ui| {
            ui.label(RichText::new("✔").color(palette.good));
            ui.label(notice);
        });
    }
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 5.0;
        match &state.state {
            Some(now) => facts(ui, state, now),
            None => {
                ui.label(RichText::new("waiting for the solver").weak());
            }
        }
        part(ui, &mesh(state));
        if let Some(live) = &state.live {
            part(ui, "");
            let colour = theme::palette(ui.visuals().dark_mode).live;
            ui.label(RichText::new(live.words()).color(colour));
        }
    });
}

fn facts(ui: &mut Ui, state: &ViewState, now: &StateRecord) {
    let palette = theme::palette(ui.visuals().dark_mode);
    let relaxing = state.frame.as_ref().is_some_and(|frame| frame.relaxing);
    ui.label(RichText::new(now.pattern.word()).strong());
    let (text, colour) = if relaxing { ("jumping, no equilibrium".to_owned(), palette.jump) } else { stability(now, &palette) };
    part(ui, "");
    ui.label(RichText::new(text).color(colour).strong()).on_hover_text(format!(
        "stiffness_min: smallest eigenvalue of the energy's Hessian per area, ± {:.1e} E*/L; residual {:.1e} σₘₐₓ",
        now.stiffness_error, now.residual
    ));
    part(ui, now.model);
    part(ui, state.method.title());
    part(ui, &format!("{} iterations", now.iterations));
    part(ui, &format!("{} transforms", now.transforms));
    part(ui, &format!("{:.1} ms", now.milliseconds));
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
        Stop::Stable => (format!("stable, stiffness_min {:.3} E*/L", now.stiffness_min), palette.good),
        Stop::Unstable => (format!("{}, stiffness_min {:.3} E*/L", now.stop, now.stiffness_min), palette.warn),
        _ => (format!("{}, residual {:.1e}", now.stop, now.residual), palette.warn),
    }
}

fn mesh(state: &ViewState) -> String {
    let grid = &state.model.grid;
    let reason = state.ready.as_ref().map_or(state.model.reason.as_str(), |ready| ready.model.reason.as_str());
    format!("mesh {} × {} ({reason})", grid.nx, grid.ny)
}
