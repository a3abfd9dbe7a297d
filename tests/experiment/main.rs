//! Loops: walked, read off the atlas, planned, with their events, their ledger and their error bar.

mod atlas;
mod chart;
mod dissipation;
mod error_bar;
mod flat_ground;
mod forecast;
mod invariance;
mod landings;
mod ledger;
mod live_loop;
mod plan;
mod time_step_map;
mod uneven;
mod walk;
