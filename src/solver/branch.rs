//! The recent states of a branch, and the prediction of the next one.

use crate::numerics::dense::{add, norm};
use crate::physics::system::State;

/// Largest sum of |weights| of an extrapolation; the uniform cubic has 15, anything wilder
/// amplifies noise.
const WILDEST: f64 = 16.0;

/// Up to four states of one branch, newest last.
#[derive(Clone, Debug, Default)]
pub struct History {
    states: Vec<(f64, Vec<f64>)>,
}

impl History {
    /// A branch that begins at one state.
    pub fn starting(state: &State) -> Self {
        let mut history = Self::default();
        history.push(state);
        history
    }

    /// Adds a state; one at the same control is replaced.
    pub fn push(
        &mut self,
        State {
            control,
            amplitudes,
            ..
        }: &State,
    ) {
        self.states.retain(|(known, _)| known != control);
        if self.states.len() == 4 {
            self.states.remove(0);
        }
        self.states.push((*control, amplitudes.clone()));
    }

    /// Lagrange extrapolation of the newest states to the value `at` of the control, of the highest
    /// order that does not amplify noise; `None` where not even a straight line through the last
    /// two may be trusted.
    pub fn predict(&self, at: f64) -> Option<Vec<f64>> {
        (2..=self.states.len()).rev().find_map(|count| {
            let points = &self.states[self.states.len() - count..];
            let weights: Vec<f64> = (0..count)
                .map(|i| {
                    let others = points.iter().enumerate().filter(|(j, _)| *j != i);
                    others
                        .map(|(_, (known, _))| (at - known) / (points[i].0 - known))
                        .product()
                })
                .collect();
            if weights.iter().map(|w: &f64| w.abs()).sum::<f64>() > WILDEST {
                return None;
            }
            let mut sum = vec![0.0; points[0].1.len()];
            for (w, (_, z)) in weights.iter().zip(points) {
                add(&mut sum, *w, z);
            }
            Some(sum)
        })
    }
}

/// Euclidean distance of two amplitude vectors: root mean square difference of the surfaces
/// (length).
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    let mut d = a.to_vec();
    add(&mut d, -1.0, b);
    norm(&d)
}
