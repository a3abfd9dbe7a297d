//! What is done with loops: plan, error bar, chart, live loop, forecast.

mod chart;
mod error_bar;
#[path = "../shared/flat_ground.rs"]
mod flat_ground;
mod forecast;
mod live_loop;
mod plan;
mod time_step_map;
