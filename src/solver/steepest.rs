//! The path of steepest descent from a saddle to a minimum: dz/dt = -dV/dz at fixed control, in the
//! metric of the root mean square of the displacement.
//!
//! Each step is the minimum of V + |z - z_k|^2/(2 tau), the implicit Euler step: whatever the
//! stiffness of the shortest waves the energy falls with every step, and long steps near the end
//! are those of Newton's method.

use super::Lost;
use super::branch::distance;
use super::mechanics::Mechanics;
use super::newton::{NewtonEnd, NewtonLimits, solve};
use crate::numerics::dense::{add, norm};
use crate::numerics::krylov::{CgEnd, CgLimits, conjugate_gradients};
use crate::physics::system::Evaluation;

/// First step off the saddle along its mode (ranges): there the path is that mode up to the square
/// of it. It is cut by four until the energy falls, where the saddle is about to vanish.
const FIRST: f64 = 1e-3;
const CUT: f64 = 0.25;
const CUTS: usize = 8;
/// Growth of the steps, and the longest (ranges): an implicit Euler step of length h errs by less
/// than h^2 over the path's radius of curvature.
const GROWTH: f64 = 1.3;
const LONGEST: f64 = 0.05;
/// Most steps: a path of a hundred ranges, longer than any well is deep.
const STEPS: usize = 4000;
/// Newton iterations of one step, its products, and the share of the force it may miss.
const ITERATIONS: usize = 6;
const PRODUCTS: usize = 40;
const MISSED: f64 = 1e-2;
/// Share of the step asked for below which a minimum is near, and Newton's method may finish within
/// a few such steps.
const NEAR: f64 = 0.6;
const WITHIN: f64 = 3.0;

/// Goes down from the saddle along its `mode` (norm 1, the way it points) to the minimum, or to the
/// saddle of another symmetry, where that leads. `observe` hears of every place with its arc length
/// from the saddle (length), the end included, and says whether to go on.
///
/// # Errors
/// No end was found within a hundred ranges, the energy does not fall along the mode, or somebody
/// asked to stop.
pub fn descend(
    mechanics: &mut Mechanics,
    saddle: &Evaluation,
    mode: &[f64],
    observe: &mut dyn FnMut(&Evaluation, f64) -> bool,
) -> Result<Evaluation, Lost> {
    let range = mechanics.system.law().range;
    let mut step = FIRST * range;
    let mut at = off(mechanics, saddle, mode, &mut step)?;
    let mut arc = step;
    let mut goes_on = observe(&at, arc);
    for _ in 0..STEPS {
        if !goes_on {
            return Ok(at);
        }
        if mechanics.cancel.requested() {
            return Err(Lost::Cancelled);
        }
        mechanics.refresh(&at.fields);
        let rate = norm(&at.gradient) / step;
        let Some(next) = implicit(mechanics, &at, rate) else {
            step *= CUT;
            if step < f64::EPSILON * range {
                return Err(Lost::Gone);
            }
            continue;
        };
        let moved = distance(&next.state.amplitudes, &at.state.amplitudes);
        at = next;
        arc += moved;
        goes_on = observe(&at, arc);
        if moved < NEAR * step
            && let Some(end) = settled(mechanics, &at, WITHIN * step)?
        {
            arc += distance(&end.state.amplitudes, &at.state.amplitudes);
            observe(&end, arc);
            return Ok(end);
        }
        step = (GROWTH * step).min(LONGEST * range);
    }
    Err(Lost::Gone)
}

/// The first place off the saddle, `step` away, which is cut until the energy falls.
fn off(
    mechanics: &mut Mechanics,
    saddle: &Evaluation,
    mode: &[f64],
    step: &mut f64,
) -> Result<Evaluation, Lost> {
    let mut at = saddle.clone();
    for _ in 0..CUTS {
        at.state
            .amplitudes
            .copy_from_slice(&saddle.state.amplitudes);
        add(&mut at.state.amplitudes, *step, mode);
        mechanics.update(&mut at);
        if at.state.energy < saddle.state.energy {
            return Ok(at);
        }
        *step *= CUT;
    }
    Err(Lost::Gone)
}

/// The minimum of V + rate |z - z_k|^2/2 next to z_k, if Newton's method finds one below it.
fn implicit(mechanics: &mut Mechanics, from: &Evaluation, rate: f64) -> Option<Evaluation> {
    let goal = MISSED * norm(&from.gradient);
    let mut at = from.clone();
    for _ in 0..ITERATIONS {
        let mut force = at.gradient.clone();
        add(&mut force, rate, &at.state.amplitudes);
        add(&mut force, -rate, &from.state.amplitudes);
        if norm(&force) <= goal {
            return (at.state.energy < from.state.energy).then_some(at);
        }
        let Mechanics {
            system,
            preconditioner,
            workspace,
            cancel,
            ..
        } = &mut *mechanics;
        let apply = |v: &[f64], out: &mut [f64]| {
            system.hessian(&at.fields, v, out, workspace);
            add(out, rate, v);
        };
        let softness = preconditioner.diagonal();
        let precondition = |r: &[f64], out: &mut [f64]| {
            for ((out, r), m) in out.iter_mut().zip(r).zip(softness) {
                *out = r * m / (1.0 + rate * m);
            }
        };
        let limits = CgLimits::new(MISSED, PRODUCTS);
        let found = conjugate_gradients(apply, &force, precondition, &[], limits, cancel);
        if !matches!(found.end, CgEnd::Converged | CgEnd::Budget) {
            return None;
        }
        add(&mut at.state.amplitudes, -1.0, &found.x);
        mechanics.update(&mut at);
    }
    None
}

/// The equilibrium that Newton's method finds no further away than `within` and no higher.
fn settled(
    mechanics: &mut Mechanics,
    at: &Evaluation,
    within: f64,
) -> Result<Option<Evaluation>, Lost> {
    let state = &at.state;
    let limits = NewtonLimits::of(&mechanics.system);
    let found = solve(mechanics, state.amplitudes.clone(), state.control, limits);
    let rounding = mechanics.system.precision().rounding() * mechanics.system.law().surface_energy;
    let near = distance(&found.at.state.amplitudes, &state.amplitudes) < within
        && found.at.state.energy <= state.energy + rounding;
    match found.end {
        NewtonEnd::Cancelled => Err(Lost::Cancelled),
        NewtonEnd::Converged if near => Ok(Some(found.at)),
        _ => Ok(None),
    }
}
