//! Edits of a scene, and what follows what when a value of the scene is edited: range or mesh after
//! mu_rho, and the drive after the law.

use super::parameter::Units;
use super::{Drive, Model, Points, Range, Scene, Turn, parameter};
use crate::physics::body::Body;
use crate::physics::control::Control;
use crate::physics::indenter::{Indenter, Measured};
use crate::physics::law::{Law, Shape};
use crate::physics::mesh;
use crate::physics::parameter::{Parameter, Refusal, Value};
use crate::physics::theory::flat_limits;
use crate::physics::topography::Topography;

/// What follows when mu_rho is changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Follows {
    /// The mesh stays, the range of the law follows.
    #[default]
    Range,
    /// The law stays, the mesh follows.
    Mesh,
}

/// Lower and upper end of the mu_rho slider.
pub const MU_RHO: (f64, f64) = (0.25, 2.0);

/// The named meshes of Table 1 by value, and before them the one above which the mesh lies.
pub const TICKS: [(&str, f64); 7] = [
    ("safe", mesh::SAFE),
    tick(1),
    tick(3),
    tick(5),
    tick(0),
    tick(2),
    tick(4),
];

const fn tick(row: usize) -> (&'static str, f64) {
    (mesh::TABLE_1[row].author, mesh::TABLE_1[row].mu_rho)
}

/// The scene with another mu_rho.
pub fn with_mu_rho(scene: &Scene, model: &Model, mu_rho: f64, follows: Follows) -> Scene {
    let mut scene = decided(scene, model);
    match follows {
        Follows::Range => {
            scene.law.range = Range::Length(mesh::range_for_mu_rho(
                &model.law,
                model.grid.spacing(),
                mu_rho,
            ));
            fit_drive(&mut scene);
        }
        Follows::Mesh => {
            let n = (mesh::points_for_mu_rho(&model.law, model.grid.length, mu_rho) / 2.0)
                .round()
                .clamp(4.0, 512.0) as usize
                * 2;
            scene.cell.points = scene.cell.points.resized(n);
        }
    }
    scene
}

/// The decided scene after an `edit` of body, law or cell, which its drive follows.
fn with(scene: &Scene, model: &Model, edit: impl FnOnce(&mut Scene)) -> Scene {
    let mut scene = decided(scene, model);
    edit(&mut scene);
    fit_drive(&mut scene);
    scene
}

/// Step of a drive of u0 in place of another, in ranges.
const U0_STEP: f64 = 0.1;

impl Scene {
    /// The same scene with u0 driven over the window of u0.
    pub fn at_fixed_u0(&self, model: &Model) -> Self {
        let mut fixed = self.clone();
        if self.control().frees_mean() {
            let [lower, upper] = self.window_of_u0(model);
            fixed.drive = Drive {
                control: Control::Displacement,
                start: upper,
                turn: Turn::At(lower),
                step: U0_STEP * model.law.range,
            };
        }
        fixed
    }
}

/// The scene with another cohesive law of the same range and surface energy.
pub fn with_shape(scene: &Scene, model: &Model, shape: Shape) -> Scene {
    with(scene, model, |scene| scene.law.shape = shape)
}

/// The scene with another surface energy.
pub fn with_surface_energy(scene: &Scene, model: &Model, surface_energy: f64) -> Scene {
    with(scene, model, |scene| {
        scene.law.surface_energy = surface_energy;
    })
}

/// The scene of a body of another modulus, in units of its file.
pub fn with_contact_modulus(scene: &Scene, model: &Model, contact_modulus: f64) -> Scene {
    with(scene, model, |scene| {
        *scene = scene.with_contact_modulus(contact_modulus);
    })
}

/// The scene with another elastic body.
pub fn with_body(scene: &Scene, model: &Model, body: Body) -> Scene {
    with(scene, model, |scene| scene.body = body)
}

/// The scene with another range of its law.
pub fn with_range(scene: &Scene, model: &Model, range: f64) -> Scene {
    with(scene, model, |scene| scene.law.range = Range::Length(range))
}

/// The scene in another cell.
pub fn with_length(scene: &Scene, model: &Model, length: f64) -> Scene {
    with(scene, model, |scene| scene.cell.length = length)
}

/// The scene on another mesh; the range stays what it is.
pub fn with_points(scene: &Scene, model: &Model, points: Points) -> Scene {
    let mut scene = decided(scene, model);
    scene.cell.points = points;
    scene
}

