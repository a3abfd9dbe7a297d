//! Everything the window shows, as plain data: built and updated without egui.

mod foresight;
mod plots;
mod run;
mod session;
mod stored;

pub use foresight::{Beside, Foresight};
pub use plots::{Ghost, Kept, KeptLoops, LiveView, Plots};
pub use run::{ClosedLoop, Hint, Origin, Pushed, RunView, Selection, Told};
pub use session::{Begin, Extent, History, Past, Saved};
pub use stored::{Films, Span, Store, foreseen, spans};

use super::action::ViewOptions;
use crate::follow::record::{JumpRecord, StateRecord};
use crate::lessons::Progress;
use crate::numerics::threads::Cancel;
use crate::physics::indenter::Indenter;
use crate::physics::parameter::{Dimension, Refusal, Value};
use crate::physics::theory::flat_limits;
use crate::plot::curve::Curve;
use crate::plot::loop_panel::{flat_state, loss};
use crate::scene::edit::Follows;
use crate::scene::{Model, Scene, Strategy, edit, parameter};
use crate::solver::methods::MethodKind;
use crate::worker::job::Job;
use crate::worker::protocol::{
    Command, Envelope, Event, Failure, Frame, Motion, Play, Resumed, RunId, Speed, Sweep,
};
use std::sync::Arc;

/// Most states kept for the export; the oldest quarter goes when it is full.
const STATES_MAX: usize = 200_000;
/// How far before its first jump the window opens (ranges): a short drag away.
const BEFORE_JUMP: f64 = 0.15;
/// What the title of an edited scene begins with.
const CHANGED: &str = "Changed: ";

/// The state of the window. What belongs to one run is in `run`; the rest survives it.
#[derive(Debug)]
pub struct ViewState {
    /// The scene.
    pub scene: Arc<Scene>,
    /// Which scene was opened; an edited one is still the one opened.
    pub opened: Opened,
    /// What the scene was decided to be.
    pub model: Model,
    /// The method.
    pub method: MethodKind,
    /// Whether the plan decides on the model.
    pub asked: Option<Strategy>,
    /// What follows mu_rho.
    pub follows: Follows,
    /// Ends of the control's slider (lower, upper).
    pub limits: (f64, f64),
    /// Where the control is asked to go.
    pub target: f64,
    /// The last sweep that was played.
    pub last_sweep: Sweep,
    /// The present run.
    pub run: RunView,
    /// The newest picture; that of the last run until this one has sent its own.
    pub frame: Option<Arc<Frame>>,
    /// What the diagrams show beside the run.
    pub plots: Plots,
    /// The scene beside this one.
    pub beside: Option<Beside>,
    /// What is said.
    pub messages: Messages,
    /// What somebody wrote, saved with the session.
    pub notes: String,
    /// How things are drawn.
    pub view: ViewOptions,
    /// Undo and redo.
    pub history: History,
    /// The lesson under way.
    pub lesson: Option<Progress>,
    /// Stops the measurement under way.
    measurement: Cancel,
    told: Sent,
}

/// The scene that was opened.
#[derive(Clone, Debug, PartialEq)]
pub struct Opened {
    /// As it was opened.
    scene: Arc<Scene>,
    /// How many were opened before it.
    pub count: usize,
    /// Its first run: what is told of older ones is another scene's.
    first_run: RunId,
    /// The window has opened with it, and nothing has snapped yet: where it will is left to guess.
    guessing: bool,
}

/// What the window says, in words and by sound.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Messages {
    /// What went wrong.
    pub failure: Option<Failure>,
    /// What went right ("written ...").
    pub notice: Option<String>,
    /// What somebody is told to do; `None` once it was done.
    pub hint: Option<Hint>,
    /// The jump that was last read aloud.
    pub announced: String,
    /// A snap clicks.
    pub click: bool,
}

impl Messages {
    /// Says what went wrong, and what to do about it.
    pub fn fail(&mut self, message: impl ToString, remedy: &str) {
        self.failure = Some(Failure {
            message: message.to_string(),
            remedy: remedy.to_owned(),
        });
    }
}

/// What the solver was told; a command is the difference to what the window shows.
#[derive(Clone, Copy, Debug, Default)]
struct Sent {
    run: RunId,
    motion: Motion,
    paused: bool,
    speed: Speed,
}

