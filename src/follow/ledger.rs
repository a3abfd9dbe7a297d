//! The energy ledger of a loop: whether it closes, what it lost, how well that is known, and the
//! check of it.
//!
//! Along a smooth branch dV = stress du0. A closed loop of equilibria therefore loses exactly what
//! its jumps release: that sum is the loss. The loop integral of the stress says the same by other
//! means, as far as the states lie close enough to integrate between them: it is the check beside
//! the loss.

use super::record::{Cause, JumpRecord, LoopRecord, SAME, StateRecord};
use crate::solver::Stop;

/// What a loop lost. Energies per area in units of gamma.
#[derive(Clone, Debug, PartialEq)]
pub struct Ledger {
    /// Sum of the energies released in the jumps.
    pub released_energy_sum: f64,
    /// How far that sum may be off because ends of branches are located only so well; the error of
    /// the mesh is not in it.
    pub released_energy_error: f64,
    /// Loop integral of stress du0.
    pub loop_integral: f64,
    /// How far the integral may be off because states lie apart, by its own estimate.
    pub integral_error: f64,
    /// Why the loop is not closed; `None` if it is.
    pub open: Option<Open>,
    /// True where states are no equilibria or jumps are only noticed: energy is then lost between
    /// the jumps too.
    pub viscous: bool,
}

/// Why a loop is not closed, and what to do about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Open {
    /// What its end is, and what its beginning.
    pub reason: String,
    /// What to change.
    pub remedy: String,
}

/// [`SAME`] for a state that lies between two others.
const BETWEEN: f64 = 1e-2;
/// Residual below which a state has lost nothing on the way, whatever is known of its stability:
/// energies are off by its square.
const AT_REST: f64 = 1e-5;
/// A loss below this (in gamma) is rounding.
const LOSS_MIN: f64 = 1e-6;
/// Share of the loss by which loop integral and loss may differ without a word, beside their
/// errors: the digits that are shown.
const SHOWN: f64 = 1e-3;

impl Ledger {
    /// The loss: the sum of the releases, or the loop integral of a method whose states are no
    /// equilibria. `None` unless the loop is closed and the number finite.
    pub fn dissipated_energy(&self) -> Option<f64> {
        let loss = if self.viscous {
            self.loop_integral
        } else {
            self.released_energy_sum
        };
        (self.open.is_none() && loss.is_finite()).then_some(loss)
    }

    /// The relative error to be stated of the loss: what the plan predicts, and how well the ends
    /// of branches are located. `None` where nothing is promised.
    pub fn stated_error(&self, predicted: f64) -> Option<f64> {
        let loss = self.dissipated_energy()?;
        let located = if loss == 0.0 {
            0.0
        } else {
            self.released_energy_error / loss.abs()
        };
        Some(predicted + located).filter(|error| *error < 1.0 && !self.viscous)
    }

    /// |loop integral - sum of releases| over the loss; `None` where nothing is lost, or some of it between the jumps.
    pub fn mismatch(&self) -> Option<f64> {
        let loss = self
            .dissipated_energy()
            .filter(|loss| loss.abs() > LOSS_MIN && !self.viscous)?;
        Some(((self.loop_integral - self.released_energy_sum) / loss).abs())
    }

    /// What a reader of the loss must know, in words: the check that does not agree with it.
    pub fn warning(&self) -> Option<String> {
        let loss = self.dissipated_energy().filter(|_| !self.viscous)?;
        let off = (self.loop_integral - loss).abs();
        if off <= self.released_energy_error + SHOWN * loss.abs() + LOSS_MIN {
            return None;
        }
        let found = format!(
            "the loop integral, {:.4} gamma, is not the sum of releases, {loss:.4} gamma",
            self.loop_integral
        );
        Some(if off <= 2.0 * self.integral_error {
            format!("{found}: the states lie too far apart to check it; a smaller drive.step does")
        } else {
            format!(
                "{found}: energy is missing, and the loss is not to be trusted; try a smaller drive.step"
            )
        })
    }
}

