//! GFMD at its best: the same damped dynamics, from a predicted start, with the largest safe time step, until it has relaxed.
//!
//! In place of a thermostat each increment begins with one tiny random push, so that a state that has lost its stability is left
//! even where it is perfectly symmetric. The method goes wherever the dynamics goes: it locates nothing.

use super::Stop;
use super::branch::History;
use super::descent::{stiffest, tractions};
use super::equilibrium::{Cost, Equilibrium};
use super::method::{Lost, Method, predicted};
use super::newton::{centred, sliding_basis};
use super::problem::{Problem, Slides};
use super::stability::random_smooth;
use crate::numerics::cancel::Cancel;
use crate::numerics::vector::{add, norm, project_out, scale};
use crate::physics::system::Workspace;
use rand::SeedableRng;
use rand_pcg::Pcg64;

/// Time steps after which an increment is given up. Tens are normal; a jump takes hundreds.
const BUDGET: usize = 1000;
/// Time step over its limit 2/sqrt(stiffest eigenvalue).
const TIME_STEP: f64 = 0.75;
/// Damping rate in units of the frequency of a free wave.
const DAMPING: f64 = 0.5;
/// Largest root mean square step of the surface, in ranges: in a jump an overshoot into the wall of the law would be the end of it.
const STEP_MAX: f64 = 0.05;
/// Time steps after which the sliding directions are asked for again.
const RECENTRE: usize = 50;
/// Root mean square push at the start of an increment, in ranges: well above what the tolerance cannot see, well below any pattern.
const PUSH: f64 = 1e-4;

/// Mass-weighted dynamics, tuned.
#[derive(Clone, Debug)]
pub struct GfmdTuned {
    rng: Pcg64,
}

impl GfmdTuned {
    /// Pushes from `seed`.
    pub fn new(seed: u64) -> Self {
        Self { rng: Pcg64::seed_from_u64(seed) }
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
        problem: &Problem<'_>,
        branch: &History,
        from: &Equilibrium,
        u0: f64,
        ws: &mut Workspace,
        cancel: &Cancel,
    ) -> Result<Equilibrium, Lost> {
        let (before, system) = (ws.transforms, problem.system);
        let (law, tolerance) = (system.law(), system.precision().tolerance());
        let mut g = vec![0.0; from.field.len()];
        let mut z = predicted(problem, branch, from, u0, ws);
        system.evaluate(&z, u0, &mut g, ws);
        let mut slides = sliding_basis(system, &z, problem.slides, ws);
        let mut push = random_smooth(system, &mut self.rng);
        project_out(&mut push, &slides);
        add(&mut z, PUSH * law.range / norm(&push), &push);
        let mut velocity = vec![0.0; z.len()];
        for step in 0.. {
            if cancel.requested() {
                return Err(Lost::Cancelled);
            }
            let at = system.evaluate(&z, u0, &mut g, ws);
            let force = norm(&g);
            if !(force.is_finite() && at.energy.is_finite()) {
                return Err(Lost::Diverged("a jump overshot into the wall of the law"));
            }
            // The mean square is a lower bound of the largest residual: only then the exact one is worth a transform.
            let goal = 0.5 * tolerance * tractions(system, ws);
            let near = force <= goal;
            if near || step == BUDGET {
                let residual = system.residual(&g, ws);
                if residual <= tolerance || step == BUDGET {
                    return Ok(Equilibrium::unmeasured(
                        u0,
                        z,
                        residual,
                        at,
                        if residual <= tolerance { Stop::Stable } else { Stop::NotConverged },
                        Cost { iterations: step, transforms: ws.transforms - before },
                    ));
                }
            }
            if step % RECENTRE == 0 {
                // Along them a pattern would creep for ever: the mesh holds it with next to nothing.
                slides = sliding_basis(system, &z, problem.slides, ws);
            }
            project_out(&mut g, &slides);
            if !near && problem.slides != Slides::Never && norm(&g) <= 0.1 * goal {
                // All that is left is the mesh's pull on a pattern between its points.
                z = centred(system, &z, [false; 2]);
                velocity.fill(0.0);
                continue;
            }
            let dt = TIME_STEP * 2.0 / stiffest(problem, ws).sqrt();
            let keep = 1.0 - DAMPING * dt.min(1.0);
            for ((v, g), m) in velocity.iter_mut().zip(&g).zip(problem.preconditioner.diagonal()) {
                *v = keep * *v - dt * m * g;
            }
            let moved = dt * norm(&velocity) / (STEP_MAX * law.range);
            if moved > 1.0 {
                scale(&mut velocity, 1.0 / moved);
            }
            add(&mut z, dt, &velocity);
        }
        unreachable!("the last step returns")
    }
}
