//! Undo and redo of scene edits. One drag is one undo, however many values it passes.

use crate::scene::Scene;
use std::sync::Arc;

/// Most edits that can be taken back.
const DEPTH: usize = 200;

/// The scenes before and after the present one.
#[derive(Clone, Debug, Default)]
pub struct History {
    undo: Vec<Arc<Scene>>,
    redo: Vec<Arc<Scene>>,
    in_gesture: bool,
}

impl History {
    /// Notes that `before` is about to be replaced. Within one gesture only the first call counts.
    pub fn remember(&mut self, before: Arc<Scene>) {
        if !self.in_gesture {
            self.undo.push(before);
            if self.undo.len() > DEPTH {
                self.undo.remove(0);
            }
        }
        self.in_gesture = true;
        self.redo.clear();
    }

    /// The pointer is up: the next edit is another one.
    pub fn end_gesture(&mut self) {
        self.in_gesture = false;
    }

    /// The scene before `present`, if any.
    pub fn undo(&mut self, present: Arc<Scene>) -> Option<Arc<Scene>> {
        let scene = self.undo.pop()?;
        self.redo.push(present);
        Some(scene)
    }

    /// The scene after `present`, if any.
    pub fn redo(&mut self, present: Arc<Scene>) -> Option<Arc<Scene>> {
        let scene = self.redo.pop()?;
        self.undo.push(present);
        Some(scene)
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
