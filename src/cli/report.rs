//! From a finished walk to its files: numbers put together for `summary.json`, tables, pictures.

use super::failures;
use crate::follow::ledger::Ledger;
use crate::follow::record::StateRecord;
use crate::follow::run::{Landing, LoopRun, Outcome, RivalLoop, nan_max};
use crate::numerics::threads::side_by_side;
use crate::physics::parameter::Dimension;
use crate::physics::pattern::Pattern;
use crate::plot::loop_panel;
use crate::plot::style::Colours;
use crate::scene::units::Units;
use crate::scene::{Model, Points, Scene, Turn};
use crate::solver::Stop;
use crate::storage::folder::Folder;
use crate::storage::summary::{
    Contested, CountSummary, EndSummary, LossSummary, Number, PlanSummary, SceneSummary, Summary,
    UnitsSummary, Yardstick,
};
use crate::storage::{Failure, VERSION, drawing, export, files, picture};
use crate::study::plan::{Plan, predicted_error, promise, reference, stated_error};
use std::sync::{Arc, Mutex};

/// A walk with what it took.
pub(super) struct Timed {
    pub(super) run: LoopRun,
    pub(super) wall_seconds: f64,
    pub(super) processor_seconds: f64,
}

/// What stands in `summary.json` until all is computed and written, and so beside whatever a killed
/// run has left.
pub(super) fn begun(
    given: &str,
    scene: &Scene,
    model: &Model,
    plan: &Plan,
    method: &'static str,
) -> Summary {
    let run = LoopRun {
        outcome: Outcome::Cancelled,
        ..LoopRun::empty()
    };
    let nothing = Timed {
        run,
        wall_seconds: f64::NAN,
        processor_seconds: f64::NAN,
    };
    let mut summary = summary(given, scene, model, plan, method, &nothing);
    summary.end.stop = "running";
    summary.end.stop_reason = Some("not finished: it is still running, or was killed".to_owned());
    summary.loss.released_energy_sum = Number(f64::NAN);
    summary
}

/// Everything for `summary.json` but the yardstick.
pub(super) fn summary(
    given: &str,
    scene: &Scene,
    model: &Model,
    plan: &Plan,
    method: &'static str,
    timed: &Timed,
) -> Summary {
    let run = &timed.run;
    let states = &run.record.states;
    let ledger = run.ledger(model.law.surface_energy);
    let of = |number: fn(&Ledger) -> Option<f64>| Number::from(ledger.as_ref().and_then(number));
    let largest = |value: fn(&StateRecord) -> f64| {
        Number(states.iter().map(value).reduce(nan_max).unwrap_or(f64::NAN))
    };
    Summary {
        tackscope: VERSION,
        scene: SceneSummary::new(given, scene),
        plan: plan_summary(scene, model, plan, run.deviation.as_deref()),
        predicted_error: Number(predicted_error(plan, run)),
        measured_error: Number(f64::NAN),
        method,
        end: end(run, ledger.as_ref()),
        loss: LossSummary {
            dissipated_energy: of(Ledger::dissipated_energy),
            stated_error: stated_error(model, plan, run).into(),
            released_energy_sum: Number(run.record.released_energy_sum()),
            released_energy_error: of(|ledger| Some(ledger.released_energy_error)),
            loop_integral: of(|ledger| {
                Some(ledger.loop_integral).filter(|_| ledger.open.is_none())
            }),
            ledger_mismatch: of(Ledger::mismatch),
        },
        warnings: warnings(scene, model, run, ledger.as_ref()),
        contested: run.rivals.iter().map(contested).collect(),
        counts: counts(run),
        stiffness_min_least: Number(-largest(|s| -s.stiffness_min).0),
        stiffness_error_max: largest(|s| s.stiffness_error),
        residual_max: largest(|s| s.residual),
        wall_seconds: Number(timed.wall_seconds),
        processor_seconds: Number(timed.processor_seconds),
        yardstick: None,
        units: scene
            .units
            .map(|units| in_si(&units, model, run, ledger.as_ref())),
    }
}

