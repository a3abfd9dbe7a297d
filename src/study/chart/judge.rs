//! What a loop is compared with, how far it is from there, what went wrong in it, and which loops
//! nothing else beats in both cost and error.

use super::points::LONGER;
use super::{Measured, Point};
use crate::follow::record::{Direction, JumpRecord, LoopRecord, StateRecord};
use crate::follow::run::Outcome;
use crate::numerics::dense::max_abs;
use crate::physics::mesh;
use crate::physics::pattern::Pattern;
use crate::solver::Stop;
use std::fmt;

/// A loss below this (over gamma) is none: errors are then absolute.
const LOSS_MIN: f64 = 1e-6;

/// Distances from the reference. NaN where there is nothing to compare.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    /// Of the dissipated energy, relative (absolute, over gamma, where nothing is dissipated).
    pub dissipated_energy: f64,
    /// Of the control at the worst matched jump, in its
    /// [`unit`](crate::physics::control::Control::unit): of u0 in ranges.
    pub jumps: f64,
    /// Root mean square of the mean stress where both are on the same pattern at the same control
    /// and away from jumps, over sigma_max.
    pub stress: f64,
}

impl Errors {
    /// The larger one of each; NaN wins.
    pub fn larger(self, other: Self) -> Self {
        let larger = |a: f64, b: f64| if a.is_nan() || a > b { a } else { b };
        Self {
            dissipated_energy: larger(self.dissipated_energy, other.dissipated_energy),
            jumps: larger(self.jumps, other.jumps),
            stress: larger(self.stress, other.stress),
        }
    }
}

/// What came of a point.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// Closed, every state converged and stable, every jump there.
    Done,
    /// Something is wrong with it, in words.
    Failed {
        /// What, as on the chart.
        what: String,
        /// Everything that is wrong.
        message: String,
    },
    /// Somebody asked to stop.
    Cancelled,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Verdict::Done => "done",
            Verdict::Failed { what, .. } => what,
            Verdict::Cancelled => "cancelled",
        })
    }
}

/// A row of the chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Judged {
    /// What was measured.
    pub point: Point,
    /// Its loss over gamma; NaN unless the loop is closed.
    pub dissipated_energy: f64,
    /// Distances from the reference.
    pub errors: Errors,
    /// Fourier transforms.
    pub transforms: usize,
    /// The same over the increments that ended in a pattern; NaN without any.
    pub transforms_per_increment: f64,
    /// Time on the wall.
    pub seconds: f64,
    /// Time of the processor.
    pub processor_seconds: f64,
    /// Nothing that is done is both nearer to the reference and cheaper in transforms.
    pub pareto_transforms: bool,
    /// The same for processor time.
    pub pareto_time: bool,
    /// What `tackscope run` would do.
    pub plan: bool,
    /// The budget of the paper.
    pub paper_budget: bool,
    /// What came of it.
    pub verdict: Verdict,
}

impl Judged {
    /// The row, in nothing marked.
    pub(super) fn new(measured: &Measured, comparison: Comparison) -> Self {
        let counts = measured.counts;
        Self {
            point: measured.point,
            dissipated_energy: measured.dissipated_energy(),
            errors: comparison.errors,
            transforms: counts.transforms,
            transforms_per_increment: match counts.patterned_increments {
                0 => f64::NAN,
                increments => counts.transforms as f64 / increments as f64,
            },
            seconds: measured.seconds,
            processor_seconds: measured.processor_seconds,
            pareto_transforms: false,
            pareto_time: false,
            plan: false,
            paper_budget: false,
            verdict: verdict(measured, comparison.faults),
        }
    }
}

/// A loop beside the reference.
pub(super) struct Comparison {
    pub(super) errors: Errors,
    /// Jumps that are missing or too many, in words.
    pub(super) faults: Vec<(String, String)>,
}

/// Compares a loop with `truth`.
pub(super) fn compare(measured: &Measured, truth: &Measured) -> Comparison {
    let (loss, expected) = (measured.dissipated_energy(), truth.dissipated_energy());
    let scale = if expected.abs() > LOSS_MIN {
        expected.abs()
    } else {
        1.0
    };
    let matched = matched(&measured.record.jumps, &truth.record.jumps);
    let unit = truth.record.control.unit(&truth.law);
    let late = matched
        .iter()
        .map(|(a, b)| (a.control - b.control).abs() / unit);
    let complete = measured.is_complete() && truth.is_complete();
    let jumps = if complete {
        late.fold(0.0, f64::max)
    } else {
        f64::NAN
    };
    let errors = Errors {
        dissipated_energy: (loss - expected).abs() / scale,
        jumps,
        stress: stress_error(measured, truth),
    };
    let faults = if complete {
        jump_faults(measured, truth, matched.len())
    } else {
        Vec::new()
    };
    Comparison { errors, faults }
}

