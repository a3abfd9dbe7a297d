//! A study: one scene at many values of its numbers, each a closed loop computed as `run` computes
//! it, and what is recorded of each; and where its values lie: between two ends, on a grid, or spread
//! within it.
//!
//! Those numbers of `summary.json` that have a name here are read off the same columns. Nothing here
//! knows files: rows are told one by one as they are found, cheapest first, and
//! whoever keeps them decides which are still to be computed.

use super::plan::{Plan, enclose, plan, predicted_error, run_planned, stated_error};
use crate::follow::ledger::Ledger;
use crate::follow::record::{Cause, Direction, JumpRecord, StateRecord};
use crate::follow::run::{LoopRun, Outcome, nan_max};
use crate::numerics::threads::{Cancel, FAULT, side_by_side};
use crate::physics::control::Control;
use crate::physics::indenter::Indenter;
use crate::physics::parameter::{Dimension, Refusal, Value};
use crate::physics::theory::{Units, flat_limits, ridge};
use crate::scene::{Model, Points, Scene, edit, parameter};
use crate::solver::Stop;
use crate::solver::methods::MethodKind;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Most points of a study.
pub const POINTS_MAX: usize = 1_000_000;
/// Most axes of a study.
pub const AXES_MAX: usize = 16;

/// Most points of a Sobol sequence.
pub const SOBOL_MAX: usize = 1 << 16;
/// Steps between the numbers of a Sobol sequence in [0, 1), which are of single precision.
const STEPS: f64 = 16_777_216.0;

/// How values lie between two ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spacing {
    /// Equal steps apart.
    Linear,
    /// Equal factors apart; both ends are above zero.
    Logarithmic,
}

/// Values between two ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// The first.
    pub from: f64,
    /// The last.
    pub to: f64,
    /// How they lie.
    pub spacing: Spacing,
}

impl Span {
    /// The value at this share of the way, 0 to 1.
    pub fn at(&self, share: f64) -> f64 {
        match self.spacing {
            Spacing::Logarithmic => self.from * (self.to / self.from).powf(share),
            Spacing::Linear => self.from + share * (self.to - self.from),
        }
    }

    /// So many values from end to end, two at least.
    pub fn values(&self, count: usize) -> Vec<f64> {
        let last = count.max(2) - 1;
        let share = |i: usize| i as f64 / last as f64;
        let inner = (0..last).map(|i| self.at(share(i)));
        inner.chain([self.to]).collect()
    }
}

/// Every combination of the values of the axes; the last axis goes fastest.
pub fn grid(axes: &[Vec<f64>]) -> Vec<Vec<f64>> {
    axes.iter().fold(vec![Vec::new()], |places, axis| {
        let longer = |place: &Vec<f64>, value: &f64| [&place[..], &[*value]].concat();
        let of = |place: &Vec<f64>| axis.iter().map(|value| longer(place, value)).collect();
        places
            .iter()
            .flat_map(|place| -> Vec<_> { of(place) })
            .collect()
    })
}

/// How places are chosen within the ends of the axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sequence {
    /// Independent of each other.
    Random,
    /// Sobol's low-discrepancy sequence, scrambled after Owen.
    Sobol,
}

impl Sequence {
    /// So many places within the `spans`, one an axis. The first ones stay when there are more.
    pub fn places(self, spans: &[Span], count: usize, seed: u32) -> Vec<Vec<f64>> {
        let mut chance = Pcg64::seed_from_u64(u64::from(seed));
        let mut share = |i: usize, axis: usize| match self {
            Sequence::Random => chance.random_range(0.0..1.0),
            // In the middle of its step, so that no place is an end.
            Sequence::Sobol => {
                let share = sobol_burley::sample(i as u32, axis as u32, seed);
                f64::from(share) + 0.5 / STEPS
            }
        };
        let mut place = |i: usize| -> Vec<f64> {
            let axes = spans.iter().enumerate();
            axes.map(|(axis, span)| span.at(share(i, axis))).collect()
        };
        (0..count).map(&mut place).collect()
    }
}

/// What is computed, and what is recorded of it.
#[derive(Clone, Debug)]
pub struct Study {
    /// One line that names it.
    pub title: String,
    /// The scene whose numbers go.
    pub scene: Scene,
    /// The keys of the numbers that go, as in `law.range`.
    pub keys: Vec<String>,
    /// The values of each loop, one a key, as the scene's file has them.
    pub places: Vec<Vec<f64>>,
    /// What is recorded.
    pub record: Vec<&'static Column>,
    /// What is drawn against what: two of the keys and recorded columns.
    pub plot: [String; 2],
}

