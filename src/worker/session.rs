//! What the solver thread does, as a state machine without a thread: tests step it by hand, with a clock they hold.

use super::course::Course;
use super::protocol::{Command, Event, Frame, LoopSummary, Motion, Output, Ready, RunId, Speed, Sweep};
use crate::experiment::record::{LoopRecord, StateRecord};
use crate::experiment::scene::{SceneError, Turn};
use crate::experiment::walk::{EnergyWell, Observed, Progress, Walk, Widened};
use crate::numerics::cancel::Cancel;
use crate::physics::pattern::Pattern;
use crate::physics::theory::flat;
use crate::solver::equilibrium::Equilibrium;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Shortest time between two states of a sweep at normal speed, so that a loop can be watched.
const PACE_STATE: Duration = Duration::from_millis(12);
/// Shortest time between two pictures of a jump at normal speed, so that it is seen as a short film.
const PACE_FILM: Duration = Duration::from_millis(16);

/// Shortest time between two energy wells on the move, and the largest share of the time they may take.
const PACE_WELL: Duration = Duration::from_millis(100);
const WELL_SHARE: f64 = 0.1;
/// Energies of a well computed in one piece of work at rest, so that a command never waits for long.
const WELL_PIECE: usize = 8;

/// A scene being played.
#[derive(Default)]
pub struct Session {
    run: RunId,
    /// The newest motion asked for.
    motion: Motion,
    course: Option<Course>,
    walk: Option<Walk>,
    /// Where the walk last stood, kept apart from it: after a panic the walk itself is not to be trusted.
    good: Option<(Equilibrium, StateRecord)>,
    sweep: Option<Leg>,
    record: LoopRecord,
    loop_began: Option<Instant>,
    /// Transforms the loop has spent on walks that were given up, and those of the present walk before the loop began.
    transforms_elsewhere: usize,
    transforms_before: usize,
    busy: bool,
    paused: bool,
    not_before: Option<Instant>,
    speed: Speed,
    /// Somebody looks at the energy well.
    watched: bool,
    /// The well at rest as far as it is computed.
    well: Option<EnergyWell>,
    /// When the last well on the move may be followed by another.
    well_after: Option<Instant>,
}

/// Which part of a sweep is under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Leg {
    Approach { then_back: bool },
    Retract { closes: bool },
}

impl Session {
    /// How long the thread may sleep: `None` until a command comes, zero if there is work now.
    pub fn wait(&self, now: Instant) -> Option<Duration> {
        if !self.busy || self.paused || self.walk.is_none() {
            return self.well.as_ref().map(|_| Duration::ZERO);
        }
        Some(self.not_before.map_or(Duration::ZERO, |t| t.saturating_duration_since(now)))
    }

    /// Takes a command; those of another run, and motions older than the newest, are stale and dropped.
    pub fn command(&mut self, command: Command, cancel: &Cancel, sink: &mut dyn FnMut(Output)) {
        if let Command::SetTarget { run, motion, .. } | Command::Sweep { run, motion, .. } | Command::Stop { run, motion } = command
        {
            if run != self.run || motion < self.motion {
                return;
            }
            self.motion = motion;
        }
        match command {
            Command::SetScene { run, scene, method, asked } => match Course::new(scene, method, asked) {
                Ok(course) => self.begin(run, course, cancel, sink),
                Err(error) => self.refuse(run, error, sink),
            },
            Command::SetTarget { mean_displacement, .. } => {
                self.sweep = None;
                self.go(mean_displacement);
            }
            Command::Sweep { sweep, .. } => self.start_sweep(sweep, cancel, sink),
            Command::Pause { paused } => {
                self.paused = paused;
                self.look_into_the_well();
            }
            Command::Stop { .. } => self.rest(sink),
            Command::Watch { energy_well } => {
                self.watched = energy_well;
                self.look_into_the_well();
            }
            Command::SetSpeed { speed } => self.speed = speed,
            Command::Measure { .. } | Command::StopMeasuring | Command::OpenPage { .. } | Command::ClosePage | Command::Quit => {}
        }
    }