impl LoopRecord {
    /// The ledger of a drive that went all the way, for a law of `surface_energy` gamma (E* times
    /// length).
    pub fn ledger(&self, surface_energy: f64) -> Ledger {
        let [work, error] = self.quadrature();
        Ledger {
            released_energy_sum: self.released_energy_sum(),
            released_energy_error: self.jumps.iter().map(|jump| jump.release_error).sum(),
            loop_integral: work / surface_energy,
            integral_error: error / surface_energy,
            open: self.open(),
            viscous: self
                .states
                .iter()
                .any(|s| s.stop == Stop::NotConverged && !(s.residual <= AT_REST))
                || self.jumps.iter().any(|j| j.cause == Cause::PatternChange),
        }
    }

    /// The record as a closed loop, if its last state lies on the way that was gone before the first
    /// jump, and something has jumped there and back: up to the start it is that way, which loses
    /// nothing.
    pub fn closed(&self) -> Option<Self> {
        let (start, first, now) = (
            self.states.first()?,
            self.jumps.first()?,
            self.states.last()?,
        );
        if self.is_pushed()
            || self.jumps.last()?.direction == first.direction
            || now.direction == first.direction
        {
            return None;
        }
        // So far before the first jump, and what was there.
        let onwards = (first.control - start.control).signum();
        let ahead = |s: &StateRecord| onwards * (first.control - s.control);
        let before = |s: &&StateRecord| {
            s.direction == first.direction && s.pattern == start.pattern && ahead(s) >= 0.0
        };
        let mut way: Vec<&StateRecord> = self.states.iter().take_while(before).collect();
        way.sort_by(|a, b| ahead(a).total_cmp(&ahead(b)));
        let next = way.partition_point(|s| ahead(s) < ahead(now));
        let (near, far) = (way.get(next.checked_sub(1)?)?, way.get(next)?);
        let share = (now.control - near.control) / (far.control - near.control);
        let there = |of: fn(&StateRecord) -> f64| of(near) + share * (of(far) - of(near));
        let same = now.pattern == start.pattern
            && (now.stress_over_max - there(|s| s.stress_over_max)).abs() <= BETWEEN;
        same.then(|| {
            let mut closed = self.clone();
            let back = way[next..].iter().map(|s| StateRecord {
                direction: now.direction,
                ..(*s).clone()
            });
            closed.states.extend(back);
            closed
        })
    }

    /// True if a push led into another state, whose work nobody counts.
    fn is_pushed(&self) -> bool {
        self.jumps.iter().any(|jump| jump.cause == Cause::Push)
    }

    /// Sum of the released energies, in units of gamma.
    pub fn released_energy_sum(&self) -> f64 {
        self.jumps.iter().map(|jump| jump.released_energy).sum()
    }

    /// The loop integral of stress du0 over the recorded states, energy per area (E* times length).
    /// Positive for a closed approach and retraction.
    pub fn work(&self) -> f64 {
        self.quadrature()[0]
    }

    /// Why the last state is not the first one; `None` if it is.
    fn open(&self) -> Option<Open> {
        let (first, last) = (self.states.first()?, self.states.last()?);
        if self.is_pushed() {
            return Some(Open {
                reason: "the surface was pushed by hand on the way".to_owned(),
                remedy: "play the loop anew".to_owned(),
            });
        }
        let scale = first.stress_over_max.abs().max(1.0);
        // Of a state that was read off there is no residual.
        let residual = |s: &StateRecord| s.residual.max(0.0);
        let within = SAME * scale + residual(first) + residual(last);
        let apart = (first.control - last.control).abs();
        // Written so that NaN is not taken for closed.
        let closed = first.pattern == last.pattern
            && (first.stress_over_max - last.stress_over_max).abs() <= within
            && apart <= 1e-9 * first.control.abs().max(1.0);
        if closed {
            return None;
        }
        let (began, ended) = (first.pattern, last.pattern);
        let what = if began == ended {
            format!("in another {ended} state than it began with")
        } else {
            format!("as {ended} and began as {began}")
        };
        Some(Open {
            reason: format!("it ends {what}, at u0 = {}", last.mean_displacement),
            remedy: "raise drive.start beyond the last jump of the retraction, to where only one state is stable".to_owned(),
        })
    }

