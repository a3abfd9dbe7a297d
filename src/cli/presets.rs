//! `tackscope presets`: what is built in.

use super::{BAD_INPUT, DONE, say};
use crate::physics::grid::Grid;
use crate::storage::{Failure, presets, scene_file};

/// Prints name, title, mesh and mu_rho of every preset, and what to look for.
pub(super) fn list() -> u8 {
    for preset in presets::all() {
        match entry(preset) {
            Ok(text) => say(&text),
            Err(failure) => {
                eprintln!("tackscope: {failure}");
                return BAD_INPUT;
            }
        }
    }
    DONE
}

fn entry(preset: &presets::Preset) -> Result<String, Failure> {
    let scene = preset.scene()?;
    let model = scene.model().map_err(|error| scene_file::refused(preset.name, error))?;
    let Grid { length, nx, ny } = model.grid;
    let facts = format!("L = {length}, {nx} x {ny} points; mu_rho = {:.3}", model.mu_rho);
    Ok(format!("{:<14}  {}\n{:16}{facts}\n{:16}{}\n", preset.name, scene.title, "", "", preset.hint()))
}
