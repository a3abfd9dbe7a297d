//! The error bar of a finished loop: how far its loss and its jumps are from those of a finer mesh.
//!
//! What a mesh is worth is known beforehand only as a bound ([`crate::scene::mesh::mesh_error`]):
//! the errors of two scenes on equally fine meshes differ by a factor of ten. Afterwards a second,
//! finer mesh tells. The error falls exponentially with the number of points, so that of the finer
//! mesh hardly counts beside that of the loop.

use crate::follow::atlas::Atlas;
use crate::follow::ledger::LOSS_MIN;
use crate::follow::record::JumpRecord;
use crate::follow::run::{LoopRun, Outcome, run_loop};
use crate::follow::walk::WalkOptions;
use crate::numerics::cancel::Cancel;
use crate::physics::indenter::Indenter;
use crate::scene::mesh::{flat_error, next_fast};
use crate::scene::part::Part;
use crate::scene::{Model, Range, Scene};

/// The measured difference is stated this many times larger: what a mesh of 4/3 times the points
/// itself is off by, a tenth to a fifth where the error falls by e^2.6 for each unit of 1/mu_rho^2,
/// and as much again.
const SAFETY: f64 = 1.4;
/// Added to it, relative: how well two loops locate the same ends.
const FLOOR: f64 = 4e-6;
/// The share of a bracket within which the end of a branch is found by the eigenvalues at both its
/// sides.
const WITHIN: f64 = 0.2;

/// The relative error of loss and jumps of a loop that was completed on flat ground; `None` where a
/// finer mesh cannot tell, or not in time. Where its jumps are not the same ones nothing can be
/// promised: 1.
pub fn error_bar(scene: &Scene, model: &Model, run: &LoopRun, cancel: &Cancel) -> Option<f64> {
    let promised = flat_error(&model.body, &model.law, model.grid.length, model.mu_rho) < 1.0;
    let ledger = run
        .ledger(model.law.surface_energy)
        .filter(|ledger| !ledger.viscous)?;
    let loss = ledger.dissipated_energy()?;
    if model.indenter != Indenter::Flat || !promised {
        return None;
    }
    // Where it is contested which of two loops it is, both meshes have both.
    let error = finer_loops(scene, model, cancel)?
        .iter()
        .map(|jumps| measured_error(&run.record.jumps, jumps))
        .fold(1.0, f64::min);
    let located = if loss > LOSS_MIN {
        WITHIN * ledger.released_energy_error / loss
    } else {
        0.0
    };
    (!cancel.requested()).then_some(if error < 1.0 {
        SAFETY * error + located + FLOOR
    } else {
        1.0
    })
}

/// The jumps of the loop on the next finer mesh: read off an atlas, or walked where there is none.
fn finer_loops(scene: &Scene, model: &Model, cancel: &Cancel) -> Option<Vec<Vec<JumpRecord>>> {
    let finer = reference(scene, model);
    if let Some(loops) = read_off(&finer, cancel) {
        return Some(loops);
    }
    let quarter = WalkOptions {
        part: Part::Quarter,
        ..WalkOptions::default()
    };
    let run = run_loop(&finer, quarter, cancel, &mut |_| {}).ok()?;
    (run.outcome == Outcome::Completed).then_some(vec![run.record.jumps])
}

/// The jumps of a loop on flat ground as an atlas on the scene's mesh has them, and those of other
/// landings; `None` if it has none.
pub fn read_off(scene: &Scene, cancel: &Cancel) -> Option<Vec<Vec<JumpRecord>>> {
    let model = scene.model().ok()?;
    let turn = scene.turn_of_atlas()?;
    if model.grid.is_line() {
        return None;
    }
    let mut atlas = Atlas::of(scene, &model);
    atlas.obey(cancel);
    let usual = atlas.cycle(scene.drive.start, turn).ok()?.jumps;
    let contested = atlas
        .contested_cycles(scene.drive.start, turn)
        .into_iter()
        .filter_map(|(_, cycle)| Some(cycle.ok()?.jumps));
    Some(std::iter::once(usual).chain(contested).collect())
}

/// The scene that judges a loop of `scene`: the same law on the next finer mesh.
pub fn reference(scene: &Scene, model: &Model) -> Scene {
    let n = next_fast(model.grid.nx + model.grid.nx / 3);
    let mut finer = scene.clone();
    finer.cell.points = scene.cell.points.resized(n);
    finer.law.range = Range::Length(model.law.range);
    finer
}

/// The larger of the relative errors of the released energy and of the jumps' u0, of a loop with
/// these `jumps` against the better `reference`; 1 where the jumps are not the same ones. Zero if
/// neither has any. Jumps that release less than a thousandth of the whole are the mesh's.
pub fn measured_error(jumps: &[JumpRecord], reference: &[JumpRecord]) -> f64 {
    let loss = |jumps: &[JumpRecord]| jumps.iter().map(|jump| jump.released_energy).sum::<f64>();
    let least = 1e-3 * loss(reference);
    let [mine, right]: [Vec<_>; 2] = [jumps, reference].map(|jumps| {
        jumps
            .iter()
            .filter(|jump| jump.released_energy > least)
            .collect()
    });
    // Not by the names of the patterns: on which side of a growing dimple's change into a bulge a
    // jump lies may depend on the mesh.
    if !mine
        .iter()
        .map(|jump| jump.direction)
        .eq(right.iter().map(|jump| jump.direction))
    {
        return 1.0;
    }
    let share = |value: f64, right: f64| {
        if right == 0.0 {
            value.abs()
        } else {
            ((value - right) / right).abs()
        }
    };
    let each = mine
        .iter()
        .zip(&right)
        .map(|(a, b)| share(a.mean_displacement, b.mean_displacement));
    each.fold(share(loss(jumps), loss(reference)), f64::max)
}
