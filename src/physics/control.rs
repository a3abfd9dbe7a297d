//! What drives the body: its mean displacement, a stage that pulls through a spring, or a load; and
//! a state of its surface under it.
//!
//! The mean displacement u0 is one more amplitude, that of q = 0, and the machine is its stiffness.
//! With V(u0, z) the energy per area of body and cohesion and sigma = dV/du0 its mean stress:
//!
//! | control | value | energy per area | equilibrium | derivative with the value |
//! |---|---|---|---|---|
//! | displacement | u0 | V | u0 given | sigma |
//! | spring | w, of the stage | V + k (w - u0)^2/2 | sigma = k (w - u0) | sigma |
//! | load | F per area | V - F u0 | sigma = F | -u0 |
//!
//! Equilibria are those of fixed u0. With S = d sigma/du0 along a branch the Hessian with u0 as an
//! unknown has one negative eigenvalue more than at fixed u0 where S < -k (Schur's complement), and
//! k = 0 under a load.

use super::law::Law;
use super::theory::boundary;
use crate::numerics::dense::norm;
use ndarray::Array2;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Traction at the stop of a load over the largest: a tenth of the residual of every state.
const TRACE: f64 = 1e-7;
/// Largest u0 at which contact holds, over sqrt(gamma L/E*), and half as much again: a ridge of zero
/// range lets go at 0.666, and uneven ground is farther away.
const REACH: f64 = 1.0;

/// What is driven.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub enum Control {
    /// The mean displacement u0 itself: a machine without compliance.
    #[default]
    Displacement,
    /// A stage that pulls through a spring.
    Spring {
        /// Its stiffness k per area (E* per length).
        stiffness: f64,
    },
    /// The load per area, the mean stress: a dead weight.
    Load,
}

impl Control {
    /// Every kind, a spring with a `stiffness` of its own.
    pub fn all(stiffness: f64) -> [Self; 3] {
        [Self::Displacement, Self::Spring { stiffness }, Self::Load]
    }

    /// The word of the scene file.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Displacement => "displacement",
            Self::Spring { .. } => "spring",
            Self::Load => "load",
        }
    }

    /// The letter of what is driven: u0, the position w of the stage, or the load F per area.
    pub fn symbol(&self) -> &'static str {
        match self {
            Self::Displacement => "u₀",
            Self::Spring { .. } => "w",
            Self::Load => "F",
        }
    }

    /// The same with a spring of `stiffness` (E* per length, infinite if there is none) in series.
    pub fn in_series(self, stiffness: f64) -> Self {
        match self {
            Self::Load => self,
            _ if stiffness.is_infinite() => self,
            _ => Self::Spring {
                stiffness: 1.0 / (1.0 / self.stiffness() + 1.0 / stiffness),
            },
        }
    }

    /// Over what length, or stress of a load, a body of this law answers: the range, beside which a
    /// spring is stretched by sigma_max/k; or sigma_max.
    pub fn unit(&self, law: &Law) -> f64 {
        match self {
            Self::Displacement => law.range,
            Self::Spring { stiffness } => law.range + law.traction_max() / stiffness,
            Self::Load => law.traction_max(),
        }
    }

    /// Over what its [conjugate](Self::conjugate) changes: sigma_max, or the range under a load.
    pub fn conjugate_unit(&self, law: &Law) -> f64 {
        if *self == Self::Load {
            law.range
        } else {
            law.traction_max()
        }
    }

    /// u0 of the stop on which a load holds the body apart (length), in a cell in which the softest
    /// wave is as stiff as the longest of a half-space in one of side `length`; the highest point of
    /// the ground at zero. There the ground is not felt any more, neither by a flat surface nor by
    /// one that is pulled out towards it.
    pub fn stop(law: &Law, length: f64) -> f64 {
        let pulled_out = law.contact_gap() + REACH * (law.surface_energy * length).sqrt();
        Self::unfelt(law).max(pulled_out)
    }

    /// The gap (length) from which on a law is not felt any more.
    pub fn unfelt(law: &Law) -> f64 {
        let felt = |gap: f64| law.at(gap).traction > TRACE * law.traction_max();
        let (near, mut width) = (law.contact_gap(), law.range);
        while felt(near + width) {
            width *= 2.0;
        }
        boundary(near, near + width, felt)
    }

    /// True if a body at `u0` is on that stop, or has flown beyond it.
    pub fn is_apart(&self, law: &Law, length: f64, u0: f64) -> bool {
        *self == Self::Load && u0 >= Self::stop(law, length)
    }

    /// True if u0 is an unknown.
    pub fn frees_mean(&self) -> bool {
        *self != Self::Displacement
    }

    /// Stiffness of the machine (E* per length), infinite at fixed u0.
    pub fn stiffness(&self) -> f64 {
        match self {
            Self::Displacement => f64::INFINITY,
            Self::Spring { stiffness } => *stiffness,
            Self::Load => 0.0,
        }
    }

    /// u0 (length) where the control has this `value` and the amplitude of q = 0 is `mean`.
    pub(super) fn mean_displacement(&self, value: f64, mean: f64) -> f64 {
        match self {
            Self::Displacement => value,
            Self::Spring { .. } => value + mean,
            Self::Load => mean,
        }
    }

    /// The value of the control where u0 and the amplitude of q = 0 are these; a load, of which
    /// they say nothing, is zero.
    pub fn value(&self, u0: f64, mean: f64) -> f64 {
        match self {
            Self::Displacement => u0,
            Self::Spring { .. } => u0 - mean,
            Self::Load => 0.0,
        }
    }

    /// Value of the control and amplitude of q = 0 where u0 and the mean `stress` are in
    /// equilibrium. Linear: of the rates of both along a branch it gives those.
    pub fn balanced(&self, u0: f64, stress: f64) -> [f64; 2] {
        match self {
            Self::Displacement => [u0, 0.0],
            Self::Spring { stiffness } => [u0 + stress / stiffness, -stress / stiffness],
            Self::Load => [stress, u0],
        }
    }

    /// True if with u0 free the Hessian has one negative eigenvalue more than at fixed u0, where u0
    /// and stress have these rates along a branch: S + k < 0, without the pole of S at a fold of
    /// u0.
    pub fn softens(&self, rates: [f64; 2]) -> bool {
        self.balanced(rates[0], rates[1])[0] * rates[0] < 0.0
    }

    /// Energy per area of the machine at mean displacement `u0` (length), to be added to that of
    /// body and cohesion (E* times length).
    pub fn energy(&self, value: f64, u0: f64) -> f64 {
        match self {
            Self::Displacement => 0.0,
            Self::Spring { stiffness } => 0.5 * stiffness * (value - u0).powi(2),
            Self::Load => -value * u0,
        }
    }

    /// The derivative of the energy per area with the control, from the mean displacement and the
    /// mean stress of an equilibrium; of their rates along a branch its rate.
    pub fn conjugate(&self, u0: f64, stress: f64) -> f64 {
        if *self == Self::Load { -u0 } else { stress }
    }

    /// u0 and mean stress of the equilibrium with this `value` of the control and its `conjugate`.
    pub fn place(&self, value: f64, conjugate: f64) -> [f64; 2] {
        match self {
            Self::Displacement => [value, conjugate],
            Self::Spring { stiffness } => [value - conjugate / stiffness, conjugate],
            Self::Load => [-conjugate, value],
        }
    }
}

