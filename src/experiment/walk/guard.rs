//! The watch over a quarter cell: a state that is stable among even fields may still give way to a mode of another symmetry.

use crate::experiment::scene::Model;
use crate::numerics::cancel::Cancel;
use crate::physics::preconditioner::Preconditioner;
use crate::physics::system::{System, Workspace};
use crate::solver::equilibrium::Stiffness;
use crate::solver::method::Slides;
use crate::solver::stability::Tracker;
use ndarray::Array2;

/// Largest distance, in ranges, between two looks while nothing is soft.
const INTERVAL: f64 = 0.1;

/// Tracks the smallest eigenvalue of the whole cell beside a walk on its even part.
pub(in crate::experiment) struct Guard {
    system: System,
    preconditioner: Preconditioner,
    slides: Slides,
    tracker: Tracker,
    ws: Workspace,
    /// Where it last looked, and what it saw.
    last: Option<(f64, Stiffness)>,
}

impl Guard {
    pub(in crate::experiment) fn new(model: &Model, constant: f64, slides: Slides, tracker: Tracker) -> Self {
        let system = System::new(model.grid, model.law, &model.indenter);
        Self { preconditioner: Preconditioner::new(&system, constant), slides, tracker, ws: system.workspace(), last: None, system }
    }

    /// Transforms of the whole cell spent.
    pub(in crate::experiment) fn transforms(&self) -> usize {
        self.ws.transforms
    }

    /// Forgets the branch.
    pub(in crate::experiment) fn reset(&mut self) {
        self.tracker.reset();
        self.last = None;
    }

    /// What it saw last, if that was near enough to `u0` and clear of zero.
    pub(in crate::experiment) fn recent(&self, u0: f64) -> Option<Stiffness> {
        let clear = |s: Stiffness| s.value > 0.1 * self.system.grid().q1();
        self.last.filter(|(at, s)| (at - u0).abs() < INTERVAL * self.system.law().range && clear(*s)).map(|(_, s)| s)
    }

    /// The smallest eigenvalue over all modes of the whole cell at the `displacement` field u of mean `u0`.
    pub(in crate::experiment) fn check(&mut self, displacement: &Array2<f64>, u0: f64, cancel: &Cancel) -> Stiffness {
        let Self { system, preconditioner, slides, tracker, ws, last } = self;
        let z = system.amplitudes(displacement, ws);
        let mut gradient = vec![0.0; z.len()];
        system.evaluate(&z, u0, &mut gradient, ws);
        preconditioner.refresh(system, ws);
        let seen = tracker.check(system, &z, *slides, preconditioner, ws, cancel).0;
        *last = Some((u0, seen));
        seen
    }
}
