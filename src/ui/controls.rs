//! The left panel: the ground, the law and the machine as pictures to choose from, the cell, whether
//! the mesh is fine enough, and what is folded away.

use super::action::{Action, FileTask};
use super::advanced;
use super::theme::{self, Palette};
use super::view_state::ViewState;
use super::widgets::{Asks, card, given, labelled, number, own};
use super::words::{self, explain};
use crate::physics::control::Control;
use crate::physics::indenter::{Indenter, Measured};
use crate::physics::law::{Law, Shape};
use crate::physics::mesh_rule;
use crate::physics::parameter::Parameter;
use crate::scene::edit::{self, Follows};
use crate::scene::parameter;
use egui::{Mesh, Painter, Rect, RichText, Stroke, StrokeKind, Ui, pos2, vec2};
use std::f64::consts::PI;

/// The panel's contents; it scrolls where the window is low.
pub fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    // The scroll bar covers nothing.
    ui.spacing_mut().scroll.floating_allocated_width = 8.0;
    egui::ScrollArea::vertical()
        .id_salt("controls")
        .auto_shrink([false, false])
        .show(ui, |ui| {
            heading(ui, "Ground");
            grounds(ui, state, actions);
            ui.add_space(4.0);
            heading(ui, "Law");
            laws(ui, state, actions);
            ui.add_space(4.0);
            heading(ui, "Machine");
            machines(ui, state, actions);
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
        actions,
        &parameter::LENGTH,
        model.grid.length / one,
        across.scale..=65536.0 * across.scale,
        across.name("ρ"),
    ) {
        actions.push(Action::edit(edit::with_length(scene, model, length * one)));
    }
    if let Some(range) = given(
        ui,
        actions,
        scene,
        &parameter::RANGE,
        model.law.range,
        1e-6..=1e6,
    ) {
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

/// Height of a picture, and the room between two (points).
const HEIGHT: f32 = 50.0;
const GAP: f32 = 6.0;
/// Points of an outline.
const POINTS: usize = 48;

/// The choice, and below it what only this ground has.
fn grounds(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
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
        actions,
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
        button.asks(actions, Action::AskFile(FileTask::OpenHeights));
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

/// Stiffness of a spring that is chosen anew, over that of the softest wave of the body: soft
/// enough that patterns are skipped.
const SOFT: f64 = 3.0;

/// The choice, and the stiffness of a spring.
fn machines(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let (scene, model) = (&state.scene, &state.model);
    let present = scene.drive.control;
    let wave = PI / model.equivalent_length;
    let mut asked = None;
    let width = (ui.available_width() - 12.0) / 3.0;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 6.0;
        for kind in Control::all(SOFT * wave) {
            let (name, what) = match kind {
                Control::Displacement => ("stiff", "the mean displacement is driven"),
                Control::Spring { .. } => ("spring", "a stage pulls through a spring"),
                Control::Load => ("weight", "the load is driven: a dead weight"),
            };
            let chosen = kind.word() == present.word();
            let size = vec2(width, 62.0);
            let drawn = |painter: &Painter, rect: Rect, palette: &Palette| {
                between(kind, painter, rect, palette);
            };
            let response = card(ui, ("machine", name), chosen, size, drawn);
            if response.on_hover_text(what).clicked() && !chosen {
                asked = Some(kind);
            }
        }
    });
    if let Control::Spring { stiffness } = present {
        let range = 1e-9..=1e9;
        let wanted = given(ui, actions, scene, &parameter::STIFFNESS, stiffness, range);
        asked = asked.or(wanted.map(|stiffness| Control::Spring { stiffness }));
        ui.small(if scene.control().stiffness() < wave {
            "Softer than the body's softest wave: it snaps as one block."
        } else {
            "The spring's line in the plot touches the curve where it snaps."
        });
    }
    if let Some(control) = asked {
        actions.push(Action::edit(edit::with_control(scene, model, control)));
    }
}

/// A stage above, the body below, and what is between.
fn between(kind: Control, painter: &Painter, rect: Rect, palette: &Palette) {
    let stroke = Stroke::new(1.8, palette.retraction);
    let (x, top, low) = (rect.center().x, rect.top() + 9.0, rect.bottom() - 30.0);
    let body = Rect::from_min_max(
        pos2(rect.left() + 12.0, low),
        pos2(rect.right() - 12.0, low + 9.0),
    );
    painter.rect_filled(body, 2.0, palette.elastomer);
    let stage = |y: f32| {
        painter.hline(
            rect.x_range().shrink(16.0),
            y,
            Stroke::new(3.0, palette.approach),
        )
    };
    match kind {
        Control::Displacement => {
            stage(top);
            painter.vline(x, top..=low, Stroke::new(5.0, palette.retraction));
        }
        Control::Spring { .. } => {
            stage(top);
            let turns = 7;
            let zigzag = (0..=turns).map(|i| {
                let side = match i {
                    0 => 0.0,
                    i if i == turns => 0.0,
                    i if i % 2 == 0 => -6.0,
                    _ => 6.0,
                };
                pos2(x + side, top + (low - top) * i as f32 / turns as f32)
            });
            painter.line(zigzag.collect(), stroke);
        }
        Control::Load => {
            // Over a pulley.
            let (left, right) = (x - 8.0, x + 8.0);
            painter.circle_stroke(pos2(x, top + 4.0), 8.0, stroke);
            painter.vline(left, top + 4.0..=low, stroke);
            painter.vline(right, top + 4.0..=low - 10.0, stroke);
            let weight = Rect::from_center_size(pos2(right, low - 6.0), vec2(10.0, 9.0));
            painter.rect(
                weight,
                1.0,
                palette.approach,
                Stroke::NONE,
                StrokeKind::Inside,
            );
        }
    }
}
