//! The loops that are kept: names, looks, numbers, and what can be done with each.

use super::{Tab, Title};
use crate::plot::panel::Role;
use crate::plot::style::stroke;
use crate::ui::action::{Action, KeepFrom, KeptAct, Scales, ViewOptions};
use crate::ui::diagram::dash;
use crate::ui::theme;
use crate::ui::view_state::{Kept, ViewState};
use crate::ui::widgets::{Asks, at_right, checkbox, choosable, named};
use crate::ui::words::explain;
use egui::{Label, RichText, ScrollArea, TextEdit, Ui, WidgetInfo};

/// The tab.
pub struct KeptTab;

impl Tab for KeptTab {
    fn title(&self) -> Title {
        Title::new(
            "Loops",
            "the loops that stay on the plot, to compare others with",
        )
    }

    fn show(&mut self, ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
        ui.horizontal_wrapped(|ui| {
            explain(ui.label("Keep:"), "Keep:");
            for (face, from, what) in [
                ("walked", KeepFrom::Walked, "Keep what was walked"),
                ("live loop", KeepFrom::Live, "Keep the live loop"),
            ] {
                named(ui.small_button(face), what).asks(actions, Action::Keep(from));
            }
            let before = named(
                ui.small_button("A | B before the edit"),
                "Compare with the scene before the last edit",
            );
            let words = "puts the scene before the last edit beside this one, at the same u₀";
            before
                .on_hover_text(words)
                .asks(actions, Action::CompareWithBefore);
            let mut absolute = state.view.scales == Scales::Absolute;
            let words = "all loops in the same lengths and stresses; else each in the range and \
                the largest traction of its own law";
            if ui
                .checkbox(&mut absolute, "Absolute units")
                .on_hover_text(words)
                .changed()
            {
                let scales = if absolute {
                    Scales::Absolute
                } else {
                    Scales::Own
                };
                actions.push(Action::SetView(ViewOptions {
                    scales,
                    ..state.view
                }));
            }
        });
        if let Some(words) = state.losses_in_words() {
            ui.add(Label::new(RichText::new(words).strong()).wrap());
        }
        let kept = &state.plots.kept;
        if let Some(deleted) = &kept.deleted {
            ui.horizontal(|ui| {
                named(ui.small_button("Bring back"), "Bring the deleted loop back")
                    .asks(actions, Action::BringKeptBack);
                let words = format!("“{}” is deleted", deleted.name);
                ui.add(Label::new(RichText::new(words).small()).truncate());
            });
        }
        if kept.list.is_empty() {
            ui.label(RichText::new("No loop is kept yet: L keeps the one on the plot.").weak());
        }
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            for kept in &kept.list {
                row(ui, state, kept, actions);
            }
        });
    }
}

/// One loop in two lines: look, name and what can be done with it, and what it is.
fn row(ui: &mut Ui, state: &ViewState, kept: &Kept, actions: &mut Vec<Action>) {
    let mut act = |act: KeptAct| actions.push(Action::OnKept(kept.id, act));
    let is_b = state.beside().is_some_and(|(_, b)| b.id == kept.id);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 5.0;
        let (colour, line) = kept.look();
        let ink = theme::rgb(stroke(Role::Kept(line), colour, theme::ground(ui)).colour);
        let mut shown = !kept.is_hidden;
        let tick = checkbox(
            ui,
            &mut shown,
            RichText::new(dash(line)).color(ink).strong(),
        );
        let name = format!("Show {}", kept.name);
        choosable(&tick, egui::Role::CheckBox, shown, &name);
        if tick.on_hover_text("on the plot or off it").changed() {
            act(KeptAct::Hide);
        }
        at_right(ui, |ui| {
            for (face, doing, done) in [
                ("✖", "Delete", KeptAct::Delete),
                ("Open", "Open the scene of", KeptAct::Restore),
            ] {
                let button = named(ui.small_button(face), &format!("{doing} {}", kept.name));
                if button.on_hover_text(doing).clicked() {
                    act(done);
                }
            }
            let beside = ui.selectable_label(is_b, "A | B");
            let name = format!("Beside: {}", kept.name);
            choosable(&beside, egui::Role::Button, is_b, &name);
            let words = "its scene beside this one, at the same u₀";
            if beside.on_hover_text(words).clicked() {
                act(KeptAct::Beside);
            }
            let mut name = kept.name.clone();
            let field = TextEdit::singleline(&mut name).desired_width(f32::INFINITY);
            let field = ui.add(field);
            field.widget_info(|| {
                WidgetInfo::labeled(
                    egui::Role::TextInput,
                    true,
                    format!("Name of {}", kept.name),
                )
            });
            if field.changed() {
                act(KeptAct::Rename(name));
            }
        });
    });
    ui.add(Label::new(RichText::new(kept.words()).small()).truncate());
}
