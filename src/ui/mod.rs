//! Floor 5: the window. STUB on branch io.

/// Says why no window can be opened here, or nothing.
///
/// # Errors
/// The reason.
pub fn display_available() -> Result<(), String> {
    Err("the window is not built yet".to_owned())
}

/// Opens the window and returns when it is closed.
///
/// # Errors
/// Why it could not be opened.
pub fn run() -> Result<(), String> {
    Err("the window is not built yet".to_owned())
}