impl ViewState {
    /// A window at rest at the start of a scene.
    ///
    /// # Errors
    /// The scene's first value that is not allowed.
    pub fn new(scene: Scene) -> Result<Self, Refusal> {
        let model = scene.model()?;
        let limits = scene.window_of_control(&model);
        let run = RunView::new(1, &scene, limits.1);
        let ends = scene.window_of_u0(&model);
        let flat_state = flat_state(&model, scene.control(), ends);
        let scene = Arc::new(scene);
        Ok(Self {
            plots: Plots {
                flat_state,
                ..Plots::default()
            },
            scene: scene.clone(),
            opened: Opened {
                scene,
                count: 0,
                first_run: 1,
                guessing: false,
            },
            model,
            method: MethodKind::default(),
            asked: None,
            follows: Follows::default(),
            limits,
            target: limits.1,
            last_sweep: Sweep::Loop,
            run,
            frame: None,
            beside: None,
            messages: Messages {
                hint: Some(Hint::Grab),
                ..Messages::default()
            },
            notes: String::new(),
            view: ViewOptions::default(),
            history: History::default(),
            lesson: None,
            measurement: Cancel::default(),
            told: Sent::default(),
        })
    }

    /// A window that opens a little before the first jump of a scene on flat ground, which it does
    /// not tell of.
    ///
    /// # Errors
    /// The scene's first value that is not allowed.
    pub fn at_first_jump(scene: Scene) -> Result<Self, Refusal> {
        let mut state = Self::new(scene)?;
        state.opened.guessing = true;
        let (law, length) = (state.model.law, state.model.equivalent_length);
        let driven = !state.scene.control().frees_mean();
        let limits = flat_limits(&law, length);
        let is_flat = state.model.indenter == Indenter::Flat && driven;
        if let Some((_, upper)) = limits.filter(|_| is_flat) {
            let step = state.scene.drive.step;
            let near = ((upper + BEFORE_JUMP * law.range) / step).round() * step;
            state.target = near.clamp(state.limits.0, state.limits.1);
            state.run = RunView::new(1, &state.scene, state.target);
        }
        Ok(state)
    }

    /// The title of the scene that was opened, whatever was edited since.
    pub fn title_opened(&self) -> &str {
        title_without(&self.scene.title)
    }

    /// Another scene comes, with this run: nothing of the present one is true of it.
    fn forget_the_last_scene(&mut self, first_run: RunId) {
        self.frame = None;
        self.plots.live = None;
        self.plots.ghosts.clear();
        self.opened.first_run = first_run;
    }

    /// The range rho.
    pub fn rho(&self) -> f64 {
        self.model.law.range
    }

    /// True while the solver has said nothing of this run yet: the picture that is shown is that of
    /// the last one.
    pub fn is_waiting(&self) -> bool {
        self.run.state.is_none()
    }

    /// Back to rest at the start.
    pub fn reset(&mut self) {
        self.target = self.limits.1;
        self.restart();
    }

    /// Replaces the scene, keeping the target where it is possible. A scene that is not allowed is
    /// refused in words and changes nothing. Returns whether it was taken.
    pub fn set_scene(&mut self, scene: Scene) -> bool {
        let model = match scene.model() {
            Ok(model) => model,
            Err(error) => {
                let remedy = "The scene stays as it was; choose a value that is allowed.";
                self.messages.fail(error, remedy);
                return false;
            }
        };
        let at_start = self.target == self.limits.1;
        self.limits = scene.window_of_control(&model);
        if at_start || !(self.limits.0..=self.limits.1).contains(&self.target) {
            self.target = self.limits.1;
        }
        if model != self.model {
            self.plots.ghosts.clear();
        }
        if title_without(&scene.title) != self.title_opened() {
            self.forget_the_last_scene(self.run.id + 1);
        }
        self.opened.guessing = false;
        self.plots.beneath.clear();
        self.plots.branches = None;
        self.plots.preview = None;
        let ends = scene.window_of_u0(&model);
        self.plots.flat_state = flat_state(&model, scene.control(), ends);
        let is_another = title_without(&scene.title) != title_without(&self.opened.scene.title);
        self.scene = Arc::new(scene);
        if is_another || !self.scene.title.starts_with(CHANGED) {
            self.opened.scene = self.scene.clone();
        }
        self.model = model;
        self.messages.failure = None;
        self.plots.fit = None;
        self.restart();
        true
    }

