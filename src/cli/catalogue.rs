//! `tackscope presets`, `lessons` and `scene`: what is built in, whether each lesson can be done, and
//! what a scene leaves open, decided.

use super::{
    DONE, INTERRUPTED, LessonsArguments, NOT_CONVERGED, SceneArguments, cancel_on_signal, print,
    say, scene_with_points, warn,
};
use crate::lessons::all;
use crate::physics::grid::Grid;
use crate::scene::Scene;
use crate::scene::edit::decided;
use crate::storage::{Failure, presets, scene_file};
use crate::study::reality::reality;
use crate::worker::rehearsal::rehearse;

/// Lists the lessons, or performs each and says what it explained; returns the exit code.
///
/// # Errors
/// A standard output that cannot be written.
pub(super) fn lessons(arguments: &LessonsArguments) -> Result<u8, Failure> {
    let cancel = cancel_on_signal();
    let mut code = DONE;
    for lesson in all() {
        let (name, steps) = (&lesson.name, lesson.steps.len());
        say(&format!(
            "{name:<16}  {}: {steps} steps, {} minutes",
            lesson.title, lesson.minutes
        ))?;
        if !arguments.check {
            say(&format!("{:18}{}", "", lesson.teaches))?;
            continue;
        }
        match rehearse(lesson, &of_preset, &cancel) {
            Ok(told) => {
                for (step, words) in told.iter().enumerate() {
                    let words = words.split_whitespace().collect::<Vec<_>>().join(" ");
                    say(&format!("{:16}{} {words}", "", step + 1))?;
                }
            }
            Err(_) if cancel.requested() => return Ok(INTERRUPTED),
            Err(why) => {
                warn(why);
                code = NOT_CONVERGED;
            }
        }
    }
    Ok(code)
}

/// The scene of a preset's name.
fn of_preset(name: &str) -> Result<Scene, String> {
    let preset = presets::find(name).ok_or_else(|| format!("there is no preset {name}"))?;
    preset.scene().map_err(|failure| failure.to_string())
}

/// Prints name, title, mesh and mu_rho of every preset, and what to look for.
pub(super) fn presets() -> Result<u8, Failure> {
    for preset in presets::all() {
        for line in entry(preset)? {
            say(&line)?;
        }
    }
    Ok(DONE)
}

/// Prints the decided scene.
pub(super) fn scene(arguments: &SceneArguments) -> Result<u8, Failure> {
    let (scene, place) = scene_with_points(&arguments.scene, None)?;
    let model = scene
        .model()
        .map_err(|error| scene_file::refused(&place, error))?;
    let decided = decided(&scene, &model);
    let text = if arguments.json {
        scene_file::to_json(&decided)
    } else {
        scene_file::to_text(&decided)
    };
    print(text.trim_end())?;
    // What people read stands beside what programs do.
    warn("is this scene real?");
    reality(&model).iter().for_each(warn);
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