/// A loop of a study.
#[derive(Clone, Debug)]
pub struct Point {
    /// Its place in the study.
    pub index: usize,
    /// The values that go, as the scene has them: whole numbers are rounded.
    pub values: Vec<f64>,
    /// The scene, or why there is none.
    pub scene: Result<Scene, String>,
    /// Seconds that it is expected to take, to a factor of two or three.
    pub cost: f64,
}

/// What is known of a point.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Its place in the study.
    pub index: usize,
    /// The values that go.
    pub values: Vec<f64>,
    /// What is recorded, in the order of the study.
    pub cells: Vec<Cell>,
    /// "completed", "not converged", or "refused" of values that are not allowed.
    pub stop: String,
    /// Where and why it stopped, or why its loop is not closed; else empty.
    pub reason: String,
}

/// Room beyond the last jump, in ranges.
const SPARE: f64 = 0.25;

/// Of values that are not allowed.
const REFUSED: &str = "refused";

impl Row {
    /// True if the drive went all the way.
    pub fn is_complete(&self) -> bool {
        self.stop == Outcome::Completed.word()
    }
}

impl Study {
    /// Checks that its keys are numbers of its scene.
    ///
    /// # Errors
    /// A key that is none.
    pub fn check(&self) -> Result<(), Refusal> {
        let decided = edit::decided(&self.scene, &self.scene.model()?);
        let mut keys = self.keys.iter();
        keys.try_for_each(|key| edit::check_key(&decided, key))
    }

    /// Checks that this is one of its keys or of the columns that it records.
    ///
    /// # Errors
    /// All of them.
    pub fn check_name(&self, name: &str) -> Result<(), Vec<String>> {
        let columns = self.record.iter().map(|column| column.name.to_owned());
        let all: Vec<String> = self.keys.iter().cloned().chain(columns).collect();
        if all.iter().any(|known| known == name) {
            return Ok(());
        }
        Err(all)
    }

    /// Its loops in order. Values that are not allowed are points that say so.
    pub fn points(&self) -> Vec<Point> {
        let points = self.places.iter().enumerate();
        points
            .map(|(index, place)| self.point(index, place))
            .collect()
    }

    fn point(&self, index: usize, place: &[f64]) -> Point {
        let scene = self
            .scene_at(place)
            .and_then(|scene| Ok((scene.model()?, scene)));
        let (values, cost) = match &scene {
            Ok((model, scene)) => {
                let value = |(key, asked): (&String, f64)| whole(scene, key).unwrap_or(asked);
                let asked = self.keys.iter().zip(place.iter().copied());
                let cost = plan(scene, model, None).predicted_seconds;
                (asked.map(value).collect(), cost)
            }
            Err(_) => (place.to_vec(), 0.0),
        };
        Point {
            index,
            values,
            scene: scene.map(|(_, scene)| scene).map_err(|why| why.to_string()),
            cost,
        }
    }

    /// The scene with these values. As in a map of patterns its other numbers stay what they are, a
    /// range that was given by mu_rho among them, and on flat ground the drive goes beyond every jump
    /// unless its own ends go; a mesh that is "auto" is decided anew.
    ///
    /// # Errors
    /// A value that is not allowed.
    pub fn scene_at(&self, place: &[f64]) -> Result<Scene, Refusal> {
        let points = |key: &String| key == parameter::POINTS.key;
        let auto = self.scene.cell.points == Points::Auto && !self.keys.iter().any(points);
        let mut scene = self.scene.clone();
        if !auto {
            scene = edit::decided(&scene, &scene.model()?);
        }
        // Law and cell move the drive, and the machine makes it anew.
        let rank = |key: &str| match key {
            key if !key.starts_with("drive.") => 0,
            key if key == parameter::STIFFNESS.key => 1,
            _ => 2,
        };
        let mut values: Vec<_> = self.keys.iter().zip(place).collect();
        values.sort_by_key(|(key, _)| rank(key));
        for (key, value) in values {
            scene = edit::with_parameter(&scene, &scene.model()?, key, *value)?;
            if auto {
                scene.cell.points = Points::Auto;
            }
        }
        let driven = |key: &String| [parameter::START.key, parameter::TURN.key].contains(&&**key);
        if !self.keys.iter().any(driven) {
            let model = scene.model()?;
            if model.indenter == Indenter::Flat {
                let start = scene.drive.start;
                enclose(&mut scene, &model);
                if scene.control() == Control::Displacement {
                    let far = beyond_ridges(&model).max(start);
                    scene.drive.start = scene.drive.start.min(far);
                }
            }
        }
        Ok(scene)
    }

