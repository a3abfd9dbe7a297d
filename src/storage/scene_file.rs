//! The scene file (`format = 1`): TOML in, [`Scene`] out, and back.
//!
//! Read by hand over the parsed table, so that every refusal names the file, the key, its value and
//! what is allowed.

use super::failure::{self, Section, finite};
use super::{Failure, files, heights};
use crate::physics::body::Body;
use crate::physics::control::Control;
use crate::physics::indenter::Indenter;
use crate::physics::law::Shape;
use crate::physics::parameter::{Parameter, Refusal, Value as Own};
use crate::scene::parameter::{LENGTH_UNITS, MODULUS_UNITS, SURFACE_ENERGY_UNITS, Units, Word};
use crate::scene::{Cell, Drive, LawChoice, Points, Range, Scene, Turn, parameter};
use std::io::Read;
use std::path::Path;
use toml::Value;

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
        ("cell", cell_keys(scene)),
        ("body", body_keys(scene)),
        ("law", law_keys(scene)),
        ("indenter", indenter_keys(ground, folder)),
        ("drive", drive_keys(scene)),
        ("accuracy", vec![("target", scene.accuracy.into())]),
        ("noise", vec![("seed", seed_value(scene.seed))]),
        ("units", units_keys(scene)),
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

fn cell_keys(scene: &Scene) -> Keys {
    let points = match scene.cell.points {
        Points::Auto => "auto".into(),
        Points::Square(n) => count(n),
        Points::Line(n) => Value::Array(vec![count(n), count(1)]),
    };
    vec![("length", scene.cell.length.into()), ("points", points)]
}

fn body_keys(scene: &Scene) -> Keys {
    let body = &scene.body;
    let modulus = scene.units.map(|units| {
        let value = units.contact_modulus.into();
        (parameter::CONTACT_MODULUS.name(), value)
    });
    let own = kind_keys(body.word(), body.parameters(), &body.values());
    own.into_iter().chain(modulus).collect()
}

/// What the numbers are in; nothing of a scene without units.
fn units_keys(scene: &Scene) -> Keys {
    scene.units.map_or_else(Vec::new, |units| {
        vec![
            ("length", units.length.word.into()),
            ("modulus", units.modulus.word.into()),
            ("energy", units.surface_energy.word.into()),
            (parameter::TEMPERATURE.name(), units.temperature.into()),
        ]
    })
}

fn law_keys(scene: &Scene) -> Keys {
    let shape = &scene.law.shape;
    let mut keys = kind_keys(shape.word(), shape.parameters(), &shape.values());
    keys.push(("surface_energy", scene.law.surface_energy.into()));
    keys.push(match scene.law.range {
        Range::Length(range) => ("range", range.into()),
        Range::MuRho(mu_rho) => ("mu_rho", mu_rho.into()),
    });
    keys
}

/// A kind of body, law or ground, with what only this kind has.
fn kind_keys(word: &str, parameters: &'static [Parameter], values: &[Own]) -> Keys {
    let value = |value: &Own| match *value {
        Own::Number(x) => x.into(),
        Own::Whole(n) => seed_value(n),
        Own::Counts([x, 0]) => count(x),
        Own::Counts([x, y]) => Value::Array(vec![count(x), count(y)]),
        Own::Flag(flag) => flag.into(),
        Own::Choice { chosen, words } => words[chosen].into(),
    };
    let names = parameters.iter().map(Parameter::name);
    std::iter::once(("kind", word.into()))
        .chain(names.zip(values.iter().map(value)))
        .collect()
}

fn indenter_keys(ground: &Indenter, folder: Option<&Path>) -> Keys {
    let mut keys = kind_keys(ground.word(), ground.parameters(), &ground.values());
    if let Indenter::Measured(measured) = ground {
        let file = &measured.topography().file;
        let inside = folder.and_then(|folder| file.strip_prefix(folder).ok());
        let path = inside.unwrap_or(file).to_string_lossy().into_owned();
        keys.insert(1, (FILE, path.into()));
    }
    keys
}

