//! Every number of a scene file: its key, what it means, and the range in which it is allowed.
//!
//! The reader, the checks of a scene, the control panel and the guide's table are made from this list. Ranges are wide: they keep
//! squares, products and counts finite, and refuse nothing that can be computed. What ties two values together (a turn below its
//! start) is in [`crate::scene::Scene::model`].

use crate::physics::roughness::WAVES_MAX;
use std::ops::RangeInclusive;

/// A value of the scene that is not allowed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{key} = {value}: {allowed}")]
pub struct SceneError {
    /// Dotted key, as in `cell.points`.
    pub key: String,
    /// The offending value.
    pub value: String,
    /// What is allowed, and so how to mend it.
    pub allowed: String,
}

/// A number of the scene file.
#[derive(Debug)]
pub struct Parameter {
    /// Dotted key, as in `cell.length`.
    pub key: &'static str,
    /// Its name for people.
    pub label: &'static str,
    /// Its letter.
    pub symbol: &'static str,
    /// Its unit in words, with E* = 1; empty for a pure number.
    pub unit: &'static str,
    /// Least and greatest value.
    pub range: RangeInclusive<f64>,
    /// What it is where the file does not say; `None` where it must.
    pub default: Option<f64>,
    /// What is allowed, with an example; `{range}` stands for the range in words.
    pub hint: &'static str,
}

/// Lengths, in any unit: their squares stay far from overflow and underflow.
const LENGTHS: RangeInclusive<f64> = 1e-110..=1e110;
/// Largest magnitude of a mean displacement.
const FAR: f64 = 1e110;
/// The largest number below 1.
const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;
/// What a positive number is called.
const POSITIVE: &str = "a finite number above 0, {range}";
/// Largest number of points along one side.
pub const POINTS_MAX: usize = 4096;
/// The largest integer of TOML, 2^63 - 1, as near as a double comes to it.
const SEED_MAX: f64 = i64::MAX as f64;

