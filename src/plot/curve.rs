//! Curves over the mean displacement, cut at jumps: stress against u0, and the smallest eigenvalue
//! against u0.

use crate::follow::record::{Direction, LoopRecord, StateRecord};
use crate::physics::law::Law;
use crate::physics::pattern::Pattern;
use crate::solver::Stop;

/// Most points of a curve that grows in the window; beyond it every second one is dropped. Drawing
/// 100 000 costs 28 ms a frame.
const POINTS_MAX: usize = 4000;

/// What the states of a piece are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PieceKind {
    /// Stable equilibria.
    Stable,
    /// Equilibria that are not stable.
    Unstable,
    /// No equilibria: where a method was left before it came to rest.
    NotConverged,
}

impl From<Stop> for PieceKind {
    fn from(stop: Stop) -> Self {
        match stop {
            Stop::Stable | Stop::ReadOff => Self::Stable,
            Stop::Unstable => Self::Unstable,
            Stop::NotConverged | Stop::Cancelled => Self::NotConverged,
        }
    }
}

/// A stretch of one branch without a jump.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// Direction of the drive.
    pub direction: Direction,
    /// What its states are, all alike.
    pub kind: PieceKind,
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
    /// The whole curve of a record.
    pub fn of(record: &LoopRecord, law: &Law) -> Self {
        Self::of_ordinate(record, law, |state| state.stress_over_max)
    }

    /// The same of another ordinate.
    pub fn of_ordinate(
        record: &LoopRecord,
        law: &Law,
        ordinate: impl Fn(&StateRecord) -> f64,
    ) -> Self {
        let mut curve = Self::default();
        let mut before: Option<&StateRecord> = None;
        let known = |s: &&StateRecord| s.mean_displacement.is_finite() && ordinate(s).is_finite();
        for state in record.states.iter().filter(known) {
            if before.is_some_and(|before| jumped(before, state, record)) {
                curve.cut();
            }
            curve.add(state, law, ordinate(state));
            before = Some(state);
        }
        curve
    }

    /// Adds a state with its stress.
    pub fn push(&mut self, state: &StateRecord, law: &Law) {
        self.push_with(state, law, state.stress_over_max);
    }

    /// Adds a state with this ordinate, and thins a curve that has grown long. After a cut or a
    /// change of direction it begins a new piece.
    pub fn push_with(&mut self, state: &StateRecord, law: &Law, ordinate: f64) {
        self.add(state, law, ordinate);
        if self.count > POINTS_MAX {
            self.thin();
        }
    }

    fn add(&mut self, state: &StateRecord, law: &Law, ordinate: f64) {
        let point = [state.mean_displacement / law.range, ordinate];
        let cut = std::mem::take(&mut self.broken);
        let kind = PieceKind::from(state.stop);
        match self.pieces.last_mut() {
            Some(piece) if !cut && (piece.direction, piece.kind) == (state.direction, kind) => {
                piece.pattern = state.pattern;
                piece.points.push(point);
            }
            _ => self.pieces.push(Piece {
                direction: state.direction,
                kind,
                pattern: state.pattern,
                points: vec![point],
            }),
        }
        self.count += 1;
    }

    /// The next state begins a new piece.
    pub fn cut(&mut self) {
        self.broken = true;
    }

    /// Every point.
    pub fn points(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        self.pieces
            .iter()
            .flat_map(|piece| piece.points.iter().copied())
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

/// True if the surface jumped between two neighbours: they share one value of the control, or a
/// recorded jump changed the pattern between them.
fn jumped(a: &StateRecord, b: &StateRecord, record: &LoopRecord) -> bool {
    let (low, high) = (a.control.min(b.control), a.control.max(b.control));
    let between = |control: f64| (low..=high).contains(&control);
    let recorded = || {
        record
            .jumps
            .iter()
            .any(|j| j.direction == b.direction && between(j.control))
    };
    a.direction == b.direction && (low == high || a.pattern != b.pattern) && recorded()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::law::{Morse, Shape};

    const LAW: Law = Law {
        shape: Shape::Morse(Morse),
        surface_energy: 1.0,
        range: 2.0,
    };

    fn state(direction: Direction, u0: f64, stress_over_max: f64) -> StateRecord {
        StateRecord {
            direction,
            stress_over_max,
            ..StateRecord::placeholder(u0)
        }
    }

    #[test]
    fn a_cut_begins_a_new_piece_and_nothing_joins_them() {
        let mut curve = Curve::default();
        curve.push(&state(Direction::Approach, 8.0, 0.1), &LAW);
        curve.push(&state(Direction::Approach, 7.0, 0.2), &LAW);
        curve.cut();
        curve.push(&state(Direction::Approach, 7.0, 0.4), &LAW);
        curve.push(&state(Direction::Approach, 6.0, 0.5), &LAW);
        let points: Vec<_> = curve
            .pieces
            .iter()
            .map(|piece| piece.points.clone())
            .collect();
        assert_eq!(
            points,
            [vec![[4.0, 0.1], [3.5, 0.2]], vec![[3.5, 0.4], [3.0, 0.5]]]
        );
    }

    #[test]
    fn where_states_are_no_equilibria_any_more_a_new_piece_begins() {
        let mut curve = Curve::default();
        for (u0, stop) in [
            (8.0, Stop::Stable),
            (7.0, Stop::ReadOff),
            (6.0, Stop::NotConverged),
            (5.0, Stop::Cancelled),
            (4.0, Stop::Unstable),
        ] {
            let state = StateRecord {
                stop,
                ..state(Direction::Approach, u0, 0.0)
            };
            curve.push(&state, &LAW);
        }
        let pieces: Vec<_> = curve
            .pieces
            .iter()
            .map(|p| (p.kind, p.points.len()))
            .collect();
        assert_eq!(
            pieces,
            [
                (PieceKind::Stable, 2),
                (PieceKind::NotConverged, 2),
                (PieceKind::Unstable, 1)
            ]
        );
    }

    #[test]
    fn a_turn_begins_a_new_piece() {
        let mut curve = Curve::default();
        curve.push(&state(Direction::Approach, 4.0, 0.1), &LAW);
        curve.push(&state(Direction::Retraction, 6.0, 0.2), &LAW);
        assert_eq!(curve.pieces[1].points, [[3.0, 0.2]]);
    }

    #[test]
    fn a_long_curve_stays_short_and_keeps_its_ends() {
        let mut curve = Curve::default();
        for i in 0..50_000 {
            curve.push(&state(Direction::Approach, -f64::from(i), 0.0), &LAW);
        }
        assert!(curve.points().count() <= POINTS_MAX + 1);
        assert_eq!(curve.points().next(), Some([0.0, 0.0]));
        assert_eq!(curve.points().last(), Some([-24_999.5, 0.0]));
    }
}
