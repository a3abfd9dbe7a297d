//! What is folded away in the left panel: the experts' numbers.

use super::action::Action;
use super::sliders;
use super::view_state::ViewState;
use super::widgets::{
    Asks, Entry, SEED_MAX, checkbox, choosable, given, labelled, number, own, radio, whole,
};
use super::words::explain;
use crate::physics::body::Body;
use crate::scene::edit::{self, Follows};
use crate::scene::part::Strategy;
use crate::scene::units::{SUGGESTED, Units};
use crate::scene::{Points, Scene, Turn, parameter};
use crate::solver::methods::MethodKind;
use egui::{ComboBox, RichText, Ui};

/// What the fold holds, in a line.
pub const HOLDS: &str = "mesh number, points, units, numbers of law and drive, body, accuracy, seed, \
     model, method";

/// What is folded away.
pub fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    mesh_number(ui, state, actions);
    mesh(ui, state, actions);
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

fn mesh(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
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
