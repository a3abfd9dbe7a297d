//! What can be recorded of a loop. The numbers of `summary.json` have the same names here and are
//! the same numbers.

use crate::follow::ledger::Ledger;
use crate::follow::record::{Cause, Direction, JumpRecord};
use crate::follow::run::{LoopRun, nan_max};
use crate::physics::parameter::Dimension;
use crate::scene::{Model, Scene};
use crate::study::plan::{Plan, predicted_error, stated_error};

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
    "predicted_error", "relative error to be expected of the loss and of the jumps' u₀, as a finer mesh tells it; 1 where nothing can be promised, NaN where nothing is known",
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
        |m| m.run.record.states.iter().map(|state| -state.stress)
            .reduce(nan_max).map(|stress| stress_given(m, stress)).into();
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
    "transforms", "Fourier transforms spent on it",
        |m| Cell::Count(m.run.counts.transforms);
    "stiffness_min_least", "least smallest eigenvalue of all states (E\\*/L)",
        |m| m.run.record.states.iter().map(|state| -state.stiffness_min)
            .reduce(nan_max).map(|largest| -largest).into();
    "seconds", "time on the wall, the only column that differs from run to run",
        |m| Cell::Number((m.seconds * 1e4).round() / 1e4);
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
