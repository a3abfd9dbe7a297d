//! The walk along what is driven: follow the branch in bounded steps, locate where it ends,
//! release, land on what is stable.
//!
//! A state machine stepped by hand: [`Walk::step`] does one bounded piece of work (one increment,
//! or a slice of a release) and hands out what happened. It works on any scene and is the reference
//! for everything faster.

use super::atlas::Fall;
use super::flat_branch::FlatBranch;
use super::record::{Cause, Direction, StateRecord};
use crate::numerics::dense::{dot, scale};
use crate::numerics::precision::Precision;
use crate::numerics::threads::Cancel;
use crate::physics::control::Control;
use crate::physics::parameter::Refusal;
use crate::physics::system::{State, System};
use crate::scene::{Model, Part, Scene};
use crate::solver::mechanics::{Mechanics, Slides, centred};
use crate::solver::method::{Cost, Equilibrium, History, Lost, Method, Stop};
use crate::solver::methods::MethodKind;
use crate::solver::newton::{NewtonLimits, solve};
use crate::solver::release::Release;
use crate::solver::stability::Tracker;
use flat::apart;
use ndarray::Array2;
use rand::SeedableRng;
use rand_pcg::Pcg64;
use std::time::{Duration, Instant};
use symmetry::{Guard, slides_on, with_coarse};

mod advance;
pub(super) mod flat;
mod landing;
mod record;
pub(super) mod symmetry;

pub use landing::Push;
pub use record::{Counts, Observed, Progress, Stuck};
pub use symmetry::Widened;

/// Why a branch cannot be followed beyond `at`.
#[derive(Clone, Debug)]
struct Barrier {
    at: f64,
    /// The negative eigenvalue found there (E* per length), if an equilibrium was.
    stiffness: Option<f64>,
    /// The mode that went soft, if it was seen.
    soft_mode: Vec<f64>,
}

impl Barrier {
    /// Where no equilibrium was found.
    fn blind(at: f64, soft_mode: Vec<f64>) -> Self {
        Self {
            at,
            stiffness: None,
            soft_mode,
        }
    }
}

/// What tells how a branch goes on: control, smallest eigenvalue, and derivative of the energy with
/// the control, of its last state but one.
#[derive(Clone, Copy, Debug)]
struct Before {
    at: f64,
    stiffness: f64,
    conjugate: f64,
}

/// How a branch is followed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WalkOptions {
    /// By which method.
    pub method: MethodKind,
    /// On which part of the cell.
    pub part: Part,
    /// With which numbers.
    pub precision: Precision,
    /// For a mesh that traps the edge of a contact: jumps of a few points are gone downhill, and
    /// located within so many ranges. `None` brackets every jump.
    pub trapped_within: Option<f64>,
}

impl From<MethodKind> for WalkOptions {
    /// This method on the whole cell.
    fn from(method: MethodKind) -> Self {
        Self {
            method,
            ..Self::default()
        }
    }
}

/// Where a walk stands between two steps.
enum Phase {
    /// On a branch whose end is not in sight.
    Following,
    /// On a branch that ends before a barrier.
    Bracketing(Bracket),
    /// Off a branch: the surface moves at fixed control.
    Jumping(Box<Jumping>),
}

/// The end of a branch lies between the present state and a barrier.
struct Bracket {
    barrier: Barrier,
    /// Its width (length).
    width: f64,
    /// True if the next trial must be the middle, because the last one did not halve it.
    halve: bool,
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
    /// Energy of the state before, carried to the control of the jump.
    energy_before: f64,
    /// Where at the latest its branch has come to an end.
    latest: f64,
    /// Where kicks lead from a limit of the flat state.
    landings: Vec<Fall>,
}

/// The branch as far as it was followed.
struct Behind {
    history: History,
    /// The state before, if it is of the same branch.
    before: Option<Before>,
    /// The step that went well after a longer one had failed; it grows again.
    short: Option<f64>,
}

impl Behind {
    fn starting(here: &Equilibrium) -> Self {
        Self {
            history: History::starting(&here.state),
            before: None,
            short: None,
        }
    }
}

/// What a walk spent, and how much of it is in its records.
struct Spent {
    counts: Counts,
    /// Transforms spent on looking where a surface may land.
    looked: usize,
    recorded: Cost,
    /// Work on the next record so far, not counting the time between steps.
    worked: Duration,
    since: Instant,
}