    /// Computes a loop; `None` if it was cancelled on the way.
    pub fn row(&self, point: &Point, cancel: &Cancel) -> Option<Row> {
        let none = |stop: &str, reason: String| Row {
            index: point.index,
            values: point.values.clone(),
            cells: vec![Cell::Word(String::new()); self.record.len()],
            stop: stop.to_owned(),
            reason,
        };
        let scene = match &point.scene {
            Ok(scene) => scene,
            Err(why) => return Some(none(REFUSED, why.clone())),
        };
        let found = catch_unwind(AssertUnwindSafe(|| self.measured(scene, cancel)));
        if cancel.requested() {
            return None;
        }
        Some(match found {
            Ok(Ok((cells, stop, reason))) => Row {
                cells,
                ..none(stop, reason)
            },
            Ok(Err(refusal)) => none(REFUSED, refusal.to_string()),
            Err(_) => none("failed", FAULT.to_owned()),
        })
    }

    fn measured(
        &self,
        scene: &Scene,
        cancel: &Cancel,
    ) -> Result<(Vec<Cell>, &'static str, String), Refusal> {
        let began = Instant::now();
        let model = scene.model()?;
        let plan = plan(scene, &model, None);
        let run = run_planned(scene, MethodKind::NewtonKrylov, &plan, cancel, &mut |_| {})?;
        let seconds = began.elapsed().as_secs_f64();
        let measured = Measured::new(scene, &model, &plan, &run, seconds);
        let open = measured
            .ledger
            .as_ref()
            .and_then(|ledger| ledger.open.as_ref());
        let open = open.map(|open| format!("{}; {}", open.reason, open.remedy));
        let reason = run.stop_reason().or(open).unwrap_or_default();
        let cells = self.record.iter().map(|column| column.of(&measured));
        Ok((cells.collect(), run.outcome.word(), reason))
    }

    /// Computes loops, cheapest first and as many at a time as there are threads; `observe` is told
    /// of each row, and of the expected share of all that is done, 0 to 1.
    pub fn compute(
        &self,
        points: &[&Point],
        cancel: &Cancel,
        observe: &mut (dyn FnMut(Row, f64) + Send),
    ) {
        let mut order = points.to_vec();
        order.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let whole: f64 = order.iter().map(|point| point.cost).sum();
        let told = Mutex::new((0.0, observe));
        side_by_side(0..order.len(), |i| {
            if cancel.requested() {
                return;
            }
            let Some(row) = self.row(order[i], cancel) else {
                return;
            };
            let mut told = told.lock().unwrap_or_else(PoisonError::into_inner);
            let (done, observe) = &mut *told;
            *done += order[i].cost;
            observe(row, if whole > 0.0 { *done / whole } else { 1.0 });
        });
    }

    /// The numbers of a key or of a recorded column in a row: none where there are none, several
    /// of jumps.
    pub fn numbers(&self, row: &Row, name: &str) -> Vec<f64> {
        if let Some(i) = self.keys.iter().position(|key| key == name) {
            return vec![row.values[i]];
        }
        let i = self.record.iter().position(|column| column.name == name);
        i.and_then(|i| row.cells.get(i))
            .map_or_else(Vec::new, Cell::numbers)
    }
}

/// u0 beyond which no pattern holds on flat ground (length): the end of a ridge of zero range, which
/// is farther than those of any range, or the limit of the flat state, with room to spare.
fn beyond_ridges(model: &Model) -> f64 {
    let (law, length) = (&model.law, model.equivalent_length);
    let ridge = Units::of(law, length).restore(ridge::critical().displacement);
    let upper = flat_limits(law, length).map_or(0.0, |(_, upper)| upper);
    ridge.max(upper) + SPARE * law.range
}

/// The whole number of this key that the scene has; `None` of other numbers.
fn whole(scene: &Scene, key: &str) -> Option<f64> {
    let known = scene.numbers().into_iter();
    known
        .filter(|(parameter, _)| parameter.key == key)
        .find_map(|(_, value)| match value {
            Value::Whole(n) => Some(n as f64),
            _ => None,
        })
}

