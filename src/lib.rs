//! Tackscope: a desktop explorer of adhesive hysteresis.
//!
//! A soft elastic body is lowered onto a sticky rigid surface and pulled off again. Its surface
//! jumps on the way, and the area between the two curves of stress against mean displacement is
//! energy that no slowness can save.
//!
//! The rooms form floors, and arrows point down only (`tests/program/floors.rs` holds the walls):
//! [`numerics`] < [`physics`] < [`solver`], [`scene`] < [`follow`] < [`study`] < [`plot`] <
//! [`paper`], [`lessons`] < [`worker`], [`storage`] < [`cli`], `ui`.
//!
//! Units: the contact modulus E* is 1; lengths are in any one unit; stresses in E*; energies per
//! area in E* times that length.
#![forbid(unsafe_code)]
#![warn(missing_docs)]
// They panic where nobody listens; the command line has doors of its own.
#![deny(clippy::print_stdout, clippy::print_stderr)]

pub mod cli;
pub mod follow;
pub mod lessons;
pub mod numerics;
pub mod paper;
pub mod physics;
pub mod plot;
pub mod scene;
pub mod solver;
pub mod storage;
pub mod study;
#[cfg(feature = "gui")]
pub mod ui;
pub mod worker;
