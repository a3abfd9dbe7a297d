//! Curves over the mean displacement, ready to draw, cut at jumps, never more than a few thousand points: stress against u0, and the
//! smallest eigenvalue against u0.

use crate::experiment::record::{Branch, Cause, JumpRecord, StateRecord};
use crate::experiment::scene::{Model, Scene};
use crate::physics::indenter::Indenter;
use crate::physics::law::Law;
use crate::physics::pattern::Pattern;
use crate::physics::theory::flat;
use crate::ui::scene_edit;

/// Most points of one curve; beyond it every second one is dropped. Drawing 100 000 costs 28 ms.
const POINTS_MAX: usize = 4000;

/// A stretch of one branch without a jump.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// Direction of the drive.
    pub branch: Branch,
    /// The pattern of its newest state.
    pub pattern: Pattern,
    /// (u0/rho, stress/sigma_max or another ordinate) in the order they were reached.
    pub points: Vec<[f64; 2]>,
}

/// A path through (u0, stress), or through another quantity of the states.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// Its pieces in order.
    pub pieces: Vec<Piece>,
    count: usize,
    broken: bool,
}

impl Curve {
    /// Adds a state with its stress.
    pub fn push(&mut self, state: &StateRecord, law: &Law) {
        self.push_with(state, law, state.stress_over_max);
    }

    /// Adds a state with this ordinate. After a jump it begins a new piece; a change of direction begins one too, joined to the old.
    pub fn push_with(&mut self, state: &StateRecord, law: &Law, ordinate: f64) {
        let point = [state.mean_displacement / law.range, ordinate];
        let jumped = std::mem::take(&mut self.broken);
        let last = self.pieces.last().and_then(|piece| piece.points.last().copied());
        match self.pieces.last_mut() {
            Some(piece) if !jumped && piece.branch == state.branch => {
                piece.pattern = state.pattern;
                piece.points.push(point);
            }
            _ => {
                let points = last.filter(|_| !jumped).into_iter().chain([point]).collect();
                self.pieces.push(Piece { branch: state.branch, pattern: state.pattern, points });
            }
        }
        self.count += 1;
        if self.count > POINTS_MAX {
            self.thin();
        }
    }

    /// Adds a jump: the branch ends at its foot, and the next state begins a new piece.
    pub fn jump(&mut self, jump: &JumpRecord, law: &Law) {
        // Where nothing was located the foot is not known better than the last state.
        if jump.cause != Cause::PatternChange
            && let Some(piece) = self.pieces.last_mut().filter(|piece| piece.branch == jump.branch)
        {
            piece.points.push([jump.mean_displacement / law.range, jump.stress_before / law.traction_max()]);
        }
        self.cut();
    }

    /// The next state begins a new piece.
    pub fn cut(&mut self) {
        self.broken = true;
    }

    /// Every point.
    pub fn points(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        self.pieces.iter().flat_map(|piece| piece.points.iter().copied())
    }

    /// Drops every second inner point; the ends of pieces (jumps, turns) stay where they are.
    fn thin(&mut self) {
        if self.pieces.len() > POINTS_MAX / 2 {
            self.pieces.drain(..POINTS_MAX / 4);
        }
        for piece in &mut self.pieces {
            let last = piece.points.len().saturating_sub(1);
            let mut i = 0;
            piece.points.retain(|_| {
                i += 1;
                i % 2 == 1 || i - 1 == last
            });
        }
        self.count = self.pieces.iter().map(|piece| piece.points.len()).sum();
    }
}

/// Below this magnitude (E*/L) eigenvalues are drawn to a linear scale, above it to a logarithmic one.
const LINEAR: f64 = 0.1;

/// Where an eigenvalue (E*/L) stands on its axis: an inverse hyperbolic sine, on which both a soft pattern and a pressed one are seen.
pub fn eigenvalue_scale(eigenvalue: f64) -> f64 {
    (eigenvalue / LINEAR).asinh()
}

/// The eigenvalue at a place of that axis.
pub fn eigenvalue_at(place: f64) -> f64 {
    LINEAR * place.sinh()
}

/// The area between the branches of a closed loop.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shade {
    /// u0/rho, ascending.
    pub x: Vec<f64>,
    /// The lower of both branches, stress/sigma_max.
    pub low: Vec<f64>,
    /// The upper of both branches.
    pub high: Vec<f64>,
}

impl Shade {
    /// The area between approach and retraction of `curve`, where both are known.
    pub fn of(curve: &Curve) -> Shade {
        let branch = |branch: Branch| {
            let mut points: Vec<[f64; 2]> =
                curve.pieces.iter().filter(|piece| piece.branch == branch).flat_map(|piece| piece.points.clone()).collect();
            points.sort_by(|a, b| a[0].total_cmp(&b[0]));
            points
        };
        let (approach, retraction) = (branch(Branch::Approach), branch(Branch::Retraction));
        let (Some(a0), Some(a1), Some(r0), Some(r1)) = (approach.first(), approach.last(), retraction.first(), retraction.last())
        else {
            return Shade::default();
        };
        let (from, to) = (a0[0].max(r0[0]), a1[0].min(r1[0]));
        let steps = 800;
        let mut shade = Shade::default();
        for i in 0..=steps {
            let x = from + (to - from) * f64::from(i) / f64::from(steps);
            let (a, r) = (interpolate(&approach, x), interpolate(&retraction, x));
            shade.x.push(x);
            shade.low.push(a.min(r));
            shade.high.push(a.max(r));
        }
        shade
    }
}

