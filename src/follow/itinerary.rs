//! The path of the drive: which way it goes, and where each way ends. A run and the window step the
//! same value.

use super::record::{Direction, StateRecord};
use super::walk::Progress;
use crate::physics::pattern::Pattern;
use crate::scene::{Scene, Turn};

/// The ways still to go.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Itinerary {
    start: f64,
    /// u0 at which an approach turns at the latest (length).
    depth: f64,
    /// An approach turns where the load on a contact is zero.
    to_zero_load: bool,
    /// The present way last.
    ahead: Vec<Direction>,
}

impl Itinerary {
    /// The closed loop of the scene's drive: down to its turning point, and back to its start.
    pub fn closed(scene: &Scene) -> Self {
        Self {
            ahead: vec![Direction::Retraction, Direction::Approach],
            ..Self::one_way(scene, Direction::Approach)
        }
    }

    /// One way of the scene's drive, from wherever the surface is.
    pub fn one_way(scene: &Scene, direction: Direction) -> Self {
        let to_zero_load = scene.drive.turn == Turn::ZeroLoad;
        Self {
            start: scene.drive.start,
            depth: scene.depth(),
            to_zero_load,
            ahead: vec![direction],
        }
    }

    /// The present way; `None` at the end of all.
    pub fn direction(&self) -> Option<Direction> {
        self.ahead.last().copied()
    }

    /// u0 for which the present way makes (length); `None` at the end of all.
    pub fn target(&self) -> Option<f64> {
        Some(match self.direction()? {
            Direction::Approach => self.depth,
            Direction::Retraction => self.start,
        })
    }

    /// Takes in how a step of the walk ended, and its last record; true if the present way ended
    /// with it.
    pub fn step(&mut self, progress: &Progress, record: &StateRecord) -> bool {
        let approaches = self.direction() == Some(Direction::Approach);
        let unloaded = self.to_zero_load
            && approaches
            && record.pattern == Pattern::Contact
            && record.stress <= 0.0;
        let ends = *progress == Progress::Resting || *progress == Progress::Working && unloaded;
        if ends {
            self.ahead.pop();
        }
        ends
    }
}
