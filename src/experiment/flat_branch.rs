//! The flat state on flat ground: a closed form that costs nothing, stable up to where Eq. 8 says.

use crate::physics::law::Law;
use crate::physics::theory::flat::stiffness_min;
use crate::solver::Stop;
use crate::solver::equilibrium::{Cost, Equilibrium, Stiffness};

/// The flat branch of a law in a cell of side `length`.
#[derive(Clone, Copy, Debug)]
pub struct FlatBranch {
    law: Law,
    length: f64,
}

impl FlatBranch {
    /// The branch.
    pub fn new(law: Law, length: f64) -> Self {
        Self { law, length }
    }

    /// The flat state at gap `u0`, exact, as amplitudes of the given dimension.
    pub fn state(&self, u0: f64, dimension: usize) -> Equilibrium {
        let response = self.law.at(u0);
        let value = stiffness_min(&self.law, self.length, u0) / self.length;
        Equilibrium {
            mean_displacement: u0,
            field: vec![0.0; dimension],
            residual: 0.0,
            stress: response.traction,
            energy: response.energy,
            stiffness_min: Some(Stiffness { value, error: 0.0 }),
            soft_mode: Vec::new(),
            stop: match value >= 0.0 {
                // So deep in the wall that the law overflows.
                _ if !response.energy.is_finite() || !value.is_finite() => Stop::NotConverged,
                true => Stop::Stable,
                false => Stop::Unstable,
            },
            cost: Cost::default(),
        }
    }

    /// Where stability is lost on the way `from` a stable gap `to` another, as the last stable and the first unstable double found
    /// by bisection; `None` if it is not lost. A way longer than the soft part of the law is looked at in pieces of a tenth range.
    pub fn limit_between(&self, from: f64, to: f64) -> Option<(f64, f64)> {
        let stable = |u: f64| stiffness_min(&self.law, self.length, u) >= 0.0;
        let pieces = ((to - from).abs() / (0.1 * self.law.range)).ceil().max(1.0) as usize;
        let ends = (0..=pieces).map(|i| from + (to - from) * i as f64 / pieces as f64).collect::<Vec<_>>();
        let piece = ends.windows(2).find(|w| !stable(w[1]))?;
        let (mut a, mut b) = (piece[0], piece[1]);
        while (b - a).abs() > 1e-9 * self.law.range {
            let middle = 0.5 * (a + b);
            if stable(middle) {
                a = middle;
            } else {
                b = middle;
            }
        }
        Some((a, b))
    }
}
