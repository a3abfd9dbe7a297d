//! The release after an instability: down the steepest way at fixed control, until Newton can take
//! over nearby.
//!
//! Inertia would carry a surface through a narrow basin, and Newton's method from afar leaps over
//! it; where it then comes to rest is a matter of luck. Here the velocity always points along the
//! force.

use super::mechanics::{Mechanics, Slides};
use super::newton::{NewtonEnd, NewtonLimits, NewtonState, descend};
use crate::numerics::dense::{add, dot, norm, scale};
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
            state.end == NewtonEnd::Stalled && !(state.at.state.energy < self.energy - least);
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
            NewtonEnd::Converged => return Some(Slice::Settled(Box::new(state))),
            NewtonEnd::Cancelled => return Some(Slice::Cancelled),
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
            && gap.fold(f64::INFINITY, f64::min) > Control::stop(system.law())
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
