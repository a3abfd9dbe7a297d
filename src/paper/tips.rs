//! The loops of the Hertzian tip behind Figs 12 and 13.

use super::figure::{Stopped, Task};
use super::scenes::{self, refused, walked};
use crate::follow::record::{Direction, StateRecord};
use crate::follow::walk::WalkOptions;
use crate::physics::control::Control;
use crate::physics::theory::jkr::{Jkr, PeriodicJkr};
use crate::scene::part::Part;
use crate::scene::{Drive, Scene, Turn};

/// The tip of Sect. 4, R = 1.
pub(super) const TIP: Jkr = Jkr {
    radius: 1.0,
    surface_energy: scenes::TIP_SURFACE_ENERGY,
};

/// The same in its cell, L = R.
pub(super) fn periodic() -> PeriodicJkr {
    PeriodicJkr::new(TIP, 1.0)
}

/// The part of the cell on which the loop of a tip at `mu_rho` is solved. Up to 0.7 nothing but the
/// two collective jumps breaks symmetry. Beyond, single points let go one by one; their mirror
/// images are then held to do so together. The apex lies between points.
fn part_for(mu_rho: f64) -> Part {
    if mu_rho < TRAPS {
        Part::Quarter
    } else {
        Part::Mirrored
    }
}

/// mu_rho from which the mesh traps the edge of the contact.
const TRAPS: f64 = 0.75;
/// How closely, in ranges, the jumps of trapped points are located.
const TRAPPED_WITHIN: f64 = 0.025;

/// One closed loop. Forces over the pull-off force, energies over V_hys, both of JKR without
/// images.
#[derive(Clone, Debug)]
pub struct Tip {
    /// mu_rho.
    pub mu_rho: f64,
    /// Points along a side.
    pub points: usize,
    /// Range of the law (R).
    pub range: f64,
    /// (u0/R, force, positive in compression) in the order of the loop.
    pub approach: Vec<[f64; 2]>,
    /// The same on the way back.
    pub retraction: Vec<[f64; 2]>,
    /// Largest tensile force.
    pub pull_off: f64,
    /// V_hys as the sum of the releases.
    pub released: f64,
    /// The same as the integral of F du0.
    pub integral: f64,
    /// Energy released in every jump.
    pub jumps: Vec<f64>,
}

impl Tip {
    /// What is released in the jumps of the mesh: all but the first, into contact, and the last,
    /// out of it.
    pub fn mesh_jumps(&self) -> &[f64] {
        match self.jumps.len() {
            0 | 1 => &[],
            n => &self.jumps[1..n - 1],
        }
    }
}

/// Which loop: mu_rho, points along a side, which surface, how far down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Order {
    /// mu_rho.
    pub mu_rho: f64,
    /// Points along a side.
    pub points: usize,
    /// Which part of the cell is solved; of the whole the apex lies on a point.
    pub part: Part,
    /// What drives it.
    pub drive: TipDrive,
}

/// How a tip is driven to the ground and back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TipDrive {
    /// By displacement, to zero load.
    ToZeroLoad,
    /// By displacement, to this u0.
    To(f64),
    /// By a load, from four times the pull-off force of JKR to a tenth of it in compression.
    Load,
}

impl Order {
    /// The loop to zero load and back, on the part of the cell that its mu_rho allows.
    pub fn new(mu_rho: f64, points: usize) -> Self {
        Self {
            mu_rho,
            points,
            part: part_for(mu_rho),
            drive: TipDrive::ToZeroLoad,
        }
    }

    /// Transforms grow with the points, increments with the root of their number, and iterations
    /// with it, too; single points that let go cost a step each, and a mirrored quarter is a
    /// quarter.
    fn cost(&self) -> f64 {
        let steps = if self.mu_rho < TRAPS { 1.0 } else { 20.0 };
        let share = if self.part == Part::Whole { 4.0 } else { 1.0 };
        (self.points as f64).powi(3) * steps * share
    }
}

