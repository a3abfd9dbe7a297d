//! The scene's own numbers. Those of a law or a ground stand with it
//! ([`Own`](crate::physics::parameter::Own)).
//!
//! What ties two values together (a turn below its start) is in [`super::Scene::model`].

use super::{Points, Range, Scene, Turn};
use crate::physics::body::Body;
use crate::physics::control::Control;
use crate::physics::grid::POINTS_MAX;
use crate::physics::indenter::Indenter;
use crate::physics::law::Shape;
use crate::physics::parameter::Dimension::{Driven, Length, Pure, Stiffness, SurfaceEnergy};
use crate::physics::parameter::{
    BELOW_ONE, LENGTHS, POSITIVE, Parameter, SEED_MAX, Value, parameter,
};

/// Largest magnitude of a mean displacement.
const FAR: f64 = 1e110;

macro_rules! parameters {
    ($($(#[$doc:meta])* $name:ident: $key:literal, $label:literal, $symbol:literal, $unit:expr,
        $range:expr, $default:expr, $hint:expr;)*) => {
        $($(#[$doc])* pub static $name: Parameter =
            parameter!($key, $label, $symbol, $unit, $range, $default, $hint);)*

        /// The scene's own numbers, in the order of the file's tables.
        static OWN: &[&Parameter] = &[$(&$name,)*];
    };
}

parameters! {
    /// Side of the cell.
    LENGTH: "cell.length", "Length", "L", Length, LENGTHS, None, POSITIVE;
    /// Points along a side.
    POINTS: "cell.points", "Points", "n", Pure(""), 4.0..=POINTS_MAX as f64, None,
        "an even number {range}, as in 64 or [64, 1], or \"auto\"";
    /// Modulus of the body, of a scene with units.
    CONTACT_MODULUS: "body.contact_modulus", "Contact modulus", "E*", Pure("units.modulus"), 1e-30..=1e30,
        None, POSITIVE;
    /// Work of adhesion.
    SURFACE_ENERGY: "law.surface_energy", "Surface energy", "γ", SurfaceEnergy, LENGTHS, None,
        POSITIVE;
    /// Range of the law.
    RANGE: "law.range", "Range", "ρ", Length, LENGTHS, None, POSITIVE;
    /// The mesh number in place of the range.
    MU_RHO: "law.mu_rho", "Mesh number", "μᵨ", Pure(""), 1e-30..=1e4, None, POSITIVE;
    /// Stiffness of the spring through which a stage pulls.
    STIFFNESS: "drive.stiffness", "Stiffness of the spring", "k", Stiffness, LENGTHS, None,
        POSITIVE;
    /// Where the drive begins and ends.
    START: "drive.start", "Start of the drive", "", Driven, -FAR..=FAR, None,
        "a finite number, {range}, as in 4.2";
    /// Where it turns.
    TURN: "drive.turn", "Turn of the drive", "", Driven, -FAR..=FAR, None,
        "a number below drive.start, {range}, or \"zero_load\"";
    /// Largest step.
    STEP: "drive.step", "Step of the drive", "", Driven, LENGTHS, None, POSITIVE;
    /// Relative error that the plan must meet.
    TARGET: "accuracy.target", "Accuracy", "", Pure(""), 1e-100..=BELOW_ONE, Some(Value::Number(0.01)),
        "a number above 0 and below 1, {range}, as in 0.01";
    /// Seed of the perturbations.
    SEED: "noise.seed", "Seed", "", Pure(""), 0.0..=SEED_MAX, Some(Value::Whole(1)), "a whole number \
        {range}";
    /// Temperature, of a scene with units.
    TEMPERATURE: "units.temperature", "Temperature", "T", Pure("K"), 1e-3..=1e5,
        Some(Value::Number(298.15)), POSITIVE;
}

/// The number of this key.
pub fn find(key: &str) -> Option<&'static Parameter> {
    all().into_iter().find(|parameter| parameter.key == key)
}

/// Every number of the scene file, in the order of its tables.
pub fn all() -> Vec<&'static Parameter> {
    let table = |name: &'static str| {
        OWN.iter()
            .copied()
            .filter(move |parameter| parameter.key.starts_with(name))
    };
    let mut all: Vec<_> = table("cell.").chain(table("body.")).collect();
    all.extend(Body::all().iter().flat_map(Body::parameters));
    all.extend(table("law."));
    all.extend(Shape::all().iter().flat_map(Shape::parameters));
    all.extend(Indenter::all().iter().flat_map(Indenter::parameters));
    all.extend(
        ["drive.", "accuracy.", "noise.", "units."]
            .into_iter()
            .flat_map(table),
    );
    all
}

impl Scene {
    /// Every number that the scene's file gives, with what is allowed of it.
    pub fn numbers(&self) -> Vec<(&'static Parameter, Value)> {
        let Self {
            cell,
            body,
            law,
            indenter,
            drive,
            accuracy,
            seed,
            units,
            ..
        } = &self.given();
        let mut numbers = Vec::new();
        // Without E* no other number has a meaning.
        if let Some(units) = units {
            let modulus = Value::Number(units.contact_modulus);
            numbers.push((&CONTACT_MODULUS, modulus));
            let temperature = Value::Number(units.temperature);
            numbers.push((&TEMPERATURE, temperature));
        }
        numbers.extend([
            (&LENGTH, Value::Number(cell.length)),
            (&SURFACE_ENERGY, Value::Number(law.surface_energy)),
            (&START, Value::Number(drive.start)),
            (&STEP, Value::Number(drive.step)),
            (&TARGET, Value::Number(*accuracy)),
            (&SEED, Value::Whole(*seed)),
        ]);
        if let Points::Square(n) | Points::Line(n) = cell.points {
            numbers.push((&POINTS, Value::Whole(n as u64)));
        }
        numbers.extend(body.parameters().iter().zip(body.values()));
        numbers.extend(law.shape.parameters().iter().zip(law.shape.values()));
        numbers.push(match law.range {
            Range::Length(range) => (&RANGE, Value::Number(range)),
            Range::MuRho(mu_rho) => (&MU_RHO, Value::Number(mu_rho)),
        });
        numbers.extend(indenter.parameters().iter().zip(indenter.values()));
        if let Control::Spring { stiffness } = drive.control {
            numbers.push((&STIFFNESS, Value::Number(stiffness)));
        }
        if let Turn::At(turn) = drive.turn {
            numbers.push((&TURN, Value::Number(turn)));
        }
        numbers
    }
}
