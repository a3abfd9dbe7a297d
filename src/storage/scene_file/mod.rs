//! The scene file (`format = 1`): TOML in, [`Scene`] out, and back.
//!
//! Read by hand over the parsed table, so that every refusal names the file, the key, its value and
//! what is allowed.

mod read;

use super::{Failure, files};
use crate::physics::control::Control;
use crate::physics::indenter::Indenter;
use crate::physics::parameter::{Parameter, Refusal, Value as Own};
use crate::scene::parameter;
use crate::scene::{Points, Range, Scene, Turn};
use std::io::Read;
use std::path::Path;
use toml::Value;

pub use read::parse;

/// The version of the scene file that this program reads and writes.
pub const FORMAT: i64 = 1;

/// Longest scene file that is read, in bytes.
pub const BYTES_MAX: u64 = 1 << 20;

/// The key of a height file.
const FILE: &str = "file";

/// Reads a scene from a file.
///
/// # Errors
/// A file that cannot be read or is not an allowed scene.
pub fn load(path: &Path) -> Result<Scene, Failure> {
    scene_of(path, files::read_bytes(path, BYTES_MAX)?)
}

/// The scene in a text that comes from a `source`, as the clipboard or standard input.
///
/// # Errors
/// What cannot be read, is too long, or no allowed scene.
pub fn received(source: &str, text: impl Read) -> Result<Scene, Failure> {
    let (path, mut bytes) = (Path::new(source), Vec::new());
    let read = text.take(BYTES_MAX + 1).read_to_end(&mut bytes);
    let remedy = "send the text of a scene file";
    read.map_err(|error| Failure::unreadable(path, &error.to_string(), remedy))?;
    scene_of(path, bytes)
}

/// The scene of a file that has been read.
///
/// # Errors
/// What is too long, not UTF-8, or no allowed scene.
pub(super) fn scene_of(path: &Path, bytes: Vec<u8>) -> Result<Scene, Failure> {
    if bytes.len() as u64 > BYTES_MAX {
        return Err(Failure::too_long(path, BYTES_MAX));
    }
    parse(&text_of(path, bytes)?, &path.display().to_string())
}

/// The text in the bytes of a file.
pub(super) fn text_of(path: &Path, bytes: Vec<u8>) -> Result<String, Failure> {
    String::from_utf8(bytes)
        .map_err(|_| Failure::unreadable(path, "not UTF-8", "save it as UTF-8 text"))
}

/// Writes a scene to a file; a scene that [`load`] would refuse is not written. A height file in its
/// folder or below is named from there, so that both can move together.
///
/// # Errors
/// A scene that is not allowed, or a file that cannot be written.
pub fn save(path: &Path, scene: &Scene) -> Result<(), Failure> {
    let folder = std::path::absolute(path).ok();
    let text = text_in(scene, folder.as_deref().and_then(Path::parent));
    parse(&text, &path.display().to_string())?;
    files::write_whole(path, text.as_bytes())
}

/// The refusal of a value by the scene itself, with the file it came from.
pub fn refused(file: &str, error: Refusal) -> Failure {
    Failure::value(file, &error.key, &error.value, &error.allowed)
}

/// The scene file of a scene; [`parse`] gives the same scene back. A height file has its whole path.
pub fn to_text(scene: &Scene) -> String {
    text_in(scene, None)
}

/// The same, with the height file named from this `folder` if it lies in there.
fn text_in(scene: &Scene, folder: Option<&Path>) -> String {
    let scene = &scene.given();
    let ground = &scene.indenter;
    let mut text = format!("format = {FORMAT}\n");
    let mut line = |key: &str, value: Value| text.push_str(&format!("{key} = {value}\n"));
    line("title", scene.title.as_str().into());
    line("source", scene.source.as_str().into());
    for (name, keys) in [
        ("cell", cell(scene)),
        ("body", body(scene)),
        ("law", law(scene)),
        ("indenter", indenter(ground, folder)),
        ("drive", drive(scene)),
        ("accuracy", vec![("target", scene.accuracy.into())]),
        ("noise", vec![("seed", seed(scene.seed))]),
        ("units", units(scene)),
    ] {
        if keys.is_empty() {
            continue;
        }
        text.push_str(&format!("\n[{name}]\n"));
        for (key, value) in keys {
            text.push_str(&format!("{key} = {value}\n"));
        }
    }
    text
}

