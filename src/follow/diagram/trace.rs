//! One branch followed to its end, with its folds and bifurcations located, and the points at which
//! it leaves and meets others.

use super::{Branch, Diagram, Ending, Kind, Observe, Point};
use crate::follow::record::LOCATED;
use crate::numerics::dense::{add, dot, norm};
use crate::physics::control::Control;
use crate::physics::pattern::Pattern;
use crate::physics::system::{Fields, State};
use crate::physics::theory::flat_limits;
use crate::solver::continuation::{Knot, way};
use crate::solver::index::{Counts, Index};
use crate::solver::mechanics::Mechanics;
use crate::solver::method::Lost;

/// First step, and the longest (ranges): shorter than any branch of the paper's, so that none is
/// jumped over; on uneven ground, where crests come into contact one by one, shorter than what a
/// branch goes between the events of one crest.
const FIRST: f64 = 0.05;
const LONGEST: f64 = 0.7;
const LONGEST_UNEVEN: f64 = 0.1;
/// A branch is lost when the step falls below this (ranges).
const SHORTEST: f64 = 1e-5;
/// Error of the prediction (ranges) that the step length aims at.
const AIM: f64 = 0.03;
/// Largest deviation from the prediction in units of the step, beyond which another branch was
/// found; and the least cosine between the tangents before and after.
const STRAY: f64 = 0.3;
const TURN: f64 = 0.7;
/// Energy that a step may miss: as a share of how far its work is uncertain, and in units of the
/// surface energy per range of it.
const AUDIT: [f64; 2] = [0.2, 1e-3];
/// Most trials to locate a fold or a bifurcation.
const TRIALS: usize = 40;
/// Steps shorter than this (ranges) are not halved to tell two events apart: at a state of higher
/// symmetry a branch turns back as its own image, and fold and bifurcation are one.
const APART: f64 = 0.02;
/// Steps shorter than this (ranges) are no progress.
const SHORT: f64 = 1e-3;
/// Most steps in a row so short that they count as no progress: as at the edge of a cosine law,
/// where the stiffness jumps.
const CREEPING: usize = 40;
/// Most points of one branch: a mesh that traps edges has hundreds of folds, which say nothing of
/// the body.
const POINTS: usize = 800;

/// Follows branches of one symmetry on one mesh.
pub(super) struct Tracer {
    /// At fixed u0.
    pub mechanics: Mechanics,
    /// The same.
    pub index: Index,
    /// What drives the body.
    pub control: Control,
}

/// Where a branch begins.
pub(super) enum Start {
    /// At a point of it.
    Point(Knot),
    /// Where another branch is left.
    Meeting(Knot),
}

/// A knot with its counts at fixed u0; none where a branch begins at a bifurcation.
struct Counted {
    knot: Knot,
    counts: Option<Counts>,
    /// Derivative of the control with the arc length.
    rate: f64,
}

/// What ends a branch at the second of two knots, or how far the next step may go (length).
pub(super) type End<'e> = &'e mut dyn FnMut(&Knot, &Knot) -> Result<f64, Ending>;

impl Tracer {
    /// Follows the branch from its start along the tangent there, until `end` says that it ends,
    /// which is asked at every new point.
    pub fn follow(&mut self, from: Start, end: End<'_>) -> (Vec<Point>, Ending) {
        let mut points = Vec::new();
        let ending = self.advance(from, end, &mut points);
        (points, ending.unwrap_or_else(Ending::Lost))
    }

    /// Transforms spent, of any size.
    pub fn transforms(&self) -> usize {
        self.mechanics.transforms() + self.index.transforms()
    }

