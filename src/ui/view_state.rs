//! Everything the window shows, as plain data: built and updated without egui.

mod axes;
mod keep;
mod listen;
mod live_view;
mod measure;
mod motion;
mod paper;
mod select;

pub use keep::Kept;
pub use live_view::LiveView;
pub use paper::PaperState;
pub use select::Selection;

use super::action::{Measurement, Tab, ViewOptions};
use super::history::History;
use super::scene_edit::{self, Follows};
use crate::experiment::part::Road;
use crate::experiment::record::{Direction, JumpRecord, LoopRecord, StateRecord};
use crate::experiment::scene::{Model, Scene, SceneError};
use crate::experiment::time_step_map::TimeStepMap;
use crate::experiment::walk::EnergyWell;
use crate::plot::curve::Curve;
use crate::plot::loop_panel::flat_state;
use crate::plot::panel::{Area, Series};
use crate::solver::methods::MethodKind;
use crate::worker::protocol::{ChartSoFar, Command, Frame, LoopSummary, Motion, Ready, RunId, Speed, Sweep};
use std::collections::VecDeque;
use std::sync::Arc;

/// What the title of an edited scene begins with.
const CHANGED: &str = "Changed: ";

/// Something went wrong, in words, with what to do about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// What happened.
    pub message: String,
    /// The remedy.
    pub remedy: String,
}

/// A closed loop as it is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct ClosedLoop {
    /// Its numbers.
    pub summary: LoopSummary,
    /// Its area.
    pub loss: Vec<Area>,
}

/// The state of the window.
#[derive(Clone, Debug)]
pub struct ViewState {
    /// Id of the present run; events of others are dropped.
    pub run: RunId,
    /// The scene.
    pub scene: Arc<Scene>,
    /// What the scene was decided to be.
    pub model: Model,
    /// The method.
    pub method: MethodKind,
    /// Whether the plan decides on the model.
    pub asked: Option<Road>,
    /// What follows mu_rho.
    pub follows: Follows,
    /// Facts of the scene, once the solver has sent them.
    pub ready: Option<Arc<Ready>>,
    /// Ends of the u0 slider (lower, upper).
    pub limits: (f64, f64),
    /// Where u0 is asked to go.
    pub target: f64,
    /// Where u0 is.
    pub actual: f64,
    /// Direction of the last motion.
    pub branch: Direction,
    /// The sweep under way.
    pub sweep: Option<Sweep>,
    /// The last sweep that was played.
    pub last_sweep: Sweep,
    /// Held.
    pub paused: bool,
    /// The solver has something to do.
    pub busy: bool,
    /// The newest picture.
    pub frame: Option<Arc<Frame>>,
    /// The newest equilibrium.
    pub state: Option<StateRecord>,
    /// Everything recorded in this run or loop.
    pub record: LoopRecord,
    /// The curve of `record`.
    pub curve: Curve,
    /// The smallest eigenvalue (E*/L) along `record`, as the stability tab draws it.
    pub stiffness: Curve,
    /// The newest energy well.
    pub well: Option<Arc<EnergyWell>>,
    /// Height of the well's picture (gamma).
    pub well_scale: f64,
    /// The time-step map as far as it is measured.
    pub time_steps: Option<Arc<TimeStepMap>>,
    /// The chart of speed against accuracy as far as it is measured.
    pub chart: Option<Arc<ChartSoFar>>,
    /// The measurement under way.
    pub measuring: Option<Measurement>,
    /// The paper's pages.
    pub paper: PaperState,
    /// The live loop.
    pub live: Option<LiveView>,
    /// The stored state somebody looks at.
    pub selection: Option<Selection>,
    /// Curves of earlier loops.
    pub ghosts: VecDeque<Curve>,
    /// The loop that is kept to compare with.
    pub kept: Option<Kept>,
    /// The last closed loop.
    pub closed_loop: Option<ClosedLoop>,
    /// The flat state's curve.
    pub flat_state: Vec<Series>,
    /// What went wrong.
    pub failure: Option<Failure>,
    /// What went right ("written ...").
    pub notice: Option<String>,
    /// True until the first jump.
    pub hint: bool,
    /// How things are drawn.
    pub view: ViewOptions,
    /// Plot fitted to the data instead of the scene: (lower left, upper right).
    pub fit: Option<([f64; 2], [f64; 2])>,
    /// Undo and redo.
    pub history: History,
    /// The newest motion asked for; a rest that ends an older one is stale.
    motion: Motion,
    scene_pending: bool,
    target_pending: bool,
    watching: bool,
    /// The speed that the solver was told.
    speed: Speed,
    outbox: Vec<Command>,
}

