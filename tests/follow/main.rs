//! Loops: walked and read off the atlas, with their events and their ledger.

mod atlas;
mod control;
#[path = "../solver/dense.rs"]
mod dense;
mod diagram;
mod diagram_control;
mod diagram_states;
mod dissipation;
mod invariance;
mod landings;
mod layer;
mod ledger;
#[path = "../shared/loops.rs"]
mod loops;
mod made_up_loops;
mod push;
mod short_cells;
mod uneven;
mod walk;
