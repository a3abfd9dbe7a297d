//! The live loop, ready to draw.

use crate::experiment::record::Direction;
use crate::worker::protocol::{LiveState, RunId};
use std::sync::Arc;

/// What is drawn of the live loop.
#[derive(Clone, Debug, PartialEq)]
pub struct LiveView {
    /// The run it was computed for.
    pub run: RunId,
    /// The loop with its numbers.
    pub state: Arc<LiveState>,
    /// Its pieces: direction, and (u0/rho, stress/sigma_max).
    pub pieces: Vec<(Direction, Vec<[f64; 2]>)>,
    /// Its jumps: u0/rho, and stress/sigma_max before and after.
    pub jumps: Vec<(f64, [f64; 2])>,
}

impl LiveView {
    /// Scales a loop by its own law.
    pub fn new(run: RunId, state: Arc<LiveState>) -> Self {
        let (mut pieces, mut jumps) = (Vec::new(), Vec::new());
        if let Ok(found) = &state.found {
            let (rho, top) = (found.law.range, found.law.traction_max());
            let scaled = |points: Vec<[f64; 2]>| points.into_iter().map(|p| [p[0] / rho, p[1] / top]).collect();
            pieces = found.legs.iter().map(|leg| (leg.direction, scaled(found.points_of(leg)))).collect();
            jumps =
                found.jumps.iter().map(|j| (j.mean_displacement / rho, [j.stress_before / top, j.stress_after / top])).collect();
        }
        Self { run, state, pieces, jumps }
    }

    /// The loop in words: what it dissipates, how long it took, which model; or why there is none.
    pub fn words(&self) -> String {
        match &self.state.found {
            Ok(found) => format!(
                "loop {:.4} γ in {:.0} ms (atlas, {} points)",
                found.dissipated_energy, self.state.milliseconds, found.points
            ),
            Err(reason) => format!("no live loop: {reason}"),
        }
    }
}
