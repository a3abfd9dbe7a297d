//! Floor 7: the only room that touches the file system.
//!
//! Scene files and studies are read and written ([`scene_file`], [`presets`], [`study_file`]),
//! sessions of the window too ([`session`]), height files read ([`heights`]), results exported
//! ([`export`], [`fields`], [`summary`], [`picture`], [`drawing`]). Every file is written whole or
//! not at all, and one folder holds one run ([`files`]); everything that can go wrong is a
//! [`Failure`], one sentence that names the file and says how to mend it. May use `paper` and all
//! below it; computes nothing, opens no dialogs.

pub mod drawing;
pub mod export;
mod failure;
pub mod fields;
pub mod files;
pub mod heights;
pub mod picture;
pub mod presets;
pub mod scene_file;
pub mod session;
pub mod study_file;
pub mod summary;

/// The version of the program, in a release with the commit it was built from.
pub const VERSION: &str = env!("TACKSCOPE_VERSION");

pub use failure::{Failure, line};
pub use files::{read_regular, remove};

use crate::physics::topography::Topography;
use crate::scene::Scene;
use std::path::Path;

/// The scene of a regular file, told by its content and not by its name.
///
/// # Errors
/// A file that cannot be read, or that holds no allowed scene.
pub fn open_scene(path: &Path) -> Result<Scene, Failure> {
    scene_in(path, files::read_regular(path, session::BYTES_MAX)?)
}

/// The scene in the bytes of a file.
///
/// # Errors
/// What holds no allowed scene.
fn scene_in(path: &Path, bytes: Vec<u8>) -> Result<Scene, Failure> {
    if picture::is_png(&bytes) {
        picture::scene_of(path, &bytes)
    } else if session::is_session(&bytes) {
        session::scene_of(path, &bytes)
    } else {
        scene_file::scene_of(path, bytes)
    }
}

/// What a file holds.
#[derive(Debug)]
pub enum Opened {
    /// A scene.
    Scene(Scene),
    /// The bytes of a session.
    Session(Vec<u8>),
    /// Measured heights.
    Heights(Topography),
}

/// The scene, session or heights of a regular file. A scene is a picture that holds one, a file
/// named `.toml`, or text with a line that begins with `format` or a bracket.
///
/// # Errors
/// A file that cannot be read, or that holds none of them.
pub fn open(path: &Path) -> Result<Opened, Failure> {
    let bytes = files::read_regular(path, session::BYTES_MAX)?;
    if picture::is_png(&bytes) {
        return match picture::session_in(&bytes) {
            Some(session) => Ok(Opened::Session(session.to_vec())),
            None => picture::scene_of(path, &bytes).map(Opened::Scene),
        };
    }
    let named = path
        .extension()
        .is_some_and(|end| end.eq_ignore_ascii_case("toml"));
    let is_key = |line: &str| line.starts_with("format") || line.starts_with('[');
    let has_keys = || std::str::from_utf8(&bytes).is_ok_and(|text| text.lines().any(is_key));
    if session::is_session(&bytes) {
        Ok(Opened::Session(bytes))
    } else if named || has_keys() {
        scene_file::scene_of(path, bytes).map(Opened::Scene)
    } else {
        heights::of_bytes(path, &bytes).map(Opened::Heights)
    }
}
