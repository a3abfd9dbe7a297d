//! What is built in: `tackscope presets` and `lessons`, whether each lesson can be done, `figure` and
//! `table`, the paper's figures and its table, computed anew; and `scene`, what a scene leaves open,
//! decided.

use super::{
    DONE, INTERRUPTED, Monitor, NOT_CONVERGED, Output, cancel_on_signal, decided_with_points,
    failures, interrupted, print, say, warn,
};
use crate::lessons::all;
use crate::numerics::threads::Cancel;
use crate::paper::Finding;
use crate::paper::errata::errata;
use crate::paper::{self, Entry, Figure, GALLERY, Size, Stopped, TABLES, Table, Task, UNDER_LOAD};
use crate::physics::mesh::Grid;
use crate::scene::Scene;
use crate::scene::edit::decided;
use crate::storage::drawing::{Report, write_report};
use crate::storage::files::Folder;
use crate::storage::{self, Failure, drawing, export, scene_file};
use crate::study::reality::reality;
use crate::worker::background::{self, Progress};
use crate::worker::rehearse;
use clap::Args;
use std::path::Path;

/// What `tackscope lessons` is told.
#[derive(Args, Clone, Debug)]
pub(super) struct LessonsArguments {
    /// Perform every lesson, and print what it explains
    #[arg(long)]
    check: bool,
}

/// What `tackscope scene` is told.
#[derive(Args, Clone, Debug)]
pub(super) struct SceneArguments {
    /// A built-in scene (see `tackscope presets`), a scene file, or - for standard input
    scene: String,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Lists the lessons, or performs each and says what it explained; returns the exit code.
///
/// # Errors
/// A standard output that cannot be written.
pub(super) fn lessons(arguments: &LessonsArguments) -> Result<u8, Failure> {
    let cancel = cancel_on_signal();
    let mut code = DONE;
    for lesson in all() {
        let (name, steps) = (&lesson.name, lesson.steps.len());
        say(&format!(
            "{name:<16}  {}: {steps} steps, {} minutes",
            lesson.title, lesson.minutes
        ))?;
        if !arguments.check {
            say(&format!("{:18}{}", "", lesson.teaches))?;
            continue;
        }
        match rehearse(lesson, &of_preset, &cancel) {
            Ok(told) => {
                for (step, words) in told.iter().enumerate() {
                    let words = words.split_whitespace().collect::<Vec<_>>().join(" ");
                    say(&format!("{:16}{} {words}", "", step + 1))?;
                }
            }
            Err(_) if cancel.requested() => return Ok(INTERRUPTED),
            Err(why) => {
                warn(why);
                code = NOT_CONVERGED;
            }
        }
    }
    Ok(code)
}

/// The scene of a preset's name.
fn of_preset(name: &str) -> Result<Scene, String> {
    let preset = storage::preset(name).ok_or_else(|| format!("there is no preset {name}"))?;
    preset.scene().map_err(|failure| failure.to_string())
}

/// Prints name, title, mesh and mu_rho of every preset, and what to look for.
pub(super) fn presets() -> Result<u8, Failure> {
    for preset in storage::presets() {
        for line in entry(preset)? {
            say(&line)?;
        }
    }
    Ok(DONE)
}

/// Prints the decided scene.
pub(super) fn scene(arguments: &SceneArguments) -> Result<u8, Failure> {
    let (scene, model, _) = decided_with_points(&arguments.scene, None)?;
    let decided = decided(&scene, &model);
    let text = if arguments.json {
        scene_file::to_json(&decided)
    } else {
        scene_file::to_text(&decided)
    };
    print(text.trim_end())?;
    // What people read stands beside what programs do.
    warn("is this scene real?");
    reality(&model).iter().for_each(warn);
    Ok(DONE)
}

fn entry(preset: &storage::Preset) -> Result<[String; 4], Failure> {
    let scene = preset.scene()?;
    let model = scene
        .model()
        .map_err(|error| scene_file::refused(preset.name, error))?;
    let Grid { length, nx, ny } = model.grid;
    let facts = format!(
        "L = {length}, {nx} x {ny} points; mu_rho = {:.3}",
        model.mu_rho
    );
    let below = |text: &str| format!("{:16}{text}", "");
    Ok([
        format!("{:<14}  {}", preset.name, scene.title),
        below(&facts),
        below(&preset.hint()),
        String::new(),
    ])
}

/// What `tackscope figure` is told.
#[derive(Args, Clone, Debug)]
pub(super) struct FigureArguments {
    /// The figure's number in the paper, or all
    #[arg(value_name = "N|all")]
    figure: String,
    #[command(flatten)]
    output: Output,
    /// Also write report.html (pictures, findings, Table 1, what the print got wrong) and
    /// findings.csv
    #[arg(long)]
    report: bool,
    /// Coarse meshes and few points: seconds in place of minutes
    #[arg(long)]
    quick: bool,
    /// Drive the tips of Figs 12 and 13 by a load in place of a displacement
    #[arg(long)]
    load: bool,
    /// Measure the law of Fig. 14 on the ground of this scene in place of the paper's
    #[arg(long, value_name = "SCENE", conflicts_with = "load")]
    scene: Option<String>,
}

/// What `tackscope table` is told.
#[derive(Args, Clone, Debug)]
pub(super) struct TableArguments {
    /// The table's number in the paper
    #[arg(value_name = "N")]
    table: String,
    #[command(flatten)]
    output: Output,
}

/// The figure that can be of another scene than the paper's.
const OF_A_SCENE: &str = "14";
/// Room that the files of a figure need, in bytes.
const ROOM: u64 = 1_000_000;
/// What a report consists of.
const SUMMED_UP: [&str; 2] = ["findings.csv", "report.html"];

/// The entries that a word names, the longest first so that none is left alone at the end.
fn chosen(
    FigureArguments {
        figure: word, load, ..
    }: &FigureArguments,
) -> Result<Vec<&'static Entry>, Failure> {
    let gallery = if *load { UNDER_LOAD } else { GALLERY };
    if word == "all" {
        return Ok(paper::longest_first(gallery));
    }
    let number = word.parse::<usize>().ok();
    match gallery.iter().find(|entry| Some(entry.number) == number) {
        Some(entry) => Ok(vec![entry]),
        None => Err(unknown(
            if *load {
                "figure under a load"
            } else {
                "figure"
            },
            word,
            gallery.iter().map(|entry| entry.number),
            " or all",
        )),
    }
}

