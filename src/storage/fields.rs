//! Fields as data: gap, displacement and traction of the states of a loop, or of a diagram, in
//! `fields.npz`, which numpy reads.
//!
//! What is kept goes to a file without a name as it comes, so that memory does not grow with the
//! number of states; the archive is made of that at the end. Arrays have one row a state, and
//! fields the shape (state, row y, column x).

use super::{Failure, VERSION, files, scene_file};
use crate::follow::diagram::{Branch, Diagram, Point};
use crate::follow::record::StateRecord;
use crate::follow::run::Report;
use crate::physics::control::Control;
use crate::physics::mesh::Grid;
use crate::physics::parameter::Dimension;
use crate::scene::{Model, Scene, edit};
use ndarray::Array2;
use npyz::{AutoSerialize, DType, WriteOptions, WriterBuilder};
use std::fs::File;
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
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

/// Finds the mode that goes soft in a state, by its record and displacement (length); `None` where
/// it is not found.
pub type SoftMode<'a> = &'a mut dyn FnMut(&StateRecord, &Array2<f64>) -> Option<Array2<f64>>;

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

    /// Writes the archive of what was collected on `scene`. `soft_mode` finds the mode that goes
    /// soft in a state from its displacement; it is asked for each that is followed by an event.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn finish(
        mut self,
        path: &Path,
        (scene, model): (&Scene, &Model),
        soft_mode: SoftMode<'_>,
    ) -> Result<(), Failure> {
        if let Some(fault) = self.fault.take() {
            return Err(Failure::write(path, fault));
        }
        files::write_by(path, |file| self.archive(file, (scene, model), soft_mode))
    }

    /// The rows of states that are followed by an event.
    fn before_events(&self) -> Vec<usize> {
        let pairs = self.rows.windows(2).enumerate();
        let leads = |two: &[Row]| two[1].event && two[1].index == two[0].index + 1;
        pairs
            .filter(|(_, two)| leads(two))
            .map(|(row, _)| row)
            .collect()
    }

    fn archive(
        mut self,
        file: &mut File,
        (scene, model): (&Scene, &Model),
        soft_mode: SoftMode<'_>,
    ) -> io::Result<()> {
        let soft = self.before_events();
        self.scratch.flush()?;
        let scratch = self.scratch.get_mut();
        let Grid { nx, ny, .. } = model.grid;
        let shape = [self.rows.len() as u64, ny as u64, nx as u64];
        let mut archive = Archive(ZipWriter::new(BufWriter::new(file)));
        let given = |of, value| scene.number_given(of, value);
        let mut read = |row: usize, which: usize| -> io::Result<Array2<f64>> {
            let mut bytes = vec![0; nx * ny * size_of::<f64>()];
            let start = ((2 * row + which) * bytes.len()) as u64;
            scratch.seek(SeekFrom::Start(start))?;
            scratch.read_exact(&mut bytes)?;
            let numbers = bytes.chunks_exact(size_of::<f64>()).map(number_of);
            Array2::from_shape_vec((ny, nx), numbers.collect()).map_err(io::Error::other)
        };
        let traction = |gap: f64| given(Dimension::Stress, model.law.at(gap).traction);
        let kept: [(_, _, &dyn Fn(f64) -> f64); 3] = [
            ("gap", 0, &|gap| gap),
            ("displacement", 1, &|displacement| displacement),
            ("traction", 0, &traction),
        ];
        for (name, which, of) in kept {
            archive.array(name, &shape, |push| {
                let mut rows = 0..self.rows.len();
                rows.try_for_each(|row| read(row, which)?.iter().try_for_each(|x| push(of(*x))))
            })?;
        }
        let modes = [soft.len() as u64, ny as u64, nx as u64];
        archive.array("soft_mode", &modes, |push| {
            for &row in &soft {
                match soft_mode(&self.rows[row].record, &read(row, 1)?) {
                    Some(mode) => mode.iter().try_for_each(|value| push(*value))?,
                    None => (0..nx * ny).try_for_each(|_| push(f64::NAN))?,
                }
            }
            Ok(())
        })?;
        archive.list(
            "soft_mode_state",
            soft.iter().map(|row| self.rows[*row].index as i64),
        )?;
        let records = || self.rows.iter().map(|row| &row.record);
        archive.numbers(
            str::to_owned,
            records().map(|s| {
                [
                    s.mean_displacement,
                    given(Dimension::Stress, s.stress),
                    given(Dimension::Driven, s.control),
                    given(Dimension::SurfaceEnergy, s.energy),
                ]
            }),
        )?;
        archive.list("state", self.rows.iter().map(|row| row.index as i64))?;
        archive.list("event", self.rows.iter().map(|row| row.event))?;
        let branches: Vec<String> = records().map(|s| s.direction.to_string()).collect();
        archive.texts("branch", &shape[..1], &branches)?;
        archive.waves("wave_stiffness", (scene, model), &model.grid)?;
        archive.scene(scene, model)?;
        archive.0.finish()?.flush()
    }
}

