//! A study's files. The study file (`format = 1`): a scene, the numbers of it that go, and what is
//! recorded. And the table of its sweep, which grows by a row a loop: what a killed process has
//! written is found again, a line that it had not finished is dropped.
//!
//! A row is known by a hash of its decided scene and of the program's version, so that a row is
//! never taken for one of another scene, whatever became of the study in between.

use super::export::{number as digits, push_row, quoted};
use super::failure::{self, Section, finite};
use super::files::{self, Growing};
use super::scene_file::{self, BYTES_MAX, FORMAT};
use super::{Failure, preset, unknown};
use crate::physics::indenter::Indenter;
use crate::physics::parameter::{Refusal, number};
use crate::scene::{Scene, edit};
use crate::study::sweep::{
    AXES_MAX, COLUMNS, Cell, DEFAULT, POINTS_MAX, Point, Row, SOBOL_MAX, Sequence, Spacing, Span,
    Study, column, grid,
};
use siphasher::sip::SipHasher13;
use std::collections::HashMap;
use std::ffi::OsString;
use std::hash::Hasher;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
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
    let table = failure::table(text, file_name)?;
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
    let scene = match preset(word) {
        Some(preset) => preset.scene()?,
        None => {
            let typed = files::typed(Path::new(word))?;
            let folder = Path::new(root.file).parent();
            let file = folder.unwrap_or(Path::new("")).join(typed);
            if !file.exists() {
                return Err(unknown(word));
            }
            scene_file::load(&file)?
        }
    };
    let Some(set) = root.inside("set")? else {
        return Ok(scene);
    };
    let mut whole = failure::table(&scene_file::to_text(&scene), root.file)?;
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

/// The table of a sweep.
pub const TABLE: &str = "sweep.csv";
/// How the name of a shard's folder begins.
const SHARD: &str = "shard-";
/// Longest table that is read, in bytes.
const TABLE_MAX: u64 = 1 << 32;
/// Columns before the values, and after what is recorded.
const BEFORE: usize = 2;
const AFTER: usize = 2;

/// The first line of the table of a study.
pub fn heading(study: &Study) -> String {
    let keys = study.keys.iter().map(String::as_str);
    let record = study.record.iter().map(|column| column.name);
    let all = ["row", "scene"].into_iter().chain(keys).chain(record);
    all.chain(["stop", "reason"]).collect::<Vec<_>>().join(",")
}

/// The folder of the shard `index` of `count`.
pub fn shard_folder(folder: &Path, index: usize, count: usize) -> PathBuf {
    folder.join(format!("{SHARD}{index}-of-{count}"))
}

/// What a point is known by: its decided scene, its ground as it was measured, and the version of
/// the program. Of values that are not allowed what was asked.
pub fn hash(study: &Study, point: &Point) -> String {
    let mut hasher = SipHasher13::new();
    hasher.write(env!("CARGO_PKG_VERSION").as_bytes());
    let decided = |scene: &Scene| {
        let model = scene.model().ok()?;
        Some(Scene {
            title: String::new(),
            source: String::new(),
            ..edit::decided(scene, &model)
        })
    };
    match point.scene.as_ref().ok().and_then(decided) {
        Some(scene) => {
            hasher.write(scene_file::to_text(&scene).as_bytes());
            if let Indenter::Measured(ground) = &scene.indenter {
                let heights = ground.topography().heights.iter();
                heights.for_each(|height| hasher.write_u64(height.to_bits()));
            }
        }
        None => {
            hasher.write(scene_file::to_text(&study.scene).as_bytes());
            for (key, value) in study.keys.iter().zip(&point.values) {
                hasher.write(format!("{key} = {value:?}").as_bytes());
            }
        }
    }
    format!("{:016x}", hasher.finish())
}

/// A row of the table, with its line break.
pub fn line(hash: &str, row: &Row) -> String {
    let mut cells = vec![(row.index + 1).to_string(), hash.to_owned()];
    cells.extend(row.values.iter().map(|value| number(*value)));
    cells.extend(row.cells.iter().map(told));
    cells.extend([row.stop.clone(), quoted(&row.reason)]);
    let mut line = String::new();
    push_row(&mut line, &cells);
    line
}

fn told(cell: &Cell) -> String {
    match cell {
        Cell::Number(x) => digits(*x),
        Cell::Count(n) => n.to_string(),
        Cell::Numbers(all) => {
            let all: Vec<_> = all.iter().map(|x| digits(*x)).collect();
            all.join(" ")
        }
        Cell::Word(word) => quoted(word),
    }
}

/// What [`told`] made the text of; the same text is made of it again.
fn cell(text: String) -> Cell {
    if let Ok(count) = text.parse() {
        Cell::Count(count)
    } else if let Ok(x) = text.parse() {
        Cell::Number(x)
    } else {
        let all: Result<Vec<f64>, _> = text.split_whitespace().map(str::parse).collect();
        all.ok()
            .filter(|all| !all.is_empty())
            .map_or(Cell::Word(text), Cell::Numbers)
    }
}

/// The cells of a line.
fn cells(line: &str) -> Vec<String> {
    let (mut cells, mut inside) = (vec![String::new()], false);
    let mut rest = line.chars().peekable();
    while let Some(c) = rest.next() {
        match c {
            '"' if inside && rest.peek() == Some(&'"') => {
                cells.last_mut().expect("begins with one").push('"');
                rest.next();
            }
            '"' => inside = !inside,
            ',' if !inside => cells.push(String::new()),
            c => cells.last_mut().expect("begins with one").push(c),
        }
    }
    cells
}

