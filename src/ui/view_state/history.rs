//! Undo and redo: the scenes before and after the present one, and where their surfaces were.

use crate::scene::part::Strategy;
use crate::scene::{Drive, Scene};
use crate::solver::methods::MethodKind;
use crate::worker::protocol::Stored;
use std::sync::Arc;

/// Among how many of the last scenes one that comes back is looked for.
const RECENT: usize = 16;
/// Most edits that can be taken back.
const DEPTH: usize = 200;

/// A scene, how it was computed, and where its surface was; `None` at the start of the drive.
#[derive(Clone, Debug)]
pub struct Past {
    pub(super) scene: Arc<Scene>,
    pub(super) method: MethodKind,
    pub(super) asked: Option<Strategy>,
    pub(super) surface: Option<Arc<Stored>>,
}

/// Undo and redo of scene edits: the scenes before and after the present one. One drag is one undo,
/// however many values it passes.
#[derive(Clone, Debug, Default)]
pub struct History {
    undo: Vec<Past>,
    redo: Vec<Past>,
    in_gesture: bool,
}

impl History {
    /// Notes that `before` is about to be replaced. Within one gesture only the first call counts.
    pub fn remember(&mut self, before: Past) {
        if !self.in_gesture {
            self.undo.push(before);
            if self.undo.len() > DEPTH {
                self.undo.remove(0);
            }
        }
        self.in_gesture = true;
        self.redo.clear();
    }

    /// The newest of the scenes before that the `edited` one differs from in title and drive alone:
    /// there and back, as from law to law, the drive would else stay adapted to the way. None where
    /// it is the drive of the `present` scene that was edited.
    pub(super) fn known(&self, edited: &Scene, present: &Scene) -> Option<Scene> {
        let same = |a: &Scene| {
            let like = Scene {
                title: edited.title.clone(),
                drive: Drive {
                    control: a.drive.control,
                    ..edited.drive
                },
                ..a.clone()
            };
            like == *edited
        };
        if same(present) {
            return None;
        }
        let before = self.undo.iter().rev().take(RECENT);
        before
            .map(|past| &*past.scene)
            .find(|scene| same(scene))
            .cloned()
    }

    /// The pointer is up: the next edit is another one.
    pub fn end_gesture(&mut self) {
        self.in_gesture = false;
    }

    /// What was before `present`, if anything.
    pub fn undo(&mut self, present: Past) -> Option<Past> {
        let past = self.undo.pop()?;
        self.redo.push(present);
        Some(past)
    }

    /// What came after `present`, if anything.
    pub fn redo(&mut self, present: Past) -> Option<Past> {
        let past = self.redo.pop()?;
        self.undo.push(present);
        Some(past)
    }

    /// The scene that an undo brings back.
    pub fn before(&self) -> Option<&Arc<Scene>> {
        self.undo.last().map(|past| &past.scene)
    }

    /// True if there is something to take back.
    pub fn can_undo(&self) -> bool {
        !self.undo.is_empty()
    }

    /// True if there is something to do again.
    pub fn can_redo(&self) -> bool {
        !self.redo.is_empty()
    }
}