/// What a loop is in SI.
fn in_si(units: &Units, model: &Model, run: &LoopRun, ledger: Option<&Ledger>) -> UnitsSummary {
    let word = |of| units.word(of);
    let loss = ledger.and_then(Ledger::dissipated_energy);
    let loss = loss.map(|loss| loss * model.law.surface_energy);
    let pull = run.pull_off();
    let si = |of, value: Option<f64>| Number::from(value.map(|value| value * units.si(of)));
    let of_cell = |value: Option<f64>| model.of_cell(value?);
    UnitsSummary {
        length: word(Dimension::Length),
        stress: word(Dimension::Stress),
        energy: word(Dimension::SurfaceEnergy),
        stiffness: word(Dimension::Stiffness),
        contact_modulus: Number(units.contact_modulus),
        temperature_kelvin: Number(units.temperature),
        loss_joule_per_square_metre: si(Dimension::SurfaceEnergy, loss),
        loss_joule: si(Dimension::Energy, of_cell(loss)),
        pull_off_pascal: si(Dimension::Stress, pull),
        pull_off_newton: si(Dimension::Force, of_cell(pull)),
    }
}

fn end(run: &LoopRun, ledger: Option<&Ledger>) -> EndSummary {
    let open = ledger.and_then(|ledger| ledger.open.as_ref());
    EndSummary {
        completed: run.outcome == Outcome::Completed,
        stop: run.outcome.word(),
        stop_reason: run.stop_reason(),
        closed: ledger.is_some_and(|ledger| ledger.open.is_none()),
        open_reason: open.map(|open| open.reason.clone()),
        open_remedy: open.map(|open| open.remedy.clone()),
    }
}

fn warnings(scene: &Scene, model: &Model, run: &LoopRun, ledger: Option<&Ledger>) -> Vec<String> {
    let contested = run
        .record
        .jumps
        .iter()
        .filter(|jump| !jump.landings.is_empty())
        .map(|jump| {
            let losses: Vec<String> = run
                .rivals
                .iter()
                .filter_map(|rival| Some(format!("{:.4}", rival.dissipated_energy?)))
                .collect();
            let or = if losses.is_empty() {
                "is not known".to_owned()
            } else {
                format!("is {} gamma", losses.join(" or "))
            };
            format!(
                "u0 = {}: {}; the loss of the other landing {or}",
                jump.mean_displacement,
                jump.cause_words()
            )
        });
    let missed = run
        .error_bar
        .filter(|error| *error > scene.accuracy)
        .map(|error| {
            let points = reference(scene, model).cell.points;
            let finer = match points {
                Points::Line(n) => format!("[{n}, 1]"),
                Points::Square(n) => n.to_string(),
                Points::Auto => "\"auto\"".to_owned(),
            };
            let (bar, target) = (promise(Some(error)), scene.accuracy);
            format!(
                "accuracy.target = {target} is not met ({bar}); cell.points = {finer} comes closer"
            )
        });
    model
        .warning()
        .into_iter()
        .chain(ledger.and_then(Ledger::warning))
        .chain(contested)
        .chain(missed)
        .collect()
}

fn contested(rival: &RivalLoop) -> Contested {
    Contested {
        landing: rival.landing.pattern.word(),
        share: Number(rival.landing.share),
        dissipated_energy: Number::from(rival.dissipated_energy),
    }
}

fn plan_summary(scene: &Scene, model: &Model, plan: &Plan, deviation: Option<&str>) -> PlanSummary {
    let given = scene.number_given(Dimension::SurfaceEnergy, model.law.surface_energy);
    PlanSummary {
        strategy: plan.carried_out(deviation).word(),
        words: deviation.map_or_else(|| plan.words(), |why| format!("{}; {why}", plan.words())),
        predicted_seconds: Number(plan.predicted_seconds),
        reason: model.reason.clone(),
        length: Number(model.grid.length),
        points: [model.grid.nx, model.grid.ny],
        spacing: Number(model.grid.spacing()),
        law: model.law.shape.word(),
        surface_energy: Number(given),
        range: Number(model.law.range),
        mu_rho: Number(model.mu_rho),
        warning: model.warning(),
    }
}

