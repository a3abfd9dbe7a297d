//! The rigid counter-surface: which, and its numbers. Lengths in ranges of the law.

use super::action::Action;
use super::number::own;
use super::view_state::ViewState;
use crate::physics::indenter::Indenter;
use crate::scene::edit;
use egui::{ComboBox, Ui};

/// The choice, and below it what only this ground has.
pub fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let (scene, model) = (&state.scene, &state.model);
    ui.horizontal(|ui| {
        let label = ui.label("Ground");
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let combo = ComboBox::from_id_salt("ground")
                .width(84.0)
                .selected_text(model.indenter.ground().name())
                .show_ui(ui, |ui| {
                    for indenter in Indenter::all() {
                        let same = indenter.word() == model.indenter.word();
                        if ui
                            .selectable_label(same, indenter.ground().name())
                            .clicked()
                            && !same
                        {
                            let indenter = indenter.ground().suited(&model.law, &model.grid);
                            actions.push(Action::EditScene(Box::new(edit::with_ground(
                                scene, model, indenter,
                            ))));
                        }
                    }
                });
            combo.response.labelled_by(label.id);
        });
    });
    if let Some(values) = own(
        ui,
        scene.indenter.parameters(),
        &scene.indenter.values(),
        state.rho(),
    ) {
        let mut scene = (**scene).clone();
        scene.indenter = scene.indenter.with(&values);
        actions.push(Action::EditScene(Box::new(scene)));
    }
}
