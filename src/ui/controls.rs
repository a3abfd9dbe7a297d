//! The left panel: u0, mu_rho, the cohesive law, the cell, and what is folded away.

use super::action::Action;
use super::number::{SEED_MAX, field, number, own, whole};
use super::view_state::ViewState;
use super::{law_picker, mu_rho_slider, u0_slider};
use crate::follow::record::Direction;
use crate::physics::indenter::Indenter;
use crate::scene::edit::{self, Follows};
use crate::scene::part::Strategy;
use crate::scene::{Points, Scene, Turn, parameter};
use crate::solver::methods::MethodKind;
use egui::{ComboBox, Response, RichText, Ui};

/// The panel's contents; it scrolls where the window is low.
pub fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    egui::ScrollArea::vertical()
        .auto_shrink([false, false])
        .show(ui, |ui| {
            heading(ui, "Mean displacement u₀");
            displacement(ui, state, actions);
            ui.separator();
            mesh_number(ui, state, actions);
            ui.separator();
            heading(ui, "Cohesive law");
            law_picker::show(ui, state, actions);
            ui.separator();
            heading(ui, "Cell");
            cell(ui, state, actions);
            ui.separator();
            egui::CollapsingHeader::new("Advanced")
                .id_salt("advanced")
                .show(ui, |ui| advanced(ui, state, actions));
        });
}

fn heading(ui: &mut Ui, text: &str) {
    ui.label(RichText::new(text).strong());
}

fn displacement(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let rho = state.rho();
    ui.horizontal_top(|ui| {
        let tall = ui.ctx().content_rect().height() > 740.0;
        u0_slider::show(ui, state, actions, if tall { 236.0 } else { 180.0 });
        ui.vertical(|ui| {
            ui.set_width(ui.available_width().min(130.0));
            let label = ui.label("Target");
            let mut target = state.target / rho;
            let range = state.limits.0 / rho..=state.limits.1 / rho;
            let drag = field(&mut target)
                .range(range)
                .clamp_existing_to_range(false)
                .speed(0.01)
                .max_decimals(6);
            if ui.add(drag.suffix(" ρ")).labelled_by(label.id).changed() {
                actions.push(Action::SetTarget(target * rho));
            }
            ui.add_space(4.0);
            ui.label("Actual");
            ui.label(
                RichText::new(format!("{:.4} ρ", state.run.actual / rho))
                    .heading()
                    .strong(),
            );
            let (arrow, word) = match state.run.direction {
                Direction::Approach => ("▼", "approach"),
                Direction::Retraction => ("▲", "retraction"),
            };
            ui.label(format!("{arrow} {word}"));
            ui.add_space(4.0);
            ui.horizontal(|ui| {
                if named(ui.button("−"), "step down")
                    .on_hover_text("one increment down (←)")
                    .clicked()
                {
                    actions.push(Action::Step(-1.0));
                }
                if named(ui.button("+"), "step up")
                    .on_hover_text("one increment up (→)")
                    .clicked()
                {
                    actions.push(Action::Step(1.0));
                }
            });
            ui.small("Shift: fine");
            if let Some((pattern, sample)) = state.foreseen() {
                let stress = sample.stress / state.model.law.traction_max();
                let words = format!(
                    "ahead: {pattern}, stable\n{stress:.3} σₘₐₓ\n{:.2} E*/L",
                    sample.stiffness_min
                );
                let colour = super::theme::palette(super::theme::ground(ui)).live;
                ui.label(RichText::new(words).small().color(colour))
                    .on_hover_text("read off the atlas; the walk is on its way there");
            }
        });
    });
}

/// Gives a widget a name that says more than its face.
pub fn named(response: Response, name: &str) -> Response {
    response
        .widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, response.enabled(), name));
    response
}

fn mesh_number(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        let label = ui.label(RichText::new("Mesh number μᵨ").strong());
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let mut mu = state.model.mu_rho;
            let range = edit::MU_RHO.0..=edit::MU_RHO.1;
            let drag = field(&mut mu)
                .range(range)
                .clamp_existing_to_range(false)
                .speed(0.002)
                .max_decimals(4);
            if ui.add(drag).labelled_by(label.id).changed() {
                actions.push(Action::EditScene(Box::new(edit::with_mu_rho(
                    &state.scene,
                    &state.model,
                    mu,
                    state.follows,
                ))));
            }
        });
    });
    mu_rho_slider::show(ui, state, actions);
    if state.model.mu_rho > 0.5 {
        let warn = super::theme::palette(super::theme::ground(ui)).warn;
        ui.colored_label(warn, "Above 0.5 the mesh lies: jumps are too late.");
    }
    ui.horizontal(|ui| {
        ui.label("What follows:");
        for (follows, word) in [(Follows::Range, "range"), (Follows::Mesh, "mesh")] {
            if ui.radio(state.follows == follows, word).clicked() {
                actions.push(Action::SetFollows(follows));
            }
        }
    });
}

fn edit(actions: &mut Vec<Action>, scene: Scene) {
    actions.push(Action::EditScene(Box::new(scene)));
}

