//! What is said of the state: the two headlines (the pattern, whether it is stable and where, over the
//! map; what is lost, over the plot), and the bar at the foot. What is shown is an equilibrium, and
//! stable, or is labelled otherwise: the bar is this label, one short line. What went wrong stands
//! above it, over the panels, until it was read.

use super::action::{Action, ViewOptions};
use super::grip;
use super::theme::{self, Palette};
use super::view_state::ViewState;
use super::widgets::{Asks, at_right, checkbox, menu, named, radio_value};
use super::words::explain;
use crate::follow::record::{JumpRecord, StateRecord};
use crate::lessons::Hidden;
use crate::physics::indenter::Indenter;
use crate::physics::mesh::Grid;
use crate::physics::parameter::Dimension;
use crate::plot::style::Colours;
use crate::scene::parameter::fixed;
use crate::scene::{Part, Strategy};
use crate::solver::Stop;
use crate::study::plan::{ModelChoice, promise, promise_as};
use crate::worker::protocol::Ready;
use egui::{
    Align, Align2, Area, Color32, FontId, Frame, Id, Label, Layout, Order, Response, RichText, Ui,
    vec2,
};
use std::time::Duration;

/// Sizes of the two, and the least to which they shrink where the column is narrow.
const SURFACE: f32 = 22.0;
const LOSS: f32 = 28.0;
const LEAST: f32 = 16.0;
/// Width of what stands at the right of each (points).
const MENU: f32 = 40.0;
const FIT: f32 = 60.0;

/// A size of letters between two at which the words have room.
fn fitting(ui: &Ui, words: &str, [least, most]: [f32; 2], room: f32) -> f32 {
    let (words, font) = (words.to_owned(), FontId::proportional(most));
    let galley = ui.painter().layout_no_wrap(words, font, Color32::WHITE);
    (most * room / galley.size().x.max(1.0))
        .clamp(least, most)
        .floor()
}

/// A line as large as its width allows; what does not fit at the least size is cut.
fn line(ui: &mut Ui, words: &str, size: f32, room: f32, colour: Color32) -> Response {
    let size = fitting(ui, words, [LEAST, size], room);
    let words = RichText::new(words).size(size).strong().color(colour);
    ui.add(Label::new(words).truncate())
}

/// Over the map, with the options of the map at its right.
pub fn surface(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let (words, colour) =
        surface_words(state, &theme::palette(ui), ui.visuals().strong_text_color());
    let size = vec2(ui.available_width(), SURFACE + 8.0);
    ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
        ui.set_min_height(SURFACE + 8.0);
        let presses = grip::presses(ui, state);
        let room = if presses { 0.4 * size.x } else { size.x - MENU };
        explain(line(ui, &words, SURFACE, room, colour), "Surface");
        at_right(ui, |ui| {
            if presses {
                return grip::press_options(ui, state, actions);
            }
            let what = ["Map options", "how the map is drawn"];
            menu(ui, "⚙", what, |ui| options(ui, state, actions));
        });
    });
}

fn options(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let mut view: ViewOptions = state.view;
    checkbox(ui, &mut view.smooth, "Smooth");
    if state.model.indenter == Indenter::Flat {
        checkbox(ui, &mut view.centred, "Centre the pattern");
    }
    checkbox(ui, &mut view.soft_mode, "Soft mode");
    ui.separator();
    for (colours, word) in Colours::ALL {
        let words = format!("Colours: {word}");
        radio_value(ui, &mut view.colours, colours, words);
    }
    if view != state.view {
        actions.push(Action::SetView(view));
    }
}

