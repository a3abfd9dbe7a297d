//! Which part of the cell is solved.

use serde::{Deserialize, Serialize};
use std::fmt;

/// The part of the cell that is solved; the rest follows by symmetry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub enum Part {
    /// Nothing: the flat state over flat ground is a closed form.
    Flat,
    /// The even half of a line, for a ridge of a square cell.
    Ridge,
    /// All of a line cell.
    Line,
    /// The even half of a line cell. Modes of other symmetry are watched on all of it.
    HalfLine,
    /// The even quarter of a square cell. Modes of other symmetry are watched on all of it.
    Quarter,
    /// The even quarter or half, held mirror-symmetric: what a surface does that is held so. On a
    /// coarse mesh single points let go; in the whole cell their mirror images do so one by one, a
    /// little earlier or later.
    Mirrored,
    /// All of a square cell.
    #[default]
    Whole,
}

impl Part {
    /// The word of the command line and of tables.
    pub fn word(self) -> &'static str {
        match self {
            Part::Flat => "flat",
            Part::Ridge => "ridge",
            Part::Line => "line",
            Part::HalfLine => "half line",
            Part::Quarter => "quarter",
            Part::Whole => "whole",
            Part::Mirrored => "mirrored",
        }
    }

    /// The same part of a line cell: all of it, or its half.
    pub fn of_line(self) -> Self {
        match self {
            Part::Whole => Part::Line,
            Part::Quarter => Part::HalfLine,
            other => other,
        }
    }

    /// True if only even fields are solved.
    pub fn is_even(self) -> bool {
        matches!(
            self,
            Part::Ridge | Part::HalfLine | Part::Quarter | Part::Mirrored
        )
    }
}

/// As a state's record says which model it is of.
impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Part::Flat => "flat, closed form",
            Part::Ridge => "ridge on half a line",
            Part::Line => "line cell",
            Part::HalfLine => "half line cell",
            Part::Quarter => "quarter cell",
            Part::Mirrored => "mirrored quarter",
            Part::Whole => "whole cell",
        })
    }
}

/// How a loop is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Strategy {
    /// Read off the branches of an atlas, every state solved on the part that its pattern needs.
    Atlas,
    /// By the walk on a part of the cell.
    Walk(Part),
}

impl Strategy {
    /// The walk on the whole cell: the reference of all.
    pub const WHOLE: Self = Strategy::Walk(Part::Whole);
    /// The walk on the even quarter.
    pub const QUARTER: Self = Strategy::Walk(Part::Quarter);

    /// The word of the command line and of tables.
    pub fn word(self) -> &'static str {
        match self {
            Strategy::Atlas => "atlas",
            Strategy::Walk(part) => part.word(),
        }
    }
}

/// Why a mesh of n x n points has no quarter whose modes are resolved; `None` if it has.
pub fn no_quarter(n: usize) -> Option<String> {
    (!n.is_multiple_of(4) || n < 16).then(|| format!("{n} points are no multiple of 4 from 16 on"))
}
