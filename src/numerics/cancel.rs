//! A flag that one thread raises and another reads.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Shared request to stop; clones refer to the same flag.
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<AtomicBool>);

impl Cancel {
    /// Asks every holder of this token to stop at its next check.
    pub fn request(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// True once a stop was requested.
    pub fn requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Takes the request back, so that the token can serve the next piece of work.
    pub fn clear(&self) {
        self.0.store(false, Ordering::Relaxed);
    }
}