/// The scene that takes the place of the paper's.
fn scene_of(arguments: &FigureArguments) -> Result<Option<Scene>, Failure> {
    let Some(name) = &arguments.scene else {
        return Ok(None);
    };
    if arguments.figure != OF_A_SCENE {
        let allowed = format!("goes with figure {OF_A_SCENE} alone");
        return Err(Failure::value("command line", "--scene", name, &allowed));
    }
    let scene = storage::resolve(name)?;
    let place = storage::place(name);
    let model = scene.model();
    let model = model.map_err(|error| scene_file::refused(place, error))?;
    if model.indenter.height(&model.grid).is_none() {
        let allowed = format!("ground with heights, for figure {OF_A_SCENE}");
        return Err(Failure::value(place, "indenter.kind", "flat", &allowed));
    }
    Ok(Some(scene))
}

fn unknown(what: &str, word: &str, numbers: impl Iterator<Item = usize>, more: &str) -> Failure {
    let list: Vec<String> = numbers.map(|n| n.to_string()).collect();
    let allowed = format!("{}{more}", list.join(", "));
    Failure::value("command line", what, word, &allowed)
}

/// What came of the figures.
#[derive(Default)]
struct Gathered {
    figures: Vec<(&'static Entry, Figure)>,
    missing: Vec<(usize, Stopped)>,
    unwritten: Vec<Failure>,
}

/// Computes the figures, writes their files and returns the exit code.
///
/// # Errors
/// An unknown number, a folder that cannot be written, or a standard output that cannot.
pub(super) fn figure(arguments: &FigureArguments) -> Result<u8, Failure> {
    let entries = chosen(arguments)?;
    let scene = scene_of(arguments)?;
    let output = &arguments.output;
    let out = &output.out;
    let size = if arguments.quick {
        Size::Quick
    } else {
        Size::Full
    };
    let cancel = cancel_on_signal();
    let folder = output.claim(&[], ROOM * entries.len() as u64, |name| {
        let summed_up = arguments.report && SUMMED_UP.contains(&name);
        summed_up || entries.iter().any(|entry| is_of(&stem(entry.number), name))
    })?;
    let what = if entries.len() == 1 {
        "1 figure".to_owned()
    } else {
        format!("{} figures", entries.len())
    };
    let monitor = Monitor::new(
        output.quiet,
        &format!("{what} of the paper, computed anew into {}", out.display()),
    );
    let mut gathered = gather(&entries, (size, scene.as_ref()), &cancel, &monitor, &folder);
    monitor.finish();
    gathered.figures.sort_by_key(|(entry, _)| entry.number);
    gathered.missing.sort_by_key(|(number, _)| *number);
    if arguments.report {
        let unwritten = report(&gathered, size, &cancel, &folder);
        gathered.unwritten.extend(unwritten);
    }
    for (number, why) in gathered
        .missing
        .iter()
        .filter(|(_, why)| *why != Stopped::Cancelled)
    {
        warn(format_args!("Fig. {number}: {why}"));
    }
    let code = exit_code(&gathered.missing, out);
    output.close(&gathered.unwritten, code, &closing_words(&gathered))
}

fn exit_code(missing: &[(usize, Stopped)], out: &Path) -> u8 {
    match missing {
        [] => DONE,
        _ if missing.iter().any(|(_, why)| *why == Stopped::Cancelled) => {
            interrupted("what was computed", out)
        }
        _ => NOT_CONVERGED,
    }
}

/// Computes, and writes each figure as soon as it is there.
fn gather(
    entries: &[&'static Entry],
    (size, scene): (Size, Option<&Scene>),
    cancel: &Cancel,
    monitor: &Monitor,
    out: &Folder,
) -> Gathered {
    let mut gathered = Gathered::default();
    let mut shares = vec![0.0; entries.len()];
    background::compute(
        entries,
        size,
        scene,
        cancel,
        &mut |progress| match progress {
            Progress::Working { index, done, what } => {
                shares[index] = done;
                monitor.fraction(shares.iter().sum::<f64>() / shares.len() as f64);
                monitor.now(&format!("Fig. {}: {what}", entries[index].number));
            }
            Progress::Done {
                index,
                figure,
                seconds,
            } => {
                shares[index] = 1.0;
                monitor.fraction(shares.iter().sum::<f64>() / shares.len() as f64);
                let entry = entries[index];
                match figure {
                    Ok(figure) => {
                        let words = findings_in_words(&figure.findings);
                        monitor.note(&format!(
                            "Fig. {}: {} ({seconds:.1} s{words})",
                            entry.number, entry.title
                        ));
                        gathered.unwritten.extend(write_figure(out, &figure));
                        gathered.figures.push((entry, figure));
                    }
                    Err(why) => gathered.missing.push((entry.number, why)),
                }
            }
        },
    );
    gathered
}

/// Writes `report.html` and `findings.csv` about what there is, also after a request to stop;
/// returns what could not be written.
fn report(gathered: &Gathered, size: Size, cancel: &Cancel, out: &Folder) -> Vec<Failure> {
    let mut missing: Vec<String> = gathered
        .missing
        .iter()
        .map(|(number, why)| format!("Fig. {number}: {why}"))
        .collect();
    let mut tables = Vec::new();
    for entry in TABLES {
        match (entry.compute)(&mut Task::new(size, cancel, &mut |_, _| {})) {
            Ok(table) => tables.push(table),
            Err(why) => missing.push(format!("Table {}: {why}", entry.number)),
        }
    }
    let errata = errata(&mut Task::new(size, cancel, &mut |_, _| {})).unwrap_or_else(|why| {
        missing.push(format!("errata: {why}"));
        Vec::new()
    });
    let of_figures = gathered.figures.iter().flat_map(|(_, f)| {
        f.findings
            .iter()
            .map(|finding| (format!("Fig. {}", f.number), finding))
    });
    let of_tables = tables.iter().flat_map(|t| {
        t.findings
            .iter()
            .map(|finding| (format!("Table {}", t.number), finding))
    });
    let [findings, page] = SUMMED_UP.map(|name| out.join(name));
    let figures = gathered
        .figures
        .iter()
        .map(|(entry, figure)| (figure, entry.look_for))
        .collect();
    let report = Report {
        figures,
        tables: tables.iter().collect(),
        errata: &errata,
        missing,
    };
    failures([
        export::write_findings_csv(&findings, of_figures.chain(of_tables)),
        write_report(&page, &report),
    ])
}

/// ", 3 of 4 findings agree", or nothing.
fn findings_in_words(findings: &[Finding]) -> String {
    let judged: Vec<bool> = findings.iter().filter_map(Finding::agrees).collect();
    let agree = judged.iter().filter(|agrees| **agrees).count();
    if judged.is_empty() {
        String::new()
    } else {
        format!(", {agree} of {} findings agree", judged.len())
    }
}

/// What the files of a figure begin with.
fn stem(number: usize) -> String {
    format!("figure-{number:02}")
}

/// True for `figure-02.csv`, `figure-02-map-a.csv` and the like.
fn is_of(stem: &str, name: &str) -> bool {
    name.strip_prefix(stem)
        .is_some_and(|end| end.starts_with(['.', '-']))
}

/// Writes the files of a figure; returns those that could not be written.
fn write_figure(out: &Folder, figure: &Figure) -> Vec<Failure> {
    let stem = out.join(stem(figure.number));
    let table = export::write_figure_csv(&stem.with_extension("csv"), figure);
    let pictures = drawing::write_page(&stem, &figure.page());
    failures([table].into_iter().chain(pictures))
}

/// The one line on standard output.
fn closing_words(gathered: &Gathered) -> String {
    let findings: Vec<Finding> = gathered
        .figures
        .iter()
        .flat_map(|(_, figure)| figure.findings.clone())
        .collect();
    let words = findings_in_words(&findings);
    let missing = if gathered.missing.is_empty() {
        String::new()
    } else {
        format!(", {} missing", gathered.missing.len())
    };
    let count = gathered.figures.len();
    format!(
        "{count} figure{}{missing}{words}",
        if count == 1 { "" } else { "s" }
    )
}

/// Computes a table, writes its files and returns the exit code.
///
/// # Errors
/// As [`figure`].
pub(super) fn table(arguments: &TableArguments) -> Result<u8, Failure> {
    let number = arguments.table.parse::<usize>().ok();
    let entry = TABLES.iter().find(|entry| Some(entry.number) == number);
    let entry = entry.ok_or_else(|| {
        unknown(
            "table",
            &arguments.table,
            TABLES.iter().map(|entry| entry.number),
            "",
        )
    })?;
    let output = &arguments.output;
    let cancel = cancel_on_signal();
    let folder = output.claim(&[], ROOM, |name| {
        is_of(&format!("table-{}", entry.number), name)
    })?;
    match (entry.compute)(&mut Task::new(Size::Full, &cancel, &mut |_, _| {})) {
        Ok(table) => {
            let findings = findings_in_words(&table.findings);
            let done = format!("Table {}: {}{findings}", entry.number, entry.title);
            output.close(&write_table(&folder, &table), DONE, &done)
        }
        Err(Stopped::Cancelled) => Ok(INTERRUPTED),
        Err(why) => {
            warn(format_args!("Table {}: {why}", entry.number));
            Ok(NOT_CONVERGED)
        }
    }
}

fn write_table(out: &Folder, table: &Table) -> Vec<Failure> {
    let stem = out.join(format!("table-{}", table.number));
    let text = export::write_table_csv(&stem.with_extension("csv"), table);
    failures([text].into_iter().chain(drawing::write_table(&stem, table)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_decides_on_the_exit_code() {
        let failed = (5, Stopped::Failed("no convergence".to_owned()));
        let codes = [
            vec![],
            vec![failed.clone()],
            vec![failed, (6, Stopped::Cancelled)],
        ]
        .map(|missing| exit_code(&missing, Path::new("")));
        assert_eq!(codes, [0, 3, 130]);
    }
}
