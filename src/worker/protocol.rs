//! What the window says to the solver, and what it hears back; and how the pictures of a walk become
//! the films of its jumps.

use super::job::{Computation, Compute, Job, Wake, Work};
use crate::follow::ledger::Ledger;
use crate::follow::record::{JumpRecord, LoopRecord, StateRecord};
use crate::follow::walk::{Push, Walk};
use crate::physics::system::Fields;
use crate::scene::{Model, Part, Scene, Strategy};
use crate::solver::method::Equilibrium;
use crate::solver::methods::MethodKind;
use crate::study::live_loop::{Fineness, LiveLoop};
use crate::study::plan::ModelChoice;
use ndarray::Array2;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::time::Duration;

/// Identifies one run of one scene.
pub type RunId = u64;

/// Number of a motion within its run, counted by the sender from 1. A rest names the motion it
/// ends, so that the end of an older one is not taken for the end of the newest.
pub type Motion = u64;

/// A continuous motion of the target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sweep {
    /// From here down to the drive's turning point.
    Approach,
    /// From here up to the drive's start.
    Retract,
    /// A fresh closed loop: start, turn, start.
    Loop,
}

/// What the surface is doing, or is asked to do; the latest wins.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum Play {
    /// Nothing: the present target and sweep are dropped; answers within 50 ms with [`Event::Rest`].
    #[default]
    Rest,
    /// It walks to this value of the control: u0, the stage's position (length), or the load per area
    /// (E*). The path already gone is kept.
    ToTarget(f64),
    /// It walks by itself.
    Sweep(Sweep),
    /// It is held pressed where it rests; [`Event::Pressed`] says with how much energy.
    Pressed(Push),
    /// It was let go that is, or were, pressed so, and comes to rest at the same control.
    LetGo(Push),
}

/// How fast sweeps and jumps are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Speed {
    /// Slow motion: a quarter of the normal speed.
    Slow,
    /// A loop of some hundred states in some seconds, a jump as a short film.
    #[default]
    Normal,
    /// As fast as they are computed.
    Full,
}

impl Speed {
    /// The pause for which the normal speed has this one.
    pub fn pause(self, normal: Duration) -> Duration {
        match self {
            Speed::Slow => 4 * normal,
            Speed::Normal => normal,
            Speed::Full => Duration::ZERO,
        }
    }
}

/// Something went wrong, in words, with what to do about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// What happened.
    pub message: String,
    /// The remedy.
    pub remedy: String,
}

/// A message with the run it belongs to; one of another run is stale, and is dropped where it
/// arrives.
#[derive(Clone, Debug)]
pub struct Envelope<T> {
    /// The run.
    pub run: RunId,
    /// What is said.
    pub message: T,
}

/// From the window to the solver.
#[derive(Clone, Debug)]
pub enum Command {
    /// Forget everything and rest at the start of this scene, or on a stored state of it: a new
    /// run, whose id the envelope carries.
    SetScene {
        /// The scene.
        scene: Arc<Scene>,
        /// The method.
        method: MethodKind,
        /// Whether the plan decides on the model.
        asked: Option<Strategy>,
        /// The state on which it rests.
        from: Option<Arc<Resumed>>,
    },
    /// Do this.
    Play {
        /// Its number.
        motion: Motion,
        /// What.
        play: Play,
    },
    /// Take a stored state as the present one. Of the path so far what led to it stays, if it is of
    /// this path; [`Event::Cut`] says so.
    GoOn {
        /// Its number.
        motion: Motion,
        /// The state.
        from: Arc<Stored>,
    },
    /// Hold or go on.
    Pause {
        /// True to hold.
        paused: bool,
    },
    /// Show sweeps and jumps at this speed from now on.
    SetSpeed {
        /// How fast.
        speed: Speed,
    },
    /// End the thread.
    Quit,
}

