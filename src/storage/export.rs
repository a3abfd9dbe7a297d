//! Stub of branch `ui`.

use super::Failure;
use crate::experiment::record::LoopRecord;
use std::path::Path;

/// Writes.
///
/// # Errors
/// Cannot write.
pub fn write_loop_csv(path: &Path, _record: &LoopRecord) -> Result<(), Failure> {
    std::fs::write(path, "").map_err(|e| Failure(format!("{}: {e}", path.display())))
}

/// Writes.
///
/// # Errors
/// Cannot write.
pub fn write_events_csv(path: &Path, _record: &LoopRecord) -> Result<(), Failure> {
    std::fs::write(path, "").map_err(|e| Failure(format!("{}: {e}", path.display())))
}