    fn advance(
        &mut self,
        from: Start,
        end: End<'_>,
        points: &mut Vec<Point>,
    ) -> Result<Ending, Lost> {
        let range = self.mechanics.system.law().range;
        let mut here = match from {
            Start::Meeting(knot) => Counted {
                knot,
                counts: None,
                rate: 0.0,
            },
            Start::Point(knot) => {
                let State {
                    amplitudes,
                    mean_displacement,
                    ..
                } = knot.state;
                let first = self.place(amplitudes, mean_displacement, &knot.tangent)?;
                points.push(first.point());
                first
            }
        };
        let mut behind: Option<Knot> = None;
        let (mut step, mut creeping) = (FIRST * range, 0);
        while points.len() < POINTS {
            // Two events of one step that hide each other are told apart by a shorter one, and one
            // that is not found is found by it.
            let found = self
                .step(behind.as_ref(), &here, step)
                .and_then(|(next, error)| {
                    if step > APART * range && hidden(&here, &next)
                        || step > SHORT * range && returns(&here, &next)
                    {
                        return Err(Lost::Gone);
                    }
                    let events = self.events(&here, &next)?;
                    Ok((next, error, events))
                });
            if found.as_ref().is_err_and(|lost| *lost == Lost::Cancelled) {
                return Err(Lost::Cancelled);
            }
            let Ok((next, error, events)) = found else {
                step *= 0.4;
                if step < SHORTEST * range {
                    return Err(Lost::Gone);
                }
                continue;
            };
            creeping = if step < SHORT * range {
                creeping + 1
            } else {
                0
            };
            if creeping > CREEPING {
                return Err(Lost::Gone);
            }
            let longer = (AIM * range / error.max(1e-12 * range)).powf(0.3);
            step = (step * longer.clamp(0.4, 2.0)).min(self.longest(&next.knot));
            points.extend(events);
            points.push(next.point());
            match end(&here.knot, &next.knot) {
                Ok(longest) => step = step.min(longest),
                Err(ending) => return Ok(ending),
            }
            behind = Some(std::mem::replace(&mut here, next).knot);
        }
        Ok(Ending::Budget)
    }

    /// How far a step may go from here (length).
    fn longest(&mut self, here: &Knot) -> f64 {
        let system = &self.mechanics.system;
        let range = system.law().range;
        if system.is_flat() {
            return LONGEST * range;
        }
        // Where no wave can soften the law alone changes, the less the farther away.
        let limits = flat_limits(system.law(), system.equivalent_length());
        let upper = limits.map_or(0.0, |(_, upper)| upper);
        let State {
            amplitudes,
            mean_displacement,
            ..
        } = &here.state;
        let gap = self.mechanics.gap(amplitudes, *mean_displacement);
        let nearest = gap.into_iter().fold(f64::INFINITY, f64::min);
        let scale = if nearest > upper { nearest } else { 0.0 };
        (LONGEST_UNEVEN * scale.max(range)).min(LONGEST * range)
    }

    /// The place a step onwards, and the error of its prediction (length).
    fn step(
        &mut self,
        behind: Option<&Knot>,
        here: &Counted,
        step: f64,
    ) -> Result<(Counted, f64), Lost> {
        let here = &here.knot;
        let (guess, u0) = predict(behind, here, step);
        let mut next = self.place(guess.clone(), u0, &here.tangent)?;
        let (from, to) = (here.state.joint(), next.knot.state.joint());
        let error = norm(&way((&guess, u0), to));
        let chord = norm(&way(from, to));
        let turned = dot(&next.knot.tangent, &here.tangent);
        // An arc is longer than its chord by 1/24 of the square of its angle.
        next.knot.arc = here.arc + chord * (1.0 + (1.0 - turned).max(0.0) / 12.0);
        let on = error < STRAY * step && turned > TURN && self.balanced(here, &next.knot);
        on.then_some((next, error)).ok_or(Lost::Gone)
    }

    fn place(&mut self, z: Vec<f64>, u0: f64, direction: &[f64]) -> Result<Counted, Lost> {
        let (knot, fields) = self.mechanics.knot(z, u0, direction)?;
        let counts = self
            .index
            .count(&mut self.mechanics, &knot.state.amplitudes, &fields)?;
        Ok(Counted {
            rate: self.rate(&knot),
            knot,
            counts: Some(counts),
        })
    }

    /// Derivative of the control with the arc length of the branch.
    fn rate(&self, knot: &Knot) -> f64 {
        let [rate, _] = self.control.balanced(knot.rate(), knot.stress_rate);
        rate
    }

    /// Along a branch dV = stress du0: a step across to another branch pays with energy.
    fn balanced(&self, a: &Knot, b: &Knot) -> bool {
        let h = b.arc - a.arc;
        let work = [a, b].map(|knot| knot.state.stress * knot.rate() * h);
        let missing = (b.state.energy - a.state.energy - 0.5 * (work[0] + work[1])).abs();
        let law = self.mechanics.system.law();
        missing
            <= AUDIT[0] * (work[0] - work[1]).abs() + AUDIT[1] * law.surface_energy * h / law.range
    }

