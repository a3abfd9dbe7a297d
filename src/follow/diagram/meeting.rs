//! Where branches meet: a bifurcation, at which one is left or met by another.

use super::trace::{Start, Tracer};
use super::{Branch, Diagram, Ending, Kind, Observe, Point};
use crate::numerics::dense::{dot, norm};
use crate::physics::pattern::Pattern;
use crate::physics::system::State;
use crate::solver::Lost;
use crate::solver::continuation::{Knot, way};

/// A branch about to meet another is taken to the known point of that when it is so near (ranges)
/// and heads for it with this cosine: there two directions lead on, and the bordered system is
/// singular. Until then a step goes no more than half the way.
const CLOSE: f64 = 0.1;
const ALIGNED: f64 = 0.9;

/// A bifurcation at which a branch leaves another.
#[derive(Clone)]
pub(super) struct Meeting {
    /// The state.
    pub state: State,
    /// The mode along which the branch leaves.
    pub mode: Vec<f64>,
    /// Residual of the state.
    pub residual: f64,
    /// True once that branch is known.
    pub joined: bool,
}

impl Meeting {
    /// The start of the branch: at constant u0 and stress to first order.
    pub fn leave(&self) -> Start {
        Start::Meeting(Knot {
            state: self.state.clone(),
            tangent: self.mode.clone(),
            stress_rate: 0.0,
            arc: 0.0,
            residual: self.residual,
        })
    }
}

/// Where a branch may end.
pub(super) struct Ends<'e> {
    /// States of others that it may meet, as images near to this one of its own.
    pub others: &'e dyn Fn(&State) -> Vec<State>,
    /// What it is to meet them.
    pub met: Ending,
    /// A branch that is lost so near to one of them (ranges) has met it.
    pub about: f64,
    /// True if between two knots it leaves what was asked for.
    pub beyond: &'e dyn Fn(&Knot, &Knot) -> bool,
}

impl Diagram {
    /// Follows a branch to one of its ends, and adds it with the points at which it leaves and
    /// meets others. Returns which of those it has met.
    pub(super) fn follow(
        &mut self,
        tracer: &mut Tracer,
        name: String,
        from: Start,
        ends: &Ends<'_>,
        observe: Observe<'_>,
    ) -> Option<usize> {
        let spent = tracer.transforms();
        let range = tracer.mechanics.system.law().range;
        let begin = match &from {
            Start::Meeting(knot) => Some(knot.state.clone()),
            Start::Point(_) => None,
        };
        let (mut met, mut count) = (None, 0);
        let mut end = |a: &Knot, b: &Knot| {
            count += 1;
            observe(&name, count, b.state.mean_displacement);
            if (ends.beyond)(a, b) {
                return Err(Ending::Window);
            }
            way_to(&(ends.others)(&b.state), &a.state, &b.state, range).map_err(|which| {
                met = Some(which);
                ends.met
            })
        };
        let (mut points, mut ending) = tracer.follow(from, &mut end);
        if let Some(state) = begin {
            let first = points.first().map_or(0, |p| p.index[0]);
            points.insert(0, meeting(state, None, first));
        }
        if let Some(last) = points.last() {
            let others = (ends.others)(&last.state);
            if ending == Ending::Lost(Lost::Gone) {
                let near = |other: &State| distance(&last.state, other) < ends.about * range;
                met = others.iter().position(near);
                ending = met.map_or(ending, |_| ends.met);
            }
            if let Some(which) = met {
                points.push(meeting(others[which].clone(), Some(last), last.index[1]));
            }
        }
        self.transforms += tracer.transforms() - spent;
        self.add(Branch {
            name,
            system: tracer.mechanics.system.clone(),
            points,
            ending,
        });
        met
    }
}

/// The first or last point of a branch, on another one. It comes after the `last` point, if there
/// is one.
fn meeting(state: State, last: Option<&Point>, index: usize) -> Point {
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
fn way_to(states: &[State], a: &State, b: &State, range: f64) -> Result<f64, usize> {
    let step = way(a.joint(), b.joint());
    let mut longest = f64::INFINITY;
    for (i, state) in states.iter().enumerate() {
        let left = way(b.joint(), state.joint());
        let far = norm(&left);
        if far < CLOSE * range && dot(&left, &step) > ALIGNED * far * norm(&step) {
            return Err(i);
        }
        longest = longest.min((0.5 * far).max(0.5 * CLOSE * range));
    }
    Ok(longest)
}

/// Root mean square distance of two surfaces.
fn distance(a: &State, b: &State) -> f64 {
    norm(&way(a.joint(), b.joint()))
}
