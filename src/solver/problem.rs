//! The problem that is solved: its mechanics, and whether its patterns can slide.

use crate::physics::preconditioner::Preconditioner;
use crate::physics::system::System;

/// What every method needs to know of the problem.
#[derive(Clone, Copy, Debug)]
pub struct Problem<'s> {
    /// The mechanics.
    pub system: &'s System,
    /// Diagonal approximate inverse of the Hessian.
    pub preconditioner: &'s Preconditioner,
    /// Whether patterns can slide.
    pub slides: Slides,
}

/// Whether patterns can slide over the ground, which gives modes without stiffness that say nothing about stability.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slides {
    /// Uneven ground holds them.
    Never,
    /// Flat ground under a fine mesh.
    Freely,
    /// Flat ground under a coarse mesh, which may pin them: where it does the modes are real and stay.
    UnlessPinned,
}
