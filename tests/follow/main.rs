//! Loops: walked and read off the atlas, with their events and their ledger.

mod atlas;
mod dissipation;
#[path = "../shared/flat_ground.rs"]
mod flat_ground;
mod invariance;
mod landings;
mod ledger;
mod uneven;
mod walk;
