//! The watch over a quarter cell: a state that is stable among even fields may still give way to a mode of another symmetry.

use super::Walk;
use crate::experiment::mesh::next_fast;
use crate::experiment::scene::Model;
use crate::numerics::cancel::Cancel;
use crate::physics::grid::Grid;
use crate::physics::indenter::Indenter;
use crate::physics::mesh_rule;
use crate::physics::preconditioner::Preconditioner;
use crate::physics::system::{System, Workspace};
use crate::solver::equilibrium::Stiffness;
use crate::solver::problem::Slides;
use crate::solver::stability::Tracker;
use ndarray::Array2;

/// Largest mu_rho at which patterns on flat ground still slide freely over the mesh; beyond it the mesh pins them (Fig. 8).
const SLIDING_MU_RHO: f64 = 0.45;

/// mu_rho of a mesh that resolves soft modes.
const RESOLVED: f64 = 0.33;

/// Tracks the smallest eigenvalue of the whole cell beside a walk on its even part.
pub(in crate::experiment) struct Guard {
    system: System,
    preconditioner: Preconditioner,
    slides: Slides,
    tracker: Tracker,
    ws: Workspace,
}

impl Guard {
    /// Watches `system`, a whole cell.
    pub(in crate::experiment) fn new(system: System, constant: f64, slides: Slides, tracker: Tracker) -> Self {
        let tracker = with_coarse(tracker, &system, constant);
        Self { preconditioner: Preconditioner::new(&system, constant), slides, tracker, ws: system.workspace(), system }
    }

    /// Transforms of the whole cell spent.
    pub(in crate::experiment) fn transforms(&self) -> usize {
        self.ws.transforms + self.tracker.coarse_transforms()
    }

    /// Transforms spent on proofs.
    pub(in crate::experiment) fn proof_transforms(&self) -> usize {
        self.tracker.proof_transforms()
    }

    /// Forgets the branch.
    pub(in crate::experiment) fn reset(&mut self) {
        self.tracker.reset();
    }

    /// The smallest eigenvalue over all modes of the whole cell at the `displacement` field u of mean `u0`.
    pub(in crate::experiment) fn check(&mut self, displacement: &Array2<f64>, u0: f64, cancel: &Cancel) -> Stiffness {
        let Self { system, preconditioner, slides, tracker, ws } = self;
        let z = system.amplitudes(displacement, ws);
        let mut gradient = vec![0.0; z.len()];
        system.evaluate(&z, u0, &mut gradient, ws);
        preconditioner.refresh(system, ws);
        tracker.check(system, &z, *slides, preconditioner, ws, cancel).0
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
        let mut displacement = self.system.unfolded(&self.ws.gap);
        if let Some(height) = self.system.height() {
            displacement += &self.system.unfolded(height);
        }
        let all = guard.check(&displacement, u0, cancel);
        if all.value < 0.0 && even.is_stable() {
            return Err("a mode that is not mirror-symmetric goes soft here: this scene needs the whole cell".to_owned());
        }
        Ok(even.among(all))
    }
}

/// The tracker with a coarser mesh to look for modes on, where `system` has points to spare.
pub(super) fn with_coarse(tracker: Tracker, system: &System, constant: f64) -> Tracker {
    let (law, grid) = (system.law(), system.grid());
    let n = next_fast(mesh_rule::points_for_mu_rho(law, grid.length, RESOLVED).ceil() as usize);
    if !system.is_flat() || !law.is_smooth() || 2 * n > grid.nx {
        return tracker;
    }
    let coarse = if grid.is_line() { Grid::line(grid.length, n) } else { Grid::square(grid.length, n) };
    let make = if system.is_even() { System::even } else { System::new };
    tracker.with_coarse(make(coarse, *law, &Indenter::Flat), constant)
}

/// Whether patterns slide on the whole cell of `model`.
pub(in crate::experiment) fn slides_on(model: &Model) -> Slides {
    match model.indenter.is_uniform() {
        [false, false] => Slides::Never,
        _ if model.law.is_smooth() && model.mu_rho <= SLIDING_MU_RHO => Slides::Freely,
        _ => Slides::UnlessPinned,
    }
}
