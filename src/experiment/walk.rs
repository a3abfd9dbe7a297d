//! The walk along u0: follow the branch in bounded steps, locate where it ends, release, land on what is stable.
//!
//! A state machine stepped by hand: [`Walk::step`] does one bounded piece of work (one increment, or a slice of a release) and hands
//! out what happened. It works on any scene and is the reference for every faster road.

mod accept;
mod advance;
mod fall;
pub(super) mod guard;
mod happening;
mod landing;
mod transition;
mod views;
mod widen;

pub use happening::{Counts, Happening, Progress};
pub use views::EnergyWell;
pub use widen::Widened;

use super::contest::Share;
use super::flat_branch::FlatBranch;
use super::plan::Reduction;
use super::record::{Cause, Direction, StateRecord};
use super::scene::{Model, Scene, SceneError, refuse};
use crate::numerics::cancel::Cancel;
use crate::numerics::precision::Precision;
use crate::physics::system::{State, System};
use crate::solver::Stop;
use crate::solver::branch::History;
use crate::solver::equilibrium::{Cost, Equilibrium};
use crate::solver::mechanics::{Mechanics, Slides};
use crate::solver::method::Method;
use crate::solver::methods::MethodKind;
use crate::solver::newton::{NewtonEnd, NewtonLimits, solve};
use crate::solver::release::Release;
use crate::solver::stability::Tracker;
use guard::{Guard, slides_on, with_coarse};
use rand::SeedableRng;
use rand_pcg::Pcg64;
use std::time::{Duration, Instant};

/// Why a branch cannot be followed beyond `at`.
#[derive(Clone, Debug)]
struct Barrier {
    at: f64,
    /// The negative eigenvalue found there (E* per length), if an equilibrium was.
    stiffness: Option<f64>,
    /// The mode that went soft, if it was seen.
    soft_mode: Vec<f64>,
}

/// What tells how a branch goes on: u0, smallest eigenvalue and stress of its last state but one.
#[derive(Clone, Copy, Debug)]
struct Before {
    at: f64,
    stiffness: f64,
    stress: f64,
}

/// A jump under way.
#[derive(Clone, Debug)]
struct Jumping {
    release: Release,
    cause: Cause,
    kicks: usize,
    /// The mode along which the state before gave way, and the size of the kick along it (ranges).
    soft_mode: Vec<f64>,
    kick: f64,
    /// Energy of the state before, carried to the u0 of the jump.
    energy_before: f64,
    /// Where kicks lead, if that is contested.
    landings: Vec<Share>,
}

/// A body on its way along u0.
pub struct Walk {
    model: Model,
    step: f64,
    start: f64,
    mechanics: Mechanics,
    method: Box<dyn Method>,
    flat: Option<FlatBranch>,
    /// On a quarter cell: the watch over modes of other symmetry.
    guard: Option<Guard>,
    rng: Pcg64,
    tracker: Tracker,
    /// Where it stands.
    here: Equilibrium,
    record: StateRecord,
    history: History,
    barrier: Option<Barrier>,
    /// Bracket width before the last trial, and whether the next must be the middle because that trial did not halve it.
    bracket: f64,
    halve: bool,
    /// The state before, if it is of the same branch.
    before: Option<Before>,
    /// The step that went well after a longer one had failed; it grows again.
    short: Option<f64>,
    /// Where jumps of a few points are gone downhill: how closely, in ranges, they are located.
    falls_within: Option<f64>,
    jumping: Option<Jumping>,
    /// The soft mode last shown, for the sign of the next.
    facing: Vec<f64>,
    target: f64,
    direction: Direction,
    counts: Counts,
    /// Work on the next record so far, not counting the time between steps.
    worked: Duration,
    step_began: Instant,
    seen: Cost,
    /// Transforms spent on looking where a surface may land.
    looked: usize,
}

impl Walk {
    /// A walk on the whole cell at rest at the start of the scene's drive.
    ///
    /// # Errors
    /// The first value of the scene that is not allowed.
    pub fn new(scene: &Scene, method: MethodKind) -> Result<Self, SceneError> {
        Self::reduced(scene, method, Reduction::Whole)
    }