/// Writes the fields of every point of a diagram, of each branch on its own mesh (ridges, and the
/// flat state, on a line): arrays `BRANCH_gap`, `BRANCH_displacement` and `BRANCH_traction` of the
/// shape (point, row y, column x), and by point what `branches.csv` has.
///
/// # Errors
/// A file that cannot be written.
pub fn write_diagram_fields(
    path: &Path,
    diagram: &Diagram,
    (scene, model): (&Scene, &Model),
) -> Result<(), Failure> {
    files::write_by(path, |file| {
        let mut archive = Archive(ZipWriter::new(BufWriter::new(file)));
        for branch in &diagram.branches {
            archive.branch(branch, diagram.control, (scene, model))?;
        }
        let names: Vec<String> = diagram.branches.iter().map(|b| b.name.clone()).collect();
        archive.texts("branches", &[names.len() as u64], &names)?;
        archive.scene(scene, model)?;
        archive.0.finish()?.flush()
    })
}

/// The number in eight bytes of the scratch file.
fn number_of(bytes: &[u8]) -> f64 {
    f64::from_le_bytes(bytes.try_into().expect("eight of them"))
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
        // Numbers one by one would be summed up one by one, too.
        let mut entry = BufWriter::new(self.entry(name)?);
        let mut array = options.writer(&mut entry).begin_nd()?;
        fill(&mut |value| array.push(&value))?;
        array.finish()?;
        entry.flush()
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

    /// Mean displacement, stress, control and energy by state, under these names.
    fn numbers(
        &mut self,
        name: impl Fn(&str) -> String,
        states: impl ExactSizeIterator<Item = [f64; 4]> + Clone,
    ) -> io::Result<()> {
        for (k, what) in ["mean_displacement", "stress", "control", "energy"]
            .iter()
            .enumerate()
        {
            self.list(&name(what), states.clone().map(|state| state[k]))?;
        }
        Ok(())
    }

    /// The points of a branch.
    fn branch(
        &mut self,
        branch: &Branch,
        driven: Control,
        (scene, model): (&Scene, &Model),
    ) -> io::Result<()> {
        let name = |what: &str| format!("{}_{what}", branch.name);
        let given = |of, value| scene.number_given(of, value);
        let points = &branch.points;
        let (rows, columns) = points
            .first()
            .map_or((0, 0), |point| branch.gap(point).dim());
        let shape = [points.len() as u64, rows as u64, columns as u64];
        let system = &branch.system;
        let height = system.height().map(|height| system.unfolded(height));
        let field = |archive: &mut Self, what: &str, of: &dyn Fn(&Point) -> Array2<f64>| {
            archive.array(&name(what), &shape, |push| {
                let mut fields = points.iter().map(of);
                fields.try_for_each(|field| field.iter().try_for_each(|value| push(*value)))
            })
        };
        field(self, "gap", &|point| branch.gap(point))?;
        field(self, "displacement", &|point| match &height {
            Some(height) => branch.gap(point) + height,
            None => branch.gap(point),
        })?;
        let traction = |gap: f64| given(Dimension::Stress, model.law.at(gap).traction);
        field(self, "traction", &|point| branch.gap(point).mapv(traction))?;
        self.numbers(
            name,
            points.iter().map(|p| {
                [
                    p.state.mean_displacement,
                    given(Dimension::Stress, p.state.stress),
                    given(Dimension::Driven, p.state.control),
                    given(Dimension::SurfaceEnergy, p.state.body_energy(driven)),
                ]
            }),
        )?;
        let least = |p: &Point| p.index[0].min(p.index[1]) as i64;
        self.list(&name("index"), points.iter().map(least))?;
        let kinds: Vec<String> = points.iter().map(|p| p.kind.to_string()).collect();
        self.texts(&name("kind"), &shape[..1], &kinds)?;
        let mesh = Grid {
            nx: columns,
            ny: rows,
            ..*system.grid()
        };
        self.waves(&name("wave_stiffness"), (scene, model), &mesh)
    }

    /// The body's stiffness by wave, in the order of numpy's `fft2`.
    fn waves(
        &mut self,
        name: &str,
        (scene, model): (&Scene, &Model),
        grid: &Grid,
    ) -> io::Result<()> {
        let given = |q| scene.number_given(Dimension::Stiffness, stiffness(model, q));
        self.array(name, &[grid.ny as u64, grid.nx as u64], |push| {
            waves(grid).try_for_each(|q| push(given(q)))
        })
    }

    /// What the fields are of, and which program wrote them.
    fn scene(&mut self, scene: &Scene, model: &Model) -> io::Result<()> {
        self.array("length", &[], |push| push(model.grid.length))?;
        let text = scene_file::to_text(&edit::decided(scene, model));
        self.texts("scene", &[], &[text])?;
        self.texts("program", &[], &[format!("tackscope {VERSION}")])?;
        self.array("format", &[], |push| push(FORMAT))
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
