//! `tackscope sweep`: the loops of a study, resumed, shared among the jobs of an array and collected.

use super::{
    DONE, INTERRUPTED, Monitor, NOT_CONVERGED, Output, cancel_on_signal, failures,
    scene_with_points, tell, warn,
};
use crate::numerics::threads::Cancel;
use crate::plot::study_panel::sweep_page;
use crate::storage::export::write_convergence_csv;
use crate::storage::files::Folder;
use crate::storage::study_file::{Journal, Known, TABLE};
use crate::storage::{Failure, drawing, files, scene_file, study_file};
use crate::study::map::{convergences, ladder};
use crate::study::sweep::{Point, Row, Study};
use clap::{Args, ValueEnum};
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Pictures of the study, without their endings, and where its numbers converge to.
const PICTURES: &str = "sweep";
const CONVERGENCE: &str = "convergence.csv";
/// Room that a row needs, and the pictures, in bytes.
const ROOM: [u64; 2] = [400, 2_000_000];
/// Most rows that are named one by one.
const NAMED: usize = 8;

/// What `tackscope sweep` is told.
#[derive(Args, Clone, Debug)]
pub(super) struct SweepArguments {
    /// A study file; with --converge a built-in scene or a scene file
    study: String,
    #[command(flatten)]
    output: Output,
    /// Compute only the share I of N, into a folder shard-I-of-N of its own
    #[arg(long, value_name = "I/N", conflicts_with = "collect")]
    shard: Option<Shard>,
    /// Compute nothing: put the rows of all shards into sweep.csv, and say which are missing
    #[arg(long)]
    collect: bool,
    /// The scene on finer and finer meshes: order, limit and error bar of its loss and jumps
    #[arg(long, value_name = "points")]
    converge: Option<Refined>,
    /// Two columns to draw in place of the study's
    #[arg(long, value_name = "X,Y")]
    plot: Option<String>,
}

/// What is refined.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Refined {
    /// The mesh
    Points,
}

/// A share of a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Shard {
    index: usize,
    count: usize,
}

impl std::str::FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('/');
        let numbers = parts.and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        numbers
            .filter(|(index, count)| (1..=*count).contains(index))
            .map(|(index, count)| Self { index, count })
            .ok_or_else(|| format!("\"{text}\" is not I/N with I from 1 to N, as in 3/8"))
    }
}

/// A study under way.
struct Sweep<'a> {
    arguments: &'a SweepArguments,
    study: Study,
    points: Vec<Point>,
    /// What each point is known by.
    hashes: Vec<String>,
    /// What is known, in whichever table.
    rows: HashMap<String, Row>,
}

/// Computes what is not known yet, writes the tables and returns the exit code.
///
/// # Errors
/// A study or an option that is refused, a folder that cannot be written, or a standard output that
/// cannot.
pub(super) fn sweep(arguments: &SweepArguments) -> Result<u8, Failure> {
    let study = study(arguments)?;
    let points = study.points();
    let hashes: Vec<_> = points
        .iter()
        .map(|point| study_file::hash(&study, point))
        .collect();
    let (output, cancel) = (&arguments.output, cancel_on_signal());
    let place = match arguments.shard {
        Some(Shard { index, count }) => study_file::shard_folder(&output.out, index, count),
        None => output.out.clone(),
    };
    let room = ROOM[0] * points.len() as u64 + ROOM[1];
    let folder = Folder::claim(&place, &[], room)?;
    let table = folder.join(TABLE);
    let own = study_file::read_table(&table, &study)?;
    let mut sweep = Sweep {
        arguments,
        study,
        points,
        hashes,
        rows: HashMap::new(),
    };
    sweep.gather(&own)?;
    let mine = sweep.mine();
    let wanted = |i: &usize| !arguments.collect && !sweep.is_known(*i);
    let todo: Vec<usize> = mine.iter().copied().filter(wanted).collect();
    if !todo.is_empty() {
        let journal = Journal::open(&table, &sweep.study, &own)?;
        sweep.compute(&todo, journal, &cancel)?;
    }
    sweep.close(&folder, mine, todo.len(), &cancel)
}

