//! The smallest Hessian eigenvalue: tracked from state to state, or found afresh.

use super::equilibrium::Stiffness;
use super::method::Slides;
use super::newton::sliding_basis;
use crate::numerics::cancel::Cancel;
use crate::numerics::eigen::{EigenLimits, EigenPairs, smallest};
use crate::numerics::vector::{add, dot, norm, project_out, scale};
use crate::physics::preconditioner::Preconditioner;
use crate::physics::system::{System, Workspace, carried};
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
    coarse: Option<Coarse>,
}

/// A coarser mesh of the same cell. Soft modes are long waves: what resolves the pattern resolves them, and the mesh in use may be
/// finer than that by far.
#[derive(Clone, Debug)]
struct Coarse {
    system: System,
    preconditioner: Preconditioner,
    ws: Workspace,
}

/// Where modes are looked for: beside the `removed` ones, at the state at which the workspace stands.
struct Place<'a> {
    system: &'a System,
    removed: Vec<Vec<f64>>,
    preconditioner: &'a Preconditioner,
    ws: &'a mut Workspace,
}

/// When a mode is good enough: its error over its value, for one known from the state before and for one found afresh.
const TRACKED: f64 = 0.25;
const AFRESH: f64 = 0.02;
/// The same in units of q1, near an instability.
const NEAR_ZERO: f64 = 1e-4;
/// How much better than that modes on the coarse mesh must be, so that the fine one finds them good enough.
const REFINED: f64 = 0.4;

impl Tracker {
    /// Knows nothing yet; `rng` gives the random directions.
    pub fn new(rng: Pcg64) -> Self {
        Self { modes: Vec::new(), rng, coarse: None }
    }

    /// The same, looking for modes on `coarse` first, a mesh of the same flat cell, with the constant `stiffness` k of its
    /// preconditioner (E* per length). The fine mesh then measures their eigenvalue, an upper bound, and its error by one product, and
    /// goes on from there only if that is too large.
    pub fn with_coarse(self, coarse: System, stiffness: f64) -> Self {
        let coarse = Coarse { preconditioner: Preconditioner::new(&coarse, stiffness), ws: coarse.workspace(), system: coarse };
        Self { coarse: Some(coarse), ..self }
    }

    /// Transforms on the coarse mesh spent.
    pub fn coarse_transforms(&self) -> usize {
        self.coarse.as_ref().map_or(0, |coarse| coarse.ws.transforms)
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
        let known = std::mem::take(&mut self.modes);
        let relative = if known.is_empty() { AFRESH } else { TRACKED };
        let mut fine = Place { system, removed: sliding_basis(system, z, slides, ws), preconditioner, ws };
        let Some(coarse) = &mut self.coarse else {
            let found = fine.softest(known, &mut self.rng, relative, cancel);
            self.modes = found.vectors;
            return (Stiffness { value: found.values[0], error: found.residual }, self.modes[0].clone());
        };
        let rough = coarse.at(z, slides, &fine).softest(known, &mut self.rng, REFINED * relative, cancel);
        let up = |mode: &Vec<f64>| carried(mode, &coarse.system, system);
        let (stiffness, mode) = fine.measured(up(&rough.vectors[0]));
        if stiffness.error <= fine.goal(relative, stiffness.value) || cancel.requested() {
            self.modes = rough.vectors;
            return (stiffness, mode);
        }
        let found = fine.softest(rough.vectors.iter().map(up).collect(), &mut self.rng, relative, cancel);
        self.modes = found.vectors.iter().map(|mode| carried(mode, system, &coarse.system)).collect();
        (Stiffness { value: found.values[0], error: found.residual }, found.vectors[0].clone())
    }
}

impl Coarse {
    /// The state `z` of `fine` without its shortest waves.
    fn at(&mut self, z: &[f64], slides: Slides, fine: &Place<'_>) -> Place<'_> {
        let Self { system, preconditioner, ws } = self;
        let z = carried(z, fine.system, system);
        let u0 = fine.ws.gap.mean().unwrap_or(f64::NAN);
        system.evaluate(&z, u0, &mut vec![0.0; z.len()], ws);
        preconditioner.refresh(system, ws);
        Place { removed: sliding_basis(system, &z, slides, ws), system, preconditioner, ws }
    }
}

impl Place<'_> {
    /// The error that a mode of this value may have.
    fn goal(&self, relative: f64, value: f64) -> f64 {
        (relative * value.abs()).max(NEAR_ZERO * self.system.grid().q1())
    }

    /// The softest modes, from the `known` ones of the state before or from random vectors.
    fn softest(&mut self, known: Vec<Vec<f64>>, rng: &mut Pcg64, relative: f64, cancel: &Cancel) -> EigenPairs {
        let Self { system, removed, preconditioner, ws } = self;
        let (strangers, least, most) = if known.is_empty() { (6, 8, 80) } else { (1, 1, 12) };
        let mut start = known;
        start.extend((0..strangers).map(|_| random_smooth(system, rng)));
        let limits = EigenLimits { pairs: 2, least, most, relative, absolute: NEAR_ZERO * system.grid().q1() };
        let precondition = |r: &[f64], out: &mut [f64]| {
            preconditioner.apply(r, out);
            // Amplitudes that belong to no real field have elastic energy alone. In deep compression that is less than any real mode
            // has, and they would grow out of the rounding.
            system.make_real(out);
        };
        smallest(|v, out| system.hessian(v, out, ws), start, removed, precondition, limits, cancel)
    }

    /// The eigenvalue of a `mode`, its error, and the mode normalised.
    fn measured(&mut self, mut mode: Vec<f64>) -> (Stiffness, Vec<f64>) {
        project_out(&mut mode, &self.removed);
        let length = norm(&mode);
        scale(&mut mode, 1.0 / length);
        let mut image = vec![0.0; mode.len()];
        self.system.hessian(&mode, &mut image, self.ws);
        let value = dot(&mode, &image);
        add(&mut image, -value, &mode);
        project_out(&mut image, &self.removed);
        (Stiffness { value, error: norm(&image) }, mode)
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
