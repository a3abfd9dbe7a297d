//! The scene's own numbers, what is allowed of them, and what they mean: the units in which its file
//! gives them, and those in which results are told to people. The numbers of a law or a ground stand
//! with it ([`Own`](crate::physics::parameter::Own)); what ties two values together (a turn below its
//! start) is in [`super::Scene::model`].
//!
//! Inside, E* is 1 and a length is what the file gives, with units as without. What E* scales is
//! divided by it where a scene is read ([`Scene::taken`]) and multiplied where it is written
//! ([`Scene::given`]), so that a scene without units is not touched by a digit.

use super::{Drive, Model, Points, Range, Scene, Turn};
use crate::physics::body::Body;
use crate::physics::control::Control;
use crate::physics::indenter::Indenter;
use crate::physics::law::Shape;
use crate::physics::mesh::POINTS_MAX;
use crate::physics::parameter::Dimension::{Driven, Length, Pure, Stiffness, SurfaceEnergy};
use crate::physics::parameter::{
    BELOW_ONE, Dimension, LENGTHS, POSITIVE, Parameter, SEED_MAX, Value, parameter,
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

/// A unit by its word in the scene file, and the power of ten that it is of m, Pa or J/m^2.
#[derive(Debug, PartialEq, Eq)]
pub struct Word {
    /// As the file has it.
    pub word: &'static str,
    power: i32,
}

macro_rules! words {
    ($($word:literal = $power:literal),*) => { [$(Word { word: $word, power: $power }),*] };
}

/// Units of length.
pub static LENGTH_UNITS: [Word; 6] = words![
    "m" = 0,
    "mm" = -3,
    "um" = -6,
    "nm" = -9,
    "angstrom" = -10,
    "pm" = -12
];
/// Units of the contact modulus, and of every stress.
pub static MODULUS_UNITS: [Word; 4] = words!["Pa" = 0, "kPa" = 3, "MPa" = 6, "GPa" = 9];
/// Units of the surface energy, and of every energy per area.
pub static SURFACE_ENERGY_UNITS: [Word; 3] = words!["J/m^2" = 0, "mJ/m^2" = -3, "uJ/m^2" = -6];

impl Word {
    /// The unit of this word, with "µ" for "u" and "²" for "^2" as well.
    pub fn find(all: &'static [Self], word: &str) -> Option<&'static Self> {
        let plain = word.replace(['µ', 'μ'], "u").replace('²', "^2");
        all.iter().find(|known| known.word == plain)
    }
}

/// The units of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// Of lengths.
    pub length: &'static Word,
    /// Of the contact modulus and of stresses; over that of lengths, of stiffnesses per area.
    pub modulus: &'static Word,
    /// Of energies per area.
    pub surface_energy: &'static Word,
    /// E* in units of `modulus`.
    pub contact_modulus: f64,
    /// Temperature (K).
    pub temperature: f64,
}

/// What a scene without units may mean: a soft rubber whose law reaches a nanometre where it
/// reaches 1.
pub const SUGGESTED: Units = Units {
    length: &LENGTH_UNITS[3],
    modulus: &MODULUS_UNITS[2],
    surface_energy: &SURFACE_ENERGY_UNITS[1],
    contact_modulus: 100.0,
    temperature: 298.15,
};

/// Boltzmann's constant (J/K), exact since 2019 (SI Brochure, 9th edition).
const BOLTZMANN: f64 = 1.380649e-23;

/// x times 10^power, rounded once.
fn shifted(x: f64, power: i32) -> f64 {
    let factor = 10f64.powi(power.abs());
    if power < 0 { x / factor } else { x * factor }
}

impl Units {
    /// How many of the file's unit E* = 1 and a length of 1 make.
    fn file_factor(&self, of: Dimension) -> f64 {
        match of.powers() {
            [0, _] => 1.0,
            [_, 1] => shifted(
                self.contact_modulus,
                self.modulus.power + self.length.power - self.surface_energy.power,
            ),
            _ => self.contact_modulus,
        }
    }

    /// A number of the file with E* = 1.
    pub fn taken(&self, of: Dimension, given: f64) -> f64 {
        given / self.file_factor(of)
    }

    /// A number with E* = 1 in units of the file.
    pub fn given(&self, of: Dimension, taken: f64) -> f64 {
        taken * self.file_factor(of)
    }

    /// The same where [`Units::taken`] gives it back to the last bit, the shortest such number;
    /// if there is none the nearest.
    fn given_exactly(&self, of: Dimension, taken: f64) -> f64 {
        let near = self.given(of, taken);
        let short = [14, 15, 16].map(|digits| format!("{near:.digits$e}").parse().unwrap_or(near));
        let close = [near.next_down(), near.next_up()];
        short
            .into_iter()
            .chain(close)
            .find(|given| self.taken(of, *given) == taken)
            .unwrap_or(near)
    }

    /// The SI unit (m, Pa, J/m^2, Pa/m, J, N) that E* = 1 and a length of 1 make.
    pub fn si(&self, of: Dimension) -> f64 {
        let [modulus, length] = of.powers();
        let power = modulus * self.modulus.power + length * self.length.power;
        shifted(self.contact_modulus.powi(modulus), power)
    }

    /// kT (J).
    pub fn thermal_energy(&self) -> f64 {
        BOLTZMANN * self.temperature
    }

    /// A quantity (E* = 1) in SI with a prefix and three digits: "5.88 mJ/m²".
    pub fn say(&self, of: Dimension, value: f64) -> String {
        say(of, value * self.si(of))
    }

    /// What the file's numbers of a dimension are in.
    pub fn word(&self, of: Dimension) -> String {
        match of.powers() {
            [0, 0] => of.word().to_owned(),
            [0, _] => self.length.word.to_owned(),
            [_, 0] => self.modulus.word.to_owned(),
            [_, 1] => self.surface_energy.word.to_owned(),
            _ => format!("{}/{}", self.modulus.word, self.length.word),
        }
    }
}

/// A quantity in SI with a prefix and three digits.
pub fn say(of: Dimension, si: f64) -> String {
    let (name, power) = prefixed(of, si);
    format!("{} {name}", significant(shifted(si, -power)))
}

/// A number with so many decimals, and no sign before a zero.
pub fn fixed(value: f64, decimals: usize) -> String {
    unsigned_zero(format!("{value:.decimals$}"))
}

/// A number as text, without the sign of a zero.
pub fn unsigned_zero(text: String) -> String {
    match text.strip_prefix('-') {
        Some(zero) if !zero.contains(|c| ('1'..='9').contains(&c)) => zero.to_owned(),
        _ => text,
    }
}

/// A number with three digits.
pub fn significant(value: f64) -> String {
    let short = format!("{value:.2e}");
    // Rounding may have carried into one more digit.
    let size = short.parse().unwrap_or(value).abs();
    if size == 0.0 {
        return "0.00".to_owned();
    }
    if !(1e-3..1e4).contains(&size) {
        return short;
    }
    let power = size.log10().floor() as i32;
    format!("{value:.*}", (2 - power).max(0) as usize)
}

/// The unit, with the largest prefix that leaves one before the point, and its power of ten.
fn prefixed(of: Dimension, si: f64) -> (String, i32) {
    const PREFIXES: [&str; 13] = [
        "z", "a", "f", "p", "n", "µ", "m", "", "k", "M", "G", "T", "P",
    ];
    const LEAST: i32 = -21;
    let base = match of {
        Dimension::Length | Dimension::Driven => "m",
        Dimension::Stress => "Pa",
        Dimension::SurfaceEnergy => "J/m²",
        Dimension::Stiffness => "Pa/m",
        Dimension::Energy => "J",
        Dimension::Force => "N",
        Dimension::Pure(unit) => return (unit.to_owned(), 0),
    };
    // A number such as 1e-9 over 1e-9 may be a hair below 1.
    let tens = if si == 0.0 || !si.is_finite() {
        0.0
    } else {
        si.abs().log10() + 1e-12
    };
    let step =
        ((tens / 3.0).floor() as i32).clamp(LEAST / 3, LEAST / 3 + PREFIXES.len() as i32 - 1);
    let prefix = PREFIXES[(step - LEAST / 3) as usize];
    (format!("{prefix}{base}"), 3 * step)
}

/// In what a quantity is told to people: in its natural unit (the range, sigma_max, gamma), or in
/// one of SI.
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    /// Its name; `None` is the natural one.
    pub word: Option<String>,
    /// How many of them the natural unit makes.
    pub scale: f64,
}

