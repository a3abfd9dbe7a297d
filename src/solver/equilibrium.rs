//! What a relaxation hands back, and why it stopped.

use crate::physics::system::{Evaluation, Fields, State};
use serde::{Deserialize, Serialize};
use std::fmt;

/// What was spent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Cost {
    /// Iterations of the method: Newton steps or time steps.
    pub iterations: usize,
    /// Fourier transforms.
    pub transforms: usize,
}

impl std::ops::AddAssign for Cost {
    fn add_assign(&mut self, other: Self) {
        self.iterations += other.iterations;
        self.transforms += other.transforms;
    }
}

/// A state with the evidence for it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Equilibrium {
    /// The state.
    pub state: State,
    /// Its gap, traction and stiffness; left out of a file, since they follow from the state.
    #[serde(skip)]
    pub fields: Fields,
    /// max |residual traction| / max(sigma_max, max |traction|).
    pub residual: f64,
    /// Smallest Hessian eigenvalue, sliding modes removed (E* per length); `None` while not
    /// measured.
    pub stiffness_min: Option<Stiffness>,
    /// The mode that belongs to it, normalised to mean(v^2) = 1; empty while not measured.
    pub soft_mode: Vec<f64>,
    /// Why the method stopped.
    pub stop: Stop,
    /// What it cost.
    pub cost: Cost,
}

/// The smallest eigenvalue, from above and from below.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stiffness {
    /// A Rayleigh quotient: an upper bound. NaN if it was not found.
    pub value: f64,
    /// Where `value` is positive, how far below it the smallest eigenvalue may lie, but for the
    /// chance stated by [`CHANCE`](super::stability::CHANCE): never below zero. Where it is
    /// negative, some eigenvalue lies within this distance.
    pub error: f64,
}

impl Stiffness {
    /// True only if it is known that every eigenvalue is positive: where one is zero nothing holds
    /// its mode.
    pub fn is_stable(&self) -> bool {
        self.value > 0.0
    }

    /// The smallest eigenvalue among `all` modes, of which these are some.
    pub fn among(self, all: Self) -> Self {
        match all.value < self.value {
            _ if !self.is_stable() => self,
            // Not known among all is not known.
            _ if all.value.is_nan() => all,
            true => all,
            // Seen more closely among some, and bounded among all.
            false => Self {
                value: self.value,
                error: (self.value - (all.value - all.error)).max(0.0),
            },
        }
    }
}

impl Equilibrium {
    /// A state whose stability is not measured yet.
    pub fn unmeasured(at: Evaluation, residual: f64, stop: Stop, cost: Cost) -> Self {
        let Evaluation { state, fields, .. } = at;
        Self {
            state,
            fields,
            residual,
            stiffness_min: None,
            soft_mode: Vec::new(),
            stop,
            cost,
        }
    }

    /// True if the surface is uniform to the last bit.
    pub fn is_uniform(&self) -> bool {
        self.state.amplitudes[1..].iter().all(|z| *z == 0.0)
    }

    /// Enters the measured stability; a state within tolerance is then known to be stable or not,
    /// or is refused.
    pub fn measured(&mut self, stiffness: Stiffness, soft_mode: Vec<f64>) {
        if matches!(self.stop, Stop::Stable | Stop::Unstable) {
            self.stop = match stiffness.value {
                value if value.is_nan() => Stop::NotConverged,
                _ if stiffness.is_stable() => Stop::Stable,
                _ => Stop::Unstable,
            };
        }
        self.stiffness_min = Some(stiffness);
        self.soft_mode = soft_mode;
    }
}

/// The honest end of a relaxation; every shown state carries one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Stop {
    /// Residual below tolerance and every eigenvalue positive.
    Stable,
    /// Residual below tolerance, but the smallest eigenvalue is not positive.
    Unstable,
    /// Budget spent with the residual above tolerance.
    NotConverged,
    /// Read off between states that were solved and are stable; not solved itself, and so without a
    /// residual.
    ReadOff,
    /// Somebody asked to stop.
    Cancelled,
}

impl fmt::Display for Stop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Stop::Stable => "converged, stable",
            Stop::Unstable => "converged, unstable",
            Stop::NotConverged => "not converged",
            Stop::ReadOff => "read off a stable branch",
            Stop::Cancelled => "cancelled",
        })
    }
}

/// Why a branch was not followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lost {
    /// No equilibrium near the prediction.
    Gone,
    /// Negative curvature on the way.
    Unstable,
    /// The numbers stopped being finite; why, in words.
    Diverged(&'static str),
    /// Somebody asked to stop.
    Cancelled,
}
