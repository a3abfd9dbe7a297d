//! The left panel: u0, mu_rho, the cohesive law, the cell, and what is folded away.

use super::action::Action;
use super::view_state::ViewState;
use super::widgets::{SEED_MAX, field, labelled, named, number, own, whole};
use super::{sliders, theme};
use crate::follow::record::Direction;
use crate::physics::indenter::Indenter;
use crate::physics::law::{Law, Shape};
use crate::scene::edit::{self, Follows};
use crate::scene::part::Strategy;
use crate::scene::{Points, Scene, Turn, parameter};
use crate::solver::methods::MethodKind;
use egui::{Align2, ComboBox, Id, RichText, Role, Sense, Stroke, Ui, WidgetInfo, pos2, vec2};

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
            laws(ui, state, actions);
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
        sliders::u0(ui, state, actions);
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
                let colour = theme::palette(ui).live;
                ui.label(RichText::new(words).small().color(colour))
                    .on_hover_text("read off the atlas; the walk is on its way there");
            }
        });
    });
}

fn mesh_number(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    labelled(ui, RichText::new("Mesh number μᵨ").strong(), |ui| {
        let mut mu = state.model.mu_rho;
        let range = edit::MU_RHO.0..=edit::MU_RHO.1;
        let drag = field(&mut mu)
            .range(range)
            .clamp_existing_to_range(false)
            .speed(0.002)
            .max_decimals(4);
        let response = ui.add(drag);
        if response.changed() {
            let scene = edit::with_mu_rho(&state.scene, &state.model, mu, state.follows);
            actions.push(Action::edit(scene));
        }
        response
    });
    sliders::mu_rho(ui, state, actions);
    if state.model.mu_rho > 0.5 {
        let warn = theme::palette(ui).warn;
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

/// Asks for the scene with one thing changed.
fn change(state: &ViewState, actions: &mut Vec<Action>, change: impl FnOnce(&mut Scene)) {
    let mut scene = (*state.scene).clone();
    change(&mut scene);
    actions.push(Action::edit(scene));
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
        actions.push(Action::edit(edit::with_length(scene, model, ratio * rho)));
    }
    let line = model.grid.is_line();
    labelled(ui, "Points n", |ui| {
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
                    actions.push(Action::edit(edit::with_points(scene, model, Points::Auto)));
                }
                for n in [16, 24, 32, 48, 64, 96, 128, 192, 256, 512, 1024, 2048, 4096]
                    .into_iter()
                    .filter(|&n| n <= most)
                {
                    if ui
                        .selectable_label(model.grid.nx == n, n.to_string())
                        .clicked()
                    {
                        let points = scene.cell.points.resized(n);
                        actions.push(Action::edit(edit::with_points(scene, model, points)));
                    }
                }
            });
        combo.response
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
        actions.push(Action::edit(edit::with_points(scene, model, points)));
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
        actions.push(Action::edit(edit::with_surface_energy(scene, model, value)));
    }
    if let Some(value) = number(ui, &parameter::RANGE, rho, 1e-6..=1e6, "") {
        actions.push(Action::edit(edit::with_range(scene, model, value)));
    }
    let shape = scene.law.shape;
    if let Some(values) = own(ui, shape.parameters(), &shape.values(), rho) {
        actions.push(Action::edit(edit::with_shape(
            scene,
            model,
            shape.with(&values),
        )));
    }
}

/// Where u0 starts and turns, and its step.
fn drive(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let (drive, rho) = (state.scene.drive, state.rho());
    let far = -1e4..=1e4;
    if let Some(value) = number(ui, &parameter::START, drive.start / rho, far.clone(), "ρ") {
        change(state, actions, |scene| scene.drive.start = value * rho);
    }
    if let Turn::At(turn) = drive.turn
        && let Some(value) = number(ui, &parameter::TURN, turn / rho, far, "ρ")
    {
        change(state, actions, |scene| {
            scene.drive.turn = Turn::At(value * rho);
        });
    }
    if let Some(value) = number(ui, &parameter::STEP, drive.step / rho, 1e-5..=10.0, "ρ") {
        change(state, actions, |scene| scene.drive.step = value * rho);
    }
}

fn accuracy_and_seed(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let scene = &state.scene;
    if let Some(value) = number(ui, &parameter::TARGET, scene.accuracy, 1e-6..=0.99, "") {
        change(state, actions, |scene| scene.accuracy = value);
    }
    if let Some(seed) = whole(ui, &parameter::SEED.title(), scene.seed, 0..=SEED_MAX) {
        change(state, actions, |scene| scene.seed = seed);
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
    labelled(ui, "Ground", |ui| {
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
                        actions.push(Action::edit(edit::with_ground(scene, model, indenter)));
                    }
                }
            });
        combo.response
    });
    if let Some(values) = own(
        ui,
        scene.indenter.parameters(),
        &scene.indenter.values(),
        state.rho(),
    ) {
        change(state, actions, |scene| {
            scene.indenter = scene.indenter.with(&values);
        });
    }
}

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
                let drawn = if same { present } else { shape };
                if law_card(ui, drawn, same, width) && !same {
                    let scene = edit::with_shape(&state.scene, &state.model, shape);
                    actions.push(Action::edit(scene));
                }
            }
        });
    }
}

fn law_card(ui: &mut Ui, shape: Shape, selected: bool, width: f32) -> bool {
    let (_, rect) = ui.allocate_space(vec2(width, 56.0));
    let response = ui.interact(rect, Id::unique(("law", shape.word())), Sense::click());
    let name = shape.word().replace('_', " ");
    response.widget_info(|| {
        WidgetInfo::selected(Role::RadioButton, true, selected, format!("law {name}"))
    });
    let visuals = ui.style().interact_selectable(&response, selected);
    let palette = theme::palette(ui);
    let painter = ui.painter().with_clip_rect(rect.intersect(ui.clip_rect()));
    let fill = if selected {
        ui.visuals().selection.bg_fill.gamma_multiply(0.55)
    } else {
        ui.visuals().faint_bg_color
    };
    painter.rect(
        rect.shrink(0.5),
        5.0,
        fill,
        Stroke::new(
            1.0,
            if selected {
                palette.approach
            } else {
                visuals.bg_stroke.color
            },
        ),
        egui::StrokeKind::Inside,
    );
    let law = Law {
        shape,
        surface_energy: 1.0,
        range: 1.0,
    };
    let (top, axis) = (rect.top() + 7.0, rect.bottom() - 17.0);
    painter.hline(
        rect.x_range().shrink(6.0),
        axis,
        Stroke::new(1.0, ui.visuals().weak_text_color()),
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
    painter.text(
        pos2(rect.center().x, rect.bottom() - 2.0),
        Align2::CENTER_BOTTOM,
        name,
        theme::small(),
        ui.visuals().strong_text_color(),
    );
    response.clicked()
}
