//! L-BFGS: the inverse Hessian from the last ten steps.

use super::{Landscape, Lost};
use crate::numerics::vector::{add, dot, project_out, scale};
use std::collections::VecDeque;

/// Pairs kept.
const PAIRS: usize = 10;
/// Share of its slope that a step may keep: beyond it the pair says little about the Hessian.
const SLOPE: f64 = 0.9;

/// What is known of the Hessian, from one increment of a branch to the next.
#[derive(Clone, Debug, Default)]
pub(super) struct Memory {
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

pub(super) fn relax(
    land: &mut Landscape<'_>,
    memory: &mut Memory,
    from: &[f64],
) -> Result<(), Lost> {
    if memory.end != from {
        memory.pairs.clear();
    }
    memory.end.clear();
    loop {
        if let Some(end) = land.ended() {
            if end.is_ok() {
                memory.end.clone_from(&land.at.state.amplitudes);
            }
            return end;
        }
        let (z, g) = (land.at.state.amplitudes.clone(), land.gradient.clone());
        let mut d = memory.inverse(&g);
        project_out(&mut d, &land.removed);
        scale(&mut d, -1.0);
        if dot(&d, &g) >= 0.0 {
            memory.pairs.clear();
            d = g.iter().map(|g| -g).collect();
        }
        land.search(&d, 1.0, SLOPE)?;
        let s: Vec<f64> = land
            .at
            .state
            .amplitudes
            .iter()
            .zip(&z)
            .zip(&land.root)
            .map(|((a, b), r)| if *r > 0.0 { (a - b) / r } else { 0.0 })
            .collect();
        let mut y = land.gradient.clone();
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
