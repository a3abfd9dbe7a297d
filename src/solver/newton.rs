//! Newton-Krylov: the nearest equilibrium to a good guess, refused wherever the Hessian is seen to
//! have negative curvature.

use super::mechanics::Mechanics;
use super::method::{Equilibrium, History, Lost, Method, audit, distance, predicted, reach};
use crate::numerics::dense::{add, norm, project_out};
use crate::numerics::krylov::{CgEnd, CgLimits, CgSolution};
use crate::physics::system::{Evaluation, System};

/// What [`solve`] and [`descend`] aim at, and how long they may take.
#[derive(Clone, Copy, Debug)]
pub struct NewtonLimits {
    /// Goal for the residual.
    pub tolerance: f64,
    /// Which residual.
    pub residual: Residual,
    /// Most Newton steps.
    pub steps: usize,
    /// Most Hessian products in one step.
    pub products: usize,
    /// Loosest linear solve of [`descend`], residual over right-hand side.
    pub forcing: f64,
    /// Step of [`solve`] from which on each makes the preconditioner anew; that of the guess, or of
    /// the state before, serves until then.
    pub refresh: usize,
}

/// Which residual tells that an equilibrium is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Residual {
    /// max |residual traction| / max(sigma_max, max |traction|): the evidence for a state that is
    /// shown. One transform.
    Largest,
    /// The root mean square over sigma_max. No transform.
    Mean,
}

impl Default for NewtonLimits {
    fn default() -> Self {
        Self {
            tolerance: 1e-6,
            residual: Residual::Largest,
            steps: 10,
            products: 80,
            forcing: 0.1,
            refresh: usize::MAX,
        }
    }
}

impl NewtonLimits {
    /// What can be asked for in the system's precision.
    pub fn of(system: &System) -> Self {
        Self {
            tolerance: system.precision().tolerance(),
            ..Self::default()
        }
    }
}

/// Where [`solve`] or [`descend`] ended.
#[derive(Clone, Debug)]
pub struct NewtonState {
    /// The surface, evaluated.
    pub at: Evaluation,
    /// The residual there; NaN where it was not measured.
    pub residual: f64,
    /// Newton steps.
    pub steps: usize,
    /// Converged; or the Hessian is not positive definite here, so that no minimum is near
    /// ([`Lost::Unstable`]), or it gets no closer, or is not finite ([`Lost::Gone`]).
    pub end: Result<(), Lost>,
}

impl NewtonState {
    /// The state if it is an equilibrium.
    ///
    /// # Errors
    /// Why it is none.
    pub fn converged(self) -> Result<Self, Lost> {
        self.end.map(|()| self)
    }
}

/// Solves for equilibrium where the control is `control` from the guess `z`.
///
/// Where patterns slide freely those directions are left out of the steps (not out of the
/// residual).
pub fn solve(
    mechanics: &mut Mechanics,
    z: Vec<f64>,
    control: f64,
    limits: NewtonLimits,
) -> NewtonState {
    let scale = mechanics.system.law().traction_max();
    // Root mean square force at which it may be an equilibrium. It is a lower bound of the largest
    // residual: only then the exact one is worth a transform. Below the floor of the precision
    // there is nothing but rounding to follow: whoever asks for less is told where it ends.
    let goal = scale
        * match limits.residual {
            Residual::Largest => 0.5 * limits.tolerance.max(mechanics.system.precision().floor()),
            Residual::Mean => limits.tolerance,
        };
    let mut at = mechanics.at(z, control);
    let mut force = norm(&at.gradient);
    let mut before = f64::INFINITY;
    for step in 0..=limits.steps {
        let end = |end, residual, at| NewtonState {
            at,
            residual,
            steps: step,
            end,
        };
        if !force.is_finite() || !at.state.energy.is_finite() {
            return end(Err(Lost::Gone), f64::NAN, at);
        }
        let diverges = force > 3.0 * before;
        if force <= goal || step == limits.steps || diverges {
            let residual = match limits.residual {
                Residual::Largest => mechanics.residual(&at),
                Residual::Mean => force / scale,
            };
            if residual <= limits.tolerance {
                return end(Ok(()), residual, at);
            }
            if step == limits.steps || diverges || force > 0.5 * before && force < 2.0 * goal {
                return end(Err(Lost::Gone), residual, at);
            }
        }
        if step >= limits.refresh {
            mechanics.refresh(&at.fields);
        }
        let removed = mechanics.sliding_basis(&at.state.amplitudes, &at.fields);
        let mut push = at.gradient.clone();
        project_out(&mut push, &removed);
        // Quadratic convergence wants it to fall with the force; less than what is left to the goal
        // is wasted.
        let forcing = (0.3 * goal / force).max((force / scale).min(0.1)).min(0.3);
        let cg = CgLimits::new(forcing, limits.products);
        let CgSolution { x: dz, end: cg_end } =
            mechanics.solve_linear(&at.fields, &push, &removed, cg);
        if let Err(lost) = downhill(cg_end) {
            return end(Err(lost), f64::NAN, at);
        }
        before = force;
        // A step that leaves the domain of the law (a Mie law at zero gap) is shortened, never
        // taken.
        let z = at.state.amplitudes.clone();
        let mut length = 1.0;
        loop {
            at.state.amplitudes.copy_from_slice(&z);
            add(&mut at.state.amplitudes, -length, &dz);
            mechanics.update(&mut at);
            force = norm(&at.gradient);
            if at.state.energy.is_finite() && force.is_finite() || length < 0.02 {
                break;
            }
            length *= 0.25;
        }
    }
    unreachable!("the last step returns")
}

