//! `tackscope diagram`, `map`, `chart` and `ground`: what is computed of a scene in one go and written
//! as tables with one picture: every branch of equilibria, stable and unstable; where every jump
//! lies as one parameter goes; every method on the same loop, speed against accuracy; the ground
//! before anything runs.

use super::{
    DONE, Monitor, NOT_CONVERGED, Output, cancel_on_signal, decided_with_points, failures,
    interrupted, scene_with_points, warn,
};
use crate::physics::indenter::{Indenter, Measured};
use crate::physics::mesh::Grid;
use crate::physics::parameter::{Own, Refusal};
use crate::plot::scale::digits;
use crate::plot::{chart_panel, diagram_panel, study_panel};
use crate::storage::export::{
    write_barriers_csv, write_branches_csv, write_chart_csv, write_chart_json, write_ground_json,
    write_heights_csv, write_map_csv, write_points_csv, write_spectrum_csv,
};
use crate::storage::fields::write_diagram_fields;
use crate::storage::{self, Failure, Opened, drawing, files, open, scene_file};
use crate::study::chart::{Chart, Effort, News, Verdict, run};
use crate::study::ground::GroundReport;
use crate::study::landscape::{Ground, Saddle};
use crate::study::map::{PatternMap, Row, Vary};
use crate::study::plan;
use clap::Args;
use std::path::Path;

/// What `tackscope diagram` is told.
#[derive(Args, Clone, Debug)]
pub(super) struct DiagramArguments {
    /// A built-in scene (see `tackscope presets`), a scene file, or - for standard input
    scene: String,
    #[command(flatten)]
    output: Output,
    /// Points a side in place of the scene's (a line cell stays a line)
    #[arg(long, value_name = "N")]
    points: Option<usize>,
    /// Also writes barriers.csv: every saddle at N places of the drive, and what it separates
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    barriers: Option<u16>,
    /// Also writes fields.npz: gap, displacement and traction of every point, for numpy
    #[arg(long)]
    fields: bool,
}

/// What is written of a diagram.
const DIAGRAM: [&str; 4] = ["branches.csv", "points.csv", "diagram.svg", "diagram.png"];
/// What is written if it is asked for.
const BARRIERS: &str = "barriers.csv";
/// Likewise.
const FIELDS: &str = "fields.npz";
/// Room that the files of a diagram or a map need, in bytes.
const ROOM: u64 = 4_000_000;

/// Computes the diagram, writes its files and returns the exit code.
///
/// # Errors
/// A scene that is refused, a folder that cannot be written, or a standard output that cannot.
pub(super) fn diagram(arguments: &DiagramArguments) -> Result<u8, Failure> {
    let (scene, model, place) = decided_with_points(&arguments.scene, arguments.points)?;
    let refused = |error| scene_file::refused(&place, error);
    let cancel = cancel_on_signal();
    let output = &arguments.output;
    let folder = output.claim(&[], ROOM, |name| {
        [BARRIERS, FIELDS].contains(&name) || DIAGRAM.contains(&name)
    })?;
    let monitor = Monitor::new(
        output.quiet,
        &format!("{}: every branch of equilibria", scene.title),
    );
    let mut under_way = String::new();
    let mut report = |branch: &str, points: usize, u0: f64| {
        if under_way != branch {
            monitor.note(&format!("following the branch \"{branch}\""));
            branch.clone_into(&mut under_way);
        }
        let u0 = digits(u0, 0.01 * scene.drive.step);
        monitor.now(&format!("{branch}: {points} points, u0 = {u0}"));
    };
    let mut found = plan::diagram(&scene, &cancel, &mut report).map_err(refused)?;
    let ground = Ground {
        scene: &scene,
        model: &model,
        diagram: &found,
        cancel: &cancel,
    };
    let barriers = arguments.barriers.map(|count| {
        let (saddles, missing) = saddles(ground, count, &monitor);
        let written = write_barriers_csv(&folder.join(BARRIERS), ground, &saddles);
        (written, missing)
    });
    monitor.finish();
    let [branches, points, picture, _] = DIAGRAM.map(|name| folder.join(name));
    let mut written = Vec::new();
    if let Some((barriers, missing)) = barriers {
        written.push(barriers);
        found.missing.extend(missing);
        found.cancelled |= cancel.requested();
    }
    if arguments.fields {
        let path = folder.join(FIELDS);
        written.push(write_diagram_fields(&path, &found, (&scene, &model)));
    }
    let page = diagram_panel::page(&found, &model, &scene.title);
    written.extend([
        write_branches_csv(&branches, &found, &scene),
        write_points_csv(&points, &found, &scene),
    ]);
    written.extend(drawing::write_page(&picture, &page));
    for words in &found.missing {
        warn(format_args!("missing: {words}"));
    }
    let code = if found.cancelled {
        interrupted("what was found", &output.out)
    } else if found.is_complete() {
        DONE
    } else {
        NOT_CONVERGED
    };
    output.close(&failures(written), code, &diagram_panel::counts(&found))
}