impl Unit {
    /// The natural unit.
    pub const NATURAL: Self = Self {
        word: None,
        scale: 1.0,
    };

    /// A number of natural units with its unit, in as fine steps as with so many `decimals` of
    /// natural units, which are called `natural`.
    pub fn say(&self, number: f64, decimals: usize, natural: &str) -> String {
        format!("{} {}", self.number(number, decimals), self.name(natural))
    }

    /// The same without the unit.
    pub fn number(&self, number: f64, decimals: usize) -> String {
        // A scale such as 100 may be a hair below.
        let fewer = (self.scale.log10() + 1e-9).floor().clamp(-20.0, 20.0) as i32;
        let decimals = (decimals as i32 - fewer).max(0) as usize;
        fixed(number * self.scale, decimals)
    }

    /// The unit's name, of the natural one `natural`.
    pub fn name<'a>(&'a self, natural: &'a str) -> &'a str {
        self.word.as_deref().unwrap_or(natural)
    }

    /// What is told, with its unit, as an axis has it; `natural` where the unit is natural.
    pub fn label(&self, natural: &str, quantity: &str) -> String {
        match &self.word {
            None => natural.to_owned(),
            Some(unit) => format!("{quantity} ({unit})"),
        }
    }
}

impl Model {
    /// In what lengths of the gap (natural: the range), stresses (sigma_max) and energies per area
    /// (gamma) are told.
    pub fn unit(&self, of: Dimension) -> Unit {
        self.unit_for(of, self.natural(of))
    }

