//! A state of the surface: what is kept of it, and what its derivatives are made of.

use super::control::Control;
use crate::numerics::vector::norm;
use ndarray::Array2;
use serde::{Deserialize, Serialize};

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
