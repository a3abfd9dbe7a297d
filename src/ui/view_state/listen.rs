//! What the window makes of what the solver says.

use super::live_view::LiveView;
use super::{ClosedLoop, Failure, ViewState};
use crate::experiment::live_loop::Sample;
use crate::experiment::record::{LoopRecord, StateRecord};
use crate::experiment::walk::EnergyWell;
use crate::physics::pattern::Pattern;
use crate::plot::curve::{Curve, eigenvalue_scale};
use crate::plot::loop_panel::loss;
use crate::ui::scene_edit;
use crate::worker::protocol::{Event, Frame, LiveState, RunId};
use std::sync::Arc;

/// Most states kept for the export; the oldest quarter goes when it is full.
const STATES_MAX: usize = 200_000;
/// Most faint curves of earlier loops.
const GHOSTS_MAX: usize = 3;

impl ViewState {
    /// Takes an event of the solver in; stale ones are dropped.
    pub fn apply(&mut self, event: Event) {
        let of = match &event {
            Event::Ready { run, .. }
            | Event::State { run, .. }
            | Event::Jump { run, .. }
            | Event::LoopStarted { run }
            | Event::Loop { run, .. }
            | Event::Rest { run, .. }
            | Event::Well { run, .. }
            | Event::Live { run, .. }
            | Event::TimeSteps { run, .. }
            | Event::Chart { run, .. }
            | Event::Measured { run, .. }
            | Event::Remodelled { run, .. }
            | Event::Failed { run, .. } => *run,
            Event::Paper { .. } => self.run,
        };
        let event = match event {
            Event::Live { run, live } => return self.take_live(run, live),
            Event::Paper { page, news } => return self.take_page(page, news),
            event => event,
        };
        if of != self.run || self.scene_pending {
            return;
        }
        match event {
            Event::Ready { ready, .. } => self.ready = Some(ready),
            Event::State { state, .. } => self.add_state(state),
            Event::Jump { jump, .. } => {
                self.hint = false;
                self.curve.cut();
                self.stiffness.cut();
                self.record.jumps.push(jump);
            }
            Event::LoopStarted { .. } => self.archive(),
            Event::Loop { summary, .. } => self.closed_loop = Some(ClosedLoop { summary, loss: loss(&self.curve) }),
            // The end of an older motion: the newest is on its way to the solver.
            Event::Rest { motion, .. } if motion != self.motion => {}
            Event::Rest { mean_displacement, .. } => {
                self.actual = mean_displacement;
                if self.sweep.take().is_some() {
                    self.target = mean_displacement;
                }
                self.busy = false;
            }
            Event::Well { well, .. } => self.take_well(well),
            Event::Live { .. } | Event::Paper { .. } => {}
            Event::TimeSteps { map, .. } => self.time_steps = Some(map),
            Event::Chart { chart, .. } => self.chart = Some(chart),
            Event::Measured { stuck, .. } => {
                self.measuring = None;
                if let Some(message) = stuck {
                    let remedy = "What was measured stands.".to_owned();
                    self.failure = Some(Failure { message: format!("The measurement ended early: {message}."), remedy });
                }
            }
            Event::Remodelled { choice, .. } => {
                let why = choice.because.as_deref().unwrap_or("asked for");
                self.notice = Some(format!("now on the whole cell: {why}"));
                if let Some(ready) = &mut self.ready {
                    Arc::make_mut(ready).choice = choice;
                }
            }
            Event::Failed { message, remedy, .. } => {
                self.failure = Some(Failure { message, remedy });
                self.sweep = None;
                self.busy = false;
            }
        }
    }

    /// Takes a picture in; stale ones are dropped.
    pub fn apply_frame(&mut self, run: RunId, frame: Arc<Frame>) {
        if run != self.run || self.scene_pending {
            return;
        }
        self.moved_to(frame.mean_displacement);
        self.frame = Some(frame);
    }

    fn add_state(&mut self, state: StateRecord) {
        self.moved_to(state.mean_displacement);
        self.branch = state.direction;
        // Who has been all the way down is told nothing new.
        self.hint &= state.mean_displacement > self.limits.0;
        self.curve.push(&state, &self.model.law);
        self.stiffness.push_with(&state, &self.model.law, eigenvalue_scale(state.stiffness_min));
        if self.record.states.len() >= STATES_MAX {
            self.record.states.drain(..STATES_MAX / 4);
        }
        self.record.states.push(state.clone());
        self.state = Some(state);
    }

    /// A sweep takes the thumb along; otherwise the thumb stays where the hand left it.
    fn moved_to(&mut self, u0: f64) {
        self.actual = u0;
        if self.sweep.is_some() {
            self.target = u0;
        }
    }

    /// While a parameter is dragged every loop is late by a few frames; it is drawn all the same.
    fn take_live(&mut self, run: RunId, live: Arc<LiveState>) {
        if self.live.as_ref().is_none_or(|shown| run >= shown.run) {
            self.live = Some(LiveView::new(run, live));
        }
    }

    /// Where the surface will stand at the target, read off the live loop of this very scene.
    pub fn foreseen(&self) -> Option<(Pattern, Sample)> {
        let live = self.live.as_ref().filter(|live| live.run == self.run && !self.scene_pending)?;
        if self.target == self.actual {
            return None;
        }
        live.state.found.as_ref().ok()?.reading(self.state.as_ref()?, self.target)
    }

    /// Its picture is rescaled only where it leaves the frame or shrinks to a few pixels.
    fn take_well(&mut self, well: Arc<EnergyWell>) {
        let gamma = self.model.law.surface_energy;
        let lowest = well.energies.iter().fold(0.0f64, |a, e| a.min(*e));
        let top = well.energies.iter().fold(0.0f64, |a, e| a.max(*e)).max(-2.0 * lowest) / gamma;
        if top > 0.0 && !(top / self.well_scale > 0.12 && top <= self.well_scale) {
            self.well_scale = scene_edit::nice(1.2 * top);
        }
        self.well = Some(well);
    }

    /// A fresh loop begins: what there was becomes a ghost.
    fn archive(&mut self) {
        self.stiffness = Curve::default();
        self.selection = None;
        let old = std::mem::take(&mut self.curve);
        if old.points().nth(2).is_some() {
            self.ghosts.push_back(old);
            if self.ghosts.len() > GHOSTS_MAX {
                self.ghosts.pop_front();
            }
        }
        self.record = LoopRecord::default();
        self.closed_loop = None;
    }
}
