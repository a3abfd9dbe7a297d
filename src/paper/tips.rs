//! The loops of the Hertzian tip behind Figs 12 and 13.

use super::scenes;
use super::task::{Stopped, Task};
use crate::experiment::plan::Reduction;
use crate::experiment::record::Branch;
use crate::experiment::run::{LoopRun, Outcome, Report, run_walk};
use crate::experiment::scene::SceneError;
use crate::experiment::walk::Walk;
use crate::physics::theory::jkr::Jkr;
use crate::physics::theory::jkr_periodic::PeriodicJkr;
use crate::solver::method::MethodKind;

/// The tip of Sect. 4, R = 1.
pub(super) const TIP: Jkr = Jkr { radius: 1.0, surface_energy: scenes::TIP_SURFACE_ENERGY };

/// The same in its cell, L = R.
pub(super) fn periodic() -> PeriodicJkr {
    PeriodicJkr::new(TIP, 1.0)
}

/// Which surface is solved, by mu_rho and mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// The even quarter, with all other modes watched: as good as the whole cell. The apex lies between points.
    Quarter,
    /// The even quarter, held mirror-symmetric. The apex lies between points.
    Mirrored,
    /// The whole cell. The apex lies on a point.
    Whole,
}

impl Way {
    /// Up to 0.7 nothing but the two collective jumps breaks symmetry. Beyond, single points let go one by one, and the whole cell
    /// is solved where the mesh is coarse enough for it to be affordable.
    pub(super) fn of(mu_rho: f64, points: usize) -> Self {
        match (mu_rho, points) {
            (..0.75, _) => Way::Quarter,
            (_, ..=64) => Way::Whole,
            _ => Way::Mirrored,
        }
    }
}

/// One closed loop. Forces over the pull-off force, energies over V_hys, both of JKR without images.
pub(super) struct Tip {
    pub(super) mu_rho: f64,
    /// Points along a side.
    pub(super) points: usize,
    /// Range of the law (R).
    pub(super) range: f64,
    /// (u0/R, force, positive in compression) in the order of the loop.
    pub(super) approach: Vec<[f64; 2]>,
    pub(super) retraction: Vec<[f64; 2]>,
    /// Largest tensile force.
    pub(super) pull_off: f64,
    /// V_hys as the sum of the releases, and as the integral of F du0.
    pub(super) released: f64,
    pub(super) integral: f64,
    /// Energy released in every jump.
    pub(super) jumps: Vec<f64>,
}

impl Tip {
    /// What is released in the jumps of the mesh: all but the first, into contact, and the last, out of it.
    pub(super) fn mesh_jumps(&self) -> &[f64] {
        match self.jumps.len() {
            0 | 1 => &[],
            n => &self.jumps[1..n - 1],
        }
    }
}

/// Runs the loop from separation to zero load and back.
pub(super) fn run(mu_rho: f64, points: usize, way: Way, task: &mut Task<'_>) -> Result<Tip, Stopped> {
    let scene = scenes::tip(points, mu_rho);
    let refused = |error: SceneError| Stopped::Failed(error.to_string());
    let range = scene.model().map_err(refused)?.law.range;
    let reduction = if way == Way::Whole { Reduction::Whole } else { Reduction::Quarter };
    let walk = Walk::reduced(&scene, MethodKind::NewtonKrylov, reduction).map_err(refused)?;
    let walk = if way == Way::Mirrored { walk.mirrored() } else { walk };
    let (cancel, what) = (task.cancel.clone(), format!("mu_rho = {mu_rho}, n = {points}"));
    let LoopRun { record, outcome, .. } = run_walk(walk, &scene, &cancel, &mut |report| {
        if let Report::State { fraction, .. } = report {
            // A request to stop ends the loop by itself.
            let _ = task.tell(fraction, &what);
        }
    });
    match outcome {
        Outcome::Completed => {}
        Outcome::Cancelled => return Err(Stopped::Cancelled),
        Outcome::NotConverged { mean_displacement, reason } => {
            return Err(Stopped::Failed(format!("{what}: stopped at u0 = {mean_displacement}: {reason}")));
        }
    }
    // L = 1: a mean stress is a force, an energy per area an energy.
    let (force, energy) = (TIP.pull_off_force(), TIP.dissipation());
    let curve = |branch| {
        let states = record.states.iter().filter(|s| s.branch == branch);
        let mut points: Vec<[f64; 2]> = states.map(|s| [s.mean_displacement, -s.stress / force]).collect();
        // Next to a jump states crowd closer than any drawing tells them apart.
        points.dedup_by(|b, a| (b[0] - a[0]).abs() < 1e-5 && (b[1] - a[1]).abs() < 5e-3);
        points
    };
    Ok(Tip {
        mu_rho,
        points,
        range,
        approach: curve(Branch::Approach),
        retraction: curve(Branch::Retraction),
        pull_off: record.states.iter().map(|s| s.stress / force).fold(0.0, f64::max),
        released: record.released_energy_sum() * TIP.surface_energy / energy,
        integral: record.work() / energy,
        jumps: record.jumps.iter().map(|j| j.released_energy * TIP.surface_energy / energy).collect(),
    })
}

/// Runs all loops of a list of (mu_rho, meshes), in its order.
pub(super) fn run_all(list: &[(f64, &[usize])], task: &mut Task<'_>) -> Result<Vec<Tip>, Stopped> {
    let pairs: Vec<(f64, usize)> = list.iter().flat_map(|(mu, meshes)| meshes.iter().map(|n| (*mu, *n))).collect();
    // Transforms grow with the points, increments with the root of their number, and iterations with it, too.
    let cost = |&(mu, n): &(f64, usize)| mu * (n as f64).powi(3);
    let all: f64 = pairs.iter().map(cost).sum();
    let mut done = 0.0;
    let mut tips = Vec::with_capacity(pairs.len());
    for pair in &pairs {
        let next = done + cost(pair) / all;
        tips.push(run(pair.0, pair.1, Way::of(pair.0, pair.1), &mut task.part(done.min(1.0), next.min(1.0)))?);
        done = next;
    }
    Ok(tips)
}
