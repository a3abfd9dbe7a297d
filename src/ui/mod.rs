//! Floor 8: the window (eframe, egui, egui_plot, rfd), behind the feature `gui`.
//!
//! A panel is a function that reads the [`view_state::ViewState`] and pushes [`action::Action`]s;
//! only [`app`] acts on them. A tab below the plot holds what only it needs, and acts once a frame
//! on what was asked of it. The state is plain data that is built and updated without egui. The
//! solver is behind [`crate::worker::SolverHandle`]: its thread never blocks the window, and tests
//! drive one by hand. May use everything below; touches files only through `storage`, starts no
//! thread.
//!
//! Lengths are shown in units of the range rho, stresses in units of sigma_max, energies in units
//! of gamma.

pub mod action;
pub mod app;
pub mod theme;
pub mod view_state;

mod commands;
mod controls;
mod diagram;
mod dialogs;
mod display;
mod files;
mod gap_map;
mod gap_picture;
mod grip;
mod headline;
mod layout;
mod loop_plot;
mod profile;
mod sliders;
mod tabs;
mod toolbar;
mod widgets;
mod words;

pub use app::{App, Player};
pub use dialogs::PathFuture;
pub use display::{begun, display_available, run};
