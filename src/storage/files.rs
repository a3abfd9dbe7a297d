//! Whole files or none: what is written appears under its name only when it is complete.

use super::Failure;
use std::fs;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

/// Makes `folder` (and what is above it) and checks that a file can be written there.
///
/// # Errors
/// A folder that cannot be made or written to.
pub fn prepare_folder(folder: &Path) -> Result<(), Failure> {
    fs::create_dir_all(folder).map_err(|error| Failure::write(folder, error))?;
    temporary(folder).map(drop).map_err(|error| Failure::write(folder, error))
}

/// Writes `bytes` to `path`, making its folder: into a temporary file beside it first, which then takes its name.
///
/// # Errors
/// A folder or file that cannot be written; the old file, if any, is then untouched.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    replace(path, bytes).map_err(|error| Failure::write(path, error))
}

fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    // Through a symbolic link the file it points to is replaced, not the link.
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    if target.is_dir() {
        return Err(io::Error::from(io::ErrorKind::IsADirectory));
    }
    let folder = match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    };
    fs::create_dir_all(&folder)?;
    let mut file = temporary(&folder)?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    file.persist(&target).map_err(|error| error.error)?;
    Ok(())
}

/// A temporary file with the permissions of any other new file; gone when dropped.
fn temporary(folder: &Path) -> io::Result<tempfile::NamedTempFile> {
    tempfile::Builder::new().prefix(".tackscope-").make_in(folder, |path| fs::File::create_new(path))
}

/// Reads at most `limit` bytes of text.
///
/// # Errors
/// A file that is missing, unreadable, longer than `limit`, or not UTF-8.
pub fn read_text(path: &Path, limit: u64) -> Result<String, Failure> {
    let bytes = read_bytes(path, limit)?;
    String::from_utf8(bytes).map_err(|_| unreadable(path, "not UTF-8".to_owned(), "save it as UTF-8 text"))
}

/// Reads at most `limit` bytes.
///
/// # Errors
/// A file that is missing, unreadable, or longer than `limit`.
pub fn read_bytes(path: &Path, limit: u64) -> Result<Vec<u8>, Failure> {
    let missing = |error: io::Error| unreadable(path, error.to_string(), "check the path, and that you may read it");
    let mut bytes = Vec::new();
    fs::File::open(path).map_err(missing)?.take(limit + 1).read_to_end(&mut bytes).map_err(missing)?;
    if bytes.len() as u64 > limit {
        let reason = format!("longer than {limit} bytes");
        return Err(unreadable(path, reason, "a scene file is a page of text; check that this is one"));
    }
    Ok(bytes)
}

fn unreadable(path: &Path, reason: String, remedy: &str) -> Failure {
    Failure::Read { file: path.display().to_string(), reason, remedy: remedy.to_owned() }
}

/// Removes the files of `folder` whose name `ours` accepts; a folder that does not exist is empty.
///
/// # Errors
/// A file that cannot be removed.
pub fn remove_old(folder: &Path, ours: impl Fn(&str) -> bool) -> Result<(), Failure> {
    let Ok(entries) = fs::read_dir(folder) else { return Ok(()) };
    for entry in entries.flatten() {
        if entry.file_name().to_str().is_some_and(&ours) {
            fs::remove_file(entry.path()).map_err(|error| Failure::write(&entry.path(), error))?;
        }
    }
    Ok(())
}