/// As in "under ...".
impl fmt::Display for Control {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Displacement => f.pad("a driven displacement"),
            Self::Spring { stiffness } => write!(f, "a spring of stiffness {stiffness}"),
            Self::Load => f.pad("a load"),
        }
    }
}

/// A surface under its control, with its energy and stress.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// What is driven: u0 or the position of the stage (length), or the load per area (E*).
    pub control: f64,
    /// Mean displacement u0 (length), which follows from control and amplitudes.
    pub mean_displacement: f64,
    /// Amplitudes z of u - u0, and of u0 where it is free (length).
    pub amplitudes: Vec<f64>,
    /// Energy per area, that of the machine with it (E* times length).
    pub energy: f64,
    /// Mean stress (E*), positive in tension.
    pub stress: f64,
}

impl State {
    /// Its amplitudes and mean displacement, which together are the surface.
    pub fn joint(&self) -> (&[f64], f64) {
        (&self.amplitudes, self.mean_displacement)
    }

    /// Moves u0 by `du` (length) where u0 is the control.
    pub fn drive_by(&mut self, du: f64) {
        self.control += du;
        self.mean_displacement = self.control;
    }

    /// Makes an equilibrium of fixed u0 one under `control`.
    pub fn put_under(&mut self, control: Control) {
        let mean;
        [self.control, mean] = control.balanced(self.mean_displacement, self.stress);
        if let Some(z) = self.amplitudes.first_mut() {
            *z = mean;
        }
        self.energy += control.energy(self.control, self.mean_displacement);
    }

    /// The same of an equilibrium of fixed u0, without its amplitudes.
    pub fn under(&self, control: Control) -> Self {
        let mut state = Self {
            amplitudes: Vec::new(),
            ..*self
        };
        state.put_under(control);
        state
    }

    /// Energy per area of body and cohesion, without that of the machine (E* times length).
    pub fn body_energy(&self, control: Control) -> f64 {
        self.energy - control.energy(self.control, self.mean_displacement)
    }

    /// Root mean square of u - u0 (length).
    pub fn roughness(&self) -> f64 {
        norm(&self.amplitudes[1..])
    }
}

/// What a law makes of the gap at every point; shapes (ny, nx) of
/// [`System::shape`](super::system::System::shape).
#[derive(Clone, Debug, Default)]
pub struct Fields {
    /// Gap g (length).
    pub gap: Array2<f64>,
    /// Traction gamma'(g) (E*).
    pub traction: Array2<f64>,
    /// Stiffness gamma''(g) (E* per length).
    pub stiffness: Array2<f64>,
}

impl Fields {
    /// All that a Hessian asks for: its `stiffness` gamma''; gap and traction are empty.
    pub fn of(stiffness: Array2<f64>) -> Self {
        Self {
            stiffness,
            ..Self::default()
        }
    }
}

/// A state with its derivatives: the force, and the fields of which the Hessian is made.
#[derive(Clone, Debug)]
pub struct Evaluation {
    /// The state.
    pub state: State,
    /// The derivative of the energy with z at a fixed control (E*).
    pub gradient: Vec<f64>,
    /// Gap, traction and stiffness.
    pub fields: Fields,
}
