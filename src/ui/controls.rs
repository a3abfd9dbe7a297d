//! The left panel: the ground, the law and the machine as pictures to choose from, the cell, whether
//! the mesh is fine enough; and what is folded away, the experts' numbers.

use super::action::{Action, FileTask};
use super::sliders;
use super::theme::{self, Palette};
use super::view_state::ViewState;
use super::widgets::{
    Asks, Entry, SEED_MAX, card, checkbox, choosable, given, labelled, number, own, radio, whole,
};
use super::words::{self, explain};
use crate::physics::body::Body;
use crate::physics::control::Control;
use crate::physics::indenter::{Indenter, Measured};
use crate::physics::law::Shape;
use crate::physics::mesh;
use crate::physics::parameter::Parameter;
use crate::scene::edit::{self, Follows};
use crate::scene::parameter::{self, SUGGESTED, Units};
use crate::scene::{Points, Range, Scene, Strategy, Turn};
use crate::solver::methods::MethodKind;
use egui::{ComboBox, Painter, Rect, RichText, Ui, vec2};
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
                .show(ui, |ui| advanced(ui, state, actions));
            explain(fold.header_response, "Advanced");
            ui.add(egui::Label::new(RichText::new(HOLDS).small().weak()).wrap());
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
    let fine = state.model.mu_rho <= mesh::SAFE;
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
            let (scene, mu) = (&state.scene, 0.98 * mesh::SAFE);
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
                    sliders::traction(shown, painter, rect, palette);
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

/// Height of a picture, and the room between two (points).
const HEIGHT: f32 = 50.0;
const GAP: f32 = 6.0;
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
                    sliders::sketch(kind, painter, rect, palette);
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
                sliders::machine(kind, painter, rect, palette);
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

/// What the fold holds, in a line.
const HOLDS: &str = "mesh number, points, units, numbers of law and drive, body, accuracy, seed, \
     model, method";

/// What is folded away.
fn advanced(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    mesh_number(ui, state, actions);
    points(ui, state, actions);
    units(ui, state, actions);
    law(ui, state, actions);
    drive(ui, state, actions);
    elastic_body(ui, state, actions);
    accuracy_and_seed(ui, state, actions);
    models(ui, state, actions);
    methods(ui, state, actions);
}

fn mesh_number(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    labelled(ui, RichText::new("Mesh number μᵨ").strong(), |ui| {
        let entry = Entry {
            name: "Mesh number",
            value: state.model.mu_rho,
            range: edit::MU_RHO.0..=edit::MU_RHO.1,
            speed: 0.002,
            decimals: 4,
            suffix: "",
        };
        let (entered, response) = entry.show(ui);
        if let Some(mu) = entered {
            let scene = edit::with_mu_rho(&state.scene, &state.model, mu, state.follows);
            actions.push(Action::edit(scene));
        }
        response
    });
    sliders::mu_rho(ui, state, actions);
    ui.horizontal_wrapped(|ui| {
        explain(ui.label("Follows:"), "Follows");
        for (follows, word) in [(Follows::Range, "range"), (Follows::Mesh, "mesh")] {
            let radio = radio(ui, &state.follows, &follows, word);
            explain(radio, word).asks(actions, Action::SetFollows(follows));
        }
    });
}

fn points(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let (scene, model) = (&state.scene, &state.model);
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
                    && matches!(scene.law.range, Range::Length(_))
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
    let line = checkbox(ui, &mut checked, "Line cell (uniform along y)");
    if explain(line, "Line cell").changed() {
        let n = model.grid.nx;
        let points = if checked {
            Points::Line(n)
        } else {
            Points::Square(n.min(256))
        };
        actions.push(Action::edit(edit::with_points(scene, model, points)));
    }
}

/// Asks for the scene with one thing changed.
fn change(state: &ViewState, actions: &mut Vec<Action>, change: impl FnOnce(&mut Scene)) {
    let mut scene = (*state.scene).clone();
    change(&mut scene);
    actions.push(Action::edit(scene));
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
    if let Some(modulus) = number(
        ui,
        actions,
        &parameter::CONTACT_MODULUS,
        value,
        1e-6..=1e6,
        word,
    ) {
        let scene = edit::with_contact_modulus(scene, model, modulus);
        actions.push(Action::edit(scene));
    }
    let value = units.temperature;
    if let Some(temperature) = number(ui, actions, &parameter::TEMPERATURE, value, 1.0..=1e4, "K") {
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
        actions,
        scene,
        &parameter::SURFACE_ENERGY,
        scene.law.surface_energy,
        1e-6..=1e6,
    ) {
        actions.push(Action::edit(edit::with_surface_energy(scene, model, value)));
    }
    let shape = scene.law.shape;
    if let Some(values) = own(ui, actions, shape.parameters(), &shape.values(), model) {
        actions.push(Action::edit(edit::with_shape(
            scene,
            model,
            shape.with(&values),
        )));
    }
}

/// Where the drive starts and turns, and its step.
fn drive(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let (drive, told) = (state.scene.drive, state.told());
    let (unit, suffix) = (told.unit, told.suffix.trim());
    let far = -1e4..=1e4;
    if let Some(value) = number(
        ui,
        actions,
        &parameter::START,
        drive.start / unit,
        far.clone(),
        suffix,
    ) {
        change(state, actions, |scene| scene.drive.start = value * unit);
    }
    if let Turn::At(turn) = drive.turn
        && let Some(value) = number(ui, actions, &parameter::TURN, turn / unit, far, suffix)
    {
        change(state, actions, |scene| {
            scene.drive.turn = Turn::At(value * unit);
        });
    }
    if let Some(value) = number(
        ui,
        actions,
        &parameter::STEP,
        drive.step / unit,
        1e-5..=10.0,
        suffix,
    ) {
        change(state, actions, |scene| scene.drive.step = value * unit);
    }
}

fn accuracy_and_seed(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let scene = &state.scene;
    if let Some(value) = number(
        ui,
        actions,
        &parameter::TARGET,
        scene.accuracy,
        1e-6..=0.99,
        "",
    ) {
        change(state, actions, |scene| scene.accuracy = value);
    }
    let seed = &parameter::SEED;
    if let Some(seed) = whole(ui, actions, (seed, seed.label), scene.seed, 0..=SEED_MAX) {
        change(state, actions, |scene| scene.seed = seed);
    }
}

fn models(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    explain(ui.label("Model"), "Model");
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
            let radio = radio(ui, &state.asked, &asked, word).on_hover_text(why);
            let name = format!("Model: {word}");
            choosable(&radio, egui::Role::RadioButton, chosen, &name);
            radio.asks(actions, Action::SetStrategy(asked));
        }
    });
}

fn methods(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    explain(ui.label("Method"), "Method");
    for method in MethodKind::ALL {
        let radio = radio(ui, &state.method, &method, method.title());
        explain(radio, method.title()).asks(actions, Action::SetMethod(method));
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
    let edited = own(ui, actions, body.parameters(), &body.values(), model);
    if let Some(body) = asked.or(edited.map(|values| body.with(&values))) {
        actions.push(Action::edit(edit::with_body(scene, model, body)));
    }
}