/// Linear interpolation in points sorted by x.
fn interpolate(points: &[[f64; 2]], x: f64) -> f64 {
    let i = points.partition_point(|p| p[0] < x);
    match (i.checked_sub(1).map(|i| points[i]), points.get(i)) {
        (Some(a), Some(b)) if b[0] > a[0] => a[1] + (b[1] - a[1]) * (x - a[0]) / (b[0] - a[0]),
        (_, Some(b)) => b[1],
        (Some(a), None) => a[1],
        (None, None) => 0.0,
    }
}

/// The flat state's closed form in pieces of equal stability (true: stable). Empty on uneven ground.
pub fn flat_state(scene: &Scene, model: &Model) -> Vec<(bool, Vec<[f64; 2]>)> {
    if model.indenter != Indenter::Flat {
        return Vec::new();
    }
    let (lower, upper) = scene_edit::limits(scene, model);
    let mut pieces: Vec<(bool, Vec<[f64; 2]>)> = Vec::new();
    for i in 0..=600 {
        let u0 = lower + (upper - lower) * f64::from(i) / 600.0;
        let stable = flat::stiffness_min(&model.law, model.grid.length, u0) >= 0.0;
        let point = [u0 / model.law.range, model.law.at(u0).traction / model.law.traction_max()];
        match pieces.last_mut() {
            Some((same, points)) if *same == stable => points.push(point),
            Some((_, points)) => {
                points.push(point);
                pieces.push((stable, vec![point]));
            }
            None => pieces.push((stable, vec![point])),
        }
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::law::{Morse, Shape};

    const LAW: Law = Law { shape: Shape::Morse(Morse), surface_energy: 1.0, range: 2.0 };

    fn state(branch: Branch, u0: f64, stress_over_max: f64) -> StateRecord {
        StateRecord { branch, stress_over_max, ..StateRecord::placeholder(u0) }
    }

    #[test]
    fn a_jump_ends_the_branch_at_its_foot_and_begins_a_new_piece() {
        let mut curve = Curve::default();
        curve.push(&state(Branch::Approach, 8.0, 0.1), &LAW);
        let jump = JumpRecord {
            branch: Branch::Approach,
            mean_displacement: 7.0,
            from: Pattern::Flat,
            to: Pattern::Ridge,
            stress_before: 0.2 * LAW.traction_max(),
            stress_after: 0.4 * LAW.traction_max(),
            released_energy: 0.1,
            release_error: 0.0,
            cause: Cause::FlatLimit,
            landings: Vec::new(),
        };
        curve.jump(&jump, &LAW);
        curve.push(&state(Branch::Approach, 7.0, 0.4), &LAW);
        curve.push(&state(Branch::Approach, 6.0, 0.5), &LAW);
        let points: Vec<_> = curve.pieces.iter().map(|piece| piece.points.clone()).collect();
        assert_eq!(points, [vec![[4.0, 0.1], [3.5, 0.2]], vec![[3.5, 0.4], [3.0, 0.5]]]);
    }

    #[test]
    fn a_turn_joins_its_pieces() {
        let mut curve = Curve::default();
        curve.push(&state(Branch::Approach, 4.0, 0.1), &LAW);
        curve.push(&state(Branch::Retraction, 6.0, 0.2), &LAW);
        assert_eq!(curve.pieces[1].points, [[2.0, 0.1], [3.0, 0.2]]);
    }

    #[test]
    fn a_long_curve_stays_short_and_keeps_its_ends() {
        let mut curve = Curve::default();
        for i in 0..50_000 {
            curve.push(&state(Branch::Approach, -f64::from(i), 0.0), &LAW);
        }
        assert!(curve.points().count() <= POINTS_MAX + 1);
        assert_eq!(curve.points().next(), Some([0.0, 0.0]));
        assert_eq!(curve.points().last(), Some([-24_999.5, 0.0]));
    }

    #[test]
    fn the_shade_has_the_area_between_the_branches() {
        let mut curve = Curve::default();
        for (branch, u0, stress) in [
            (Branch::Approach, 8.0, 0.1),
            (Branch::Approach, 2.0, 0.1),
            (Branch::Retraction, 2.0, 0.5),
            (Branch::Retraction, 8.0, 0.3),
        ] {
            curve.push(&state(branch, u0, stress), &LAW);
        }
        let shade = Shade::of(&curve);
        let width = shade.x[1] - shade.x[0];
        let area: f64 = shade.high.iter().zip(&shade.low).map(|(high, low)| (high - low) * width).sum();
        assert!((area - 0.9).abs() < 0.01, "{area}");
    }
}
