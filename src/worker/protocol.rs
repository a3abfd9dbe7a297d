//! What the window says to the solver, and what it hears back.

use crate::experiment::chart::{Effort, Judged};
use crate::experiment::ledger::Ledger;
use crate::experiment::live_loop::{Fineness, LiveLoop};
use crate::experiment::part::{Part, Road};
use crate::experiment::plan::Plan;
use crate::experiment::record::{JumpRecord, StateRecord};
use crate::experiment::scene::{Model, Scene};
use crate::experiment::time_step_map::TimeStepMap;
use crate::experiment::walk::EnergyWell;
use crate::paper::Figure;
use crate::paper::errata::Erratum;
use crate::paper::overlay::ZeroRange;
use crate::solver::methods::MethodKind;
use ndarray::Array2;
use std::sync::Arc;
use std::time::Duration;

/// Identifies one run of one scene; events of an older run are stale and dropped by the receiver.
pub type RunId = u64;

/// Number of a motion within its run, counted by the sender from 1. A rest names the motion it ends, so that the end of an older one
/// is not taken for the end of the newest.
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

/// A measurement that takes its time, done beside the walk by a thread of its own.
#[derive(Clone, Debug)]
pub enum Errand {
    /// Which time steps GFMD survives along the approach.
    TimeSteps {
        /// The scene.
        scene: Arc<Scene>,
        /// Where the approach ends (length).
        turn: f64,
    },
    /// Speed against accuracy of every method.
    Chart {
        /// The scene.
        scene: Arc<Scene>,
        /// How much trouble to take.
        effort: Effort,
    },
}

/// A page of the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Page {
    /// The figure of this number.
    Figure(usize),
    /// What the print got wrong.
    Errata,
    /// Theory to lay over the live loop.
    Theory,
}

/// News of a page.
#[derive(Clone, Debug)]
pub enum PaperNews {
    /// It is being computed.
    Progress {
        /// Share that is done, 0 to 1.
        done: f64,
        /// What is being done.
        what: String,
    },
    /// A figure is there.
    Figure(Arc<Figure>),
    /// The errata are there.
    Errata(Arc<Vec<Erratum>>),
    /// The theory is there.
    Theory(Arc<ZeroRange>),
    /// It could not be computed.
    Stuck(String),
}

/// A chart of speed against accuracy as far as it is measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ChartSoFar {
    /// What was measured, in that order.
    pub rows: Vec<Judged>,
    /// How many points were left out because they would take too long.
    pub skipped: usize,
    /// What is being measured now, in words.
    pub now: String,
    /// Share of the work that is done, 0 to 1.
    pub fraction: f64,
    /// The reference's own error of the dissipated energy, once everything is measured.
    pub floor: Option<f64>,
}

/// From the window to the solver.
#[derive(Clone, Debug)]
pub enum Command {
    /// Forget everything and rest at the start of this scene.
    SetScene {
        /// Id that every event of this run will carry.
        run: RunId,
        /// The scene.
        scene: Arc<Scene>,
        /// The method.
        method: MethodKind,
        /// Whether the plan decides on the model.
        asked: Option<Road>,
    },
    /// Walk towards this mean displacement (latest wins; the path already gone is kept).
    SetTarget {
        /// The run it is meant for.
        run: RunId,
        /// Its number.
        motion: Motion,
        /// u0 (length).
        mean_displacement: f64,
    },
    /// Walk by itself.
    Sweep {
        /// The run it is meant for.
        run: RunId,
        /// Its number.
        motion: Motion,
        /// Which way.
        sweep: Sweep,
    },
    /// Hold or go on.
    Pause {
        /// True to hold.
        paused: bool,
    },
    /// Drop the present target and sweep; answers within 50 ms with [`Event::Rest`].
    Stop {
        /// The run it is meant for.
        run: RunId,
        /// Its number.
        motion: Motion,
    },
    /// Show sweeps and jumps at this speed from now on.
    SetSpeed {
        /// How fast.
        speed: Speed,
    },
    /// Say (or stop saying) what the energy well of each state looks like.
    Watch {
        /// True while somebody looks at it.
        energy_well: bool,
    },
    /// Measure something beside the walk; replaces a measurement under way.
    Measure {
        /// The run it is meant for.
        run: RunId,
        /// What.
        errand: Errand,
    },
    /// Drop the measurement under way; what was measured stands.
    StopMeasuring,
    /// Compute a page of the paper beside everything else; replaces one under way.
    OpenPage {
        /// Which.
        page: Page,
    },
    /// Drop the page under way.
    ClosePage,
    /// End the thread.
    Quit,
}

