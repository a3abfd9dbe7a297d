//! `tackscope presets`: what is built in.

use super::{DONE, say};
use crate::physics::grid::Grid;
use crate::storage::{Failure, presets, scene_file};

/// Prints name, title, mesh and mu_rho of every preset, and what to look for.
pub(super) fn list() -> Result<u8, Failure> {
    for preset in presets::all() {
        for line in entry(preset)? {
            say(&line)?;
        }
    }
    Ok(DONE)
}

fn entry(preset: &presets::Preset) -> Result<[String; 4], Failure> {
    let scene = preset.scene()?;
    let model = scene
        .model()
        .map_err(|error| scene_file::refused(preset.name, error))?;
    let Grid { length, nx, ny } = model.grid;
    let facts = format!(
        "L = {length}, {nx} x {ny} points; mu_rho = {:.3}",
        model.mu_rho
    );
    let below = |text: &str| format!("{:16}{text}", "");
    Ok([
        format!("{:<14}  {}", preset.name, scene.title),
        below(&facts),
        below(&preset.hint()),
        String::new(),
    ])
}
