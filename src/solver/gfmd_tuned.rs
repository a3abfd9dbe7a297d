//! GFMD at its best: the same damped dynamics, from a predicted start, with the largest safe time
//! step, until it has relaxed.
//!
//! In place of a thermostat each increment begins with one tiny random push, so that a state that
//! has lost its stability is left even where it is perfectly symmetric. The method goes wherever
//! the dynamics goes: it locates nothing.

use super::Lost;
use super::Stop;
use super::branch::History;
use super::descent::{stiffest, tractions};
use super::equilibrium::{Cost, Equilibrium};
use super::mechanics::{Mechanics, Slides};
use super::method::{Method, predicted};
use super::newton::centred;
use super::stability::random_smooth;
use crate::numerics::vector::{add, norm, project_out, scale};
use rand::SeedableRng;
use rand_pcg::Pcg64;

/// Time steps after which an increment is given up. Tens are normal; a jump takes hundreds.
const BUDGET: usize = 1000;
/// Time step over its limit 2/sqrt(stiffest eigenvalue).
const TIME_STEP: f64 = 0.75;
/// Damping rate in units of the frequency of a free wave.
const DAMPING: f64 = 0.5;
/// Largest root mean square step of the surface, in ranges: in a jump an overshoot into the wall of
/// the law would be the end of it.
const STEP_MAX: f64 = 0.05;
/// Time steps after which the sliding directions are asked for again.
const RECENTRE: usize = 50;
/// Root mean square push at the start of an increment, in ranges: well above what the tolerance
/// cannot see, well below any pattern.
const PUSH: f64 = 1e-4;

/// Mass-weighted dynamics, tuned.
#[derive(Clone, Debug)]
pub struct GfmdTuned {
    rng: Pcg64,
}

impl GfmdTuned {
    /// Pushes from `seed`.
    pub fn new(seed: u64) -> Self {
        Self {
            rng: Pcg64::seed_from_u64(seed),
        }
    }
}

impl Method for GfmdTuned {
    fn name(&self) -> &'static str {
        "tuned GFMD"
    }

    fn locates(&self) -> bool {
        false
    }

    fn follow(
        &mut self,
        mechanics: &mut Mechanics,
        branch: &History,
        from: &Equilibrium,
        u0: f64,
    ) -> Result<Equilibrium, Lost> {
        let before = mechanics.transforms();
        let (law, tolerance) = (
            *mechanics.system.law(),
            mechanics.system.precision().tolerance(),
        );
        let guess = predicted(mechanics, branch, from, u0);
        let mut at = mechanics.at(guess, u0);
        let mut slides = mechanics.sliding_basis(&at.state.amplitudes, &at.fields);
        let mut push = random_smooth(&mechanics.system, &mut self.rng);
        project_out(&mut push, &slides);
        add(
            &mut at.state.amplitudes,
            PUSH * law.range / norm(&push),
            &push,
        );
        let mut velocity = vec![0.0; push.len()];
        for step in 0.. {
            if mechanics.cancel.requested() {
                return Err(Lost::Cancelled);
            }
            mechanics.update(&mut at);
            let force = norm(&at.gradient);
            if !(force.is_finite() && at.state.energy.is_finite()) {
                return Err(Lost::Diverged("a jump overshot into the wall of the law"));
            }
            // The mean square is a lower bound of the largest residual: only then the exact one is
            // worth a transform.
            let goal = 0.5 * tolerance * tractions(&law, &at.fields);
            let near = force <= goal;
            if near || step == BUDGET {
                let residual = mechanics.residual(&at);
                if residual <= tolerance || step == BUDGET {
                    let stop = if residual <= tolerance {
                        Stop::Stable
                    } else {
                        Stop::NotConverged
                    };
                    let cost = Cost {
                        iterations: step,
                        transforms: mechanics.transforms() - before,
                    };
                    return Ok(Equilibrium::unmeasured(at, residual, stop, cost));
                }
            }
            if step % RECENTRE == 0 {
                // Along them a pattern would creep for ever: the mesh holds it with next to
                // nothing.
                slides = mechanics.sliding_basis(&at.state.amplitudes, &at.fields);
            }
            project_out(&mut at.gradient, &slides);
            if !near && mechanics.slides != Slides::Never && norm(&at.gradient) <= 0.1 * goal {
                // All that is left is the mesh's pull on a pattern between its points.
                at.state.amplitudes = centred(&mechanics.system, &at.state.amplitudes, [false; 2]);
                velocity.fill(0.0);
                continue;
            }
            let dt = TIME_STEP * 2.0 / stiffest(mechanics, &at.fields).sqrt();
            let keep = 1.0 - DAMPING * dt.min(1.0);
            for ((v, g), m) in velocity
                .iter_mut()
                .zip(&at.gradient)
                .zip(mechanics.preconditioner.diagonal())
            {
                *v = keep * *v - dt * m * g;
            }
            let moved = dt * norm(&velocity) / (STEP_MAX * law.range);
            if moved > 1.0 {
                scale(&mut velocity, 1.0 / moved);
            }
            add(&mut at.state.amplitudes, dt, &velocity);
        }
        unreachable!("the last step returns")
    }
}