/// Runs the loop from separation to the turn and back.
///
/// # Errors
/// Where it stopped, in words.
pub fn run(order: &Order, task: &mut Task<'_>) -> Result<Tip, Stopped> {
    let Order {
        mu_rho,
        points,
        part,
        drive,
    } = *order;
    let mut scene = scenes::tip(points, mu_rho);
    match drive {
        TipDrive::ToZeroLoad => {}
        TipDrive::To(turn) => scene.drive.turn = Turn::At(turn),
        TipDrive::Load => scene = by_load(scene),
    }
    scene.title += &format!(", n = {points}");
    let range = scene
        .model()
        .map_err(|error| refused(&scene, error))?
        .law
        .range;
    let options = WalkOptions {
        part,
        trapped_within: (mu_rho >= TRAPS).then_some(TRAPPED_WITHIN),
        ..WalkOptions::default()
    };
    let record = walked(&scene, options, task)?.record;
    // L = 1: a mean stress is a force, an energy per area an energy.
    let (force, energy) = (TIP.pull_off_force(), TIP.dissipation());
    let curve = |branch| {
        let states = record.states.iter().filter(|s| s.direction == branch);
        // What is left of a load on a body apart the stop bears.
        let applied = |s: &StateRecord| match drive {
            TipDrive::Load => s.control,
            _ => s.stress,
        };
        let mut points: Vec<[f64; 2]> = states
            .map(|s| [s.mean_displacement, -applied(s) / force])
            .collect();
        // Next to a jump states crowd closer than any drawing tells them apart.
        points.dedup_by(|b, a| (b[0] - a[0]).abs() < 1e-5 && (b[1] - a[1]).abs() < 5e-3);
        points
    };
    Ok(Tip {
        mu_rho,
        points,
        range,
        approach: curve(Direction::Approach),
        retraction: curve(Direction::Retraction),
        pull_off: match drive {
            TipDrive::Load => record.jumps.last().map_or(f64::NAN, |j| j.control / force),
            _ => {
                let stresses = record.states.iter().map(|s| s.stress / force);
                stresses.fold(0.0, f64::max)
            }
        },
        released: record.released_energy_sum() * TIP.surface_energy / energy,
        integral: record.work() / energy,
        jumps: record
            .jumps
            .iter()
            .map(|j| j.released_energy * TIP.surface_energy / energy)
            .collect(),
    })
}

/// The `scene` of the tip, L = 1, where a mean stress is a force, driven by a load.
pub(super) fn by_load(scene: Scene) -> Scene {
    let force = TIP.pull_off_force();
    let drive = Drive {
        control: Control::Load,
        start: 4.0 * force,
        turn: Turn::At(-0.1 * force),
        step: 0.05 * force,
    };
    Scene { drive, ..scene }
}

/// Runs all these loops, several at a time.
pub(super) fn run_all(orders: &[Order], task: &mut Task<'_>) -> Result<Vec<Tip>, Stopped> {
    task.each(orders, Order::cost, run)
}

/// The loops of a list of (mu_rho, meshes).
pub(super) fn orders(list: &[(f64, &[usize])], drive: TipDrive) -> Vec<Order> {
    let order = |mu: f64, n: usize| Order {
        drive,
        ..Order::new(mu, n)
    };
    list.iter()
        .flat_map(|(mu, meshes)| meshes.iter().map(move |n| order(*mu, *n)))
        .collect()
}

/// Loops kept with the program, since the finest take an hour together: mu_rho and points along a
/// side of each. The file is the output of `cargo run --release --no-default-features --example
/// tip_loops`.
pub const KEPT: ([f64; 5], [usize; 5]) = ([0.5, 0.7, 1.0, 1.5, 2.0], [32, 64, 128, 256, 512]);

/// Head of the table of loops that are kept.
pub const HEAD: &str = "mu_rho,points,range,pull_off,released,integral,jumps";

impl Tip {
    /// Its row in the table of loops that are kept: without its curves, the jumps parted by spaces.
    pub fn row(&self) -> String {
        let Self {
            mu_rho,
            points,
            range,
            pull_off,
            released,
            integral,
            jumps,
            ..
        } = self;
        let jumps: Vec<String> = jumps.iter().map(|jump| format!("{jump:.3e}")).collect();
        format!(
            "{mu_rho},{points},{range:.6e},{pull_off:.6},{released:.6},{integral:.6},{}",
            jumps.join(" ")
        )
    }

    fn from_row(row: &str) -> Option<Self> {
        let cells: Vec<&str> = row.split(',').collect();
        let [mu_rho, points, range, pull_off, released, integral, jumps] = cells[..] else {
            return None;
        };
        let number = |cell: &str| cell.parse().ok();
        Some(Self {
            mu_rho: number(mu_rho)?,
            points: points.parse().ok()?,
            range: number(range)?,
            approach: Vec::new(),
            retraction: Vec::new(),
            pull_off: number(pull_off)?,
            released: number(released)?,
            integral: number(integral)?,
            jumps: jumps
                .split_whitespace()
                .map(number)
                .collect::<Option<_>>()?,
        })
    }
}

/// The loops kept with the program.
pub fn kept() -> Vec<Tip> {
    include_str!("../../assets/tips.csv")
        .lines()
        .filter_map(Tip::from_row)
        .collect()
}