/// The scene with what it leaves open decided: range and mesh as numbers. Editing one value then
/// does not move another.
pub fn decided(scene: &Scene, model: &Model) -> Scene {
    let mut scene = scene.clone();
    scene.law.range = Range::Length(model.law.range);
    if scene.cell.points == Points::Auto {
        scene.cell.points = Points::Square(model.grid.nx);
    }
    scene
}

/// On flat ground: moves the drive if it no longer encloses the instabilities of the edited law,
/// else leaves it alone.
fn fit_drive(scene: &mut Scene) {
    let (Indenter::Flat, Ok(model)) = (
        &scene.indenter,
        Scene {
            drive: SAFE,
            ..scene.clone()
        }
        .model(),
    ) else {
        return;
    };
    let law = model.law;
    let Some((lower, upper)) = flat_limits(&law, model.equivalent_length) else {
        return;
    };
    let (control, machine) = (scene.control(), scene.drive.control);
    let Drive {
        start,
        turn: Turn::At(turn),
        ..
    } = scene.drive
    else {
        return;
    };
    // The value of the control that holds the flat state of a gap.
    let held = |gap: f64| control.balanced(gap, law.at(gap).traction)[0];
    let pressed = if control.frees_mean() {
        0.0
    } else {
        -law.at(turn).traction / law.traction_max()
    };
    let fits = start > held(upper + 0.2 * law.range)
        && start < held(upper + 6.0 * law.range)
        && turn < held(lower - 0.1 * law.range)
        && pressed < 1.0;
    if !fits {
        scene.drive = enclosing(&law, (lower, upper), control, machine);
    }
}

/// A drive on flat ground that goes beyond both ends of what is unstable, of a `machine` that makes
/// this `control` of u0.
fn enclosing(law: &Law, (lower, upper): (f64, f64), control: Control, machine: Control) -> Drive {
    let held = |gap: f64| control.balanced(gap, law.at(gap).traction)[0];
    let (start, turn) = match control {
        Control::Load => (1.3 * law.traction_max(), -0.3 * law.traction_max()),
        // As soft a machine takes both ends farther.
        _ => {
            let stretched = control.unit(law) - law.range;
            let start = held(upper + 1.1 * law.range) + stretched;
            (start, held(turn_for(law, lower)))
        }
    };
    let step = match control {
        Control::Displacement => 0.02 * law.range,
        _ => (start - turn) / STEPS,
    };
    Drive {
        control: machine,
        start,
        turn: Turn::At(turn),
        step,
    }
}

/// The scene under another machine, driven from where nothing touches into contact and back.
pub fn with_control(scene: &Scene, model: &Model, control: Control) -> Scene {
    let mut scene = decided(scene, model);
    let law = model.law;
    scene.drive.control = control;
    scene.drive = match flat_limits(&law, model.equivalent_length) {
        Some(limits) if model.indenter == Indenter::Flat => {
            enclosing(&law, limits, scene.control(), control)
        }
        _ => {
            let mut drive = with_ground(&scene, model, model.indenter.clone()).drive;
            drive.control = control;
            if control == Control::Load {
                let pull_off = model.indenter.ground().pull_off(&law, &model.grid);
                let start = 1.5 * pull_off.unwrap_or(law.traction_max());
                (drive.start, drive.turn) = (start, Turn::At(-0.3 * start));
                drive.step = 1.3 * start / STEPS;
            }
            drive
        }
    };
    scene
}

/// Checks that the scene has a number of this `key`.
///
/// # Errors
/// The keys that it has.
pub fn check_key(scene: &Scene, key: &str) -> Result<(), Refusal> {
    let known: Vec<&str> = scene
        .numbers()
        .iter()
        .map(|(parameter, _)| parameter.key)
        .chain([parameter::RANGE.key, parameter::MU_RHO.key])
        .collect();
    if known.contains(&key) {
        return Ok(());
    }
    let allowed = format!("a number of this scene: {}", known.join(", "));
    Err(Refusal::new("key", format!("\"{key}\""), &allowed))
}

