//! Floor 6: every figure and table of the paper as a value, computed live beside its theory, with
//! what the print got wrong.
//!
//! Each figure is an [`Entry`] in a file (Figs 2 and 3 share theirs) and one line in [`GALLERY`].
//! Nothing is drawn here: `storage` writes a [`Figure`] as CSV, SVG and PNG, the window shows it as
//! plots. Axes and normalisation are the paper's; the stress is turned into its pressure
//! p = -stress where the paper plots p. May use `plot` and below; no drawing, files, or threads.

pub mod boundary_elements;
pub mod errata;
pub mod figure;
mod figure_01;
mod figure_04;
mod figure_05;
mod figure_06;
mod figure_07;
mod figure_08;
mod figure_09;
mod figure_10;
mod figure_11;
mod figure_12;
mod figure_13;
mod figure_14;
mod figures_02_03;
pub mod measured_law;
pub mod overlay;
pub mod scenes;

pub use scenes as tips;

pub use figure::{Entry, Figure, Size, Stopped, Table, TableEntry, Task};

/// The figures in the paper's order.
pub const GALLERY: &[Entry] = &[
    figure_01::ENTRY,
    figures_02_03::FIGURE_2,
    figures_02_03::FIGURE_3,
    figure_04::ENTRY,
    figure_05::ENTRY,
    figure_06::ENTRY,
    figure_07::ENTRY,
    figure_08::ENTRY,
    figure_09::ENTRY,
    figure_10::ENTRY,
    figure_11::ENTRY,
    figure_12::ENTRY,
    figure_13::ENTRY,
    figure_14::ENTRY,
];

/// Those of tips under a load in place of a driven displacement.
pub const UNDER_LOAD: &[Entry] = &[figure_12::UNDER_LOAD, figure_13::UNDER_LOAD];

/// Figures that take longest at full size, the longest first; the others take seconds.
const LONG: [usize; 5] = [13, 12, 14, 3, 11];

/// The figures of a gallery with the long ones first: the order in which several are soonest done
/// together.
pub fn longest_first(gallery: &'static [Entry]) -> Vec<&'static Entry> {
    let mut list: Vec<&'static Entry> = gallery.iter().collect();
    list.sort_by_key(|entry| {
        LONG.iter()
            .position(|number| *number == entry.number)
            .unwrap_or(LONG.len())
    });
    list
}

/// The tables.
pub const TABLES: &[TableEntry] = &[figure::MESH_NUMBERS];
