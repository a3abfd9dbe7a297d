//! Newton-Krylov: the nearest equilibrium to a good guess, refused wherever the Hessian is seen to have negative curvature.

use super::problem::{Problem, Slides};
use crate::numerics::cancel::Cancel;
use crate::numerics::krylov::{CgEnd, CgLimits, CgSolution, conjugate_gradients};
use crate::numerics::vector::{add, dot, norm, orthonormalise, project_out};
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
    /// Loosest linear solve of [`descend`], residual over right-hand side.
    pub forcing: f64,
}

impl Default for NewtonLimits {
    fn default() -> Self {
        Self { tolerance: 1e-6, steps: 10, products: 80, forcing: 0.1 }
    }
}

impl NewtonLimits {
    /// What can be asked for in the system's precision.
    pub fn of(system: &System) -> Self {
        Self { tolerance: system.precision().tolerance(), ..Self::default() }
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
/// Where patterns slide freely those directions are left out of the steps (not out of the residual).
pub fn solve(
    problem: &Problem<'_>,
    mut z: Vec<f64>,
    u0: f64,
    limits: NewtonLimits,
    ws: &mut Workspace,
    cancel: &Cancel,
) -> NewtonState {
    let Problem { system, preconditioner, slides } = *problem;
    let scale = system.law().traction_max();
    // Below it there is nothing but rounding to follow: whoever asks for less is told where it ends.
    let goal = limits.tolerance.max(system.precision().floor());
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
        if force <= goal * scale * 0.5 || step == limits.steps || force > 3.0 * before {
            let residual = system.residual(&g, ws);
            if residual <= limits.tolerance {
                return end(NewtonEnd::Converged, residual, z);
            }
            if step == limits.steps || force > 3.0 * before || force > 0.5 * before && force < goal * scale {
                return end(NewtonEnd::Stalled, residual, z);
            }
        }
        let removed = sliding_basis(system, &z, slides, ws);
        project_out(&mut g, &removed);
        let forcing = (0.15 * goal * scale / force).max((0.3 * force / scale).min(0.1)).min(0.3);
        let cg = CgLimits { tolerance: forcing, products: limits.products };
        let CgSolution { x: dz, end: cg_end, .. } = conjugate_gradients(
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

/// Descends to a minimum at `u0` from anywhere by Newton steps within a trust region: where the curvature is negative it goes to the
/// region's edge along that direction (T. Steihaug, SIAM J. Numer. Anal. 20, 626 (1983)). The energy never rises, no step is longer
/// than `radius` (root mean square, length). Leaves the workspace evaluated at the result.
pub fn descend(
    problem: &Problem<'_>,
    mut z: Vec<f64>,
    u0: f64,
    radius: f64,
    limits: NewtonLimits,
    ws: &mut Workspace,
    cancel: &Cancel,
) -> NewtonState {
    let system = problem.system;
    let (scale, rounding) = (system.law().traction_max(), system.precision().rounding() * system.law().surface_energy);
    let mut g = vec![0.0; z.len()];
    let mut at = system.evaluate(&z, u0, &mut g, ws);
    let mut reach = radius;
    for step in 0..=limits.steps {
        let force = norm(&g);
        let residual = system.residual(&g, ws);
        let end = match residual <= limits.tolerance {
            true => Some(NewtonEnd::Converged),
            false if cancel.requested() => Some(NewtonEnd::Cancelled),
            false if step == limits.steps || !residual.is_finite() || reach < 1e-9 * radius => Some(NewtonEnd::Stalled),
            false => None,
        };
        if let Some(end) = end {
            return NewtonState { z, at, residual, steps: step, end };
        }
        let removed = sliding_basis(system, &z, problem.slides, ws);
        let cg = CgLimits { tolerance: (force / scale).sqrt().clamp(1e-4, limits.forcing), products: limits.products };
        let apply = |v: &[f64], out: &mut [f64]| system.hessian(v, out, ws);
        let found = conjugate_gradients(apply, &g, |r, out| problem.preconditioner.apply(r, out), &removed, cg, cancel);
        let mut dz = found.x;
        if found.end == CgEnd::NegativeCurvature {
            // To the edge: |x + t p| = reach.
            let (pp, xp, xx) = (dot(&found.direction, &found.direction), dot(&dz, &found.direction), dot(&dz, &dz));
            let t = (-xp + (xp * xp + pp * (reach * reach - xx).max(0.0)).sqrt()) / pp;
            add(&mut dz, t, &found.direction);
        }
        let length = norm(&dz);
        let share = (reach / length).min(1.0);
        let mut trial = z.clone();
        add(&mut trial, -share, &dz);
        let mut trial_g = vec![0.0; z.len()];
        let trial_at = system.evaluate(&trial, u0, &mut trial_g, ws);
        let lower = trial_at.energy < at.energy - rounding || trial_at.energy <= at.energy + rounding && norm(&trial_g) < force;
        if lower {
            (z, g, at) = (trial, trial_g, trial_at);
            reach = (2.0 * reach).min(radius);
        } else {
            reach = 0.25 * share * length;
            system.evaluate(&z, u0, &mut g, ws);
        }
    }
    unreachable!("the last step returns")
}

/// Sliding modes softer than this (E*/L) are free; the flat state's softest mode has pi where nothing attracts. With five times as much a
/// line of 16 points at mu_rho = 0.75 shows one of its 18 jumps of the mesh too few.
const PINNED: f64 = 0.02;

/// Orthonormal basis of the directions in which the pattern of `z` slides; none for a flat surface, one for a ridge. `ws` must be
/// evaluated at the state where it depends on the mesh's pinning.
pub fn sliding_basis(system: &System, z: &[f64], slides: Slides, ws: &mut Workspace) -> Vec<Vec<f64>> {
    if slides == Slides::Never {
        return Vec::new();
    }
    // A ridge carries a trace of its softest modulation, whose derivative is that modulation moved by a quarter wave: taken for a
    // sliding mode it would hide the coming instability.
    let weakest = 1e-3 * system.grid().q1() * norm(z);
    let modes = system.sliding_modes(z).into_iter().filter(|m| norm(m) > weakest).collect();
    let mut basis = orthonormalise(modes, 1e-6);
    if slides == Slides::UnlessPinned {
        let mut image = vec![0.0; z.len()];
        basis.retain(|mode| {
            system.hessian(mode, &mut image, ws);
            (dot(mode, &image) * system.grid().length).abs() < PINNED
        });
    }
    basis
}

/// `z` moved by less than a mesh spacing so that the pattern's centre lies, along each axis, on a mesh point or `between` two. There the
/// mesh's own weak pinning vanishes by symmetry; elsewhere it would keep the residual from converging.
pub fn centred(system: &System, z: &[f64], between: [bool; 2]) -> Vec<f64> {
    let half = between.map(|between| if between { 0.5 } else { 0.0 });
    placed(system, z, |axis, x0| (x0 - half[axis]).round() + half[axis])
}

/// `z` moved to the nearest such place of all.
pub(super) fn held(system: &System, z: &[f64]) -> Vec<f64> {
    placed(system, z, |_, x0| 0.5 * (2.0 * x0).round())
}

/// `z` moved along each axis from where its centre lies (mesh spacings) to where that is wanted.
fn placed(system: &System, z: &[f64], wanted: impl Fn(usize, f64) -> f64) -> Vec<f64> {
    let grid = system.grid();
    let slides = system.slides_along();
    let shift = |axis: usize, pair: usize| {
        let (re, im) = (z[2 * pair], z[2 * pair + 1]);
        if !slides[axis] || re.hypot(im) < 1e-3 * norm(z) {
            return 0.0;
        }
        // u_q ~ e^{-i q x0}: the pattern's centre (or anti-centre) is x0.
        let x0 = -im.atan2(re) / grid.q1() / grid.spacing();
        (wanted(axis, x0) - x0) * grid.spacing()
    };
    system.moved(z, shift(0, grid.ny), shift(1, 1))
}
