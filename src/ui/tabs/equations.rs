//! The model's equations with the numbers of the scene.

use super::{Tab, Title};
use crate::study::equations::equations;
use crate::ui::action::Action;
use crate::ui::theme;
use crate::ui::view_state::ViewState;
use egui::{RichText, ScrollArea, Ui};

/// Size of a formula, and of the numbers beneath it.
const FORMULA: f32 = 17.0;
const NUMBERS: f32 = 13.0;

/// The tab.
pub struct Equations;

impl Tab for Equations {
    fn title(&self) -> Title {
        Title::new(
            "Equations",
            "the model in five lines, with the numbers of this scene",
        )
    }

    fn show(&mut self, ui: &mut Ui, state: &ViewState, _: &mut Vec<Action>) {
        let (ink, weak) = (
            ui.visuals().strong_text_color(),
            theme::palette(ui).approach,
        );
        ScrollArea::vertical()
            .auto_shrink([false, false])
            .show(ui, |ui| {
                for equation in equations(&state.scene, &state.model, &state.run.record) {
                    ui.label(RichText::new(equation.name).strong());
                    ui.label(theme::set(&equation.formula, FORMULA, ink));
                    ui.label(equation.sentence);
                    ui.label(theme::set(&equation.here, NUMBERS, weak));
                    ui.add_space(6.0);
                }
            });
    }
}
