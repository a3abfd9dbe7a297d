//! Which time steps GFMD survives along the approach: measured, beside the bound that predicts it.
//!
//! At each of a row of equilibria a tiny perturbation is let go, without drive, damping and
//! thermostat, for each of a list of time steps. The explicit scheme keeps it bounded or blows it
//! up. Damping lowers the limit slightly (by a share of a quarter of the damping per time step);
//! the bound of [`time_step_limit`] leaves it out too.

use crate::follow::walk::{Progress as Walked, Walk};
use crate::numerics::dense::{add, norm, project_out, scale};
use crate::numerics::threads::Cancel;
use crate::physics::parameter::Refusal;
use crate::scene::{Model, Scene};
use crate::solver::gfmd::{Gfmd, GfmdBudget, time_step_limit};
use crate::solver::mechanics::{Mechanics, Slides};
use crate::solver::method::{Equilibrium, History, Lost, Method};
use crate::solver::methods::MethodKind;
use crate::solver::stability::random_amplitudes;
use rand::SeedableRng;
use rand_pcg::Pcg64;

/// States along the approach.
const COLUMNS: usize = 28;
/// Time steps tried at each, and the first and the last of them; even on a logarithmic scale.
const ROWS: usize = 20;
const TIME_STEPS: (f64, f64) = (0.15, 2.6);
/// Time steps run in one piece of work, and in all.
const SLICE: usize = 20;
// Long enough to tell a limit to a fraction of a per cent, and too short for a pattern that slides
// off slowly to look unstable.
const RUN: usize = 100;
/// Root mean square of the perturbation, in ranges, and the growth that counts as unstable.
/// Together they stay in the linear regime.
const PERTURBATION: f64 = 1e-4;
const GROWTH: f64 = 30.0;

/// What was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeStepMap {
    /// Mean displacements of the columns (length), descending; as many as were reached.
    pub displacements: Vec<f64>,
    /// Time steps of the rows, ascending, in units of the inverse frequency of a free wave.
    pub time_steps: Vec<f64>,
    /// Column by column: true where the perturbation stayed bounded. The last column may be
    /// unfinished.
    pub stable: Vec<bool>,
    /// The bound at each column.
    pub bounds: Vec<f64>,
    /// Columns in all.
    pub columns: usize,
}

impl TimeStepMap {
    /// Whether `row` was stable in `column`, if measured.
    pub fn at(&self, column: usize, row: usize) -> Option<bool> {
        self.stable
            .get(column * self.time_steps.len() + row)
            .copied()
    }

    /// Share that is done, 0 to 1.
    pub fn fraction(&self) -> f64 {
        self.stable.len() as f64 / (self.columns * self.time_steps.len()) as f64
    }
}

/// How a piece of work ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Progress {
    /// There is more.
    Working,
    /// The map is complete.
    Done,
    /// Interrupted by the cancel token.
    Cancelled,
    /// The approach could not be followed further; what was measured stands.
    Stuck(String),
}

/// The measurement, stepped by hand.
pub struct Survey {
    map: TimeStepMap,
    targets: Vec<f64>,
    walk: Walk,
    model: Model,
    /// Of the dynamics, beside that of the walk.
    mechanics: Mechanics,
    rng: Pcg64,
    run: Option<Run>,
}

/// One perturbation under way.
struct Run {
    gfmd: Gfmd,
    state: Equilibrium,
    size: f64,
    steps: usize,
}

impl Survey {
    /// A measurement along the approach from the start of the scene's drive down to `turn`
    /// (length).
    ///
    /// # Errors
    /// The first value of the scene that is not allowed.
    pub fn new(scene: &Scene, turn: f64) -> Result<Self, Refusal> {
        let walk = Walk::start(scene, MethodKind::NewtonKrylov.into(), &Cancel::default())?;
        let (from, down) = (scene.drive.start, scene.drive.start - turn);
        let mut mechanics = walk.mechanics().clone();
        // A pattern that slides, driven by what its residual left, is no oscillation that grows.
        mechanics.slides = Slides::Freely;
        let ratio = (TIME_STEPS.1 / TIME_STEPS.0).powf(1.0 / (ROWS - 1) as f64);
        Ok(Self {
            targets: (0..COLUMNS)
                .map(|i| from - down * (i as f64 + 0.5) / COLUMNS as f64)
                .collect(),
            map: TimeStepMap {
                displacements: Vec::new(),
                time_steps: (0..ROWS)
                    .map(|i| TIME_STEPS.0 * ratio.powi(i as i32))
                    .collect(),
                stable: Vec::new(),
                bounds: Vec::new(),
                columns: COLUMNS,
            },
            mechanics,
            model: walk.model().clone(),
            rng: Pcg64::seed_from_u64(scene.seed),
            walk,
            run: None,
        })
    }

