//! Which pattern a surface shows, by the topology of its contact set on the torus.
//!
//! The cell is periodic, so a connected piece of contact may close on itself around the cell. Its
//! closed loops generate a lattice of winding vectors (turns along x, turns along y); the rank of
//! that lattice is 0 for an island, 1 for a line in any direction (a diagonal one too), 2 for a net
//! that surrounds the non-contact. Nothing here depends on where the pattern sits.

pub mod centre;
mod winding;

use super::law::Law;
use ndarray::{Array2, ArrayView2};
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
    /// On uneven ground: some contact.
    Contact,
    /// Anything else (on uneven ground: no contact; a field with a value that is not finite).
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

/// A surface whose gap varies by less than this share of the law's range is flat.
pub const FLATNESS: f64 = 1e-4;

/// The points in contact: those whose gap is below `threshold` (both lengths). Shape of `gap`.
pub fn contact_set(gap: ArrayView2<f64>, threshold: f64) -> Array2<bool> {
    gap.mapv(|g| g < threshold)
}

/// True if on the way from one contact set of the torus to the other its edge moves by a spacing at
/// most: every point that changes has a neighbour that was on the other side before. False where
/// there was no edge.
pub fn moves_by_a_spacing(before: &Array2<bool>, after: &Array2<bool>) -> bool {
    let (ny, nx) = before.dim();
    let beside = |y: usize, x: usize| {
        let (rows, columns) = (
            [y, (y + 1) % ny, (y + ny - 1) % ny],
            [x, (x + 1) % nx, (x + nx - 1) % nx],
        );
        rows.into_iter().any(|row| {
            columns
                .into_iter()
                .any(|column| before[[row, column]] != before[[y, x]])
        })
    };
    let has_edge = before.iter().any(|&inside| inside) && !before.iter().all(|&inside| inside);
    has_edge
        && before
            .indexed_iter()
            .all(|((y, x), inside)| after[[y, x]] == *inside || beside(y, x))
}

/// Share of the cell in contact, 0 to 1: points with a gap (length) below that of the law's largest
/// traction.
pub fn contact_area(gap: ArrayView2<f64>, law: &Law) -> f64 {
    let threshold = law.contact_gap();
    gap.iter().filter(|&&g| g < threshold).count() as f64 / gap.len() as f64
}

/// The pattern of a gap field (length; rows are y; one row is a line cell) above flat or uneven
/// ground.
///
/// On flat ground an uneven surface that lies wholly on one side of the law's contact gap (a faint
/// bulge near the fold where it flattens, a dimple about to close) is cut halfway between its
/// lowest and highest gap instead, so that its shape still decides. Of several pieces of contact
/// the one that wraps in most directions decides.
pub fn classify(gap: ArrayView2<f64>, law: &Law, flat_ground: bool) -> Pattern {
    let Some((low, high)) = extent(&gap) else {
        return Pattern::Other;
    };
    let contact_gap = law.contact_gap();
    if !flat_ground {
        return if low < contact_gap {
            Pattern::Contact
        } else {
            Pattern::Other
        };
    }
    if high - low < FLATNESS * law.range {
        return Pattern::Flat;
    }
    let one_sided = low >= contact_gap || high < contact_gap;
    let threshold = if one_sided {
        0.5 * (low + high)
    } else {
        contact_gap
    };
    if gap.nrows() == 1 {
        // Uniform along y: whatever is in contact wraps around y, and the rest of the row is not in
        // contact.
        return Pattern::Ridge;
    }
    match winding::rank(gap, threshold) {
        0 => Pattern::Bulge,
        1 => Pattern::Ridge,
        _ => Pattern::Dimple,
    }
}

/// Smallest and largest value; `None` for an empty field and where a value is not finite.
fn extent(gap: &ArrayView2<f64>) -> Option<(f64, f64)> {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut finite = true;
    for &g in gap {
        // `min` and `max` would swallow a NaN.
        finite &= g.is_finite();
        low = low.min(g);
        high = high.max(g);
    }
    (finite && low <= high).then_some((low, high))
}
