//! The watch over a quarter cell: a state that is stable among even fields may still give way to a mode of another symmetry.

use super::Walk;
use crate::experiment::scene::Model;
use crate::numerics::cancel::Cancel;
use crate::physics::indenter::Indenter;
use crate::physics::preconditioner::Preconditioner;
use crate::physics::system::{System, Workspace};
use crate::solver::equilibrium::Stiffness;
use crate::solver::method::Slides;
use crate::solver::stability::Tracker;
use ndarray::Array2;

/// Largest distance, in ranges, between two looks while nothing is soft.
const INTERVAL: f64 = 0.1;

/// Largest mu_rho at which patterns on flat ground still slide freely over the mesh; beyond it the mesh pins them (Fig. 8).
const SLIDING_MU_RHO: f64 = 0.45;

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
    /// Watches `system`, a whole cell.
    pub(in crate::experiment) fn new(system: System, constant: f64, slides: Slides, tracker: Tracker) -> Self {
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

impl Walk {
    /// The smallest eigenvalue over all modes: on a quarter cell also those that are not even. `Err` where one of those is negative.
    /// The workspace must hold the state's gap.
    pub(super) fn all_modes(&mut self, even: Stiffness, cancel: &Cancel) -> Result<Stiffness, String> {
        let Some(guard) = &mut self.guard else {
            return Ok(even);
        };
        let u0 = self.ws.gap.mean().unwrap_or(f64::NAN) + self.system.height().and_then(|h| h.mean()).unwrap_or(0.0);
        let all = guard.recent(u0).unwrap_or_else(|| {
            let mut displacement = self.system.unfolded(&self.ws.gap);
            if let Some(height) = self.system.height() {
                displacement += &self.system.unfolded(height);
            }
            guard.check(&displacement, u0, cancel)
        });
        if all.value < even.value.min(-all.error) && even.is_stable() {
            return Err("a mode that is not mirror-symmetric goes soft here: this scene needs the whole cell".to_owned());
        }
        Ok(if all.value < even.value { all } else { even })
    }
}

/// Whether patterns slide on the whole cell of `model`.
pub(in crate::experiment) fn slides_on(model: &Model) -> Slides {
    match model.indenter {
        Indenter::Flat if model.law.is_smooth() && model.mu_rho <= SLIDING_MU_RHO => Slides::Freely,
        Indenter::Flat => Slides::UnlessPinned,
        _ => Slides::Never,
    }
}
