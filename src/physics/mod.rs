//! Floor 1: elastic bodies, cohesive laws, indenters, patterns, the mesh rule and closed-form
//! theory.
//!
//! Signs and units: contact modulus E* = 1; `stress` and `traction` are positive in tension
//! (attraction); energies are per area of the cell. The gap is g = u - h with the indenter's
//! highest point at h = 0. May use `numerics` only.

pub mod body;
pub mod control;
pub mod indenter;
pub mod law;
pub mod low_block;
pub mod mesh;
pub mod parameter;
pub mod pattern;
pub mod preconditioner;
pub mod system;
pub mod theory;
pub mod topography;