impl ViewState {
    /// A window at rest at the start of a scene.
    ///
    /// # Errors
    /// The scene's first value that is not allowed.
    pub fn new(scene: Scene) -> Result<Self, SceneError> {
        let model = scene.model()?;
        let limits = scene_edit::limits(&scene, &model);
        Ok(Self {
            run: 0,
            flat_state: flat_state(&model, limits.into()),
            scene: Arc::new(scene),
            model,
            method: MethodKind::default(),
            asked: None,
            follows: Follows::default(),
            ready: None,
            limits,
            target: limits.1,
            actual: limits.1,
            branch: Direction::Approach,
            sweep: None,
            last_sweep: Sweep::Loop,
            paused: false,
            busy: false,
            frame: None,
            state: None,
            record: LoopRecord::default(),
            curve: Curve::default(),
            stiffness: Curve::default(),
            well: None,
            well_scale: 0.01,
            time_steps: None,
            chart: None,
            measuring: None,
            paper: PaperState::default(),
            live: None,
            selection: None,
            ghosts: VecDeque::new(),
            kept: None,
            closed_loop: None,
            failure: None,
            notice: None,
            hint: true,
            view: ViewOptions::default(),
            fit: None,
            history: History::default(),
            motion: 0,
            scene_pending: true,
            target_pending: false,
            watching: false,
            speed: Speed::default(),
            outbox: Vec::new(),
        })
    }

    /// The range rho.
    pub fn rho(&self) -> f64 {
        self.model.law.range
    }

    /// True while the solver has said nothing of this run yet: the picture that is shown is that of the last one.
    pub fn is_waiting(&self) -> bool {
        self.state.is_none()
    }

    /// Back to rest at the start.
    pub fn reset(&mut self) {
        self.target = self.limits.1;
        self.restart();
    }

    /// Replaces the scene, keeping the target where it is possible. A scene that is not allowed is refused in words and changes nothing.
    /// Returns whether it was taken.
    pub fn set_scene(&mut self, scene: Scene) -> bool {
        let model = match scene.model() {
            Ok(model) => model,
            Err(error) => {
                let remedy = "The scene stays as it was; choose a value that is allowed.".to_owned();
                self.failure = Some(Failure { message: error.to_string(), remedy });
                return false;
            }
        };
        let at_start = self.target == self.limits.1;
        self.limits = scene_edit::limits(&scene, &model);
        if at_start || !(self.limits.0..=self.limits.1).contains(&self.target) {
            self.target = self.limits.1;
        }
        if model != self.model {
            self.ghosts.clear();
        }
        // Mesh and step are what a chart compares; another law or cell is another loop.
        let loop_of = |m: &Model| (m.law, m.grid.length, m.grid.is_line(), m.indenter);
        if loop_of(&model) != loop_of(&self.model) {
            self.chart = None;
        }
        self.flat_state = flat_state(&model, self.limits.into());
        self.scene = Arc::new(scene);
        self.model = model;
        self.failure = None;
        self.fit = None;
        self.restart();
        true
    }

    /// Replaces the scene by an edited one, remembering the old one for undo. Its title then says that it is not the one opened.
    pub fn edit_scene(&mut self, mut scene: Scene) {
        let before = self.scene.clone();
        if scene == *before {
            return;
        }
        if !scene.title.starts_with(CHANGED) {
            scene.title.insert_str(0, CHANGED);
        }
        if self.set_scene(scene) {
            self.history.remember(before);
        }
    }

