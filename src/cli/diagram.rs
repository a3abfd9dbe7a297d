//! `tackscope diagram`: every branch of equilibria, stable and unstable.

use super::progress::Monitor;
use super::{
    DONE, DiagramArguments, INTERRUPTED, NOT_CONVERGED, cancel_on_signal, failures,
    scene_with_points, warn,
};
use crate::follow::diagram::Diagram;
use crate::plot::diagram_panel::{counts, page};
use crate::plot::ticks::digits;
use crate::storage::export::{write_branches_csv, write_points_csv};
use crate::storage::{Failure, drawing, scene_file};
use crate::study::plan;

/// What is written.
const FILES: [&str; 4] = ["branches.csv", "points.csv", "diagram.svg", "diagram.png"];
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
    let folder = output.claim(&[], ROOM, |name| FILES.contains(&name))?;
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
    let found = plan::diagram(&scene, &cancel, &mut report).map_err(refused)?;
    monitor.finish();
    let [branches, points, svg, png] = FILES.map(|name| folder.join(name));
    let mut title = scene.title.clone();
    if scene.control().frees_mean() {
        title.push_str(" (at fixed u0)");
    }
    let page = page(&found, &model.law, &title);
    let written = [
        write_branches_csv(&branches, &found),
        write_points_csv(&points, &found),
        drawing::write_page_svg(&svg, &page),
        drawing::write_page_png(&png, &page),
    ];
    let code = exit_code(&found, &output.out);
    output.close(&failures(written), code, &counts(&found))
}

fn exit_code(found: &Diagram, out: &std::path::Path) -> u8 {
    for words in &found.missing {
        warn(format_args!("missing: {words}"));
    }
    if found.cancelled {
        let out = out.display();
        warn(format_args!("interrupted; what was found is in {out}"));
        return INTERRUPTED;
    }
    if found.is_complete() {
        DONE
    } else {
        NOT_CONVERGED
    }
}
