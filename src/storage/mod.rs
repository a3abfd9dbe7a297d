//! Floor 7: the only room that touches the file system.
//!
//! Scene files and studies are read and written ([`scene_file`], [`presets`], [`study_file`]),
//! sessions of the window too ([`session`]), height files read ([`heights`]), results exported
//! ([`export`], [`fields`], [`summary`], [`picture`], [`drawing`]). Every file is written whole or
//! not at all, and one folder holds one run ([`files`]); everything that can go wrong is a
//! [`Failure`], one sentence that names the file and says how to mend it. May use `paper` and all
//! below it; computes nothing, opens no dialogs.

pub mod click;
pub mod drawing;
pub mod export;
mod failure;
pub mod fields;
pub mod files;
pub mod film;
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
pub use picture::{Opened, open, open_scene};
