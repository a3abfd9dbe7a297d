//! `tackscope chart`: every method on the same loop, speed against accuracy.

use super::progress::Teller;
use super::{BAD_INPUT, ChartArguments, DONE, INTERRUPTED, NOT_CONVERGED, cancel_on_interrupt, say};
use crate::experiment::chart::{Chart, Effort, News, Verdict, run};
use crate::storage::{Failure, chart as paper, files, presets, scene_file};

/// Measures the chart, writes its files and returns the exit code.
pub(super) fn chart(arguments: &ChartArguments) -> u8 {
    match try_chart(arguments) {
        Ok(code) => code,
        Err(failure) => {
            eprintln!("tackscope: {failure}");
            BAD_INPUT
        }
    }
}

fn try_chart(arguments: &ChartArguments) -> Result<u8, Failure> {
    let scene = presets::resolve(&arguments.scene)?;
    let refused = |error| scene_file::refused(&arguments.scene, error);
    scene.validate().map_err(refused)?;
    files::prepare_folder(&arguments.out)?;
    let effort = if arguments.quick { Effort::Quick } else { Effort::Full { seconds: arguments.seconds } };
    let mut teller = Teller::new(arguments.quiet, &format!("{}: speed against accuracy", scene.title));
    let chart = run(&scene, effort, &cancel_on_interrupt(), &mut |news| tell(&mut teller, &news)).map_err(refused)?;
    teller.finish();
    let out = &arguments.out;
    paper::write_chart_csv(&out.join("chart.csv"), &chart)?;
    paper::write_chart_json(&out.join("chart.json"), &arguments.scene, &scene, &chart)?;
    paper::write_chart_svg(&out.join("chart.svg"), &chart, &scene.title)?;
    paper::write_chart_png(&out.join("chart.png"), &chart, &scene.title)?;
    if !arguments.quiet {
        say(&closing_words(arguments, &chart));
    }
    Ok(exit_code(&chart, out))
}

fn exit_code(chart: &Chart, out: &std::path::Path) -> u8 {
    let sound = chart.reference.as_ref().is_some_and(|reference| reference.finest.is_complete());
    if chart.cancelled {
        eprintln!("tackscope: interrupted; what was measured is in {}", out.display());
        return INTERRUPTED;
    }
    if !sound {
        eprintln!("tackscope: the reference did not close its loop: there are no errors in {}", out.display());
        return NOT_CONVERGED;
    }
    DONE
}

fn tell(teller: &mut Teller, news: &News<'_>) {
    match news {
        News::Begun { what, reference: true } => teller.note(&format!("reference: {what}")),
        News::Begun { what, reference: false } => teller.now(&what.to_string()),
        News::Fraction(fraction) => teller.fraction(*fraction),
        News::Measured(row) => {
            let (error, seconds) = (row.errors.dissipated_energy, row.processor_seconds);
            let verdict = match &row.verdict {
                Verdict::Failed { message, .. } => format!("FAILED: {message}"),
                verdict => verdict.to_string(),
            };
            teller.note(&format!("{}: error {error:.1e}, {} transforms, {seconds:.2} s: {verdict}", row.point, row.transforms));
        }
        News::Skipped(skipped) => teller.note(&format!("{}: skipped, {skipped}", skipped.point)),
    }
}

/// The one line on standard output.
fn closing_words(arguments: &ChartArguments, chart: &Chart) -> String {
    let failed = chart.rows.iter().filter(|row| matches!(row.verdict, Verdict::Failed { .. })).count();
    let (points, skipped, out) = (chart.rows.len(), chart.skipped.len(), arguments.out.display());
    format!("{points} points measured, {failed} of them failed in a way that is named, {skipped} skipped: written to {out}")
}
