//! The way down from where a state gives way, to what is stable.
//!
//! The **release** after an instability goes down the steepest way at fixed control, until Newton
//! can take over nearby. Inertia would carry a surface through a narrow basin, and Newton's method
//! from afar leaps over it; where it then comes to rest is a matter of luck. Here the velocity
//! always points along the force.
//!
//! The **path of steepest descent** from a saddle is dz/dt = -dV/dz at fixed control, in the metric
//! of the root mean square of the displacement. Each step is the minimum of V + |z - z_k|^2/(2 tau),
//! the implicit Euler step: whatever the stiffness of the shortest waves the energy falls with every
//! step, and long steps near the end are those of Newton's method.

use super::mechanics::{Mechanics, Slides};
use super::method::{Lost, distance};
use super::newton::{NewtonLimits, NewtonState, descend, downhill, solve};
use crate::numerics::dense::{add, dot, norm, scale};
use crate::numerics::krylov::{CgLimits, conjugate_gradients};
use crate::physics::control::Control;
use crate::physics::system::Evaluation;

/// Largest root mean square step of the surface, in ranges: an overshoot into the wall of the law
/// would be the end of it.
const STEP_MAX: f64 = 0.05;
/// Time step in units of the inverse largest frequency (the stability limit is 2).
const TIME_STEP: f64 = 1.2;
/// Steps after which a release is given up: hundreds are normal.
const STEPS_MAX: usize = 20_000;
/// Share of the longest step below which the steepest way creeps, on a saddle or along a valley,
/// and Newton steps go on.
const CREEP: f64 = 0.2;
/// Steps that the steepest way is given before that is asked.
const STEEPEST: usize = 12;
/// Newton steps then, each within a trust region of the longest step, so that they follow the
/// valley.
const DESCENT: usize = 4;
/// Energy, in gamma, that such a descent must release: what slides from between mesh points gives
/// less.
const LEAST_GAIN: f64 = 1e-10;
/// Newton steps of a pattern that is let slide.
const SLIDING: usize = 40;

/// A release under way.
#[derive(Clone, Debug)]
pub struct Release {
    /// The surface now.
    pub at: Evaluation,
    /// Time steps done.
    pub steps: usize,
    /// The surface before the last step, and its energy as that of the lowest yet.
    previous: Evaluation,
    energy: f64,
    velocity: Vec<f64>,
    shrink: f64,
    /// Length of the last step (root mean square), and steps since Newton's method was tried.
    moved: f64,
    since_newton: usize,
    /// How many are given to the steepest way.
    patience: usize,
    limits: NewtonLimits,
}

/// How a slice of the release ended.
#[derive(Clone, Debug)]
pub enum Slice {
    /// Still moving.
    Moving,
    /// At an equilibrium (its stability is not checked yet).
    Settled(Box<NewtonState>),
    /// Not finite from the start, or the step shrank to nothing.
    Stuck,
    /// Somebody asked to stop.
    Cancelled,
}

impl Release {
    /// Starts at rest from a surface, whose control stays.
    pub fn new(at: Evaluation) -> Self {
        Self {
            velocity: vec![0.0; at.gradient.len()],
            previous: at.clone(),
            at,
            steps: 0,
            energy: f64::INFINITY,
            shrink: 1.0,
            moved: 0.0,
            since_newton: 0,
            patience: STEEPEST,
            limits: NewtonLimits {
                steps: DESCENT,
                ..NewtonLimits::default()
            },
        }
    }

    /// The same with another goal for the residual.
    pub fn with_tolerance(mut self, tolerance: f64) -> Self {
        self.limits.tolerance = tolerance;
        self
    }

    /// Goal for the residual.
    pub fn tolerance(&self) -> f64 {
        self.limits.tolerance
    }

