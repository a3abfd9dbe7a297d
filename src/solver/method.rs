//! The one interface behind which every relaxation method stands: the branch that it is given, what
//! it hands back, and how what continues the branch is told from what does not.

use super::mechanics::{Mechanics, held};
use crate::numerics::dense::{add, norm};
use crate::physics::control::Control;
use crate::physics::system::{Evaluation, Fields, State, System};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Carries a state from one value of the control to a near one.
pub trait Method: Send {
    /// Its name on the screen and in the tables.
    fn name(&self) -> &'static str;

    /// True if a failed increment may be cut into smaller ones to find out where the branch ends;
    /// false for a method with a fixed budget per increment, which simply goes where it goes.
    fn locates(&self) -> bool;

    /// From the newest state of `branch` to where the control is `control`. The stability of the
    /// result is not measured yet.
    ///
    /// `Ok` is a state within tolerance, or (for a method that does not locate) whatever its budget
    /// gave. `Err` says that the branch was lost.
    fn follow(
        &mut self,
        mechanics: &mut Mechanics,
        branch: &History,
        from: &Equilibrium,
        control: f64,
    ) -> Result<Equilibrium, Lost>;
}

/// The branch's extrapolation to where the control is `control`; where it has none, the state it
/// stands on.
pub(crate) fn predicted(
    mechanics: &mut Mechanics,
    branch: &History,
    from: &Equilibrium,
    control: f64,
) -> Vec<f64> {
    let Some(mut guess) = branch.predict(control) else {
        return from.state.amplitudes.clone();
    };
    // Nothing corrects what no real field has: extrapolated again and again it would grow.
    mechanics.system.make_real(&mut guess);
    // Nothing but symmetry holds a pattern in its place: extrapolated round-off would make it drift
    // off.
    let slides = !mechanics
        .sliding_basis(&from.state.amplitudes, &from.fields)
        .is_empty();
    if slides {
        held(&mechanics.system, &guess)
    } else {
        guess
    }
}

/// Largest deviation from the prediction, in units of the predicted change: beyond it a method has
/// found some other branch.
const STRAY: f64 = 0.6;

/// How far (root mean square, length) from its prediction a state may be and still continue the
/// branch.
///
/// Without a second state there is no prediction to stray from; the audit alone decides. Where the
/// branch is soft, a residual within tolerance leaves a thousandth of a range undecided.
pub(super) fn reach(system: &System, from: &State, guess: &[f64], control: f64) -> f64 {
    let change = distance(guess, &from.amplitudes);
    if change == 0.0 {
        return f64::INFINITY;
    }
    let step = (control - from.control).abs();
    let moved = if system.control() == Control::Load {
        step * system.law().range / system.law().traction_max()
    } else {
        step
    };
    STRAY * change + 0.1 * moved + 1e-3 * system.law().range
}

/// What a trapezoid may miss of the energy, over |d stress| |du0|: towards a fold, where the stress
/// falls off like a square root, it is 1/6 over the whole rest of the way, .09 over nine tenths of
/// it and .03 over half. A jump may hide behind what is allowed.
const SMOOTH: f64 = 0.05;

/// The energy audit: along a smooth branch dV = stress du0, and so for other controls. A step
/// across a jump pays with energy and is found out.
pub(crate) fn audit(system: &System, from: &State, to: &State) -> bool {
    let (control, law) = (system.control(), system.law());
    let conjugate = |of: &State| control.conjugate(of.mean_displacement, of.stress);
    let scale = control.conjugate_unit(law);
    let step = to.control - from.control;
    let (before, after) = (conjugate(from), conjugate(to));
    let missing = (to.energy - from.energy - 0.5 * (after + before) * step).abs();
    let smooth = SMOOTH * (after - before).abs() + 1e-3 * scale;
    missing
        <= smooth * step.abs()
            + system.precision().rounding().max(1e-12) * system.law().surface_energy
}

/// Largest sum of |weights| of an extrapolation; the uniform cubic has 15, anything wilder
/// amplifies noise.
const WILDEST: f64 = 16.0;

/// Up to four states of one branch, newest last.
#[derive(Clone, Debug, Default)]
pub struct History {
    states: Vec<(f64, Vec<f64>)>,
}

impl History {
    /// A branch that begins at one state.
    pub fn starting(state: &State) -> Self {
        let mut history = Self::default();
        history.push(state);
        history
    }

    /// Adds a state; one at the same control is replaced.
    pub fn push(&mut self, state: &State) {
        self.states.retain(|(known, _)| *known != state.control);
        if self.states.len() == 4 {
            self.states.remove(0);
        }
        self.states.push((state.control, state.amplitudes.clone()));
    }

    /// Lagrange extrapolation of the newest states to the value `at` of the control, of the highest
    /// order that does not amplify noise; `None` where not even a straight line through the last
    /// two may be trusted.
    pub fn predict(&self, at: f64) -> Option<Vec<f64>> {
        (2..=self.states.len()).rev().find_map(|count| {
            let points = &self.states[self.states.len() - count..];
            let weights: Vec<f64> = (0..count)
                .map(|i| {
                    let others = points.iter().enumerate().filter(|(j, _)| *j != i);
                    others
                        .map(|(_, (known, _))| (at - known) / (points[i].0 - known))
                        .product()
                })
                .collect();
            if weights.iter().map(|w: &f64| w.abs()).sum::<f64>() > WILDEST {
                return None;
            }
            let mut sum = vec![0.0; points[0].1.len()];
            for (w, (_, z)) in weights.iter().zip(points) {
                add(&mut sum, *w, z);
            }
            Some(sum)
        })
    }
}

/// Euclidean distance of two amplitude vectors: root mean square difference of the surfaces
/// (length).
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    let mut d = a.to_vec();
    add(&mut d, -1.0, b);
    norm(&d)
}

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
        if !self.is_stable() {
            return self;
        }
        // Not known among all is not known.
        if all.value.is_nan() || all.value < self.value {
            return all;
        }
        // Seen more closely among some, and bounded among all.
        Self {
            value: self.value,
            error: (self.value - (all.value - all.error)).max(0.0),
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

    /// What a method came to in so many `iterations`, having begun when `before` transforms were
    /// done.
    pub(super) fn reached(
        mechanics: &Mechanics,
        at: Evaluation,
        residual: f64,
        iterations: usize,
        before: usize,
    ) -> Self {
        let stop = if residual <= mechanics.system.precision().tolerance() {
            Stop::Stable
        } else {
            Stop::NotConverged
        };
        let transforms = mechanics.transforms() - before;
        let cost = Cost {
            iterations,
            transforms,
        };
        Self::unmeasured(at, residual, stop, cost)
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