fn drive_keys(scene: &Scene) -> Keys {
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
fn count(n: usize) -> Value {
    Value::Integer(i64::try_from(n).unwrap_or(i64::MAX))
}

/// A seed; beyond 2^63 - 1, which the reader refuses, it is kept as a text that says so.
fn seed_value(seed: u64) -> Value {
    i64::try_from(seed).map_or_else(|_| Value::String(seed.to_string()), Value::Integer)
}

/// Reads a scene from the text of a scene file; `file_name` is used in messages, and a height file is
/// looked for from its folder.
///
/// # Errors
/// Anything that is not an allowed scene: syntax, unknown or missing keys, wrong types, values out
/// of range.
pub fn parse(text: &str, file_name: &str) -> Result<Scene, Failure> {
    let table = failure::table(text, file_name)?;
    let root = Section::root(file_name, &table);
    root.format_version(FORMAT, "a scene file")?;
    root.only(&[
        "format", "title", "source", "cell", "body", "law", "indenter", "drive", "accuracy",
        "noise", "units",
    ])?;
    let body_table = root.inside("body")?;
    let given = Scene {
        title: root.text_or("title", "untitled")?,
        source: root.text_or("source", "")?,
        cell: cell(&root.required("cell", "length and points")?)?,
        body: body_table.as_ref().map_or(Ok(Body::HalfSpace), body)?,
        law: law(&root.required("law", "kind, surface_energy, and range or mu_rho")?)?,
        indenter: root
            .inside("indenter")?
            .map_or(Ok(Indenter::Flat), |section| indenter(&section))?,
        drive: drive(&root.required("drive", "start, turn and step")?)?,
        accuracy: accuracy(&root.optional("accuracy")?)?,
        seed: noise(&root.optional("noise")?)?,
        units: units(&root, body_table.as_ref())?,
    };
    let scene = given.taken();
    scene
        .validate()
        .map_err(|error| refused(file_name, error))?;
    Ok(scene)
}

fn cell(section: &Section<'_>) -> Result<Cell, Failure> {
    section.only(&["length", "points"])?;
    Ok(Cell {
        length: section.number(&parameter::LENGTH)?,
        points: points(section)?,
    })
}

fn points(section: &Section<'_>) -> Result<Points, Failure> {
    let value = section.given(&parameter::POINTS)?;
    let parsed = match value {
        Value::String(word) if word == "auto" => Some(Points::Auto),
        Value::Array(sides) => match wholes(sides).as_deref() {
            Some([n, 1]) => Some(Points::Line(*n)),
            Some([n, m]) if n == m => Some(Points::Square(*n)),
            _ => None,
        },
        other => whole(other).map(Points::Square),
    };
    parsed.ok_or_else(|| section.refuse_number(&parameter::POINTS, value))
}

fn law(section: &Section<'_>) -> Result<LawChoice, Failure> {
    let kinds = Shape::all();
    let shape = kinds[kind(section, &kinds.iter().map(Shape::word).collect::<Vec<_>>())?];
    let values = own(
        section,
        &["kind", "surface_energy", "range", "mu_rho"],
        shape.parameters(),
        &shape.values(),
    )?;
    let surface_energy = section.number(&parameter::SURFACE_ENERGY)?;
    Ok(LawChoice {
        shape: shape.with(&values),
        surface_energy,
        range: range(section)?,
    })
}

fn body(section: &Section<'_>) -> Result<Body, Failure> {
    let kinds = Body::all();
    let body = kinds[kind(section, &kinds.iter().map(Body::word).collect::<Vec<_>>())?];
    let common = ["kind", parameter::CONTACT_MODULUS.name()];
    let values = own(section, &common, body.parameters(), &body.values())?;
    Ok(body.with(&values))
}

fn indenter(section: &Section<'_>) -> Result<Indenter, Failure> {
    let kinds = Indenter::all();
    let words: Vec<_> = kinds.iter().map(Indenter::word).collect();
    let ground = &kinds[kind(section, &words)?];
    let mut common = vec!["kind"];
    if let Indenter::Measured(_) = ground {
        common.push(FILE);
    }
    let values = own(section, &common, ground.parameters(), &ground.values())?;
    Ok(match ground.with(&values) {
        Indenter::Measured(choices) => {
            let allowed = "the path of a height file, as seen from the scene's folder";
            let word = files::typed(Path::new(section.text(FILE, allowed)?))?;
            let folder = Path::new(section.file).parent();
            let file = folder.unwrap_or(Path::new("")).join(word);
            Indenter::Measured(choices.of(heights::read(&file)?))
        }
        other => other,
    })
}

/// Which of the `words` the section's kind is.
fn kind(section: &Section<'_>, words: &[&str]) -> Result<usize, Failure> {
    let kind = section.text("kind", &format!("one of \"{}\"", words.join("\", \"")))?;
    words
        .iter()
        .position(|word| *word == kind)
        .ok_or_else(|| section.refuse_word("kind", kind, words))
}

/// The values of a kind's own parameters, `like` those of its default; beside them the section may
/// have only the `common` keys.
fn own(
    section: &Section<'_>,
    common: &[&str],
    parameters: &[Parameter],
    like: &[Own],
) -> Result<Vec<Own>, Failure> {
    let names: Vec<&str> = parameters.iter().map(Parameter::name).collect();
    section.only(&[common, &names].concat())?;
    parameters
        .iter()
        .zip(like)
        .map(|(parameter, like)| value(section, parameter, like))
        .collect()
}

/// The value of a parameter, of the same kind as `like`.
fn value(section: &Section<'_>, parameter: &Parameter, like: &Own) -> Result<Own, Failure> {
    Ok(match like {
        Own::Number(_) => Own::Number(section.number(parameter)?),
        Own::Whole(_) => Own::Whole(seed(section, parameter)?),
        Own::Counts(_) => Own::Counts(counts(section, parameter)?),
        Own::Flag(_) => Own::Flag(section.flag(parameter)?),
        Own::Choice { words, .. } => section.choice(parameter, words)?,
    })
}

fn range(section: &Section<'_>) -> Result<Range, Failure> {
    match (section.has("range"), section.has("mu_rho")) {
        (true, false) => Ok(Range::Length(section.number(&parameter::RANGE)?)),
        (false, true) => Ok(Range::MuRho(section.number(&parameter::MU_RHO)?)),
        (false, false) => Err(section.missing(
            "range",
            &format!("{}, or mu_rho in its place", parameter::RANGE.allowed()),
        )),
        (true, true) => {
            let value = section.given(&parameter::MU_RHO)?;
            Err(section.refuse(
                "mu_rho",
                value,
                "not together with law.range; remove one of the two",
            ))
        }
    }
}

/// One count along x, or one along x and one along y.
fn counts(section: &Section<'_>, parameter: &Parameter) -> Result<[usize; 2], Failure> {
    let value = section.given(parameter)?;
    let parsed = match value {
        Value::Array(both) => match wholes(both).as_deref() {
            Some([x, y]) => Some([*x, *y]),
            _ => None,
        },
        other => whole(other).map(|x| [x, 0]),
    };
    parsed.ok_or_else(|| section.refuse_number(parameter, value))
}

fn drive(section: &Section<'_>) -> Result<Drive, Failure> {
    let control = control(section)?;
    let start = section.number(&parameter::START)?;
    let turn = match section.given(&parameter::TURN)? {
        Value::String(word) if word == "zero_load" => Turn::ZeroLoad,
        value => {
            Turn::At(finite(value).ok_or_else(|| section.refuse_number(&parameter::TURN, value))?)
        }
    };
    Ok(Drive {
        control,
        start,
        turn,
        step: section.number(&parameter::STEP)?,
    })
}

/// What is driven: the mean displacement where the file says nothing.
fn control(section: &Section<'_>) -> Result<Control, Failure> {
    let keys = ["control", "start", "turn", "step"];
    let word = section.text_or("control", Control::Displacement.word())?;
    let kinds = Control::all(f64::NAN);
    let words = kinds.map(|kind| kind.word());
    let kind = words
        .iter()
        .position(|known| *known == word)
        .ok_or_else(|| section.refuse_word("control", &word, &words))?;
    if let Control::Spring { .. } = kinds[kind] {
        section.only(&[&keys[..], &[parameter::STIFFNESS.name()]].concat())?;
        let stiffness = section.number(&parameter::STIFFNESS)?;
        return Ok(Control::Spring { stiffness });
    }
    section.only(&keys)?;
    Ok(kinds[kind])
}

/// What the numbers are in. The modulus of the `body` is told with them, and not without.
fn units(root: &Section<'_>, body: Option<&Section<'_>>) -> Result<Option<Units>, Failure> {
    let modulus = &parameter::CONTACT_MODULUS;
    let told = body.filter(|body| body.has(modulus.name()));
    let Some(section) = root.inside("units")? else {
        return match told {
            None => Ok(None),
            Some(body) => Err(body.refuse(
                modulus.name(),
                body.given(modulus)?,
                "not without [units], which say what it is in; without them E* is 1",
            )),
        };
    };
    section.only(&["length", "modulus", "energy", parameter::TEMPERATURE.name()])?;
    let Some(body) = told else {
        return Err(root.missing(
            modulus.key,
            "the contact modulus E* of the body in units.modulus, as in 2.0, in [body]",
        ));
    };
    let word = |key: &str, all: &'static [Word], word: &str| {
        let words: Vec<&str> = all.iter().map(|known| known.word).collect();
        Word::find(all, word).ok_or_else(|| section.refuse_word(key, word, &words))
    };
    let text =
        |key: &str, example: &str| section.text(key, &format!("a unit, as in \"{example}\""));
    Ok(Some(Units {
        length: word("length", &LENGTH_UNITS, text("length", "um")?)?,
        modulus: word("modulus", &MODULUS_UNITS, text("modulus", "MPa")?)?,
        surface_energy: word(
            "energy",
            &SURFACE_ENERGY_UNITS,
            &section.text_or("energy", "mJ/m^2")?,
        )?,
        contact_modulus: body.number(modulus)?,
        temperature: section.number(&parameter::TEMPERATURE)?,
    }))
}

fn accuracy(section: &Section<'_>) -> Result<f64, Failure> {
    section.only(&["target"])?;
    section.number(&parameter::TARGET)
}

fn noise(section: &Section<'_>) -> Result<u64, Failure> {
    section.only(&["seed"])?;
    seed(section, &parameter::SEED)
}

/// A seed: all its digits count, which a float does not hold.
fn seed(section: &Section<'_>, parameter: &Parameter) -> Result<u64, Failure> {
    let default = parameter
        .default
        .map(|seed| Value::Integer(seed.whole() as i64));
    let value = match (section.has(parameter.name()), &default) {
        (false, Some(default)) => default,
        _ => section.given(parameter)?,
    };
    value
        .as_integer()
        .and_then(|seed| u64::try_from(seed).ok())
        .ok_or_else(|| section.refuse_number(parameter, value))
}

/// A count.
fn whole(value: &Value) -> Option<usize> {
    value.as_integer().and_then(|n| usize::try_from(n).ok())
}

fn wholes(values: &[Value]) -> Option<Vec<usize>> {
    values.iter().map(whole).collect()
}
