//! What is done with loops: plan, error bar, chart, live loop, forecast.

#[path = "../program/binary.rs"]
mod binary;
mod chart;
#[path = "../solver/dense.rs"]
mod dense;
mod forecast;
mod landscape;
mod live_loop;
#[path = "../shared/loops.rs"]
mod loops;
mod map;
mod plan;
mod reality;
mod reference;
mod sweep;
mod why;
