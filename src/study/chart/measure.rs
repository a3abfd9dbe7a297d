//! One loop, with what it took.

use super::{Point, atlas};
use crate::follow::ledger::Ledger;
use crate::follow::record::LoopRecord;
use crate::follow::run::{LoopRun, Outcome, Report, run_loop};
use crate::follow::walk::Counts;
use crate::follow::walk::WalkOptions;
use crate::numerics::cancel::Cancel;
use crate::physics::law::Law;
use crate::physics::parameter::Refusal;
use crate::scene::part::Strategy;
use crate::scene::{Points, Scene};
use cpu_time::ProcessTime;
use std::time::Instant;

/// A loop as a point of the chart computed it.
#[derive(Clone, Debug)]
pub struct Measured {
    /// The point.
    pub point: Point,
    /// The law.
    pub law: Law,
    /// mu_rho on the point's mesh.
    pub mu_rho: f64,
    /// States and jumps.
    pub record: LoopRecord,
    /// How it ended.
    pub outcome: Outcome,
    /// True if it took more than it was allowed.
    pub out_of_time: bool,
    /// What was counted.
    pub counts: Counts,
    /// Time on the wall.
    pub seconds: f64,
    /// Time of the processor.
    pub processor_seconds: f64,
}

impl Measured {
    /// True if the drive went all the way.
    pub fn is_complete(&self) -> bool {
        self.outcome == Outcome::Completed
    }

    /// The loss over gamma; NaN unless the loop is closed.
    pub fn dissipated_energy(&self) -> f64 {
        self.ledger()
            .and_then(|ledger| ledger.dissipated_energy())
            .unwrap_or(f64::NAN)
    }

    /// The ledger, if the drive was completed.
    pub fn ledger(&self) -> Option<Ledger> {
        self.is_complete()
            .then(|| self.record.ledger(self.law.surface_energy))
    }

    /// Loop integral of stress du0 over gamma.
    pub fn integral(&self) -> f64 {
        self.record.work() / self.law.surface_energy
    }
}

/// Computes the loop of `scene` (its range given as a length) as `point` says, stopping after
/// `allowed` processor seconds.
///
/// # Errors
/// The first value of the scene that is not allowed.
pub fn measure(
    scene: &Scene,
    point: &Point,
    allowed: f64,
    cancel: &Cancel,
    progress: &mut dyn FnMut(f64),
) -> Result<Measured, Refusal> {
    let mut scene = scene.clone();
    scene.drive.step = point.step;
    scene.cell.points = if point.line {
        Points::Line(point.points)
    } else {
        Points::Square(point.points)
    };
    let model = scene.model()?;
    let part = cancel.part();
    let (wall, processor) = (Instant::now(), ProcessTime::now());
    let mut out_of_time = false;
    let options = |part| WalkOptions {
        method: point.method,
        part,
        precision: point.precision,
        trapped_within: None,
    };
    let LoopRun {
        record,
        outcome,
        counts,
        ..
    } = match point.model {
        Strategy::Atlas => atlas::read_off(&scene, &model),
        Strategy::Walk(walked) => run_loop(&scene, options(walked), &part, &mut |report| {
            if processor.elapsed().as_secs_f64() > allowed {
                out_of_time = true;
                part.request();
            }
            if let Report::State { fraction, .. } = report {
                progress(fraction);
            }
        })?,
    };
    Ok(Measured {
        point: *point,
        law: model.law,
        mu_rho: model.mu_rho,
        record,
        outcome,
        out_of_time,
        counts,
        seconds: wall.elapsed().as_secs_f64(),
        processor_seconds: processor.elapsed().as_secs_f64(),
    })
}
