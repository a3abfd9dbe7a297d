//! Fields as data: gap, displacement and traction of the states of a loop in `fields.npz`, which
//! numpy reads.
//!
//! What is kept goes to a file without a name as it comes, so that memory does not grow with the
//! number of states; the archive is made of that at the end. Arrays have one row a state, and
//! fields the shape (state, row y, column x).

use super::{Failure, files, scene_file};
use crate::follow::record::StateRecord;
use crate::follow::run::Report;
use crate::physics::grid::Grid;
use crate::physics::parameter::Dimension;
use crate::scene::{Model, Scene, edit};
use ndarray::Array2;
use npyz::{AutoSerialize, DType, WriteOptions, WriterBuilder};
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::Path;
use std::str::FromStr;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// The version of the archive; `format` in it.
const FORMAT: i64 = 1;

/// Which states are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    /// All.
    All,
    /// The last one before each jump or transition, and the one where it lands.
    Jumps,
    /// One in so many, the first one first.
    Every(usize),
}

impl FromStr for Keep {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        match (word, word.strip_prefix("every=").map(str::parse)) {
            ("all", _) => Ok(Keep::All),
            ("jumps", _) => Ok(Keep::Jumps),
            (_, Some(Ok(n))) if n > 0 => Ok(Keep::Every(n)),
            _ => Err("allowed is all, jumps, or every=N with N from 1 on".to_owned()),
        }
    }
}

/// A state that is kept, or may be.
struct Row {
    /// Its place in `loop.csv`.
    index: usize,
    record: StateRecord,
    /// True if a jump or a transition led to it.
    event: bool,
}

/// Collects the fields of a loop under way.
pub struct Collector {
    keep: Keep,
    scratch: BufWriter<File>,
    rows: Vec<Row>,
    /// The state before, where a jump may yet make it one to keep.
    before: Option<(Row, [Array2<f64>; 2])>,
    event: bool,
    fault: Option<io::Error>,
}

impl Collector {
    /// Of the states to `keep`, with its scratch file in `folder`.
    ///
    /// # Errors
    /// A folder that cannot be written.
    pub fn new(keep: Keep, folder: &Path) -> Result<Self, Failure> {
        let scratch = tempfile::tempfile_in(folder).map_err(|e| Failure::write(folder, e))?;
        Ok(Self {
            keep,
            scratch: BufWriter::new(scratch),
            rows: Vec::new(),
            before: None,
            event: false,
            fault: None,
        })
    }

    /// Takes in what a loop reports.
    pub fn observe(&mut self, report: &Report<'_>) {
        match report {
            Report::Jump(_) => self.event = true,
            Report::State {
                record,
                index,
                fields,
                ..
            } => {
                if self.fault.is_none() {
                    self.fault = self.state(record, *index, *fields).err();
                }
            }
        }
    }

    fn state(
        &mut self,
        record: &StateRecord,
        index: usize,
        fields: [&Array2<f64>; 2],
    ) -> io::Result<()> {
        if self.rows.last().is_some_and(|last| last.index >= index) {
            self.forget(index, fields[0].len())?;
        }
        let row = Row {
            index,
            record: record.clone(),
            event: std::mem::take(&mut self.event),
        };
        let keeps = match self.keep {
            Keep::All => true,
            Keep::Every(n) => index.is_multiple_of(n),
            Keep::Jumps => row.event,
        };
        if !keeps {
            let may_be_left = self.keep == Keep::Jumps;
            self.before = may_be_left.then(|| (row, fields.map(Array2::clone)));
            return Ok(());
        }
        if let Some((row, [gap, displacement])) = self.before.take() {
            self.write(row, [&gap, &displacement])?;
        }
        self.write(row, fields)
    }

    fn write(&mut self, row: Row, fields: [&Array2<f64>; 2]) -> io::Result<()> {
        for value in fields.into_iter().flatten() {
            self.scratch.write_all(&value.to_le_bytes())?;
        }
        self.rows.push(row);
        Ok(())
    }

    /// Drops the states from `index` on, of so many `points` each: from there on the loop is done
    /// anew.
    fn forget(&mut self, index: usize, points: usize) -> io::Result<()> {
        (self.before, self.event) = (None, false);
        self.rows.retain(|row| row.index < index);
        let end = (self.rows.len() * 2 * points * size_of::<f64>()) as u64;
        self.scratch.seek(SeekFrom::Start(end)).map(drop)
    }