fn counts(run: &LoopRun) -> CountSummary {
    let (counts, states, tally) = (run.counts, &run.record.states, run.record.tally());
    let per_increment = (counts.patterned_increments > 0)
        .then(|| counts.transforms as f64 / counts.patterned_increments as f64);
    CountSummary {
        states: states.len(),
        states_not_stable: states.iter().filter(|s| s.stop != Stop::Stable).count(),
        jumps: tally.jumps,
        mesh_jumps: tally.of_the_mesh,
        transitions: tally.transitions,
        patterned_increments: counts.patterned_increments,
        transforms: counts.transforms,
        proof_transforms: counts.proof_transforms,
        transforms_per_patterned_increment: per_increment.into(),
        iterations: counts.iterations,
    }
}

/// The yardstick's numbers beside those of the main run.
pub(super) fn yardstick(model: &Model, main: &Timed, other: &Timed) -> Yardstick {
    let both = main.run.outcome == Outcome::Completed && other.run.outcome == Outcome::Completed;
    Yardstick {
        method: "gfmd",
        completed: other.run.outcome == Outcome::Completed,
        stop: other.run.outcome.word(),
        dissipated_energy: other
            .run
            .ledger(model.law.surface_energy)
            .and_then(|ledger| ledger.dissipated_energy())
            .into(),
        jumps: other.run.record.tally().jumps,
        transforms: other.run.counts.transforms,
        wall_seconds: Number(other.wall_seconds),
        processor_seconds: Number(other.processor_seconds),
        processor_time_ratio: both
            .then(|| other.processor_seconds / main.processor_seconds)
            .into(),
    }
}

/// The folder of the gap pictures.
pub(super) const GAPS: &str = "gaps";

/// The file that says how it went.
pub(super) const SUMMARY: &str = "summary.json";

/// The file of the fields.
pub(super) const FIELDS: &str = "fields.npz";

/// What is written beside it.
const FILES: [&str; 4] = ["loop.csv", "events.csv", "loop.svg", "loop.png"];

/// True for a file (as in `gaps/1-approach-bulge.png`) that a run writes.
pub(super) fn is_result(name: &str) -> bool {
    let gap = name
        .strip_prefix(GAPS)
        .and_then(|name| name.strip_prefix('/'));
    [SUMMARY, FIELDS].contains(&name) || FILES.contains(&name) || gap.is_some_and(is_gap_picture)
}

/// Room that the results may need, in bytes.
pub(super) fn room(scene: &Scene, model: &Model) -> u64 {
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
pub(super) type Unwritten<'a> = Box<dyn FnOnce() -> Result<(), Failure> + Send + 'a>;

/// Writes files side by side: some wait for the disk while others are computed. Returns what could
/// not be written.
pub(super) fn written(files: Vec<Unwritten<'_>>) -> Vec<Failure> {
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
pub(super) fn results<'a>(
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

    #[test]
    fn only_our_own_gap_pictures_are_recognised() {
        assert!(is_gap_picture("1-approach-bulge.png") && is_gap_picture("12-retraction-flat.png"));
        assert!(
            !is_gap_picture("holiday.png")
                && !is_gap_picture("1-approach-cat.png")
                && !is_gap_picture("x-approach-flat.png")
        );
    }

    #[test]
    fn nan_is_never_swallowed_by_a_maximum() {
        assert!(
            [1.0, f64::NAN, 2.0]
                .into_iter()
                .reduce(nan_max)
                .is_some_and(f64::is_nan)
        );
        assert_eq!([1.0, 3.0, 2.0].into_iter().reduce(nan_max), Some(3.0));
    }
}