    /// Replaces the scene by an edited one, remembering the old one for undo. Its title then says
    /// that it is not the one opened; a scene that was there before comes back as it was.
    pub fn edit_scene(&mut self, mut scene: Scene) {
        if scene == *self.scene {
            return;
        }
        let before = self.past();
        if let Some(known) = self.history.known(&scene, &self.scene) {
            scene = known;
        } else if !scene.title.starts_with(CHANGED) {
            scene.title.insert_str(0, CHANGED);
        }
        if self.set_scene(scene) {
            self.history.remember(before);
        }
    }

    /// Brings the number of this key back to what it is in the scene that was opened.
    pub fn bring_number_back(&mut self, key: &str) {
        let (opened, scene, model) = (&self.opened.scene, &self.scene, &self.model);
        let known = opened.numbers().into_iter().find(|(p, _)| p.key == key);
        let edited = match known.map(|(_, value)| value) {
            // It may be given by the mesh number there or here.
            _ if key == parameter::RANGE.key => opened
                .model()
                .map(|opened| edit::with_range(scene, model, opened.law.range)),
            Some(Value::Number(x)) => edit::with_parameter(scene, model, key, x),
            Some(Value::Whole(n)) => edit::with_parameter(scene, model, key, n as f64),
            _ => return,
        };
        match edited {
            Ok(scene) => self.edit_scene(scene),
            Err(error) => self.messages.fail(error, "The scene stays as it is."),
        }
    }

    /// Opens another scene at rest at its start, which can be taken back like an edit.
    pub fn open_scene(&mut self, scene: Scene) {
        let before = self.past();
        self.target = self.limits.1;
        if self.set_scene(scene) {
            self.opened.scene = self.scene.clone();
            self.forget_the_last_scene(self.run.id);
            (self.method, self.asked) = Default::default();
            self.opened.count += 1;
            self.history.end_gesture();
            self.history.remember(before);
            self.messages.hint.get_or_insert(Hint::Lower);
            self.messages.notice = None;
        }
    }

    /// Chooses the method, which begins a new run.
    pub fn set_method(&mut self, method: MethodKind) {
        if method != self.method {
            self.history.remember(self.past());
            self.method = method;
            self.restart();
        }
    }

    /// Lets the plan decide on the model, or overrules it, which begins a new run.
    pub fn set_strategy(&mut self, asked: Option<Strategy>) {
        if asked != self.asked {
            self.history.remember(self.past());
            self.asked = asked;
            self.restart();
        }
    }

    /// Begins another run; the solver is told at the end of the frame.
    fn restart(&mut self) {
        self.run = RunView::new(self.run.id + 1, &self.scene, self.target);
        self.plots.guesses.clear();
        self.measurement.request();
        self.messages.notice = None;
        self.hint_afresh();
    }

    /// Notes a measurement that has begun: the one before ends, and this one with the run.
    pub fn measure<T>(&mut self, job: &Job<T>) {
        std::mem::replace(&mut self.measurement, job.cancel()).request();
    }

    /// What the solver must hear: at most one scene and one motion per frame, in the order that
    /// makes sense to it.
    pub fn take_commands(&mut self) -> Vec<Envelope<Command>> {
        let (run, told) = (&mut self.run, &mut self.told);
        let motion = run.motion;
        let mut commands = Vec::new();
        if told.run != run.id {
            let resumed = |state| {
                let along = run.record.clone();
                Arc::new(Resumed { state, along })
            };
            let from = run.from.take().map(resumed);
            // A session counts motions afresh, from the rest at the start, and is not held.
            *told = Sent {
                run: run.id,
                motion: 0,
                paused: false,
                ..*told
            };
            commands.push(Command::SetScene {
                scene: self.scene.clone(),
                method: self.method,
                asked: self.asked,
                from,
            });
        }
        if let Some(from) = run.from.take() {
            // A session that goes on from a state rests there.
            if run.play == Play::ToTarget(from.record.control) {
                told.motion = motion;
            }
            commands.push(Command::GoOn { motion, from });
        }
        if std::mem::replace(&mut told.motion, motion) != motion {
            let play = run.play;
            commands.push(Command::Play { motion, play });
        }
        if std::mem::replace(&mut told.paused, run.paused) != run.paused {
            commands.push(Command::Pause { paused: run.paused });
        }
        let speed = self.view.speed;
        if std::mem::replace(&mut told.speed, speed) != speed {
            commands.push(Command::SetSpeed { speed });
        }
        commands
            .into_iter()
            .map(|message| Envelope {
                run: run.id,
                message,
            })
            .collect()
    }

