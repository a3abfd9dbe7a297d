//! Descents to the nearest minimum without Hessian: FIRE, nonlinear conjugate gradients, L-BFGS.
//!
//! All three work in the scaled amplitudes y = z / sqrt(m) with m the diagonal of the
//! preconditioner, in which the Hessian's spectrum is of order one whatever the mesh: a plain step
//! then suits all waves alike. They begin at the branch's prediction, and give up where they leave
//! its neighbourhood: a descent that ran on would find some other branch and call it this one.

use super::mechanics::Mechanics;
use super::method::{Equilibrium, History, Lost, Method, audit, distance, predicted, reach};
use crate::numerics::dense::{add, dot, max_abs, norm, orthonormalise, project_out, scale};
use crate::physics::law::Law;
use crate::physics::system::{Evaluation, Fields};
use std::collections::VecDeque;

/// Iterations after which a descent says that it does not get there. Tens are normal; next to a
/// fold it is the square root of the softness that counts.
const BUDGET: usize = 600;
/// How often a step that leaves the domain of the law is cut to a quarter.
const CUTS: usize = 8;

/// A descent behind the interface of every method.
#[derive(Clone, Debug)]
pub struct Descent {
    rule: Rule,
}

#[derive(Clone, Debug)]
enum Rule {
    Fire,
    Conjugate,
    Lbfgs(Memory),
}

impl Descent {
    /// FIRE (E. Bitzek et al., Phys. Rev. Lett. 97, 170201 (2006), doi
    /// 10.1103/PhysRevLett.97.170201).
    pub fn fire() -> Self {
        Self { rule: Rule::Fire }
    }

    /// Nonlinear conjugate gradients after Polak and Ribiere, restarted where their factor is
    /// negative.
    pub fn conjugate() -> Self {
        Self {
            rule: Rule::Conjugate,
        }
    }

    /// L-BFGS with ten pairs (D. C. Liu and J. Nocedal, Math. Program. 45, 503 (1989), doi
    /// 10.1007/BF01589116).
    pub fn lbfgs() -> Self {
        Self {
            rule: Rule::Lbfgs(Memory::default()),
        }
    }
}

impl Method for Descent {
    fn name(&self) -> &'static str {
        match self.rule {
            Rule::Fire => "FIRE",
            Rule::Conjugate => "conjugate gradients",
            Rule::Lbfgs(_) => "L-BFGS",
        }
    }

    /// They refuse what is not the continuation of the branch, and so can be asked where it ends.
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
        let mut position = Position::at(mechanics, guess, control, reach);
        match &mut self.rule {
            Rule::Fire => fire(&mut position)?,
            Rule::Conjugate => conjugate(&mut position)?,
            Rule::Lbfgs(memory) => lbfgs(&mut position, memory, &from.state.amplitudes)?,
        }
        let Position {
            at,
            residual,
            iterations,
            ..
        } = position;
        if !audit(&mechanics.system, &from.state, &at.state) {
            return Err(Lost::Gone);
        }
        Ok(Equilibrium::reached(
            mechanics, at, residual, iterations, before,
        ))
    }
}

/// The energy at one control over the scaled amplitudes y, and where on it a descent stands.
struct Position<'a> {
    mechanics: &'a mut Mechanics,
    /// sqrt(m), so that z = root * y.
    root: Vec<f64>,
    /// Sliding directions in y: left out of gradients, and so of steps.
    removed: Vec<Vec<f64>>,
    guess: Vec<f64>,
    /// Largest distance from the guess that is still this branch (length).
    reach: f64,
    at: Evaluation,
    /// dV/dy without the sliding directions.
    gradient: Vec<f64>,
    residual: f64,
    iterations: usize,
}

impl<'a> Position<'a> {
    fn at(mechanics: &'a mut Mechanics, guess: Vec<f64>, control: f64, reach: f64) -> Self {
        let root: Vec<f64> = mechanics
            .preconditioner
            .diagonal()
            .iter()
            .map(|m| m.sqrt())
            .collect();
        let at = mechanics.at(guess.clone(), control);
        let slides = mechanics.sliding_basis(&at.state.amplitudes, &at.fields);
        let scaled = slides
            .iter()
            .map(|mode| mode.iter().zip(&root).map(|(m, r)| m * r).collect())
            .collect();
        let removed = orthonormalise(scaled, 1e-9);
        let gradient = vec![0.0; guess.len()];
        let mut position = Self {
            mechanics,
            root,
            removed,
            guess,
            reach,
            at,
            gradient,
            residual: f64::NAN,
            iterations: 0,
        };
        position.differentiate();
        position
    }

    /// The gradient in y of what was evaluated.
    fn differentiate(&mut self) {
        for ((g, f), r) in self
            .gradient
            .iter_mut()
            .zip(&self.at.gradient)
            .zip(&self.root)
        {
            *g = f * r;
        }
        project_out(&mut self.gradient, &self.removed);
    }