/// What map and profile show, in one line.
fn surface_words(state: &ViewState, palette: &Palette, plain: Color32) -> (String, Color32) {
    let length = state.model.unit(Dimension::Length);
    let at = |u0: f64| format!("u₀ = {}", length.say(u0 / state.rho(), 4, "ρ"));
    if let Some(frame) = &state.run.replayed {
        return (
            format!("Replay, {}", at(frame.mean_displacement)),
            palette.jump,
        );
    }
    let old = state.run.shown.as_ref();
    if let Some(frame) = old.or_else(|| state.jumping()) {
        let words = match &frame.state {
            Some(stored) => {
                let word = state.shown_word().unwrap_or("stored");
                format!("{}: {}", capital(word), equilibrium(stored))
            }
            None if frame.relaxing => capital(grip::press_word(state).unwrap_or("no equilibrium")),
            None => "Of a branch".to_owned(),
        };
        let colour = if frame.relaxing { palette.jump } else { plain };
        return (format!("{words}, {}", at(frame.mean_displacement)), colour);
    }
    match &state.run.state {
        None => {
            let told = state.told();
            let at = told.say(state.run.actual, 4);
            (format!("Waiting, {} = {at}", told.symbol), plain)
        }
        Some(now) => {
            let words = format!(
                "{}, {}",
                capital(&equilibrium(now)),
                at(now.mean_displacement)
            );
            let stable = now.stop == Stop::Stable;
            (words, if stable { plain } else { palette.warn })
        }
    }
}

/// "ridge, stable".
fn equilibrium(state: &StateRecord) -> String {
    format!("{}, {}", state.pattern.words(), stability(state))
}

/// The honest word on stability.
pub fn stability(state: &StateRecord) -> &'static str {
    match state.stop {
        Stop::Stable => "stable",
        Stop::Unstable => "unstable",
        Stop::NotConverged => "not converged",
        Stop::ReadOff => "read off",
        Stop::Cancelled => "cancelled",
    }
}

/// How far from balance a state is; a closed form is not at all.
pub fn residual(state: &StateRecord) -> String {
    if state.residual == 0.0 {
        "residual 0".to_owned()
    } else {
        format!("residual {:.1e} σₘₐₓ", state.residual)
    }
}

/// With a capital letter.
pub fn capital(words: &str) -> String {
    let mut letters = words.chars();
    let first = letters.next().into_iter().flat_map(char::to_uppercase);
    first.chain(letters).collect()
}

/// What is promised of a number, in the fewest words; `error` is relative.
pub fn exact_to(error: Option<f64>) -> String {
    promise_as("exact to", error)
}

/// What is lost, in words.
#[derive(Clone, Debug, PartialEq)]
struct Lost {
    /// Large.
    headline: String,
    /// Below it: of what, and how exactly.
    detail: String,
    /// What speaks against it.
    doubt: Option<String>,
}

/// Over the plot, with the fit of its axes at its right; below it a line on what is lost.
pub fn loss(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let palette = theme::palette(ui);
    let lost = lost(state);
    let size = vec2(ui.available_width(), LOSS + 8.0);
    ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
        ui.set_min_height(LOSS + 8.0);
        let colour = ui.visuals().strong_text_color();
        explain(line(ui, &lost.headline, LOSS, size.x - FIT, colour), "Loss");
        at_right(ui, |ui| {
            fit(ui, state, actions, &palette);
        });
    });
    let (words, colour) = match &lost.doubt {
        Some(doubt) => (format!("⚠ {doubt}"), palette.warn),
        None => (lost.detail, ui.visuals().text_color()),
    };
    let letters = [theme::LEAST, theme::BODY];
    let letters = fitting(ui, &words, letters, ui.available_width());
    let text = RichText::new(&words).size(letters).color(colour);
    ui.add(Label::new(text).truncate()).on_hover_text(words);
}

fn fit(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>, palette: &Palette) {
    if state.plots.fit.is_some() {
        let button = named(ui.button("Scene"), "Scene axes");
        button
            .on_hover_text("the axes of the scene again")
            .asks(actions, Action::FitScene);
        return;
    }
    let leaves = state.data_leave_view();
    let (text, hover) = if leaves {
        let text = RichText::new("Fit").color(palette.warn).strong();
        (text, "Data lie outside the axes")
    } else {
        (RichText::new("Fit"), "Fit the axes to the data")
    };
    ui.button(text)
        .on_hover_text(hover)
        .asks(actions, Action::FitData);
}

