//! Closed forms: production code and oracles at once.

pub mod flat;