/// A picture of the surface, at rest or during a jump.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Frame {
    /// What is driven: u0, the stage's position (length), or the load per area (E*).
    pub control: f64,
    /// Mean displacement u0 (length).
    pub mean_displacement: f64,
    /// Mean stress (E*).
    pub stress: f64,
    /// Gap field (length), shape (ny, nx).
    pub gap: Arc<Array2<f64>>,
    /// Field of the mode that gives way first, mean square 1; `None` while relaxing or not
    /// measured.
    pub soft_mode: Option<Arc<Array2<f64>>>,
    /// True while the surface is jumping: not an equilibrium.
    pub relaxing: bool,
    /// The equilibrium's record; `None` while relaxing.
    pub state: Option<StateRecord>,
}

impl Frame {
    /// Of a state that somebody looks at while the control stays at this value.
    pub fn of_a_branch(control: f64, [u0, stress]: [f64; 2], gap: Arc<Array2<f64>>) -> Self {
        Self {
            control,
            mean_displacement: u0,
            stress,
            gap,
            soft_mode: None,
            relaxing: false,
            state: None,
        }
    }

    /// Of a surface that is no equilibrium: it jumps, or is pressed.
    pub fn moving(control: f64, [u0, stress]: [f64; 2], gap: Arc<Array2<f64>>) -> Self {
        Self {
            relaxing: true,
            ..Self::of_a_branch(control, [u0, stress], gap)
        }
    }

    /// Of an equilibrium with this record.
    pub fn at_rest(state: &StateRecord, gap: Arc<Array2<f64>>) -> Self {
        let at = [state.mean_displacement, state.stress];
        Self {
            state: Some(state.clone()),
            ..Self::of_a_branch(state.control, at, gap)
        }
    }

    /// True of a state that somebody chose on a branch: the walk does not stand on it.
    pub fn is_of_a_branch(&self) -> bool {
        self.state.is_none() && !self.relaxing
    }
}

/// An equilibrium of the path, kept to be shown and to be gone on from.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Stored {
    /// Its record.
    pub record: StateRecord,
    /// How many states and jumps of the path came before it; none of one that was not walked to.
    pub before: [usize; 2],
    /// The part of the cell that was walked.
    pub part: Part,
    /// The surface without its fields, which follow from its amplitudes.
    pub surface: Equilibrium,
    /// Gap field (length), shape (ny, nx).
    pub gap: Array2<f32>,
}

impl Stored {
    /// Where a walk on this part of the cell stands, so many states and jumps `before` it.
    pub fn of(walk: &Walk, part: Part, before: [usize; 2]) -> Self {
        let here = walk.here();
        Self {
            record: walk.record().clone(),
            before,
            part,
            surface: Equilibrium {
                fields: Fields::default(),
                soft_mode: here.soft_mode.clone(),
                state: here.state.clone(),
                ..*here
            },
            gap: walk.gap_here().mapv(|gap| gap as f32),
        }
    }

    /// Its picture.
    pub fn frame(&self) -> Frame {
        Frame::at_rest(&self.record, Arc::new(self.gap.mapv(f64::from)))
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        let doubles = self.surface.state.amplitudes.len() + self.surface.soft_mode.len();
        size_of::<Self>() + size_of::<f64>() * doubles + size_of::<f32>() * self.gap.len()
    }
}

/// A stored state that a new run begins with.
#[derive(Clone, Debug)]
pub struct Resumed {
    /// The state.
    pub state: Arc<Stored>,
    /// The path that led there, as far as it is known.
    pub along: LoopRecord,
}

/// The pictures of one jump, in order.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Film {
    /// The last equilibrium before, with the mode that goes soft.
    pub before: Arc<Frame>,
    /// The surface while it moved, at even intervals; empty where nothing was seen of it.
    pub moving: Vec<Arc<Frame>>,
    /// The equilibrium on which it landed.
    pub after: Arc<Frame>,
}

impl Film {
    /// All its pictures.
    pub fn frames(&self) -> impl Iterator<Item = &Arc<Frame>> {
        let ends = (std::iter::once(&self.before), std::iter::once(&self.after));
        ends.0.chain(&self.moving).chain(ends.1)
    }

