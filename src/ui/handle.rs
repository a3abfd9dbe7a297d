//! What the window needs of a solver.

use crate::worker::Worker;
use crate::worker::protocol::{Command, Event, Frame, RunId};
use std::sync::Arc;

/// A solver as the window sees it: neither call blocks.
pub trait SolverHandle {
    /// Passes a command on.
    fn send(&mut self, command: Command);

    /// The events that have arrived since the last call, and the newest picture if there is one.
    fn poll(&mut self) -> (Vec<Event>, Option<(RunId, Arc<Frame>)>);
}

impl SolverHandle for Worker {
    fn send(&mut self, command: Command) {
        Worker::send(self, command);
    }

    fn poll(&mut self) -> (Vec<Event>, Option<(RunId, Arc<Frame>)>) {
        (self.events().collect(), self.take_frame())
    }
}