/// The study of the file, or that of a scene on a ladder of meshes.
fn study(arguments: &SweepArguments) -> Result<Study, Failure> {
    let word = &arguments.study;
    let mut study = match arguments.converge {
        Some(Refined::Points) => {
            let (scene, place) = scene_with_points(word, None)?;
            ladder(&scene).map_err(|error| scene_file::refused(&place, error))?
        }
        None => study_file::load(&files::typed(Path::new(word))?)?,
    };
    if let Some(text) = &arguments.plot {
        let refuse = |allowed: &str| Failure::value("command line", "--plot", text, allowed);
        let names = text
            .split_once(',')
            .map(|(x, y)| [x, y].map(|name| name.trim().to_owned()));
        study.plot =
            names.ok_or_else(|| refuse("allowed are two columns, as in law.range,jumps"))?;
        for name in &study.plot {
            study
                .check_name(name)
                .map_err(|all| refuse(&format!("allowed are two of {}", all.join(", "))))?;
        }
    }
    Ok(study)
}

impl Sweep<'_> {
    /// Takes in every table of the folder.
    fn gather(&mut self, own: &Known) -> Result<(), Failure> {
        let known: HashSet<&String> = self.hashes.iter().collect();
        let tables: Vec<PathBuf> = study_file::tables(&self.arguments.output.out);
        let others = tables
            .iter()
            .map(|table| study_file::read_table(table, &self.study));
        let others: Vec<Known> = others.collect::<Result<_, _>>()?;
        for (hash, row) in others.iter().chain([own]).flat_map(|table| &table.rows) {
            if known.contains(hash) {
                self.rows.entry(hash.clone()).or_insert_with(|| row.clone());
            }
        }
        let strangers = own.rows.keys().filter(|hash| !known.contains(hash)).count();
        if self.arguments.output.quiet {
            return Ok(());
        }
        if strangers > 0 {
            warn(format_args!(
                "{strangers} rows of {TABLE} are of other scenes or of another version, and are left out"
            ));
        }
        if own.torn {
            warn(format_args!(
                "the last line of {TABLE} was not finished, and is computed anew"
            ));
        }
        Ok(())
    }

    /// The points that this command is about: one of each scene, of a shard its share of them.
    fn mine(&self) -> Vec<usize> {
        let mut seen = HashSet::new();
        let first = (0..self.points.len()).filter(|i| seen.insert(&self.hashes[*i]));
        let first: Vec<usize> = first.collect();
        match self.arguments.shard {
            Some(Shard { index, count }) => {
                first.into_iter().skip(index - 1).step_by(count).collect()
            }
            None => first,
        }
    }

    /// Computes these points; each row is on the disk before it is told.
    fn compute(
        &mut self,
        todo: &[usize],
        mut journal: Journal,
        cancel: &Cancel,
    ) -> Result<(), Failure> {
        let Self {
            study,
            points,
            hashes,
            rows,
            arguments,
        } = self;
        let known = rows.len();
        let mut heading = format!("{}: {} loops", study.title, todo.len());
        if known > 0 {
            heading.push_str(&format!(", {known} are known"));
        }
        let mut monitor = Monitor::new(arguments.output.quiet, &heading);
        let (began, mut unwritten) = (Instant::now(), None);
        let chosen: Vec<&Point> = todo.iter().map(|i| &points[*i]).collect();
        study.compute(&chosen, cancel, &mut |row, fraction| {
            let hash = &hashes[row.index];
            if let Err(failure) = journal.add(hash, &row) {
                unwritten.get_or_insert(failure);
                cancel.request();
                return;
            }
            rows.insert(hash.clone(), row);
            let done = [rows.len() - known, todo.len()];
            monitor.loops(done, fraction, began.elapsed().as_secs_f64());
        });
        monitor.finish();
        unwritten.map_or(Ok(()), Err)
    }

    /// Writes the table in order, and of a whole study its pictures; says what failed and what is
    /// missing.
    fn close(
        &self,
        folder: &Folder,
        mine: Vec<usize>,
        computed: usize,
        cancel: &Cancel,
    ) -> Result<u8, Failure> {
        let about = match self.arguments.shard {
            Some(_) => mine,
            None => (0..self.points.len()).collect(),
        };
        let row = |i: &usize| {
            let found = self.rows.get(&self.hashes[*i])?;
            Some(Row {
                index: *i,
                values: self.points[*i].values.clone(),
                ..found.clone()
            })
        };
        let rows: Vec<Row> = about.iter().filter_map(row).collect();
        let listed = rows
            .iter()
            .map(|row| (self.hashes[row.index].as_str(), row));
        let table = study_file::write_table(&folder.join(TABLE), &self.study, listed);
        let written = std::iter::once(table).chain(self.pictures(folder, &rows));
        let unwritten = failures(written);
        let missing: Vec<usize> = about.into_iter().filter(|i| !self.is_known(*i)).collect();
        let code = if cancel.requested() && !missing.is_empty() {
            let left = missing.len();
            warn(format_args!(
                "interrupted with {left} rows to go; the same command goes on"
            ));
            INTERRUPTED
        } else {
            judged(&rows, &missing)
        };
        let done = format!("{} loops, {computed} of them now", rows.len());
        self.arguments.output.close(&unwritten, code, &done)
    }

    /// What is written of a whole study beside its table.
    fn pictures(&self, folder: &Folder, rows: &[Row]) -> Vec<Result<(), Failure>> {
        let arguments = self.arguments;
        if arguments.shard.is_some() {
            return Vec::new();
        }
        let page = sweep_page(&self.study, rows);
        let mut written = drawing::write_page(&folder.join(PICTURES), &page).to_vec();
        if arguments.converge.is_some() {
            let found = convergences(&self.study, rows);
            if !arguments.output.quiet {
                found.iter().for_each(|one| tell(&one.to_string()));
            }
            written.push(write_convergence_csv(&folder.join(CONVERGENCE), &found));
        }
        written
    }

    fn is_known(&self, index: usize) -> bool {
        self.rows.contains_key(&self.hashes[index])
    }
}