    /// Writes the archive of what was collected on `scene`.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn finish(mut self, path: &Path, scene: &Scene, model: &Model) -> Result<(), Failure> {
        if let Some(fault) = self.fault.take() {
            return Err(Failure::write(path, fault));
        }
        files::write_by(path, |file| self.archive(file, scene, model))
    }

    fn archive(mut self, file: &mut File, scene: &Scene, model: &Model) -> io::Result<()> {
        self.scratch.flush()?;
        let mut scratch = BufReader::new(self.scratch.get_mut());
        let Grid { nx, ny, .. } = model.grid;
        let shape = [self.rows.len() as u64, ny as u64, nx as u64];
        let mut archive = Archive(ZipWriter::new(BufWriter::new(file)));
        let given = |of, value| scene.number_given(of, value);
        let mut field = |archive: &mut Archive<'_>, name: &str, which: usize, law: bool| {
            scratch.rewind()?;
            archive.array(name, &shape, |push| {
                let mut bytes = vec![0; nx * ny * size_of::<f64>()];
                for kept in 0..2 * self.rows.len() {
                    scratch.read_exact(&mut bytes)?;
                    if kept % 2 != which {
                        continue;
                    }
                    for number in bytes.chunks_exact(size_of::<f64>()) {
                        let value = f64::from_le_bytes(number.try_into().expect("of this size"));
                        push(if law {
                            given(Dimension::Stress, model.law.at(value).traction)
                        } else {
                            value
                        })?;
                    }
                }
                Ok(())
            })
        };
        field(&mut archive, "gap", 0, false)?;
        field(&mut archive, "displacement", 1, false)?;
        field(&mut archive, "traction", 0, true)?;
        let records = || self.rows.iter().map(|row| &row.record);
        archive.list("mean_displacement", records().map(|s| s.mean_displacement))?;
        archive.list(
            "stress",
            records().map(|s| given(Dimension::Stress, s.stress)),
        )?;
        archive.list(
            "control",
            records().map(|s| given(Dimension::Driven, s.control)),
        )?;
        archive.list(
            "energy",
            records().map(|s| given(Dimension::SurfaceEnergy, s.energy)),
        )?;
        archive.list("state", self.rows.iter().map(|row| row.index as i64))?;
        archive.list("event", self.rows.iter().map(|row| row.event))?;
        let branches: Vec<String> = records().map(|s| s.direction.to_string()).collect();
        archive.texts("branch", &shape[..1], &branches)?;
        archive.array("wave_stiffness", &shape[1..], |push| {
            waves(&model.grid)
                .try_for_each(|q| push(given(Dimension::Stiffness, stiffness(model, q))))
        })?;
        archive.array("length", &[], |push| push(model.grid.length))?;
        archive.texts(
            "scene",
            &[],
            &[scene_file::to_text(&edit::decided(scene, model))],
        )?;
        let program = concat!("tackscope ", env!("CARGO_PKG_VERSION")).to_owned();
        archive.texts("program", &[], &[program])?;
        archive.array("format", &[], |push| push(FORMAT))?;
        archive.0.finish()?.flush()
    }
}

/// The wave numbers of a mesh in the order of numpy's `fft2`.
fn waves(grid: &Grid) -> impl Iterator<Item = f64> {
    let (q1, nx, ny) = (grid.q1(), grid.nx, grid.ny);
    let shorter = |k: usize, n: usize| k.min(n - k) as f64;
    (0..ny).flat_map(move |l| (0..nx).map(move |k| q1 * shorter(k, nx).hypot(shorter(l, ny))))
}

/// The body's stiffness (E* per length) of a wave; nothing holds the mean.
fn stiffness(model: &Model, q: f64) -> f64 {
    if q == 0.0 {
        0.0
    } else {
        model.body.elastic().stiffness(q)
    }
}

/// An archive that is being written, array by array.
struct Archive<'a>(ZipWriter<BufWriter<&'a mut File>>);

impl<'a> Archive<'a> {
    /// One array of this shape, whose values `fill` pushes in order.
    fn array<T: AutoSerialize>(
        &mut self,
        name: &str,
        shape: &[u64],
        fill: impl FnOnce(&mut dyn FnMut(T) -> io::Result<()>) -> io::Result<()>,
    ) -> io::Result<()> {
        let options = WriteOptions::<T>::new().default_dtype().shape(shape);
        let mut array = options.writer(self.entry(name)?).begin_nd()?;
        fill(&mut |value| array.push(&value))?;
        array.finish()
    }

    /// An array of one row a state.
    fn list<T: AutoSerialize>(
        &mut self,
        name: &str,
        values: impl ExactSizeIterator<Item = T>,
    ) -> io::Result<()> {
        self.array(name, &[values.len() as u64], |push| {
            values.into_iter().try_for_each(push)
        })
    }

    /// An array of texts.
    fn texts(&mut self, name: &str, shape: &[u64], texts: &[String]) -> io::Result<()> {
        let longest = texts.iter().map(|text| text.chars().count()).max();
        let kind = format!("<U{}", longest.unwrap_or(0).max(1));
        let options = WriteOptions::<str>::new()
            .dtype(DType::Plain(kind.parse().map_err(io::Error::other)?))
            .shape(shape);
        let mut array = options.writer(self.entry(name)?).begin_nd()?;
        texts.iter().try_for_each(|text| array.push(text))?;
        array.finish()
    }

    /// Begins the file of an array; not compressed, so that numpy can read a part of it.
    fn entry(&mut self, name: &str) -> io::Result<&mut ZipWriter<BufWriter<&'a mut File>>> {
        let options = SimpleFileOptions::default()
            .compression_method(zip::CompressionMethod::Stored)
            .large_file(true);
        self.0.start_file(format!("{name}.npy"), options)?;
        Ok(&mut self.0)
    }
}
