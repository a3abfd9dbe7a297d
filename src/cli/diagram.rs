//! `tackscope diagram`: every branch of equilibria, stable and unstable.

use super::progress::Monitor;
use super::{
    DONE, DiagramArguments, NOT_CONVERGED, cancel_on_signal, failures, interrupted,
    scene_with_points, warn,
};
use crate::follow::diagram::Diagram;
use crate::plot::diagram_panel::{counts, page};
use crate::plot::ticks::digits;
use crate::scene::window;
use crate::storage::export::{write_barriers_csv, write_branches_csv, write_points_csv};
use crate::storage::fields::write_diagram_fields;
use crate::storage::{Failure, drawing, scene_file};
use crate::study::landscape::{Ground, Saddle};
use crate::study::plan;

/// What is written.
const FILES: [&str; 4] = ["branches.csv", "points.csv", "diagram.svg", "diagram.png"];
/// What is written if it is asked for.
const BARRIERS: &str = "barriers.csv";
/// Likewise.
const FIELDS: &str = "fields.npz";
/// Room that the files need, in bytes.
const ROOM: u64 = 4_000_000;

/// Computes the diagram, writes its files and returns the exit code.
///
/// # Errors
/// A scene that is refused, a folder that cannot be written, or a standard output that cannot.
pub(super) fn diagram(arguments: &DiagramArguments) -> Result<u8, Failure> {
    let (scene, place) = scene_with_points(&arguments.scene, arguments.points)?;
    let refused = |error| scene_file::refused(&place, error);
    let model = scene.model().map_err(refused)?;
    let cancel = cancel_on_signal();
    let output = &arguments.output;
    let folder = output.claim(&[], ROOM, |name| {
        [BARRIERS, FIELDS].contains(&name) || FILES.contains(&name)
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
    let [branches, points, picture, _] = FILES.map(|name| folder.join(name));
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
    let page = page(&found, &model, &scene.title);
    written.extend([
        write_branches_csv(&branches, &found, &scene),
        write_points_csv(&points, &found, &scene),
    ]);
    written.extend(drawing::write_page(&picture, &page));
    let code = exit_code(&found, &output.out);
    output.close(&failures(written), code, &counts(&found))
}

/// The saddles at `count` places of the drive, each with its value of the control, and which are
/// missing, in words.
fn saddles(ground: Ground<'_>, count: u16, monitor: &Monitor) -> (Vec<(f64, Saddle)>, Vec<String>) {
    let (low, high) = window::of_control(ground.scene, ground.model);
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

fn exit_code(found: &Diagram, out: &std::path::Path) -> u8 {
    for words in &found.missing {
        warn(format_args!("missing: {words}"));
    }
    if found.cancelled {
        interrupted("what was found", out)
    } else if found.is_complete() {
        DONE
    } else {
        NOT_CONVERGED
    }
}