/// The longest common sequence of jumps (branch, pattern before and after), in order.
fn matched<'a>(a: &'a [JumpRecord], b: &'a [JumpRecord]) -> Vec<(&'a JumpRecord, &'a JumpRecord)> {
    let same = |i: usize, j: usize| {
        (a[i].direction, a[i].from, a[i].to) == (b[j].direction, b[j].from, b[j].to)
    };
    let mut length = vec![vec![0; b.len() + 1]; a.len() + 1];
    for i in (0..a.len()).rev() {
        for j in (0..b.len()).rev() {
            let skip = length[i + 1][j].max(length[i][j + 1]);
            length[i][j] = if same(i, j) {
                skip.max(1 + length[i + 1][j + 1])
            } else {
                skip
            };
        }
    }
    let (mut i, mut j, mut pairs) = (0, 0, Vec::new());
    while i < a.len() && j < b.len() {
        if same(i, j) && length[i][j] == 1 + length[i + 1][j + 1] {
            pairs.push((&a[i], &b[j]));
            (i, j) = (i + 1, j + 1);
        } else if length[i + 1][j] >= length[i][j + 1] {
            i += 1;
        } else {
            j += 1;
        }
    }
    pairs
}

/// What is wrong with the jumps, in short for a chart and in full.
fn jump_faults(measured: &Measured, truth: &Measured, matched: usize) -> Vec<(String, String)> {
    let (ours, theirs) = (&measured.record, &truth.record);
    let mut faults = Vec::new();
    for branch in Direction::BOTH {
        let reached = |record: &LoopRecord, p: Pattern| {
            record
                .jumps
                .iter()
                .any(|j| j.direction == branch && j.to == p)
        };
        for pattern in [
            Pattern::Bulge,
            Pattern::Ridge,
            Pattern::Dimple,
            Pattern::Contact,
            Pattern::Other,
            Pattern::Flat,
        ] {
            if reached(theirs, pattern) && !reached(ours, pattern) {
                faults.push((
                    format!("{pattern} skipped"),
                    format!("{pattern} skipped on {branch}"),
                ));
            }
        }
    }
    let missing = theirs.jumps.len() - matched;
    if missing > 0 && faults.is_empty() {
        faults.push((
            "jumps missing".to_owned(),
            format!("{missing} jumps missing"),
        ));
    }
    let extra = ours.jumps.len() - matched;
    if extra > 0 {
        let whose = if measured.mu_rho > mesh::SAFE {
            "jumps of the mesh"
        } else {
            "extra jumps"
        };
        faults.push((whose.to_owned(), format!("{extra} {whose}")));
    }
    faults
}

/// What is wrong with a loop, the gravest first.
fn verdict(measured: &Measured, jumps: Vec<(String, String)>) -> Verdict {
    let failed = |what: String, message: String| Verdict::Failed { what, message };
    match &measured.outcome {
        Outcome::Cancelled if measured.out_of_time => {
            return failed(
                "out of time".to_owned(),
                "took longer than predicted".to_owned(),
            );
        }
        Outcome::Cancelled => return Verdict::Cancelled,
        Outcome::NotConverged {
            mean_displacement,
            reason,
        } => {
            return failed(
                reason.what(),
                format!("{reason}; last state at u0 = {mean_displacement}"),
            );
        }
        Outcome::Completed => {}
    }
    if let Some(open) = measured.ledger().and_then(|ledger| ledger.open) {
        return failed(
            "loop not closed".to_owned(),
            format!("loop not closed: {}; {}", open.reason, open.remedy),
        );
    }
    let states = &measured.record.states;
    let with = |stop: Stop| states.iter().filter(|s| s.stop == stop).count();
    let mut faults = Vec::new();
    if with(Stop::Unstable) > 0 {
        faults.push((
            "unstable state kept".to_owned(),
            format!(
                "{} of {} states are unstable",
                with(Stop::Unstable),
                states.len()
            ),
        ));
    }
    faults.extend(jumps);
    if with(Stop::NotConverged) > 0 {
        let worst = max_abs(&states.iter().map(|s| s.residual).collect::<Vec<_>>());
        let message = format!(
            "{} of {} states above the tolerance, residual up to {worst:.1e}",
            with(Stop::NotConverged),
            states.len()
        );
        faults.push(("not converged".to_owned(), message));
    }
    match faults.first() {
        None => Verdict::Done,
        Some((what, _)) => failed(
            what.clone(),
            faults
                .iter()
                .map(|(_, message)| message.as_str())
                .collect::<Vec<_>>()
                .join("; "),
        ),
    }
}