/// Whether the solution of a linear solve that ended so is of use.
pub(super) fn downhill(end: CgEnd) -> Result<(), Lost> {
    match end {
        CgEnd::NegativeCurvature => Err(Lost::Unstable),
        CgEnd::Cancelled => Err(Lost::Cancelled),
        CgEnd::Converged | CgEnd::Edge | CgEnd::Budget => Ok(()),
    }
}

/// Descends to a minimum at a fixed control from anywhere by Newton steps within a trust region, on
/// whose edge their linear solves end. The energy never rises, no step is longer than `radius`
/// (root mean square, length).
pub fn descend(
    mechanics: &mut Mechanics,
    z: Vec<f64>,
    control: f64,
    radius: f64,
    limits: NewtonLimits,
) -> NewtonState {
    let (law, precision) = (*mechanics.system.law(), mechanics.system.precision());
    let scale = law.traction_max();
    let mut at = mechanics.at(z, control);
    let mut trial = at.clone();
    let mut reach = radius;
    for step in 0..=limits.steps {
        let force = norm(&at.gradient);
        let gives_up = step == limits.steps || !force.is_finite() || reach < 1e-9 * radius;
        // The mean is a lower bound of the largest: only then the exact one is worth a transform.
        let residual = if gives_up || force <= limits.tolerance * scale {
            mechanics.residual(&at)
        } else {
            f64::NAN
        };
        let end = if residual <= limits.tolerance {
            Some(Ok(()))
        } else if mechanics.cancel.requested() {
            Some(Err(Lost::Cancelled))
        } else {
            gives_up.then_some(Err(Lost::Gone))
        };
        if let Some(end) = end {
            return NewtonState {
                at,
                residual,
                steps: step,
                end,
            };
        }
        let removed = mechanics.sliding_basis(&at.state.amplitudes, &at.fields);
        let cg = CgLimits {
            tolerance: (force / scale).sqrt().clamp(1e-4, limits.forcing),
            products: limits.products,
            radius: reach,
        };
        let dz = mechanics
            .solve_linear(&at.fields, &at.gradient, &removed, cg)
            .x;
        trial.state.amplitudes.copy_from_slice(&at.state.amplitudes);
        add(&mut trial.state.amplitudes, -1.0, &dz);
        mechanics.update(&mut trial);
        let (before, after) = (at.state.energy, trial.state.energy);
        let rounding = precision.rounding() * law.surface_energy.max(before.abs());
        if after < before - rounding || after <= before + rounding && norm(&trial.gradient) < force
        {
            std::mem::swap(&mut at, &mut trial);
            reach = (2.0 * reach).min(radius);
        } else {
            reach = 0.25 * norm(&dz);
        }
    }
    unreachable!("the last step returns")
}

/// Newton-Krylov from an extrapolated guess, accepted only if it is the continuation of the branch.
#[derive(Clone, Copy, Debug)]
pub struct NewtonKrylov;

/// How much of a state, in ranges, the residual may leave undecided along the softest mode. Close
/// to where that loses its stiffness the usual residual leaves a hundredth and more, which reads as
/// straying from the branch.
const UNDECIDED: f64 = 3e-5;
/// The same in units of the step: towards the end of a branch steps are as short as it is to be
/// located.
const SHARE: f64 = 0.01;
/// The sharpest residual, as a share of the usual: below it patterns between mesh points labour on
/// the mesh's own pull.
const SHARPEST: f64 = 1e-4;

impl Method for NewtonKrylov {
    fn name(&self) -> &'static str {
        "Newton-Krylov"
    }

    fn locates(&self) -> bool {
        true
    }

    fn follow(
        &mut self,
        mechanics: &mut Mechanics,
        branch: &History,
        from: &Equilibrium,
        control: f64,
    ) -> Result<Equilibrium, Lost> {
        let before = mechanics.transforms();
        let guess = predicted(mechanics, branch, from, control);
        let reach = reach(&mechanics.system, &from.state, &guess, control);
        let limits = limits(&mechanics.system, from, control);
        let mut found = solve(mechanics, guess.clone(), control, limits);
        // No sharper than usual, and still that.
        if found.end != Err(Lost::Gone)
            || !(found.residual <= mechanics.system.precision().tolerance())
        {
            found = found.converged()?;
        }
        let strayed = distance(&guess, &found.at.state.amplitudes) > reach;
        if strayed || !audit(&mechanics.system, &from.state, &found.at.state) {
            return Err(Lost::Gone);
        }
        let NewtonState {
            at,
            residual,
            steps,
            ..
        } = found;
        Ok(Equilibrium::reached(mechanics, at, residual, steps, before))
    }
}

/// What to ask for next to the state `from` where the control is `control`: a residual that leaves
/// less than [`UNDECIDED`] open along its softest mode, and less than [`SHARE`] of the step.
fn limits(system: &System, from: &Equilibrium, control: f64) -> NewtonLimits {
    let usual = NewtonLimits::of(system);
    let softest = from
        .stiffness_min
        .map_or(f64::INFINITY, |stiffness| stiffness.value.abs());
    let step = (control - from.state.control).abs() / system.control().unit(system.law());
    let undecided = UNDECIDED.min(SHARE * step);
    let decided = undecided * system.law().range * softest / system.law().traction_max();
    NewtonLimits {
        tolerance: decided.min(usual.tolerance).max(SHARPEST * usual.tolerance),
        ..usual
    }
}
