//! What is shown is an equilibrium, and stable, or is labelled otherwise: this is the label, one
//! short line. What went wrong stands above it, over the panels, until it was read.

use super::action::Action;
use super::grip;
use super::headline::{exact_to, residual, stability};
use super::theme::{self, Palette};
use super::view_state::ViewState;
use super::words::explain;
use crate::follow::record::StateRecord;
use crate::lessons::Hidden;
use crate::physics::grid::Grid;
use crate::scene::part::{Part, Strategy};
use crate::scene::units::fixed;
use crate::solver::Stop;
use crate::study::plan::promise;
use crate::worker::protocol::{ModelChoice, Ready};
use egui::{Align, Align2, Area, Color32, Frame, Id, Label, Layout, Order, RichText, Ui, vec2};
use std::time::Duration;

/// Seconds for which a notice stays.
const NOTICE: f64 = 8.0;
/// Width of the card behind the chip (points).
const CARD: f32 = 380.0;

/// The bar.
pub fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        ui.set_min_height(26.0);
        ui.spacing_mut().item_spacing.x = 6.0;
        let shown = state.run.shown.as_ref();
        let shown = shown.filter(|_| state.jumping().is_none());
        let shown = shown.and_then(|frame| frame.state.as_ref());
        match shown.or(state.run.state.as_ref()) {
            Some(now) => facts(ui, state, now),
            None => {
                ui.label(RichText::new("waiting").weak());
            }
        }
        let chip = ui.menu_button(chip(state), |ui| card(ui, state));
        chip.response.on_hover_text("how it was computed");
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            notice(ui, state, actions);
        });
    });
    failure(ui, state, actions);
}

/// What went right, for some seconds.
fn notice(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let (id, now) = (Id::unique("notice"), ui.input(|input| input.time));
    let Some(notice) = &state.messages.notice else {
        return ui.data_mut(|data| data.remove::<(String, f64)>(id));
    };
    let known = ui.data(|data| data.get_temp::<(String, f64)>(id));
    let since = known
        .filter(|(words, _)| words == notice)
        .map_or(now, |(_, since)| since);
    ui.data_mut(|data| data.insert_temp(id, (notice.clone(), since)));
    // What is under way stays until it is done.
    let left = if notice.ends_with('…') {
        NOTICE
    } else {
        NOTICE - (now - since)
    };
    if left <= 0.0 {
        actions.push(Action::DropNotice);
    } else {
        ui.ctx()
            .request_repaint_after(Duration::from_secs_f64(left));
    }
    let words = RichText::new(format!("✔ {notice}")).color(theme::palette(ui).good);
    ui.add(Label::new(words).truncate()).on_hover_text(notice);
}

/// What went wrong and what to do about it, over the foot of the panels: nothing moves for it.
fn failure(ui: &Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let Some(failure) = &state.messages.failure else {
        return;
    };
    let warn = theme::palette(ui).warn;
    let screen = ui.ctx().content_rect();
    let area = Area::new(Id::unique("failure"))
        .order(Order::Middle)
        .anchor(Align2::CENTER_BOTTOM, vec2(0.0, -44.0));
    area.show(ui.ctx(), |ui| {
        ui.set_max_width((screen.width() - 40.0).min(760.0));
        let frame = Frame::popup(ui.style()).stroke(egui::Stroke::new(1.5, warn));
        frame.show(ui, |ui| {
            ui.label(
                RichText::new(format!("⚠ {}", failure.message))
                    .color(warn)
                    .strong(),
            );
            ui.horizontal_wrapped(|ui| {
                ui.label(&failure.remedy);
                if ui.button("Dismiss").clicked() {
                    actions.push(Action::DismissFailure);
                }
                if state.history.can_undo() && ui.button("Undo edit").clicked() {
                    actions.push(Action::Undo);
                }
            });
        });
    });
}

