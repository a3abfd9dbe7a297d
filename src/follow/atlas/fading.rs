//! Patterns that fade away at a limit of the flat state: where the flat state gives way continuously
//! (a supercritical bifurcation) a branch does not turn back, but goes over into it.
//!
//! Of the Landau energy r a^2 + g a^4 + h a^6 of an amplitude a, r is proportional to the distance
//! from the limit and h > 0. With g > 0 the pattern goes as the root of that distance; with g < 0 it
//! is still there at the limit, and has a fold beyond.

use crate::numerics::dense::dot;
use crate::physics::theory::flat_limits;
use crate::solver::method::Lost;
use crate::solver::sector::{Node, SHARP, Sector, Side};

/// Distance (ranges) before a limit from which a pattern may be seen to fade.
const NEAR: f64 = 0.15;
/// Where a^2, falling as it does, would vanish, in units of the distance to the limit: below 2 for
/// g > 0, and above for g < 0.
const TRICRITICAL: f64 = 2.0;
/// The same where a^2 is as good as proportional to the distance.
const LINEAR: f64 = 1.25;
/// Distance (ranges) from which it is believed: farther off another symmetry may be lost on the way.
const CERTAIN: f64 = 0.02;
/// At this distance (ranges), up to so much more, the fold lies within 2e-5 ranges of the limit, and a
/// jump would free too little to be told from none.
const NEXT: f64 = 5e-4;
const UNRESOLVED: f64 = 2.5;

/// A pattern about to fade.
pub struct Fading {
    /// u0 of the limit, and the distance to it (length).
    limit: f64,
    pub ahead: f64,
    /// True where it is known to.
    pub is_certain: bool,
}

impl Fading {
    /// `None` where the branch of `here` does not seem to fade on this `side`.
    pub fn of(sector: &Sector, here: &Node, side: Side) -> Option<Self> {
        let system = sector.system();
        let (law, length) = (system.law(), system.grid().length);
        let limit = <[f64; 2]>::from(flat_limits(law, length)?)[side.index()];
        let ahead = side.sign() * (limit - here.u0());
        let z = &here.state.amplitudes;
        let fall = -2.0 * side.sign() * dot(z, &here.tangent);
        let vanishes = dot(z, z) / (fall * ahead);
        let is_near = 0.0 < ahead && ahead < NEAR * law.range;
        let is_next = ahead < NEXT * law.range;
        let most = if is_next { UNRESOLVED } else { TRICRITICAL };
        (is_near && 0.0 < vanishes && vanishes < most).then_some(Self {
            limit,
            ahead,
            is_certain: vanishes < LINEAR && ahead < CERTAIN * law.range || is_next,
        })
    }

    /// The end of the branch, whose slope is extrapolated from the last node and one `before`.
    pub fn end(&self, sector: &Sector, before: Option<&Node>, here: &Node) -> Node {
        let bend = before.map_or(0.0, |b| (here.slope - b.slope) / (here.u0() - b.u0()));
        let slope = here.slope + bend * (self.limit - here.u0());
        sector.out_of_flat(self.limit, slope)
    }
}

/// The end on a `side` where a branch fades whose `end` and the node `near` it are those of a slightly
/// different law or cell, if it still does.
///
/// # Errors
/// It does not, as far as the node near it tells.
pub fn refade(to: &mut Sector, end: &Node, near: &Node, side: Side) -> Result<Node, Lost> {
    let (law, length) = (to.system().law(), to.system().grid().length);
    let limits = flat_limits(law, length).ok_or(Lost::Gone)?;
    let u0 = <[f64; 2]>::from(limits)[side.index()] + near.u0() - end.u0();
    let (node, _) = to.node(u0, near.state.amplitudes.clone(), None, SHARP)?;
    let fading = Fading::of(to, &node, side).ok_or(Lost::Gone)?;
    let slope = node.slope + end.slope - near.slope;
    Ok(to.out_of_flat(fading.limit, slope))
}
