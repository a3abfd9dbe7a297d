//! Stub of branch `ui`.

use super::Failure;
use crate::experiment::record::LoopRecord;
use crate::physics::law::Law;
use ndarray::Array2;
use std::path::Path;

/// Writes.
///
/// # Errors
/// Cannot write.
pub fn write_gap_png(path: &Path, _gap: &Array2<f64>) -> Result<(), Failure> {
    std::fs::write(path, "").map_err(|e| Failure(format!("{}: {e}", path.display())))
}

/// Writes.
///
/// # Errors
/// Cannot write.
pub fn write_loop_png(path: &Path, _record: &LoopRecord, _law: &Law, _title: &str) -> Result<(), Failure> {
    std::fs::write(path, "").map_err(|e| Failure(format!("{}: {e}", path.display())))
}
