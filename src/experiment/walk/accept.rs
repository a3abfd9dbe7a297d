//! From a state to its record.

use super::{Happening, Walk};
use crate::experiment::record::StateRecord;
use crate::numerics::vector::norm;
use crate::physics::pattern::{Pattern, classify, contact_area};
use crate::solver::equilibrium::{Cost, Stiffness};

impl Walk {
    pub(super) fn pattern(&mut self) -> Pattern {
        if self.here.is_uniform() && self.mechanics.system.is_flat() {
            return Pattern::Flat;
        }
        let thermal = if self.method.locates() { 0.0 } else { 0.02 * self.model.law.range };
        if self.mechanics.system.is_flat() && norm(&self.here.state.amplitudes) < thermal {
            return Pattern::Flat;
        }
        classify(self.mechanics.system.unfolded(&self.here.fields.gap).view(), &self.model.law, self.mechanics.system.is_flat())
    }

    /// Writes the record of the present state and hands it out.
    pub(super) fn accept(&mut self, observe: &mut dyn FnMut(Happening)) {
        let law = self.model.law;
        let uniform = self.here.is_uniform() && self.mechanics.system.is_flat();
        let pattern = self.pattern();
        if self.method.locates() {
            self.note_transition(pattern, observe);
        }
        let contact_area = match uniform {
            true => f64::from(u8::from(self.here.state.mean_displacement < law.contact_gap())),
            false => contact_area(self.here.fields.gap.view(), &law),
        };
        if pattern != Pattern::Flat {
            self.counts.patterned_increments += 1;
        }
        self.pause_clock();
        let stiffness = self.here.stiffness_min.unwrap_or(Stiffness { value: f64::NAN, error: f64::NAN });
        let length = self.model.grid.length;
        self.record = StateRecord {
            direction: self.direction,
            mean_displacement: self.here.state.mean_displacement,
            stress: self.here.state.stress,
            stress_over_max: self.here.state.stress / law.traction_max(),
            contact_area,
            pattern,
            residual: self.here.residual,
            stiffness_min: stiffness.value * length,
            stiffness_error: stiffness.error * length,
            energy: self.here.state.energy,
            model: if uniform && self.flat.is_some() {
                "flat, closed form"
            } else {
                match (self.model.grid.is_line(), self.mechanics.system.is_even(), self.guard.is_some()) {
                    (true, false, _) => "line cell",
                    (true, true, _) => "half line cell",
                    (false, false, _) => "whole cell",
                    (false, true, true) => "quarter cell",
                    (false, true, false) => "mirrored quarter",
                }
            },
            stop: self.here.stop,
            iterations: self.counts.iterations - self.seen.iterations,
            transforms: self.transforms() - self.seen.transforms,
            milliseconds: std::mem::take(&mut self.worked).as_secs_f64() * 1e3,
        };
        self.seen = Cost { iterations: self.counts.iterations, transforms: self.transforms() };
        observe(Happening::State(self.record.clone()));
    }
}
