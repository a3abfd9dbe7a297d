//! The scene file (`format = 1`): TOML in, [`Scene`] out, and back.
//!
//! Read by hand over the parsed table, so that every refusal names the file, the key, its value and what is allowed.

mod read;
mod section;
mod write;

use super::{Failure, files};
use crate::experiment::scene::{Scene, SceneError};
use std::path::Path;

pub use read::parse;
pub use write::to_text;

/// The version of the scene file that this program reads and writes.
pub const FORMAT: i64 = 1;

/// Longest scene file that is read, in bytes.
pub const BYTES_MAX: u64 = 1 << 20;

/// Reads a scene from a file.
///
/// # Errors
/// A file that cannot be read or is not an allowed scene.
pub fn load(path: &Path) -> Result<Scene, Failure> {
    parse(&files::read_text(path, BYTES_MAX)?, &path.display().to_string())
}

/// Writes a scene to a file; a scene that [`load`] would refuse is not written.
///
/// # Errors
/// A scene that is not allowed, or a file that cannot be written.
pub fn save(path: &Path, scene: &Scene) -> Result<(), Failure> {
    let text = to_text(scene);
    parse(&text, &path.display().to_string())?;
    files::write_whole(path, text.as_bytes())
}

/// The refusal of a value by the scene itself, with the file it came from.
pub fn refused(file: &str, error: SceneError) -> Failure {
    Failure::Value { file: file.to_owned(), key: error.key, value: error.value, allowed: error.allowed }
}
