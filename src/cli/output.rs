//! What the command line says: each line through one of two doors, which let no control character
//! out and survive that nobody listens.

use crate::storage::{Failure, line};
use std::io::{ErrorKind, Write, stderr, stdout};
use std::path::Path;

/// Prints a line to standard output; a reader that has gone away (`| head`) is no error.
///
/// # Errors
/// A standard output that cannot be written, as on a full disk.
pub(super) fn say(text: &str) -> Result<(), Failure> {
    let mut out = stdout().lock();
    match writeln!(out, "{}", line(text)).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            let remedy = "make room where it goes, or send it elsewhere";
            Err(Failure::refused(
                Path::new("standard output"),
                &error.to_string(),
                remedy,
            ))
        }
        _ => Ok(()),
    }
}

/// Prints a line to standard error; nobody listening is no error.
pub(super) fn tell(text: &str) {
    let _ = writeln!(stderr(), "{}", line(text));
}

/// Tells what went wrong, or what must be known.
pub(super) fn warn(text: impl std::fmt::Display) {
    tell(&format!("tackscope: {text}"));
}
