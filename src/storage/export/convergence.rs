//! The convergence of a loop's numbers as a table.

use super::{number, write_rows};
use crate::storage::Failure;
use crate::study::converge::Convergence;
use std::path::Path;

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