/// The saddles at `count` places of the drive, each with its value of the control, and which are
/// missing, in words.
fn saddles(ground: Ground<'_>, count: u16, monitor: &Monitor) -> (Vec<(f64, Saddle)>, Vec<String>) {
    let (low, high) = ground.scene.window_of_control(ground.model);
    let (mut found, mut missing) = (Vec::new(), Vec::new());
    for i in 0..count {
        let share = (f64::from(i) + 0.5) / f64::from(count);
        let control = high - share * (high - low);
        monitor.now(&format!("saddles: {} of {count} places", i + 1));
        monitor.fraction(share);
        let Ok(here) = ground.saddles(control) else {
            break;
        };
        let at = |words: String| format!("{words} at {control:.5}");
        missing.extend(here.missing.into_iter().map(at));
        let saddles = here.found.into_iter();
        found.extend(saddles.map(|(saddle, _)| (control, saddle)));
    }
    (found, missing)
}

/// What `tackscope map` is told.
#[derive(Args, Clone, Debug)]
pub(super) struct MapArguments {
    /// A built-in scene (see `tackscope presets`), a scene file, or - for standard input
    scene: String,
    /// The parameter of the scene file that goes, and its ends, as in law.range=0.5..2
    #[arg(long, value_name = "KEY=A..B")]
    vary: Vary,
    #[command(flatten)]
    output: Output,
    /// Values of the parameter; by equal factors where its ends are a factor of two or more apart
    #[arg(long, value_name = "N", default_value_t = 97, value_parser = clap::value_parser!(u32).range(2..=10_000))]
    rows: u32,
    /// Points a side in place of the scene's (a line cell stays a line), where loops are walked
    #[arg(long, value_name = "N")]
    points: Option<usize>,
}

/// What is written of a map.
const MAP: [&str; 3] = ["map.csv", "map.svg", "map.png"];

/// Computes the map, writes its files and returns the exit code.
///
/// # Errors
/// A scene or a parameter that is refused, a folder that cannot be written, or a standard output
/// that cannot.
pub(super) fn map(arguments: &MapArguments) -> Result<u8, Failure> {
    let (scene, place) = scene_with_points(&arguments.scene, arguments.points)?;
    let refused = |error| scene_file::refused(&place, error);
    let (vary, cancel) = (&arguments.vary, cancel_on_signal());
    let output = &arguments.output;
    let folder = output.claim(&[], ROOM, |name| MAP.contains(&name))?;
    let monitor = Monitor::new(
        output.quiet,
        &format!(
            "{}: {} from {} to {}",
            scene.title, vary.key, vary.from, vary.to
        ),
    );
    let step = (vary.to - vary.from).abs() / f64::from(arguments.rows);
    let mut told = |row: &Row, done: f64| {
        let value = digits(row.value, 0.1 * step);
        monitor.now(&format!("{:.0} %: {} = {value}", 100.0 * done, vary.key));
    };
    let found = PatternMap::of(&scene, vary, arguments.rows as usize, &cancel, &mut told)
        .map_err(refused)?;
    monitor.finish();
    let [csv, picture, _] = MAP.map(|name| folder.join(name));
    let pictures = drawing::write_page(&picture, &study_panel::map_page(&found, &scene));
    let written = [write_map_csv(&csv, &found)].into_iter().chain(pictures);
    let missing = found.missing().count();
    if let Some((value, why)) = found.missing().next() {
        warn(format_args!(
            "no loop at {missing} of {} values, first at {value}: {why}",
            found.rows.len()
        ));
    }
    let code = if found.cancelled {
        interrupted("what was found", &output.out)
    } else if missing == 0 {
        DONE
    } else {
        NOT_CONVERGED
    };
    output.close(
        &failures(written),
        code,
        &format!("{} loops", found.rows.len()),
    )
}