    /// In what lengths along the cell are told (natural: the range).
    pub fn unit_across(&self) -> Unit {
        self.unit_for(Dimension::Length, self.grid.length)
    }

    /// In what barriers are told (natural: gamma per area): with units in kT a square cell.
    pub fn unit_of_barriers(&self) -> Unit {
        let Some(kt) = self.in_kt(self.law.surface_energy) else {
            return self.unit(Dimension::SurfaceEnergy);
        };
        const POWERS: [&str; 7] = ["", "10³ ", "10⁶ ", "10⁹ ", "10¹² ", "10¹⁵ ", "10¹⁸ "];
        // Barriers are a thousandth of gamma and less, and rarely more than a tenth.
        let step = ((0.01 * kt).log10() / 3.0).floor().clamp(0.0, 6.0) as usize;
        Unit {
            word: Some(format!("{}kT", POWERS[step])),
            scale: shifted(kt, -3 * step as i32),
        }
    }

    /// An energy per area (E* times length) of a whole square cell in kT; `None` without units, and
    /// of a line cell, which has no depth.
    pub fn in_kt(&self, energy: f64) -> Option<f64> {
        let units = self.units?;
        let energy = self.of_cell(energy)? * units.si(Dimension::Energy);
        Some(energy / units.thermal_energy())
    }

    /// A quantity per area of a whole square cell; `None` of a line cell.
    pub fn of_cell(&self, per_area: f64) -> Option<f64> {
        let area = self.grid.length * self.grid.length;
        (!self.grid.is_line()).then_some(per_area * area)
    }

    /// What is 1 in natural units: the range, sigma_max, gamma.
    fn natural(&self, of: Dimension) -> f64 {
        match of {
            Dimension::Stress => self.law.traction_max(),
            Dimension::SurfaceEnergy => self.law.surface_energy,
            _ => self.law.range,
        }
    }

    /// With the prefix that suits a `typical` value.
    fn unit_for(&self, of: Dimension, typical: f64) -> Unit {
        let Some(units) = self.units else {
            return Unit::NATURAL;
        };
        let si = units.si(of);
        let (name, power) = prefixed(of, typical * si);
        Unit {
            word: Some(name),
            scale: shifted(self.natural(of) * si, -power),
        }
    }
}

impl Scene {
    /// What is driven: a length, or the stress of a load.
    pub fn driven(&self) -> Dimension {
        match self.drive.control {
            Control::Load => Dimension::Stress,
            _ => Dimension::Length,
        }
    }

    /// The dimension of a parameter of this scene.
    fn resolved(&self, of: Dimension) -> Dimension {
        if of == Dimension::Driven {
            self.driven()
        } else {
            of
        }
    }

    /// A number of this scene's file with E* = 1.
    pub fn number_taken(&self, of: Dimension, given: f64) -> f64 {
        let taken = |units: Units| units.taken(self.resolved(of), given);
        self.units.map_or(given, taken)
    }

    /// A number with E* = 1 as this scene's file gives it.
    pub fn number_given(&self, of: Dimension, taken: f64) -> f64 {
        let given = |units: Units| units.given(self.resolved(of), taken);
        self.units.map_or(taken, given)
    }

    /// The scene with the numbers of its file: what E* scales is in its units.
    pub fn given(&self) -> Self {
        self.turned(Units::given_exactly)
    }

    /// Of the numbers of a file: the scene with E* = 1; inverts [`Scene::given`].
    pub fn taken(&self) -> Self {
        self.turned(Units::taken)
    }

    /// The scene on a body of another modulus: every number of its file stays what it is. Without
    /// units nothing changes.
    pub fn with_contact_modulus(&self, contact_modulus: f64) -> Self {
        let mut given = self.given();
        given.units = given.units.map(|units| Units {
            contact_modulus,
            ..units
        });
        given.taken()
    }

    fn turned(&self, number: fn(&Units, Dimension, f64) -> f64) -> Self {
        let mut scene = self.clone();
        let Some(units) = &self.units else {
            return scene;
        };
        scene.law.surface_energy = number(units, Dimension::SurfaceEnergy, self.law.surface_energy);
        let Drive {
            control,
            start,
            turn,
            step,
        } = self.drive;
        let driven = |value: f64| number(units, self.driven(), value);
        scene.drive = Drive {
            control: match control {
                Control::Spring { stiffness } => Control::Spring {
                    stiffness: number(units, Dimension::Stiffness, stiffness),
                },
                other => other,
            },
            start: driven(start),
            turn: match turn {
                Turn::At(turn) => Turn::At(driven(turn)),
                Turn::ZeroLoad => Turn::ZeroLoad,
            },
            step: driven(step),
        };
        scene
    }
}