fn cell(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let (scene, model) = (&state.scene, &state.model);
    let rho = state.rho();
    if let Some(ratio) = number(
        ui,
        &parameter::LENGTH,
        model.grid.length / rho,
        1.0..=65536.0,
        "ρ",
    ) {
        edit(actions, edit::with_length(scene, model, ratio * rho));
    }
    let line = model.grid.is_line();
    ui.horizontal(|ui| {
        let label = ui.label("Points n");
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let most = if line { 4096 } else { 256 };
            let text = if scene.cell.points == Points::Auto {
                format!("auto ({})", model.grid.nx)
            } else {
                model.grid.nx.to_string()
            };
            let combo = ComboBox::from_id_salt("points")
                .width(84.0)
                .selected_text(text)
                .show_ui(ui, |ui| {
                    if !line
                        && matches!(scene.law.range, crate::scene::Range::Length(_))
                        && ui
                            .selectable_label(scene.cell.points == Points::Auto, "auto")
                            .clicked()
                    {
                        edit(actions, edit::with_points(scene, model, Points::Auto));
                    }
                    for n in [16, 24, 32, 48, 64, 96, 128, 192, 256, 512, 1024, 2048, 4096]
                        .into_iter()
                        .filter(|&n| n <= most)
                    {
                        if ui
                            .selectable_label(model.grid.nx == n, n.to_string())
                            .clicked()
                        {
                            let points = if line {
                                Points::Line(n)
                            } else {
                                Points::Square(n)
                            };
                            edit(actions, edit::with_points(scene, model, points));
                        }
                    }
                });
            combo.response.labelled_by(label.id);
        });
    });
    let mut checked = line;
    if ui
        .checkbox(&mut checked, "Line cell (uniform along y)")
        .changed()
    {
        let n = model.grid.nx;
        let points = if checked {
            Points::Line(n)
        } else {
            Points::Square(n.min(256))
        };
        edit(actions, edit::with_points(scene, model, points));
    }
}

fn advanced(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    law(ui, state, actions);
    drive(ui, state, actions);
    counter_surface(ui, state, actions);
    accuracy_and_seed(ui, state, actions);
    models(ui, state, actions);
    methods(ui, state, actions);
}

/// The numbers of the cohesive law.
fn law(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let (scene, model) = (&state.scene, &state.model);
    let rho = state.rho();
    if let Some(value) = number(
        ui,
        &parameter::SURFACE_ENERGY,
        scene.law.surface_energy,
        1e-6..=1e6,
        "",
    ) {
        edit(actions, edit::with_surface_energy(scene, model, value));
    }
    if let Some(value) = number(ui, &parameter::RANGE, rho, 1e-6..=1e6, "") {
        edit(actions, edit::with_range(scene, model, value));
    }
    let shape = scene.law.shape;
    if let Some(values) = own(ui, shape.parameters(), &shape.values(), rho) {
        edit(actions, edit::with_shape(scene, model, shape.with(&values)));
    }
}

/// Where u0 starts and turns, and its step.
fn drive(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let scene = &state.scene;
    let rho = state.rho();
    if let Some(value) = number(
        ui,
        &parameter::START,
        scene.drive.start / rho,
        -1e4..=1e4,
        "ρ",
    ) {
        let mut scene = (**scene).clone();
        scene.drive.start = value * rho;
        edit(actions, scene);
    }
    if let Turn::At(turn) = scene.drive.turn
        && let Some(value) = number(ui, &parameter::TURN, turn / rho, -1e4..=1e4, "ρ")
    {
        let mut scene = (**scene).clone();
        scene.drive.turn = Turn::At(value * rho);
        edit(actions, scene);
    }
    if let Some(value) = number(
        ui,
        &parameter::STEP,
        scene.drive.step / rho,
        1e-5..=10.0,
        "ρ",
    ) {
        let mut scene = (**scene).clone();
        scene.drive.step = value * rho;
        edit(actions, scene);
    }
}

fn accuracy_and_seed(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let scene = &state.scene;
    if let Some(value) = number(ui, &parameter::TARGET, scene.accuracy, 1e-6..=0.99, "") {
        let mut scene = (**scene).clone();
        scene.accuracy = value;
        edit(actions, scene);
    }
    if let Some(seed) = whole(ui, &parameter::SEED.title(), scene.seed, 0..=SEED_MAX) {
        edit(
            actions,
            Scene {
                seed,
                ..(**scene).clone()
            },
        );
    }
}

fn models(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    ui.label("Model")
        .on_hover_text("which part of the cell the walk represents");
    let models = [
        (
            None,
            "plan",
            "the least that meets the accuracy: a quarter wherever patterns keep their mirror \
             symmetry",
        ),
        (Some(Strategy::WHOLE), "whole cell", "nothing is left out"),
        (
            Some(Strategy::QUARTER),
            "quarter",
            "even patterns only; modes of other symmetry are watched on the whole cell",
        ),
    ];
    ui.horizontal_wrapped(|ui| {
        for (asked, word, why) in models {
            let chosen = state.asked == asked;
            let radio = ui.radio(chosen, word).on_hover_text(why);
            let name = format!("Model: {word}");
            radio.widget_info(|| {
                egui::WidgetInfo::selected(egui::Role::RadioButton, true, chosen, &name)
            });
            if radio.clicked() {
                actions.push(Action::SetStrategy(asked));
            }
        }
    });
}

fn methods(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    ui.label("Method");
    for method in MethodKind::ALL {
        if ui.radio(state.method == method, method.title()).clicked() {
            actions.push(Action::SetMethod(method));
        }
    }
}

/// The rigid counter-surface: the choice, and below it what only this ground has.
fn counter_surface(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
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
