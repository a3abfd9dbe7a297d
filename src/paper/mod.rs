//! Floor 4: every figure and table of the paper as a value, computed live beside its theory, with what the print got wrong.
//!
//! Each figure is one file and one line in [`GALLERY`]. Nothing is drawn here: `storage` writes a [`Figure`] as CSV, SVG and PNG, the
//! window shows it as plots. Axes and normalisation are the paper's; the stress is turned into its pressure p = -stress where the paper
//! plots p. May use `experiment` and below; no drawing, files, or threads.

pub mod figure;
mod figure_04;
mod figure_07;
mod figure_08;
mod figure_11;
mod line_cell;
pub mod scenes;
pub mod task;

pub use figure::{Figure, Table};
pub use task::{Size, Stopped, Task};

use crate::experiment::scene::Scene;

/// A place in the gallery.
pub struct Entry {
    /// The figure's number in the paper.
    pub number: usize,
    /// One line.
    pub title: &'static str,
    /// What to look for, in two sentences.
    pub look_for: &'static str,
    /// The scene that a click on it opens.
    pub scene: fn() -> Scene,
    /// Computes it.
    pub compute: fn(&mut Task<'_>) -> Result<Figure, Stopped>,
}

/// The figures in the paper's order.
pub const GALLERY: &[Entry] = &[figure_04::ENTRY, figure_07::ENTRY, figure_08::ENTRY, figure_11::ENTRY];
