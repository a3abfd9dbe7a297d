//! The scene file (`format = 1`): TOML in, [`Scene`] out, and back.
//!
//! Read by hand over the parsed table, so that every refusal names the file, the key, its value and
//! what is allowed.

mod read;
mod section;
mod write;

use super::{Failure, files};
use crate::physics::parameter::Refusal;
use crate::scene::Scene;
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
    scene_of(path, files::read_bytes(path, BYTES_MAX)?)
}

/// The scene in a text from the clipboard.
///
/// # Errors
/// What is too long, or no allowed scene.
pub fn pasted(text: &str) -> Result<Scene, Failure> {
    scene_of(
        Path::new("clipboard"),
        text.as_bytes()
            .iter()
            .take(BYTES_MAX as usize + 1)
            .copied()
            .collect(),
    )
}

/// The scene of a file that has been read.
///
/// # Errors
/// What is too long, not UTF-8, or no allowed scene.
pub(super) fn scene_of(path: &Path, bytes: Vec<u8>) -> Result<Scene, Failure> {
    let refused = |reason: String, remedy: &str| Failure::Read {
        file: path.display().to_string(),
        reason,
        remedy: remedy.to_owned(),
    };
    if bytes.len() as u64 > BYTES_MAX {
        let remedy = "a scene file is a page of text; check that this is one";
        return Err(refused(format!("longer than {BYTES_MAX} bytes"), remedy));
    }
    let text = String::from_utf8(bytes)
        .map_err(|_| refused("not UTF-8".to_owned(), "save it as UTF-8 text"))?;
    parse(&text, &path.display().to_string())
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
pub fn refused(file: &str, error: Refusal) -> Failure {
    Failure::Value {
        file: file.to_owned(),
        key: error.key,
        value: error.value,
        allowed: error.allowed,
    }
}
