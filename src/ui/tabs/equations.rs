//! The model's equations with the numbers of the scene, and whether such a scene is real.

use super::{Tab, Title};
use crate::study::reality::equations;
use crate::study::reality::{Check, Verdict, reality};
use crate::ui::action::Action;
use crate::ui::theme;
use crate::ui::view_state::ViewState;
use crate::ui::words::explain;
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
            "the model in five lines with the numbers of this scene, and whether it can be real",
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
                    explain(
                        ui.label(RichText::new(equation.name).strong()),
                        equation.name,
                    );
                    ui.label(theme::set(&equation.formula, FORMULA, ink));
                    ui.label(equation.sentence);
                    ui.label(theme::set(&equation.here, NUMBERS, weak));
                    ui.add_space(6.0);
                }
                ui.separator();
                ui.label(RichText::new("Is this scene real?").heading().strong());
                for check in reality(&state.model) {
                    verdict(ui, &check);
                }
            });
    }
}

/// An assumption with its numbers, and whether it holds.
fn verdict(ui: &mut Ui, check: &Check) {
    let palette = theme::palette(ui);
    let (mark, colour) = match check.verdict {
        Verdict::Holds => ("✔", palette.good),
        Verdict::Doubtful => ("⚠", palette.warn),
        Verdict::Fails => ("✖", palette.warn),
    };
    ui.horizontal(|ui| {
        ui.label(RichText::new(mark).color(colour).strong());
        ui.label(RichText::new(format!("{}: {}", check.name, check.verdict)).strong());
    });
    ui.label(theme::set(&check.here, NUMBERS, palette.approach));
    ui.label(&check.sentence);
    ui.add_space(6.0);
}