    /// Does one bounded piece of work.
    pub fn step(&mut self, now: Instant, cancel: &Cancel, sink: &mut dyn FnMut(Output)) {
        if !self.busy || self.paused {
            return self.deepen_the_well(WELL_PIECE, sink);
        }
        let Some(walk) = &mut self.walk else { return };
        let run = self.run;
        let mut seen = Vec::new();
        let progress = walk.step(cancel, &mut |h| seen.push(h));
        let mut pace = Duration::ZERO;
        for observed in seen {
            match observed {
                Observed::Moving { stress } => {
                    pace = self.speed.pause(PACE_FILM);
                    let mean_displacement = walk.displacement();
                    let gap = Arc::new(walk.gap());
                    sink(Output::Frame(
                        run,
                        Frame { mean_displacement, stress, gap, soft_mode: None, relaxing: true, state: None },
                    ));
                }
                Observed::Jump(jump) => {
                    self.record.jumps.push(jump.clone());
                    sink(Output::Event(Event::Jump { run, jump }));
                }
                Observed::State(state) => {
                    if self.sweep.is_some() {
                        pace = self.speed.pause(PACE_STATE);
                    }
                    self.record.states.push(state.clone());
                    self.good = Some((walk.here().clone(), state.clone()));
                    sink(Output::Event(Event::State { run, state }));
                    sink(Output::Frame(run, resting_frame(walk)));
                }
            }
        }
        self.not_before = Some(now + pace);
        self.follow_up(progress, now, cancel, sink);
        if self.busy && self.watched && self.well_after.is_none_or(|t| now >= t) {
            let began = Instant::now();
            self.well = self.walk.as_mut().and_then(Walk::energy_well);
            while self.well.is_some() && !cancel.requested() {
                self.deepen_the_well(WELL_PIECE, sink);
            }
            self.well_after = Some(now + PACE_WELL.max(began.elapsed().div_f64(WELL_SHARE)));
        }
    }

    /// At rest: begins to compute the well if somebody looks.
    fn look_into_the_well(&mut self) {
        self.well = None;
        if self.watched && (!self.busy || self.paused) {
            self.well = self.walk.as_mut().and_then(Walk::energy_well);
        }
    }

    fn deepen_the_well(&mut self, count: usize, sink: &mut dyn FnMut(Output)) {
        let (Some(walk), Some(mut well)) = (&mut self.walk, self.well.take()) else { return };
        walk.deepen(&mut well, count);
        if well.is_complete() {
            sink(Output::Event(Event::Well { run: self.run, well: Arc::new(well) }));
        } else {
            self.well = Some(well);
        }
    }

    /// After a panic: rests on the last good state, or at the start of the scene if there is none. Returns the run it belongs to.
    pub fn recover(&mut self) -> RunId {
        let Self { run, motion, course, good, record, speed, watched, .. } = std::mem::take(self);
        *self = Self { run, motion, course, record, speed, watched, ..Self::default() };
        if let Some(course) = &self.course {
            self.walk = match good {
                Some((state, record)) => course.resume(state, record).ok(),
                None => course.walk(&Cancel::default()).ok(),
            };
        }
        run
    }

    fn begin(&mut self, run: RunId, course: Course, cancel: &Cancel, sink: &mut dyn FnMut(Output)) {
        *self = Self { run, speed: self.speed, watched: self.watched, ..Self::default() };
        match course.walk(cancel) {
            Ok(mut walk) => {
                let system = walk.system();
                let flat_limits = if system.is_flat() { flat::limits(system.law(), system.grid().length) } else { None };
                let height = system.height().map(|h| Arc::new(system.unfolded(h)));
                let ready = Arc::new(Ready { model: walk.model().clone(), height, flat_limits, choice: course.choice.clone() });
                sink(Output::Event(Event::Ready { run, ready }));
                sink(Output::Event(Event::State { run, state: walk.record().clone() }));
                sink(Output::Frame(run, resting_frame(&mut walk)));
                sink(Output::Event(Event::Rest { run, motion: 0, mean_displacement: walk.record().mean_displacement }));
                self.record.states.push(walk.record().clone());
                self.walk = Some(walk);
                self.course = Some(course);
                self.look_into_the_well();
            }
            Err(error) => self.refuse(run, error, sink),
        }
    }

    fn refuse(&mut self, run: RunId, error: SceneError, sink: &mut dyn FnMut(Output)) {
        *self = Self { run, speed: self.speed, watched: self.watched, ..Self::default() };
        sink(Output::Event(Event::Failed {
            run,
            message: format!("This scene cannot run: {} = {}", error.key, error.value),
            remedy: error.allowed,
        }));
    }

    fn go(&mut self, target: f64) {
        if let Some(walk) = &mut self.walk {
            walk.set_target(target);
            self.well = None;
            self.busy = true;
            self.not_before = None;
        }
    }

    fn start_sweep(&mut self, sweep: Sweep, cancel: &Cancel, sink: &mut dyn FnMut(Output)) {
        let Some(course) = &self.course else { return };
        let start = course.scene.drive.start;
        match sweep {
            Sweep::Approach => (self.sweep, self.paused) = (Some(Leg::Approach { then_back: false }), false),
            Sweep::Retract => (self.sweep, self.paused) = (Some(Leg::Retract { closes: false }), false),
            Sweep::Loop => {
                // A loop is only closed if it begins at the start of the drive, with the scene's own seed.
                self.walk = course.walk(cancel).ok();
                self.record = LoopRecord::default();
                sink(Output::Event(Event::LoopStarted { run: self.run }));
                if let Some(walk) = &mut self.walk {
                    self.record.states.push(walk.record().clone());
                    sink(Output::Event(Event::State { run: self.run, state: walk.record().clone() }));
                    sink(Output::Frame(self.run, resting_frame(walk)));
                }
                self.loop_began = Some(Instant::now());
                self.transforms_elsewhere = 0;
                self.transforms_before = self.walk.as_ref().map_or(0, |w| w.counts().transforms);
                (self.sweep, self.paused) = (Some(Leg::Approach { then_back: true }), false);
            }
        }
        if let Some(fault) = self.record.states.first().filter(|_| sweep == Sweep::Loop).and_then(StateRecord::fault) {
            sink(Output::Event(Event::Failed { run: self.run, message: format!("No loop: {}.", fault.0), remedy: fault.1 }));
            return self.rest(sink);
        }
        self.go(if sweep == Sweep::Retract { start } else { self.depth() });
    }

