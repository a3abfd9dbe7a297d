//! A loop read off an atlas, in the form of a walk's.

use crate::follow::atlas::{Atlas, Leg, Meshes, Place, Unmapped};
use crate::follow::record::StateRecord;
use crate::follow::run::{LoopRun, Outcome};
use crate::follow::walk::Stuck;
use crate::physics::pattern::Pattern;
use crate::scene::part::Part;
use crate::scene::{Model, Scene, Turn};
use crate::solver::Stop;

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
