//! The rigid ground: a picture of each kind to choose from, and what only the chosen one has.

use super::action::{Action, FileTask};
use super::theme::Palette;
use super::view_state::ViewState;
use super::widgets::{card, labelled, own};
use super::words;
use crate::physics::indenter::{Indenter, Measured};
use crate::physics::parameter::Parameter;
use crate::scene::edit;
use egui::{Mesh, Painter, Rect, Stroke, Ui, pos2, vec2};

/// Height of a picture, and the room between two (points).
const HEIGHT: f32 = 50.0;
const GAP: f32 = 6.0;
/// Points of an outline.
const POINTS: usize = 48;

/// The choice, and below it what only this ground has.
pub fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let (scene, model, all) = (&state.scene, &state.model, Indenter::all());
    let present = model.indenter.ground().name();
    let width = (ui.available_width() - 2.0 * GAP) / 3.0;
    let mut asked = None;
    for row in all.chunks(3) {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = GAP;
            for kind in row {
                let name = kind.ground().name();
                let drawn = |painter: &Painter, rect: Rect, palette: &Palette| {
                    sketch(kind, painter, rect, palette);
                };
                let chosen = name == present;
                let response = card(ui, ("ground", name), chosen, vec2(width, HEIGHT), drawn);
                let response = response.on_hover_ui(|ui| {
                    let own = kind.parameters().iter().map(Parameter::title);
                    let own = own.collect::<Vec<_>>().join(", ");
                    let own = if own.is_empty() { "nothing" } else { &own };
                    let sentence = format!("The rigid ground is {name}; it is set by: {own}.");
                    words::card(ui, name, &sentence, "g = u - h");
                });
                let again = matches!(kind, Indenter::Measured(_));
                if response.clicked() && (!chosen || again) {
                    asked = Some(kind);
                }
            }
        });
    }
    match asked {
        Some(Indenter::Measured(_)) => actions.push(Action::AskFile(FileTask::OpenHeights)),
        Some(kind) => {
            let indenter = kind.ground().suited(&model.law, &model.grid);
            actions.push(Action::edit(edit::with_ground(scene, model, indenter)));
        }
        None => {}
    }
    if let Indenter::Measured(measured) = &scene.indenter {
        height_file(ui, measured, actions);
    }
    if let Some(values) = own(
        ui,
        scene.indenter.parameters(),
        &scene.indenter.values(),
        model,
    ) {
        let edited = edit::with_ground_values(scene, &values);
        actions.push(Action::edit(edited));
    }
}

/// The name of the height file, which asks for another one.
fn height_file(ui: &mut Ui, measured: &Measured, actions: &mut Vec<Action>) {
    let file = &measured.topography().file;
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    labelled(ui, "Height file", |ui| {
        let button = ui.add(egui::Button::new(&*name).truncate());
        let button = button.on_hover_text(file.display().to_string());
        if button.clicked() {
            actions.push(Action::AskFile(FileTask::OpenHeights));
        }
        button
    });
}

/// The outline of a kind of ground, filled to below. Without its numbers: it stands for the kind.
pub fn sketch(kind: &Indenter, painter: &Painter, rect: Rect, palette: &Palette) {
    let (left, right) = (rect.left() + 8.0, rect.right() - 8.0);
    let (top, low) = (rect.top() + 8.0, rect.bottom() - 20.0);
    let mut filled = Mesh::default();
    let mut line = Vec::new();
    for i in 0..=POINTS {
        let x = i as f32 / POINTS as f32;
        let height = kind.ground().outline(f64::from(x)) as f32;
        let at = pos2(left + x * (right - left), low - height * (low - top));
        filled.colored_vertex(at, palette.indenter);
        filled.colored_vertex(pos2(at.x, low + 2.0), palette.indenter);
        line.push(at);
    }
    for k in 0..POINTS as u32 {
        filled.add_triangle(2 * k, 2 * k + 1, 2 * k + 2);
        filled.add_triangle(2 * k + 1, 2 * k + 2, 2 * k + 3);
    }
    painter.add(filled);
    if matches!(kind, Indenter::Measured(_)) {
        // The points of a measurement.
        for at in line.iter().step_by(6) {
            painter.circle_filled(*at, 2.2, palette.approach);
        }
    } else {
        painter.line(line, Stroke::new(1.4, palette.now));
    }
}
