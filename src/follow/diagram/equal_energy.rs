//! Where two stable pieces have the same energy: between them neither is favoured.

use super::{Branch, Kind, Point};
use crate::follow::atlas::{self, Support};
use crate::physics::control::Control;

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

/// Bisections to a crossing: all digits of a double.
const HALVINGS: usize = 60;

/// All crossings of the energies of stable pieces.
pub(super) fn all(branches: &[Branch], control: Control) -> Vec<EqualEnergy> {
    let pieces: Vec<(&str, Vec<Support>)> = branches
        .iter()
        .flat_map(|branch| {
            stable(branch, control)
                .into_iter()
                .map(|piece| (&*branch.name, piece))
        })
        .collect();
    let mut found = Vec::new();
    for (i, (name, a)) in pieces.iter().enumerate() {
        for (other, b) in &pieces[i + 1..] {
            for value in crossings(a, b) {
                let points = [a, b].map(|piece| at(piece, value));
                let places = points.map(|point| control.place(value, point.stress));
                found.push(EqualEnergy {
                    branches: [*name, *other].map(str::to_owned),
                    control: value,
                    mean_displacements: places.map(|[u0, _]| u0),
                    stresses: places.map(|[_, stress]| stress),
                    energy: points[0].energy,
                });
            }
        }
    }
    found.sort_by(|a, b| b.control.total_cmp(&a.control));
    found
}

/// The pieces of a branch without negative eigenvalues, by growing values of the control.
fn stable(branch: &Branch, control: Control) -> Vec<Vec<Support>> {
    let mut pieces: Vec<Vec<Support>> = Vec::new();
    let mut open = false;
    for point in &branch.points {
        let [before, after] = point.index;
        if !open && (before == 0 || after == 0) {
            pieces.push(Vec::new());
        }
        open = after == 0;
        if (before == 0 || after == 0)
            && let Some(piece) = pieces.last_mut()
        {
            piece.push(support(point, control));
        }
    }
    for piece in &mut pieces {
        if piece.first().map(|s| s.u0) > piece.last().map(|s| s.u0) {
            piece.reverse();
        }
    }
    pieces.retain(|piece| piece.len() > 1);
    pieces
}

/// A point with the control in place of u0, and the derivative of the energy with that in place of
/// the stress.
fn support(point: &Point, control: Control) -> Support {
    let (state, [du, ds]) = (&point.state, point.rates);
    Support {
        u0: state.control,
        energy: state.energy,
        stress: control.conjugate(state.mean_displacement, state.stress),
        slope: match point.kind {
            Kind::Fold => f64::INFINITY,
            _ => control.conjugate(du, ds) / control.balanced(du, ds)[0],
        },
    }
}

/// Energy of a piece where the control has this `value`, and its derivative with that.
fn at(piece: &[Support], value: f64) -> atlas::Point {
    let i = piece
        .partition_point(|s| s.u0 <= value)
        .clamp(1, piece.len() - 1);
    piece[i - 1].to(piece[i], value)
}

/// Where the energies of two pieces cross.
fn crossings(a: &[Support], b: &[Support]) -> Vec<f64> {
    let low = a[0].u0.max(b[0].u0);
    let high = a[a.len() - 1].u0.min(b[b.len() - 1].u0);
    if !(low < high) {
        return Vec::new();
    }
    let mut places: Vec<f64> = a
        .iter()
        .chain(b)
        .map(|s| s.u0)
        .filter(|value| low < *value && *value < high)
        .collect();
    places.extend([low, high]);
    places.sort_by(f64::total_cmp);
    let apart = |value: f64| at(a, value).energy - at(b, value).energy;
    let mut found = Vec::new();
    for pair in places.windows(2) {
        let (mut low, mut high) = (pair[0], pair[1]);
        // Pieces that meet at a bifurcation have the same energy there: no crossing.
        if !(apart(low) * apart(high) < 0.0) {
            continue;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if apart(low) * apart(middle) <= 0.0 {
                high = middle;
            } else {
                low = middle;
            }
        }
        found.push(0.5 * (low + high));
    }
    found
}
