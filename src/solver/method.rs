//! The one interface behind which every relaxation method stands.

use super::branch::{History, distance};
use super::equilibrium::{Cost, Equilibrium};
use super::equilibrium::{Lost, Stop};
use super::mechanics::Mechanics;
use super::newton::{NewtonEnd, NewtonLimits, held, solve};
use crate::physics::control::Control;
use crate::physics::system::{State, System};

/// Carries a state from one value of the control to a near one.
pub trait Method: Send {
    /// Its name on the screen and in the tables.
    fn name(&self) -> &'static str;

    /// True if a failed increment may be cut into smaller ones to find out where the branch ends;
    /// false for a method with a fixed budget per increment, which simply goes where it goes.
    fn locates(&self) -> bool;

    /// From the newest state of `branch` to where the control is `control`. The stability of the
    /// result is not measured yet.
    ///
    /// `Ok` is a state within tolerance, or (for a method that does not locate) whatever its budget
    /// gave. `Err` says that the branch was lost.
    fn follow(
        &mut self,
        mechanics: &mut Mechanics,
        branch: &History,
        from: &Equilibrium,
        control: f64,
    ) -> Result<Equilibrium, Lost>;
}

/// Newton-Krylov from an extrapolated guess, accepted only if it is the continuation of the branch.
#[derive(Clone, Copy, Debug)]
pub struct NewtonKrylov;

/// Largest deviation from the prediction, in units of the predicted change: beyond it Newton has
/// found some other branch.
const STRAY: f64 = 0.6;
/// How much of a state, in ranges, the residual may leave undecided along the softest mode. Close
/// to where that loses its stiffness the usual residual leaves a hundredth and more, which reads as
/// straying from the branch.
const UNDECIDED: f64 = 3e-5;
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
        let mut found = solve(
            mechanics,
            guess.clone(),
            control,
            limits(&mechanics.system, from),
        );
        // No sharper than usual, and still that.
        if found.end != NewtonEnd::Stalled
            || !(found.residual <= mechanics.system.precision().tolerance())
        {
            found = found.converged()?;
        }
        let strayed = distance(&guess, &found.at.state.amplitudes) > reach;
        if strayed || !audit(&mechanics.system, &from.state, &found.at.state) {
            return Err(Lost::Gone);
        }
        let cost = Cost {
            iterations: found.steps,
            transforms: mechanics.transforms() - before,
        };
        Ok(Equilibrium::unmeasured(
            found.at,
            found.residual,
            Stop::Stable,
            cost,
        ))
    }
}

/// What to ask for next to the state `from`: a residual that leaves less than [`UNDECIDED`] open
/// along its softest mode.
fn limits(system: &System, from: &Equilibrium) -> NewtonLimits {
    let usual = NewtonLimits::of(system);
    let softest = from
        .stiffness_min
        .map_or(f64::INFINITY, |stiffness| stiffness.value.abs());
    let decided = UNDECIDED * system.law().range * softest / system.law().traction_max();
    NewtonLimits {
        tolerance: decided.min(usual.tolerance).max(SHARPEST * usual.tolerance),
        ..usual
    }
}

/// The branch's extrapolation to where the control is `control`; where it has none, the state it
/// stands on.
pub(crate) fn predicted(
    mechanics: &mut Mechanics,
    branch: &History,
    from: &Equilibrium,
    control: f64,
) -> Vec<f64> {
    let Some(mut guess) = branch.predict(control) else {
        return from.state.amplitudes.clone();
    };
    // Nothing corrects what no real field has: extrapolated again and again it would grow.
    mechanics.system.make_real(&mut guess);
    // Nothing but symmetry holds a pattern in its place: extrapolated round-off would make it drift
    // off.
    let slides = !mechanics
        .sliding_basis(&from.state.amplitudes, &from.fields)
        .is_empty();
    if slides {
        held(&mechanics.system, &guess)
    } else {
        guess
    }
}

/// How far (root mean square, length) from its prediction a state may be and still continue the
/// branch.
///
/// Without a second state there is no prediction to stray from; the audit alone decides. Where the
/// branch is soft, a residual within tolerance leaves a thousandth of a range undecided.
pub(super) fn reach(system: &System, from: &State, guess: &[f64], control: f64) -> f64 {
    let change = distance(guess, &from.amplitudes);
    if change == 0.0 {
        return f64::INFINITY;
    }
    let step = (control - from.control).abs();
    let moved = if system.control() == Control::Load {
        step * system.law().range / system.law().traction_max()
    } else {
        step
    };
    STRAY * change + 0.1 * moved + 1e-3 * system.law().range
}

/// What a trapezoid may miss of the energy, over |d stress| |du0|: towards a fold, where the stress
/// falls off like a square root, it is 1/6 over the whole rest of the way, .09 over nine tenths of
/// it and .03 over half. A jump may hide behind what is allowed.
const SMOOTH: f64 = 0.05;

/// The energy audit: along a smooth branch dV = stress du0, and so for other controls. A step
/// across a jump pays with energy and is found out.
pub(crate) fn audit(system: &System, from: &State, to: &State) -> bool {
    let (control, law) = (system.control(), system.law());
    let conjugate = |of: &State| control.conjugate(of.mean_displacement, of.stress);
    let scale = if control == Control::Load {
        law.range
    } else {
        law.traction_max()
    };
    let step = to.control - from.control;
    let (before, after) = (conjugate(from), conjugate(to));
    let missing = (to.energy - from.energy - 0.5 * (after + before) * step).abs();
    let smooth = SMOOTH * (after - before).abs() + 1e-3 * scale;
    missing
        <= smooth * step.abs()
            + system.precision().rounding().max(1e-12) * system.law().surface_energy
}
