//! From the text of a scene file to a scene.

use super::section::{Section, finite};
use super::{FORMAT, refused};
use crate::experiment::scene::{Cell, Drive, LawChoice, POINTS_MAX, Points, Range, Scene, Turn};
use crate::physics::indenter::Indenter;
use crate::physics::law::{Cosine, DoubleExponential, Mie, Morse, Shape};
use crate::physics::roughness::Roughness;
use crate::storage::Failure;
use toml::{Table, Value};

const POSITIVE: &str = "a finite number above 0";
const SEED: &str = "a whole number from 0 to 9223372036854775807";
/// Accuracy asked for where the file says nothing.
const ACCURACY: f64 = 0.01;
/// Seed where the file says nothing.
const DEFAULT_SEED: u64 = 1;

/// Reads a scene from the text of a scene file; `file_name` is only used in messages.
///
/// # Errors
/// Anything that is not an allowed scene: syntax, unknown or missing keys, wrong types, values out of range.
pub fn parse(text: &str, file_name: &str) -> Result<Scene, Failure> {
    let table: Table = text.parse().map_err(|error| syntax(text, file_name, &error))?;
    let root = Section::root(file_name, &table);
    format_version(&root)?;
    root.only(&["format", "title", "source", "cell", "law", "indenter", "drive", "accuracy", "noise"])?;
    let scene = Scene {
        title: root.text_or("title", "untitled")?,
        source: root.text_or("source", "")?,
        cell: cell(&root.required("cell", "length and points")?)?,
        law: law(&root.required("law", "kind, surface_energy, and range or mu_rho")?)?,
        indenter: root.inside("indenter")?.map_or(Ok(Indenter::Flat), |section| indenter(&section))?,
        drive: drive(&root.required("drive", "start, turn and step")?)?,
        accuracy: root.inside("accuracy")?.map_or(Ok(ACCURACY), |section| accuracy(&section))?,
        seed: root.inside("noise")?.map_or(Ok(DEFAULT_SEED), |section| noise(&section))?,
    };
    scene.validate().map_err(|error| refused(file_name, error))?;
    Ok(scene)
}

fn syntax(text: &str, file_name: &str, error: &toml::de::Error) -> Failure {
    let at = error.span().map_or(0, |span| span.start).min(text.len());
    let before = String::from_utf8_lossy(&text.as_bytes()[..at]);
    let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
    Failure::Syntax {
        file: file_name.to_owned(),
        line: before.matches('\n').count() + 1,
        column: before[line_start..].chars().count() + 1,
        message: error.message().split_whitespace().collect::<Vec<_>>().join(" "),
    }
}

fn format_version(root: &Section<'_>) -> Result<(), Failure> {
    let value = root.value("format", "format = 1 as the first line of a scene file")?;
    if value.as_integer() == Some(FORMAT) {
        return Ok(());
    }
    Err(root.refuse("format", value, "allowed is 1, the only version that this program reads"))
}

fn cell(section: &Section<'_>) -> Result<Cell, Failure> {
    section.only(&["length", "points"])?;
    Ok(Cell { length: section.number("length", POSITIVE)?, points: points(section)? })
}

fn points(section: &Section<'_>) -> Result<Points, Failure> {
    let allowed = format!("an even number from 4 to {POINTS_MAX}, as in 64 or [64, 1], or \"auto\"");
    let value = section.value("points", &allowed)?;
    let whole = |value: &Value| value.as_integer().and_then(|n| usize::try_from(n).ok());
    let parsed = match value {
        Value::String(word) if word == "auto" => Some(Points::Auto),
        Value::Array(sides) => match sides.iter().map(whole).collect::<Option<Vec<_>>>().as_deref() {
            Some([n, 1]) => Some(Points::Line(*n)),
            Some([n, m]) if n == m => Some(Points::Square(*n)),
            _ => None,
        },
        other => whole(other).map(Points::Square),
    };
    parsed.ok_or_else(|| section.refuse("points", value, &format!("allowed is {allowed}")))
}

fn law(section: &Section<'_>) -> Result<LawChoice, Failure> {
    let words: Vec<_> = Shape::all().iter().map(Shape::word).collect();
    let kind = section.text("kind", &format!("one of \"{}\"", words.join("\", \"")))?;
    let (shape, own): (_, &[&str]) = match kind {
        "morse" => (Ok(Shape::Morse(Morse)), &[]),
        "mie" => (mie(section), &["m", "n"]),
        "cosine" => (section.flag_or("smooth", false).map(|smooth| Shape::Cosine(Cosine { smooth })), &["smooth"]),
        "double_exponential" => (double_exponential(section), &["ratio"]),
        _ => return Err(section.refuse_word("kind", kind, &words)),
    };
    section.only(&[&["kind", "surface_energy", "range", "mu_rho"], own].concat())?;
    let shape = shape?;
    let surface_energy = section.number("surface_energy", POSITIVE)?;
    Ok(LawChoice { shape, surface_energy, range: range(section)? })
}

