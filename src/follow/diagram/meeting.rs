//! Where branches meet: a bifurcation, as the first or the last point of the branch that leaves it.

use super::{Kind, Point};
use crate::numerics::vector::{add, dot, norm};
use crate::physics::pattern::Pattern;
use crate::physics::system::State;

/// A branch about to meet another is taken to the known point of that when it is so near (ranges)
/// and heads for it with this cosine: there two directions lead on, and the bordered system is
/// singular. Until then a step goes no more than half the way.
const CLOSE: f64 = 0.1;
const ALIGNED: f64 = 0.9;

/// Where a branch begins or ends on another one: it leaves along a mode of other symmetry, at
/// constant u0 and stress to first order. It comes after the `last` point, if there is one.
pub(super) fn meeting(state: State, last: Option<&Point>, index: usize) -> Point {
    let arc = last.map_or(0.0, |last| last.arc + distance(&last.state, &state));
    Point {
        state,
        arc,
        rates: [0.0; 2],
        kind: Kind::Bifurcation,
        index: [index; 2],
        pattern: Pattern::Other,
        residual: 0.0,
        class: None,
        mode: Vec::new(),
    }
}

/// How far a step may go after the way from `a` to `b`, where the branch may meet others at these
/// states.
///
/// # Errors
/// Which of them it has met.
pub(super) fn way_to(states: &[State], a: &State, b: &State, range: f64) -> Result<f64, usize> {
    let step = between(a, b);
    let mut longest = f64::INFINITY;
    for (i, state) in states.iter().enumerate() {
        let left = between(b, state);
        let far = dot(&left, &left).sqrt();
        let aligned = dot(&left, &step) > ALIGNED * far * dot(&step, &step).sqrt();
        if far < CLOSE * range && aligned {
            return Err(i);
        }
        longest = longest.min((0.5 * far).max(0.5 * CLOSE * range));
    }
    Ok(longest)
}

/// The way from one surface to another; entry 0 is that of u0.
fn between(a: &State, b: &State) -> Vec<f64> {
    let mut d = b.amplitudes.clone();
    add(&mut d, -1.0, &a.amplitudes);
    d[0] = b.mean_displacement - a.mean_displacement;
    d
}

/// Root mean square distance of two surfaces.
pub(super) fn distance(a: &State, b: &State) -> f64 {
    norm(&between(a, b))
}