    /// Folds and bifurcations between two places, in their order.
    fn events(&mut self, a: &Counted, b: &Counted) -> Result<Vec<Point>, Lost> {
        let (Some(before), Some(after)) = (&a.counts, &b.counts) else {
            return Ok(Vec::new());
        };
        let (rates, [turned, fold]) = ([a.rate, b.rate], turns(a, b));
        // Each with the change of the index.
        let mut found: Vec<(Point, isize)> = Vec::new();
        for class in before.classes() {
            let (from, to) = (before.of(class), after.of(class));
            let change = before.copies(class) as isize * if to > from { 1 } else { -1 };
            let mut ranks = from.min(to)..from.max(to);
            if turned && class == 0 {
                // One of the pattern's own modes changes its sign there.
                ranks.next_back();
            }
            if fold && class == 0 {
                let rate = |tracer: &mut Self, s: f64| {
                    let (knot, _) = tracer.between(&a.knot, &b.knot, s)?;
                    Ok((tracer.rate(&knot), knot))
                };
                let knot = self.zero([&a.knot, &b.knot], rates.map(Some), rate)?;
                let all = b.own(after) as isize - a.own(before) as isize;
                let change = all - change * ranks.len() as isize;
                found.push((knot.point(Kind::Fold, [0; 2]), change));
            }
            for rank in ranks {
                let sign = if from > to { 1.0 } else { -1.0 };
                let point = self.bifurcation([&a.knot, &b.knot], [class, rank], sign)?;
                found.push((point, change));
            }
        }
        found.sort_by(|(p, _), (q, _)| p.arc.total_cmp(&q.arc));
        let mut index = before.total() + a.softened();
        let counted = found.into_iter().map(|(point, change)| {
            let after = index.saturating_add_signed(change);
            Point {
                index: [std::mem::replace(&mut index, after), after],
                ..point
            }
        });
        Ok(counted.collect())
    }

    /// Where the eigenvalue of a class with so many smaller ones vanishes between two knots;
    /// `sign` times it rises.
    fn bifurcation(
        &mut self,
        [a, b]: [&Knot; 2],
        which: [usize; 2],
        sign: f64,
    ) -> Result<Point, Lost> {
        let mut mode = Vec::new();
        let value = |tracer: &mut Self, s: f64| {
            let (knot, fields) = tracer.between(a, b, s)?;
            let Tracer {
                mechanics, index, ..
            } = tracer;
            let (value, found) =
                index.eigenvalue(mechanics, &knot.state.amplitudes, &fields, which)?;
            mode = found;
            Ok((sign * value, knot))
        };
        let knot = self.zero([a, b], [None; 2], value)?;
        Ok(Point {
            class: self.index.class(which[0]),
            mode,
            ..knot.point(Kind::Bifurcation, [0; 2])
        })
    }

    /// The zero between two knots of a `value` of opposite signs there, which may be unknown
    /// (negative first), to [`LOCATED`] in the arc length: by secants, and by halves where they
    /// creep. What is driven is exact to the square of that at a fold.
    fn zero(
        &mut self,
        [a, b]: [&Knot; 2],
        ends: [Option<f64>; 2],
        mut value: impl FnMut(&mut Self, f64) -> Result<(f64, Knot), Lost>,
    ) -> Result<Knot, Lost> {
        let goal = LOCATED * self.mechanics.system.law().range;
        let mut bracket = [(a.arc, ends[0]), (b.arc, ends[1])];
        let first = ends[0].unwrap_or(-1.0);
        let mut best = None;
        for trial in 0..TRIALS {
            let [low, high] = bracket;
            let s = match slope(bracket) {
                Some((slope, value)) if trial % 3 != 2 => low.0 - value / slope,
                _ => 0.5 * (low.0 + high.0),
            };
            let (v, at) = value(self, s)?;
            best = Some(at);
            bracket[usize::from(v * first <= 0.0)] = (s, Some(v));
            let left = slope(bracket).map_or(f64::INFINITY, |(slope, _)| (v / slope).abs());
            if left < goal || bracket[1].0 - bracket[0].0 < goal {
                break;
            }
        }
        best.ok_or(Lost::Gone)
    }

    /// The branch between two knots at arc length `s`.
    fn between(&mut self, a: &Knot, b: &Knot, s: f64) -> Result<(Knot, Fields), Lost> {
        let (guess, u0) = Knot::between(a, b, s);
        let nearer = if s - a.arc < b.arc - s { a } else { b };
        let (mut knot, fields) = self.mechanics.knot(guess, u0, &nearer.tangent)?;
        knot.arc = s;
        Ok((knot, fields))
    }
}

