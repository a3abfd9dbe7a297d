//! A stored state that somebody looks at, and the steps from jump to jump.

use super::ViewState;
use crate::experiment::record::{JumpRecord, StateRecord};

/// What is looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// The stored state.
    pub state: StateRecord,
    /// Index of the jump that led to it or away from it.
    pub jump: Option<usize>,
}

/// A state this close to a jump (ranges) belongs to it: the walk brackets a jump to a ten-thousandth.
const AT_JUMP: f64 = 2e-4;

impl ViewState {
    /// Selects the recorded state nearest to (u0/rho, stress/sigma_max), if one is within `reach` along each axis; else none.
    pub fn select_near(&mut self, at: [f64; 2], reach: [f64; 2]) {
        let rho = self.rho();
        let distance =
            |s: &StateRecord| ((s.mean_displacement / rho - at[0]) / reach[0]).hypot((s.stress_over_max - at[1]) / reach[1]);
        let nearest = self.record.states.iter().map(|s| (distance(s), s)).filter(|(d, _)| *d <= 1.0);
        let nearest = nearest.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, state)| state.clone());
        self.selection = nearest.map(|state| Selection { jump: self.jump_at(&state), state });
    }

    /// Selects the state after a jump.
    pub fn select_jump(&mut self, index: usize) {
        let Some(jump) = self.record.jumps.get(index) else { return };
        let landed = |s: &&StateRecord| s.direction == jump.direction && s.mean_displacement == jump.mean_displacement;
        self.selection = self.record.states.iter().rfind(landed).map(|state| Selection { state: state.clone(), jump: Some(index) });
    }

    /// Selects the next (or an earlier) jump; from nowhere the last, or the first.
    pub fn step_jump(&mut self, forward: bool) {
        let last = self.record.jumps.len().saturating_sub(1);
        let present = self.selection.as_ref().and_then(|selection| selection.jump);
        self.select_jump(match (present, forward) {
            (None, true) => 0,
            (None, false) => last,
            (Some(i), true) => (i + 1).min(last),
            (Some(i), false) => i.saturating_sub(1),
        });
    }

    fn jump_at(&self, state: &StateRecord) -> Option<usize> {
        let off = |jump: &JumpRecord| (jump.mean_displacement - state.mean_displacement).abs();
        let near = |jump: &JumpRecord| jump.direction == state.direction && off(jump) <= AT_JUMP * self.rho();
        self.record.jumps.iter().rposition(near)
    }
}
