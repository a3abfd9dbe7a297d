//! What is known to go wrong, each case provoked in a method that has it, and seen to be caught and named.

mod common;
mod jumps;
mod mesh;
mod numbers;
mod saddles;
mod steps;