/// Longest time that a chart may be given.
const SECONDS_MAX: f64 = 1e6;

/// What `tackscope chart` is told.
#[derive(Args, Clone, Debug)]
pub(super) struct ChartArguments {
    /// A built-in scene (see `tackscope presets`), a scene file, or - for standard input
    scene: String,
    #[command(flatten)]
    output: Output,
    /// Only coarse meshes and long steps: seconds in place of minutes
    #[arg(long)]
    quick: bool,
    /// Processor time to spend, in seconds; what does not fit is skipped, and said to be
    #[arg(
        long,
        value_name = "S",
        default_value_t = 180.0,
        conflicts_with = "quick"
    )]
    #[arg(value_parser = seconds, allow_negative_numbers = true)]
    seconds: f64,
}

/// A budget of processor time.
fn seconds(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(seconds) if seconds > 0.0 && seconds <= SECONDS_MAX => Ok(seconds),
        _ => Err(format!(
            "allowed is a number above 0, at most {SECONDS_MAX} (eleven days)"
        )),
    }
}

/// What is written of a chart, the file that says that all is there last.
const CHART: [&str; 4] = ["chart.csv", "chart.svg", "chart.png", "chart.json"];
/// Room that its files need, in bytes.
const CHART_ROOM: u64 = 1_000_000;

/// Measures the chart, writes its files and returns the exit code.
///
/// # Errors
/// A scene that is refused, a folder that cannot be written, or a standard output that cannot.
pub(super) fn chart(arguments: &ChartArguments) -> Result<u8, Failure> {
    let scene = storage::resolve(&arguments.scene)?;
    let refused = |error| scene_file::refused(storage::place(&arguments.scene), error);
    scene.validate().map_err(refused)?;
    let cancel = cancel_on_signal();
    let output = &arguments.output;
    let folder = output.claim(&[], CHART_ROOM, |name| CHART.contains(&name))?;
    let effort = if arguments.quick {
        Effort::Quick
    } else {
        Effort::Full {
            seconds: arguments.seconds,
        }
    };
    let mut monitor = Monitor::new(
        output.quiet,
        &format!("{}: speed against accuracy", scene.title),
    );
    let chart = run(&scene, effort, &cancel, &mut |news| {
        tell(&mut monitor, &news);
    })
    .map_err(refused)?;
    monitor.finish();
    let [csv, picture, _, json] = CHART.map(|name| folder.join(name));
    let mut written = vec![write_chart_csv(&csv, &chart)];
    written.extend(drawing::write_page(
        &picture,
        &chart_panel::page(&chart, &scene.title),
    ));
    written.push(write_chart_json(&json, &arguments.scene, &scene, &chart));
    let code = chart_code(&chart, &output.out);
    output.close(&failures(written), code, &closing_words(&chart))
}

fn chart_code(chart: &Chart, out: &Path) -> u8 {
    let reference = chart.reference.as_ref();
    if chart.cancelled {
        interrupted("what was measured", out)
    } else if reference.is_some_and(|reference| reference.finest.is_complete()) {
        DONE
    } else {
        let out = out.display();
        warn(format_args!(
            "the reference did not close its loop: there are no errors in {out}"
        ));
        NOT_CONVERGED
    }
}

fn tell(monitor: &mut Monitor, news: &News<'_>) {
    match news {
        News::Begun {
            what,
            reference: true,
        } => monitor.note(&format!("reference: {what}")),
        News::Begun {
            what,
            reference: false,
        } => monitor.now(&what.to_string()),
        News::Fraction(fraction) => monitor.fraction(*fraction),
        News::Measured(row) => {
            let (error, seconds) = (row.errors.dissipated_energy, row.processor_seconds);
            let verdict = match &row.verdict {
                Verdict::Failed { message, .. } => format!("FAILED: {message}"),
                verdict => verdict.to_string(),
            };
            monitor.note(&format!(
                "{}: error {error:.1e}, {} transforms, {seconds:.2} s: {verdict}",
                row.point, row.transforms
            ));
        }
        News::Skipped(skipped) => monitor.note(&format!("{}: skipped, {skipped}", skipped.point)),
    }
}

