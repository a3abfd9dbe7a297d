//! What a walk leaves behind: states, jumps, and the loop with its energy ledger.

use crate::physics::pattern::Pattern;
use crate::solver::Stop;
use std::fmt;

/// Direction of the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Branch {
    /// u0 decreases.
    Approach,
    /// u0 increases.
    Retraction,
}

impl fmt::Display for Branch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Branch::Approach => "approach",
            Branch::Retraction => "retraction",
        })
    }
}

/// One equilibrium on the way.
#[derive(Clone, Debug, PartialEq)]
pub struct StateRecord {
    /// Direction of the drive.
    pub branch: Branch,
    /// Mean displacement u0 (length).
    pub mean_displacement: f64,
    /// Mean stress, positive in tension (E*).
    pub stress: f64,
    /// Mean stress over the law's largest traction.
    pub stress_over_max: f64,
    /// Share of the cell with a gap below that of the largest traction, 0 to 1.
    pub contact_area: f64,
    /// Pattern by topology.
    pub pattern: Pattern,
    /// max |residual traction| / sigma_max.
    pub residual: f64,
    /// Smallest Hessian eigenvalue per area, sliding modes removed (E*/L).
    pub stiffness_min: f64,
    /// Bound on the error of `stiffness_min` (E*/L).
    pub stiffness_error: f64,
    /// Energy per area (E* times length).
    pub energy: f64,
    /// Which model produced it ("flat, closed form"; "whole cell 64 x 64"; ...).
    pub model: &'static str,
    /// Why the solver stopped here.
    pub stop: Stop,
    /// Iterations of the method spent on it (Newton steps or time steps).
    pub iterations: usize,
    /// Fourier transforms spent on it.
    pub transforms: usize,
    /// Wall milliseconds spent on it.
    pub milliseconds: f64,
}

impl StateRecord {
    /// A record to stand in until the first state is measured.
    pub(crate) fn placeholder(mean_displacement: f64) -> Self {
        Self {
            branch: Branch::Approach,
            mean_displacement,
            stress: f64::NAN,
            stress_over_max: f64::NAN,
            contact_area: f64::NAN,
            pattern: Pattern::Other,
            residual: f64::NAN,
            stiffness_min: f64::NAN,
            stiffness_error: f64::NAN,
            energy: f64::NAN,
            model: "",
            stop: Stop::NotConverged,
            iterations: 0,
            transforms: 0,
            milliseconds: 0.0,
        }
    }
}

/// What made a state give way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Cause {
    /// The flat state lost stability (Eq. 8).
    FlatLimit,
    /// The branch turned back.
    Fold,
    /// An eigenvalue went through zero on a branch that goes on, unstable.
    SymmetryBreaking,
    /// Seen as a change of pattern between two increments of a method that locates nothing.
    PatternChange,
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Cause::FlatLimit => "flat limit",
            Cause::Fold => "fold",
            Cause::SymmetryBreaking => "symmetry breaking",
            Cause::PatternChange => "pattern change",
        })
    }
}

/// A jump at fixed u0.
#[derive(Clone, Debug, PartialEq)]
pub struct JumpRecord {
    /// Direction of the drive.
    pub branch: Branch,
    /// Where it happened (length).
    pub mean_displacement: f64,
    /// Pattern before.
    pub from: Pattern,
    /// Pattern after.
    pub to: Pattern,
    /// Mean stress before (E*).
    pub stress_before: f64,
    /// Mean stress after (E*).
    pub stress_after: f64,
    /// Energy released per area, in units of gamma.
    pub released_energy: f64,
    /// What gave way.
    pub cause: Cause,
}

/// Everything recorded along a path, in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoopRecord {
    /// The states in the order they were reached. A jump stands between two states of equal u0.
    pub states: Vec<StateRecord>,
    /// The jumps in the order they happened.
    pub jumps: Vec<JumpRecord>,
}

impl LoopRecord {
    /// The loop integral of stress du0 over the recorded states, energy per area (E* times length).
    ///
    /// Along each smooth stretch a cubic in every interval, with slopes from the neighbouring states; at a jump the stress before it
    /// holds up to the jump, which is a vertical line. Positive for a closed approach and retraction.
    pub fn work(&self) -> f64 {
        let mut jumps = self.jumps.iter().peekable();
        let mut sum = 0.0;
        let mut stretch: Vec<[f64; 2]> = Vec::new();
        for pair in self.states.windows(2) {
            let [a, b] = [&pair[0], &pair[1]].map(|s| [s.mean_displacement, s.stress]);
            if pair[0].branch != pair[1].branch {
                sum += integral(&stretch);
                stretch.clear();
            }
            if stretch.is_empty() {
                stretch.push(a);
            }
            match jumps.next_if(|j| j.branch == pair[1].branch && j.mean_displacement == b[0]) {
                None => {
                    stretch.push(b);
                    continue;
                }
                Some(jump) if jump.cause != Cause::PatternChange => stretch.push([b[0], jump.stress_before]),
                // Somewhere in between: half of the way on either side.
                Some(_) => sum += 0.5 * (a[1] + b[1]) * (b[0] - a[0]),
            }
            sum += integral(&stretch);
            stretch.clear();
        }
        sum + integral(&stretch)
    }