    /// What is measured so far.
    pub fn map(&self) -> &TimeStepMap {
        &self.map
    }

    /// Does one bounded piece of work: an increment of the walk, or a few time steps.
    pub fn step(&mut self, cancel: &Cancel) -> Progress {
        if let Some(run) = self.run.take() {
            return self.go_on(run, cancel);
        }
        let column = self.map.stable.len() / ROWS;
        if column == COLUMNS {
            return Progress::Done;
        }
        if column < self.map.bounds.len() {
            self.run = Some(self.perturbed(self.map.time_steps[self.map.stable.len() % ROWS]));
            return Progress::Working;
        }
        self.walk.set_target(self.targets[column]);
        match self.walk.step(cancel, &mut |_| {}) {
            Walked::Working => {}
            Walked::Resting => self.begin_column(),
            Walked::Cancelled => return Progress::Cancelled,
            Walked::Stuck(reason) => return Progress::Stuck(reason.to_string()),
        }
        Progress::Working
    }

    fn begin_column(&mut self) {
        let (system, here) = (self.walk.system(), self.walk.here());
        let stiffest = here
            .fields
            .stiffness
            .iter()
            .fold(f64::NEG_INFINITY, |most, k| most.max(*k));
        // The first wave's entry of the inverse inertia 1/(q E*/2 + k) tells k.
        let first = 2 * system.grid().ny;
        let k = 1.0 / self.mechanics.preconditioner.diagonal()[first] - system.elastic()[first];
        // Where nothing is stiffer than k, not the longest wave sets the limit but the shortest.
        let shortest = system.elastic().iter().fold(0.0f64, |most, e| most.max(*e));
        let limit = 2.0 / ((stiffest + shortest) / (k + shortest)).sqrt();
        self.map
            .bounds
            .push(limit.min(time_step_limit(system, stiffest, k)));
        self.map.displacements.push(here.state.mean_displacement);
    }

    fn perturbed(&mut self, time_step: f64) -> Run {
        let system = self.walk.system();
        let size = PERTURBATION * self.model.law.range;
        let mut kick = random_amplitudes(system, &mut self.rng);
        let length = norm(&kick);
        scale(&mut kick, size / length);
        let mut state = self.walk.here().clone();
        add(&mut state.state.amplitudes, 1.0, &kick);
        let budget = GfmdBudget {
            ramp: 0,
            relax: SLICE,
            time_step,
            damping: 0.0,
            temperature: 0.0,
        };
        Run {
            gfmd: Gfmd::with_budget(budget, 0),
            state,
            size,
            steps: 0,
        }
    }

    fn go_on(&mut self, mut run: Run, cancel: &Cancel) -> Progress {
        let u0 = run.state.state.mean_displacement;
        self.mechanics.cancel = cancel.clone();
        let grown = match run
            .gfmd
            .follow(&mut self.mechanics, &History::default(), &run.state, u0)
        {
            Ok(state) => {
                run.state = state;
                let (mut away, here) = (run.state.state.amplitudes.clone(), self.walk.here());
                add(&mut away, -1.0, &here.state.amplitudes);
                project_out(
                    &mut away,
                    &self
                        .mechanics
                        .sliding_basis(&here.state.amplitudes, &here.fields),
                );
                norm(&away) > GROWTH * run.size
            }
            Err(Lost::Cancelled) => return Progress::Cancelled,
            Err(Lost::Gone | Lost::Unstable | Lost::Diverged(_)) => true,
        };
        run.steps += SLICE;
        if grown || run.steps >= RUN {
            self.map.stable.push(!grown);
        } else {
            self.run = Some(run);
        }
        Progress::Working
    }
}
