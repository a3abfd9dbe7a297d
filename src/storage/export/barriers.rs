//! Barriers as a table.

use super::{number, write_rows};
use crate::physics::parameter::Dimension;
use crate::storage::Failure;
use crate::study::landscape::{Ground, Saddle};
use std::path::Path;

/// First line of `barriers.csv`.
pub const BARRIER_COLUMNS: &str =
    "control,mean_displacement,saddle,stress,from,barrier,to,released_energy";

/// What a scene with units adds to it: the barrier of a square cell in kT.
const BARRIER_COLUMN_OF_UNITS: &str = ",barrier_kt";

/// Writes two lines a saddle, one for each way over it: what is driven and the saddle's own u0 (in
/// the scene's length), the name of its branch and its stress (E*), the pattern that is left and
/// the barrier from there, the pattern beyond and what is released by going there; energies per
/// area in units of gamma, of a cell in gamma L^2; of a scene with units also in kT (NaN of a line
/// cell, which has no depth).
///
/// # Errors
/// A file that cannot be written.
pub fn write_barriers_csv(
    path: &Path,
    ground: Ground<'_>,
    saddles: &[(f64, Saddle)],
) -> Result<(), Failure> {
    let given = |of, value| number(ground.scene.number_given(of, value));
    let gamma = ground.model.law.surface_energy;
    let rows = saddles.iter().flat_map(|(control, saddle)| {
        let ends = saddle.sides.each_ref().map(|side| &side[side.len() - 1]);
        [[0, 1], [1, 0]].map(|ways| {
            let [from, to] = ways.map(|side| ends[side]);
            let [barrier, released] = [saddle.place.energy - from.energy, from.energy - to.energy];
            let mut cells = vec![
                given(Dimension::Driven, *control),
                number(saddle.place.mean_displacement),
                saddle.branch.clone(),
                given(Dimension::Stress, saddle.place.stress),
                ground.pattern(from, *control).to_string(),
                number(barrier / gamma),
                ground.pattern(to, *control).to_string(),
                number(released / gamma),
            ];
            let kt = |_| number(ground.model.in_kt(barrier).unwrap_or(f64::NAN));
            cells.extend(ground.model.units.map(kt));
            cells
        })
    });
    let more = ground.model.units.map_or("", |_| BARRIER_COLUMN_OF_UNITS);
    write_rows(path, &format!("{BARRIER_COLUMNS}{more}"), rows)
}