/// A body on its way along its control.
pub struct Walk {
    model: Model,
    options: WalkOptions,
    step: f64,
    start: f64,
    mechanics: Mechanics,
    method: Box<dyn Method>,
    flat: Option<FlatBranch>,
    /// On a part of the cell: the watch over modes of other symmetry.
    guard: Option<Guard>,
    rng: Pcg64,
    tracker: Tracker,
    /// Where it stands.
    here: Equilibrium,
    record: StateRecord,
    behind: Behind,
    phase: Phase,
    /// The soft mode last shown, for the sign of the next.
    facing: Vec<f64>,
    target: f64,
    direction: Direction,
    spent: Spent,
}

impl Walk {
    /// A walk at rest at the start of the scene's drive. Where `cancel` ends the search for the
    /// first state the walk stands on none.
    ///
    /// # Errors
    /// The first value of the scene that is not allowed.
    pub fn start(scene: &Scene, options: WalkOptions, cancel: &Cancel) -> Result<Self, Refusal> {
        Self::start_by(options.method.build(scene.seed), scene, options, cancel)
    }

    /// The same by a method that is not in the list.
    ///
    /// # Errors
    /// The first value of the scene that is not allowed.
    pub fn start_by(
        method: Box<dyn Method>,
        scene: &Scene,
        options: WalkOptions,
        cancel: &Cancel,
    ) -> Result<Self, Refusal> {
        let (model, part) = (scene.model()?, options.part);
        if part.is_even() && !model.grid.nx.is_multiple_of(4) {
            return Err(Refusal::new(
                "cell.points",
                model.grid.nx,
                "a multiple of 4 for a quarter of the cell",
            ));
        }
        if part.is_even() && !model.indenter.ground().is_even() {
            return Err(Refusal::new(
                "indenter.kind",
                "\"rough\"",
                "even ground for a quarter of the cell; rough ground needs the whole",
            ));
        }
        let control = scene.control();
        let make = if part.is_even() {
            System::even
        } else {
            System::new
        };
        let system = make(model.grid, model.law, &model.indenter)
            .with_precision(options.precision)
            .with_body(model.body)
            .with_control(control);
        let slides = slides_on(&model);
        let watched = part.is_even() && part != Part::Mirrored;
        let guard = watched.then(|| Guard::new(&system, slides, scene.seed ^ 0x9a4d));
        let mut mechanics = Mechanics::new(
            system,
            if part.is_even() {
                Slides::Never
            } else {
                slides
            },
        );
        mechanics.cancel = cancel.clone();
        let flat = (mechanics.system.is_flat() && method.locates())
            .then(|| FlatBranch::new(model.law, model.equivalent_length, control));
        let tracker = Tracker::new(Pcg64::seed_from_u64(scene.seed ^ 0x5eed));
        let mut tracker = with_coarse(tracker, &mechanics);
        let start = scene.drive.start;
        let here = match flat {
            _ if control == Control::Load => apart(&mut mechanics, start),
            Some(flat) => flat.first(&mechanics.system, start),
            None => {
                let uniform = vec![0.0; mechanics.system.dimension()];
                solved(&mut mechanics, &mut tracker, uniform, start)
            }
        };
        let mut walk = Self {
            options,
            step: scene.drive.step,
            start,
            mechanics,
            method,
            flat,
            guard,
            tracker,
            rng: Pcg64::seed_from_u64(scene.seed),
            behind: Behind::starting(&here),
            record: StateRecord::placeholder(start),
            here,
            phase: Phase::Following,
            facing: Vec::new(),
            target: start,
            direction: Direction::Approach,
            spent: Spent {
                counts: Counts::default(),
                looked: 0,
                recorded: Cost::default(),
                worked: Duration::ZERO,
                since: Instant::now(),
            },
            model,
        };
        walk.accept(&mut |_| {});
        Ok(walk)
    }

    /// The same walk on another state of its scene, on which an earlier walk on the same part of
    /// the cell stood.
    pub fn standing_on(mut self, mut state: Equilibrium, record: StateRecord) -> Self {
        let State {
            control,
            amplitudes,
            ..
        } = state.state.clone();
        // It may come from another mesh, or have been moved.
        state.fields = self
            .mechanics
            .uncounted(|mechanics| mechanics.at(amplitudes, control))
            .fields;
        self.target = control;
        self.direction = record.direction;
        self.behind.history = History::starting(&state.state);
        (self.here, self.record) = (state, record);
        self
    }

