//! What somebody is told who has done nothing yet: to lower the body, to pull it off, and what was
//! lost.

use super::ViewState;
use crate::follow::record::{Direction, JumpRecord, StateRecord};
use crate::physics::indenter::Indenter;
use crate::study::why::calm;

/// How far somebody is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hint {
    /// Nothing was moved yet.
    Grab,
    /// Nothing has snapped yet.
    Lower,
    /// It has snapped on the way down.
    PullOff,
    /// It is back where it was.
    Loss,
}

impl ViewState {
    /// The hint in words; `None` where there is none, a lesson says what to do, or the surface
    /// moves by itself.
    pub fn hint(&self) -> Option<String> {
        let hint = self.messages.hint?;
        let moves = self.run.sweep().is_some() || self.jumping().is_some();
        if self.lesson.is_some() || moves {
            return None;
        }
        Some(match hint {
            Hint::Grab | Hint::Lower => match calm(&self.scene, &self.model) {
                Some(calm) => format!("Here nothing snaps. {}", calm.remedy),
                None if self.model.indenter == Indenter::Flat => {
                    "Drag down slowly. Something will snap.".to_owned()
                }
                None => "Drag down slowly. Something may snap.".to_owned(),
            },
            Hint::PullOff => "Now pull it off again.".to_owned(),
            Hint::Loss if self.run.closed_loop.is_some() => {
                "The shaded area is what was lost.".to_owned()
            }
            Hint::Loss => "The jumps add up to what was lost.".to_owned(),
        })
    }

    /// Something was moved.
    pub(super) fn hint_after_motion(&mut self) {
        if self.messages.hint == Some(Hint::Grab) {
            self.messages.hint = Some(Hint::Lower);
        }
    }

    /// Another run: nothing has snapped in it.
    pub(super) fn hint_afresh(&mut self) {
        if self.messages.hint.is_some_and(|hint| hint != Hint::Grab) {
            self.messages.hint = Some(Hint::Lower);
        }
    }

    pub(super) fn hint_after_jump(&mut self, jump: &JumpRecord) {
        if jump.direction == Direction::Approach && self.messages.hint.is_some() {
            self.messages.hint = Some(Hint::PullOff);
        }
    }

    pub(super) fn hint_after_state(&mut self, state: &StateRecord) {
        let record = &self.run.record;
        let first = record.states.first().map(|first| first.pattern);
        let last = record.jumps.last().map(|jump| jump.direction);
        self.messages.hint = match (self.messages.hint, state.direction) {
            (Some(Hint::Loss), Direction::Approach) => None,
            // Who has been all the way down is told nothing new.
            (Some(Hint::Grab | Hint::Lower), _) if state.control <= self.limits.0 => None,
            (Some(Hint::PullOff), Direction::Retraction)
                if last == Some(Direction::Retraction) && first == Some(state.pattern) =>
            {
                Some(Hint::Loss)
            }
            (hint, _) => hint,
        };
    }
}
