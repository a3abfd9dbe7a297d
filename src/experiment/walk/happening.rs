//! What a step of the walk brings, leaves to do, and costs.

use crate::experiment::record::{JumpRecord, StateRecord};

/// What one step of the walk brought.
#[derive(Clone, Debug)]
pub enum Happening {
    /// A new state on the path.
    State(StateRecord),
    /// The surface is moving at fixed u0; [`Walk::gap`](super::Walk::gap) shows it.
    Moving {
        /// Mean stress at this instant (E*).
        stress: f64,
    },
    /// A jump was completed; the state after it follows.
    Jump(JumpRecord),
}

/// What is left to do.
#[derive(Clone, Debug, PartialEq)]
pub enum Progress {
    /// More steps are needed.
    Working,
    /// At the target.
    Resting,
    /// Interrupted by the cancel token; the last state stands.
    Cancelled,
    /// Cannot go on; the last state stands.
    Stuck(String),
}

impl std::ops::AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        let Self { transforms, proof_transforms, iterations, patterned_increments } = other;
        self.transforms += transforms;
        self.proof_transforms += proof_transforms;
        self.iterations += iterations;
        self.patterned_increments += patterned_increments;
    }
}

/// What was spent so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counts {
    /// Fourier transforms.
    pub transforms: usize,
    /// Those of them that prove that no mode is softer than the ones that are followed.
    pub proof_transforms: usize,
    /// Iterations of the method.
    pub iterations: usize,
    /// Recorded states with a pattern.
    pub patterned_increments: usize,
}
