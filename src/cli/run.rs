//! `tackscope run`: a closed loop without a window.

use super::progress::Teller;
use super::report::{self, Timed};
use super::{BAD_INPUT, DONE, INTERRUPTED, NOT_CONVERGED, RunArguments, cancel_on_interrupt, say};
use crate::experiment::run::{LoopRun, Outcome, run_loop};
use crate::experiment::scene::{Model, Points, Scene, SceneError};
use crate::numerics::cancel::Cancel;
use crate::solver::method::MethodKind;
use crate::storage::{Failure, files, presets, scene_file, summary};
use cpu_time::ProcessTime;
use std::time::Instant;

/// Computes the loop, writes its files and returns the exit code.
pub(super) fn run(arguments: &RunArguments) -> u8 {
    match try_run(arguments) {
        Ok(code) => code,
        Err(failure) => {
            eprintln!("tackscope: {failure}");
            BAD_INPUT
        }
    }
}

fn try_run(arguments: &RunArguments) -> Result<u8, Failure> {
    if arguments.yardstick && arguments.method == MethodKind::Gfmd {
        return Err(Failure::Value {
            file: "command line".to_owned(),
            key: "--yardstick".to_owned(),
            value: "with --method gfmd".to_owned(),
            allowed: "the yardstick is gfmd itself; leave one of the two out".to_owned(),
        });
    }
    let (scene, place) = scene(arguments)?;
    let refused = |error: SceneError| scene_file::refused(&place, error);
    let model = scene.model().map_err(refused)?;
    files::prepare_folder(&arguments.out)?;
    let cancel = cancel_on_interrupt();

    let main = timed(arguments, &scene, &model, arguments.method, &cancel).map_err(refused)?;
    report::write_results(&arguments.out, &scene, &model, &main.run)?;
    let mut told = report::summary(&arguments.scene, &scene, &model, arguments.method.word(), &main);
    let summary_path = arguments.out.join("summary.json");
    summary::write_summary(&summary_path, &told)?;
    if arguments.yardstick && main.run.outcome == Outcome::Completed {
        let other = timed(arguments, &scene, &model, MethodKind::Gfmd, &cancel).map_err(refused)?;
        told.yardstick = Some(report::yardstick(&model, &main, &other));
        summary::write_summary(&summary_path, &told)?;
    }
    if let (Some(warning), false) = (model.warning(), arguments.quiet) {
        eprintln!("tackscope: {warning}");
    }
    if !arguments.quiet {
        say(&closing_words(arguments, &model, &main.run, told.yardstick.as_ref()));
    }
    if let Some(reason) = told.stop_reason {
        eprintln!("tackscope: {} at {reason}; what was computed is in {}", told.stop, arguments.out.display());
    }
    let yardstick_cut = told.yardstick.is_some_and(|yardstick| yardstick.stop == report::stop_word(&Outcome::Cancelled));
    Ok(if yardstick_cut { INTERRUPTED } else { exit_code(&main.run.outcome) })
}

/// The scene with what the command line replaces in it, and how to name both in a refusal.
fn scene(arguments: &RunArguments) -> Result<(Scene, String), Failure> {
    let mut scene = presets::resolve(&arguments.scene)?;
    let mut place = arguments.scene.clone();
    if let Some(n) = arguments.points {
        place.push_str(&format!(" with --points {n}"));
        scene.cell.points = if matches!(scene.cell.points, Points::Line(_)) { Points::Line(n) } else { Points::Square(n) };
    }
    if let Some(step) = arguments.step {
        place.push_str(&format!(" with --step {step}"));
        scene.drive.step = step;
    }
    if let Some(seed) = arguments.seed {
        scene.seed = seed;
    }
    Ok((scene, place))
}

/// Walks the loop, telling the user, and takes the time.
fn timed(arguments: &RunArguments, scene: &Scene, model: &Model, method: MethodKind, cancel: &Cancel) -> Result<Timed, SceneError> {
    let word = method.word();
    let (nx, ny, mu_rho) = (model.grid.nx, model.grid.ny, model.mu_rho);
    let heading = format!("{}: {nx} x {ny} points ({}), mu_rho = {mu_rho:.3}, method {word}", scene.title, model.reason);
    let mut teller = Teller::new(arguments.quiet, &heading);
    let (wall, processor) = (Instant::now(), ProcessTime::try_now().ok());
    let run = run_loop(scene, method, cancel, &mut |news| teller.tell(&news))?;
    let processor = processor.and_then(|start| start.try_elapsed().ok());
    let processor_seconds = processor.map_or(f64::NAN, |spent| spent.as_secs_f64());
    teller.finish();
    Ok(Timed { run, wall_seconds: wall.elapsed().as_secs_f64(), processor_seconds })
}

fn exit_code(outcome: &Outcome) -> u8 {
    match outcome {
        Outcome::Completed => DONE,
        Outcome::NotConverged { .. } => NOT_CONVERGED,
        Outcome::Cancelled => INTERRUPTED,
    }
}

/// The one line on standard output.
fn closing_words(arguments: &RunArguments, model: &Model, run: &LoopRun, yardstick: Option<&summary::Yardstick>) -> String {
    let loss = match report::dissipated_energy(run, model) {
        Some(loss) => format!("dissipated energy {:.4} gamma", if loss.abs() < 5e-5 { 0.0 } else { loss }),
        None => "loop not closed".to_owned(),
    };
    let ratio = match yardstick {
        Some(yardstick) if yardstick.processor_time_ratio.0.is_finite() => {
            format!(", {:.1} times less processor time than gfmd", yardstick.processor_time_ratio.0)
        }
        _ => String::new(),
    };
    let (states, jumps) = (run.record.states.len(), run.record.jumps.len());
    format!("{loss}, {jumps} jumps, {states} states{ratio}: written to {}", arguments.out.display())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_outcome_has_its_exit_code() {
        let stuck = Outcome::NotConverged { mean_displacement: 1.0, reason: "stalled".to_owned() };
        assert_eq!([Outcome::Completed, stuck, Outcome::Cancelled].map(|outcome| exit_code(&outcome)), [0, 3, 130]);
    }
}