    /// The loop integral and an estimate of its error (E* times length).
    ///
    /// Every smooth segment is integrated for itself; a jump is a vertical line, up to which the
    /// stress before it holds. What approach and retraction pass from the same state to the same
    /// state cancels, and is left out: in deep compression it is many times the loss.
    fn quadrature(&self) -> [f64; 2] {
        let (mut segments, noticed) = self.segments();
        leave_out_retraced(&mut segments);
        let parts = segments.iter().map(Segment::integral);
        parts.fold([noticed, 0.0], |[sum, error], [part, its]| {
            [sum + part, error + its]
        })
    }

    /// The smooth segments, and the work around the jumps that were only noticed: half of the way
    /// with the stress of either side.
    fn segments(&self) -> (Vec<Segment>, f64) {
        let mut jumps = self.jumps.iter().peekable();
        let (mut done, mut noticed) = (Vec::new(), 0.0);
        let before = |jump: &JumpRecord| {
            self.control
                .conjugate(jump.mean_displacement, jump.stress_before)
        };
        let mut segment = Segment::default();
        for pair in self.states.windows(2) {
            let [a, b] = [&pair[0], &pair[1]].map(|s| {
                let conjugate = self.control.conjugate(s.mean_displacement, s.stress);
                [s.control, conjugate]
            });
            if pair[0].direction != pair[1].direction {
                done.push(std::mem::take(&mut segment));
            }
            // The end of a branch, where it was recorded too: the way from there is the jump.
            if segment.points.is_empty() && a[0] == b[0] {
                jumps.next_if(|j| j.direction == pair[1].direction && j.control == b[0]);
                continue;
            }
            segment.begin(a);
            // What was noticed only later: the kink was passed unbroken.
            let behind = |at: f64| (b[0] - a[0]) * (at - a[0]) <= 0.0;
            while jumps
                .next_if(|j| {
                    j.cause == Cause::Transition
                        && j.direction == pair[1].direction
                        && behind(j.control)
                })
                .is_some()
            {}
            let between = |at: f64| (a[0] < at && at < b[0]) || (b[0] < at && at < a[0]);
            match jumps.next_if(|j| {
                j.direction == pair[1].direction && (j.control == b[0] || between(j.control))
            }) {
                None => {
                    segment.points.push(b);
                    continue;
                }
                // The branch has a kink there, between two states.
                Some(jump) if between(jump.control) => {
                    let kink = [jump.control, before(jump)];
                    segment.points.push(kink);
                    done.push(std::mem::replace(
                        &mut segment,
                        Segment {
                            points: vec![kink, b],
                            ..Segment::default()
                        },
                    ));
                    continue;
                }
                Some(jump) if jump.cause != Cause::PatternChange => {
                    segment.points.push([b[0], before(jump)]);
                    segment.turns_back = matches!(jump.cause, Cause::Fold | Cause::Mesh);
                }
                Some(_) => noticed += 0.5 * (a[1] + b[1]) * (b[0] - a[0]),
            }
            done.push(std::mem::take(&mut segment));
        }
        done.push(segment);
        (
            done.into_iter().map(Segment::without_crowds).collect(),
            noticed,
        )
    }
}

/// Points (u0, stress) along a smooth branch, u0 growing or falling.
#[derive(Clone, Debug, Default)]
struct Segment {
    points: Vec<[f64; 2]>,
    /// For each interval but those at the end of the list, whether it is passed the other way too.
    retraced: Vec<bool>,
    /// True if it ends at a fold, where the stress goes with the root of the distance.
    turns_back: bool,
}