    /// Moves y by `t` times `direction`.
    fn go(&mut self, direction: &[f64], t: f64) {
        for ((z, d), r) in self
            .at
            .state
            .amplitudes
            .iter_mut()
            .zip(direction)
            .zip(&self.root)
        {
            *z += t * r * d;
        }
        self.mechanics.update(&mut self.at);
        self.differentiate();
    }

    fn is_finite(&self) -> bool {
        self.at.state.energy.is_finite() && norm(&self.gradient).is_finite()
    }

    /// How the descent ends here, or `None` if another iteration is due, which is then counted.
    fn ended(&mut self) -> Option<Result<(), Lost>> {
        if self.mechanics.cancel.requested() {
            return Some(Err(Lost::Cancelled));
        }
        if !self.is_finite() || distance(&self.at.state.amplitudes, &self.guess) > self.reach {
            return Some(Err(Lost::Gone));
        }
        // The mean square is a lower bound of the largest residual: only then the exact one is
        // worth a transform.
        let tolerance = self.mechanics.system.precision().tolerance();
        if norm(&self.at.gradient)
            <= 0.5 * tolerance * tractions(self.mechanics.system.law(), &self.at.fields)
        {
            self.residual = self.mechanics.residual(&self.at);
            if self.residual <= tolerance {
                return Some(Ok(()));
            }
        }
        if self.iterations == BUDGET {
            return Some(Err(Lost::Gone));
        }
        self.iterations += 1;
        None
    }

    /// Upper bound of the Hessian's eigenvalues in y here.
    fn stiffest(&self) -> f64 {
        stiffest(self.mechanics, &self.at.fields)
    }

    /// Goes along the descent direction `d` to where the slope has fallen to `share` of what it
    /// was: a first trial at `t`, then by the secant. Returns the mean curvature d H d / d d on the
    /// way, which is above zero.
    fn search(&mut self, d: &[f64], mut t: f64, share: f64) -> Result<f64, Lost> {
        let before = dot(&self.gradient, d);
        self.go(d, t);
        for _ in 0..CUTS {
            if self.is_finite() {
                break;
            }
            // Out of the law's domain: a step is shortened, never taken.
            self.go(d, -0.75 * t);
            t *= 0.25;
        }
        let after = dot(&self.gradient, d);
        let curvature = (after - before) / (t * dot(d, d));
        if !curvature.is_finite() {
            return Err(Lost::Gone);
        }
        if curvature <= 0.0 {
            return Err(Lost::Unstable);
        }
        if after.abs() > share * before.abs() {
            let there = (t * before / (before - after)).min(4.0 * t);
            self.go(d, there - t);
        }
        Ok(curvature)
    }
}

/// The largest tractions that act, at least sigma_max (E*): the scale of every residual.
pub(super) fn tractions(law: &Law, fields: &Fields) -> f64 {
    fields
        .traction
        .as_slice()
        .map_or(0.0, max_abs)
        .max(law.traction_max())
}

/// Upper bound of the Hessian's eigenvalues in the scaled amplitudes: the stiffest point met by the
/// softest wave.
pub(super) fn stiffest(mechanics: &Mechanics, fields: &Fields) -> f64 {
    let largest = |x: &[f64]| x.iter().cloned().fold(0.0, f64::max);
    let stiffness = fields.stiffness.as_slice().map_or(0.0, largest);
    ((stiffness + mechanics.system.stiffness_unit() / 2.0)
        * largest(mechanics.preconditioner.diagonal()))
    .max(1.0)
}

/// Share of its slope that a direction may keep: most trials then need no second one.
const CONJUGATE_SLOPE: f64 = 0.3;

fn conjugate(position: &mut Position<'_>) -> Result<(), Lost> {
    let mut d: Vec<f64> = position.gradient.iter().map(|g| -g).collect();
    // Of order one in these variables.
    let mut curvature = 1.0;
    loop {
        if let Some(end) = position.ended() {
            return end;
        }
        let before = position.gradient.clone();
        if dot(&before, &d) >= 0.0 {
            d = before.iter().map(|g| -g).collect();
        }
        let t = -dot(&before, &d) / (curvature * dot(&d, &d));
        curvature = position.search(&d, t, CONJUGATE_SLOPE)?;
        let g = &position.gradient;
        let beta = ((dot(g, g) - dot(g, &before)) / dot(&before, &before)).max(0.0);
        d.iter_mut().for_each(|d| *d *= beta);
        add(&mut d, -1.0, g);
    }
}

