//! The plan: the cheapest model that meets the asked accuracy, in words.

/// Which part of the cell a walk represents.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Reduction {
    /// All of it.
    #[default]
    Whole,
    /// The even quarter (half of a line cell), by cosine transforms. Modes of other symmetry are watched on the whole cell.
    Quarter,
}

impl Reduction {
    /// The word of the command line and the tables.
    pub fn word(self) -> &'static str {
        match self {
            Reduction::Whole => "whole",
            Reduction::Quarter => "quarter",
        }
    }
}
