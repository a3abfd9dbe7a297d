//! The walk along u0: follow the branch in bounded steps, locate where it ends, release, land on what is stable.
//!
//! A state machine stepped by hand: [`Walk::step`] does one bounded piece of work (one increment, or a slice of a release) and hands
//! out what happened. It works on any scene and is the reference for every faster road.

use super::flat_branch::FlatBranch;
use super::record::{Branch, Cause, JumpRecord, StateRecord};
use super::scene::{Model, Scene, SceneError};
use crate::numerics::cancel::Cancel;
use crate::numerics::vector::{add, norm};
use crate::physics::pattern::{Pattern, classify, contact_area};
use crate::physics::preconditioner::Preconditioner;
use crate::physics::system::{System, Workspace};
use crate::solver::Stop;
use crate::solver::branch::{History, distance};
use crate::solver::equilibrium::{Cost, Equilibrium, Stiffness};
use crate::solver::method::{Lost, Method, MethodKind, Problem};
use crate::solver::newton::{NewtonEnd, NewtonLimits, NewtonState, solve};
use crate::solver::release::{Release, Slice};
use crate::solver::stability::{Tracker, random_smooth};
use ndarray::Array2;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use std::time::Instant;

/// Width, in ranges, to which the end of a branch is bracketed.
const LOCATED: f64 = 1e-4;
/// Root mean square kick along the soft mode, in ranges.
const KICK: f64 = 0.1;
/// Time steps of a release between two pictures.
const SLICE: usize = 6;
/// How often an unstable landing may be kicked on before the walk gives up.
const KICKS: usize = 8;
/// Largest mu_rho at which patterns on flat ground still slide freely over the mesh; beyond it the mesh pins them (Fig. 8).
const SLIDING_MU_RHO: f64 = 0.45;

/// What one step of the walk brought.
#[derive(Clone, Debug)]
pub enum Happening {
    /// A new state on the path.
    State(StateRecord),
    /// The surface is moving at fixed u0; [`Walk::gap`] shows it.
    Moving {
        /// Mean stress at this instant (E*).
        stress: f64,
    },
    /// A jump was completed; the state after it follows.
    Jump(JumpRecord),
}

/// What is left to do.
#[derive(Clone, Debug, PartialEq)]
pub enum Progress {
    /// More steps are needed.
    Working,
    /// At the target.
    Resting,
    /// Interrupted by the cancel token; the last state stands.
    Cancelled,
    /// Cannot go on; the last state stands.
    Stuck(String),
}

/// What was spent so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counts {
    /// Fourier transforms.
    pub transforms: usize,
    /// Iterations of the method.
    pub iterations: usize,
    /// Recorded states with a pattern.
    pub patterned_increments: usize,
}

/// Why a branch cannot be followed beyond `at`.
#[derive(Clone, Debug)]
struct Barrier {
    at: f64,
    cause: Cause,
    /// The negative eigenvalue found there (E* per length), if an equilibrium was.
    stiffness: Option<f64>,
    /// The mode that went soft, if it was seen.
    soft_mode: Vec<f64>,
}

/// A jump under way.
#[derive(Clone, Debug)]
struct Jumping {
    release: Release,
    cause: Cause,
    kicks: usize,
    /// Energy of the state before, carried to the u0 of the jump.
    energy_before: f64,
}

/// A body on its way along u0.
pub struct Walk {
    model: Model,
    step: f64,
    start: f64,
    system: System,
    preconditioner: Preconditioner,
    slides: bool,
    method: Box<dyn Method>,
    flat: Option<FlatBranch>,
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
    jumping: Option<Jumping>,
    target: f64,
    direction: Branch,
    counts: Counts,
    clock: Instant,
    seen: Cost,
}

impl Walk {
    /// A walk at rest at the start of the scene's drive.
    ///
    /// # Errors
    /// The first value of the scene that is not allowed.
    pub fn new(scene: &Scene, method: MethodKind) -> Result<Self, SceneError> {
        let model = scene.model()?;
        let system = System::new(model.grid, model.law, &model.indenter);
        let well = model.law.at(model.law.equilibrium_gap()).stiffness;
        let preconditioner = Preconditioner::new(&system, well * if system.is_flat() { 0.25 } else { 0.04 });
        let method = method.build(scene.seed);
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
            slides: system.is_flat() && model.mu_rho <= SLIDING_MU_RHO,
            method,
            flat,
            tracker: Tracker::new(Pcg64::seed_from_u64(scene.seed ^ 0x5eed)),
            rng,
            ws: system.workspace(),
            history: History::starting(start, state.field.clone()),
            record: StateRecord::placeholder(start),
            state,
            barrier: None,
            bracket: f64::INFINITY,
            halve: false,
            jumping: None,
            target: start,
            direction: Branch::Approach,
            counts: Counts::default(),
            clock: Instant::now(),
            seen: Cost::default(),
            system,
            model,
        };
        walk.rest_at_start();
        Ok(walk)
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