    /// A walk on a part of the cell.
    ///
    /// # Errors
    /// The first value of the scene that is not allowed.
    pub fn reduced(scene: &Scene, method: MethodKind, reduction: Reduction) -> Result<Self, SceneError> {
        Self::with_method(scene, method.build(scene.seed), reduction)
    }

    /// A walk by any method, also one that is not in the list.
    ///
    /// # Errors
    /// The first value of the scene that is not allowed.
    pub fn with_method(scene: &Scene, method: Box<dyn Method>, reduction: Reduction) -> Result<Self, SceneError> {
        Self::begun(scene, method, reduction, Precision::Double, &Cancel::default())
    }

    /// The same with other numbers, and a token that ends the search for the first state: the walk then stands on none.
    ///
    /// # Errors
    /// The first value of the scene that is not allowed.
    pub fn begun(
        scene: &Scene,
        method: Box<dyn Method>,
        reduction: Reduction,
        precision: Precision,
        cancel: &Cancel,
    ) -> Result<Self, SceneError> {
        let model = scene.model()?;
        let even = reduction == Reduction::Quarter;
        if even && !model.grid.nx.is_multiple_of(4) {
            return Err(refuse("cell.points", model.grid.nx, "a multiple of 4 for a quarter of the cell"));
        }
        if even && !model.indenter.is_even() {
            return Err(refuse(
                "indenter.kind",
                "\"rough\"",
                "even ground for a quarter of the cell; rough ground needs the whole",
            ));
        }
        let system =
            if even { System::even } else { System::new }(model.grid, model.law, &model.indenter).with_precision(precision);
        let slides = slides_on(&model);
        let tracker = |salt: u64| Tracker::new(Pcg64::seed_from_u64(scene.seed ^ salt));
        let guard = even.then(|| Guard::of_even(&system, slides, tracker(0x9a4d)));
        let mut mechanics = Mechanics::new(system, if even { Slides::Never } else { slides });
        mechanics.cancel = cancel.clone();
        let flat = (mechanics.system.is_flat() && method.locates()).then(|| FlatBranch::new(model.law, model.grid.length));
        let mut tracker = with_coarse(tracker(0x5eed), &mechanics);
        let start = scene.drive.start;
        let here = match flat {
            Some(flat) => flat.state(&mechanics.system, start),
            None => {
                let uniform = vec![0.0; mechanics.system.dimension()];
                solved(&mut mechanics, &mut tracker, uniform, start)
            }
        };
        let mut walk = Self {
            step: scene.drive.step,
            start,
            mechanics,
            method,
            flat,
            guard,
            tracker,
            rng: Pcg64::seed_from_u64(scene.seed),
            history: History::starting(&here.state),
            record: StateRecord::placeholder(start),
            here,
            barrier: None,
            bracket: f64::INFINITY,
            halve: false,
            before: None,
            short: None,
            falls_within: None,
            jumping: None,
            facing: Vec::new(),
            target: start,
            direction: Direction::Approach,
            counts: Counts::default(),
            worked: Duration::ZERO,
            step_began: Instant::now(),
            seen: Cost::default(),
            looked: 0,
            model,
        };
        walk.accept(&mut |_| {});
        Ok(walk)
    }

    /// The same walk without the watch over modes that are not mirror-symmetric: what a surface does that is held so. On a coarse mesh
    /// single points let go; in the whole cell their mirror images do so one by one, a little earlier or later.
    pub fn mirrored(self) -> Self {
        Self { guard: None, ..self }
    }

    /// A walk on the whole cell that stands on a state an earlier walk of the same scene stood on.
    ///
    /// # Errors
    /// The first value of the scene that is not allowed.
    pub fn resume(scene: &Scene, method: MethodKind, state: Equilibrium, record: StateRecord) -> Result<Self, SceneError> {
        Self::resume_reduced(scene, method, Reduction::Whole, state, record)
    }

    /// The same on the part of the cell on which the earlier walk went.
    ///
    /// # Errors
    /// The first value of the scene that is not allowed.
    pub fn resume_reduced(
        scene: &Scene,
        method: MethodKind,
        reduction: Reduction,
        state: Equilibrium,
        record: StateRecord,
    ) -> Result<Self, SceneError> {
        Self::reduced(scene, method, reduction).map(|walk| walk.standing_on(state, record))
    }

