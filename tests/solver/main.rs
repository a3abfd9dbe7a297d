//! One equilibrium and its stability; and what is known to go wrong, each case provoked in a method
//! that has it, and seen to be caught and named.

mod classes;
mod common;
mod dense;
mod jumps;
#[path = "../shared/loops.rs"]
mod loops;
mod methods;
mod numbers;
mod planted_modes;
mod precision;
mod saddles;
mod stability_audit;
mod tracker;
