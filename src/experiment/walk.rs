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
use crate::physics::preconditioner::Preconditioner;
use crate::physics::system::{System, Workspace};
use crate::solver::Stop;
use crate::solver::branch::History;
use crate::solver::equilibrium::{Cost, Equilibrium};
use crate::solver::method::Method;
use crate::solver::methods::MethodKind;
use crate::solver::newton::{NewtonEnd, NewtonLimits, solve};
use crate::solver::problem::{Problem, Slides};
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
    system: System,
    preconditioner: Preconditioner,
    slides: Slides,
    method: Box<dyn Method>,
    flat: Option<FlatBranch>,
    /// On a quarter cell: the watch over modes of other symmetry.
    guard: Option<Guard>,
    rng: Pcg64,
    tracker: Tracker,
    ws: Workspace,
    state: Equilibrium,
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
        let well = model.law.at(model.law.equilibrium_gap()).stiffness;
        let constant = well * if system.is_flat() || even { 0.25 } else { 0.04 };
        let preconditioner = Preconditioner::new(&system, constant);
        let slides = slides_on(&model);
        let tracker = |salt: u64| Tracker::new(Pcg64::seed_from_u64(scene.seed ^ salt));
        let guard =
            (reduction == Reduction::Quarter).then(|| Guard::new(System::whole(&system), constant, slides, tracker(0x9a4d)));
        let flat = (system.is_flat() && method.locates()).then(|| FlatBranch::new(model.law, model.grid.length));
        let start = scene.drive.start;
        let state = Equilibrium {
            mean_displacement: start,
            field: vec![0.0; system.dimension()],
            residual: 0.0,
            stress: model.law.at(start).traction,
            energy: model.law.at(start).energy,
            stiffness_min: None,
            soft_mode: Vec::new(),
            stop: Stop::Stable,
            cost: Cost::default(),
        };
        let rng = Pcg64::seed_from_u64(scene.seed);
        let mut walk = Self {
            step: scene.drive.step,
            start,
            preconditioner,
            slides: if even { Slides::Never } else { slides },
            method,
            flat,
            guard,
            tracker: with_coarse(tracker(0x5eed), &system, constant),
            rng,
            ws: system.workspace(),
            history: History::starting(start, state.field.clone()),
            record: StateRecord::placeholder(start),
            state,
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
            system,
            model,
        };
        walk.rest_at_start(cancel);
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
    pub fn standing_on(mut self, state: Equilibrium, record: StateRecord) -> Self {
        self.target = state.mean_displacement;
        self.direction = record.direction;
        self.history = History::starting(state.mean_displacement, state.field.clone());
        (self.state, self.record) = (state, record);
        self
    }

    /// The decided model.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The mechanics.
    pub fn system(&self) -> &System {
        &self.system
    }

    /// The method's name.
    pub fn method_name(&self) -> &'static str {
        self.method.name()
    }

    /// Record of the state it stands on.
    pub fn record(&self) -> &StateRecord {
        &self.record
    }

    /// The state it stands on.
    pub fn state(&self) -> &Equilibrium {
        &self.state
    }

    /// What a method needs to know of the problem.
    pub(super) fn problem(&self) -> Problem<'_> {
        problem(&self.system, &self.preconditioner, self.slides)
    }

    /// What was spent so far.
    pub fn counts(&self) -> Counts {
        let proofs = self.tracker.proof_transforms() + self.guard.as_ref().map_or(0, Guard::proof_transforms);
        Counts { transforms: self.transforms(), proof_transforms: proofs, ..self.counts }
    }

    fn transforms(&self) -> usize {
        self.looked + self.ws.transforms + self.tracker.coarse_transforms() + self.guard.as_ref().map_or(0, Guard::transforms)
    }

    /// Mean displacement now; during a jump, that of the jump.
    pub fn displacement(&self) -> f64 {
        self.jumping.as_ref().map_or(self.state.mean_displacement, |jumping| jumping.release.u0)
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
        let progress = self.work(cancel, observe);
        self.pause_clock();
        progress
    }

    /// Books the time since the step began, or since it was last booked.
    fn pause_clock(&mut self) {
        let now = Instant::now();
        self.worked += now.duration_since(self.step_began);
        self.step_began = now;
    }

    fn work(&mut self, cancel: &Cancel, observe: &mut dyn FnMut(Happening)) -> Progress {
        if let Some(jumping) = self.jumping.take() {
            return self.relax(jumping, cancel, observe);
        }
        let here = self.state.mean_displacement;
        if here == self.target {
            return Progress::Resting;
        }
        if cancel.requested() {
            return Progress::Cancelled;
        }
        let direction = if self.target < here { Direction::Approach } else { Direction::Retraction };
        if direction != self.direction {
            self.direction = direction;
            (self.barrier, self.before, self.short) = (None, None, None);
        }
        match self.flat {
            Some(flat) if self.state.is_uniform() => self.step_flat(flat, cancel, observe),
            _ => self.step_patterned(cancel, observe),
        }
    }

    fn rest_at_start(&mut self, cancel: &Cancel) {
        match self.flat {
            Some(flat) => self.state = flat.state(self.start, self.system.dimension()),
            None => self.solve_here(cancel),
        }
        self.accept(&mut |_| {});
    }

    /// Solves at the present u0 from the present field, and measures what was found.
    fn solve_here(&mut self, cancel: &Cancel) {
        let (u0, z) = (self.state.mean_displacement, self.state.field.clone());
        let limits = NewtonLimits { steps: 40, ..NewtonLimits::of(&self.system) };
        let found = solve(&problem(&self.system, &self.preconditioner, self.slides), z, u0, limits, &mut self.ws, cancel);
        self.state.residual = found.residual;
        (self.state.energy, self.state.stress) = (found.at.energy, found.at.stress);
        self.state.field = found.z;
        self.state.stop = match found.end {
            NewtonEnd::Converged => Stop::Stable,
            NewtonEnd::Cancelled => Stop::Cancelled,
            _ => Stop::NotConverged,
        };
        let (stiffness, mode) =
            self.tracker.check(&self.system, &self.state.field, self.slides, &self.preconditioner, &mut self.ws, cancel);
        self.state.measured(stiffness, mode);
        self.history = History::starting(u0, self.state.field.clone());
    }
}

fn problem<'s>(system: &'s System, preconditioner: &'s Preconditioner, slides: Slides) -> Problem<'s> {
    Problem { system, preconditioner, slides }
}
