//! `tackscope run`: a closed loop without a window, and its files: tables, pictures, `summary.json`.

use super::{
    DONE, INTERRUPTED, Monitor, NOT_CONVERGED, Output, cancel_on_signal, failures,
    scene_with_points, warn,
};
use crate::follow::record::StateRecord;
use crate::follow::run::{Landing, LoopRun, Outcome, Report};
use crate::follow::walk::soft_mode;
use crate::numerics::threads::{Cancel, side_by_side};
use crate::physics::parameter::{Dimension, Refusal};
use crate::physics::pattern::Pattern;
use crate::plot::loop_panel;
use crate::plot::style::Colours;
use crate::scene::parameter::say;
use crate::scene::{Model, Scene, Strategy, Turn, parameter};
use crate::solver::methods::MethodKind;
use crate::storage::fields::{Collector, Keep};
use crate::storage::files::Folder;
use crate::storage::summary::{Number, Summary, Timed, Yardstick, write_summary};
use crate::storage::{Failure, drawing, export, files, picture, scene_file};
use crate::study::plan::{
    Plan, measured_error, plan as plan_of, promise, reference, refusal, run_planned, stated_error,
};
use clap::builder::PossibleValue;
use clap::{Args, ValueEnum};
use cpu_time::ProcessTime;
use ndarray::Array2;
use std::sync::{Arc, Mutex};
use std::time::Instant;

/// What `tackscope run` is told.
#[derive(Args, Clone, Debug)]
pub(super) struct RunArguments {
    /// A built-in scene (see `tackscope presets`), a scene file, or - for standard input
    scene: String,
    #[command(flatten)]
    output: Output,
    /// Which method follows the branches
    #[arg(long, value_enum, default_value_t = MethodKind::NewtonKrylov)]
    method: MethodKind,
    /// How the loop is computed, in place of the plan's choice
    #[arg(long, value_enum, default_value_t = Asked(None))]
    model: Asked,
    /// Seed in place of the scene's: it chooses between equivalent patterns
    #[arg(long, value_name = "N")]
    #[arg(value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64))]
    seed: Option<u64>,
    /// Points a side in place of the scene's (a line cell stays a line)
    #[arg(long, value_name = "N")]
    points: Option<usize>,
    /// Largest step of u0 in place of the scene's
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    step: Option<f64>,
    /// Afterwards run the paper's method on the same loop and write the ratio of processor time
    /// into summary.json
    #[arg(long)]
    yardstick: bool,
    /// Afterwards walk the same loop on the next finer mesh of the whole cell and write the
    /// measured error into summary.json
    #[arg(long)]
    verify: bool,
    /// Also write the fields of so many states into fields.npz, which numpy reads: gap,
    /// displacement, traction
    #[arg(long, value_name = "all|jumps|every=N")]
    fields: Option<Keep>,
}

/// The strategy that is asked for; `None` leaves it to the plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Asked(Option<Strategy>);

impl ValueEnum for Asked {
    fn value_variants<'a>() -> &'a [Self] {
        &[
            Asked(None),
            Asked(Some(Strategy::Atlas)),
            Asked(Some(Strategy::QUARTER)),
            Asked(Some(Strategy::WHOLE)),
        ]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let help = match self.0 {
            None => "the cheapest model that is good enough",
            Some(Strategy::Atlas) => "branches of flat, ridge and square patterns",
            Some(Strategy::Walk(part)) if part.is_even() => {
                "the walk on the even quarter of the cell"
            }
            Some(Strategy::Walk(_)) => "the walk on the whole cell",
        };
        Some(PossibleValue::new(self.0.map_or("plan", Strategy::word)).help(help))
    }
}

impl ValueEnum for MethodKind {
    fn value_variants<'a>() -> &'a [Self] {
        &MethodKind::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.word()).help(self.title()))
    }
}

