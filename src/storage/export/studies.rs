//! What many loops of a scene give, as tables: the map of patterns, the convergence with the mesh.

use super::{cells_of, number, quoted, write_rows};
use crate::storage::Failure;
use crate::study::converge::Convergence;
use crate::study::map::PatternMap;
use std::path::Path;

/// First line of `map.csv`.
pub const MAP_COLUMNS: &str =
    "value,kind,branch,mean_displacement,from,to,released_energy,cause,dissipated_energy";

/// Writes a map, row by row: its jumps in order, then u0 between which each visited pattern is
/// stable (kind `end`, the lower one from nothing, the upper one to nothing); a value without a
/// loop has one line that says why (kind `missing`), one whose loop has no jump a line of kind
/// `none`. u0 in the scene's length, energies per area in units of gamma.
///
/// # Errors
/// A file that cannot be written.
pub fn write_map_csv(path: &Path, map: &PatternMap) -> Result<(), Failure> {
    let empty = || String::new();
    let lines = map.rows.iter().flat_map(|row| {
        let value = number(row.value);
        let found = match &row.found {
            Ok(found) => found,
            Err(why) => {
                let blank = std::iter::repeat_n(empty(), 5);
                let head = [value, "missing".to_owned()].into_iter().chain(blank);
                return vec![head.chain([quoted(why), empty()]).collect()];
            }
        };
        let loss = number(found.dissipated_energy);
        let jumps = found.jumps.iter().map(|jump| {
            let head = [value.clone(), "jump".to_owned()].into_iter();
            head.chain(cells_of(jump)).chain([loss.clone()]).collect()
        });
        let end = |u0: f64, [from, to]: [String; 2]| {
            let head = [
                value.clone(),
                "end".to_owned(),
                empty(),
                number(u0),
                from,
                to,
            ];
            head.into_iter()
                .chain([empty(), empty(), loss.clone()])
                .collect()
        };
        let ends = found.extents.iter().flat_map(|(pattern, [low, high])| {
            let word = || pattern.to_string();
            [end(*low, [empty(), word()]), end(*high, [word(), empty()])]
        });
        let mut lines: Vec<Vec<String>> = jumps.chain(ends).collect();
        if found.jumps.is_empty() {
            let blank = std::iter::repeat_n(empty(), 6);
            let head = [value, "none".to_owned()].into_iter().chain(blank);
            lines.push(head.chain([loss]).collect());
        }
        lines
    });
    write_rows(path, MAP_COLUMNS, lines)
}

/// First line of `convergence.csv`.
const CONVERGENCE_COLUMNS: &str = "quantity,points,value,order,limit,error_bar";

/// Writes each number on each mesh, from coarse to fine, with the order that the last three meshes
/// show (`NaN` where they show none), the limit, and how far that may be off.
///
/// # Errors
/// A file that cannot be written.
pub fn write_convergence_csv(path: &Path, all: &[Convergence]) -> Result<(), Failure> {
    let rows = all.iter().flat_map(|one| {
        let estimate = one.estimate;
        let order = estimate.order.unwrap_or(f64::NAN);
        one.values.iter().map(move |[points, value]| {
            let numbers = [*value, order, estimate.limit, estimate.error_bar].map(number);
            let head = [one.quantity.clone(), points.to_string()];
            head.into_iter().chain(numbers).collect()
        })
    });
    write_rows(path, CONVERGENCE_COLUMNS, rows)
}
