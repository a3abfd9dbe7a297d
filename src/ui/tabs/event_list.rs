//! The list of jumps, newest first.

use super::{Tab, Title};
use crate::follow::record::{Cause, Direction};
use crate::physics::parameter::Dimension;
use crate::ui::action::Action;
use crate::ui::theme;
use crate::ui::view_state::ViewState;
use crate::ui::widgets::{Asks, named};
use crate::ui::words::explain;
use egui::{RichText, ScrollArea, Ui};

/// Most rows that are laid out.
const ROWS: usize = 200;

/// What gave way, for someone who meets the word for the first time.
fn why(cause: Cause) -> &'static str {
    match cause {
        Cause::FlatLimit => {
            "The flat surface could not stay flat: with depth the pull grew faster there than the \
             softest wave of the body resists."
        }
        Cause::Fold => {
            "The pattern came to its end: beyond this u₀ there is no equilibrium of its kind."
        }
        Cause::SymmetryBreaking => {
            "The pattern exists beyond this u₀ too, but is unstable there: a disturbance of \
             another symmetry grows."
        }
        Cause::Mesh => {
            "The edge of the contact moved on by one spacing of the mesh. A finer mesh has no such \
             jump."
        }
        Cause::Transition => {
            "One pattern passes into the other by and by: nothing jumps, and nothing is lost."
        }
        Cause::PatternChange => {
            "The pattern was another one at the next u₀. This method does not ask where and why it \
             changed."
        }
        Cause::Push => {
            "Nothing gave way by itself: the surface was pressed by hand, and came to rest in \
             another state."
        }
    }
}

/// Width below which the columns stand closer, so that the causes have room.
const NARROW: f32 = 350.0;

/// The tab.
pub struct EventList;

impl Tab for EventList {
    fn title(&self) -> Title {
        Title::new("Events", "every jump so far")
    }

    fn show(&mut self, ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
        show(ui, state, actions);
    }
}

/// Sum and table.
fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let jumps = &state.run.record.jumps;
    let [length, energy] =
        [Dimension::Length, Dimension::SurfaceEnergy].map(|of| state.model.unit(of));
    let sum = energy.say(state.run.record.released_energy_sum(), 4, "γ");
    let words = format!("{}, {sum} released", state.run.record.tally());
    explain(ui.label(RichText::new(words).weak()), "Released");
    if !jumps.is_empty() && named(ui.small_button("Copy"), "Copy the jumps").clicked() {
        let lines = jumps.iter().map(|jump| state.say_jump(jump) + "\n");
        actions.push(Action::CopyText(lines.collect()));
    }
    if jumps.is_empty() {
        ui.label(RichText::new("No jump yet.").weak());
        return;
    }
    let palette = theme::palette(ui);
    let selected = state.run.selected_jump();
    let marked = selected.map(|index| jumps.len() - index);
    let colour = ui.visuals().selection.bg_fill.gamma_multiply(0.55);
    let faint = ui.visuals().faint_bg_color;
    let rows = move |row: usize, _: &egui::Style| {
        if marked == Some(row) {
            Some(colour)
        } else {
            (row % 2 == 1).then_some(faint)
        }
    };
    let gap = if ui.available_width() < NARROW {
        4.0
    } else {
        10.0
    };
    ScrollArea::both()
        .auto_shrink([false, false])
        .show(ui, |ui| {
            egui::Grid::new("events")
                .with_row_color(rows)
                .num_columns(5)
                .min_col_width(0.0)
                .spacing([gap, 3.0])
                .show(ui, |ui| {
                    let u0 = length.label("u₀/ρ", "u₀");
                    let released = energy.label("released/γ", "released");
                    let titles = [&*u0, "pattern", &released, "cause"];
                    ui.label("");
                    for (title, word) in titles.iter().zip(["u0", "pattern", "released", "cause"]) {
                        explain(ui.label(RichText::new(*title).small().weak()), word);
                    }
                    ui.end_row();
                    for (index, jump) in jumps.iter().enumerate().rev().take(ROWS) {
                        let (mark, colour) = match jump.direction {
                            Direction::Approach => ("◀", palette.approach),
                            Direction::Retraction => ("▶", palette.retraction),
                        };
                        ui.label(RichText::new(mark).color(colour))
                            .on_hover_text(jump.direction.to_string());
                        let place = ui.selectable_label(
                            selected == Some(index),
                            length.number(jump.mean_displacement / state.rho(), 3),
                        );
                        place
                            .on_hover_text("the numbers of the state after it (J, K)")
                            .asks(actions, Action::SelectJump(index));
                        ui.label(jump.change()).on_hover_text(state.say_jump(jump));
                        ui.label(energy.number(jump.released_energy, 4));
                        // A narrow list is cut at its right: first what is unusual.
                        let cause = jump.contested_words().map_or_else(
                            || jump.cause.to_string(),
                            |words| format!("{words}; {}", jump.cause),
                        );
                        ui.label(RichText::new(cause).small())
                            .on_hover_text(why(jump.cause));
                        ui.end_row();
                    }
                });
        });
}
