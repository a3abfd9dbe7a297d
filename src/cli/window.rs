//! The way to the window: the one place outside `ui` that asks for the feature `gui`.

/// Why there is no window.
pub(super) enum NoWindow {
    /// Nothing to open it on.
    NoDisplay(String),
    /// There is a display, yet it did not open.
    #[cfg_attr(not(feature = "gui"), expect(dead_code, reason = "needs a window"))]
    Broken(String),
}

/// Opens the window and returns when it is closed.
#[cfg(feature = "gui")]
pub(super) fn open() -> Result<(), NoWindow> {
    crate::ui::display_available().map_err(NoWindow::NoDisplay)?;
    crate::ui::run().map_err(NoWindow::Broken)
}

/// Says that there is none in this build.
#[cfg(not(feature = "gui"))]
pub(super) fn open() -> Result<(), NoWindow> {
    Err(NoWindow::NoDisplay("this build has none".to_owned()))
}
