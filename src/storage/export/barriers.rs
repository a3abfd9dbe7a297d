//! Barriers as a table.

use super::{number, write_rows};
use crate::storage::Failure;
use crate::study::landscape::{Ground, Saddle};
use std::path::Path;

/// First line of `barriers.csv`.
pub const BARRIER_COLUMNS: &str =
    "control,mean_displacement,saddle,stress,from,barrier,to,released_energy";

/// Writes two lines a saddle, one for each way over it: what is driven and the saddle's own u0 (in
/// the scene's length), the name of its branch and its stress (E*), the pattern that is left and
/// the barrier from there, the pattern beyond and what is released by going there; energies per
/// area in units of gamma, of a cell in gamma L^2.
///
/// # Errors
/// A file that cannot be written.
pub fn write_barriers_csv(
    path: &Path,
    ground: Ground<'_>,
    saddles: &[(f64, Saddle)],
) -> Result<(), Failure> {
    let gamma = ground.model.law.surface_energy;
    let rows = saddles.iter().flat_map(|(control, saddle)| {
        let ends = saddle.sides.each_ref().map(|side| &side[side.len() - 1]);
        [[0, 1], [1, 0]].map(|ways| {
            let [from, to] = ways.map(|side| ends[side]);
            let [barrier, released] = [saddle.place.energy - from.energy, from.energy - to.energy];
            vec![
                number(*control),
                number(saddle.place.mean_displacement),
                saddle.branch.clone(),
                number(saddle.place.stress),
                ground.pattern(from, *control).to_string(),
                number(barrier / gamma),
                ground.pattern(to, *control).to_string(),
                number(released / gamma),
            ]
        })
    });
    write_rows(path, BARRIER_COLUMNS, rows)
}
