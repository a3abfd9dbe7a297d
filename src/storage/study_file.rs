//! The study file (`format = 1`): a scene, the numbers of it that go, and what is recorded.

use super::scene_file::{self, BYTES_MAX, FORMAT};
use super::section::{self, Section, finite};
use super::{Failure, files, presets};
use crate::physics::parameter::Refusal;
use crate::scene::Scene;
use crate::study::axis::{SOBOL_MAX, Sequence, Spacing, Span, grid};
use crate::study::sweep::{AXES_MAX, COLUMNS, DEFAULT, POINTS_MAX, Study, column};
use std::path::Path;
use toml::{Table, Value};

/// Keys of the file, and of an axis.
const KEYS: [&str; 9] = [
    "format", "title", "scene", "set", "axis", "random", "sobol", "record", "plot",
];
const AXIS: [&str; 5] = ["key", "values", "linear", "logarithmic", "seeds"];

/// Reads a study; its scene is a preset, or a file as seen from the study's folder.
///
/// # Errors
/// A file that cannot be read or is no allowed study, or the same of its scene.
pub fn load(path: &Path) -> Result<Study, Failure> {
    let text = scene_file::text_of(path, files::read_bytes(path, BYTES_MAX)?)?;
    parse(&text, &path.display().to_string())
}

/// Reads a study from the text of a study file of this name.
///
/// # Errors
/// As [`load`].
pub fn parse(text: &str, file_name: &str) -> Result<Study, Failure> {
    let table = section::table(text, file_name)?;
    let root = Section::root(file_name, &table);
    root.format_version(FORMAT, "a study file")?;
    root.only(&KEYS)?;
    let scene = scene(&root)?;
    let (keys, places) = places(&root)?;
    let mut study = Study {
        title: root.text_or("title", &scene.title)?,
        scene,
        keys,
        places,
        record: Vec::new(),
        plot: Default::default(),
    };
    let names = if root.has("record") {
        let allowed = "a list of columns, as in [\"dissipated_energy\"]";
        texts(&root, "record", allowed)?
    } else {
        DEFAULT.map(str::to_owned).to_vec()
    };
    for name in &names {
        let words: Vec<_> = COLUMNS.iter().map(|column| column.name).collect();
        let column = column(name).ok_or_else(|| root.refuse_word("record", name, &words))?;
        if study.record.iter().any(|known| known.name == column.name) {
            let value = Value::String(name.clone());
            return Err(root.refuse("record", &value, "allowed is each column once"));
        }
        study.record.push(column);
    }
    study.plot = plot(&root, &study)?;
    let refused = |error: Refusal| match error.key.as_str() {
        "key" => Failure::value(file_name, "axis.key", &error.value, &error.allowed),
        _ => scene_file::refused(file_name, error),
    };
    study.check().map_err(refused)?;
    Ok(study)
}

/// The scene, with what `set` puts in place of its numbers.
fn scene(root: &Section<'_>) -> Result<Scene, Failure> {
    let word = root.text(
        "scene",
        "a preset or the path of a scene file, as in \"fig2\"",
    )?;
    let scene = match presets::find(word) {
        Some(preset) => preset.scene()?,
        None => {
            let typed = files::typed(Path::new(word))?;
            let folder = Path::new(root.file).parent();
            let file = folder.unwrap_or(Path::new("")).join(typed);
            if !file.exists() {
                return Err(presets::unknown(word));
            }
            scene_file::load(&file)?
        }
    };
    let Some(set) = root.inside("set")? else {
        return Ok(scene);
    };
    let mut whole = section::table(&scene_file::to_text(&scene), root.file)?;
    for name in set.keys() {
        let value = set.value(name, "a table of the scene file")?;
        let own = value.as_table().ok_or_else(|| {
            set.refuse(
                name,
                value,
                "allowed are tables of the scene file, as in law.range = 0.8",
            )
        })?;
        merge(&mut whole, name, own);
    }
    scene_file::parse(&whole.to_string(), root.file)
}

