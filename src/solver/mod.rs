//! Floor 2: equilibria along a branch, their stability, and the release after an instability.
//!
//! A [`State`](crate::physics::system::State) is a vector of amplitudes z at a mean displacement
//! u0. Eigenvalues are of the Hessian per area in the metric mean(v^2), in E* per length; where a
//! record says E*/L they are multiplied by L. Knows neither scenes nor clocks. May use `physics`
//! and `numerics`.

pub mod class_proof;
pub mod continuation;
pub mod descent;
pub mod gfmd;
pub mod index;
pub mod mechanics;
pub mod method;
pub mod methods;
pub mod newton;
mod proof;
pub mod release;
pub mod sector;
pub mod stability;

pub use method::{Lost, Stop};
