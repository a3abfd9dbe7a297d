//! The smallest Hessian eigenvalue: tracked from state to state, or found afresh.

use super::equilibrium::Stiffness;
use super::method::Slides;
use super::newton::sliding_basis;
use crate::numerics::cancel::Cancel;
use crate::numerics::eigen::{EigenLimits, smallest};
use crate::physics::preconditioner::Preconditioner;
use crate::physics::system::{System, Workspace};
use rand::Rng;
use rand_pcg::Pcg64;

/// Follows the softest modes of a branch.
///
/// Two modes are carried; one random smooth direction joins at each check, so that a mode of another symmetry that softens is not
/// missed, however exactly the carried ones keep to theirs.
#[derive(Clone, Debug)]
pub struct Tracker {
    modes: Vec<Vec<f64>>,
    rng: Pcg64,
}

impl Tracker {
    /// Knows nothing yet; `rng` gives the random directions.
    pub fn new(rng: Pcg64) -> Self {
        Self { modes: Vec::new(), rng }
    }

    /// Forgets the branch.
    pub fn reset(&mut self) {
        self.modes.clear();
    }

    /// The smallest eigenvalue and its mode at the state `z` at which `ws` was last evaluated.
    ///
    /// The first check after a reset starts from random vectors and converges; later ones take two iterations, and more only where
    /// the value is not clear of its error. `slides`: sliding modes are removed.
    pub fn check(
        &mut self,
        system: &System,
        z: &[f64],
        slides: Slides,
        preconditioner: &Preconditioner,
        ws: &mut Workspace,
        cancel: &Cancel,
    ) -> (Stiffness, Vec<f64>) {
        let fresh = self.modes.is_empty();
        let removed = sliding_basis(system, z, slides, ws);
        let mut start = std::mem::take(&mut self.modes);
        for _ in 0..if fresh { 6 } else { 1 } {
            start.push(random_smooth(system, &mut self.rng));
        }
        let absolute = 1e-4 * system.grid().q1();
        let limits = if fresh {
            EigenLimits { pairs: 2, least: 8, most: 80, relative: 0.02, absolute }
        } else {
            EigenLimits { pairs: 2, least: 1, most: 12, relative: 0.25, absolute }
        };
        let apply = |r: &[f64], out: &mut [f64]| {
            preconditioner.apply(r, out);
            // Amplitudes that belong to no real field have elastic energy alone. In deep compression that is less than any real mode
            // has, and they would grow out of the rounding.
            system.make_real(out);
        };
        let found = smallest(|v, out| system.hessian(v, out, ws), start, &removed, apply, limits, cancel);
        let stiffness = Stiffness { value: found.values[0], error: found.residual };
        self.modes = found.vectors;
        (stiffness, self.modes[0].clone())
    }
}

/// A random real field of long waves, as amplitudes: every symmetry is in it.
pub fn random_smooth(system: &System, rng: &mut Pcg64) -> Vec<f64> {
    let q1 = system.grid().q1();
    let mut z = random_amplitudes(system, rng);
    for (z, e) in z.iter_mut().zip(system.elastic()) {
        let waves = 2.0 * e / q1;
        *z *= (-0.3 * waves).exp();
    }
    z
}

/// White noise of variance 1/3 per amplitude with the symmetry of a real field, without mean.
pub fn random_amplitudes(system: &System, rng: &mut Pcg64) -> Vec<f64> {
    let mut z: Vec<f64> = (0..system.dimension()).map(|_| rng.random_range(-1.0..1.0)).collect();
    system.make_real(&mut z);
    z
}