/// How many times shorter an interval may be than its neighbour and still tell of its slope.
const CROWDED: f64 = 8.0;

impl Segment {
    fn begin(&mut self, point: [f64; 2]) {
        if self.points.is_empty() {
            self.points.push(point);
        }
    }

    /// Points that only rounding holds apart count once.
    fn without_crowds(mut self) -> Self {
        let ends = self.points.first().zip(self.points.last());
        let near = ends.map_or(0.0, |(a, b)| {
            1e-6 * (b[0] - a[0]).abs() / self.points.len() as f64
        });
        self.points.dedup_by(|b, a| (b[0] - a[0]).abs() <= near);
        self
    }

    /// The integral over the intervals that are not retraced, and an estimate of its error. Towards
    /// a fold in the root of the distance from it, of which the stress is a smooth function.
    fn integral(&self) -> [f64; 2] {
        let Some(end) = self.points.last().filter(|_| self.turns_back) else {
            return integral(&self.points, &self.retraced);
        };
        // u = end - side s^2, so that stress du = -2 side s stress ds.
        let side = (end[0] - self.points[0][0]).signum();
        let root = |&[u, stress]: &[f64; 2]| {
            let s = (side * (end[0] - u)).max(0.0).sqrt();
            [s, -2.0 * side * s * stress]
        };
        integral(
            &self.points.iter().map(root).collect::<Vec<_>>(),
            &self.retraced,
        )
    }
}

/// Marks the intervals that approach and retraction pass from the same state to the same state,
/// also where one of them has further states in between.
fn leave_out_retraced(segments: &mut [Segment]) {
    for segment in segments.iter_mut() {
        segment.retraced = vec![false; segment.points.len().saturating_sub(1)];
    }
    for i in 0..segments.len() {
        for j in i + 1..segments.len() {
            let common = common(&segments[i].points, &segments[j].points);
            for pair in common.windows(2) {
                let (there, back) = (pair[0].0..pair[1].0, pair[1].1..pair[0].1);
                let free = |i: usize, range: &std::ops::Range<usize>| {
                    !segments[i].retraced[range.clone()].contains(&true)
                };
                if free(i, &there) && free(j, &back) {
                    segments[i].retraced[there].fill(true);
                    segments[j].retraced[back].fill(true);
                }
            }
        }
    }
}

/// The states that two segments have in common, if one goes up and the other down: their places in
/// both, in the order of the first.
fn common(one: &[[f64; 2]], other: &[[f64; 2]]) -> Vec<(usize, usize)> {
    let way = |points: &[[f64; 2]]| {
        points
            .first()
            .zip(points.last())
            .map_or(0.0, |(a, b)| b[0] - a[0])
    };
    let (there, back) = (way(one), way(other));
    let mut found = Vec::new();
    if !(there * back < 0.0) {
        return found;
    }
    let near = 1e-9 * there.abs().min(back.abs()) / one.len().max(other.len()) as f64;
    let mut rest = other.len();
    for (i, a) in one.iter().enumerate() {
        // Those that lie before this one on the way of the first segment.
        while rest > 0 && (other[rest - 1][0] - a[0]) * there.signum() < -near {
            rest -= 1;
        }
        let Some(b) = rest
            .checked_sub(1)
            .map(|last| other[last])
            .filter(|b| (b[0] - a[0]).abs() <= near)
        else {
            continue;
        };
        // A thousandth of what the stress changes to the next state is far below the error of
        // integrating it.
        let neighbours = [i.checked_sub(1), Some(i + 1)]
            .into_iter()
            .flatten()
            .filter_map(|k| one.get(k));
        let change = neighbours.map(|p| (p[1] - a[1]).abs()).fold(0.0, f64::max);
        if (a[1] - b[1]).abs() <= 1e-3 * change + 1e-12 * a[1].abs() {
            found.push((i, rest - 1));
        }
    }
    found
}

