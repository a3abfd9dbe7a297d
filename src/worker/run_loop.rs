//! Stub of branch `ui`: closed-form flat states and painted patterns, to look at the window. Replaced at merge.

use super::protocol::{Command, Event, Frame, LoopSummary, Ready, RunId, Sweep};
use crate::experiment::record::{Branch, Cause, JumpRecord, StateRecord};
use crate::experiment::scene::{Model, Scene, Turn};
use crate::physics::pattern::Pattern;
use crate::physics::theory::flat;
use crate::solver::Stop;
use crossbeam_channel::{Receiver, Sender, unbounded};
use ndarray::Array2;
use std::sync::{Arc, Mutex};

/// Stub.
pub struct Worker {
    tx: Sender<Command>,
    rx: Receiver<Event>,
    slot: Arc<Mutex<Option<(RunId, Arc<Frame>)>>>,
}

impl Worker {
    /// Stub.
    pub fn spawn(wake: impl Fn() + Send + Sync + 'static) -> Worker {
        let (tx, commands) = unbounded();
        let (events, rx) = unbounded();
        let slot = Arc::new(Mutex::new(None));
        let mine = slot.clone();
        std::thread::spawn(move || Fake { events, slot: mine, wake: Box::new(wake) }.run(&commands));
        Worker { tx, rx, slot }
    }
    /// Stub.
    pub fn send(&self, command: Command) {
        let _ = self.tx.send(command);
    }
    /// Stub.
    pub fn events(&self) -> impl Iterator<Item = Event> {
        self.rx.try_iter()
    }
    /// Stub.
    pub fn take_frame(&self) -> Option<(RunId, Arc<Frame>)> {
        self.slot.lock().ok()?.take()
    }
}

struct Fake {
    events: Sender<Event>,
    slot: Arc<Mutex<Option<(RunId, Arc<Frame>)>>>,
    wake: Box<dyn Fn() + Send + Sync>,
}

struct Run {
    id: RunId,
    scene: Arc<Scene>,
    model: Model,
    u0: f64,
    pattern: Pattern,
    targets: Vec<f64>,
    looping: bool,
}

impl Fake {
    fn run(&self, commands: &Receiver<Command>) {
        let mut run: Option<Run> = None;
        let mut paused = false;
        loop {
            let busy = run.as_ref().is_some_and(|r| !r.targets.is_empty()) && !paused;
            let command = if busy {
                commands.try_recv().ok()
            } else {
                match commands.recv() {
                    Ok(c) => Some(c),
                    Err(_) => return,
                }
            };
            match command {
                Some(Command::SetScene { run: id, scene, .. }) => {
                    let model = match scene.model() {
                        Ok(m) => m,
                        Err(e) => {
                            self.say(Event::Failed { run: id, message: e.to_string(), remedy: "Undo the edit.".into() });
                            continue;
                        }
                    };
                    let height = scene.indenter.height(&model.grid).map(Arc::new);
                    let u0 = scene.drive.start;
                    let ready = Ready { model: model.clone(), height, flat_limits: None };
                    self.say(Event::Ready { run: id, ready: Arc::new(ready) });
                    let r = Run { id, scene, model, u0, pattern: Pattern::Flat, targets: vec![], looping: false };
                    self.show(&r, Branch::Approach);
                    run = Some(r);
                }
                Some(Command::SetTarget { mean_displacement, .. }) => {
                    if let Some(r) = &mut run {
                        r.targets = vec![mean_displacement];
                        r.looping = false;
                    }
                }
                Some(Command::Sweep { sweep, .. }) => {
                    if let Some(r) = &mut run {
                        let (a, b) = (
                            match r.scene.drive.turn {
                                Turn::At(t) => t,
                                Turn::ZeroLoad => -1.0,
                            },
                            r.scene.drive.start,
                        );
                        r.looping = sweep == Sweep::Loop;
                        r.targets = match sweep {
                            Sweep::Approach => vec![a],
                            Sweep::Retract => vec![b],
                            Sweep::Loop => {
                                r.u0 = b;
                                self.say(Event::LoopStarted { run: r.id });
                                vec![b, a]
                            }
                        };
                    }
                }
                Some(Command::Pause { paused: p }) => paused = p,
                Some(Command::Stop) => {
                    if let Some(r) = &mut run {
                        r.targets.clear();
                        self.say(Event::Rest { run: r.id, mean_displacement: r.u0 });
                    }
                }
                Some(Command::Quit) => return,
                None => {}
            }
            if !paused && let Some(r) = &mut run {
                self.step(r);
            }
        }
    }

