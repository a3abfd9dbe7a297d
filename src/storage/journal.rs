//! The table of a sweep, which grows by a row a loop: what a killed process has written is found
//! again, a line that it had not finished is dropped.
//!
//! A row is known by a hash of its decided scene and of the program's version, so that a row is
//! never taken for one of another scene, whatever became of the study in between.

use super::export::{number as digits, push_row, quoted};
use super::files::{self, Growing};
use super::{Failure, scene_file};
use crate::physics::indenter::Indenter;
use crate::physics::parameter::number;
use crate::scene::{Scene, edit};
use crate::study::sweep::{Cell, Point, Row, Study};
use siphasher::sip::SipHasher13;
use std::collections::HashMap;
use std::ffi::OsString;
use std::hash::Hasher;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// The table of a sweep.
pub const TABLE: &str = "sweep.csv";
/// How the name of a shard's folder begins.
const SHARD: &str = "shard-";
/// Longest table that is read, in bytes.
const BYTES_MAX: u64 = 1 << 32;
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
pub fn read(path: &Path, study: &Study) -> Result<Known, Failure> {
    if let Err(error) = std::fs::metadata(path)
        && error.kind() == ErrorKind::NotFound
    {
        return Ok(Known::default());
    }
    let bytes = files::read_bytes(path, BYTES_MAX)?;
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
pub fn write<'a>(
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
