//! Newton-Krylov: the nearest equilibrium to a good guess, refused wherever the Hessian is seen to have negative curvature.

use crate::numerics::cancel::Cancel;
use crate::numerics::krylov::{CgEnd, CgLimits, conjugate_gradients};
use crate::numerics::vector::{add, norm, project_out};
use crate::physics::preconditioner::Preconditioner;
use crate::physics::system::{Evaluation, System, Workspace};

/// Tolerances of [`solve`].
#[derive(Clone, Copy, Debug)]
pub struct NewtonLimits {
    /// Goal for max |residual traction| / max(sigma_max, max |traction|).
    pub tolerance: f64,
    /// Most Newton steps.
    pub steps: usize,
    /// Most Hessian products in one step.
    pub products: usize,
}

impl Default for NewtonLimits {
    fn default() -> Self {
        Self { tolerance: 1e-6, steps: 10, products: 80 }
    }
}

/// Why [`solve`] ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NewtonEnd {
    /// Residual below tolerance.
    Converged,
    /// The Hessian is not positive definite here: no minimum is near.
    NegativeCurvature,
    /// Not getting closer, or not finite.
    Stalled,
    /// Somebody asked to stop.
    Cancelled,
}

/// Where [`solve`] ended.
#[derive(Clone, Debug)]
pub struct NewtonState {
    /// Amplitudes.
    pub z: Vec<f64>,
    /// Energy and stress there.
    pub at: Evaluation,
    /// max |residual traction| / max(sigma_max, max |traction|) there.
    pub residual: f64,
    /// Newton steps.
    pub steps: usize,
    /// Why.
    pub end: NewtonEnd,
}

/// Solves for equilibrium at `u0` from the guess `z`. Leaves the workspace evaluated at the result.
///
/// `slides`: on flat ground patterns can slide freely; those directions are left out of the steps (not out of the residual).
pub fn solve(
    system: &System,
    mut z: Vec<f64>,
    u0: f64,
    preconditioner: &Preconditioner,
    slides: bool,
    limits: NewtonLimits,
    ws: &mut Workspace,
    cancel: &Cancel,
) -> NewtonState {
    let scale = system.law().traction_max();
    let mut g = vec![0.0; z.len()];
    let mut at = system.evaluate(&z, u0, &mut g, ws);
    let mut force = norm(&g);
    let mut before = f64::INFINITY;
    for step in 0..=limits.steps {
        let end = |end, residual, z| NewtonState { z, at, residual, steps: step, end };
        if !force.is_finite() || !at.energy.is_finite() {
            return end(NewtonEnd::Stalled, f64::NAN, z);
        }
        // The mean square is a lower bound of the largest residual: only then the exact one is worth a transform.
        if force <= limits.tolerance * scale * 0.5 || step == limits.steps || force > 3.0 * before {
            let residual = system.residual(&g, ws);
            if residual <= limits.tolerance {
                return end(NewtonEnd::Converged, residual, z);
            }
            if step == limits.steps || force > 3.0 * before || force > 0.5 * before && force < limits.tolerance * scale {
                return end(NewtonEnd::Stalled, residual, z);
            }
        }
        let removed = if slides { sliding_basis(system, &z) } else { Vec::new() };
        project_out(&mut g, &removed);
        let forcing = (0.15 * limits.tolerance * scale / force).max((0.3 * force / scale).min(0.1)).min(0.3);
        let cg = CgLimits { tolerance: forcing, products: limits.products };
        let (dz, cg_end) = conjugate_gradients(
            |v, out| system.hessian(v, out, ws),
            &g,
            |r, out| preconditioner.apply(r, out),
            &removed,
            cg,
            cancel,
        );
        match cg_end {
            CgEnd::Cancelled => return end(NewtonEnd::Cancelled, f64::NAN, z),
            CgEnd::NegativeCurvature => return end(NewtonEnd::NegativeCurvature, f64::NAN, z),
            CgEnd::Converged | CgEnd::Budget => {}
        }
        before = force;
        // A step that leaves the domain of the law (a Mie law at zero gap) is shortened, never taken.
        let mut length = 1.0;
        loop {
            let mut trial = z.clone();
            add(&mut trial, -length, &dz);
            at = system.evaluate(&trial, u0, &mut g, ws);
            force = norm(&g);
            if at.energy.is_finite() && force.is_finite() || length < 0.02 {
                z = trial;
                break;
            }
            length *= 0.25;
        }
    }
    unreachable!("the last step returns")
}

/// Orthonormal basis of the directions in which the pattern of `z` slides; none for a flat surface, one for a ridge.
pub fn sliding_basis(system: &System, z: &[f64]) -> Vec<Vec<f64>> {
    let weakest = 1e-7 * system.grid().q1() * norm(z);
    let modes = system.sliding_modes(z).into_iter().filter(|m| norm(m) > weakest).collect();
    crate::numerics::vector::orthonormalise(modes, 1e-6)
}