/// Steering at the start of a run downhill, and its decay per step.
const STEERING: f64 = 0.1;
const STEERING_DECAY: f64 = 0.99;
/// Growth of the time step on the way down, cut when uphill, and steps after which it may grow.
const GROWTH: f64 = 1.1;
const CUT: f64 = 0.5;
const PATIENCE: usize = 5;
/// First and largest time step over the limit 2/sqrt(stiffest eigenvalue).
const FIRST: f64 = 0.4;
const LARGEST: f64 = 0.8;

fn fire(position: &mut Position<'_>) -> Result<(), Lost> {
    let limit = |position: &Position<'_>| 2.0 / position.stiffest().sqrt();
    let mut velocity = vec![0.0; position.gradient.len()];
    let (mut dt, mut steering, mut downhill) = (FIRST * limit(position), STEERING, 0);
    loop {
        if let Some(end) = position.ended() {
            return end;
        }
        if dot(&velocity, &position.gradient) <= 0.0 {
            downhill += 1;
            if downhill > PATIENCE {
                dt *= GROWTH;
                steering *= STEERING_DECAY;
            }
        } else {
            // Half a step back: the bottom was passed on the way.
            position.go(&velocity, -0.5 * dt);
            velocity.fill(0.0);
            (dt, steering, downhill) = (CUT * dt, STEERING, 0);
        }
        dt = dt.min(LARGEST * limit(position));
        add(&mut velocity, -dt, &position.gradient);
        let force = norm(&position.gradient);
        if force > 0.0 {
            let speed = norm(&velocity);
            scale(&mut velocity, 1.0 - steering);
            add(&mut velocity, -steering * speed / force, &position.gradient);
        }
        position.go(&velocity, dt);
    }
}

/// Pairs kept.
const PAIRS: usize = 10;
/// Share of its slope that a step may keep: beyond it the pair says little about the Hessian.
const LBFGS_SLOPE: f64 = 0.9;

/// What is known of the Hessian, from one increment of a branch to the next.
#[derive(Clone, Debug, Default)]
struct Memory {
    pairs: VecDeque<Pair>,
    /// Where the last relaxation ended. From anywhere else (after a jump, or a failed increment)
    /// the pairs are another state's.
    end: Vec<f64>,
}

/// A step s, the change y of the gradient over it, and their product.
#[derive(Clone, Debug)]
struct Pair {
    s: Vec<f64>,
    y: Vec<f64>,
    sy: f64,
}

fn lbfgs(position: &mut Position<'_>, memory: &mut Memory, from: &[f64]) -> Result<(), Lost> {
    if memory.end != from {
        memory.pairs.clear();
    }
    memory.end.clear();
    loop {
        if let Some(end) = position.ended() {
            if end.is_ok() {
                memory.end.clone_from(&position.at.state.amplitudes);
            }
            return end;
        }
        let (z, g) = (
            position.at.state.amplitudes.clone(),
            position.gradient.clone(),
        );
        let mut d = memory.inverse(&g);
        project_out(&mut d, &position.removed);
        scale(&mut d, -1.0);
        if dot(&d, &g) >= 0.0 {
            memory.pairs.clear();
            d = g.iter().map(|g| -g).collect();
        }
        position.search(&d, 1.0, LBFGS_SLOPE)?;
        let s: Vec<f64> = position
            .at
            .state
            .amplitudes
            .iter()
            .zip(&z)
            .zip(&position.root)
            .map(|((a, b), r)| if *r > 0.0 { (a - b) / r } else { 0.0 })
            .collect();
        let mut y = position.gradient.clone();
        add(&mut y, -1.0, &g);
        memory.learn(s, y)?;
    }
}

impl Memory {
    /// The approximate inverse Hessian times `g`.
    fn inverse(&self, g: &[f64]) -> Vec<f64> {
        let mut q = g.to_vec();
        let mut shares = Vec::with_capacity(self.pairs.len());
        for pair in self.pairs.iter().rev() {
            let share = dot(&pair.s, &q) / pair.sy;
            add(&mut q, -share, &pair.y);
            shares.push(share);
        }
        if let Some(newest) = self.pairs.back() {
            scale(&mut q, newest.sy / dot(&newest.y, &newest.y));
        }
        for (pair, share) in self.pairs.iter().zip(shares.iter().rev()) {
            let back = dot(&pair.y, &q) / pair.sy;
            add(&mut q, share - back, &pair.s);
        }
        q
    }

    /// Takes in a step; a gradient that falls along it is negative curvature.
    fn learn(&mut self, s: Vec<f64>, y: Vec<f64>) -> Result<(), Lost> {
        let sy = dot(&s, &y);
        // NaN must not pass as positive.
        if !(sy > 0.0) {
            return Err(Lost::Unstable);
        }
        if self.pairs.len() == PAIRS {
            self.pairs.pop_front();
        }
        self.pairs.push_back(Pair { s, y, sy });
        Ok(())
    }
}