/// The same as JSON.
pub fn to_json(scene: &Scene) -> String {
    let table: toml::Table = to_text(scene).parse().expect("just written");
    serde_json::to_string_pretty(&table).expect("tables of numbers and words")
}

type Keys = Vec<(&'static str, Value)>;

fn cell(scene: &Scene) -> Keys {
    let points = match scene.cell.points {
        Points::Auto => "auto".into(),
        Points::Square(n) => whole(n),
        Points::Line(n) => Value::Array(vec![whole(n), whole(1)]),
    };
    vec![("length", scene.cell.length.into()), ("points", points)]
}

fn body(scene: &Scene) -> Keys {
    let body = &scene.body;
    let modulus = scene.units.map(|units| {
        let value = units.contact_modulus.into();
        (parameter::CONTACT_MODULUS.name(), value)
    });
    let own = kind(body.word(), body.parameters(), &body.values());
    own.into_iter().chain(modulus).collect()
}

/// What the numbers are in; nothing of a scene without units.
fn units(scene: &Scene) -> Keys {
    scene.units.map_or_else(Vec::new, |units| {
        vec![
            ("length", units.length.word.into()),
            ("modulus", units.modulus.word.into()),
            ("energy", units.surface_energy.word.into()),
            (parameter::TEMPERATURE.name(), units.temperature.into()),
        ]
    })
}

fn law(scene: &Scene) -> Keys {
    let shape = &scene.law.shape;
    let mut keys = kind(shape.word(), shape.parameters(), &shape.values());
    keys.push(("surface_energy", scene.law.surface_energy.into()));
    keys.push(match scene.law.range {
        Range::Length(range) => ("range", range.into()),
        Range::MuRho(mu_rho) => ("mu_rho", mu_rho.into()),
    });
    keys
}

/// A kind of body, law or ground, with what only this kind has.
fn kind(word: &str, parameters: &'static [Parameter], values: &[Own]) -> Keys {
    let value = |value: &Own| match *value {
        Own::Number(x) => x.into(),
        Own::Whole(n) => seed(n),
        Own::Counts([x, 0]) => whole(x),
        Own::Counts([x, y]) => Value::Array(vec![whole(x), whole(y)]),
        Own::Flag(flag) => flag.into(),
        Own::Choice { chosen, words } => words[chosen].into(),
    };
    let names = parameters.iter().map(Parameter::name);
    std::iter::once(("kind", word.into()))
        .chain(names.zip(values.iter().map(value)))
        .collect()
}

fn indenter(ground: &Indenter, folder: Option<&Path>) -> Keys {
    let mut keys = kind(ground.word(), ground.parameters(), &ground.values());
    if let Indenter::Measured(measured) = ground {
        let file = &measured.topography().file;
        let inside = folder.and_then(|folder| file.strip_prefix(folder).ok());
        let path = inside.unwrap_or(file).to_string_lossy().into_owned();
        keys.insert(1, (FILE, path.into()));
    }
    keys
}

fn drive(scene: &Scene) -> Keys {
    let turn = match scene.drive.turn {
        Turn::At(turn) => turn.into(),
        Turn::ZeroLoad => "zero_load".into(),
    };
    let mut keys: Keys = Vec::new();
    if scene.drive.control.frees_mean() {
        keys.push(("control", scene.drive.control.word().into()));
    }
    if let Control::Spring { stiffness } = scene.drive.control {
        keys.push((parameter::STIFFNESS.name(), stiffness.into()));
    }
    keys.extend([
        ("start", scene.drive.start.into()),
        ("turn", turn),
        ("step", scene.drive.step.into()),
    ]);
    keys
}

/// A count; TOML has no integers beyond 2^63 - 1, and no allowed scene has such a count.
fn whole(n: usize) -> Value {
    Value::Integer(i64::try_from(n).unwrap_or(i64::MAX))
}

/// A seed; beyond 2^63 - 1, which the reader refuses, it is kept as a text that says so.
fn seed(seed: u64) -> Value {
    i64::try_from(seed).map_or_else(|_| Value::String(seed.to_string()), Value::Integer)
}
