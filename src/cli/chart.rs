//! `tackscope chart`: every method on the same loop, speed against accuracy.

use super::progress::Monitor;
use super::{ChartArguments, DONE, NOT_CONVERGED, cancel_on_signal, failures, interrupted, warn};
use crate::plot::chart_panel::{headline, page};
use crate::storage::export::write_chart_csv;
use crate::storage::summary::write_chart_json;
use crate::storage::{Failure, drawing, presets, scene_file};
use crate::study::chart::{Chart, Effort, News, Verdict, run};

/// What is written, the file that says that all is there last.
const FILES: [&str; 4] = ["chart.csv", "chart.svg", "chart.png", "chart.json"];
/// Room that the files need, in bytes.
const ROOM: u64 = 1_000_000;

/// Measures the chart, writes its files and returns the exit code.
///
/// # Errors
/// A scene that is refused, a folder that cannot be written, or a standard output that cannot.
pub(super) fn chart(arguments: &ChartArguments) -> Result<u8, Failure> {
    let scene = presets::resolve(&arguments.scene)?;
    let refused = |error| scene_file::refused(presets::place(&arguments.scene), error);
    scene.validate().map_err(refused)?;
    let cancel = cancel_on_signal();
    let output = &arguments.output;
    let folder = output.claim(&[], ROOM, |name| FILES.contains(&name))?;
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
    let [csv, picture, _, json] = FILES.map(|name| folder.join(name));
    let mut written = vec![write_chart_csv(&csv, &chart)];
    written.extend(drawing::write_page(&picture, &page(&chart, &scene.title)));
    written.push(write_chart_json(&json, &arguments.scene, &scene, &chart));
    let code = exit_code(&chart, &output.out);
    output.close(&failures(written), code, &closing_words(&chart))
}

fn exit_code(chart: &Chart, out: &std::path::Path) -> u8 {
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
    let mut words = headline(&chart.rows, chart.floor());
    words.push(format!(
        "{points} points measured, {failed} of them failed in a way that is named, {skipped} \
         skipped"
    ));
    words.join(" ")
}