fn facts(ui: &mut Ui, state: &ViewState, now: &StateRecord) {
    let palette = theme::palette(ui);
    let word = state
        .shown_word()
        .map_or_else(String::new, |word| word.to_owned() + " ");
    let pattern = ui.label(RichText::new(word + now.pattern.words()).strong());
    let pattern = explain(pattern, now.pattern.words());
    // Only read aloud: the last jump, not more often than the ear can follow.
    ui.ctx().accesskit_node_builder(pattern.id, |node| {
        node.set_live(egui::accesskit::Live::Polite);
        node.set_description(state.messages.announced.clone());
    });
    let (words, colour) = match state.jumping() {
        Some(_) => (grip::press_word(state).unwrap_or_default(), palette.jump),
        None => (stability(now), stable_colour(now, &palette)),
    };
    ui.label(RichText::new("·").weak());
    explain(ui.label(RichText::new(words).color(colour).strong()), words);
}

fn stable_colour(now: &StateRecord, palette: &Palette) -> Color32 {
    if now.stop == Stop::Stable {
        palette.good
    } else {
        palette.warn
    }
}

/// How exact what is shown is, in few words: that of the plan belongs to stable equilibria only.
fn chip(state: &ViewState) -> String {
    match &state.run.state {
        None => "not computed yet".to_owned(),
        Some(now) if now.stop == Stop::Stable && state.jumping().is_none() => {
            // The headline's number, once there is one.
            let predicted = state.predicted_error();
            let closed = state.run.closed_loop.as_ref();
            let stated = closed.and_then(|closed| closed.summary.ledger.stated_error(predicted));
            let error = stated.unwrap_or(predicted);
            exact_to(Some(error))
        }
        Some(_) => "no equilibrium".to_owned(),
    }
}

/// Everything about the present state, line by line.
fn card(ui: &mut Ui, state: &ViewState) {
    ui.set_width(CARD.min(ui.ctx().content_rect().width() - 40.0));
    ui.with_layout(Layout::top_down(Align::LEFT), |ui| {
        for line in lines(state) {
            ui.add(Label::new(line).wrap());
        }
        let live = state.plots.live.as_ref();
        if let Some(live) = live.filter(|_| !state.hides(Hidden::Forecast)) {
            let colour = theme::palette(ui).live;
            ui.add(Label::new(RichText::new(live.words(&state.model)).color(colour)).wrap());
        }
    });
}

fn lines(state: &ViewState) -> Vec<String> {
    let mut lines = Vec::new();
    if let Some(now) = &state.run.state {
        let plural = if now.iterations == 1 { "" } else { "s" };
        lines = vec![
            format!(
                "{}, stiffness_min {} ± {:.1e} E*/L: the smallest eigenvalue of the energy's \
                 Hessian per area",
                stability(now),
                fixed(now.stiffness_min, 3),
                now.stiffness_error
            ),
            residual(now),
            format!("{}, {}", now.part, state.method.title()),
            format!(
                "last increment: {} iteration{plural}, {} transforms, {:.1} ms",
                now.iterations, now.transforms, now.milliseconds
            ),
        ];
    }
    let grid = &state.model.grid;
    match &state.run.ready {
        None => lines.push(format!("mesh {} × {}", grid.nx, grid.ny)),
        Some(ready) => {
            lines.push(model_words(&ready.choice, grid));
            lines.push(model_sentence(ready));
        }
    }
    lines
}

/// In a few words: "quarter of 64 × 64, expected error 0.005 %".
fn model_words(choice: &ModelChoice, grid: &Grid) -> String {
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
    let mut words = format!("Plan: {}.", plan.words());
    if let Some(because) = because {
        words += &format!(" The walk runs on the whole cell: {because}.");
    } else if matches!(plan.strategy, Strategy::Atlas) && *part == Part::Quarter {
        words += " Here the walk solves every state that is shown on the quarter; the atlas says \
            what is ahead and draws the live loop.";
    }
    format!("{words} Mesh: {}.", ready.model.reason)
}
