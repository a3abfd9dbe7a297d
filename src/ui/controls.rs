//! The left panel: u0, mu_rho, the cohesive law, the cell, and what is folded away.

use super::action::{Action, FileTask};
use super::machine::Told;
use super::theme::Palette;
use super::view_state::ViewState;
use super::widgets::{SEED_MAX, card, field, given, labelled, named, number, own, whole};
use super::{machine, sliders, theme};
use crate::follow::record::Direction;
use crate::physics::body::Body;
use crate::physics::indenter::{Indenter, Measured};
use crate::physics::law::{Law, Shape};
use crate::physics::parameter::Dimension;
use crate::scene::edit::{self, Follows};
use crate::scene::part::Strategy;
use crate::scene::units::{SUGGESTED, Units};
use crate::scene::{Points, Scene, Turn, parameter};
use crate::solver::methods::MethodKind;
use egui::{ComboBox, Painter, Rect, RichText, Stroke, Ui, pos2, vec2};

/// The panel's contents; it scrolls where the window is low.
pub fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    // The scroll bar covers nothing.
    ui.spacing_mut().scroll.floating_allocated_width = 8.0;
    egui::ScrollArea::vertical()
        .auto_shrink([false, false])
        .show(ui, |ui| {
            let told = machine::told(state);
            heading(ui, &format!("{} {}", told.name, told.symbol));
            driven(ui, state, &told, actions);
            machine::show(ui, state, actions);
            ui.separator();
            mesh_number(ui, state, actions);
            ui.separator();
            heading(ui, "Cohesive law");
            laws(ui, state, actions);
            ui.separator();
            counter_surface(ui, state, actions);
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

fn driven(ui: &mut Ui, state: &ViewState, told: &Told, actions: &mut Vec<Action>) {
    let unit = told.unit;
    ui.horizontal_top(|ui| {
        sliders::driven(ui, state, told, actions);
        ui.vertical(|ui| {
            ui.set_width(ui.available_width().min(130.0));
            let label = ui.label("Target");
            let mut target = state.target / unit;
            let range = state.limits.0 / unit..=state.limits.1 / unit;
            let drag = field(&mut target)
                .range(range)
                .clamp_existing_to_range(false)
                .speed(0.01 * told.measure.scale)
                .max_decimals(6);
            if ui
                .add(drag.suffix(told.suffix.as_str()))
                .labelled_by(label.id)
                .changed()
            {
                actions.push(Action::SetTarget(target * unit));
            }
            ui.add_space(4.0);
            ui.label("Actual");
            ui.label(
                RichText::new(told.say(state.run.actual, 4))
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
                let unit = state.model.unit(Dimension::Stress);
                let words = format!(
                    "ahead: {pattern}, stable\n{}\n{:.2} E*/L",
                    unit.say(stress, 3, "σₘₐₓ"),
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
    units(ui, state, actions);
    law(ui, state, actions);
    drive(ui, state, actions);
    elastic_body(ui, state, actions);
    accuracy_and_seed(ui, state, actions);
    models(ui, state, actions);
    methods(ui, state, actions);
}

/// Whether the numbers have units, and what only such a scene has.
fn units(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let (scene, model) = (&state.scene, &state.model);
    let names = ["none: E* is 1", "SI"];
    let present = names[usize::from(scene.units.is_some())];
    if let Some(i) = chosen(ui, "Units", present, &names) {
        change(state, actions, |scene| {
            scene.units = (i == 1).then_some(SUGGESTED);
        });
    }
    let Some(units) = scene.units else {
        return;
    };
    let value = units.contact_modulus;
    let word = units.modulus.word;
    if let Some(modulus) = number(ui, &parameter::CONTACT_MODULUS, value, 1e-6..=1e6, word) {
        let scene = edit::with_contact_modulus(scene, model, modulus);
        actions.push(Action::edit(scene));
    }
    let value = units.temperature;
    if let Some(temperature) = number(ui, &parameter::TEMPERATURE, value, 1.0..=1e4, "K") {
        let units = Units {
            temperature,
            ..units
        };
        change(state, actions, |scene| scene.units = Some(units));
    }
}

/// The numbers of the cohesive law.
fn law(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let (scene, model) = (&state.scene, &state.model);
    if let Some(value) = given(
        ui,
        scene,
        &parameter::SURFACE_ENERGY,
        scene.law.surface_energy,
        1e-6..=1e6,
    ) {
        actions.push(Action::edit(edit::with_surface_energy(scene, model, value)));
    }
    if let Some(value) = given(ui, scene, &parameter::RANGE, model.law.range, 1e-6..=1e6) {
        actions.push(Action::edit(edit::with_range(scene, model, value)));
    }
    let shape = scene.law.shape;
    if let Some(values) = own(ui, shape.parameters(), &shape.values(), model) {
        actions.push(Action::edit(edit::with_shape(
            scene,
            model,
            shape.with(&values),
        )));
    }
}

/// Where the drive starts and turns, and its step.
fn drive(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let (drive, told) = (state.scene.drive, machine::told(state));
    let (unit, suffix) = (told.unit, told.suffix.trim());
    let far = -1e4..=1e4;
    if let Some(value) = number(
        ui,
        &parameter::START,
        drive.start / unit,
        far.clone(),
        suffix,
    ) {
        change(state, actions, |scene| scene.drive.start = value * unit);
    }
    if let Turn::At(turn) = drive.turn
        && let Some(value) = number(ui, &parameter::TURN, turn / unit, far, suffix)
    {
        change(state, actions, |scene| {
            scene.drive.turn = Turn::At(value * unit);
        });
    }
    if let Some(value) = number(ui, &parameter::STEP, drive.step / unit, 1e-5..=10.0, suffix) {
        change(state, actions, |scene| scene.drive.step = value * unit);
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

/// Which of the `names` of a kind of thing is chosen, if not the present one again.
fn chosen(ui: &mut Ui, what: &str, present: &str, names: &[&str]) -> Option<usize> {
    let mut asked = None;
    labelled(ui, what, |ui| {
        let combo = ComboBox::from_id_salt(what)
            .width(84.0)
            .selected_text(present)
            .show_ui(ui, |ui| {
                for (i, name) in names.iter().enumerate() {
                    let same = *name == present;
                    if ui.selectable_label(same, *name).clicked() && !same {
                        asked = Some(i);
                    }
                }
            });
        combo.response
    });
    asked
}

/// The elastic body: the choice, and below it what only this body has.
fn elastic_body(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let (scene, model) = (&state.scene, &state.model);
    let (body, all) = (scene.body, Body::all());
    let names: Vec<_> = all.iter().map(|body| body.elastic().name()).collect();
    let asked = chosen(ui, "Body", body.elastic().name(), &names)
        .map(|i| all[i].elastic().suited(&model.grid));
    let edited = own(ui, body.parameters(), &body.values(), model);
    if let Some(body) = asked.or(edited.map(|values| body.with(&values))) {
        actions.push(Action::edit(edit::with_body(scene, model, body)));
    }
}

/// The rigid counter-surface: the choice, and below it what only this ground has.
fn counter_surface(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let (scene, model, all) = (&state.scene, &state.model, Indenter::all());
    let names: Vec<_> = all.iter().map(|ground| ground.ground().name()).collect();
    if let Some(i) = chosen(ui, "Ground", model.indenter.ground().name(), &names) {
        if let Indenter::Measured(_) = all[i] {
            actions.push(Action::AskFile(FileTask::OpenHeights));
        } else {
            let indenter = all[i].ground().suited(&model.law, &model.grid);
            actions.push(Action::edit(edit::with_ground(scene, model, indenter)));
        }
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
                let response = card(ui, ("law", &name), same, vec2(width, 56.0), drawn);
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
