//! A whole loop in one call: approach, retraction, and what they add up to; and the path of the
//! drive, which the window steps too.

use super::ledger::Ledger;
use super::record::{Direction, JumpRecord, LoopRecord, Share, StateRecord};
use super::walk::{Counts, Observed, Progress, Stuck, Walk, WalkOptions, Widened};
use crate::numerics::threads::Cancel;
use crate::physics::control::Control;
use crate::physics::parameter::Refusal;
use crate::physics::pattern::Pattern;
use crate::scene::{Scene, Turn};
use ndarray::Array2;

/// A loop, complete or as far as it came.
#[derive(Clone, Debug)]
pub struct LoopRun {
    /// States and jumps.
    pub record: LoopRecord,
    /// How it ended.
    pub outcome: Outcome,
    /// What it cost.
    pub counts: Counts,
    /// A picture of each pattern where it was first reached.
    pub landings: Vec<Landing>,
    /// Why it was not computed as it was meant to be, in words, if it was not.
    pub deviation: Option<String>,
    /// Relative error of loss and jumps as a finer mesh tells it ([`crate::study::plan::run_planned`]);
    /// `None` unless it was asked.
    pub error_bar: Option<f64>,
    /// The loops of other landings, if it is contested where the surface lands.
    pub rivals: Vec<RivalLoop>,
}

/// The loop of another landing from a limit of the flat state.
#[derive(Clone, Debug, PartialEq)]
pub struct RivalLoop {
    /// Where the surface lands, and how often.
    pub landing: Share,
    /// Its loss over gamma; `None` where that is not known.
    pub dissipated_energy: Option<f64>,
}

impl LoopRun {
    /// A loop of this control of which nothing is computed yet.
    pub(crate) fn of(control: Control) -> Self {
        Self {
            record: LoopRecord::of(control),
            outcome: Outcome::Completed,
            counts: Counts::default(),
            landings: Vec::new(),
            deviation: None,
            error_bar: None,
            rivals: Vec::new(),
        }
    }

    /// The ledger, for a law of `surface_energy` gamma; `None` if the drive was not completed.
    pub fn ledger(&self, surface_energy: f64) -> Option<Ledger> {
        (self.outcome == Outcome::Completed).then(|| self.record.ledger(surface_energy))
    }

    /// Where and why it stopped; `None` if it was completed.
    pub fn stop_reason(&self) -> Option<String> {
        match &self.outcome {
            Outcome::Completed => None,
            Outcome::NotConverged {
                mean_displacement,
                reason,
            } => Some(format!("u0 = {mean_displacement}: {reason}")),
            Outcome::Cancelled => {
                let at = self
                    .record
                    .states
                    .last()
                    .map_or("before the first state".to_owned(), |s| {
                        format!("u0 = {}", s.mean_displacement)
                    });
                Some(format!("{at}: interrupted"))
            }
        }
    }

    /// The largest mean stress, in tension (E*); NaN if one is.
    pub fn pull_off(&self) -> Option<f64> {
        let stresses = self.record.states.iter().map(|state| state.stress);
        stresses.reduce(nan_max)
    }
}

/// The larger one; NaN wins, so that it is not swallowed.
pub fn nan_max(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

/// How a loop ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// The drive went all the way; whether the loop is closed says its ledger.
    Completed,
    /// The solver could not go on; everything before stands.
    NotConverged {
        /// Last u0 reached (length).
        mean_displacement: f64,
        /// What happened.
        reason: Stuck,
    },
    /// Somebody asked to stop; everything before stands.
    Cancelled,
}

impl Outcome {
    /// Its word in files.
    pub fn word(&self) -> &'static str {
        match self {
            Outcome::Completed => "completed",
            Outcome::NotConverged { .. } => "not converged",
            Outcome::Cancelled => "cancelled",
        }
    }
}

/// The surface just after a jump (or at the start).
#[derive(Clone, Debug)]
pub struct Landing {
    /// Direction of the drive.
    pub direction: Direction,
    /// What it shows.
    pub pattern: Pattern,
    /// Gap field (length), shape (ny, nx).
    pub gap: Array2<f64>,
}