    /// What was spent so far.
    pub fn counts(&self) -> Counts {
        Counts { transforms: self.ws.transforms, ..self.counts }
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

    /// The gap field as it is now, also in the middle of a jump. Shape (ny, nx).
    pub fn gap(&mut self) -> Array2<f64> {
        let spent = self.ws.transforms;
        let (z, u0) = match &self.jumping {
            Some(jumping) => (&jumping.release.z, jumping.release.u0),
            None => (&self.state.field, self.state.mean_displacement),
        };
        self.system.gap(z, u0, &mut self.ws);
        // A picture is no part of the solution's cost.
        self.ws.transforms = spent;
        self.ws.gap.clone()
    }

    /// Does one bounded piece of work.
    pub fn step(&mut self, cancel: &Cancel, observe: &mut dyn FnMut(Happening)) -> Progress {
        if let Some(jumping) = self.jumping.take() {
            return self.relax(jumping, cancel, observe);
        }
        let here = self.state.mean_displacement;
        if here == self.target {
            return Progress::Resting;
        }
        let direction = if self.target < here { Branch::Approach } else { Branch::Retraction };
        if direction != self.direction {
            self.direction = direction;
            self.barrier = None;
        }
        match self.flat {
            Some(flat) if self.state.is_uniform() => self.step_flat(flat, observe),
            _ => self.step_patterned(cancel, observe),
        }
    }

    /// The next u0 on the way: the points start - k x step, the target, or half the way to a known barrier.
    fn next_displacement(&self) -> f64 {
        let here = self.state.mean_displacement;
        if let Some(barrier) = &self.barrier {
            return self.towards(barrier);
        }
        let k = (self.start - here) / self.step;
        match self.direction {
            Branch::Approach => (self.start - ((k + 1e-6).floor() + 1.0) * self.step).max(self.target),
            Branch::Retraction => (self.start - ((k - 1e-6).ceil() - 1.0) * self.step).min(self.target),
        }
    }

    /// The next trial between here and a barrier: close to where the eigenvalue is expected to vanish, by the secant; the middle
    /// where there is no expectation, or it did not help last time.
    fn towards(&self, barrier: &Barrier) -> f64 {
        let here = self.state.mean_displacement;
        let width = barrier.at - here;
        let (Some(a), Some(b)) = (self.state.stiffness_min, barrier.stiffness) else {
            return here + 0.5 * width;
        };
        let share = a.value / (a.value - b);
        let fine = LOCATED * self.model.law.range / width.abs();
        // A hair before the expected zero first, a hair behind it next: two solves close the bracket.
        let trial = if share > 0.5 * fine { share - 0.4 * fine } else { 0.9 * fine };
        if self.halve { here + 0.5 * width } else { here + width * trial.clamp(0.02, 0.98) }
    }

    fn step_flat(&mut self, flat: FlatBranch, observe: &mut dyn FnMut(Happening)) -> Progress {
        let next = self.next_displacement();
        let Some((stable, unstable)) = flat.limit_between(self.state.mean_displacement, next) else {
            self.state = flat.state(next, self.system.dimension());
            self.accept(observe);
            return Progress::Working;
        };
        if stable != self.state.mean_displacement {
            self.state = flat.state(stable, self.system.dimension());
            self.accept(observe);
        }
        let soft = self.random_soft_wave();
        self.release(Barrier { at: unstable, cause: Cause::FlatLimit, stiffness: None, soft_mode: soft }, false)
    }

    /// All first waves of the cell go soft together; the seed mixes them.
    fn random_soft_wave(&mut self) -> Vec<f64> {
        let q1 = self.system.grid().q1();
        let mut z = random_smooth(&self.system, &mut self.rng);
        for (z, e) in z.iter_mut().zip(self.system.elastic()) {
            if 2.0 * e > 1.1 * q1 {
                *z = 0.0;
            }
        }
        let length = norm(&z);
        z.iter_mut().for_each(|z| *z /= length);
        z
    }

    fn step_patterned(&mut self, cancel: &Cancel, observe: &mut dyn FnMut(Happening)) -> Progress {
        let located = LOCATED * self.model.law.range;
        let here = self.state.mean_displacement;
        if let Some(mut barrier) = self.barrier.take_if(|b| (b.at - here).abs() <= located) {
            if barrier.stiffness.is_none() {
                barrier.soft_mode = self.state.soft_mode.clone();
            }
            return self.release(barrier, true);
        }
        let next = self.next_displacement();
        let problem = Problem { system: &self.system, preconditioner: &self.preconditioner, slides: self.slides };
        let locates = self.method.locates();
        let mut barrier = Barrier { at: next, cause: Cause::Fold, stiffness: None, soft_mode: Vec::new() };
        match self.method.follow(&problem, &self.history, &self.state, next, &mut self.ws, cancel) {
            Ok(mut state) => {
                self.counts.iterations += state.cost.iterations;
                let (stiffness, mode) =
                    self.tracker.check(&self.system, &state.field, self.slides, &self.preconditioner, &mut self.ws, cancel);
                if cancel.requested() {
                    return Progress::Cancelled;
                }
                state.measured(stiffness, mode);
                if state.stop != Stop::Unstable || !locates {
                    self.take(state, observe);
                    self.watch_bracket();
                    return Progress::Working;
                }
                barrier.cause = Cause::SymmetryBreaking;
                barrier.stiffness = Some(stiffness.value);
                barrier.soft_mode = state.soft_mode;
            }
            Err(Lost::Cancelled) => return Progress::Cancelled,
            Err(_) if !locates => {
                return Progress::Stuck(format!(
                    "{} left the numbers at u0 = {next:.6}: its time step is beyond the stability limit for this compression",
                    self.method.name()
                ));
            }
            Err(Lost::Unstable | Lost::Gone) => {}
        }
        self.barrier = Some(barrier);
        self.watch_bracket();
        Progress::Working
    }

    fn watch_bracket(&mut self) {
        let width = self.barrier.as_ref().map_or(f64::INFINITY, |b| (b.at - self.state.mean_displacement).abs());
        self.halve = width.is_finite() && width > 0.5 * self.bracket && !self.halve;
        self.bracket = width;
    }

    /// Stands on a new state of the same branch; a method that locates nothing may have jumped on the way.
    fn take(&mut self, state: Equilibrium, observe: &mut dyn FnMut(Happening)) {
        let (before, energy, stress) = (self.record.clone(), self.state.energy, self.state.stress);
        let du = state.mean_displacement - self.state.mean_displacement;
        let work = 0.5 * (stress + state.stress) * du;
        let released = (energy + work - state.energy) / self.model.law.surface_energy;
        self.history.push(state.mean_displacement, state.field.clone());
        self.state = state;
        if self.method.locates() {
            self.preconditioner.refresh(&self.system, &mut self.ws);
        }
        let pattern = self.pattern();
        if !self.method.locates() && pattern != before.pattern {
            observe(Happening::Jump(JumpRecord {
                branch: self.direction,
                mean_displacement: self.state.mean_displacement,
                from: before.pattern,
                to: pattern,
                stress_before: stress,
                stress_after: self.state.stress,
                released_energy: released,
                cause: Cause::PatternChange,
            }));
        }
        self.accept(observe);
    }

    /// Starts the release at a barrier. `choose`: take the side of the soft mode on which the energy falls.
    fn release(&mut self, barrier: Barrier, choose: bool) -> Progress {
        let du = barrier.at - self.state.mean_displacement;
        let energy_before = self.state.energy + self.state.stress * du;
        let z = self.kicked(&self.state.field.clone(), barrier.at, &barrier.soft_mode, choose);
        self.jumping = Some(Jumping { release: Release::new(z, barrier.at), cause: barrier.cause, kicks: 1, energy_before });
        Progress::Working
    }

    /// `z` moved by the kick along `mode`: downhill where the two sides differ, and to a side drawn from the seed where they do not.
    fn kicked(&mut self, z: &[f64], u0: f64, mode: &[f64], choose: bool) -> Vec<f64> {
        let size = KICK * self.model.law.range;
        let random = if self.rng.random::<bool>() { 1.0 } else { -1.0 };
        let mut side = |sign: f64| {
            let mut moved = z.to_vec();
            if !mode.is_empty() {
                add(&mut moved, sign * size, mode);
            }
            let mut g = vec![0.0; moved.len()];
            let energy = self.system.evaluate(&moved, u0, &mut g, &mut self.ws).energy;
            (moved, energy)
        };
        let (one, energy_one) = side(random);
        if !choose {
            return one;
        }
        let (other, energy_other) = side(-random);
        let equal = 1e-7 * self.model.law.surface_energy;
        if energy_other < energy_one - equal || !energy_one.is_finite() { other } else { one }
    }

    fn relax(&mut self, mut jumping: Jumping, cancel: &Cancel, observe: &mut dyn FnMut(Happening)) -> Progress {
        let slice = jumping.release.advance(&self.system, SLICE, &mut self.preconditioner, self.slides, &mut self.ws, cancel);
        let u0 = jumping.release.u0;
        match slice {
            Slice::Moving => {
                let stress = jumping.release.stress;
                self.jumping = Some(jumping);
                observe(Happening::Moving { stress });
                Progress::Working
            }
            Slice::Cancelled => {
                self.jumping = Some(jumping);
                Progress::Cancelled
            }
            Slice::Stuck => Progress::Stuck(format!("the release at u0 = {u0:.6} found no way down")),
            Slice::Settled(settled) => self.settle(jumping, settled, cancel, observe),
        }
    }

    /// Checks the stability of where the release came to rest; lands there, or kicks on.
    fn settle(
        &mut self,
        mut jumping: Jumping,
        settled: NewtonState,
        cancel: &Cancel,
        observe: &mut dyn FnMut(Happening),
    ) -> Progress {
        let u0 = jumping.release.u0;
        let dimension = self.system.dimension();
        let landed = match self.flat {
            Some(flat) if norm(&settled.z) < 1e-4 * self.model.law.range => {
                let mut state = flat.state(u0, dimension);
                if state.stop == Stop::Unstable {
                    state.soft_mode = self.random_soft_wave();
                }
                state
            }
            _ => match self.measure(settled, u0, &jumping, cancel) {
                Some(state) => state,
                None => {
                    self.jumping = Some(jumping);
                    return Progress::Cancelled;
                }
            },
        };
        if landed.stop == Stop::Unstable {
            if jumping.kicks >= KICKS {
                return Progress::Stuck(format!("after the jump at u0 = {u0:.6} every resting place found was unstable"));
            }
            jumping.kicks += 1;
            let z = self.kicked(&landed.field, u0, &landed.soft_mode, true);
            jumping.release = Release::new(z, u0);
            self.jumping = Some(jumping);
            return Progress::Working;
        }
        self.land(jumping, landed, observe)
    }

    /// Centres, polishes and measures a settled pattern; `None` if cancelled.
    fn measure(&mut self, settled: NewtonState, u0: f64, jumping: &Jumping, cancel: &Cancel) -> Option<Equilibrium> {
        let steps = jumping.release.steps;
        let mut settled = settled;
        if self.slides {
            let centred = self.centred(&settled.z);
            let limits = NewtonLimits::default();
            let polished = solve(&self.system, centred, u0, &self.preconditioner, self.slides, limits, &mut self.ws, cancel);
            if polished.end == NewtonEnd::Converged {
                settled = polished;
            }
        }
        let mut gradient = vec![0.0; settled.z.len()];
        self.system.evaluate(&settled.z, u0, &mut gradient, &mut self.ws);
        self.preconditioner.refresh(&self.system, &mut self.ws);
        self.tracker.reset();
        let (stiffness, mode) =
            self.tracker.check(&self.system, &settled.z, self.slides, &self.preconditioner, &mut self.ws, cancel);
        if cancel.requested() {
            return None;
        }
        let mut state = Equilibrium {
            mean_displacement: u0,
            field: settled.z,
            residual: settled.residual,
            stress: settled.at.stress,
            energy: settled.at.energy,
            stiffness_min: None,
            soft_mode: Vec::new(),
            stop: Stop::Stable,
            cost: Cost { iterations: settled.steps + steps, transforms: 0 },
        };
        state.measured(stiffness, mode);
        Some(state)
    }

    /// Moves a pattern by less than half a mesh spacing so that its centre lies on a mesh point. There the mesh's own weak pinning
    /// vanishes by symmetry; elsewhere it would keep the residual from converging.
    fn centred(&self, z: &[f64]) -> Vec<f64> {
        let grid = self.system.grid();
        let shift = |pair: usize| {
            let (re, im) = (z[2 * pair], z[2 * pair + 1]);
            if re.hypot(im) < 1e-3 * norm(z) {
                return 0.0;
            }
            // u_q ~ e^{-i q x0}: the pattern's centre (or anti-centre) is x0.
            let x0 = -im.atan2(re) / grid.q1();
            (x0 / grid.spacing()).round() * grid.spacing() - x0
        };
        let (along_x, along_y) = (grid.ny, 1);
        let dy = if grid.is_line() { 0.0 } else { shift(along_y) };
        self.system.moved(z, shift(along_x), dy)
    }

    fn land(&mut self, jumping: Jumping, landed: Equilibrium, observe: &mut dyn FnMut(Happening)) -> Progress {
        let law = self.model.law;
        let released = (jumping.energy_before - landed.energy) / law.surface_energy;
        let (from, stress_before) = (self.record.pattern, self.state.stress);
        let moved = distance(&landed.field, &self.state.field);
        self.counts.iterations += landed.cost.iterations;
        if released < -1e-7 {
            return Progress::Stuck(format!(
                "the release at u0 = {:.6} would have gained energy ({released:.2e} gamma), which is a failure of the solver",
                landed.mean_displacement
            ));
        }
        self.history = History::starting(landed.mean_displacement, landed.field.clone());
        self.state = landed;
        let to = self.pattern();
        // Newton can fail on a branch that goes on; then the release leads back to it, and nothing has jumped.
        if !(from == to && released < 1e-6 && moved < 0.02 * law.range) {
            observe(Happening::Jump(JumpRecord {
                branch: self.direction,
                mean_displacement: self.state.mean_displacement,
                from,
                to,
                stress_before,
                stress_after: self.state.stress,
                released_energy: released,
                cause: jumping.cause,
            }));
        }
        self.accept(observe);
        Progress::Working
    }

    fn rest_at_start(&mut self) {
        match self.flat {
            Some(flat) => self.state = flat.state(self.start, self.system.dimension()),
            None => {
                let z = self.state.field.clone();
                let limits = NewtonLimits { steps: 40, ..NewtonLimits::default() };
                let cancel = Cancel::default();
                let found = solve(&self.system, z, self.start, &self.preconditioner, self.slides, limits, &mut self.ws, &cancel);
                self.state.residual = found.residual;
                (self.state.energy, self.state.stress) = (found.at.energy, found.at.stress);
                self.state.field = found.z;
                self.state.stop = if found.end == NewtonEnd::Converged { Stop::Stable } else { Stop::NotConverged };
                let (stiffness, mode) =
                    self.tracker.check(&self.system, &self.state.field, self.slides, &self.preconditioner, &mut self.ws, &cancel);
                self.state.measured(stiffness, mode);
                self.history = History::starting(self.start, self.state.field.clone());
            }
        }
        self.accept(&mut |_| {});
    }

    fn pattern(&mut self) -> Pattern {
        if self.state.is_uniform() && self.system.is_flat() {
            return Pattern::Flat;
        }
        let thermal = if self.method.locates() { 0.0 } else { 0.02 * self.model.law.range };
        if self.system.is_flat() && norm(&self.state.field) < thermal {
            return Pattern::Flat;
        }
        classify(self.ws.gap.view(), &self.model.law, self.system.is_flat())
    }

    /// Writes the record of the present state and hands it out. The workspace must hold the state's gap, unless it is uniform.
    fn accept(&mut self, observe: &mut dyn FnMut(Happening)) {
        let law = self.model.law;
        let uniform = self.state.is_uniform() && self.system.is_flat();
        let pattern = self.pattern();
        let contact_area = match uniform {
            true => f64::from(u8::from(self.state.mean_displacement < law.contact_gap())),
            false => contact_area(self.ws.gap.view(), &law),
        };
        if pattern != Pattern::Flat {
            self.counts.patterned_increments += 1;
        }
        let now = Instant::now();
        let stiffness = self.state.stiffness_min.unwrap_or(Stiffness { value: f64::NAN, error: f64::NAN });
        let length = self.model.grid.length;
        self.record = StateRecord {
            branch: self.direction,
            mean_displacement: self.state.mean_displacement,
            stress: self.state.stress,
            stress_over_max: self.state.stress / law.traction_max(),
            contact_area,
            pattern,
            residual: self.state.residual,
            stiffness_min: stiffness.value * length,
            stiffness_error: stiffness.error * length,
            energy: self.state.energy,
            model: if uniform && self.flat.is_some() {
                "flat, closed form"
            } else if self.model.grid.is_line() {
                "line cell"
            } else {
                "whole cell"
            },
            stop: self.state.stop,
            iterations: self.counts.iterations - self.seen.iterations,
            transforms: self.ws.transforms - self.seen.transforms,
            milliseconds: now.duration_since(self.clock).as_secs_f64() * 1e3,
        };
        self.seen = Cost { iterations: self.counts.iterations, transforms: self.ws.transforms };
        self.clock = now;
        observe(Happening::State(self.record.clone()));
    }
}
