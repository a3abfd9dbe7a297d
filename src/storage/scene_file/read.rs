//! From the text of a scene file to a scene, by a typed view of each of its tables.

use super::{FILE, FORMAT, refused};
use crate::physics::body::Body;
use crate::physics::control::Control;
use crate::physics::indenter::Indenter;
use crate::physics::law::Shape;
use crate::physics::parameter::{Parameter, Value as Own};
use crate::scene::parameter;
use crate::scene::units::{LENGTHS, MODULI, SURFACE_ENERGIES, Units, Word};
use crate::scene::{Cell, Drive, LawChoice, Points, Range, Scene, Turn};
use crate::storage::section::{self, Section, finite};
use crate::storage::{Failure, files, heights};
use std::path::Path;
use toml::Value;

/// Reads a scene from the text of a scene file; `file_name` is used in messages, and a height file is
/// looked for from its folder.
///
/// # Errors
/// Anything that is not an allowed scene: syntax, unknown or missing keys, wrong types, values out
/// of range.
pub fn parse(text: &str, file_name: &str) -> Result<Scene, Failure> {
    let table = section::table(text, file_name)?;
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
        length: word("length", &LENGTHS, text("length", "um")?)?,
        modulus: word("modulus", &MODULI, text("modulus", "MPa")?)?,
        surface_energy: word(
            "energy",
            &SURFACE_ENERGIES,
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
