//! Stub of branch `ui`.

use super::Failure;
use crate::experiment::scene::{Cell, Drive, LawChoice, Points, Range, Scene, Turn};
use crate::physics::indenter::Indenter;
use crate::physics::law::{Morse, Shape};
use std::path::Path;

/// Parses.
///
/// # Errors
/// Bad text.
pub fn parse(text: &str, file_name: &str) -> Result<Scene, Failure> {
    let (length, indenter, turn, title) = match text {
        "fig2" => (256.0, Indenter::Flat, Turn::At(0.2), "Fig. 2: four patterns"),
        "fig3" => (1024.0, Indenter::Flat, Turn::At(0.2), "Fig. 3: a larger cell"),
        "tip" => (256.0, Indenter::Hertz { radius: 256.0 }, Turn::ZeroLoad, "A tip"),
        _ => return Err(Failure(format!("{file_name}: not a scene (unknown key at line 1)"))),
    };
    Ok(Scene {
        title: title.to_owned(),
        source: "Wang, Zhou, Mueser 2020, Fig. 2".to_owned(),
        cell: Cell { length, points: Points::Square(64) },
        law: LawChoice { shape: Shape::Morse(Morse), surface_energy: 0.15, range: Range::Length(1.0) },
        indenter,
        drive: Drive { start: if length > 300.0 { 6.0 } else { 4.2 }, turn, step: 0.02 },
        accuracy: 0.01,
        seed: 1,
    })
}

/// Loads.
///
/// # Errors
/// Missing or bad file.
pub fn load(path: &Path) -> Result<Scene, Failure> {
    let text = std::fs::read_to_string(path).map_err(|e| Failure(format!("{}: {e}", path.display())))?;
    parse(&text, &path.display().to_string())
}

/// Saves.
///
/// # Errors
/// Cannot write.
pub fn save(path: &Path, _scene: &Scene) -> Result<(), Failure> {
    std::fs::write(path, "fig2").map_err(|e| Failure(format!("{}: {e}", path.display())))
}
