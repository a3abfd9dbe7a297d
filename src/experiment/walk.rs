//! STUB on branch io: the flat state's closed form along the drive. The core replaces this file.

use super::record::{Branch, JumpRecord, LoopRecord, StateRecord};
use super::scene::{Scene, SceneError, Turn};
use crate::numerics::cancel::Cancel;
use crate::physics::pattern::Pattern;
use crate::physics::theory::flat;
use crate::solver::Stop;
use ndarray::Array2;

/// Which relaxation method follows the branches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MethodKind {
    /// Newton-Krylov.
    NewtonKrylov,
    /// The paper's mass-weighted GFMD.
    Gfmd,
}

/// A walk and what it cost.
#[derive(Clone, Debug)]
pub struct LoopRun {
    /// States and jumps.
    pub record: LoopRecord,
    /// How it ended.
    pub outcome: Outcome,
    /// What it cost.
    pub counts: Counts,
    /// Where each jump landed.
    pub landings: Vec<Landing>,
}

/// How a walk ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// The loop is closed.
    Completed,
    /// A state could not be found.
    NotConverged {
        /// Where.
        mean_displacement: f64,
        /// Why.
        reason: String,
    },
    /// Somebody asked to stop.
    Cancelled,
}

/// What a walk cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Fourier transforms.
    pub transforms: usize,
    /// Iterations.
    pub iterations: usize,
    /// Increments with a pattern.
    pub patterned_increments: usize,
}

/// The surface after a jump.
#[derive(Clone, Debug)]
pub struct Landing {
    /// Direction of the drive.
    pub branch: Branch,
    /// u0.
    pub mean_displacement: f64,
    /// Pattern.
    pub pattern: Pattern,
    /// Gap field.
    pub gap: Array2<f64>,
}

/// News from a walk.
pub enum Progress<'a> {
    /// One more state.
    State {
        /// Its record.
        record: &'a StateRecord,
        /// Share of the drive done, 0 to 1.
        fraction: f64,
    },
    /// One more jump.
    Jump(&'a JumpRecord),
}

/// Walks the loop of `scene`.
///
/// # Errors
/// A value of the scene that is not allowed.
pub fn run_loop(
    scene: &Scene,
    _method: MethodKind,
    cancel: &Cancel,
    observe: &mut dyn FnMut(Progress<'_>),
) -> Result<LoopRun, SceneError> {
    let model = scene.model()?;
    let turn = if let Turn::At(turn) = scene.drive.turn { turn } else { 0.0 };
    let increments = ((scene.drive.start - turn) / scene.drive.step).round().max(1.0) as usize;
    let mut record = LoopRecord::default();
    let mut outcome = Outcome::Completed;
    for i in 0..=2 * increments {
        if cancel.requested() {
            outcome = Outcome::Cancelled;
            break;
        }
        let down = if i <= increments { i } else { 2 * increments - i };
        let u0 = scene.drive.start + (turn - scene.drive.start) * down as f64 / increments as f64;
        let response = model.law.at(u0);
        let stiffness_min = flat::stiffness_min(&model.law, model.grid.length, u0);
        record.states.push(StateRecord {
            branch: if i <= increments { Branch::Approach } else { Branch::Retraction },
            mean_displacement: u0,
            stress: response.traction,
            stress_over_max: response.traction / model.law.traction_max(),
            contact_area: f64::from(u8::from(u0 < model.law.contact_gap())),
            pattern: Pattern::Flat,
            residual: 0.0,
            stiffness_min,
            stiffness_error: 0.0,
            energy: response.energy,
            model: "flat, closed form",
            stop: if stiffness_min >= 0.0 { Stop::Stable } else { Stop::Unstable },
            iterations: 0,
            transforms: 0,
            milliseconds: 0.0,
        });
        std::thread::sleep(std::time::Duration::from_nanos(model.grid.points() as u64));
        observe(Progress::State { record: &record.states[i], fraction: i as f64 / (2 * increments) as f64 });
    }
    Ok(LoopRun { record, outcome, counts: Counts::default(), landings: Vec::new() })
}