    fn step(&self, r: &mut Run) {
        let Some(&target) = r.targets.last() else { return };
        std::thread::sleep(std::time::Duration::from_millis(8));
        let step = r.scene.drive.step;
        let branch = if target < r.u0 { Branch::Approach } else { Branch::Retraction };
        let before = r.u0;
        r.u0 += (target - r.u0).clamp(-step, step);
        let x = r.u0 / r.model.law.range;
        let next = match (branch, r.pattern) {
            (Branch::Approach, Pattern::Flat) if x < 3.1 && x > 0.9 => Pattern::Ridge,
            (Branch::Approach, Pattern::Bulge) if x < 2.6 => Pattern::Ridge,
            (Branch::Approach, Pattern::Ridge) if x < 1.4 => Pattern::Dimple,
            (Branch::Approach, Pattern::Dimple) if x < 0.55 => Pattern::Flat,
            (Branch::Retraction, Pattern::Flat) if x > 0.787 && x < 3.1 => Pattern::Dimple,
            (Branch::Retraction, Pattern::Dimple) if x > 2.0 => Pattern::Ridge,
            (Branch::Retraction, Pattern::Ridge) if x > 3.3 => Pattern::Bulge,
            (Branch::Retraction, Pattern::Bulge) if x > 3.7 => Pattern::Flat,
            _ => r.pattern,
        };
        if next != r.pattern && r.model.grid.ny > 1 {
            let (a, b) = (self.state(r, branch), r.pattern);
            r.pattern = next;
            let c = self.state(r, branch);
            self.say(Event::State { run: r.id, state: a.clone() });
            let jump = JumpRecord {
                branch,
                mean_displacement: r.u0,
                from: b,
                to: next,
                stress_before: a.stress,
                stress_after: c.stress,
                released_energy: 0.07,
                cause: Cause::Fold,
            };
            self.say(Event::Jump { run: r.id, jump });
        }
        self.show(r, branch);
        if r.u0 == target || r.u0 == before {
            r.targets.pop();
            if r.targets.is_empty() {
                if r.looping {
                    let summary = LoopSummary {
                        dissipated_energy: 0.412,
                        released_energy_sum: 0.413,
                        ledger_mismatch: 0.002,
                        transforms: 1234,
                        seconds: 0.8,
                    };
                    self.say(Event::Loop { run: r.id, summary });
                }
                self.say(Event::Rest { run: r.id, mean_displacement: r.u0 });
            }
        }
    }

    fn state(&self, r: &Run, branch: Branch) -> StateRecord {
        let law = &r.model.law;
        let response = law.at(r.u0);
        let lift = match r.pattern {
            Pattern::Flat => response.traction,
            Pattern::Dimple => 0.35 * law.traction_max() + 0.1 * response.traction,
            Pattern::Ridge => 0.28 * law.traction_max(),
            _ => 0.18 * law.traction_max(),
        };
        StateRecord {
            branch,
            mean_displacement: r.u0,
            stress: lift,
            stress_over_max: lift / law.traction_max(),
            contact_area: 0.3,
            pattern: r.pattern,
            residual: 1e-9,
            stiffness_min: flat::stiffness_min(law, r.model.grid.length, r.u0).max(0.02),
            stiffness_error: 1e-6,
            energy: response.energy,
            model: if r.pattern == Pattern::Flat { "flat, closed form" } else { "whole cell" },
            stop: Stop::Stable,
            iterations: 3,
            transforms: 24,
            milliseconds: 1.8,
        }
    }

    fn show(&self, r: &Run, branch: Branch) {
        let state = self.state(r, branch);
        let (ny, nx) = r.model.grid.shape();
        let u0 = r.u0;
        let rho = r.model.law.range;
        let mut gap = Array2::from_shape_fn((ny, nx), |(j, i)| {
            let x = (i as f64 / nx as f64 * std::f64::consts::TAU).cos();
            let y = (j as f64 / ny as f64 * std::f64::consts::TAU + 1.0).cos();
            let s = match r.pattern {
                Pattern::Ridge => 1.0 - y,
                Pattern::Dimple => (x + y - 0.6).max(0.0) * 2.0,
                Pattern::Flat => 0.0,
                _ => (1.3 - (x + y) / 1.5).max(0.0),
            };
            0.15 * rho + s * u0
        });
        let mean = gap.mean().unwrap_or(0.0);
        gap.mapv_inplace(|g| if r.pattern == Pattern::Flat { u0 } else { (g / mean * u0).max(0.08 * rho) });
        if let Some(h) = r.scene.indenter.height(&r.model.grid) {
            gap = h.mapv(|h| (u0 - h).max(0.05 * rho));
        }
        let frame =
            Frame { mean_displacement: u0, stress: state.stress, gap: Arc::new(gap), relaxing: false, state: Some(state.clone()) };
        if let Ok(mut slot) = self.slot.lock() {
            *slot = Some((r.id, Arc::new(frame)));
        }
        self.say(Event::State { run: r.id, state });
    }

    fn say(&self, event: Event) {
        let _ = self.events.send(event);
        (self.wake)();
    }
}