    /// Does up to `count` time steps. Inertia is q E*/2 + k (the inverse of the preconditioner), so
    /// that all waves move alike.
    pub fn advance(&mut self, mechanics: &mut Mechanics, count: usize) -> Slice {
        let (law, precision) = (*mechanics.system.law(), mechanics.system.precision());
        for _ in 0..count {
            if mechanics.cancel.requested() {
                return Slice::Cancelled;
            }
            if self.steps >= STEPS_MAX {
                return Slice::Stuck;
            }
            let energy = self.at.state.energy;
            let rounding = precision.rounding() * law.surface_energy.max(energy.abs());
            let rounding = rounding.max(1e-9 * law.surface_energy);
            if !(energy <= self.energy + rounding) || !norm(&self.at.gradient).is_finite() {
                if !self.undo() {
                    return Slice::Stuck;
                }
                continue;
            }
            (self.energy, self.steps) = (self.at.state.energy, self.steps + 1);
            self.since_newton += 1;
            if self.is_free(mechanics) {
                self.at.state.amplitudes.fill(0.0);
                self.velocity.fill(0.0);
                mechanics.update(&mut self.at);
            }
            if self.creeps(mechanics) {
                mechanics.refresh(&self.at.fields);
                if let Some(slice) = self.newton(mechanics) {
                    return slice;
                }
                continue;
            }
            self.step(mechanics);
        }
        Slice::Moving
    }

    /// A few Newton steps where the steepest way creeps; `None` if they do not settle it: then from
    /// where they got to.
    ///
    /// What slides is left out at first. Where nothing else is left to gain, and the mesh still
    /// pulls, it is let slide.
    fn newton(&mut self, mechanics: &mut Mechanics) -> Option<Slice> {
        let (law, control, slides) = (
            *mechanics.system.law(),
            self.at.state.control,
            mechanics.slides,
        );
        let least = mechanics.system.precision().rounding().max(LEAST_GAIN) * law.surface_energy;
        let cap = STEP_MAX * law.range;
        self.since_newton = 0;
        let mut state = descend(
            mechanics,
            self.at.state.amplitudes.clone(),
            control,
            cap,
            self.limits,
        );
        let stalled =
            state.end == Err(Lost::Gone) && !(state.at.state.energy < self.energy - least);
        if stalled && slides != Slides::Never {
            mechanics.slides = Slides::Never;
            let limits = NewtonLimits {
                steps: SLIDING,
                ..self.limits
            };
            state = descend(mechanics, state.at.state.amplitudes, control, cap, limits);
            mechanics.slides = slides;
        }
        match state.end {
            Ok(()) => return Some(Slice::Settled(Box::new(state))),
            Err(Lost::Cancelled) => return Some(Slice::Cancelled),
            _ => {}
        }
        if stalled {
            self.patience *= 2;
        } else {
            self.patience = STEEPEST;
            self.velocity.fill(0.0);
        }
        self.at = state.at;
        None
    }

    /// True if a spring has pulled the body off to where the ground is not felt, and pulls it still
    /// on to its stage, which may be far.
    fn is_free(&self, mechanics: &Mechanics) -> bool {
        let system = &mechanics.system;
        let gap = self.at.fields.gap.iter().copied();
        matches!(system.control(), Control::Spring { .. })
            && self.at.state.amplitudes[0] < 0.0
            && gap.fold(f64::INFINITY, f64::min) > Control::unfelt(system.law())
    }

    /// Whether the steepest way is slow, or from rest would still be after its steps.
    fn creeps(&self, mechanics: &Mechanics) -> bool {
        let slow = CREEP * STEP_MAX * mechanics.system.law().range;
        if self.since_newton >= self.patience {
            return self.moved < slow;
        }
        if self.patience > STEEPEST || self.velocity.iter().any(|v| *v != 0.0) {
            return false;
        }
        let (push, dt) = self.push(mechanics);
        STEEPEST as f64 * dt * dt * norm(&push) < slow
    }