/// A loop that was computed.
pub struct Measured<'a> {
    /// Its scene.
    pub scene: &'a Scene,
    /// What that means.
    pub model: &'a Model,
    /// How it was to be computed.
    pub plan: &'a Plan,
    /// The loop.
    pub run: &'a LoopRun,
    /// What it loses, if it was completed.
    pub ledger: Option<Ledger>,
    /// Time on the wall.
    pub seconds: f64,
}

/// What stands in a column.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// A number; NaN where there is none.
    Number(f64),
    /// A count.
    Count(usize),
    /// Numbers, one a jump.
    Numbers(Vec<f64>),
    /// Anything else.
    Word(String),
}

impl Cell {
    /// Its numbers that are finite.
    pub fn numbers(&self) -> Vec<f64> {
        let all = match self {
            Cell::Number(x) => vec![*x],
            Cell::Count(n) => vec![*n as f64],
            Cell::Numbers(all) => all.clone(),
            Cell::Word(_) => Vec::new(),
        };
        all.into_iter().filter(|x| x.is_finite()).collect()
    }
}

impl From<Option<f64>> for Cell {
    fn from(value: Option<f64>) -> Self {
        // Adding zero turns -0.0, the sum of nothing, into 0.0.
        Cell::Number(value.unwrap_or(f64::NAN) + 0.0)
    }
}

/// Something that can be recorded.
#[derive(Debug)]
pub struct Column {
    /// Its name in study files and tables.
    pub name: &'static str,
    /// What it is, with its unit.
    pub what: &'static str,
    of: fn(&Measured<'_>) -> Cell,
}

impl<'a> Measured<'a> {
    /// A loop that took so many seconds.
    pub fn new(
        scene: &'a Scene,
        model: &'a Model,
        plan: &'a Plan,
        run: &'a LoopRun,
        seconds: f64,
    ) -> Self {
        Self {
            scene,
            model,
            plan,
            run,
            ledger: run.ledger(model.law.surface_energy),
            seconds,
        }
    }
}

impl Column {
    /// What stands in it.
    pub fn of(&self, measured: &Measured<'_>) -> Cell {
        (self.of)(measured)
    }
}

/// What is recorded where a study does not say.
pub const DEFAULT: [&str; 11] = [
    "dissipated_energy",
    "predicted_error",
    "jumps",
    "approach_jumps",
    "retraction_jumps",
    "pull_off_stress",
    "closed",
    "contested",
    "points",
    "transforms",
    "seconds",
];

/// The column of this name.
pub fn column(name: &str) -> Option<&'static Column> {
    COLUMNS.iter().find(|column| column.name == name)
}

macro_rules! columns {
    ($($name:literal, $what:literal, $of:expr;)*) => {
        /// Everything that can be recorded.
        pub static COLUMNS: &[Column] = &[$(Column { name: $name, what: $what, of: $of },)*];
    };
}

