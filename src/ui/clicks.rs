//! The click of a jump, if it is wanted.

use crate::storage::click;
use crate::worker::SolverHandle;
use crate::worker::job::{Job, Reporter};
use crate::worker::sound;
use std::sync::Arc;

/// Makes the sound and returns at its end, on a thread of its own; or says why it cannot.
pub type Player = Arc<dyn Fn() -> Result<(), String> + Send + Sync>;

/// By a program of the desktop.
pub fn desktop() -> Player {
    Arc::new(|| {
        let file = click::file().map_err(|error| error.to_string())?;
        sound::play(file.path())
    })
}

fn play(player: &Player, _: &Reporter<()>) -> Result<(), String> {
    player()
}

/// What clicks.
pub struct Clicks {
    player: Player,
    sounding: Option<Job<()>>,
}

impl Clicks {
    /// By this player.
    pub fn new(player: Player) -> Self {
        Self {
            player,
            sounding: None,
        }
    }

    /// Clicks, unless the last click still sounds: a hundred jumps in a second are no hundred
    /// programs.
    pub fn click(&mut self, solver: &dyn SolverHandle) {
        if self.sounding.as_ref().is_none_or(|job| !job.is_running()) {
            self.sounding = Some(solver.job(self.player.clone(), play));
        }
    }

    /// Why there was no click, once.
    pub fn failed(&mut self) -> Option<String> {
        self.sounding.as_mut()?.poll()?.err()
    }
}
