//! Under a load: the body apart from the ground, on a stop of the machine.
//!
//! A load that pulls at a free body has no equilibrium: the body would fly off, and one that pushes
//! would bring it back from any distance. The machine holds it where the ground is not felt any
//! more; how far that is adds to the energy that a pull-off releases, load times way.

use super::{Barrier, Cause, Observed, Progress, Walk};
use crate::physics::control::Control;
use crate::solver::Stop;
use crate::solver::equilibrium::{Cost, Equilibrium, Stiffness};
use crate::solver::mechanics::Mechanics;
use std::f64::consts::PI;

/// The flat body on the stop under the load `control`. Two transforms.
pub(in crate::follow) fn apart(mechanics: &mut Mechanics, control: f64) -> Equilibrium {
    let system = &mechanics.system;
    let (law, length) = (*system.law(), system.equivalent_length());
    let mut z = vec![0.0; system.dimension()];
    z[0] = Control::stop(&law);
    let mut at = mechanics.at(z, control);
    // What is left of the load the stop bears.
    at.gradient[0] = 0.0;
    let residual = mechanics.residual(&at);
    // The stop holds the mean; the softest wave is softened by no more than this.
    let softest = at.fields.stiffness.fold(0.0, |least: f64, s| least.min(*s));
    let mut state = Equilibrium::unmeasured(at, residual, Stop::Stable, Cost::default());
    let stiffness = Stiffness {
        value: PI / length,
        error: -softest,
    };
    state.measured(stiffness, Vec::new());
    state
}

impl Walk {
    /// True if a body at `u0` is on the stop, or has flown beyond it.
    pub(super) fn is_apart(&self, u0: f64) -> bool {
        self.control().is_apart(&self.model.law, u0)
    }

    /// One increment on the stop: it holds as long as the load does not push.
    pub(super) fn step_apart(&mut self, observe: &mut dyn FnMut(Observed)) -> Progress {
        let (next, touch) = (self.next(), self.here.state.stress);
        if next > touch || next > self.here.state.control {
            self.here = apart(&mut self.mechanics, next);
            self.accept(observe);
            return Progress::Working;
        }
        if self.here.state.control > touch {
            self.here = apart(&mut self.mechanics, touch);
            self.accept(observe);
        }
        let mut soft_mode = vec![0.0; self.mechanics.system.dimension()];
        soft_mode[0] = 1.0;
        let barrier = Barrier {
            at: touch - self.located_within(),
            stiffness: None,
            soft_mode,
        };
        self.release_because(Cause::Fold, barrier, Vec::new())
    }
}
