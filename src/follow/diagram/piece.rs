//! Pieces of branches with one index: along each the control grows, for where it turns back a mode
//! changes its sign.

use super::{Branch, Diagram, Kind, Point};
use crate::follow::atlas::Support;
use crate::physics::system::State;

/// Points of one branch in a row, by the growing control, between two of its ends, folds and
/// bifurcations.
#[derive(Clone, Debug)]
pub struct Piece<'d> {
    /// The branch.
    pub branch: &'d Branch,
    points: Vec<&'d Point>,
}

impl Diagram {
    /// All pieces whose states have `index` negative eigenvalues.
    pub fn pieces(&self, index: usize) -> impl Iterator<Item = Piece<'_>> {
        self.branches
            .iter()
            .flat_map(move |branch| of_branch(branch, index))
    }
}

fn of_branch(branch: &Branch, index: usize) -> Vec<Piece<'_>> {
    let mut pieces: Vec<Piece<'_>> = Vec::new();
    let mut open = false;
    for point in &branch.points {
        let [before, after] = point.index;
        // At an event it may end and begin again.
        if before == index
            && open
            && let Some(piece) = pieces.last_mut()
        {
            piece.points.push(point);
        }
        if after == index && (!open || point.kind != Kind::Regular) {
            pieces.push(Piece {
                branch,
                points: vec![point],
            });
        }
        open = after == index;
    }
    pieces.retain(|piece| piece.points.len() > 1);
    for piece in &mut pieces {
        if piece.points.first().map(|p| place(p)) > piece.points.last().map(|p| place(p)) {
            piece.points.reverse();
        }
    }
    pieces
}

fn place(point: &Point) -> f64 {
    point.state.control
}

impl<'d> Piece<'d> {
    /// Lowest and highest value of the control.
    pub fn extent(&self) -> [f64; 2] {
        [
            place(self.points[0]),
            place(self.points[self.points.len() - 1]),
        ]
    }

    /// True if it has a state at this value of the control, within its ends.
    pub fn holds(&self, control: f64) -> bool {
        let [low, high] = self.extent();
        low < control && control < high
    }

    /// Values of the control at its points, ascending.
    pub fn places(&self) -> impl Iterator<Item = f64> + '_ {
        self.points.iter().map(|p| place(p))
    }

    /// The two points around a value of the control.
    pub fn around(&self, control: f64) -> [&'d Point; 2] {
        let after = self.points.partition_point(|p| place(p) <= control);
        let after = after.clamp(1, self.points.len() - 1);
        [self.points[after - 1], self.points[after]]
    }

    /// The state at a value of the control, without its amplitudes; meaningful within its extent.
    pub fn at(&self, value: f64) -> State {
        let control = self.branch.system.control();
        // The energy's derivative with the control is to it what the stress is to u0.
        let support = |p: &Point| {
            let [du, ds] = p.rates;
            Support {
                u0: place(p),
                energy: p.state.energy,
                stress: control.conjugate(p.state.mean_displacement, p.state.stress),
                slope: match p.kind {
                    Kind::Fold => f64::INFINITY,
                    _ => control.conjugate(du, ds) / control.balanced(du, ds)[0],
                },
            }
        };
        let [a, b] = self.around(value).map(support);
        let between = a.to(b, value);
        let [mean_displacement, stress] = control.place(value, between.stress);
        State {
            control: value,
            mean_displacement,
            amplitudes: Vec::new(),
            energy: between.energy,
            stress,
        }
    }

    /// The values of the control that two pieces have in common, if any.
    pub fn common(&self, other: &Self) -> Option<[f64; 2]> {
        let ([a, b], [c, d]) = (self.extent(), other.extent());
        let common = [a.max(c), b.min(d)];
        (common[0] < common[1]).then_some(common)
    }
}
