//! A flag that one thread raises and another reads.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Shared request to stop; clones refer to the same flag.
#[derive(Clone, Debug, Default)]
pub struct Cancel {
    flag: Arc<AtomicBool>,
    above: Option<Box<Cancel>>,
}

impl Cancel {
    /// A token for a part of the work: it hears a request to this one, and its own stops only the
    /// part.
    pub fn part(&self) -> Self {
        Self {
            flag: Arc::default(),
            above: Some(Box::new(self.clone())),
        }
    }

    /// Asks every holder of this token to stop at its next check.
    pub fn request(&self) {
        self.flag.store(true, Ordering::Relaxed);
    }

    /// True once a stop was requested.
    pub fn requested(&self) -> bool {
        self.flag.load(Ordering::Relaxed)
            || self.above.as_ref().is_some_and(|above| above.requested())
    }

    /// Takes the request back, so that the token can serve the next piece of work.
    pub fn clear(&self) {
        self.flag.store(false, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_hears_the_whole_and_not_the_other_way_round() {
        let whole = Cancel::default();
        let (one, other) = (whole.part(), whole.part());
        let small = other.part();
        one.request();
        assert!(one.requested() && !other.requested() && !whole.requested());
        whole.request();
        assert!(other.requested() && small.requested());
    }
}
