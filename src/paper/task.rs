//! The order to compute a figure: how large, when to stop, whom to tell.

use crate::numerics::cancel::Cancel;

/// How much work a figure may be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Size {
    /// Seconds at most: fewer points and coarser meshes, for the window and the tests.
    Quick,
    /// As in the paper.
    #[default]
    Full,
}

/// Why there is no figure.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Stopped {
    /// Somebody asked to stop.
    #[error("stopped")]
    Cancelled,
    /// A computation that the figure cannot do without has failed.
    #[error("{0}")]
    Failed(String),
}

/// An order to compute a figure.
pub struct Task<'a> {
    /// How large.
    pub size: Size,
    /// Raised to stop.
    pub cancel: &'a Cancel,
    observe: &'a mut dyn FnMut(f64, &str),
    share: [f64; 2],
}

impl<'a> Task<'a> {
    /// An order; `observe` is told the share that is done (0 to 1) and what is being done.
    pub fn new(size: Size, cancel: &'a Cancel, observe: &'a mut dyn FnMut(f64, &str)) -> Self {
        Self { size, cancel, observe, share: [0.0, 1.0] }
    }

    /// The part of it that goes from share `from` to share `to`.
    pub fn part(&mut self, from: f64, to: f64) -> Task<'_> {
        let [low, high] = self.share;
        let at = |share: f64| low + (high - low) * share;
        Task { size: self.size, cancel: self.cancel, share: [at(from), at(to)], observe: self.observe }
    }

    /// Tells the share that is done and what is being done.
    ///
    /// # Errors
    /// [`Stopped::Cancelled`] if somebody asked to stop, so that a loop can say `task.tell(...)?`.
    pub fn tell(&mut self, done: f64, what: &str) -> Result<(), Stopped> {
        let [low, high] = self.share;
        (self.observe)(low + (high - low) * done.clamp(0.0, 1.0), what);
        if self.cancel.requested() { Err(Stopped::Cancelled) } else { Ok(()) }
    }

    /// `full` or `quick`, as the order says.
    pub fn choose<T>(&self, quick: T, full: T) -> T {
        match self.size {
            Size::Quick => quick,
            Size::Full => full,
        }
    }
}