/// Root mean square difference of the stress over the states of `measured` that are on the same
/// pattern as `truth` and away from the jumps of both, over sigma_max.
fn stress_error(measured: &Measured, truth: &Measured) -> f64 {
    let unit = truth.record.control.unit(&truth.law);
    let away = (2.0 * measured.point.step).max(0.1 * unit);
    let (mut sum, mut count) = (0.0, 0);
    let mut curve = Direction::BOTH.map(|branch| Curve::new(&truth.record.states, branch));
    for state in &measured.record.states {
        let value = state.control;
        let jumps = measured.record.jumps.iter().chain(&truth.record.jumps);
        if jumps
            .filter(|j| j.direction == state.direction)
            .any(|j| (j.control - value).abs() < away)
        {
            continue;
        }
        if let Some((stress, pattern)) =
            curve[usize::from(state.direction == Direction::Retraction)].at(value)
            && pattern == state.pattern
        {
            sum += (state.stress - stress).powi(2);
            count += 1;
        }
    }
    if count == 0 {
        f64::NAN
    } else {
        (sum / f64::from(count)).sqrt() / truth.law.traction_max()
    }
}

/// Stress and pattern of a branch by linear interpolation, exact where the states coincide.
struct Curve<'a> {
    states: Vec<&'a StateRecord>,
}

impl<'a> Curve<'a> {
    fn new(states: &'a [StateRecord], direction: Direction) -> Self {
        let mut states: Vec<_> = states.iter().filter(|s| s.direction == direction).collect();
        states.sort_by(|a, b| a.control.total_cmp(&b.control));
        Self { states }
    }

    fn at(&mut self, value: f64) -> Option<(f64, Pattern)> {
        let after = self.states.partition_point(|s| s.control < value);
        let b = self.states.get(after)?;
        if b.control == value {
            return Some((b.stress, b.pattern));
        }
        let a = self.states.get(after.checked_sub(1)?)?;
        let t = (value - a.control) / (b.control - a.control);
        (a.pattern == b.pattern).then_some((a.stress + t * (b.stress - a.stress), a.pattern))
    }
}

/// Which of the points (cost, error) are on the front: no other is at most as dear and at most as
/// wrong, and less of one of the two. A point with a number that is not finite is never on it, and
/// beats nothing.
pub fn front(points: &[(f64, f64)]) -> Vec<bool> {
    let finite = |(cost, error): (f64, f64)| cost.is_finite() && error.is_finite();
    let beats = |a: (f64, f64), b: (f64, f64)| finite(a) && a.0 <= b.0 && a.1 <= b.1 && a != b;
    points
        .iter()
        .map(|&b| finite(b) && !points.iter().any(|&a| beats(a, b)))
        .collect()
}

/// Which rows are on the front of dissipated energy against this cost. Failures are on none; below
/// `floor`, the reference's own error, nothing is told apart.
pub fn on_front(rows: &[Judged], floor: f64, cost: impl Fn(&Judged) -> f64) -> Vec<bool> {
    let error = |row: &Judged| match row.verdict {
        Verdict::Done => row.errors.dissipated_energy.max(floor),
        _ => f64::NAN,
    };
    let points = rows.iter().map(|row| (cost(row), error(row)));
    front(&points.collect::<Vec<_>>())
}

/// Marks the rows on the fronts of dissipated energy against transforms and against processor time.
pub(super) fn mark(rows: &mut [Judged], floor: f64) {
    let by_transforms = on_front(rows, floor, |row| row.transforms as f64);
    let by_time = on_front(rows, floor, |row| row.processor_seconds);
    for ((row, transforms), time) in rows.iter_mut().zip(by_transforms).zip(by_time) {
        (row.pareto_transforms, row.pareto_time) = (transforms, time);
    }
}

/// The finest solution, with its own error estimate.
#[derive(Clone, Debug)]
pub struct Reference {
    /// The loop with the finest mesh and step.
    pub finest: Measured,
    /// Loss over gamma: its sum of releases.
    pub dissipated_energy: f64,
    /// Loop integral over gamma, extrapolated in the step (Richardson, second order).
    pub integral: f64,
    /// What a coarser mesh, or a longer step, changes: upper bounds of its own errors. NaN if it
    /// failed.
    pub errors: Errors,
}

impl Reference {
    /// From three loops: the finest, one on a coarser mesh, one with a longer step.
    pub fn new([finest, coarser, longer]: [Measured; 3]) -> Self {
        let errors = compare(&coarser, &finest)
            .errors
            .larger(compare(&longer, &finest).errors);
        let longer = longer.integral();
        let integral = finest.integral() + (finest.integral() - longer) / (LONGER * LONGER - 1.0);
        Self {
            dissipated_energy: finest.dissipated_energy(),
            integral,
            errors,
            finest,
        }
    }

    /// The row of a measured loop.
    pub fn judge(&self, measured: &Measured) -> Judged {
        Judged::new(measured, compare(measured, &self.finest))
    }

    /// Its own row, whose errors are its own estimates.
    pub fn judged(&self) -> Judged {
        Judged::new(
            &self.finest,
            Comparison {
                errors: self.errors,
                faults: Vec::new(),
            },
        )
    }

    /// Its own settings.
    pub fn point(&self) -> &Point {
        &self.finest.point
    }
}
