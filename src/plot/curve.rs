//! Curves over the mean displacement. Of a record, cut at jumps: stress against u0, and the smallest
//! eigenvalue against u0. Of theory, in the units of the scene at hand: the flat state and the
//! patterns of zero range, or JKR's tip.

use super::scale::steps;
use crate::follow::record::{Direction, LoopRecord, StateRecord};
use crate::numerics::threads::Cancel;
use crate::physics::body::Body;
use crate::physics::indenter::{Hertz, Indenter};
use crate::physics::law::Law;
use crate::physics::pattern::Pattern;
use crate::physics::theory::jkr::{Contact, Jkr, PeriodicJkr};
use crate::physics::theory::{Units, circular, ridge};
use crate::scene::Model;
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

/// A piece of one branch without a jump.
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

/// Points of a curve.
const THEORY_POINTS: usize = 160;
/// The same for a tip, whose states are dearer.
const TIP_POINTS: usize = 60;
/// Largest contact radius over the length of the cell: beyond, images touch.
const LARGEST_CONTACT: f64 = 0.4;

/// p~(u~) of the patterns of an adhesion without range: the same for every scene on flat ground.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ZeroRange {
    curves: Vec<(&'static str, Vec<[f64; 2]>)>,
}

/// A curve of theory for a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct TheoryLine {
    /// Its name.
    pub name: &'static str,
    /// (u0 (length), mean stress (E*, tensile positive)) by growing u0.
    pub points: Vec<[f64; 2]>,
}

impl ZeroRange {
    /// Computes the curves; the first time takes some tenths of a second. `None` if cancelled.
    pub fn compute(cancel: &Cancel) -> Option<Self> {
        // Each from 0 (not included) to its end; stable parts only.
        let up_to = |end: f64| {
            steps(0.0, end, THEORY_POINTS)
                .skip(1)
                .take_while(|_| !cancel.requested())
        };
        let ridge_end = ridge::critical().displacement;
        let ridge = up_to(ridge_end)
            .filter_map(|u| ridge::pressure(u.min(ridge_end)).map(|p| [u, p]))
            .collect();
        let circle = |pattern: &circular::Pattern| {
            let end = pattern.fold().displacement;
            up_to(end)
                .filter_map(|u| pattern.at(u.min(end)).map(|state| [u, state.pressure]))
                .collect()
        };
        let curves = vec![
            ("ridge", ridge),
            ("dimple", circle(circular::dimple())),
            ("bulge", circle(circular::bulge())),
        ];
        (!cancel.requested()).then_some(Self { curves })
    }

    /// The curves for a scene, together with its flat state between two mean displacements; for a
    /// tip in a square cell those of JKR, alone and in the cell; empty on other ground.
    ///
    /// Over a layer there is the flat state alone: the other theory is that of a half-space.
    ///
    /// The curves of zero range hold where the range is small: L/L_c well above 1, and u0 well
    /// above the range.
    pub fn lines(&self, model: &Model, from: f64, to: f64) -> Vec<TheoryLine> {
        let half_space = model.body == Body::HalfSpace;
        match model.indenter {
            Indenter::Flat => {}
            Indenter::Hertz(Hertz { radius }) if half_space && !model.grid.is_line() => {
                return tip(
                    Jkr {
                        radius,
                        surface_energy: model.law.surface_energy,
                    },
                    model.grid.length,
                    from,
                );
            }
            _ => return Vec::new(),
        }
        let units = Units::of(&model.law, model.grid.length);
        let flat = |u0: f64| [u0, model.law.at(u0).traction];
        let mut lines = vec![TheoryLine {
            name: "flat",
            points: steps(from, to, THEORY_POINTS).map(flat).collect(),
        }];
        for (name, curve) in self.curves.iter().filter(|_| half_space) {
            // A dimple and a bulge are patterns of a square cell.
            if model.grid.is_line() && *name != "ridge" {
                continue;
            }
            let restored = |[u, p]: [f64; 2]| {
                let u0 = units.restore(u);
                [u0, units.stress(p, u0)]
            };
            lines.push(TheoryLine {
                name,
                points: curve.iter().copied().map(restored).collect(),
            });
        }
        lines
    }
}

/// The stable branch of a tip without range from u0 = `from` to its end, alone and in its cell of
/// side `length`.
fn tip(tip: Jkr, length: f64, from: f64) -> Vec<TheoryLine> {
    let largest = (0..40).fold(length, |a, _| {
        (tip.radius * (tip.opening(a) - from).max(0.0)).sqrt()
    });
    let (smallest, largest) = (
        0.7 * tip.end_of_displacement().radius,
        (1.1 * largest).min(LARGEST_CONTACT * length),
    );
    let area = length * length;
    let branch = |contact: &dyn Fn(f64) -> Contact| {
        let mut points: Vec<[f64; 2]> = Vec::new();
        for radius in steps(largest, smallest, TIP_POINTS) {
            let contact = contact(radius);
            let point = [contact.mean_displacement, contact.force / area];
            if points.last().is_some_and(|last| point[0] <= last[0]) {
                break;
            }
            points.push(point);
        }
        points.retain(|point| point[0] >= from);
        points
    };
    let periodic = PeriodicJkr::new(tip, length);
    vec![
        TheoryLine {
            name: "JKR",
            points: branch(&|a| tip.contact(a)),
        },
        TheoryLine {
            name: "JKR, periodic",
            points: branch(&|a| periodic.contact(a)),
        },
    ]
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
