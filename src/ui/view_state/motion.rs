//! How u0 is moved: by hand, by key, by itself.

use super::ViewState;
use crate::experiment::record::Direction;
use crate::worker::protocol::{Command, Sweep};

impl ViewState {
    /// Asks the solver to walk to `u0`, held inside the drive.
    pub fn set_target(&mut self, u0: f64) {
        let u0 = u0.clamp(self.limits.0, self.limits.1);
        if !u0.is_finite() || u0 == self.target && self.sweep.is_none() {
            return;
        }
        if u0 != self.actual {
            self.branch = if u0 < self.actual { Direction::Approach } else { Direction::Retraction };
        }
        self.target = u0;
        self.motion += 1;
        self.target_pending = true;
        self.sweep = None;
        self.busy = true;
        self.resume();
    }

    /// Starts a sweep.
    pub fn play(&mut self, sweep: Sweep) {
        self.sweep = Some(sweep);
        self.last_sweep = sweep;
        self.busy = true;
        self.target_pending = false;
        self.resume();
        self.motion += 1;
        // The run id is filled in when the command leaves: a scene edit of the same frame may still change it.
        self.outbox.push(Command::Sweep { run: self.run, motion: self.motion, sweep });
    }

    /// Space: pause, go on, or start.
    pub fn toggle_play(&mut self) {
        if self.paused {
            self.pause(false);
        } else if self.busy {
            self.pause(true);
        } else {
            self.play(self.last_sweep);
        }
    }

    /// Holds or goes on.
    pub fn pause(&mut self, paused: bool) {
        self.paused = paused;
        self.outbox.push(Command::Pause { paused });
    }

    fn resume(&mut self) {
        if self.paused {
            self.pause(false);
        }
    }

    /// Drops target and sweep; the thumb goes where the surface is.
    pub fn stop(&mut self) {
        self.outbox.retain(|command| !matches!(command, Command::Sweep { .. }));
        self.resume();
        self.motion += 1;
        self.outbox.push(Command::Stop { run: self.run, motion: self.motion });
        self.sweep = None;
        self.busy = false;
        self.target_pending = false;
        self.target = self.actual;
    }

    /// Moves the target by so many increments; further key presses add up although the solver is still on its way.
    pub fn step(&mut self, increments: f64) {
        self.set_target(self.target + increments * self.scene.drive.step);
    }

    /// One increment in the present direction.
    pub fn increment(&mut self) {
        self.step(if self.branch == Direction::Approach { -1.0 } else { 1.0 });
    }

    /// Turns round.
    pub fn reverse(&mut self) {
        let (sweep, branch) = match self.branch {
            Direction::Approach => (Sweep::Retract, Direction::Retraction),
            Direction::Retraction => (Sweep::Approach, Direction::Approach),
        };
        if self.sweep.is_some() {
            self.play(sweep);
        }
        self.branch = branch;
    }
}