    /// The acceleration, and the time step.
    fn push(&self, mechanics: &Mechanics) -> (Vec<f64>, f64) {
        let softness = mechanics.preconditioner.diagonal();
        let push = self.at.gradient.iter().zip(softness).map(|(g, m)| -g * m);
        let inertia = 1.0 / softness.iter().cloned().fold(0.0, f64::max);
        let stiffest = self.at.fields.stiffness.iter().cloned().fold(0.0, f64::max);
        let dt = self.shrink * TIME_STEP / ((stiffest / inertia).max(1.0)).sqrt();
        (push.collect(), dt)
    }

    fn step(&mut self, mechanics: &mut Mechanics) {
        let (push, dt) = self.push(mechanics);
        if dot(&self.velocity, &self.at.gradient) > 0.0 {
            self.velocity.fill(0.0);
        }
        let (speed, length) = (norm(&self.velocity), norm(&push));
        if length > 0.0 {
            self.velocity.copy_from_slice(&push);
            scale(&mut self.velocity, speed / length);
        }
        add(&mut self.velocity, dt, &push);
        let moved = dt * norm(&self.velocity);
        let cap = STEP_MAX * mechanics.system.law().range * self.shrink;
        if moved > cap {
            scale(&mut self.velocity, cap / moved);
        }
        self.moved = moved.min(cap);
        std::mem::swap(&mut self.previous, &mut self.at);
        self.at
            .state
            .amplitudes
            .copy_from_slice(&self.previous.state.amplitudes);
        add(&mut self.at.state.amplitudes, dt, &self.velocity);
        mechanics.update(&mut self.at);
        self.shrink = (self.shrink * 1.02).min(1.0);
    }

    /// Takes the last step back, comes to rest and halves the next step; false when there is
    /// nothing left to halve.
    fn undo(&mut self) -> bool {
        if self.steps == 0 || self.shrink < 1e-6 {
            return false;
        }
        self.at.clone_from(&self.previous);
        self.velocity.fill(0.0);
        self.shrink *= 0.5;
        true
    }
}

/// First step off the saddle along its mode (ranges): there the path is that mode up to the square
/// of it. It is cut by four until the energy falls, where the saddle is about to vanish.
const OFF: f64 = 1e-3;
const SHORTER: f64 = 0.25;
const OFF_CUTS: usize = 8;
/// Growth of the steps, and the longest (ranges): an implicit Euler step of length h errs by less
/// than h^2 over the path's radius of curvature.
const GROWTH: f64 = 1.3;
const LONGEST: f64 = 0.05;
/// Most steps: a path of a hundred ranges, longer than any well is deep.
const PLACES: usize = 4000;
/// Newton iterations of one step, its products, and the share of the force it may miss.
const ITERATIONS: usize = 6;
const PRODUCTS: usize = 40;
const MISSED: f64 = 1e-2;
/// Share of the step asked for below which a minimum is near, and Newton's method may finish within
/// a few such steps.
const NEAR: f64 = 0.6;
const WITHIN: f64 = 3.0;