    /// The same walk on another state of its scene.
    pub fn standing_on(mut self, mut state: Equilibrium, record: StateRecord) -> Self {
        let State { mean_displacement, amplitudes, .. } = state.state.clone();
        // It may come from another mesh, or have been moved.
        state.fields = self.mechanics.uncounted(|mechanics| mechanics.at(amplitudes, mean_displacement)).fields;
        self.target = mean_displacement;
        self.direction = record.direction;
        self.history = History::starting(&state.state);
        (self.here, self.record) = (state, record);
        self
    }

    /// The decided model.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Law, ground and cell.
    pub fn system(&self) -> &System {
        &self.mechanics.system
    }

    /// The method's name.
    pub fn method_name(&self) -> &'static str {
        self.method.name()
    }

    /// Record of the state it stands on.
    pub fn record(&self) -> &StateRecord {
        &self.record
    }

    /// The equilibrium it stands on.
    pub fn here(&self) -> &Equilibrium {
        &self.here
    }

    /// The mechanics, ready for where it stands.
    pub(super) fn mechanics(&self) -> &Mechanics {
        &self.mechanics
    }

    /// What was spent so far.
    pub fn counts(&self) -> Counts {
        let proofs = self.tracker.proof_transforms() + self.guard.as_ref().map_or(0, Guard::proof_transforms);
        Counts { transforms: self.transforms(), proof_transforms: proofs, ..self.counts }
    }

    fn transforms(&self) -> usize {
        self.looked
            + self.mechanics.transforms()
            + self.tracker.coarse_transforms()
            + self.guard.as_ref().map_or(0, Guard::transforms)
    }

    /// Mean displacement now; during a jump, that of the jump.
    pub fn displacement(&self) -> f64 {
        self.jumping.as_ref().map_or(&self.here.state, |jumping| &jumping.release.at.state).mean_displacement
    }

    /// Where it is going.
    pub fn target(&self) -> f64 {
        self.target
    }

    /// Sets where to go; the path already gone is kept, and a jump under way is completed first.
    pub fn set_target(&mut self, u0: f64) {
        self.target = u0;
    }

    /// Does one bounded piece of work.
    pub fn step(&mut self, cancel: &Cancel, observe: &mut dyn FnMut(Happening)) -> Progress {
        self.step_began = Instant::now();
        self.mechanics.cancel = cancel.clone();
        let progress = self.work(observe);
        self.pause_clock();
        progress
    }

    /// Books the time since the step began, or since it was last booked.
    fn pause_clock(&mut self) {
        let now = Instant::now();
        self.worked += now.duration_since(self.step_began);
        self.step_began = now;
    }

    fn work(&mut self, observe: &mut dyn FnMut(Happening)) -> Progress {
        if let Some(jumping) = self.jumping.take() {
            return self.relax(jumping, observe);
        }
        let here = self.here.state.mean_displacement;
        if here == self.target {
            return Progress::Resting;
        }
        if self.cancelled() {
            return Progress::Cancelled;
        }
        let direction = if self.target < here { Direction::Approach } else { Direction::Retraction };
        if direction != self.direction {
            self.direction = direction;
            (self.barrier, self.before, self.short) = (None, None, None);
        }
        match self.flat {
            Some(flat) if self.here.is_uniform() => self.step_flat(flat, observe),
            _ => self.step_patterned(observe),
        }
    }

    /// True once somebody asked to stop.
    fn cancelled(&self) -> bool {
        self.mechanics.cancel.requested()
    }
}

/// The equilibrium at `u0` that Newton's method finds from the amplitudes `z`, measured, or as far as it came.
fn solved(mechanics: &mut Mechanics, tracker: &mut Tracker, z: Vec<f64>, u0: f64) -> Equilibrium {
    let limits = NewtonLimits { steps: 40, ..NewtonLimits::of(&mechanics.system) };
    let found = solve(mechanics, z, u0, limits);
    let stop = match found.end {
        NewtonEnd::Converged => Stop::Stable,
        NewtonEnd::Cancelled => Stop::Cancelled,
        _ => Stop::NotConverged,
    };
    let mut state = Equilibrium::unmeasured(found.at, found.residual, stop, Cost::default());
    let (stiffness, mode) = tracker.check(mechanics, &state.state.amplitudes, &state.fields);
    state.measured(stiffness, mode);
    state
}