    /// How many they are.
    pub fn count(&self) -> usize {
        self.moving.len() + 2
    }

    /// The mode along which the surface gave way, positive where the jump widened the gap: an
    /// eigenvector has no sign of its own.
    pub fn soft_mode(&self) -> Option<Array2<f64>> {
        let mode = self.before.soft_mode.as_ref()?;
        let went = &*self.after.gap - &*self.before.gap;
        let along = (&went * &**mode).sum();
        Some(if along < 0.0 {
            -(&**mode)
        } else {
            (**mode).clone()
        })
    }
}

/// What a scene turned out to be, sent once per run.
#[derive(Clone, Debug)]
pub struct Ready {
    /// The decided model.
    pub model: Model,
    /// Height of the indenter, `None` if flat; shape (ny, nx).
    pub height: Option<Arc<Array2<f64>>>,
    /// The model in use.
    pub choice: ModelChoice,
}

/// The result of a drive from the start to the turn and back.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopSummary {
    /// What it lost, and whether it closes.
    pub ledger: Ledger,
    /// Fourier transforms spent.
    pub transforms: usize,
    /// Wall seconds spent.
    pub seconds: f64,
}

/// The newest live loop.
#[derive(Clone, Debug)]
pub struct LiveState {
    /// The loop, or why there is none.
    pub found: Result<LiveLoop, String>,
    /// On which mesh.
    pub fineness: Fineness,
    /// Wall milliseconds spent.
    pub milliseconds: f64,
}

/// From the solver to the window.
#[derive(Clone, Debug)]
pub enum Event {
    /// The scene is accepted and at rest at its start.
    Ready(Arc<Ready>),
    /// One more equilibrium on the path.
    State(StateRecord),
    /// The same, to be kept; not of a state that was passed within a step.
    Stored(Arc<Stored>),
    /// The newest picture; one that nobody took yet is replaced.
    Frame(Arc<Frame>),
    /// The surface is held pressed.
    Pressed {
        /// Its energy per area less that of the state it stands on (E* times length).
        energy: f64,
    },
    /// A jump was completed.
    Jump(JumpRecord),
    /// How the jump before was seen, once the surface stands on the state after it.
    Film(Arc<Film>),
    /// The path goes back to its first states and jumps, so many of each: what came after them
    /// belongs to an earlier path (a ghost). A fresh loop goes back to none.
    Cut {
        /// States that stay.
        states: usize,
        /// Jumps that stay.
        jumps: usize,
    },
    /// A closed loop is complete.
    Loop(LoopSummary),
    /// Nothing left to do: at the target, stopped, or stuck.
    Rest {
        /// The motion that ended; 0 before the first.
        motion: Motion,
        /// The value of the control where it rests.
        control: f64,
    },
    /// The whole loop of the scene, read off the atlas. While a parameter is dragged it comes late:
    /// newer than the last one shown is good enough.
    Live(Arc<LiveState>),
    /// The model was changed on the way; the state stays.
    Remodelled(ModelChoice),
    /// Something went wrong; the last good state stays.
    Failed(Failure),
}

impl Event {
    /// Something went wrong: what happened, and what to do about it.
    pub fn failed(message: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::Failed(Failure {
            message: message.into(),
            remedy: remedy.into(),
        })
    }
}

/// A solver as the window sees it, with what is computed beside it: a thread, or a session stepped
/// by hand. No call blocks.
pub trait SolverHandle {
    /// Passes a command on.
    fn send(&self, command: Envelope<Command>);

    /// The events since the last call, the newest picture last.
    fn poll(&self) -> Vec<Envelope<Event>>;

    /// What a job calls, from whatever thread, when it has something to say.
    fn wake(&self) -> Wake;

    /// Begins work beside the solver.
    fn begin(&self, work: Box<dyn Work>);
}

impl dyn SolverHandle + '_ {
    /// Begins a job beside the solver.
    pub fn job<I, T>(&self, input: I, compute: Compute<I, T>) -> Job<T>
    where
        I: Send + 'static,
        T: Send + 'static,
    {
        let (job, report) = Job::new(self.wake());
        self.begin(Box::new(Computation {
            input,
            report,
            compute,
        }));
        job
    }
}

