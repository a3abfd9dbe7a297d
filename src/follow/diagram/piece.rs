//! Pieces of branches with one index: along each the control grows, for where it turns back a mode
//! changes its sign. Between two stable pieces of the same energy neither is favoured.

use super::{Branch, Diagram, Kind, Point};
use crate::follow::atlas::Support;
use crate::physics::system::State;
use crate::physics::theory::boundary;

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

/// Stable pieces of two branches with the same energy at the same value of the control.
#[derive(Clone, Debug, PartialEq)]
pub struct EqualEnergy {
    /// Names of both branches.
    pub branches: [String; 2],
    /// Where: u0 or the position of the stage (length), or the load per area (E*).
    pub control: f64,
    /// u0 on each (length).
    pub mean_displacements: [f64; 2],
    /// Mean stress on each (E*).
    pub stresses: [f64; 2],
    /// Energy per area of both, that of the machine with it (E* times length).
    pub energy: f64,
}

/// All crossings of the energies of stable pieces.
pub(super) fn equal_energies(diagram: &Diagram) -> Vec<EqualEnergy> {
    let pieces: Vec<Piece<'_>> = diagram.pieces(0).collect();
    let mut found = Vec::new();
    for (i, a) in pieces.iter().enumerate() {
        for b in &pieces[i + 1..] {
            for control in crossings(a, b) {
                let states = [a, b].map(|piece| piece.at(control));
                found.push(EqualEnergy {
                    branches: [a, b].map(|piece| piece.branch.name.clone()),
                    control,
                    mean_displacements: states.each_ref().map(|state| state.mean_displacement),
                    stresses: states.each_ref().map(|state| state.stress),
                    energy: states[0].energy,
                });
            }
        }
    }
    found.sort_by(|a, b| b.control.total_cmp(&a.control));
    found
}

/// Where the energies of two pieces cross.
fn crossings(a: &Piece<'_>, b: &Piece<'_>) -> Vec<f64> {
    let Some([low, high]) = a.common(b) else {
        return Vec::new();
    };
    let within = |value: &f64| low < *value && *value < high;
    let mut places: Vec<f64> = a.places().chain(b.places()).filter(within).collect();
    places.extend([low, high]);
    places.sort_by(f64::total_cmp);
    let apart = |control: f64| a.at(control).energy - b.at(control).energy;
    let mut found = Vec::new();
    for pair in places.windows(2) {
        let (low, high) = (pair[0], pair[1]);
        // Pieces that meet at a bifurcation have the same energy there: no crossing.
        if apart(low) * apart(high) < 0.0 {
            found.push(boundary(low, high, |middle| {
                apart(low) * apart(middle) > 0.0
            }));
        }
    }
    found
}
