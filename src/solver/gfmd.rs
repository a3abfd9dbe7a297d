//! The paper's method: mass-weighted Green's function molecular dynamics with damping and a
//! thermostat.
//!
//! Each amplitude moves with inertia proportional to q E*/2 + k, which collapses the intrinsic
//! frequencies (inertia must *grow* with q; the text of Sect. 2.2 says the inverse). An increment
//! of u0 is a ramp of 50 time steps and 150 more to relax.
//!
//! And the same dynamics at its best ([`GfmdTuned`]): from a predicted start, with the largest safe
//! time step, until it has relaxed. In place of a thermostat each increment begins with one tiny
//! random push, so that a state that has lost its stability is left even where it is perfectly
//! symmetric. It goes wherever the dynamics goes: it locates nothing.

use super::descent::{stiffest, tractions};
use super::mechanics::{Mechanics, Slides, centred};
use super::method::{Equilibrium, History, Lost, Method, predicted};
use super::stability::{random_amplitudes, random_smooth};
use crate::numerics::dense::{add, norm, project_out, scale};
use crate::physics::system::System;
use rand::SeedableRng;
use rand_pcg::Pcg64;

/// Time steps, damping and temperature of GFMD. Time is in units of the inverse frequency of a free
/// wave, sqrt(inertia per stiffness).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GfmdBudget {
    /// Time steps during which u0 moves.
    pub ramp: usize,
    /// Time steps after it.
    pub relax: usize,
    /// Time step. Stable below [`time_step_limit`].
    pub time_step: f64,
    /// Damping rate.
    pub damping: f64,
    /// Thermal energy over gamma rho^2.
    pub temperature: f64,
}

impl Default for GfmdBudget {
    fn default() -> Self {
        Self {
            ramp: 50,
            relax: 150,
            time_step: 0.5,
            damping: 0.3,
            temperature: 1e-4,
        }
    }
}

/// Why the numbers of a fixed budget end.
const TOO_LONG: &str = "time step beyond its limit";
const TOO_HOT: &str = "thrown into the wall of the law, by too hot a thermostat or by a jump";

/// Mass-weighted GFMD with a thermostat.
#[derive(Clone, Debug)]
pub struct Gfmd {
    budget: GfmdBudget,
    velocity: Vec<f64>,
    rng: Pcg64,
}

impl Gfmd {
    /// The paper's budget, noise from `seed`.
    pub fn new(seed: u64) -> Self {
        Self::with_budget(GfmdBudget::default(), seed)
    }

    /// Another budget.
    pub fn with_budget(budget: GfmdBudget, seed: u64) -> Self {
        Self {
            budget,
            velocity: Vec::new(),
            rng: Pcg64::seed_from_u64(seed),
        }
    }
}

/// The largest stable time step, 2/sqrt((max gamma'' + q1 E*/2)/(k + q1 E*/2)) of a half-space,
/// where the stiffest point has `stiffness_max` and the inertia is q E*/2 + `k`.
pub fn time_step_limit(system: &System, stiffness_max: f64, k: f64) -> f64 {
    let elastic = system.stiffness_unit() / 2.0;
    2.0 / ((stiffness_max + elastic) / (k + elastic)).sqrt()
}

impl Method for Gfmd {
    fn name(&self) -> &'static str {
        "GFMD"
    }

    fn locates(&self) -> bool {
        false
    }

    fn follow(
        &mut self,
        mechanics: &mut Mechanics,
        _branch: &History,
        from: &Equilibrium,
        control: f64,
    ) -> Result<Equilibrium, Lost> {
        let (before, b) = (mechanics.transforms(), self.budget);
        let (first, start, total) = (&from.state.amplitudes, from.state.control, b.ramp + b.relax);
        self.velocity.resize(first.len(), 0.0);
        let inverse_inertia = mechanics.preconditioner.diagonal().to_vec();
        // Equipartition: mean velocity^2 = kT / (inertia x area); the noise has variance 1/3 per
        // amplitude.
        let area = mechanics.system.grid().length.powi(2);
        let law = mechanics.system.law();
        let thermal = b.temperature * law.surface_energy * law.range.powi(2) / area;
        let kick = (3.0 * 2.0 * b.damping * thermal * b.time_step).sqrt();
        let amplitude: Vec<f64> = inverse_inertia.iter().map(|m| kick * m.sqrt()).collect();
        let ramp = |step: usize| start + (step as f64 / b.ramp as f64).min(1.0) * (control - start);
        let mut at = mechanics.at(first.clone(), ramp(1));
        let limit = 2.0 / stiffest(mechanics, &at.fields).sqrt();
        for step in 1..=total {
            if mechanics.cancel.requested() {
                return Err(Lost::Cancelled);
            }
            if !norm(&at.gradient).is_finite() {
                break;
            }
            let noise = random_amplitudes(&mechanics.system, &mut self.rng);
            let keep = 1.0 - b.damping * b.time_step;
            for (i, v) in self.velocity.iter_mut().enumerate() {
                *v = keep * *v - b.time_step * inverse_inertia[i] * at.gradient[i]
                    + amplitude[i] * noise[i];
            }
            add(&mut at.state.amplitudes, b.time_step, &self.velocity);
            at.state.control = if step < total {
                ramp(step + 1)
            } else {
                control
            };
            mechanics.update(&mut at);
        }
        let residual = mechanics.residual(&at);
        if !residual.is_finite() || !at.state.energy.is_finite() {
            self.velocity.fill(0.0);
            return Err(Lost::Diverged(if b.time_step < limit {
                TOO_HOT
            } else {
                TOO_LONG
            }));
        }
        Ok(Equilibrium::reached(mechanics, at, residual, total, before))
    }
}

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
        control: f64,
    ) -> Result<Equilibrium, Lost> {
        let before = mechanics.transforms();
        let (law, tolerance) = (
            *mechanics.system.law(),
            mechanics.system.precision().tolerance(),
        );
        let guess = predicted(mechanics, branch, from, control);
        let mut at = mechanics.at(guess, control);
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
                    return Ok(Equilibrium::reached(mechanics, at, residual, step, before));
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
