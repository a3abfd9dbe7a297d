//! Floor 3: the scene, the walk along u0, its record of states and jumps, and the loop with its ledger.
//!
//! May use `solver`, `physics` and `numerics`; no threads, channels or files.

pub mod atlas;
pub mod chart;
pub mod contest;
pub mod error_bar;
pub mod flat_branch;
pub mod forecast;
pub mod itinerary;
pub mod ledger;
pub mod live_loop;
pub mod measured_law;
pub mod mesh;
pub mod parameter;
pub mod part;
pub mod plan;
pub mod planned;
pub mod record;
pub mod run;
pub mod scene;
pub mod time_step_map;
mod tour;
pub mod walk;
