//! Floor 3: from state to state along the drive: the walk, the atlas of branches, their states and
//! jumps, and the loop with its ledger.
//!
//! May use `scene`, `solver`, `physics` and `numerics`; no scene files, threads, channels or
//! drawing.

pub mod atlas;
pub mod diagram;
pub mod flat_branch;
pub mod ledger;
pub mod record;
pub mod run;
mod tour;
pub mod walk;
