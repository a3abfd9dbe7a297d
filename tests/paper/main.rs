//! Every figure of the paper, and what is found in it.

#[path = "../program/binary.rs"]
mod binary;
mod figures;
mod findings;