columns! {
    "dissipated_energy", "what the loop loses, per area over γ; NaN unless it is closed",
        |m| of_ledger(m, Ledger::dissipated_energy);
    "predicted_error", "relative error to be expected of the loss and of the jumps' places, as a finer mesh tells it; 1 where nothing can be promised, NaN where nothing is known",
        |m| Cell::Number(predicted_error(m.plan, m.run));
    "stated_error", "relative error of the loss; NaN where nothing is promised",
        |m| stated_error(m.model, m.plan, m.run).into();
    "released_energy_sum", "sum of the energies released in jumps, per area over γ",
        |m| Some(m.run.record.released_energy_sum()).into();
    "released_energy_error", "how far that may be off because ends of branches are located only so well",
        |m| of_ledger(m, |ledger| Some(ledger.released_energy_error));
    "loop_integral", "loop integral of σ du₀ over γ, the check of the loss",
        |m| of_ledger(m, |ledger| Some(ledger.loop_integral).filter(|_| ledger.open.is_none()));
    "ledger_mismatch", "difference of the two over the loss",
        |m| of_ledger(m, Ledger::mismatch);
    "jumps", "how many jumps of the physics there are",
        |m| Cell::Count(m.run.record.tally().jumps);
    "mesh_jumps", "how many jumps of the mesh",
        |m| Cell::Count(m.run.record.tally().of_the_mesh);
    "transitions", "how often the pattern changes without a jump",
        |m| Cell::Count(m.run.record.tally().transitions);
    "approach_jumps", "u₀ of each jump on approach, in order, with spaces between them (length)",
        |m| Cell::Numbers(places(m, Direction::Approach));
    "retraction_jumps", "the same on retraction",
        |m| Cell::Numbers(places(m, Direction::Retraction));
    "approach_patterns", "the patterns that are passed on approach, in order",
        |m| Cell::Word(patterns(m, Direction::Approach));
    "retraction_patterns", "the same on retraction",
        |m| Cell::Word(patterns(m, Direction::Retraction));
    "pull_off_stress", "largest mean stress, in tension (E\\*, or `units.modulus`)",
        |m| m.run.pull_off().map(|stress| stress_given(m, stress)).into();
    "pull_off_force", "the same times the area of the cell, with lengths as in the scene; NaN of a line cell",
        |m| m.run.pull_off().and_then(|stress| m.model.of_cell(stress_given(m, stress))).into();
    "compression_max", "largest mean stress in compression, positive (as the pull-off stress)",
        |m| largest(m, |state| -state.stress).map(|stress| stress_given(m, stress)).into();
    "closed", "true if the loop was completed and ends in the state with which it began",
        |m| Cell::Word(m.ledger.as_ref().is_some_and(|ledger| ledger.open.is_none()).to_string());
    "contested", "where the surface may land, if that is contested",
        |m| Cell::Word(contested(m));
    "points", "points along a side of the mesh",
        |m| Cell::Count(m.model.grid.nx);
    "mu_rho", "mesh number of Eq. 10",
        |m| Cell::Number(m.model.mu_rho);
    "model", "how it was computed: `atlas`, or the part of the cell that was walked",
        |m| Cell::Word(m.plan.carried_out(m.run.deviation.as_deref()).word().to_owned());
    "states", "recorded states",
        |m| Cell::Count(m.run.record.states.len());
    "states_not_stable", "recorded states that are not converged and stable",
        |m| Cell::Count(m.run.record.states.iter().filter(|state| state.stop != Stop::Stable).count());
    "patterned_increments", "increments that ended in a pattern other than flat",
        |m| Cell::Count(m.run.counts.patterned_increments);
    "transforms", "Fourier transforms spent on it",
        |m| Cell::Count(m.run.counts.transforms);
    "proof_transforms", "those of them that prove that no mode is softer than the ones that are followed",
        |m| Cell::Count(m.run.counts.proof_transforms);
    "transforms_per_patterned_increment", "transforms over patterned increments; NaN without any",
        |m| Some(m.run.counts).filter(|counts| counts.patterned_increments > 0)
            .map(|counts| counts.transforms as f64 / counts.patterned_increments as f64).into();
    "iterations", "iterations of the method",
        |m| Cell::Count(m.run.counts.iterations);
    "stiffness_min_least", "least smallest eigenvalue of all states (E\\*/L)",
        |m| largest(m, |state| -state.stiffness_min).map(|largest| -largest).into();
    "stiffness_error_max", "largest error bound of a smallest eigenvalue (E\\*/L)",
        |m| largest(m, |state| state.stiffness_error).into();
    "residual_max", "largest residual of all states",
        |m| largest(m, |state| state.residual).into();
    "seconds", "time on the wall, the only column that differs from run to run",
        |m| Cell::Number((m.seconds * 1e4).round() / 1e4);
}

fn largest(m: &Measured<'_>, number: fn(&StateRecord) -> f64) -> Option<f64> {
    m.run.record.states.iter().map(number).reduce(nan_max)
}

fn of_ledger(m: &Measured<'_>, number: fn(&Ledger) -> Option<f64>) -> Cell {
    m.ledger.as_ref().and_then(number).into()
}

fn stress_given(m: &Measured<'_>, stress: f64) -> f64 {
    m.scene.number_given(Dimension::Stress, stress)
}

/// u0 of the jumps of the physics.
fn places(m: &Measured<'_>, direction: Direction) -> Vec<f64> {
    let jumps = m.run.record.jumps.iter();
    jumps
        .filter(|jump| jump.direction == direction)
        .filter(|jump| !matches!(jump.cause, Cause::Mesh | Cause::Transition))
        .map(|jump| jump.mean_displacement)
        .collect()
}

fn patterns(m: &Measured<'_>, direction: Direction) -> String {
    let pieces = m
        .run
        .record
        .pieces()
        .filter(|piece| piece[0].direction == direction);
    let words: Vec<&str> = pieces.map(|piece| piece[0].pattern.word()).collect();
    words.join(" ")
}

fn contested(m: &Measured<'_>) -> String {
    let words = m
        .run
        .record
        .jumps
        .iter()
        .filter_map(JumpRecord::contested_words);
    words.collect::<Vec<_>>().join("; ")
}
