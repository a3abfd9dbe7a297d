//! The left panel: the ground, the law and the machine as pictures to choose from, the cell, whether
//! the mesh is fine enough, and what is folded away.

use super::action::Action;
use super::theme::{self, Palette};
use super::view_state::ViewState;
use super::widgets::{card, given, number};
use super::words::{self, explain};
use super::{advanced, grounds, machine};
use crate::physics::law::{Law, Shape};
use crate::physics::mesh_rule;
use crate::scene::edit::{self, Follows};
use crate::scene::parameter;
use egui::{Painter, Rect, RichText, Stroke, Ui, pos2, vec2};

/// The panel's contents; it scrolls where the window is low.
pub fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    // The scroll bar covers nothing.
    ui.spacing_mut().scroll.floating_allocated_width = 8.0;
    egui::ScrollArea::vertical()
        .id_salt("controls")
        .auto_shrink([false, false])
        .show(ui, |ui| {
            heading(ui, "Ground");
            grounds::show(ui, state, actions);
            ui.add_space(4.0);
            heading(ui, "Law");
            laws(ui, state, actions);
            ui.add_space(4.0);
            heading(ui, "Machine");
            machine::show(ui, state, actions);
            ui.separator();
            cell(ui, state, actions);
            mesh(ui, state, actions);
            ui.separator();
            let fold = egui::CollapsingHeader::new("Advanced")
                .id_salt("advanced")
                .show(ui, |ui| advanced::show(ui, state, actions));
            explain(fold.header_response, "Advanced");
            ui.add(egui::Label::new(RichText::new(advanced::HOLDS).small().weak()).wrap());
        });
}

fn heading(ui: &mut Ui, text: &str) {
    explain(ui.label(RichText::new(text).strong()), text);
}

/// The side of the cell, and the range of the law.
fn cell(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let (scene, model) = (&state.scene, &state.model);
    let across = model.unit_across();
    let one = state.rho() / across.scale;
    if let Some(length) = number(
        ui,
        &parameter::LENGTH,
        model.grid.length / one,
        across.scale..=65536.0 * across.scale,
        across.name("ρ"),
    ) {
        actions.push(Action::edit(edit::with_length(scene, model, length * one)));
    }
    if let Some(range) = given(ui, scene, &parameter::RANGE, model.law.range, 1e-6..=1e6) {
        actions.push(Action::edit(edit::with_range(scene, model, range)));
    }
}

/// Height of a line that may have a button.
const ROW: f32 = 28.0;

/// Whether the mesh is fine enough, in room that is there for either answer.
fn mesh(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let palette = theme::palette(ui);
    let fine = state.model.mu_rho <= mesh_rule::SAFE;
    let (mark, words, colour) = if fine {
        ("✔", "Mesh: fine enough", palette.good)
    } else {
        ("⚠", "Mesh: too coarse", palette.warn)
    };
    let hover = "Jumps belong to the physics, and not to the mesh, while the mesh number is at most \
                 0.5 (Advanced).";
    ui.horizontal(|ui| {
        ui.set_min_height(ROW);
        ui.label(RichText::new(format!("{mark} {words}")).color(colour))
            .on_hover_text(hover);
        if !fine
            && ui
                .button("Refine")
                .on_hover_text("more points, until it is")
                .clicked()
        {
            let (scene, mu) = (&state.scene, 0.98 * mesh_rule::SAFE);
            let refined = edit::with_mu_rho(scene, &state.model, mu, Follows::Mesh);
            actions.push(Action::edit(refined));
        }
    });
}

/// What each of them is.
const LAW: &str = "The energy of two facing pieces of surface against the gap between them; the \
     curve is its slope, the traction.";

/// The cohesive laws as cards, two by two, each with a sketch of its traction against the gap.
fn laws(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let present = state.scene.law.shape;
    let shapes = Shape::all();
    let width = (ui.available_width() - 6.0) / 2.0;
    for pair in shapes.chunks(2) {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 6.0;
            for &shape in pair {
                let same = shape.word() == present.word();
                let shown = if same { present } else { shape };
                let name = shape.word().replace('_', " ");
                let drawn = |painter: &Painter, rect: Rect, palette: &Palette| {
                    traction(shown, painter, rect, palette);
                };
                let response = card(ui, ("law", &name), same, vec2(width, 58.0), drawn);
                let response = response.on_hover_ui(|ui| {
                    let formula = format!("gamma(g) = gamma_0 {}", shown.form().formula());
                    words::card(ui, &name, LAW, &formula);
                });
                if response.clicked() && !same {
                    let scene = edit::with_shape(&state.scene, &state.model, shape);
                    actions.push(Action::edit(scene));
                }
            }
        });
    }
}

/// The law's traction against the gap.
fn traction(shape: Shape, painter: &Painter, rect: Rect, palette: &Palette) {
    let law = Law {
        shape,
        surface_energy: 1.0,
        range: 1.0,
    };
    let (top, axis) = (rect.top() + 7.0, rect.bottom() - 17.0);
    painter.hline(
        rect.x_range().shrink(6.0),
        axis,
        Stroke::new(1.0, palette.flat),
    );
    let points = (0..=60)
        .map(|i| f64::from(i) / 60.0)
        .filter_map(|t| {
            let traction = law.at(0.02 + 3.4 * t).traction / law.traction_max();
            (traction > -0.15).then(|| {
                pos2(
                    rect.left() + 6.0 + t as f32 * (rect.width() - 12.0),
                    axis - traction as f32 * (axis - top),
                )
            })
        })
        .collect();
    painter.line(points, Stroke::new(1.8, palette.retraction));
}