/// The integral of a smooth curve through the points (x, y), x growing or falling, and an estimate
/// of its error: in every interval that is not to be left out the cubic with the slopes of the
/// parabolas through neighbouring points.
fn integral(points: &[[f64; 2]], left_out: &[bool]) -> [f64; 2] {
    let secant = |a: [f64; 2], b: [f64; 2]| (b[1] - a[1]) / (b[0] - a[0]);
    // The parabola's slope at the first of three points, which may be in any order.
    let slope =
        |at: [f64; 2], b: [f64; 2], c: [f64; 2]| secant(at, b) + secant(at, c) - secant(b, c);
    let slopes: Vec<f64> = (0..points.len())
        .map(|i| match (i.checked_sub(1), points.get(i + 1)) {
            (Some(before), Some(&after)) => slope(points[i], points[before], after),
            (None, Some(&after)) => points.get(2).map_or_else(
                || secant(points[0], after),
                |&third| slope(points[0], after, third),
            ),
            (Some(before), None) => match before.checked_sub(1) {
                Some(third) => slope(points[i], points[before], points[third]),
                None => secant(points[before], points[i]),
            },
            (None, None) => 0.0,
        })
        .collect();
    let length = |i: usize| points.get(i + 1).map(|next| (next[0] - points[i][0]).abs());
    let piece = |i: usize| {
        let (a, b) = (points[i], points[i + 1]);
        let (h, k) = (b[0] - a[0], secant(a, b));
        let (before, after) = (i.checked_sub(1).and_then(length), length(i + 1));
        // Next to a fold the states crowd together, and the slope among them says nothing about a
        // long interval beside them: there the parabola with the other slope.
        let holds = |neighbour: Option<f64>| neighbour.is_some_and(|n| CROWDED * n >= h.abs());
        let (bend, unknown) = match (holds(before.or(after)), holds(after.or(before))) {
            // A parabola has no third derivative: what there is of it tells how well the cubic
            // fits. Twice that covers the ends, where the slope is extrapolated.
            (true, true) => (
                slopes[i] - slopes[i + 1],
                2.0 * (slopes[i] + slopes[i + 1] - 2.0 * k),
            ),
            (true, false) => (2.0 * (slopes[i] - k), 2.0 * (slopes[i] - k)),
            (false, true) => (2.0 * (k - slopes[i + 1]), 2.0 * (k - slopes[i + 1])),
            // Nothing is known but the ends.
            (false, false) => (0.0, 6.0 * k),
        };
        [
            0.5 * h * (a[1] + b[1]) + h * h / 12.0 * bend,
            h * h / 12.0 * unknown.abs(),
        ]
    };
    let wanted =
        (0..points.len().saturating_sub(1)).filter(|&i| !left_out.get(i).is_some_and(|left| *left));
    wanted
        .map(piece)
        .fold([0.0; 2], |[sum, error], [part, its]| {
            [sum + part, error + its]
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn segment(points: &[[f64; 2]]) -> Segment {
        Segment {
            points: points.to_vec(),
            ..Segment::default()
        }
        .without_crowds()
    }

    fn value(points: &[[f64; 2]]) -> f64 {
        segment(points).integral()[0]
    }

    #[test]
    fn the_integral_is_exact_for_parabolas_on_any_mesh_and_in_both_directions() {
        let xs = [0.0, 0.3, 0.35, 1.1, 1.5];
        let mut points = xs.map(|x: f64| [x, 2.0 - x + 3.0 * x * x]).to_vec();
        let exact = 2.0 * 1.5 - 0.5 * 1.5f64.powi(2) + 1.5f64.powi(3);
        assert!((value(&points) - exact).abs() < 1e-14);
        points.insert(2, [0.3 + 1e-16, points[1][1] + 1e-13]);
        points.reverse();
        assert!((value(&points) + exact).abs() < 1e-12);
    }

    #[test]
    fn halving_the_steps_divides_the_error_by_sixteen_on_a_smooth_curve() {
        let error = |n: usize| {
            let points: Vec<_> = (0..=n)
                .map(|i| 3.0 * i as f64 / n as f64)
                .map(|x| [x, x.sin()])
                .collect();
            value(&points) - (1.0 - 3f64.cos())
        };
        let ratio = error(40) / error(80);
        assert!((ratio - 16.0).abs() < 4.0, "{ratio}");
    }

    #[test]
    fn states_that_crowd_at_a_fold_do_not_spoil_the_long_interval_before_them() {
        // y = sqrt(1 - x), steep at the end; by hand 2/3. Straight lines alone would miss the last
        // interval by a sixth of its box.
        let xs =
            (0..=20)
                .map(|i| 0.04 * f64::from(i))
                .chain([0.99, 0.9999, 0.999999, 1.0 - 1e-9, 1.0]);
        let points: Vec<_> = xs.map(|x: f64| [x, (1.0 - x).max(0.0).sqrt()]).collect();
        let missing = value(&points) - 2.0 / 3.0;
        assert!(missing.abs() < 0.19 * 0.45 / 6.0, "{missing}");
        // In the root of the distance it is a straight line.
        let [folded, _] = Segment {
            turns_back: true,
            ..segment(&points)
        }
        .integral();
        assert!((folded - 2.0 / 3.0).abs() < 1e-6, "{folded}");
    }

    #[test]
    fn the_estimate_of_the_error_holds_and_falls_with_the_steps() {
        let tried = [4, 8, 16, 32].map(|n: usize| {
            let points: Vec<_> = (0..=n)
                .map(|i| 3.0 * i as f64 / n as f64)
                .map(|x| [x, x.sin()])
                .collect();
            let [value, error] = segment(&points).integral();
            assert!(
                (value - (1.0 - 3f64.cos())).abs() <= error,
                "{n}: {value} {error}"
            );
            error
        });
        assert!(tried.windows(2).all(|w| w[1] < 0.3 * w[0]), "{tried:?}");
    }

    #[test]
    fn what_is_passed_both_ways_cancels_however_large_it_is() {
        let wall = |x: f64| [x, (-40.0 * x).exp()];
        let down: Vec<_> = [1.0, 0.5, 0.0, -0.5, -1.0].map(wall).to_vec();
        // Back the same way, but for the last part.
        let up: Vec<_> = [-1.0, -0.5, 0.0, 0.5]
            .map(wall)
            .into_iter()
            .chain([[1.0, 0.3]])
            .collect();
        let mut both = [segment(&down), segment(&up)];
        leave_out_retraced(&mut both);
        assert_eq!(both[0].retraced, [false, true, true, true]);
        assert_eq!(both[1].retraced, [true, true, true, false]);
        let sum: f64 = both.iter().map(|segment| segment.integral()[0]).sum();
        assert!(sum.abs() < 1.0, "{sum}");
    }

    #[test]
    fn a_sharp_bend_stays_inside_its_interval() {
        // A steep fall between 1 and 1.001, then a gentle slope: the steep one must not reach
        // beyond.
        let points = [
            [0.0, 1.0],
            [0.999, 1.0],
            [1.0, 1.0],
            [1.001, 0.5],
            [1.5, 0.49],
            [2.0, 0.48],
        ];
        // The trapezoid's own 1.490255 is right to a hundredth.
        assert!(
            (value(&points) - 1.490255).abs() < 0.01,
            "{}",
            value(&points)
        );
    }

    #[test]
    fn one_state_or_none_encloses_nothing() {
        assert_eq!(
            (
                value(&[]),
                value(&[[1.0, 2.0]]),
                value(&[[1.0, 2.0], [3.0, 2.0]])
            ),
            (0.0, 0.0, 4.0)
        );
    }
}