/// Computes the loop, writes its files and returns the exit code.
///
/// # Errors
/// A scene or an option that is refused, a folder that cannot be written, or a standard output that
/// cannot.
pub(super) fn run(arguments: &RunArguments) -> Result<u8, Failure> {
    check_options(arguments)?;
    let (scene, place) = scene(arguments)?;
    let refused = |error: Refusal| scene_file::refused(&place, error);
    let model = scene.model().map_err(refused)?;
    if let Some(reason) = refusal(&scene, &model, arguments.model.0) {
        let allowed =
            format!("this scene has no atlas, since {reason}; leave --model out, or take whole");
        return Err(Failure::value(
            &place,
            "--model",
            Strategy::Atlas.word(),
            &allowed,
        ));
    }
    // The other methods are there to be compared on the cell they were made for.
    let newton = arguments.method == MethodKind::NewtonKrylov;
    let asked = if newton {
        arguments.model.0
    } else {
        arguments.model.0.or(Some(Strategy::WHOLE))
    };
    let plan = plan_of(&scene, &model, asked).by(arguments.method);

    let cancel = cancel_on_signal();
    let output = &arguments.output;
    let room = room(&scene, &model);
    let folder = output.claim(&[GAPS], room, is_result)?;
    let summary_path = folder.join(SUMMARY);
    let method = arguments.method.word();
    write_summary(
        &summary_path,
        &Summary::begun(&arguments.scene, &scene, &model, &plan, method),
    )?;

    let mut fields = arguments
        .fields
        .map(|keep| Collector::new(keep, &output.out))
        .transpose()?;
    let mut collect = |news: &Report<'_>| fields.iter_mut().for_each(|all| all.observe(news));
    let main = timed(
        arguments,
        &scene,
        &plan,
        arguments.method,
        &cancel,
        &mut collect,
    )
    .map_err(refused)?;
    let mut files = results(&folder, &scene, &model, &plan, &main.run);
    if let Some(fields) = fields {
        let (path, of, cancel) = (folder.join(FIELDS), (&scene, &model), &cancel);
        let driven = scene.control();
        let write = move || {
            let mut mode = |record: &StateRecord, displacement: &Array2<f64>| {
                soft_mode((of.1, driven), record, displacement, cancel)
            };
            fields.finish(&path, of, &mut mode)
        };
        files.insert(0, Box::new(write));
    }
    let mut failures = written(files);
    let mut told = Summary::of(&arguments.scene, &scene, &model, &plan, method, &main);
    failures.extend(write_summary(&summary_path, &told).err());
    let mut code = exit_code(&main.run.outcome);
    if main.run.outcome == Outcome::Completed && (arguments.yardstick || arguments.verify) {
        let compared =
            compare(arguments, &scene, &model, &main, &cancel, &mut told).map_err(refused)?;
        failures.extend(write_summary(&summary_path, &told).err());
        code = compared;
    }
    if !output.quiet {
        told.warnings.iter().for_each(warn);
    }
    if let Some(reason) = &told.end.stop_reason {
        warn(format_args!(
            "{} at {reason}; what was computed is in {}",
            told.end.stop,
            output.out.display()
        ));
    }
    if let (Some(reason), Some(remedy)) = (&told.end.open_reason, &told.end.open_remedy) {
        warn(format_args!("loop not closed: {reason}; {remedy}"));
    }
    output.close(&failures, code, &closing_words(&told, &main.run))
}

/// Refuses options that contradict each other.
fn check_options(arguments: &RunArguments) -> Result<(), Failure> {
    let refuse =
        |key, value: &str, allowed| Err(Failure::value("command line", key, value, allowed));
    if arguments.yardstick && arguments.method == MethodKind::Gfmd {
        let allowed = "the yardstick is gfmd itself; leave one of the two out";
        return refuse("--yardstick", "with --method gfmd", allowed);
    }
    if arguments.model.0 == Some(Strategy::Atlas) && arguments.method != MethodKind::NewtonKrylov {
        let value = format!("atlas with --method {}", arguments.method.word());
        return refuse(
            "--model",
            &value,
            "only newton follows the branches of an atlas; leave one of the two out",
        );
    }
    Ok(())
}

/// Computes what was asked for beside the loop, and puts it into the summary; returns the exit
/// code.
fn compare(
    arguments: &RunArguments,
    scene: &Scene,
    model: &Model,
    main: &Timed,
    cancel: &Cancel,
    told: &mut Summary,
) -> Result<u8, Refusal> {
    let mut code = DONE;
    if arguments.yardstick {
        let whole = plan_of(scene, model, Some(Strategy::WHOLE)).by(MethodKind::Gfmd);
        let other = timed(
            arguments,
            scene,
            &whole,
            MethodKind::Gfmd,
            cancel,
            &mut |_| {},
        )?;
        told.yardstick = Some(Yardstick::of(model, main, &other));
        if other.run.outcome == Outcome::Cancelled {
            code = INTERRUPTED;
            warn("interrupted before the yardstick was done; the loop itself is complete");
        }
    }
    if arguments.verify {
        let finer = reference(scene, model);
        let finer_model = finer.model()?;
        let whole = plan_of(&finer, &finer_model, Some(Strategy::WHOLE));
        let better = timed(
            arguments,
            &finer,
            &whole,
            MethodKind::NewtonKrylov,
            cancel,
            &mut |_| {},
        )?;
        match &better.run.outcome {
            Outcome::Completed
                if [&main.run, &better.run]
                    .into_iter()
                    .any(|run| is_open(run, model)) =>
            {
                warn("nothing to verify: a loop that is not closed has no loss");
            }
            Outcome::Completed => {
                told.measured_error = Number(measured_error(
                    &main.run.record.jumps,
                    &better.run.record.jumps,
                ));
            }
            Outcome::Cancelled => {
                code = INTERRUPTED;
                warn("interrupted before the verification was done; the loop itself is complete");
            }
            Outcome::NotConverged {
                mean_displacement,
                reason,
            } => {
                code = NOT_CONVERGED;
                warn(format_args!(
                    "the verification did not converge at u0 = {mean_displacement}: {reason}: the \
                     error is not known"
                ));
            }
        }
    }
    Ok(code)
}