/// The scene with another value of the number of this `key`, as its file has it; what follows it
/// follows.
///
/// # Errors
/// As [`check_key`], or a value that is not allowed.
pub fn with_parameter(
    scene: &Scene,
    model: &Model,
    key: &str,
    value: f64,
) -> Result<Scene, Refusal> {
    check_key(scene, key)?;
    let known = scene.numbers().into_iter();
    let known = known
        .map(|(parameter, _)| parameter)
        .find(|parameter| parameter.key == key);
    let value = known.map_or(value, |known| scene.number_taken(known.unit, value));
    let of = |parameter: &Parameter| parameter.key == key;
    let whole = value.round().max(0.0);
    // The number of this key among the own ones of a body, a law or a ground.
    let own = |parameters: &[Parameter], mut values: Vec<Value>| {
        let i = parameters.iter().position(of)?;
        values[i] = match values[i] {
            Value::Number(_) => Value::Number(value),
            Value::Whole(_) => Value::Whole(whole as u64),
            _ => return None,
        };
        Some(values)
    };
    let (body, law, ground) = (scene.body, scene.law.shape, &scene.indenter);
    if let Some(values) = own(body.parameters(), body.values()) {
        return Ok(with_body(scene, model, body.with(&values)));
    }
    if let Some(values) = own(law.parameters(), law.values()) {
        return Ok(with_shape(scene, model, law.with(&values)));
    }
    if let Some(values) = own(ground.parameters(), ground.values()) {
        return Ok(with_ground_values(scene, &values));
    }
    let drive = |edit: &dyn Fn(&mut Drive)| {
        let mut edited = scene.clone();
        edit(&mut edited.drive);
        edited
    };
    Ok(match key {
        "cell.length" => with_length(scene, model, value),
        "cell.points" => {
            let even = 2 * (whole / 2.0).round() as usize;
            with_points(scene, model, scene.cell.points.resized(even))
        }
        "law.surface_energy" => with_surface_energy(scene, model, value),
        "law.range" => with_range(scene, model, value),
        "law.mu_rho" => with_mu_rho(scene, model, value, Follows::Range),
        "drive.stiffness" => with_control(scene, model, Control::Spring { stiffness: value }),
        "drive.start" => drive(&|drive| drive.start = value),
        "drive.turn" => drive(&|drive| drive.turn = Turn::At(value)),
        "drive.step" => drive(&|drive| drive.step = value),
        "accuracy.target" => Scene {
            accuracy: value,
            ..scene.clone()
        },
        "noise.seed" => Scene {
            seed: whole as u64,
            ..scene.clone()
        },
        "body.contact_modulus" => with_contact_modulus(scene, model, value),
        "units.temperature" => Scene {
            units: scene.units.map(|units| Units {
                temperature: value,
                ..units
            }),
            ..scene.clone()
        },
        _ => return Err(Refusal::new(key, value, "a number that can be varied")),
    })
}

/// Steps of the approach of a drive under a spring or a load.
const STEPS: f64 = 150.0;

/// A drive that no law refuses, to ask for the model of a scene whose own drive may not fit any
/// more.
const SAFE: Drive = Drive {
    control: Control::Displacement,
    start: 2.0,
    turn: Turn::At(1.0),
    step: 0.1,
};

/// A turning point deep enough for the flat state to be stable again, yet not pressed hard:
/// traction 0.6 sigma_max below its maximum.
fn turn_for(law: &Law, lower: f64) -> f64 {
    let (mut low, mut high) = (1e-3 * law.contact_gap(), law.contact_gap());
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if law.at(middle).traction < 0.6 * law.traction_max() {
            low = middle;
        } else {
            high = middle;
        }
    }
    high.min(lower - 0.2 * law.range)
}

/// The scene with other values of its ground's own parameters, as many and of the same kinds.
pub fn with_ground_values(scene: &Scene, values: &[Value]) -> Scene {
    let mut scene = scene.clone();
    let ground = scene.indenter.with(values);
    set_ground(&mut scene, ground);
    scene
}

/// The scene on measured ground, with the choices of the measured ground that it had; where nothing
/// tells the size of the map, it fills the present cell. A map has no line cell.
pub fn with_heights(scene: &Scene, model: &Model, map: Topography) -> Scene {
    let choices = match &scene.indenter {
        Indenter::Measured(measured) => measured.clone(),
        _ => Measured::default(),
    };
    let choices = match &scene.units {
        Some(units) => choices.in_unit(units.length.word),
        None => choices,
    };
    let is_map = map.heights.nrows() > 1;
    let ground = Indenter::Measured(choices.of(map).filling(model.grid.length));
    let mut scene = with_ground(scene, model, ground);
    if let (true, Points::Line(n)) = (is_map, scene.cell.points) {
        scene.cell.points = Points::Square(n.min(SQUARE_MAX));
    }
    scene
}

/// Points along a side of the square cell that a line cell becomes.
const SQUARE_MAX: usize = 128;

/// Ground that repeats in one cell alone brings it along.
fn set_ground(scene: &mut Scene, indenter: Indenter) {
    scene.cell.length = indenter.ground().period().unwrap_or(scene.cell.length);
    scene.indenter = indenter;
}

