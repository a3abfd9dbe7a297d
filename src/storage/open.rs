//! Opening what somebody chose: a scene file, or a picture with its scene inside. Nothing here can
//! wait for ever.

use super::{Failure, files, picture, scene_file};
use crate::scene::Scene;
use std::fs;
use std::path::Path;

/// Reads at most `limit` bytes of a regular file: what gives its bytes when it likes (a pipe, a
/// terminal, a device) is refused.
///
/// # Errors
/// A file that is missing, unreadable, not regular, or longer than `limit`.
pub fn read_regular(path: &Path, limit: u64) -> Result<Vec<u8>, Failure> {
    match fs::metadata(path) {
        Ok(data) if !data.is_file() && !data.is_dir() => Err(Failure::Read {
            file: path.display().to_string(),
            reason: "a pipe or a device, not a file".to_owned(),
            remedy: "open a file; tackscope run reads a scene from a pipe".to_owned(),
        }),
        // What is missing, or a folder, fails at once and in its own words.
        _ => files::read_bytes(path, limit),
    }
}

/// The scene of a regular file, told by its content and not by its name.
///
/// # Errors
/// A file that cannot be read, or that holds no allowed scene.
pub fn open_scene(path: &Path) -> Result<Scene, Failure> {
    let bytes = read_regular(path, picture::BYTES_MAX)?;
    if picture::is_png(&bytes) {
        picture::scene_of(path, &bytes)
    } else {
        scene_file::scene_of(path, bytes)
    }
}

/// Forgets a file of the program's own, if it is there.
pub fn remove(path: &Path) {
    // What cannot be removed stays, and is refused again next time.
    let _ = fs::remove_file(path);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pipe_is_refused_without_waiting_for_what_it_may_give() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.toml");
        assert!(
            std::process::Command::new("mkfifo")
                .arg(&path)
                .status()
                .unwrap()
                .success()
        );
        assert!(
            open_scene(&path)
                .unwrap_err()
                .to_string()
                .contains("a pipe or a device")
        );
        remove(&path);
        assert!(!path.exists() && open_scene(&path).is_err() && open_scene(folder.path()).is_err());
        files::write_whole(&path, b"12345678").unwrap();
        assert!(read_regular(&path, 8).is_ok() && read_regular(&path, 7).is_err());
    }
}