/// The rows of a table by what they are known by.
#[derive(Clone, Debug, Default)]
pub struct Known {
    /// Rows with the index and values that they have in their table.
    pub rows: HashMap<String, Row>,
    /// Its last line was not finished.
    pub torn: bool,
    /// Bytes that are whole lines.
    whole: u64,
}

/// The table in a folder, and those that its shards have in folders of their own.
pub fn tables(folder: &Path) -> Vec<PathBuf> {
    let inner = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let shard = |name: &OsString| name.as_encoded_bytes().starts_with(SHARD.as_bytes());
    let inner = inner.filter(|entry| shard(&entry.file_name()));
    let mut shards: Vec<PathBuf> = inner.map(|entry| entry.path().join(TABLE)).collect();
    shards.sort();
    std::iter::once(folder.join(TABLE)).chain(shards).collect()
}

/// Reads the table of a study; a table that is not there has no rows. The first of several rows of
/// the same scene counts.
///
/// # Errors
/// A file that cannot be read, or the table of another study.
pub fn read_table(path: &Path, study: &Study) -> Result<Known, Failure> {
    if let Err(error) = std::fs::metadata(path)
        && error.kind() == ErrorKind::NotFound
    {
        return Ok(Known::default());
    }
    let bytes = files::read_bytes(path, TABLE_MAX)?;
    let whole = bytes
        .iter()
        .rposition(|byte| *byte == b'\n')
        .map_or(0, |i| i + 1);
    let text = String::from_utf8_lossy(&bytes[..whole]);
    let mut lines = text.lines();
    let expected = heading(study);
    match lines.next() {
        Some(first) if first != expected => {
            let reason = "it holds a study of other numbers, or with other columns";
            let remedy = "choose another folder, or remove the file";
            return Err(Failure::refused(path, reason, remedy));
        }
        _ => {}
    }
    let mut known = Known {
        rows: HashMap::new(),
        torn: whole < bytes.len(),
        whole: whole as u64,
    };
    for (hash, row) in lines.filter_map(|line| parsed(line, study)) {
        known.rows.entry(hash).or_insert(row);
    }
    Ok(known)
}

/// What a row is known by, and the row; `None` of what is none.
fn parsed(line: &str, study: &Study) -> Option<(String, Row)> {
    let mut cells = cells(line);
    let (values, record) = (study.keys.len(), study.record.len());
    if cells.len() != BEFORE + values + record + AFTER {
        return None;
    }
    let [stop, reason] = cells.split_off(BEFORE + values + record).try_into().ok()?;
    let found = cells.split_off(BEFORE + values);
    let index: usize = cells[0].parse().ok()?;
    let numbers: Result<_, _> = cells[BEFORE..].iter().map(|cell| cell.parse()).collect();
    let row = Row {
        index: index.checked_sub(1)?,
        values: numbers.ok()?,
        cells: found.into_iter().map(cell).collect(),
        stop,
        reason,
    };
    Some((cells[1].clone(), row))
}

/// A table that rows are added to.
#[derive(Debug)]
pub struct Journal(Growing);

impl Journal {
    /// Goes on with the table from which `known` was read, without a line that was not finished, or
    /// begins one.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn open(path: &Path, study: &Study, known: &Known) -> Result<Self, Failure> {
        if known.whole > 0 {
            return Growing::open(path, known.whole).map(Self);
        }
        let first = format!("{}\n", heading(study));
        files::write_whole(path, first.as_bytes())?;
        Growing::open(path, first.len() as u64).map(Self)
    }

    /// Adds a row; it is on the disk when this returns.
    ///
    /// # Errors
    /// A disk that is full, or gone.
    pub fn add(&mut self, hash: &str, row: &Row) -> Result<(), Failure> {
        self.0.append(&line(hash, row))
    }
}

/// Writes the whole table, in this order.
///
/// # Errors
/// A file that cannot be written.
pub fn write_table<'a>(
    path: &Path,
    study: &Study,
    rows: impl Iterator<Item = (&'a str, &'a Row)>,
) -> Result<(), Failure> {
    let first = format!("{}\n", heading(study));
    let text = rows.fold(first, |text, (hash, row)| text + &line(hash, row));
    files::write_whole(path, text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn cell_of_any_kind() -> impl Strategy<Value = Cell> {
        prop_oneof![
            any::<f64>().prop_map(Cell::Number),
            any::<usize>().prop_map(Cell::Count),
            prop::collection::vec(-1e9..1e9, 0..5).prop_map(Cell::Numbers),
            "[a-z,\" %;]{0,12}".prop_map(Cell::Word),
        ]
    }

    proptest! {
        #[test]
        fn a_row_that_is_read_back_is_written_as_the_same_line(
            index in 0..usize::MAX / 2,
            values in prop::collection::vec(any::<f64>(), 2),
            found in prop::collection::vec(cell_of_any_kind(), 3),
            reason in "[a-z,\" .=0-9]{0,20}",
        ) {
            let study = Study {
                title: String::new(),
                scene: crate::scene::tests::fig2(16),
                keys: vec![String::new(); 2],
                places: Vec::new(),
                record: crate::study::sweep::COLUMNS.iter().take(3).collect(),
                plot: Default::default(),
            };
            let row = Row { index, values, cells: found, stop: "completed".to_owned(), reason };
            let first = line("abc", &row);
            let (hash, back) = parsed(first.trim_end_matches('\n'), &study).expect("a row");
            prop_assert_eq!(line(&hash, &back), first);
        }
    }
}