/// The one line on standard output.
fn closing_words(chart: &Chart) -> String {
    let failed = chart
        .rows
        .iter()
        .filter(|row| matches!(row.verdict, Verdict::Failed { .. }))
        .count();
    let (points, skipped) = (chart.rows.len(), chart.skipped.len());
    let mut words = chart_panel::headline(&chart.rows, chart.floor());
    words.push(format!(
        "{points} points measured, {failed} of them failed in a way that is named, {skipped} \
         skipped"
    ));
    words.join(" ")
}

/// What `tackscope ground` is told.
#[derive(Args, Clone, Debug)]
pub(super) struct GroundArguments {
    /// A built-in scene (see `tackscope presets`), a scene file, a height file, or - for a scene from
    /// standard input
    #[arg(value_name = "SCENE|FILE")]
    scene: String,
    #[command(flatten)]
    output: Output,
    /// Points a side in place of the scene's, or of a height file's
    #[arg(long, value_name = "N")]
    points: Option<usize>,
}

/// What is written of the ground.
const GROUND: [&str; 5] = [
    "ground.json",
    "spectrum.csv",
    "heights.csv",
    "ground.svg",
    "ground.png",
];
/// Room that its files need, in bytes.
const GROUND_ROOM: u64 = 40_000_000;

/// Looks at the ground, writes its files and returns the exit code.
///
/// # Errors
/// A scene or a height file that is refused, flat ground, a folder that cannot be written, or a
/// standard output that cannot.
pub(super) fn ground(arguments: &GroundArguments) -> Result<u8, Failure> {
    let (report, title) = report(arguments)?;
    let output = &arguments.output;
    let folder = output.claim(&[], GROUND_ROOM, |name| GROUND.contains(&name))?;
    let [json, spectrum, heights, picture, _] = GROUND.map(|name| folder.join(name));
    let page = diagram_panel::ground_page(&report, &title);
    let tables = [
        write_ground_json(&json, &report),
        write_spectrum_csv(&spectrum, &report),
        write_heights_csv(&heights, &report),
    ];
    let written = tables
        .into_iter()
        .chain(drawing::write_page(&picture, &page));
    if !output.quiet {
        report.words.iter().for_each(warn);
    }
    output.close(&failures(written), DONE, &page.caption[0])
}

/// The report with its title: on the mesh of the scene, or on the points of the file.
fn report(arguments: &GroundArguments) -> Result<(GroundReport, String), Failure> {
    let word = arguments.scene.as_str();
    let path = files::typed(Path::new(word))?;
    if storage::preset(word).is_none()
        && path.exists()
        && let Opened::Heights(topography) = open(&path)?
    {
        let measured = Measured::new(topography);
        let refused = |error: Refusal| scene_file::refused(word, error);
        measured.check().map_err(refused)?;
        let line = measured.topography().heights.nrows() == 1;
        let n = arguments.points.unwrap_or_else(|| own_points(&measured));
        let indenter = Indenter::Measured(measured);
        let length = indenter.ground().period().unwrap_or(1.0);
        let grid = if line {
            Grid::line(length, n)
        } else {
            Grid::square(length, n)
        };
        let report = GroundReport::of(&indenter, &grid, None);
        return Ok((report.expect("there is a map"), word.to_owned()));
    }
    let (scene, model, place) = decided_with_points(word, arguments.points)?;
    let report = GroundReport::of(&model.indenter, &model.grid, Some(&model.law));
    let report = report.ok_or_else(|| {
        let allowed = "allowed is ground with heights; flat ground has none to look at";
        Failure::value(&place, "indenter.kind", "\"flat\"", allowed)
    })?;
    Ok((report.in_units(scene.units), scene.title))
}

/// An even number of points that shows all that a file has.
fn own_points(measured: &Measured) -> usize {
    let worked = measured.worked().as_ref();
    let periodic = worked.map(|worked| worked.levelled.periodic(measured.periodic()).dim());
    periodic.map_or(0, |(ny, nx)| nx.max(ny).next_multiple_of(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_budget_is_a_finite_number_above_zero() {
        for word in ["nan", "-5", "0", "inf", "1e7", "", "3 s"] {
            assert!(seconds(word).is_err(), "{word}");
        }
        assert_eq!(
            ["1e-9", "180", "1e6"].map(|word| seconds(word).unwrap()),
            [1e-9, 180.0, 1e6]
        );
    }
}
