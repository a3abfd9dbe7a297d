//! Floor 4: what is done with loops: the plan and the run that follows it, the error bar, the chart
//! of speed against accuracy, the live loop of a dragged parameter; what is ahead of a surface, why
//! it snapped, the equations it obeys, and whether it is real; a study of a scene at many values of
//! its numbers, and how they converge with the mesh.
//!
//! May use `follow` and all below it; no threads, channels or files.

pub mod chart;
pub mod forecast;
pub mod ground;
pub mod landscape;
pub mod live_loop;
pub mod map;
pub mod plan;
pub mod reality;
pub mod sweep;
pub mod time_step_map;
pub mod why;