fn mie(section: &Section<'_>) -> Result<Shape, Failure> {
    let m = section.number("m", "a number above law.n, at most 100, as in 8")?;
    Ok(Shape::Mie(Mie { m, n: section.number("n", "a finite number above 0, as in 2")? }))
}

fn double_exponential(section: &Section<'_>) -> Result<Shape, Failure> {
    let ratio = section.number("ratio", "a number above 0 and below 1 (repulsive over attractive range)")?;
    Ok(Shape::DoubleExponential(DoubleExponential { ratio }))
}

fn range(section: &Section<'_>) -> Result<Range, Failure> {
    match (section.has("range"), section.has("mu_rho")) {
        (true, false) => Ok(Range::Length(section.number("range", POSITIVE)?)),
        (false, true) => Ok(Range::MuRho(section.number("mu_rho", POSITIVE)?)),
        (false, false) => Err(section.missing("range", "a finite number above 0, or mu_rho in its place")),
        (true, true) => {
            let value = section.value("mu_rho", POSITIVE)?;
            Err(section.refuse("mu_rho", value, "not together with law.range; remove one of the two"))
        }
    }
}

fn indenter(section: &Section<'_>) -> Result<Indenter, Failure> {
    let words = ["flat", "hertz", "wave", "rough"];
    match section.text("kind", "one of \"flat\", \"hertz\", \"wave\", \"rough\"")? {
        "flat" => section.only(&["kind"]).map(|()| Indenter::Flat),
        "hertz" => {
            section.only(&["kind", "radius"])?;
            Ok(Indenter::Hertz { radius: section.number("radius", POSITIVE)? })
        }
        "wave" => {
            section.only(&["kind", "amplitude", "periods"])?;
            Ok(Indenter::Wave { amplitude: section.number("amplitude", POSITIVE)?, periods: periods(section)? })
        }
        "rough" => {
            section.only(&["kind", "hurst", "rms", "longest", "shortest", "seed"])?;
            Ok(Indenter::Rough(Roughness {
                hurst: section.number("hurst", "a number above 0, at most 1, as in 0.8")?,
                rms: section.number("rms", "the root mean square height, a finite number above 0")?,
                longest: section.number("longest", "a wavelength, at most cell.length")?,
                shortest: section.number("shortest", "a wavelength, at most indenter.longest")?,
                seed: seed(section)?,
            }))
        }
        other => Err(section.refuse_word("kind", other, &words)),
    }
}

fn periods(section: &Section<'_>) -> Result<[usize; 2], Failure> {
    let allowed = "a whole number of waves along x, or along x and y as in [2, 1]";
    let value = section.value("periods", allowed)?;
    let whole = |value: &Value| value.as_integer().and_then(|n| usize::try_from(n).ok());
    let parsed = match value {
        Value::Array(both) => match both.iter().map(whole).collect::<Option<Vec<_>>>().as_deref() {
            Some([x, y]) => Some([*x, *y]),
            _ => None,
        },
        other => whole(other).map(|x| [x, 0]),
    };
    parsed.ok_or_else(|| section.refuse("periods", value, &format!("allowed is {allowed}")))
}

fn drive(section: &Section<'_>) -> Result<Drive, Failure> {
    section.only(&["start", "turn", "step"])?;
    let start = section.number("start", "a finite number")?;
    let allowed = "a number below drive.start, or \"zero_load\"";
    let turn = match section.value("turn", allowed)? {
        Value::String(word) if word == "zero_load" => Turn::ZeroLoad,
        value => {
            let at = finite(value).ok_or_else(|| section.refuse("turn", value, &format!("allowed is {allowed}")))?;
            Turn::At(at)
        }
    };
    Ok(Drive { start, turn, step: section.number("step", POSITIVE)? })
}

fn accuracy(section: &Section<'_>) -> Result<f64, Failure> {
    section.only(&["target"])?;
    if section.has("target") { section.number("target", "a number above 0 and below 1, as in 0.01") } else { Ok(ACCURACY) }
}

fn noise(section: &Section<'_>) -> Result<u64, Failure> {
    section.only(&["seed"])?;
    seed(section)
}

fn seed(section: &Section<'_>) -> Result<u64, Failure> {
    if !section.has("seed") {
        return Ok(DEFAULT_SEED);
    }
    let value = section.value("seed", SEED)?;
    let seed = value.as_integer().and_then(|seed| u64::try_from(seed).ok());
    seed.ok_or_else(|| section.refuse("seed", value, &format!("allowed is {SEED}")))
}
