//! The rigid counter-surface: which, and its numbers. Lengths in ranges of the law.

use super::action::Action;
use super::number::{SEED_MAX, number, whole};
use super::scene_edit;
use super::view_state::ViewState;
use crate::physics::indenter::Indenter;
use crate::physics::roughness::{Roughness, WAVES_MAX};
use crate::scene::Model;
use crate::scene::parameter::{self, Parameter};
use egui::{ComboBox, Ui};

/// The choice, and below it what only this ground has.
pub fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let (scene, model) = (&state.scene, &state.model);
    ui.horizontal(|ui| {
        let label = ui.label("Ground");
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let combo = ComboBox::from_id_salt("ground").width(84.0).selected_text(word(&model.indenter)).show_ui(ui, |ui| {
                for indenter in grounds(model) {
                    let same = word(&indenter) == word(&model.indenter);
                    if ui.selectable_label(same, word(&indenter)).clicked() && !same {
                        actions.push(Action::EditScene(Box::new(scene_edit::with_ground(scene, model, indenter))));
                    }
                }
            });
            combo.response.labelled_by(label.id);
        });
    });
    let mut indenter = scene.indenter;
    parameters(ui, model, &mut indenter);
    if indenter != scene.indenter {
        let mut scene = (**scene).clone();
        scene.indenter = indenter;
        actions.push(Action::EditScene(Box::new(scene)));
    }
}

fn word(indenter: &Indenter) -> &'static str {
    match indenter {
        Indenter::Flat => "flat",
        Indenter::Hertz { .. } => "tip",
        Indenter::Wave { .. } => "waves",
        Indenter::Rough(_) => "rough",
    }
}

/// One of each, with numbers that suit the law and the cell.
fn grounds(model: &Model) -> [Indenter; 4] {
    let (rho, length) = (model.law.range, model.grid.length);
    let shortest = (8.0 * model.grid.spacing()).max(length / 16.0).min(length);
    [
        Indenter::Flat,
        Indenter::Hertz { radius: length },
        Indenter::Wave { amplitude: 2.0 * rho, periods: [1, usize::from(!model.grid.is_line())] },
        Indenter::Rough(Roughness { hurst: 0.8, rms: 4.0 * rho, longest: length, shortest, seed: 1 }),
    ]
}

fn parameters(ui: &mut Ui, model: &Model, indenter: &mut Indenter) {
    let (rho, length) = (model.law.range, model.grid.length);
    let mut edit = |parameter: &Parameter, value: &mut f64, unit: f64, low: f64, high: f64, word: &str| {
        if let Some(edited) = number(ui, parameter, *value / unit, low..=high, word) {
            *value = edited * unit;
        }
    };
    match indenter {
        Indenter::Flat => {}
        Indenter::Hertz { radius } => edit(&parameter::RADIUS, radius, rho, 1e-3, 1e7, "ρ"),
        Indenter::Wave { amplitude, periods } => {
            edit(&parameter::AMPLITUDE, amplitude, rho, 1e-6, 1e6, "ρ");
            let most = model.grid.nx as u64 / 4;
            for (axis, name) in
                ["Waves along x", "Waves along y"].into_iter().enumerate().take(if model.grid.is_line() { 1 } else { 2 })
            {
                // One of the two has to stay.
                let least = u64::from(periods[1 - axis] == 0);
                if let Some(count) = whole(ui, name, periods[axis] as u64, least..=most) {
                    periods[axis] = count as usize;
                }
            }
        }
        Indenter::Rough(rough) => {
            edit(&parameter::HURST, &mut rough.hurst, 1.0, 0.01, 1.0, "");
            edit(&parameter::RMS, &mut rough.rms, rho, 1e-6, 1e6, "ρ");
            edit(&parameter::LONGEST, &mut rough.longest, rho, rough.shortest / rho, length / rho, "ρ");
            edit(&parameter::SHORTEST, &mut rough.shortest, rho, length / WAVES_MAX as f64 / rho, rough.longest / rho, "ρ");
            if let Some(seed) = whole(ui, &parameter::GROUND_SEED.title(), rough.seed, 0..=SEED_MAX) {
                rough.seed = seed;
            }
        }
    }
}