macro_rules! parameters {
    ($($(#[$doc:meta])* $name:ident: $key:literal, $label:literal, $symbol:literal, $unit:literal, $range:expr, $default:expr, $hint:expr;)*) => {
        $($(#[$doc])* pub static $name: Parameter = Parameter {
            key: $key, label: $label, symbol: $symbol, unit: $unit, range: $range, default: $default, hint: $hint,
        };)*

        /// Every number of the scene file, in the order of its tables.
        pub static ALL: &[&Parameter] = &[$(&$name,)*];
    };
}

parameters! {
    /// Side of the cell.
    LENGTH: "cell.length", "Length", "L", "length", LENGTHS, None, POSITIVE;
    /// Points along a side.
    POINTS: "cell.points", "Points", "n", "", 4.0..=POINTS_MAX as f64, None,
        "an even number {range}, as in 64 or [64, 1], or \"auto\"";
    /// Work of adhesion.
    SURFACE_ENERGY: "law.surface_energy", "Surface energy", "γ", "E* times length", LENGTHS, None, POSITIVE;
    /// Range of the law.
    RANGE: "law.range", "Range", "ρ", "length", LENGTHS, None, POSITIVE;
    /// The mesh number in place of the range.
    MU_RHO: "law.mu_rho", "Mesh number", "μᵨ", "", 1e-30..=1e4, None, POSITIVE;
    /// Exponent of a Mie law's repulsion.
    MIE_M: "law.m", "Mie exponent", "m", "", 1e-9..=100.0, None, "a number above law.n, {range}, as in 8";
    /// Exponent of a Mie law's attraction.
    MIE_N: "law.n", "Mie exponent", "n", "", 1e-9..=100.0, None, "a finite number above 0, {range}, as in 2";
    /// Range of the repulsion over that of the attraction.
    RATIO: "law.ratio", "Ratio of ranges", "", "", 1e-6..=BELOW_ONE, None,
        "a number above 0 and below 1, {range} (repulsive over attractive range)";
    /// Radius of a tip.
    RADIUS: "indenter.radius", "Tip radius", "R", "length", LENGTHS, None, POSITIVE;
    /// Amplitude of waves.
    AMPLITUDE: "indenter.amplitude", "Amplitude", "", "length", LENGTHS, None, POSITIVE;
    /// Waves on the side of the cell.
    PERIODS: "indenter.periods", "Waves", "", "", 0.0..=(POINTS_MAX / 4) as f64, None,
        "a whole number of waves along x, or along x and y as in [2, 1], each {range}";
    /// Hurst exponent.
    HURST: "indenter.hurst", "Hurst exponent", "", "", 1e-12..=1.0, None, "a number above 0, at most 1, {range}, as in 0.8";
    /// Root mean square height.
    RMS: "indenter.rms", "RMS height", "", "length", LENGTHS, None, "the root mean square height, a finite number above 0, {range}";
    /// Longest wave of the self-affine part.
    LONGEST: "indenter.longest", "Longest wave", "", "length", LENGTHS, None, "a wavelength, at most cell.length, {range}";
    /// Shortest wave.
    SHORTEST: "indenter.shortest", "Shortest wave", "", "length", LENGTHS, None,
        "a wavelength from cell.length/512 to indenter.longest, {range}";
    /// Seed of a rough surface.
    GROUND_SEED: "indenter.seed", "Surface seed", "", "", 0.0..=SEED_MAX, Some(1.0), "a whole number {range}";
    /// Where the drive begins and ends.
    START: "drive.start", "Start of", "u₀", "length", -FAR..=FAR, None, "a finite number, {range}, as in 4.2";
    /// Where it turns.
    TURN: "drive.turn", "Turn of", "u₀", "length", -FAR..=FAR, None, "a number below drive.start, {range}, or \"zero_load\"";
    /// Largest step.
    STEP: "drive.step", "Step of", "u₀", "length", LENGTHS, None, POSITIVE;
    /// Relative error that the plan must meet.
    TARGET: "accuracy.target", "Accuracy", "", "", 1e-100..=BELOW_ONE, Some(0.01), "a number above 0 and below 1, {range}, as in 0.01";
    /// Seed of the perturbations.
    SEED: "noise.seed", "Seed", "", "", 0.0..=SEED_MAX, Some(1.0), "a whole number {range}";
}

// The hint of `SHORTEST` quotes it.
const _: () = assert!(WAVES_MAX == 512);

impl Parameter {
    /// The last part of the key, as it stands inside its table.
    pub fn name(&self) -> &'static str {
        self.key.rsplit('.').next().unwrap_or(self.key)
    }

    /// Its name with its letter.
    pub fn title(&self) -> String {
        format!("{} {}", self.label, self.symbol).trim_end().to_owned()
    }

    /// What is allowed, in words.
    pub fn allowed(&self) -> String {
        let range = format!("from {} to {}", number(*self.range.start()), number(*self.range.end()));
        self.hint.replace("{range}", &range)
    }

    /// The value itself.
    ///
    /// # Errors
    /// A value that is out of range, or no number.
    pub fn check(&self, value: f64) -> Result<f64, SceneError> {
        if self.range.contains(&value) { Ok(value) } else { Err(self.refuse(number(value))) }
    }

    /// The refusal of a value.
    pub fn refuse(&self, value: impl std::fmt::Display) -> SceneError {
        SceneError { key: self.key.to_owned(), value: value.to_string(), allowed: format!("allowed is {}", self.allowed()) }
    }
}

/// A number as people write it.
pub(super) fn number(x: f64) -> String {
    let size = x.abs();
    if x == SEED_MAX {
        i64::MAX.to_string()
    } else if size == 0.0 || (1e-3..1e10).contains(&size) {
        x.to_string()
    } else {
        format!("{x:e}")
    }
}

/// The guide's table of all parameters (Markdown).
pub fn table() -> String {
    let mut text = "| key | name | unit | where the file says nothing | allowed |\n|---|---|---|---|---|\n".to_owned();
    for parameter in ALL {
        let default = parameter.default.map_or_else(|| "must be given".to_owned(), number);
        let Parameter { key, unit, .. } = parameter;
        text += &format!("| `{key}` | {} | {unit} | {default} | {} |\n", parameter.title(), parameter.allowed());
    }
    text
}
