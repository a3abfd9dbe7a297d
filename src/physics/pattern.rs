//! Which pattern a surface shows, by the topology of its contact set on the torus.

use std::fmt;

/// The patterns of the paper, and what else a surface can be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Pattern {
    /// Uniform gap.
    Flat,
    /// An island of contact: its components wrap around the cell in no direction.
    Bulge,
    /// A line of contact: wraps in exactly one direction.
    Ridge,
    /// An island of non-contact: the contact wraps in both directions.
    Dimple,
    /// On uneven ground: some contact. On flat ground: contact everywhere, yet not uniform.
    Contact,
    /// Anything else (on uneven ground: no contact).
    Other,
}

impl Pattern {
    /// The word of the tables and labels.
    pub fn word(self) -> &'static str {
        match self {
            Pattern::Flat => "flat",
            Pattern::Bulge => "bulge",
            Pattern::Ridge => "ridge",
            Pattern::Dimple => "dimple",
            Pattern::Contact => "contact",
            Pattern::Other => "other",
        }
    }
}

impl fmt::Display for Pattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.word())
    }
}