    /// Sum of the released energies, in units of gamma.
    pub fn released_energy_sum(&self) -> f64 {
        self.jumps.iter().map(|jump| jump.released_energy).sum()
    }
}

/// How many times shorter an interval may be than its neighbour and still tell of its slope.
const CROWDED: f64 = 8.0;

/// The integral of a smooth curve through the points (x, y), x growing or falling: in every interval the cubic with the slopes of
/// the parabolas through neighbouring points. Points that only rounding holds apart count once.
fn integral(points: &[[f64; 2]]) -> f64 {
    let Some((first, last)) = points.first().zip(points.last()) else { return 0.0 };
    let near = 1e-6 * (last[0] - first[0]).abs() / points.len() as f64;
    let mut points = points.to_vec();
    points.dedup_by(|b, a| (b[0] - a[0]).abs() <= near);
    let secant = |a: [f64; 2], b: [f64; 2]| (b[1] - a[1]) / (b[0] - a[0]);
    // The parabola's slope at the first of three points, which may be in any order.
    let slope = |at: [f64; 2], b: [f64; 2], c: [f64; 2]| secant(at, b) + secant(at, c) - secant(b, c);
    let slopes: Vec<f64> = (0..points.len())
        .map(|i| match (i.checked_sub(1), points.get(i + 1)) {
            (Some(before), Some(&after)) => slope(points[i], points[before], after),
            (None, Some(&after)) => points.get(2).map_or_else(|| secant(points[0], after), |&third| slope(points[0], after, third)),
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
        // Next to a fold the states crowd together, and the slope among them says nothing about a long interval beside them: there the
        // parabola with the other slope.
        let holds = |neighbour: Option<f64>| neighbour.is_some_and(|n| CROWDED * n >= h.abs());
        let bend = match (holds(before.or(after)), holds(after.or(before))) {
            (true, true) => slopes[i] - slopes[i + 1],
            (true, false) => 2.0 * (slopes[i] - k),
            (false, true) => 2.0 * (k - slopes[i + 1]),
            (false, false) => 0.0,
        };
        0.5 * h * (a[1] + b[1]) + h * h / 12.0 * bend
    };
    (0..points.len().saturating_sub(1)).map(piece).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_integral_is_exact_for_parabolas_on_any_mesh_and_in_both_directions() {
        let xs = [0.0, 0.3, 0.35, 1.1, 1.5];
        let mut points = xs.map(|x: f64| [x, 2.0 - x + 3.0 * x * x]).to_vec();
        let exact = 2.0 * 1.5 - 0.5 * 1.5f64.powi(2) + 1.5f64.powi(3);
        assert!((integral(&points) - exact).abs() < 1e-14);
        points.insert(2, [0.3 + 1e-16, points[1][1] + 1e-13]);
        points.reverse();
        assert!((integral(&points) + exact).abs() < 1e-12);
    }

    #[test]
    fn halving_the_steps_divides_the_error_by_sixteen_on_a_smooth_curve() {
        let error = |n: usize| {
            let points: Vec<_> = (0..=n).map(|i| 3.0 * i as f64 / n as f64).map(|x| [x, x.sin()]).collect();
            integral(&points) - (1.0 - 3f64.cos())
        };
        let ratio = error(40) / error(80);
        assert!((ratio - 16.0).abs() < 4.0, "{ratio}");
    }

    #[test]
    fn states_that_crowd_at_a_fold_do_not_spoil_the_long_interval_before_them() {
        // y = sqrt(1 - x), steep at the end; by hand 2/3. Straight lines alone would miss the last interval by a sixth of its box.
        let xs = (0..=20).map(|i| 0.04 * i as f64).chain([0.99, 0.9999, 0.999999, 1.0 - 1e-9, 1.0]);
        let points: Vec<_> = xs.map(|x: f64| [x, (1.0 - x).max(0.0).sqrt()]).collect();
        let missing = integral(&points) - 2.0 / 3.0;
        assert!(missing.abs() < 0.19 * 0.45 / 6.0, "{missing}");
    }

    #[test]
    fn one_state_or_none_encloses_nothing() {
        assert_eq!((integral(&[]), integral(&[[1.0, 2.0]]), integral(&[[1.0, 2.0], [3.0, 2.0]])), (0.0, 0.0, 4.0));
    }
}