    /// Takes an event of the solver in. Those of another run are stale and dropped, but for live
    /// loops, which are late by nature.
    pub fn apply(&mut self, Envelope { run, message }: Envelope<Event>) {
        if run != self.run.id && !matches!(message, Event::Live(_)) {
            return;
        }
        match message {
            Event::Ready(ready) => self.run.ready = Some(ready),
            Event::State(state) => self.add_state(state),
            Event::Frame(frame) => {
                self.moved_to(frame.control);
                self.frame = Some(frame);
                (self.run.replayed, self.run.shown) = (None, None);
                self.run.foresight = Foresight::default();
            }
            Event::Pressed { energy } => self.take_pressed(energy),
            Event::Stored(stored) => self.run.store.keep(stored),
            Event::Jump(jump) => {
                self.opened.guessing = false;
                self.hint_after_jump(&jump);
                self.run.curve.cut();
                self.run.stiffness.cut();
                self.run.record.jumps.push(jump);
            }
            Event::Film(film) => {
                let jump = self.run.record.jumps.len().saturating_sub(1);
                self.run.films.keep(jump, film);
            }
            Event::Cut { states, jumps } => self.cut(states, jumps),
            Event::Loop(summary) => {
                self.run.closed_loop = Some(ClosedLoop {
                    summary,
                    loss: loss(&self.run.curve),
                });
            }
            // The end of an older motion: the newest is on its way to the solver.
            Event::Rest { motion, .. } if motion != self.run.motion => {}
            Event::Rest { control, .. } => {
                self.moved_to(control);
                self.run.play = Play::Rest;
            }
            Event::Live(live) => self.take_live(run, live),
            Event::Remodelled(choice) => {
                // Under a hand that presses nothing may move; the bar says it all the same.
                if !self.is_pressed() {
                    let why = choice.because.as_deref().unwrap_or("asked for");
                    self.messages.notice = Some(format!("now on the whole cell: {why}"));
                }
                if let Some(ready) = &mut self.run.ready {
                    Arc::make_mut(ready).choice = choice;
                }
            }
            Event::Failed(failure) => {
                self.messages.failure = Some(failure);
                self.run.play = Play::Rest;
            }
        }
    }

    fn add_state(&mut self, state: StateRecord) {
        self.moved_to(state.control);
        self.run.direction = state.direction;
        self.hint_after_state(&state);
        self.run.curve.push(&state, &self.model.law);
        let law = &self.model.law;
        let stiffness = &mut self.run.stiffness;
        stiffness.push_with(&state, law, state.stiffness_min);
        if self.run.record.states.len() >= STATES_MAX {
            self.run.record.states.drain(..STATES_MAX / 4);
            self.run.store.forgotten += STATES_MAX / 4;
            self.select_nothing();
        }
        self.run.record.states.push(state.clone());
        self.run.state = Some(state);
    }

    /// A sweep takes the thumb along; otherwise the thumb stays where the hand left it.
    fn moved_to(&mut self, control: f64) {
        self.run.actual = control;
        if self.run.sweep().is_some() {
            self.target = self.held(control);
        }
    }

    /// What the plan expects of the loss; NaN while it is not known.
    pub fn predicted_error(&self) -> f64 {
        self.run
            .ready
            .as_ref()
            .map_or(f64::NAN, |ready| ready.choice.plan.predicted_error)
    }

    /// A jump in words.
    pub fn say_jump(&self, jump: &JumpRecord) -> String {
        let [length, energy] =
            [Dimension::Length, Dimension::SurfaceEnergy].map(|of| self.model.unit(of));
        format!(
            "{} at u₀ = {} on {}, released {} ({})",
            jump.change(),
            length.say(jump.mean_displacement / self.rho(), 3, "ρ"),
            jump.direction,
            energy.say(jump.released_energy, 4, "γ"),
            jump.cause_words()
        )
    }
}

/// The title of a scene without the words that say that it was edited.
fn title_without(title: &str) -> &str {
    title.strip_prefix(CHANGED).unwrap_or(title)
}
