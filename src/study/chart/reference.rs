//! What everything is compared with: the same loop on a finer mesh with half the step, and how far
//! it can be trusted.

use super::judge::{Comparison, Errors, Judged, compare};
use super::points::LONGER;
use super::{Measured, Point};

/// The finest solution, with its own error estimate.
#[derive(Clone, Debug)]
pub struct Reference {
    /// The loop with the finest mesh and step.
    pub finest: Measured,
    /// Loss over gamma: its sum of releases.
    pub dissipated_energy: f64,
    /// Loop integral over gamma, extrapolated in the step (Richardson, second order).
    pub integral: f64,
    /// What a coarser mesh, or a longer step, changes: upper bounds of its own errors. NaN if it
    /// failed.
    pub errors: Errors,
}

impl Reference {
    /// From three loops: the finest, one on a coarser mesh, one with a longer step.
    pub fn new([finest, coarser, longer]: [Measured; 3]) -> Self {
        let errors = compare(&coarser, &finest)
            .errors
            .larger(compare(&longer, &finest).errors);
        let longer = longer.integral();
        let integral = finest.integral() + (finest.integral() - longer) / (LONGER * LONGER - 1.0);
        Self {
            dissipated_energy: finest.dissipated_energy(),
            integral,
            errors,
            finest,
        }
    }

    /// The row of a measured loop; `plan`, `paper_budget`: how it is marked.
    pub fn judge(&self, measured: &Measured, plan: bool, paper_budget: bool) -> Judged {
        let comparison = compare(measured, &self.finest);
        Judged::new(measured, comparison, plan, paper_budget)
    }

    /// Its own row, whose errors are its own estimates.
    pub fn judged(&self) -> Judged {
        Judged::new(
            &self.finest,
            Comparison {
                errors: self.errors,
                faults: Vec::new(),
            },
            false,
            false,
        )
    }

    /// Its own settings.
    pub fn point(&self) -> &Point {
        &self.finest.point
    }
}
