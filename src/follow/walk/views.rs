//! What a walk shows: the gap, and the mode that gives way first.

use super::symmetry::{slides_on, with_coarse};
use super::{Phase, Walk};
use crate::follow::record::StateRecord;
use crate::numerics::cancel::Cancel;
use crate::numerics::vector::{dot, scale};
use crate::physics::control::Control;
use crate::physics::system::System;
use crate::scene::Model;
use crate::solver::mechanics::Mechanics;
use crate::solver::stability::Tracker;
use ndarray::Array2;
use rand::SeedableRng;
use rand_pcg::Pcg64;

/// The field of the mode of smallest stiffness in a state of which the displacement (length) is
/// known over the whole cell, mean(phi^2) = 1: of several that are equal one. `None` where it was
/// not found, or somebody asked to stop.
pub fn soft_mode(
    (model, driven): (&Model, Control),
    record: &StateRecord,
    displacement: &Array2<f64>,
    cancel: &Cancel,
) -> Option<Array2<f64>> {
    let system = System::new(model.grid, model.law, &model.indenter).with_body(model.body);
    let mut mechanics = Mechanics::new(system.with_control(driven), slides_on(model));
    mechanics.cancel = cancel.clone();
    let [control, mean] = driven.balanced(record.mean_displacement, record.stress);
    let mut z = mechanics.amplitudes(displacement);
    z[0] = mean;
    let at = mechanics.at(z, control);
    mechanics.refresh(&at.fields);
    let mut tracker = with_coarse(Tracker::new(Pcg64::seed_from_u64(0)), &mechanics);
    let (stiffness, mode) = tracker.check(&mut mechanics, &at.state.amplitudes, &at.fields);
    (!stiffness.value.is_nan()).then(|| mechanics.field(&mode).clone())
}

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
