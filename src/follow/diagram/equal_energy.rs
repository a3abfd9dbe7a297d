//! Where two stable pieces have the same energy: between them neither is favoured.

use super::Diagram;
use super::piece::Piece;

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
pub(super) fn all(diagram: &Diagram) -> Vec<EqualEnergy> {
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
