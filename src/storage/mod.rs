//! Floor 7: the only room that touches the file system.
//!
//! Scene files are read and written ([`scene_file`], [`presets`]), height files read ([`heights`]),
//! results exported ([`export`], [`fields`], [`summary`], [`picture`], [`drawing`], [`report`]).
//! Every file is written whole or not at all ([`files`]), and one folder holds one run ([`folder`]);
//! everything that can go wrong is a [`Failure`], one sentence that names the file and says how to
//! mend it. May use `paper` and all below it; computes nothing, opens no dialogs.

pub mod drawing;
pub mod export;
mod failure;
pub mod fields;
pub mod files;
pub mod film;
pub mod folder;
pub mod heights;
pub mod picture;
pub mod presets;
pub mod report;
pub mod scene_file;
pub mod summary;

pub use failure::{Failure, line};
pub use files::{read_regular, remove};
pub use picture::{Opened, open, open_scene};
