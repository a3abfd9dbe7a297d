//! What a relaxation hands back.

use super::Stop;
use crate::physics::system::{Evaluation, Fields, State};

/// What was spent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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
#[derive(Clone, Debug)]
pub struct Equilibrium {
    /// The state.
    pub state: State,
    /// Its gap, traction and stiffness.
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
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stiffness {
    /// A Rayleigh quotient: an upper bound. NaN if it was not found.
    pub value: f64,
    /// Where `value` is positive, how far below it the smallest eigenvalue may lie, but for the
    /// chance stated by [`CHANCE`](super::stability::CHANCE): never as far as zero. Where it is
    /// negative, some eigenvalue lies within this distance.
    pub error: f64,
}

impl Stiffness {
    /// True only if it is known that no eigenvalue is negative.
    pub fn is_stable(&self) -> bool {
        self.value >= 0.0
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
                error: self.error.max(self.value - (all.value - all.error)),
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
        self.state.amplitudes.iter().all(|z| *z == 0.0)
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
