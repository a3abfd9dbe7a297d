//! Floor 2: equilibria along a branch, their stability, and the release after an instability.

mod stop;

pub use stop::Stop;
