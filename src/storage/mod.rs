//! Floor 4: the only room that touches the file system. (Stub of branch `ui`, replaced at merge.)

pub mod export;
pub mod picture;
pub mod presets;
pub mod scene_file;

/// What went wrong with a file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct Failure(pub String);