    /// The same walk on the equilibrium at `control` to which Newton's method comes from the
    /// amplitudes `z`, as on a drive in this direction; measured and recorded.
    ///
    /// # Errors
    /// There is none nearby, or it is not stable over all modes of the cell.
    pub fn standing_near(
        mut self,
        z: Vec<f64>,
        control: f64,
        direction: Direction,
    ) -> Result<Self, Lost> {
        (self.direction, self.target) = (direction, control);
        let system = self.system();
        let limits = NewtonLimits::of(system);
        // Where the mesh does not pull at a pattern.
        let z = match self.mechanics.slides {
            Slides::Never => z,
            _ => centred(system, &z, [false; 2]),
        };
        let found = solve(&mut self.mechanics, z, control, limits).converged()?;
        let uniform = found.at.state.amplitudes[1..].iter().all(|z| *z == 0.0);
        self.here = match self.flat.filter(|_| uniform) {
            Some(flat) => {
                let u0 = found.at.state.mean_displacement;
                flat.state_at(self.system(), u0, control)
            }
            None => self.measure(found, 0).map_err(|stuck| match stuck {
                Progress::Cancelled => Lost::Cancelled,
                _ => Lost::Unstable,
            })?,
        };
        if self.here.stop != Stop::Stable {
            return Err(Lost::Unstable);
        }
        self.behind.history = History::starting(&self.here.state);
        self.accept(&mut |_| {});
        Ok(self)
    }

