//! One loop, with what it took: walked, or read off an atlas in the form of a walk's.

use super::Point;
use crate::follow::atlas::{Atlas, Leg, Meshes, Place, Unmapped};
use crate::follow::ledger::Ledger;
use crate::follow::record::{LoopRecord, StateRecord};
use crate::follow::run::{LoopRun, Outcome, Report, run_loop};
use crate::follow::walk::{Counts, Stuck, WalkOptions};
use crate::numerics::cancel::Cancel;
use crate::physics::law::Law;
use crate::physics::parameter::Refusal;
use crate::physics::pattern::Pattern;
use crate::scene::part::{Part, Strategy};
use crate::scene::{Model, Points, Scene, Turn};
use crate::solver::Stop;
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
        Strategy::Atlas => read_off(&scene, &model),
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

/// The loop of a scene on flat ground. Where the atlas has no answer the loop has not converged,
/// and says why.
pub(super) fn read_off(scene: &Scene, model: &Model) -> LoopRun {
    // As the live loop does.
    let meshes = Meshes::new(&model.law, model.grid.length, model.grid.nx);
    let mut atlas = Atlas::new(meshes);
    let start = scene.drive.start;
    let cycle = match scene.drive.turn {
        Turn::At(turn) => atlas.cycle(start, turn),
        Turn::ZeroLoad => Err(Unmapped::anywhere("a tip has no atlas")),
    };
    let mut run = LoopRun::empty();
    match cycle {
        Ok(cycle) => {
            run.record.states = cycle
                .legs
                .iter()
                .flat_map(|leg| states(&atlas, leg, start, scene.drive.step, model))
                .collect();
            run.record.jumps = cycle.jumps;
        }
        Err(reason) => {
            run.outcome = Outcome::NotConverged {
                mean_displacement: start,
                reason: Stuck::Unmapped(reason),
            }
        }
    }
    run.counts.transforms = atlas.transforms().iter().sum();
    run.counts.patterned_increments = run
        .record
        .states
        .iter()
        .filter(|s| s.pattern != Pattern::Flat)
        .count();
    run
}

/// States along a leg: its ends, and the points start - k x step between them.
fn states(atlas: &Atlas, leg: &Leg, start: f64, step: f64, model: &Model) -> Vec<StateRecord> {
    let (low, high) = (leg.from.min(leg.to), leg.from.max(leg.to));
    let (first, last) = (
        ((start - high) / step).floor() as i64,
        ((start - low) / step).ceil() as i64,
    );
    let mut places: Vec<f64> = (first..=last)
        .map(|k| start - k as f64 * step)
        .filter(|u| *u > low && *u < high)
        .collect();
    places.extend([leg.from, leg.to]);
    places.sort_by(|a, b| {
        if leg.from < leg.to {
            a.total_cmp(b)
        } else {
            b.total_cmp(a)
        }
    });
    places
        .iter()
        .map(|&u0| state(atlas, leg, u0, model))
        .collect()
}

fn state(atlas: &Atlas, leg: &Leg, u0: f64, model: &Model) -> StateRecord {
    let at = atlas.at(leg.place, u0);
    let (pattern, part) = match leg.place {
        Place::Flat => (Pattern::Flat, Part::Flat),
        Place::On(i) => {
            let branch = &atlas.branches()[i];
            (
                branch.pattern,
                if branch.is_ridge {
                    Part::Ridge
                } else {
                    Part::Quarter
                },
            )
        }
    };
    StateRecord {
        direction: leg.direction,
        stress: at.stress,
        stress_over_max: at.stress / model.law.traction_max(),
        energy: at.energy,
        pattern,
        part,
        stop: Stop::ReadOff,
        ..StateRecord::placeholder(u0)
    }
}