/// Slope of a bracket whose values are known, and the value at its low end.
fn slope([low, high]: [(f64, Option<f64>); 2]) -> Option<(f64, f64)> {
    let (a, b) = (low.1?, high.1?);
    Some(((b - a) / (high.0 - low.0), a))
}

/// True if u0, and the control, turn back between two places.
fn turns(a: &Counted, b: &Counted) -> [bool; 2] {
    [[a.knot.rate(), b.knot.rate()], [a.rate, b.rate]].map(|[a, b]| a * b < 0.0)
}

/// True if u0 turns back between the limit of the flat state at which a branch begins and the next
/// place.
fn returns(a: &Counted, b: &Counted) -> bool {
    let [from, to] = [&a.knot, &b.knot];
    let gone = to.state.mean_displacement - from.state.mean_displacement;
    a.counts.is_none() && turns_near(&from.state, gone, to.rate() * (to.arc - from.arc))
}

/// True if u0 turns back between a limit of the flat state, where it is stationary, and a place
/// from which it differs by so much, and by so much along the tangent there. Of u0 = a s^2 + b s^4
/// this is where the fourth order is more than half of the second, of the other sign. Where other
/// branches meet is known too roughly to tell.
fn turns_near(limit: &State, difference: f64, tangent: f64) -> bool {
    limit.roughness() == 0.0 && difference * tangent < 0.25 * tangent * tangent
}

/// True if a turn between two places hides, or hides itself behind, a change among the pattern's
/// own modes.
fn hidden(a: &Counted, b: &Counted) -> bool {
    let (Some(before), Some(after)) = (&a.counts, &b.counts) else {
        return false;
    };
    let [turned, fold] = turns(a, b);
    let fixed = before.of(0).abs_diff(after.of(0));
    let free = a.own(before).abs_diff(b.own(after));
    turned && fixed != 1 || fold && free != 1
}

impl Counted {
    fn point(&self) -> Point {
        let total = self.counts.as_ref().map_or(0, Counts::total);
        let index = total + self.softened();
        self.knot.clone().point(Kind::Regular, [index; 2])
    }

    /// Negative eigenvalues that u0 adds where it is free: [`Control::softens`].
    fn softened(&self) -> usize {
        usize::from(self.rate * self.knot.rate() < 0.0)
    }

    /// Negative eigenvalues among the pattern's own modes, of which u0 is one where it is free.
    fn own(&self, counts: &Counts) -> usize {
        counts.of(0) + self.softened()
    }
}

impl Knot {
    fn point(self, kind: Kind, index: [usize; 2]) -> Point {
        Point {
            kind,
            index,
            arc: self.arc,
            rates: [self.rate(), self.stress_rate],
            residual: self.residual,
            state: self.state,
            pattern: Pattern::Other,
            class: None,
            mode: Vec::new(),
        }
    }
}

/// Hermite extrapolation from two knots, or along the tangent of one.
fn predict(behind: Option<&Knot>, here: &Knot, step: f64) -> (Vec<f64>, f64) {
    if let Some(behind) = behind {
        return Knot::between(behind, here, here.arc + step);
    }
    let mut z = here.state.amplitudes.clone();
    add(&mut z, step, &here.tangent);
    z[0] = 0.0;
    (z, here.state.mean_displacement + step * here.rate())
}

/// A branch about to meet another is taken to the known point of that when it is so near (ranges)
/// and heads for it with this cosine: there two directions lead on, and the bordered system is
/// singular. Until then a step goes no more than half the way. Where there is a fold before it, it
/// is so near only behind that.
const CLOSE: f64 = 0.1;
const ALIGNED: f64 = 0.9;
const NEAREST: f64 = 0.005;

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
            way_to(&(ends.others)(&b.state), a, b, range).map_err(|which| {
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
fn way_to(states: &[State], a: &Knot, b: &Knot, range: f64) -> Result<f64, usize> {
    let step = way(a.state.joint(), b.state.joint());
    let mut longest = f64::INFINITY;
    for (i, state) in states.iter().enumerate() {
        let left = way(b.state.joint(), state.joint());
        let far = norm(&left);
        let hides = turns_near(state, left[0], b.rate() * far);
        let close = range * if hides { NEAREST } else { CLOSE };
        if far < close && dot(&left, &step) > ALIGNED * far * norm(&step) {
            return Err(i);
        }
        longest = longest.min((0.5 * far).max(0.5 * close));
    }
    Ok(longest)
}

/// Root mean square distance of two surfaces.
fn distance(a: &State, b: &State) -> f64 {
    norm(&way(a.joint(), b.joint()))
}