/// Puts the keys of a table over those of a scene. One of another kind takes the place of the whole
/// table, and range and mu_rho that of each other.
fn merge(scene: &mut Table, name: &str, own: &Table) {
    let mut merged = match scene.get(name) {
        Some(Value::Table(known)) => known.clone(),
        _ => Table::new(),
    };
    let other = |key: &str| {
        own.get(key)
            .is_some_and(|value| merged.get(key) != Some(value))
    };
    if other("kind") || other("control") {
        let kept = ["surface_energy", "range", "mu_rho", "contact_modulus"];
        merged.retain(|key, _| kept.contains(&key));
    }
    for (key, twin) in [("range", "mu_rho"), ("mu_rho", "range")] {
        if own.contains_key(key) {
            merged.remove(twin);
        }
    }
    merged.extend(own.clone());
    scene.insert(name.to_owned(), Value::Table(merged));
}

/// The keys of the axes, and the values of each loop.
fn places(root: &Section<'_>) -> Result<(Vec<String>, Vec<Vec<f64>>), Failure> {
    let example = "add one [[axis]] with key and values, linear, logarithmic or seeds";
    let tables: Vec<&Table> = match root.value("axis", example)? {
        Value::Array(all) => all.iter().filter_map(Value::as_table).collect(),
        other => return Err(root.refuse("axis", other, "allowed are tables, [[axis]]")),
    };
    if tables.is_empty() || tables.len() > AXES_MAX {
        let allowed = format!("allowed are 1 to {AXES_MAX} tables [[axis]]");
        let value = Value::Integer(tables.len() as i64);
        return Err(root.refuse("axis", &value, &allowed));
    }
    let names: Vec<String> = (1..=tables.len()).map(|i| format!("axis {i}")).collect();
    let axes = tables.iter().zip(&names);
    let axes: Vec<_> = axes
        .map(|(table, name)| Section::of(root.file, name, table))
        .collect();
    let mut keys: Vec<String> = Vec::new();
    for axis in &axes {
        axis.only(&AXIS)?;
        let key = axis.text("key", "a number of the scene, as in \"law.range\"")?;
        if keys.iter().any(|known| known == key) {
            let value = Value::String(key.to_owned());
            return Err(axis.refuse("key", &value, "allowed is each key once"));
        }
        keys.push(key.to_owned());
    }
    let sequences = [("random", Sequence::Random), ("sobol", Sequence::Sobol)];
    let mut asked = sequences.into_iter().filter(|(name, _)| root.has(name));
    let places = match (asked.next(), asked.next()) {
        (Some((name, sequence)), None) => sampled(root, name, sequence, &axes)?,
        (Some(_), Some(_)) => {
            let value = root.value("sobol", "")?;
            return Err(root.refuse("sobol", value, "not together with random; remove one"));
        }
        _ => {
            let values = axes.iter().map(values).collect::<Result<Vec<_>, _>>()?;
            let count = values.iter().map(|axis| axis.len() as f64).product::<f64>();
            if count > POINTS_MAX as f64 {
                let allowed = format!("allowed are at most {POINTS_MAX} loops");
                return Err(root.refuse("axis", &Value::Float(count), &allowed));
            }
            grid(&values)
        }
    };
    Ok((keys, places))
}

