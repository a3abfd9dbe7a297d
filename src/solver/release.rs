//! The release after an instability: down the steepest way at fixed u0, until Newton can take over nearby.
//!
//! Inertia would carry a surface through a narrow basin, and Newton's method from afar leaps over it; where it then comes to rest is a
//! matter of luck. Here the velocity always points along the force.

use super::newton::{NewtonEnd, NewtonLimits, NewtonState, descend};
use super::problem::{Problem, Slides};
use crate::numerics::cancel::Cancel;
use crate::numerics::vector::{add, dot, norm, scale};
use crate::physics::preconditioner::Preconditioner;
use crate::physics::system::{System, Workspace};

/// Largest root mean square step of the surface, in ranges: an overshoot into the wall of the law would be the end of it.
const STEP_MAX: f64 = 0.05;
/// Time step in units of the inverse largest frequency (the stability limit is 2).
const TIME_STEP: f64 = 1.2;
/// Steps after which a release is given up: hundreds are normal.
const STEPS_MAX: usize = 20_000;
/// Share of the longest step below which the steepest way creeps, on a saddle or along a valley, and Newton steps go on.
const CREEP: f64 = 0.2;
/// Steps that the steepest way is given before that is asked.
const STEEPEST: usize = 12;
/// Newton steps then, each within a trust region of the longest step, so that they follow the valley.
const DESCENT: usize = 4;
/// Energy, in gamma, that such a descent must release: what slides from between mesh points gives less.
const LEAST_GAIN: f64 = 1e-10;
/// Newton steps of a pattern that is let slide.
const SLIDING: usize = 40;

/// A release under way.
#[derive(Clone, Debug)]
pub struct Release {
    /// Amplitudes of the surface now.
    pub z: Vec<f64>,
    /// Fixed mean displacement.
    pub u0: f64,
    /// Time steps done.
    pub steps: usize,
    /// Mean stress at the last step (E*).
    pub stress: f64,
    previous: Vec<f64>,
    velocity: Vec<f64>,
    gradient: Vec<f64>,
    energy: f64,
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
    Settled(NewtonState),
    /// Not finite from the start, or the step shrank to nothing.
    Stuck,
    /// Somebody asked to stop.
    Cancelled,
}

impl Release {
    /// Starts at rest from amplitudes `z` at mean displacement `u0`.
    pub fn new(z: Vec<f64>, u0: f64) -> Self {
        let n = z.len();
        Self {
            previous: z.clone(),
            z,
            u0,
            steps: 0,
            stress: 0.0,
            velocity: vec![0.0; n],
            gradient: vec![0.0; n],
            energy: f64::INFINITY,
            shrink: 1.0,
            moved: 0.0,
            since_newton: 0,
            patience: STEEPEST,
            limits: NewtonLimits { steps: DESCENT, ..NewtonLimits::default() },
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

    /// Does up to `count` time steps. Inertia is q E*/2 + k (the inverse of `preconditioner`), so that all waves move alike.
    pub fn advance(
        &mut self,
        system: &System,
        count: usize,
        preconditioner: &mut Preconditioner,
        slides: Slides,
        ws: &mut Workspace,
        cancel: &Cancel,
    ) -> Slice {
        for _ in 0..count {
            if cancel.requested() {
                return Slice::Cancelled;
            }
            if self.steps >= STEPS_MAX {
                return Slice::Stuck;
            }
            let mut gradient = std::mem::take(&mut self.gradient);
            let at = system.evaluate(&self.z, self.u0, &mut gradient, ws);
            self.gradient = gradient;
            let force = norm(&self.gradient);
            if !(at.energy <= self.energy + system.precision().rounding().max(1e-9) * system.law().surface_energy)
                || !force.is_finite()
            {
                if !self.undo() {
                    return Slice::Stuck;
                }
                continue;
            }
            (self.energy, self.stress, self.steps) = (at.energy, at.stress, self.steps + 1);
            self.since_newton += 1;
            if self.since_newton >= self.patience && self.moved < CREEP * STEP_MAX * system.law().range {
                preconditioner.refresh(system, ws);
                if let Some(slice) = self.newton(&Problem { system, preconditioner, slides }, ws, cancel) {
                    return slice;
                }
                continue;
            }
            self.step(system, preconditioner, ws);
        }
        Slice::Moving
    }

    /// A few Newton steps where the steepest way creeps; `None` if they do not settle it: then from where they got to.
    ///
    /// What slides is left out at first. Where nothing else is left to gain, and the mesh still pulls, it is let slide.
    fn newton(&mut self, problem: &Problem<'_>, ws: &mut Workspace, cancel: &Cancel) -> Option<Slice> {
        let law = problem.system.law();
        let least = problem.system.precision().rounding().max(LEAST_GAIN) * law.surface_energy;
        let cap = STEP_MAX * law.range;
        self.since_newton = 0;
        let mut state = descend(problem, self.z.clone(), self.u0, cap, self.limits, ws, cancel);
        let stalled = state.end == NewtonEnd::Stalled && !(state.at.energy < self.energy - least);
        if stalled && problem.slides != Slides::Never {
            let (held, limits) = (Problem { slides: Slides::Never, ..*problem }, NewtonLimits { steps: SLIDING, ..self.limits });
            state = descend(&held, state.z, self.u0, cap, limits, ws, cancel);
        }
        match state.end {
            NewtonEnd::Converged => return Some(Slice::Settled(state)),
            NewtonEnd::Cancelled => return Some(Slice::Cancelled),
            _ => {}
        }
        if stalled {
            self.patience *= 2;
        } else {
            self.patience = STEEPEST;
            self.velocity.fill(0.0);
        }
        self.z = state.z;
        None
    }

    fn step(&mut self, system: &System, preconditioner: &Preconditioner, ws: &Workspace) {
        let push: Vec<f64> = self.gradient.iter().zip(preconditioner.diagonal()).map(|(g, m)| -g * m).collect();
        if dot(&self.velocity, &self.gradient) > 0.0 {
            self.velocity.fill(0.0);
        }
        let (speed, length) = (norm(&self.velocity), norm(&push));
        if length > 0.0 {
            self.velocity.copy_from_slice(&push);
            scale(&mut self.velocity, speed / length);
        }
        let inertia = 1.0 / preconditioner.diagonal().iter().cloned().fold(0.0, f64::max);
        let stiffest = ws.stiffness.iter().cloned().fold(0.0, f64::max);
        let dt = self.shrink * TIME_STEP / ((stiffest / inertia).max(1.0)).sqrt();
        add(&mut self.velocity, dt, &push);
        let moved = dt * norm(&self.velocity);
        let cap = STEP_MAX * system.law().range * self.shrink;
        if moved > cap {
            scale(&mut self.velocity, cap / moved);
        }
        self.moved = moved.min(cap);
        self.previous.copy_from_slice(&self.z);
        add(&mut self.z, dt, &self.velocity);
        self.shrink = (self.shrink * 1.02).min(1.0);
    }

    /// Takes the last step back, comes to rest and halves the next step; false when there is nothing left to halve.
    fn undo(&mut self) -> bool {
        if self.steps == 0 || self.shrink < 1e-6 {
            return false;
        }
        self.z.copy_from_slice(&self.previous);
        self.velocity.fill(0.0);
        self.shrink *= 0.5;
        true
    }
}