/// Goes down from the saddle along its `mode` (norm 1, the way it points) to the minimum, or to the
/// saddle of another symmetry, where that leads. `observe` hears of every place with its arc length
/// from the saddle (length), the end included, and says whether to go on.
///
/// # Errors
/// No end was found within a hundred ranges, the energy does not fall along the mode, or somebody
/// asked to stop.
pub fn steepest_descent(
    mechanics: &mut Mechanics,
    saddle: &Evaluation,
    mode: &[f64],
    observe: &mut dyn FnMut(&Evaluation, f64) -> bool,
) -> Result<Evaluation, Lost> {
    let range = mechanics.system.law().range;
    let mut step = OFF * range;
    let mut at = off(mechanics, saddle, mode, &mut step)?;
    let mut arc = step;
    let mut goes_on = observe(&at, arc);
    for _ in 0..PLACES {
        if !goes_on {
            return Ok(at);
        }
        if mechanics.cancel.requested() {
            return Err(Lost::Cancelled);
        }
        mechanics.refresh(&at.fields);
        let rate = norm(&at.gradient) / step;
        let Some(next) = implicit(mechanics, &at, rate) else {
            step *= SHORTER;
            if step < f64::EPSILON * range {
                return Err(Lost::Gone);
            }
            continue;
        };
        let moved = distance(&next.state.amplitudes, &at.state.amplitudes);
        at = next;
        arc += moved;
        goes_on = observe(&at, arc);
        if moved < NEAR * step
            && let Some(end) = settled(mechanics, &at, WITHIN * step)?
        {
            arc += distance(&end.state.amplitudes, &at.state.amplitudes);
            observe(&end, arc);
            return Ok(end);
        }
        step = (GROWTH * step).min(LONGEST * range);
    }
    Err(Lost::Gone)
}

/// The first place off the saddle, `step` away, which is cut until the energy falls.
fn off(
    mechanics: &mut Mechanics,
    saddle: &Evaluation,
    mode: &[f64],
    step: &mut f64,
) -> Result<Evaluation, Lost> {
    let mut at = saddle.clone();
    for _ in 0..OFF_CUTS {
        at.state
            .amplitudes
            .copy_from_slice(&saddle.state.amplitudes);
        add(&mut at.state.amplitudes, *step, mode);
        mechanics.update(&mut at);
        if at.state.energy < saddle.state.energy {
            return Ok(at);
        }
        *step *= SHORTER;
    }
    Err(Lost::Gone)
}

/// The minimum of V + rate |z - z_k|^2/2 next to z_k, if Newton's method finds one below it.
fn implicit(mechanics: &mut Mechanics, from: &Evaluation, rate: f64) -> Option<Evaluation> {
    let goal = MISSED * norm(&from.gradient);
    let mut at = from.clone();
    for _ in 0..ITERATIONS {
        let mut force = at.gradient.clone();
        add(&mut force, rate, &at.state.amplitudes);
        add(&mut force, -rate, &from.state.amplitudes);
        if norm(&force) <= goal {
            return (at.state.energy < from.state.energy).then_some(at);
        }
        let Mechanics {
            system,
            preconditioner,
            workspace,
            cancel,
            ..
        } = &mut *mechanics;
        let apply = |v: &[f64], out: &mut [f64]| {
            system.hessian(&at.fields, v, out, workspace);
            add(out, rate, v);
        };
        let softness = preconditioner.diagonal();
        let precondition = |r: &[f64], out: &mut [f64]| {
            for ((out, r), m) in out.iter_mut().zip(r).zip(softness) {
                *out = r * m / (1.0 + rate * m);
            }
        };
        let limits = CgLimits::new(MISSED, PRODUCTS);
        let found = conjugate_gradients(apply, &force, precondition, &[], limits, cancel);
        downhill(found.end).ok()?;
        add(&mut at.state.amplitudes, -1.0, &found.x);
        mechanics.update(&mut at);
    }
    None
}

/// The equilibrium that Newton's method finds no further away than `within` and no higher.
fn settled(
    mechanics: &mut Mechanics,
    at: &Evaluation,
    within: f64,
) -> Result<Option<Evaluation>, Lost> {
    let state = &at.state;
    let limits = NewtonLimits::of(&mechanics.system);
    let found = solve(mechanics, state.amplitudes.clone(), state.control, limits);
    let rounding = mechanics.system.precision().rounding() * mechanics.system.law().surface_energy;
    let near = distance(&found.at.state.amplitudes, &state.amplitudes) < within
        && found.at.state.energy <= state.energy + rounding;
    match found.end {
        Err(Lost::Cancelled) => Err(Lost::Cancelled),
        Ok(()) if near => Ok(Some(found.at)),
        _ => Ok(None),
    }
}
