//! Where two stable pieces have the same energy: between them neither is favoured.

use super::{Branch, Kind, Point};
use crate::follow::atlas::{self, Support};

/// Stable pieces of two branches with the same energy at the same u0.
#[derive(Clone, Debug, PartialEq)]
pub struct EqualEnergy {
    /// Names of both branches.
    pub branches: [String; 2],
    /// Where (length).
    pub mean_displacement: f64,
    /// Mean stress on each (E*).
    pub stresses: [f64; 2],
    /// Energy per area of both (E* times length).
    pub energy: f64,
}

/// Bisections to a crossing: all digits of a double.
const HALVINGS: usize = 60;

/// All crossings of the energies of stable pieces.
pub(super) fn all(branches: &[Branch]) -> Vec<EqualEnergy> {
    let pieces: Vec<(&str, Vec<&Point>)> = branches
        .iter()
        .flat_map(|branch| {
            stable(branch)
                .into_iter()
                .map(|piece| (&*branch.name, piece))
        })
        .collect();
    let mut found = Vec::new();
    for (i, (name, a)) in pieces.iter().enumerate() {
        for (other, b) in &pieces[i + 1..] {
            for u0 in crossings(a, b) {
                let (here, across) = (at(a, u0), at(b, u0));
                found.push(EqualEnergy {
                    branches: [*name, *other].map(str::to_owned),
                    mean_displacement: u0,
                    stresses: [here.stress, across.stress],
                    energy: here.energy,
                });
            }
        }
    }
    found.sort_by(|a, b| b.mean_displacement.total_cmp(&a.mean_displacement));
    found
}

/// The pieces of a branch without negative eigenvalues, by growing u0.
fn stable(branch: &Branch) -> Vec<Vec<&Point>> {
    let mut pieces: Vec<Vec<&Point>> = Vec::new();
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
            piece.push(point);
        }
    }
    for piece in &mut pieces {
        if piece.first().map(|p| place(p)) > piece.last().map(|p| place(p)) {
            piece.reverse();
        }
    }
    pieces.retain(|piece| piece.len() > 1);
    pieces
}

fn place(point: &Point) -> f64 {
    point.state.mean_displacement
}

/// Energy and stress of a piece at `u0`.
fn at(piece: &[&Point], u0: f64) -> atlas::Point {
    let i = piece
        .partition_point(|p| place(p) <= u0)
        .clamp(1, piece.len() - 1);
    let support = |p: &Point| Support {
        u0: place(p),
        energy: p.state.energy,
        stress: p.state.stress,
        slope: match p.kind {
            Kind::Fold => f64::INFINITY,
            _ => p.rates[1] / p.rates[0],
        },
    };
    support(piece[i - 1]).to(support(piece[i]), u0)
}

/// Where the energies of two pieces cross.
fn crossings(a: &[&Point], b: &[&Point]) -> Vec<f64> {
    let low = place(a[0]).max(place(b[0]));
    let high = place(a[a.len() - 1]).min(place(b[b.len() - 1]));
    if !(low < high) {
        return Vec::new();
    }
    let mut places: Vec<f64> = a
        .iter()
        .chain(b)
        .map(|p| place(p))
        .filter(|u| low < *u && *u < high)
        .collect();
    places.extend([low, high]);
    places.sort_by(f64::total_cmp);
    let apart = |u0: f64| at(a, u0).energy - at(b, u0).energy;
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
