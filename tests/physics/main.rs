//! Closed forms, laws, grounds and mechanics: what is known without solving for a loop.

mod griffith;
mod hertz;
mod laws;
mod layer;
#[path = "../shared/loops.rs"]
mod loops;
mod mechanics;
mod mesh_rule;
mod numerics;
mod patterns;
mod theory;
mod topography;