/// A picture of the surface, at rest or during a jump.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Mean displacement u0 (length).
    pub mean_displacement: f64,
    /// Mean stress (E*).
    pub stress: f64,
    /// Gap field (length), shape (ny, nx).
    pub gap: Arc<Array2<f64>>,
    /// Field of the mode that gives way first, mean square 1; `None` while relaxing or not measured.
    pub soft_mode: Option<Arc<Array2<f64>>>,
    /// True while the surface is jumping: not an equilibrium.
    pub relaxing: bool,
    /// The equilibrium's record; `None` while relaxing.
    pub state: Option<StateRecord>,
}

/// What a scene turned out to be, sent once per run.
#[derive(Clone, Debug)]
pub struct Ready {
    /// The decided model.
    pub model: Model,
    /// Height of the indenter, `None` if flat; shape (ny, nx).
    pub height: Option<Arc<Array2<f64>>>,
    /// Lower and upper limit of stability of the flat state (length); `None` if always stable or not on flat ground.
    pub flat_limits: Option<(f64, f64)>,
    /// The model in use.
    pub choice: ModelChoice,
}

/// Which model runs, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelChoice {
    /// What the plan says of the scene.
    pub plan: Plan,
    /// The part of the cell that the walk represents.
    pub part: Part,
    /// Why the walk runs on the whole cell where the plan or the user would have had a part.
    pub because: Option<String>,
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
#[derive(Clone, Debug, PartialEq)]
pub struct LiveState {
    /// The loop, or why the atlas does not hold the scene.
    pub found: Result<LiveLoop, String>,
    /// On which mesh.
    pub fineness: Fineness,
    /// Wall milliseconds spent.
    pub milliseconds: f64,
}

/// From the solver to the window. Every variant but `Paper` belongs to a run.
#[derive(Clone, Debug)]
pub enum Event {
    /// The scene is accepted and at rest at its start.
    Ready {
        /// Run.
        run: RunId,
        /// Facts of the scene.
        ready: Arc<Ready>,
    },
    /// One more equilibrium on the path.
    State {
        /// Run.
        run: RunId,
        /// Its record.
        state: StateRecord,
    },
    /// A jump was completed.
    Jump {
        /// Run.
        run: RunId,
        /// Its record.
        jump: JumpRecord,
    },
    /// A fresh loop starts here: earlier states belong to an earlier loop (a ghost).
    LoopStarted {
        /// Run.
        run: RunId,
    },
    /// A closed loop is complete.
    Loop {
        /// Run.
        run: RunId,
        /// Its numbers.
        summary: LoopSummary,
    },
    /// Nothing left to do: at the target, stopped, or stuck.
    Rest {
        /// Run.
        run: RunId,
        /// The motion that ended; 0 before the first.
        motion: Motion,
        /// u0 where it rests.
        mean_displacement: f64,
    },
    /// The energy around a state along its soft mode.
    Well {
        /// Run.
        run: RunId,
        /// The well.
        well: Arc<EnergyWell>,
    },
    /// The whole loop of the scene, read off the atlas. While a parameter is dragged it comes late: newer than the last one shown is
    /// good enough.
    Live {
        /// Run.
        run: RunId,
        /// The loop.
        live: Arc<LiveState>,
    },
    /// More of the time-step map.
    TimeSteps {
        /// Run.
        run: RunId,
        /// What is measured so far.
        map: Arc<TimeStepMap>,
    },
    /// More of the chart.
    Chart {
        /// Run.
        run: RunId,
        /// What is measured so far.
        chart: Arc<ChartSoFar>,
    },
    /// The measurement is over: done, dropped, or stuck for the reason given.
    Measured {
        /// Run.
        run: RunId,
        /// Why it could not be finished.
        stuck: Option<String>,
    },
    /// The model was changed on the way; the state stays.
    Remodelled {
        /// Run.
        run: RunId,
        /// What runs now, and why.
        choice: ModelChoice,
    },
    /// News of a page of the paper, which belongs to no run.
    Paper {
        /// Which.
        page: Page,
        /// What.
        news: PaperNews,
    },
    /// Something went wrong; the last good state stays.
    Failed {
        /// Run.
        run: RunId,
        /// What happened.
        message: String,
        /// What to do about it.
        remedy: String,
    },
}

/// What a session hands out.
pub enum Output {
    /// For the series.
    Event(Event),
    /// For the mailbox.
    Frame(RunId, Frame),
}