fn is_open(run: &LoopRun, model: &Model) -> bool {
    run.ledger(model.law.surface_energy)
        .is_none_or(|ledger| ledger.open.is_some())
}

/// The scene with what the command line replaces in it, and how to name both in a refusal.
fn scene(arguments: &RunArguments) -> Result<(Scene, String), Failure> {
    let (mut scene, mut place) = scene_with_points(&arguments.scene, arguments.points)?;
    if let Some(step) = arguments.step {
        place.push_str(&format!(" with --step {step}"));
        scene.drive.step = scene.number_taken(parameter::STEP.unit, step);
    }
    if let Some(seed) = arguments.seed {
        scene.seed = seed;
    }
    Ok((scene, place))
}

/// Walks the loop, telling the user and `collect`, and takes the time.
fn timed(
    arguments: &RunArguments,
    scene: &Scene,
    plan: &Plan,
    method: MethodKind,
    cancel: &Cancel,
    collect: &mut dyn FnMut(&Report<'_>),
) -> Result<Timed, Refusal> {
    let model = scene.model()?;
    let heading = format!(
        "{}: {} ({}), mu_rho = {:.3}, {}",
        scene.title,
        plan.words(),
        model.reason,
        model.mu_rho,
        method.title()
    );
    let mut monitor = Monitor::new(arguments.output.quiet, &heading);
    let (wall, processor) = (Instant::now(), ProcessTime::try_now().ok());
    let run = run_planned(scene, method, plan, cancel, &mut |news| {
        collect(&news);
        monitor.tell(&news, scene.drive.step);
    })?;
    let processor = processor.and_then(|start| start.try_elapsed().ok());
    let processor_seconds = processor.map_or(f64::NAN, |spent| spent.as_secs_f64());
    monitor.finish();
    Ok(Timed {
        run,
        wall_seconds: wall.elapsed().as_secs_f64(),
        processor_seconds,
    })
}

fn exit_code(outcome: &Outcome) -> u8 {
    match outcome {
        Outcome::Completed => DONE,
        Outcome::NotConverged { .. } => NOT_CONVERGED,
        Outcome::Cancelled => INTERRUPTED,
    }
}

/// The one line on standard output.
fn closing_words(told: &Summary, run: &LoopRun) -> String {
    let loss = told.loss.number("dissipated_energy");
    let loss = match (&told.end.open_reason, loss.is_finite()) {
        (Some(reason), _) => format!("loop not closed: {reason}"),
        (None, false) => "loop not closed".to_owned(),
        (None, true) => {
            let accuracy = promise(Some(told.loss.number("stated_error")));
            format!(
                "dissipated energy {:.4} gamma, {accuracy}",
                if loss.abs() < 5e-5 { 0.0 } else { loss }
            )
        }
    };
    let ratio = match &told.yardstick {
        Some(yardstick) if yardstick.processor_time_ratio.0.is_finite() => {
            format!(
                ", {:.1} times less processor time than gfmd",
                yardstick.processor_time_ratio.0
            )
        }
        _ => String::new(),
    };
    let (states, tally) = (run.record.states.len(), run.record.tally());
    format!("{loss}, {tally}, {states} states{ratio}{}", in_si(told))
}

/// Loss and pull-off of a scene with units.
fn in_si(told: &Summary) -> String {
    let Some(units) = &told.units else {
        return String::new();
    };
    let said = [
        (
            "loss",
            Dimension::SurfaceEnergy,
            &units.loss_joule_per_square_metre,
            "",
        ),
        ("", Dimension::Energy, &units.loss_joule, " a cell"),
        ("pull-off", Dimension::Stress, &units.pull_off_pascal, ""),
        ("", Dimension::Force, &units.pull_off_newton, " a cell"),
    ];
    let known = said.iter().filter(|(.., value, _)| value.0.is_finite());
    known
        .map(|(what, of, value, per)| {
            let separator = if what.is_empty() { " or" } else { "; " };
            format!("{separator}{what} {}{per}", say(*of, value.0))
        })
        .collect()
}

/// The folder of the gap pictures.
const GAPS: &str = "gaps";

/// The file that says how it went.
const SUMMARY: &str = "summary.json";

/// The file of the fields.
const FIELDS: &str = "fields.npz";

/// What is written beside it.
const FILES: [&str; 4] = ["loop.csv", "events.csv", "loop.svg", "loop.png"];

/// True for a file (as in `gaps/1-approach-bulge.png`) that a run writes.
fn is_result(name: &str) -> bool {
    let gap = name
        .strip_prefix(GAPS)
        .and_then(|name| name.strip_prefix('/'));
    [SUMMARY, FIELDS].contains(&name) || FILES.contains(&name) || gap.is_some_and(is_gap_picture)
}

/// Room that the results may need, in bytes.
fn room(scene: &Scene, model: &Model) -> u64 {
    /// A state in the table and in the pictures; what does not grow; a point in all gap pictures.
    const SIZES: [f64; 3] = [300.0, 1e6, 4.0];
    /// More states than this are not reckoned with.
    const STATES_MAX: f64 = 1e6;
    let drive = &scene.drive;
    let turn = if let Turn::At(turn) = drive.turn {
        turn
    } else {
        drive.start - scene.cell.length
    };
    let states = (2.0 * (drive.start - turn) / drive.step).clamp(0.0, STATES_MAX);
    let points = (model.grid.nx * model.grid.ny) as f64;
    (SIZES[0] * states + SIZES[1] + SIZES[2] * points) as u64
}

/// A file to be written.
type Unwritten<'a> = Box<dyn FnOnce() -> Result<(), Failure> + Send + 'a>;

/// Writes files side by side: some wait for the disk while others are computed. Returns what could
/// not be written.
fn written(files: Vec<Unwritten<'_>>) -> Vec<Failure> {
    let files: Vec<_> = files
        .into_iter()
        .map(|file| Mutex::new(Some(file)))
        .collect();
    failures(side_by_side(0..files.len(), |i| {
        let write = files[i].lock().ok().and_then(|mut file| file.take());
        write.map_or(Ok(()), |write| write())
    }))
}

/// The tables and pictures of a walk, to be written, the dearest first.
fn results<'a>(
    folder: &'a Folder,
    scene: &'a Scene,
    model: &Model,
    plan: &Plan,
    run: &'a LoopRun,
) -> Vec<Unwritten<'a>> {
    let error = stated_error(model, plan, run);
    let page = Arc::new(loop_panel::page(&run.record, model, &scene.title, error));
    let [states, jumps, svg, png] = FILES.map(|name| folder.join(name));
    let drawn = Arc::clone(&page);
    let mut files: Vec<Unwritten<'a>> = vec![
        Box::new(move || {
            let image = drawing::page_image(&page);
            let image = image.map_err(|error| Failure::write(&png, error))?;
            picture::write_with_scene(&png, &image, scene)
        }),
        Box::new(move || files::write_whole(&svg, drawing::page_svg(&drawn).as_bytes())),
        Box::new(move || export::write_loop_csv(&states, scene, &run.record.states)),
        Box::new(move || export::write_events_csv(&jumps, scene, &run.record.jumps)),
    ];
    let scale = picture::common_scale(run.landings.iter().map(|landing| &landing.gap));
    for (i, landing) in run.landings.iter().enumerate() {
        let path = folder.join(GAPS).join(gap_picture(i, landing));
        files.push(Box::new(move || {
            picture::write_with_scene(
                &path,
                &picture::gap_image(&landing.gap, scale, Colours::default()),
                scene,
            )
        }));
    }
    files
}

