//! Closed forms, laws, grounds and mechanics: what is known without solving for a loop.

mod even;
mod griffith;
mod hertz;
mod jkr;
mod laws;
mod layer;
mod mechanics;
mod mesh_rule;
mod numerics;
mod patterns;
mod theory;
mod topography;
