//! `tackscope diagram`: every branch of equilibria, stable and unstable.

use super::progress::Monitor;
use super::{
    BAD_INPUT, DONE, DiagramArguments, INTERRUPTED, NOT_CONVERGED, cancel_on_signal, say,
    tell_replaced, unwritten, warn,
};
use crate::follow::diagram::Diagram;
use crate::plot::diagram_panel::{counts, page};
use crate::plot::ticks::digits;
use crate::scene::part::{Part, Strategy};
use crate::storage::folder::Folder;
use crate::storage::{Failure, diagram as table, drawing, scene_file};
use crate::study::plan::plan;

/// What is written.
const FILES: [&str; 4] = ["branches.csv", "points.csv", "diagram.svg", "diagram.png"];
/// Room that the files need, in bytes.
const ROOM: u64 = 4_000_000;

/// Computes the diagram, writes its files and returns the exit code.
///
/// # Errors
/// A scene that is refused, a folder that cannot be written, or a standard output that cannot.
pub(super) fn diagram(arguments: &DiagramArguments) -> Result<u8, Failure> {
    let (scene, place) = super::scene_with_points(&arguments.scene, arguments.points)?;
    let refused = |error| scene_file::refused(&place, error);
    let model = scene.model().map_err(refused)?;
    let part = match plan(&scene, &model, None).strategy {
        Strategy::Walk(part) => part,
        Strategy::Atlas => Part::Whole,
    };
    let cancel = cancel_on_signal();
    let folder = Folder::claim(&arguments.out, &[], ROOM)?;
    let earlier = folder.clear(&[], |name| FILES.contains(&name))?;
    if !arguments.quiet {
        tell_replaced(earlier, &arguments.out);
    }
    let monitor = Monitor::new(
        arguments.quiet,
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
    let found = Diagram::of(&scene, part, &cancel, &mut report).map_err(refused)?;
    monitor.finish();
    let [branches, points, svg, png] = FILES.map(|name| folder.join(name));
    let page = page(&found, &model.law, &scene.title);
    let written = [
        table::write_branches_csv(&branches, &found),
        table::write_points_csv(&points, &found),
        drawing::write_page_svg(&svg, &page),
        drawing::write_page_png(&png, &page),
    ];
    let failures: Vec<Failure> = written.into_iter().filter_map(Result::err).collect();
    found
        .missing
        .iter()
        .for_each(|words| warn(format_args!("missing: {words}")));
    if unwritten(&failures) {
        return Ok(BAD_INPUT);
    }
    let out = arguments.out.display();
    if found.cancelled {
        warn(format_args!("interrupted; what was found is in {out}"));
        return Ok(INTERRUPTED);
    }
    if !arguments.quiet {
        say(&format!("{}: written to {out}", counts(&found)))?;
    }
    Ok(if found.is_complete() {
        DONE
    } else {
        NOT_CONVERGED
    })
}
