//! What a walk shows: the gap, the mode that gives way first, and the energy well along it.

use super::{Phase, Walk};
use crate::numerics::vector::{add, dot, scale};
use ndarray::Array2;

/// Offsets along the soft mode, in ranges, root mean square over the cell.
const OFFSET: f64 = 0.5;
/// Energies of a well; odd, so that the state itself is among them.
const SAMPLES: usize = 41;

/// The energy around a state along its soft mode phi, mean(phi^2) = 1: V(u0; u + a phi) - V.
#[derive(Clone, Debug, PartialEq)]
pub struct EnergyWell {
    /// u0 of the state (length).
    pub mean_displacement: f64,
    /// What holds it there: u0, the position of the stage (length), or the load per area (E*).
    control: f64,
    /// Offsets a (length), ascending.
    pub offsets: Vec<f64>,
    /// Energies per area at the offsets (E* times length), as many as are computed yet.
    pub energies: Vec<f64>,
    /// Curvature at the state: its smallest eigenvalue (E* per length).
    pub curvature: f64,
    energy: f64,
    mode: Vec<f64>,
}

impl EnergyWell {
    /// True once every energy is known.
    pub fn is_complete(&self) -> bool {
        self.energies.len() == self.offsets.len()
    }
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

    /// The field of the mode that gives way first, mean(phi^2) = 1: that of the smallest
    /// eigenvalue, or of the flat state one of its equal softest waves. `None` while jumping or not
    /// measured. One transform.
    pub fn soft_mode(&mut self) -> Option<Array2<f64>> {
        let mode = self.soft_amplitudes()?;
        let field = self
            .mechanics
            .uncounted(|mechanics| mechanics.field(&mode).clone());
        Some(self.mechanics.system.unfolded(&field))
    }

    /// The well around the present state, still empty: [`Walk::deepen`] fills it. `None` while
    /// jumping or without a soft mode.
    pub fn energy_well(&mut self) -> Option<EnergyWell> {
        let (mode, stiffness) = (self.soft_amplitudes()?, self.here.stiffness_min?);
        let step = 2.0 * OFFSET * self.model.law.range / (SAMPLES - 1) as f64;
        Some(EnergyWell {
            mean_displacement: self.here.state.mean_displacement,
            control: self.here.state.control,
            offsets: (0..SAMPLES)
                .map(|i| (i as f64 - (SAMPLES / 2) as f64) * step)
                .collect(),
            energies: Vec::with_capacity(SAMPLES),
            curvature: stiffness.value,
            energy: self.here.state.energy,
            mode,
        })
    }

    /// Computes up to `count` more energies of a well around the present state.
    pub fn deepen(&mut self, well: &mut EnergyWell, count: usize) {
        for _ in 0..count.min(well.offsets.len() - well.energies.len()) {
            let mut z = self.here.state.amplitudes.clone();
            add(&mut z, well.offsets[well.energies.len()], &well.mode);
            let there = self
                .mechanics
                .uncounted(|mechanics| mechanics.at(z, well.control));
            well.energies.push(there.state.energy - well.energy);
        }
    }

    /// The mode with the sign of the last one asked for, so that pictures do not flicker.
    fn soft_amplitudes(&mut self) -> Option<Vec<f64>> {
        if matches!(self.phase, Phase::Jumping(_)) {
            return None;
        }
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
