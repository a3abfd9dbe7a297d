//! `tackscope lessons`: what is built in, and whether each lesson can be done.

use super::{DONE, INTERRUPTED, LessonsArguments, NOT_CONVERGED, cancel_on_signal, say, warn};
use crate::lessons::all;
use crate::scene::Scene;
use crate::storage::{Failure, presets};
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
        match rehearse(lesson, &scene, &cancel) {
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
fn scene(name: &str) -> Result<Scene, String> {
    let preset = presets::find(name).ok_or_else(|| format!("there is no preset {name}"))?;
    preset.scene().map_err(|failure| failure.to_string())
}
