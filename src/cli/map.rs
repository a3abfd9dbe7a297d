//! `tackscope map`: where every jump lies as one parameter goes.

use super::progress::Monitor;
use super::{
    DONE, NOT_CONVERGED, Output, cancel_on_signal, failures, interrupted, scene_with_points, warn,
};
use crate::plot::study_panel::map_page;
use crate::plot::ticks::digits;
use crate::storage::export::write_map_csv;
use crate::storage::{Failure, drawing, scene_file};
use crate::study::map::{PatternMap, Row, Vary};
use clap::Args;

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

/// What is written.
const FILES: [&str; 3] = ["map.csv", "map.svg", "map.png"];
/// Room that the files need, in bytes.
const ROOM: u64 = 4_000_000;

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
    let folder = output.claim(&[], ROOM, |name| FILES.contains(&name))?;
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
    let [csv, picture, _] = FILES.map(|name| folder.join(name));
    let pictures = drawing::write_page(&picture, &map_page(&found, &scene));
    let written = [write_map_csv(&csv, &found)].into_iter().chain(pictures);
    let code = exit_code(&found, &output.out);
    output.close(
        &failures(written),
        code,
        &format!("{} loops", found.rows.len()),
    )
}

fn exit_code(found: &PatternMap, out: &std::path::Path) -> u8 {
    let missing = found.missing().count();
    if let Some((value, why)) = found.missing().next() {
        warn(format_args!(
            "no loop at {missing} of {} values, first at {value}: {why}",
            found.rows.len()
        ));
    }
    if found.cancelled {
        interrupted("what was found", out)
    } else if missing == 0 {
        DONE
    } else {
        NOT_CONVERGED
    }
}