/// What a loop reports while it runs.
#[derive(Clone, Copy, Debug)]
pub enum Report<'a> {
    /// A new state, and the share of the loop that is done.
    State {
        /// The state.
        record: &'a StateRecord,
        /// Its place among the states of the loop; one that is not new takes the place of what came
        /// before from there on.
        index: usize,
        /// Gap and displacement (lengths), of shape (ny, nx).
        fields: [&'a Array2<f64>; 2],
        /// 0 to 1.
        fraction: f64,
    },
    /// A jump.
    Jump(&'a JumpRecord),
}

/// Why a loop is not what was planned.
pub(crate) fn walked_after_all(reason: &str) -> String {
    format!("walked on the whole cell after all: {reason}")
}

/// Runs the closed loop of `scene`: from the start of its drive to the turning point and back. On a
/// part of the cell that proves too small it goes on on the whole of it.
///
/// # Errors
/// The first value of the scene that is not allowed. Failures on the way are an [`Outcome`].
pub fn run_loop(
    scene: &Scene,
    options: WalkOptions,
    cancel: &Cancel,
    observe: &mut dyn FnMut(Report<'_>),
) -> Result<LoopRun, Refusal> {
    let mut drive = Drive::new(Walk::start(scene, options, cancel)?, scene);
    if cancel.requested() {
        drive.run.outcome = Outcome::Cancelled;
        return Ok(drive.run);
    }
    if let Some((what, remedy)) = drive.walk.record().fault() {
        let reason = Stuck::NoStart { what, remedy };
        drive.run.outcome = Outcome::NotConverged {
            mean_displacement: scene.drive.start,
            reason,
        };
        return Ok(drive.run);
    }
    drive.tell(observe);
    while let Some(target) = drive.itinerary.target() {
        drive.walk.set_target(target);
        let progress = drive.step(cancel, observe);
        match progress {
            Progress::Working | Progress::Resting => {
                drive.itinerary.step(&progress, drive.walk.record());
            }
            Progress::Cancelled => {
                drive.run.outcome = Outcome::Cancelled;
                break;
            }
            Progress::Stuck(reason) => match drive.walk.widen(&reason, scene, cancel) {
                Some(widened) => drive.go_on_with(widened, &reason, observe),
                None => {
                    let mean_displacement = drive.walk.record().mean_displacement;
                    drive.run.outcome = Outcome::NotConverged {
                        mean_displacement,
                        reason,
                    };
                    break;
                }
            },
        }
    }
    let spent = drive.walk.counts();
    drive.run.counts += spent;
    Ok(drive.run)
}

/// A drive under way: down to the turning point, and back to the start.
struct Drive<'s> {
    scene: &'s Scene,
    walk: Walk,
    run: LoopRun,
    itinerary: Itinerary,
    /// True if the next state is the first of its branch.
    landed: bool,
    lowest: f64,
    /// How much of the loop is done, 0 to 1.
    fraction: f64,
}

impl<'s> Drive<'s> {
    fn new(walk: Walk, scene: &'s Scene) -> Self {
        let (start, mut run) = (scene.drive.start, LoopRun::of(scene.control()));
        run.record.states.push(walk.record().clone());
        Self {
            scene,
            walk,
            run,
            itinerary: Itinerary::closed(scene),
            landed: true,
            lowest: start,
            fraction: 0.0,
        }
    }

    /// One step of the walk, told and recorded.
    fn step(&mut self, cancel: &Cancel, observe: &mut dyn FnMut(Report<'_>)) -> Progress {
        let Self {
            scene,
            walk,
            run,
            itinerary,
            landed,
            lowest,
            fraction,
        } = self;
        let start = scene.drive.start;
        let depth = match scene.drive.turn {
            Turn::At(turn) => start - turn,
            Turn::ZeroLoad => f64::INFINITY,
        };
        let retracting = itinerary.direction() == Some(Direction::Retraction);
        let mut fresh = false;
        let progress = walk.step(cancel, &mut |observed| match observed {
            Observed::Moving { .. } => {}
            Observed::Jump(jump) => {
                *landed = true;
                observe(Report::Jump(&jump));
                run.record.jumps.push(jump);
            }
            Observed::State(state) => {
                fresh = true;
                *lowest = lowest.min(state.control);
                let gone = if retracting {
                    1.0 + (state.control - *lowest) / (start - *lowest)
                } else {
                    (start - state.control) / depth
                };
                *fraction = 0.5 * gone.clamp(0.0, 2.0);
                run.record.states.push(state);
            }
        });
        if fresh {
            self.tell(observe);
        }
        if fresh && std::mem::take(&mut self.landed) {
            let gap = self.walk.gap();
            let record = self.walk.record();
            self.run.landings.push(Landing {
                direction: record.direction,
                pattern: record.pattern,
                gap,
            });
        }
        let record = self.walk.record();
        if fresh && !(record.stress.is_finite() && record.energy.is_finite()) {
            return Progress::Stuck(Stuck::NotFinite);
        }
        progress
    }

    /// Tells of the last state.
    fn tell(&self, observe: &mut dyn FnMut(Report<'_>)) {
        let Some(record) = self.run.record.states.last() else {
            return;
        };
        let (system, gap) = (self.walk.system(), &self.walk.here().fields.gap);
        let displacement = system
            .height()
            .map(|height| system.unfolded(&(gap + height)));
        let gap = system.unfolded(gap);
        observe(Report::State {
            record,
            index: self.run.record.states.len() - 1,
            fields: [&gap, displacement.as_ref().unwrap_or(&gap)],
            fraction: self.fraction,
        });
    }

    /// On the whole cell, from where the walk stood or from the start of the drive.
    fn go_on_with(
        &mut self,
        Widened { walk, stays }: Widened,
        because: &Stuck,
        observe: &mut dyn FnMut(Report<'_>),
    ) {
        self.run.counts += self.walk.counts();
        if stays {
            self.walk = walk;
            let here = self.walk.record().mean_displacement;
            self.run.deviation = Some(format!("on the whole cell from u0 = {here} on: {because}"));
        } else {
            let counts = self.run.counts;
            *self = Self::new(walk, self.scene);
            self.run.counts = counts;
            self.run.deviation = Some(walked_after_all(&because.to_string()));
            self.tell(observe);
        }
    }
}

/// The ways still to go.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Itinerary {
    start: f64,
    /// The control at which an approach turns at the latest.
    depth: f64,
    /// An approach turns where the load on a contact is zero.
    to_zero_load: bool,
    /// The present way last.
    ahead: Vec<Direction>,
}

impl Itinerary {
    /// The closed loop of the scene's drive: down to its turning point, and back to its start.
    pub fn closed(scene: &Scene) -> Self {
        Self {
            ahead: vec![Direction::Retraction, Direction::Approach],
            ..Self::one_way(scene, Direction::Approach)
        }
    }

    /// One way of the scene's drive, from wherever the surface is.
    pub fn one_way(scene: &Scene, direction: Direction) -> Self {
        let to_zero_load = scene.drive.turn == Turn::ZeroLoad;
        Self {
            start: scene.drive.start,
            depth: scene.depth(),
            to_zero_load,
            ahead: vec![direction],
        }
    }

    /// The present way; `None` at the end of all.
    pub fn direction(&self) -> Option<Direction> {
        self.ahead.last().copied()
    }

    /// The control for which the present way makes; `None` at the end of all.
    pub fn target(&self) -> Option<f64> {
        Some(match self.direction()? {
            Direction::Approach => self.depth,
            Direction::Retraction => self.start,
        })
    }

    /// Takes in how a step of the walk ended, and its last record; true if the present way ended
    /// with it.
    pub fn step(&mut self, progress: &Progress, record: &StateRecord) -> bool {
        let approaches = self.direction() == Some(Direction::Approach);
        let unloaded = self.to_zero_load
            && approaches
            && record.pattern == Pattern::Contact
            && record.stress <= 0.0;
        let ends = *progress == Progress::Resting || *progress == Progress::Working && unloaded;
        if ends {
            self.ahead.pop();
        }
        ends
    }
}