    /// Where an approach turns; at zero load the sign of the stress ends it before.
    fn depth(&self) -> f64 {
        self.course.as_ref().map_or(f64::NAN, |course| course.scene.depth())
    }

    /// What comes after a step: nothing, the next leg, or rest.
    fn follow_up(&mut self, progress: Progress, now: Instant, cancel: &Cancel, sink: &mut dyn FnMut(Output)) {
        let (Some(course), Some(walk)) = (&mut self.course, &mut self.walk) else { return };
        let scene = course.scene.clone();
        let state = walk.record();
        let waits_for_load = scene.drive.turn == Turn::ZeroLoad && matches!(self.sweep, Some(Leg::Approach { .. }));
        let unloaded = waits_for_load && state.pattern == Pattern::Contact && state.stress <= 0.0;
        match progress {
            Progress::Working if !unloaded => {}
            Progress::Cancelled => {}
            Progress::Working | Progress::Resting => match self.sweep {
                Some(Leg::Approach { then_back: true }) => {
                    self.sweep = Some(Leg::Retract { closes: true });
                    let start = scene.drive.start;
                    self.go(start);
                }
                Some(Leg::Retract { closes: true }) => {
                    self.close_loop(now, sink);
                    self.rest(sink);
                }
                _ => self.rest(sink),
            },
            Progress::Stuck(reason) => {
                let spent = walk.counts().transforms;
                if let Some(widened) = course.widen(walk, &reason, cancel) {
                    sink(Output::Event(Event::Remodelled { run: self.run, choice: course.choice.clone() }));
                    return self.go_on_with(widened, spent, sink);
                }
                sink(Output::Event(Event::Failed {
                    run: self.run,
                    message: format!("Not converged: {reason}."),
                    remedy: "The last good state stays. Try a smaller step, a finer mesh (lower mu_rho), or another seed.".into(),
                }));
                self.rest(sink);
            }
        }
    }

    /// Takes another walk up, which stands where the last one stood or is back at the start of the drive.
    fn go_on_with(&mut self, Widened { mut walk, stays }: Widened, spent: usize, sink: &mut dyn FnMut(Output)) {
        self.transforms_elsewhere += spent - self.transforms_before;
        self.transforms_before = 0;
        if !stays {
            self.record = LoopRecord::default();
            self.record.states.push(walk.record().clone());
            sink(Output::Event(Event::LoopStarted { run: self.run }));
            sink(Output::Event(Event::State { run: self.run, state: walk.record().clone() }));
        }
        self.good = Some((walk.here().clone(), walk.record().clone()));
        sink(Output::Frame(self.run, resting_frame(&mut walk)));
        self.walk = Some(walk);
        if !stays && self.sweep == Some(Leg::Retract { closes: true }) {
            // Back at the start, a loop has its approach ahead again.
            self.sweep = Some(Leg::Approach { then_back: true });
            self.go(self.depth());
        }
    }

    fn close_loop(&mut self, now: Instant, sink: &mut dyn FnMut(Output)) {
        let Some(walk) = &self.walk else { return };
        let summary = LoopSummary {
            ledger: self.record.ledger(walk.model().law.surface_energy),
            transforms: self.transforms_elsewhere + walk.counts().transforms - self.transforms_before,
            seconds: self.loop_began.map_or(0.0, |t| now.duration_since(t).as_secs_f64()),
        };
        sink(Output::Event(Event::Loop { run: self.run, summary }));
    }

    fn rest(&mut self, sink: &mut dyn FnMut(Output)) {
        self.busy = false;
        self.sweep = None;
        if let Some(walk) = &mut self.walk {
            let mean_displacement = walk.displacement();
            walk.set_target(mean_displacement);
            sink(Output::Event(Event::Rest { run: self.run, motion: self.motion, mean_displacement }));
        }
        self.look_into_the_well();
    }
}

fn resting_frame(walk: &mut Walk) -> Frame {
    let state = walk.record().clone();
    Frame {
        mean_displacement: state.mean_displacement,
        stress: state.stress,
        gap: Arc::new(walk.gap()),
        soft_mode: walk.soft_mode().map(Arc::new),
        relaxing: false,
        state: Some(state),
    }
}