/// Most pictures of the moving surface in one film.
const MOVING_MAX: usize = 64;

/// What was seen since the surface last rested.
#[derive(Debug, Default)]
pub struct Recorder {
    before: Option<Arc<Frame>>,
    moving: Vec<Arc<Frame>>,
    /// Pictures since the last one that was kept, and of how many one is kept.
    passed: usize,
    every: usize,
    jumped: bool,
}

impl Recorder {
    /// The surface moves.
    pub fn moves(&mut self, frame: &Arc<Frame>) {
        self.passed += 1;
        if self.passed < self.every {
            return;
        }
        self.passed = 0;
        self.moving.push(frame.clone());
        if self.moving.len() == MOVING_MAX {
            self.moving = std::mem::take(&mut self.moving)
                .into_iter()
                .step_by(2)
                .collect();
            // The newest has gone too.
            self.passed = self.every.max(1);
            self.every = 2 * self.passed;
        }
    }

    /// The motion is a jump; where it landed follows.
    pub fn jumps(&mut self) {
        self.jumped = true;
    }

    /// The surface rests; the film of the jump that led here, if one did.
    pub fn rests(&mut self, frame: &Arc<Frame>) -> Option<Film> {
        let ended = std::mem::replace(
            self,
            Self {
                before: Some(frame.clone()),
                ..Self::default()
            },
        );
        let before = ended.before.filter(|_| ended.jumped)?;
        Some(Film {
            before,
            moving: ended.moving,
            after: frame.clone(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    fn frame(u0: f64, gap: f64, mode: Option<f64>) -> Arc<Frame> {
        let field = |value: f64| Arc::new(Array2::from_elem((1, 4), value));
        Arc::new(Frame {
            soft_mode: mode.map(field),
            ..Frame::of_a_branch(u0, [u0, 0.0], field(gap))
        })
    }

    #[test]
    fn a_film_has_both_ends_and_an_even_choice_of_what_is_between() {
        let mut recorder = Recorder::default();
        assert!(recorder.rests(&frame(3.0, 3.0, Some(1.0))).is_none());
        let seen = 5 * MOVING_MAX;
        for i in 0..seen {
            recorder.moves(&frame(3.0, i as f64, None));
        }
        recorder.jumps();
        let film = recorder.rests(&frame(3.0, -1.0, None)).expect("it jumped");
        assert_eq!(film.count(), film.frames().count());
        let kept: Vec<f64> = film.moving.iter().map(|f| f.gap[(0, 0)]).collect();
        assert!(
            kept.len() < MOVING_MAX && kept.len() >= MOVING_MAX / 4,
            "{kept:?}"
        );
        let step = kept[1] - kept[0];
        assert!(kept.windows(2).all(|w| w[1] - w[0] == step), "{kept:?}");
        assert!(seen as f64 - kept[kept.len() - 1] <= 2.0 * step, "{kept:?}");
    }

    #[test]
    fn a_motion_that_was_no_jump_leaves_no_film() {
        let mut recorder = Recorder::default();
        recorder.rests(&frame(3.0, 3.0, None));
        recorder.moves(&frame(3.0, 2.0, None));
        assert!(recorder.rests(&frame(3.0, 2.9, None)).is_none());
        recorder.jumps();
        let film = recorder.rests(&frame(3.0, 1.0, None)).expect("it jumped");
        assert_eq!((film.moving.len(), film.before.gap[(0, 0)]), (0, 2.9));
    }

    #[test]
    fn the_soft_mode_points_the_way_the_surface_went() {
        let [before, after] = [frame(3.0, 3.0, Some(1.0)), frame(3.0, 1.0, None)];
        let film = Film {
            before,
            moving: Vec::new(),
            after,
        };
        assert_eq!(film.soft_mode().expect("a mode")[(0, 0)], -1.0);
    }
}