    /// The decided model.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Law, ground and cell.
    pub fn system(&self) -> &System {
        &self.mechanics.system
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
    pub(crate) fn mechanics(&self) -> &Mechanics {
        &self.mechanics
    }

    /// What was spent so far.
    pub fn counts(&self) -> Counts {
        let proofs = self.tracker.proof_transforms()
            + self.guard.as_ref().map_or(0, Guard::proof_transforms);
        Counts {
            transforms: self.transforms(),
            proof_transforms: proofs,
            coarse_transforms: self.tracker.coarse_transforms(),
            ..self.spent.counts
        }
    }

    fn transforms(&self) -> usize {
        self.spent.looked
            + self.mechanics.transforms()
            + self.tracker.coarse_transforms()
            + self.guard.as_ref().map_or(0, Guard::transforms)
    }

    /// The surface now, also in the middle of a jump.
    pub fn surface(&self) -> &State {
        match &self.phase {
            Phase::Jumping(jumping) => &jumping.release.at.state,
            _ => &self.here.state,
        }
    }

    /// What is driven.
    pub fn control(&self) -> Control {
        self.system().control()
    }

    /// True if the surface moves.
    pub fn is_jumping(&self) -> bool {
        matches!(self.phase, Phase::Jumping(_))
    }

    /// [`Control::unit`] of the law.
    fn unit(&self) -> f64 {
        self.control().unit(&self.model.law)
    }

    /// How much energy per area a `residual` leaves open along a mode of this stiffness (E* times
    /// length).
    fn energy_open(&self, residual: f64, stiffness: f64) -> f64 {
        (residual * self.model.law.traction_max()).powi(2) / stiffness
    }

    /// The same, in gamma, of a `state` along its softest mode.
    fn left_open(&self, state: &Equilibrium) -> f64 {
        let softest = state.stiffness_min.map_or(f64::INFINITY, |s| s.value);
        self.energy_open(state.residual, softest) / self.model.law.surface_energy
    }

    /// The derivative of the energy of a `state` with the control.
    fn conjugate(&self, state: &State) -> f64 {
        self.control()
            .conjugate(state.mean_displacement, state.stress)
    }

    /// Sets the value of the control to go to; the path already gone is kept, and a jump under way
    /// is completed first.
    pub fn set_target(&mut self, control: f64) {
        self.target = control;
    }

    /// Does one bounded piece of work.
    pub fn step(&mut self, cancel: &Cancel, observe: &mut dyn FnMut(Observed)) -> Progress {
        self.spent.since = Instant::now();
        self.mechanics.cancel = cancel.clone();
        let progress = self.work(observe);
        self.pause_clock();
        progress
    }

    /// Books the time since the step began, or since it was last booked.
    fn pause_clock(&mut self) {
        let now = Instant::now();
        self.spent.worked += now.duration_since(self.spent.since);
        self.spent.since = now;
    }

    fn work(&mut self, observe: &mut dyn FnMut(Observed)) -> Progress {
        self.phase = match std::mem::replace(&mut self.phase, Phase::Following) {
            Phase::Jumping(jumping) => return self.relax(jumping, observe),
            phase => phase,
        };
        let here = self.here.state.control;
        if here == self.target {
            return Progress::Resting;
        }
        if self.cancelled() {
            return Progress::Cancelled;
        }
        let direction = if self.target < here {
            Direction::Approach
        } else {
            Direction::Retraction
        };
        if direction != self.direction {
            self.direction = direction;
            self.phase = Phase::Following;
            (self.behind.before, self.behind.short) = (None, None);
        }
        match self.flat {
            _ if self.is_apart(self.here.state.mean_displacement) => self.step_apart(observe),
            Some(flat) if self.here.is_uniform() => self.step_flat(flat, observe),
            _ => self.step_patterned(observe),
        }
    }

    /// True once somebody asked to stop.
    fn cancelled(&self) -> bool {
        self.mechanics.cancel.requested()
    }
}

/// The equilibrium at this control that Newton's method finds from the amplitudes `z`, measured, or
/// as far as it came.
fn solved(
    mechanics: &mut Mechanics,
    tracker: &mut Tracker,
    z: Vec<f64>,
    control: f64,
) -> Equilibrium {
    let limits = NewtonLimits {
        steps: 40,
        ..NewtonLimits::of(&mechanics.system)
    };
    let found = solve(mechanics, z, control, limits);
    let stop = match found.end {
        Ok(()) => Stop::Stable,
        Err(Lost::Cancelled) => Stop::Cancelled,
        Err(_) => Stop::NotConverged,
    };
    let mut state = Equilibrium::unmeasured(found.at, found.residual, stop, Cost::default());
    let (stiffness, mode) = tracker.check(mechanics, &state.state.amplitudes, &state.fields);
    state.measured(stiffness, mode);
    state
}

/// The field of the mode of smallest stiffness in a state of which the displacement (length) is
/// known over the whole cell, mean(phi^2) = 1: of several that are equal one. `None` where it was
/// not found, or somebody asked to stop.
pub fn soft_mode(
    (model, driven): (&Model, Control),
    record: &StateRecord,
    displacement: &Array2<f64>,
    cancel: &Cancel,
) -> Option<Array2<f64>> {
    let system = System::new(model.grid, model.law, &model.indenter).with_body(model.body);
    let mut mechanics = Mechanics::new(system.with_control(driven), slides_on(model));
    mechanics.cancel = cancel.clone();
    let [control, mean] = driven.balanced(record.mean_displacement, record.stress);
    let mut z = mechanics.amplitudes(displacement);
    z[0] = mean;
    let at = mechanics.at(z, control);
    mechanics.refresh(&at.fields);
    let mut tracker = with_coarse(Tracker::new(Pcg64::seed_from_u64(0)), &mechanics);
    let (stiffness, mode) = tracker.check(&mut mechanics, &at.state.amplitudes, &at.fields);
    (!stiffness.value.is_nan()).then(|| mechanics.field(&mode).clone())
}

impl Walk {
    /// The gap field as it is now, also in the middle of a jump. Shape (ny, nx).
    pub fn gap(&self) -> Array2<f64> {
        let fields = match &self.phase {
            Phase::Jumping(jumping) => &jumping.release.at.fields,
            _ => &self.here.fields,
        };
        self.system().unfolded(&fields.gap)
    }

    /// The gap field of the state it stands on, which a jump under way has left.
    pub fn gap_here(&self) -> Array2<f64> {
        self.system().unfolded(&self.here.fields.gap)
    }

    /// The field of the mode that gives way first in the state it stands on, mean(phi^2) = 1: that
    /// of the smallest eigenvalue, or of the flat state one of its equal softest waves; with the sign
    /// of the last one asked for, so that pictures do not flicker. `None` where it was not measured.
    /// One transform.
    pub fn soft_mode(&mut self) -> Option<Array2<f64>> {
        let mut mode = self.here.soft_mode.clone();
        if self.here.is_uniform() && self.system().is_flat() {
            mode = self.system().softest_wave();
        }
        if mode.len() == self.facing.len() && dot(&mode, &self.facing) < 0.0 {
            scale(&mut mode, -1.0);
        }
        self.facing.clone_from(&mode);
        if mode.is_empty() {
            return None;
        }
        let field = self.mechanics.uncounted(|m| m.field(&mode).clone());
        Some(self.system().unfolded(&field))
    }
}