/// What a walked loop lost, or the live one will, or the jumps so far.
fn lost(state: &ViewState) -> Lost {
    let plain = |headline: String, detail: String| Lost {
        headline,
        detail,
        doubt: None,
    };
    if let Some(closed) = &state.run.closed_loop {
        let ledger = &closed.summary.ledger;
        let contested = contested(&state.run.record.jumps);
        let detail = format!(
            "in one loop, {}",
            exact_to(ledger.stated_error(state.predicted_error()))
        );
        let headline = match (ledger.dissipated_energy(), &ledger.open) {
            (Some(loss), _) if contested.is_some() => format!("{} lost", either(state, loss)),
            (Some(loss), _) => format!("{} lost", energy(state, loss)),
            (None, Some(_)) => "Loop not closed".to_owned(),
            (None, None) => "Loss not known".to_owned(),
        };
        let open = ledger
            .open
            .as_ref()
            .map(|open| format!("{}; {}", open.reason, open.remedy));
        return Lost {
            headline,
            detail,
            doubt: open.or_else(|| ledger.warning()).or(contested),
        };
    }
    let live = state.plots.live.as_ref();
    let live = live.filter(|_| !state.hides(Hidden::Forecast));
    let fresh = live.is_some_and(|live| live.run == state.run.id);
    if let Some(Ok(live)) = live.map(|live| &live.state.found) {
        let contested = contested(&live.jumps);
        let loss = live.dissipated_energy;
        let told = match contested {
            Some(_) => either(state, loss),
            None => energy(state, loss),
        };
        let detail = if fresh {
            let exact = exact_to(Some(live.predicted_error));
            format!("live loop, {} jumps, {exact}", live.jumps.len())
        } else {
            "live loop before the edit; the new one is computed …".to_owned()
        };
        return Lost {
            doubt: contested,
            ..plain(format!("{told} a loop"), detail)
        };
    }
    let record = &state.run.record;
    if record.jumps.is_empty() {
        let detail = "play a loop to see what is lost";
        return plain("Nothing lost yet".to_owned(), detail.to_owned());
    }
    let freed = energy(state, record.released_energy_sum());
    plain(
        format!("{freed} lost so far"),
        format!("in {}", record.tally()),
    )
}

/// Where a surface may land that has several places to land.
fn contested(jumps: &[JumpRecord]) -> Option<String> {
    jumps.iter().find_map(JumpRecord::contested_words)
}

/// An energy per area (gamma) as it is told.
pub fn energy(state: &ViewState, energy: f64) -> String {
    let unit = state.model.unit(Dimension::SurfaceEnergy);
    unit.say(energy, 4, "γ")
}

/// The `loss` of a loop, and what it would lose by its other landing, as the live loop knows it:
/// "0.1175 or 0.1292 γ".
fn either(state: &ViewState, loss: f64) -> String {
    let unit = state.model.unit(Dimension::SurfaceEnergy);
    let other = other_loss(state, loss);
    let other =
        other.map(|other| format!("{} or ", unit.number(loss, 4)) + &unit.say(other, 4, "γ"));
    other.unwrap_or_else(|| unit.say(loss, 4, "γ"))
}

/// What a loop that loses `loss` would lose by its other landing, as the live loop knows it.
fn other_loss(state: &ViewState, loss: f64) -> Option<f64> {
    let Some(Ok(live)) = state.plots.live.as_ref().map(|live| &live.state.found) else {
        return None;
    };
    let mut known: Vec<f64> = live
        .rivals
        .iter()
        .filter_map(|rival| rival.dissipated_energy)
        .collect();
    if known.is_empty() {
        return None;
    }
    // The live loop may take the other of two; of both values the farther one is not this loop's.
    known.push(live.dissipated_energy);
    known
        .into_iter()
        .max_by(|a, b| (a - loss).abs().total_cmp(&(b - loss).abs()))
}

/// Seconds for which a notice stays.
const NOTICE: f64 = 8.0;
/// Width of the card behind the chip (points).
const CARD: f32 = 380.0;

/// The bar.
pub fn bar(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
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
        at_right(ui, |ui| {
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
                ui.button("Dismiss").asks(actions, Action::DismissFailure);
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
