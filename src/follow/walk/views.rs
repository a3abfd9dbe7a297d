//! What a walk shows: the gap, and the mode that gives way first.

use super::{Phase, Walk};
use crate::numerics::vector::{dot, scale};
use ndarray::Array2;

impl Walk {
    /// The gap field as it is now, also in the middle of a jump. Shape (ny, nx).
    pub fn gap(&self) -> Array2<f64> {
        let fields = match &self.phase {
            Phase::Jumping(jumping) => &jumping.release.at.fields,
            _ => &self.here.fields,
        };
        self.mechanics.system.unfolded(&fields.gap)
    }

    /// The gap field of the state it stands on, which a jump under way has left.
    pub fn gap_here(&self) -> Array2<f64> {
        self.mechanics.system.unfolded(&self.here.fields.gap)
    }

    /// The field of the mode that gives way first in the state it stands on, mean(phi^2) = 1: that
    /// of the smallest eigenvalue, or of the flat state one of its equal softest waves. `None` where
    /// it was not measured. One transform.
    pub fn soft_mode(&mut self) -> Option<Array2<f64>> {
        let mode = self.soft_amplitudes()?;
        let field = self
            .mechanics
            .uncounted(|mechanics| mechanics.field(&mode).clone());
        Some(self.mechanics.system.unfolded(&field))
    }

    /// The mode with the sign of the last one asked for, so that pictures do not flicker.
    fn soft_amplitudes(&mut self) -> Option<Vec<f64>> {
        let mut mode = self.here.soft_mode.clone();
        if self.here.is_uniform() && self.mechanics.system.is_flat() {
            mode = self.mechanics.system.softest_wave();
        }
        if mode.len() == self.facing.len() && dot(&mode, &self.facing) < 0.0 {
            scale(&mut mode, -1.0);
        }
        self.facing.clone_from(&mode);
        (!mode.is_empty()).then_some(mode)
    }
}