/// Says which rows failed or are missing; the exit code.
fn judged(rows: &[Row], missing: &[usize]) -> u8 {
    let failed: Vec<&Row> = rows.iter().filter(|row| !row.is_complete()).collect();
    if let Some(first) = failed.first() {
        let (count, of, row) = (failed.len(), rows.len(), first.index + 1);
        let why = &first.reason;
        warn(format_args!(
            "{count} of {of} loops failed, first row {row}: {why}"
        ));
    }
    if !missing.is_empty() {
        let (count, which) = (missing.len(), ranges(missing));
        warn(format_args!("{count} rows are missing: {which}"));
    }
    if failed.is_empty() && missing.is_empty() {
        DONE
    } else {
        NOT_CONVERGED
    }
}

/// Rows as people count them: "3, 7-9".
fn ranges(indices: &[usize]) -> String {
    let runs = indices.chunk_by(|a, b| a + 1 == *b);
    let mut words: Vec<String> = runs
        .map(|run| match run {
            [one] => (one + 1).to_string(),
            [first, .., last] => format!("{}-{}", first + 1, last + 1),
            [] => String::new(),
        })
        .collect();
    if words.len() > NAMED {
        words.truncate(NAMED);
        words.push("...".to_owned());
    }
    words.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_rows_are_told_as_ranges() {
        assert_eq!(ranges(&[2, 6, 7, 8, 11]), "3, 7-9, 12");
    }

    #[test]
    fn a_shard_is_one_of_so_many() {
        let shard = |text: &str| text.parse::<Shard>().ok().map(|s| (s.index, s.count));
        assert_eq!(shard("3/8"), Some((3, 8)));
        for wrong in ["0/8", "9/8", "3", "a/b", "3/", "-1/8", "1/0"] {
            assert_eq!(shard(wrong), None, "{wrong}");
        }
    }
}