    /// Opens another scene at rest at its start, which can be taken back like an edit.
    pub fn open_scene(&mut self, scene: Scene) {
        let before = self.scene.clone();
        self.target = self.limits.1;
        if self.set_scene(scene) {
            // Another scene: nothing of the last one is true of it.
            self.frame = None;
            self.history.end_gesture();
            self.history.remember(before);
            self.hint = true;
            self.notice = None;
        }
    }

    /// Undo (or redo) of a scene edit.
    pub fn travel(&mut self, back: bool) {
        let present = self.scene.clone();
        let scene = if back { self.history.undo(present) } else { self.history.redo(present) };
        if let Some(scene) = scene {
            self.set_scene((*scene).clone());
        }
    }

    /// Chooses the method, which begins a new run.
    pub fn set_method(&mut self, method: MethodKind) {
        if method != self.method {
            self.method = method;
            self.restart();
        }
    }

    /// Lets the plan decide on the model, or overrules it, which begins a new run.
    pub fn set_road(&mut self, asked: Option<Road>) {
        if asked != self.asked {
            self.asked = asked;
            self.restart();
        }
    }

    /// Forgets the run; the solver is told at the end of the frame.
    fn restart(&mut self) {
        self.scene_pending = true;
        self.target_pending = self.target != self.limits.1;
        // The session counts afresh from the rest at the start, which is motion 0.
        self.motion = u64::from(self.target_pending);
        // A page of the paper belongs to no run.
        self.outbox.retain(|command| matches!(command, Command::OpenPage { .. } | Command::ClosePage));
        if self.paused {
            self.pause(false);
        }
        self.sweep = None;
        self.busy = self.target_pending;
        self.ready = None;
        self.notice = None;
        self.state = None;
        self.actual = self.limits.1;
        self.branch = Direction::Approach;
        self.record = LoopRecord::default();
        self.curve = Curve::default();
        self.stiffness = Curve::default();
        self.closed_loop = None;
        self.selection = None;
        self.well = None;
        self.time_steps = None;
        self.measuring = None;
    }

    /// What the solver must hear, at most one scene and one target per frame, in the order that makes sense to it.
    pub fn take_commands(&mut self) -> Vec<Command> {
        let mut commands = Vec::new();
        if std::mem::take(&mut self.scene_pending) {
            self.run += 1;
            commands.push(Command::SetScene { run: self.run, scene: self.scene.clone(), method: self.method, asked: self.asked });
        }
        if std::mem::take(&mut self.target_pending) {
            self.outbox.retain(|command| !matches!(command, Command::Sweep { .. }));
            commands.push(Command::SetTarget { run: self.run, motion: self.motion, mean_displacement: self.target });
        }
        let run = self.run;
        commands.extend(self.outbox.drain(..).map(|command| match command {
            Command::Sweep { motion, sweep, .. } => Command::Sweep { run, motion, sweep },
            Command::Stop { motion, .. } => Command::Stop { run, motion },
            other => other,
        }));
        let watching = self.view.tab == Tab::EnergyWell;
        if std::mem::replace(&mut self.watching, watching) != watching {
            commands.push(Command::Watch { energy_well: watching });
        }
        if std::mem::replace(&mut self.speed, self.view.speed) != self.view.speed {
            commands.push(Command::SetSpeed { speed: self.view.speed });
        }
        commands
    }

    /// What the plan expects of the loss; NaN while it is not known.
    pub fn predicted_error(&self) -> f64 {
        self.ready.as_ref().map_or(f64::NAN, |ready| ready.choice.plan.predicted_error)
    }

    /// A jump in words.
    pub fn say_jump(&self, jump: &JumpRecord) -> String {
        format!(
            "{} → {} at u₀ = {:.3} ρ on {}, released {:.4} γ ({})",
            jump.from,
            jump.to,
            jump.mean_displacement / self.rho(),
            jump.direction,
            jump.released_energy,
            jump.cause_words()
        )
    }
}