/// Places within the ends of the axes.
fn sampled(
    root: &Section<'_>,
    name: &'static str,
    sequence: Sequence,
    axes: &[Section<'_>],
) -> Result<Vec<Vec<f64>>, Failure> {
    let section = root.inside(name)?.expect("asked for");
    section.only(&["count", "seed"])?;
    let most = match sequence {
        Sequence::Random => POINTS_MAX,
        Sequence::Sobol => SOBOL_MAX,
    };
    let count = whole(&section, "count", 1, most as i64)?;
    let seed = if section.has("seed") {
        whole(&section, "seed", 0, i64::from(u32::MAX))?
    } else {
        1
    };
    let spans = axes.iter().map(|axis| {
        if let Some(key) = ["values", "seeds"].into_iter().find(|key| axis.has(key)) {
            let allowed = format!("not together with [{name}]: give linear or logarithmic ends");
            return Err(axis.refuse(key, axis.value(key, "")?, &allowed));
        }
        span(axis, &["from", "to"]).map(|(span, _)| span)
    });
    let spans: Vec<Span> = spans.collect::<Result<_, _>>()?;
    Ok(sequence.places(&spans, count as usize, seed as u32))
}

/// The values of an axis of a grid.
fn values(axis: &Section<'_>) -> Result<Vec<f64>, Failure> {
    let given: Vec<&str> = AXIS[1..]
        .iter()
        .copied()
        .filter(|key| axis.has(key))
        .collect();
    match given[..] {
        ["values"] => {
            let allowed = "a list of numbers, as in [0.5, 1.0, 2.0]";
            let value = axis.value("values", allowed)?;
            let numbers = value.as_array().filter(|all| !all.is_empty());
            let numbers = numbers.and_then(|all| all.iter().map(finite).collect());
            numbers.ok_or_else(|| axis.refuse("values", value, &format!("allowed is {allowed}")))
        }
        ["seeds"] => {
            let seeds = axis.inside("seeds")?.expect("given");
            seeds.only(&["from", "count"])?;
            let from = whole(&seeds, "from", 0, 1 << 53)?;
            let count = whole(&seeds, "count", 1, POINTS_MAX as i64)?;
            Ok((from..from + count).map(|seed| seed as f64).collect())
        }
        ["linear" | "logarithmic"] => {
            let (span, section) = span(axis, &["from", "to", "count"])?;
            let count = whole(&section, "count", 2, POINTS_MAX as i64)?;
            Ok(span.values(count as usize))
        }
        [] => Err(axis.missing("values", "one of values, linear, logarithmic, seeds")),
        [.., last] => Err(axis.refuse(
            last,
            axis.value(last, "")?,
            "allowed is one of values, linear, logarithmic, seeds",
        )),
    }
}

/// The ends of an axis.
fn span<'a>(axis: &Section<'a>, keys: &[&str]) -> Result<(Span, Section<'a>), Failure> {
    let [linear, logarithmic] = [axis.inside("linear")?, axis.inside("logarithmic")?];
    let (section, spacing) = match (linear, logarithmic) {
        (Some(section), None) => (section, Spacing::Linear),
        (None, Some(section)) => (section, Spacing::Logarithmic),
        _ => return Err(axis.missing("linear", "linear or logarithmic, with from and to")),
    };
    section.only(keys)?;
    let end = |key: &str| {
        let allowed = match spacing {
            Spacing::Linear => "a finite number",
            Spacing::Logarithmic => "a finite number above 0",
        };
        let value = section.value(key, allowed)?;
        let number = finite(value).filter(|x| spacing == Spacing::Linear || *x > 0.0);
        number.ok_or_else(|| section.refuse(key, value, &format!("allowed is {allowed}")))
    };
    let (from, to) = (end("from")?, end("to")?);
    if from == to {
        let value = section.value("to", "")?;
        return Err(section.refuse("to", value, "allowed is another number than from"));
    }
    Ok((Span { from, to, spacing }, section))
}

/// What is drawn against what: what the file says, or else the first number that is recorded against
/// the first axis.
fn plot(root: &Section<'_>, study: &Study) -> Result<[String; 2], Failure> {
    let default = || [study.keys[0].clone(), study.record[0].name.to_owned()];
    if !root.has("plot") {
        return Ok(default());
    }
    let allowed = "two columns, as in [\"law.range\", \"dissipated_energy\"]";
    let names = texts(root, "plot", allowed)?;
    for name in &names {
        study.check_name(name).map_err(|words| {
            let words: Vec<&str> = words.iter().map(String::as_str).collect();
            root.refuse_word("plot", name, &words)
        })?;
    }
    let value = root.value("plot", allowed)?;
    names
        .try_into()
        .map_err(|_| root.refuse("plot", value, &format!("allowed are {allowed}")))
}

/// A list of texts, not empty.
fn texts(root: &Section<'_>, key: &str, allowed: &str) -> Result<Vec<String>, Failure> {
    let value = root.value(key, allowed)?;
    let texts = value.as_array().filter(|all| !all.is_empty());
    let texts = texts.and_then(|all| {
        all.iter()
            .map(|one| Some(one.as_str()?.to_owned()))
            .collect()
    });
    texts.ok_or_else(|| root.refuse(key, value, &format!("allowed is {allowed}")))
}

/// A whole number between two.
fn whole(section: &Section<'_>, key: &str, least: i64, most: i64) -> Result<i64, Failure> {
    let allowed = format!("a whole number from {least} to {most}");
    let value = section.value(key, &allowed)?;
    let number = value.as_integer().filter(|n| (least..=most).contains(n));
    number.ok_or_else(|| section.refuse(key, value, &format!("allowed is {allowed}")))
}
