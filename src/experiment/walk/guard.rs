//! The watch over a quarter cell: a state that is stable among even fields may still give way to a mode of another symmetry.

use super::Walk;
use crate::experiment::mesh::next_fast;
use crate::experiment::scene::Model;
use crate::physics::grid::Grid;
use crate::physics::indenter::Indenter;
use crate::physics::mesh_rule;
use crate::physics::preconditioner::Preconditioner;
use crate::physics::system::System;
use crate::solver::equilibrium::{Equilibrium, Stiffness};
use crate::solver::mechanics::{Mechanics, Slides, preconditioner_stiffness};
use crate::solver::stability::Tracker;
use ndarray::Array2;

/// Largest mu_rho at which patterns on flat ground still slide freely over the mesh; beyond it the mesh pins them (Fig. 8).
const SLIDING_MU_RHO: f64 = 0.45;

/// mu_rho of a mesh that resolves soft modes.
const RESOLVED: f64 = 0.33;

/// Tracks the smallest eigenvalue of the whole cell beside a walk on its even part.
pub(in crate::experiment) struct Guard {
    pub(in crate::experiment) mechanics: Mechanics,
    tracker: Tracker,
}

impl Guard {
    /// Watches a whole cell.
    pub(in crate::experiment) fn new(mechanics: Mechanics, tracker: Tracker) -> Self {
        Self { tracker: with_coarse(tracker, &mechanics), mechanics }
    }

    /// Watches the whole cell of the `even` system.
    pub(super) fn of_even(even: &System, slides: Slides, tracker: Tracker) -> Self {
        let whole = System::whole(even);
        let preconditioner = Preconditioner::new(&whole, preconditioner_stiffness(even));
        Self::new(Mechanics::with_preconditioner(preconditioner, whole, slides), tracker)
    }

    /// Transforms of the whole cell spent.
    pub(in crate::experiment) fn transforms(&self) -> usize {
        self.mechanics.transforms() + self.tracker.coarse_transforms()
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
    pub(in crate::experiment) fn check(&mut self, displacement: &Array2<f64>, u0: f64) -> Stiffness {
        let Self { mechanics, tracker } = self;
        let z = mechanics.amplitudes(displacement);
        let at = mechanics.at(z, u0);
        mechanics.refresh(&at.fields);
        tracker.check(mechanics, &at.state.amplitudes, &at.fields).0
    }
}

impl Walk {
    /// The smallest eigenvalue of `found` over all modes, `even` being that over even ones: on a quarter cell also over those that are
    /// not. `Err` where one of those is negative.
    pub(super) fn all_modes(&mut self, found: &Equilibrium, even: Stiffness) -> Result<Stiffness, String> {
        let Some(guard) = &mut self.guard else {
            return Ok(even);
        };
        let (system, gap) = (&self.mechanics.system, &found.fields.gap);
        let u0 = gap.mean().unwrap_or(f64::NAN) + system.height().and_then(|h| h.mean()).unwrap_or(0.0);
        let mut displacement = system.unfolded(gap);
        if let Some(height) = system.height() {
            displacement += &system.unfolded(height);
        }
        guard.mechanics.cancel = self.mechanics.cancel.clone();
        let all = guard.check(&displacement, u0);
        if all.value < 0.0 && even.is_stable() {
            return Err("a mode that is not mirror-symmetric goes soft here: this scene needs the whole cell".to_owned());
        }
        Ok(even.among(all))
    }
}

/// The tracker with a coarser mesh to look for modes on, where the one of `mechanics` has points to spare.
pub(super) fn with_coarse(tracker: Tracker, Mechanics { system, slides, .. }: &Mechanics) -> Tracker {
    let (law, grid) = (system.law(), system.grid());
    let n = next_fast(mesh_rule::points_for_mu_rho(law, grid.length, RESOLVED).ceil() as usize);
    if !system.is_flat() || !law.is_smooth() || 2 * n > grid.nx {
        return tracker;
    }
    let coarse = if grid.is_line() { Grid::line(grid.length, n) } else { Grid::square(grid.length, n) };
    let make = if system.is_even() { System::even } else { System::new };
    tracker.with_coarse(Mechanics::new(make(coarse, *law, &Indenter::Flat), *slides))
}

/// Whether patterns slide on the whole cell of `model`.
pub(in crate::experiment) fn slides_on(model: &Model) -> Slides {
    match model.indenter.is_uniform() {
        [false, false] => Slides::Never,
        _ if model.law.is_smooth() && model.mu_rho <= SLIDING_MU_RHO => Slides::Freely,
        _ => Slides::UnlessPinned,
    }
}