/// The scene on other ground. The drive goes from where nothing touches to zero load on a tip, and
/// far into the valleys of waves and rough ground.
pub fn with_ground(scene: &Scene, model: &Model, indenter: Indenter) -> Scene {
    let mut scene = decided(scene, model);
    set_ground(&mut scene, indenter);
    let (rho, ground) = (model.law.range, scene.indenter.ground());
    let turn = if ground.turns_at_zero_load() {
        Turn::ZeroLoad
    } else {
        Turn::At(-0.85 * ground.relief(&model.law))
    };
    scene.drive = if scene.indenter == Indenter::Flat {
        SAFE
    } else {
        Drive {
            control: Control::Displacement,
            start: 6.0 * rho,
            turn,
            step: 0.1 * rho,
        }
    };
    fit_drive(&mut scene);
    scene
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::tests::fig2;

    #[test]
    fn the_drive_encloses_both_instabilities_after_any_edit_of_law_or_mu_rho() {
        let scene = fig2(64);
        let model = scene.model().unwrap();
        let mut edited: Vec<Scene> = Shape::all()
            .into_iter()
            .map(|s| with_shape(&scene, &model, s))
            .collect();
        edited.extend(
            [0.25, 0.35, 0.5, 0.7].map(|mu| with_mu_rho(&scene, &model, mu, Follows::Range)),
        );
        for scene in edited {
            let model = scene.model().unwrap_or_else(|e| panic!("{e}"));
            let Some((lower, upper)) = flat_limits(&model.law, model.equivalent_length) else {
                continue;
            };
            let (Turn::At(turn), start) = (scene.drive.turn, scene.drive.start) else {
                panic!("flat ground")
            };
            assert!(
                turn < lower && upper < start,
                "{turn} {lower} {upper} {start} of {}",
                scene.law.shape.word()
            );
        }
    }

    #[test]
    fn every_machine_over_any_ground_has_a_drive_of_u0_that_is_legal() {
        let scene = fig2(64);
        let grounds = Indenter::all().into_iter();
        for ground in grounds.filter(|ground| ground.check().is_ok()) {
            for (shape, control) in Shape::all()
                .into_iter()
                .flat_map(|shape| Control::all(0.05).map(|control| (shape, control)))
            {
                let scene = with_shape(&scene, &scene.model().unwrap(), shape);
                let model = scene.model().unwrap();
                let mut driven = with_ground(&scene, &model, ground.clone());
                driven = with_control(&driven, &driven.model().unwrap(), control);
                let fixed = driven.at_fixed_u0(&driven.model().unwrap());
                let [word, law] = [control.word(), shape.word()];
                assert!(
                    fixed.validate().is_ok(),
                    "{law} {word}: {:?}",
                    fixed.validate()
                );
            }
        }
    }

    #[test]
    fn every_number_of_a_scene_can_be_given_another_value_by_its_key() {
        let mut scene = fig2(64);
        scene.drive.control = Control::Spring { stiffness: 1.0 };
        let mut grounds = Indenter::all();
        grounds.retain(|ground| ground.check().is_ok());
        for (shape, ground) in Shape::all().into_iter().zip(grounds.into_iter().cycle()) {
            (scene.law.shape, scene.indenter) = (shape, ground);
            let model = fig2(64).model().unwrap();
            for (parameter, old) in scene.numbers() {
                let wanted = match old {
                    Value::Number(x) => 0.97 * x,
                    Value::Whole(n) => n as f64 + 2.0,
                    _ => continue,
                };
                let edited = with_parameter(&scene, &model, parameter.key, wanted).unwrap();
                let numbers = edited.numbers();
                let new = numbers.iter().find(|(known, _)| known.key == parameter.key);
                let same = match new.map(|(_, value)| *value) {
                    Some(Value::Number(x)) => x == wanted,
                    Some(Value::Whole(n)) => n as f64 == wanted,
                    _ => false,
                };
                assert!(same, "{}: {wanted} became {new:?}", parameter.key);
            }
            let refused = with_parameter(&scene, &model, "law.rnage", 1.0).unwrap_err();
            assert!(refused.to_string().contains("law.range"), "{refused}");
        }
    }

    #[test]
    fn mu_rho_comes_back_as_it_was_set_whatever_follows() {
        let scene = fig2(64);
        let model = scene.model().unwrap();
        for (follows, tolerance) in [(Follows::Range, 1e-12), (Follows::Mesh, 0.02)] {
            let model = with_mu_rho(&scene, &model, 0.45, follows).model().unwrap();
            assert!((model.mu_rho - 0.45).abs() < tolerance, "{}", model.mu_rho);
        }
    }
}