/// `1-approach-bulge.png` for the first landing, and so on.
fn gap_picture(index: usize, landing: &Landing) -> String {
    format!(
        "{}-{}-{}.png",
        index + 1,
        landing.direction,
        landing.pattern
    )
}

/// True for a name that [`gap_picture`] can give.
fn is_gap_picture(name: &str) -> bool {
    let parts: Vec<_> = name
        .strip_suffix(".png")
        .unwrap_or_default()
        .split('-')
        .collect();
    let [number, "approach" | "retraction", pattern] = parts[..] else {
        return false;
    };
    number.parse::<usize>().is_ok() && Pattern::ALL.iter().any(|p| p.word() == pattern)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::follow::walk::Stuck;

    #[test]
    fn each_outcome_has_its_exit_code() {
        let stuck = Outcome::NotConverged {
            mean_displacement: 1.0,
            reason: Stuck::NotFinite,
        };
        assert_eq!(
            [Outcome::Completed, stuck, Outcome::Cancelled].map(|outcome| exit_code(&outcome)),
            [0, 3, 130]
        );
    }

    #[test]
    fn only_our_own_gap_pictures_are_recognised() {
        assert!(is_gap_picture("1-approach-bulge.png") && is_gap_picture("12-retraction-flat.png"));
        assert!(
            !is_gap_picture("holiday.png")
                && !is_gap_picture("1-approach-cat.png")
                && !is_gap_picture("x-approach-flat.png")
        );
    }
}
