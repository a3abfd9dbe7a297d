//! The scenes of the paper as values, for the figures and for the window; and the closed loops behind
//! the figures, run by a walk or as planned, with what is read off them, reduced by [`Units`]; the
//! loops of the Hertzian tip behind Figs 12 and 13 among them.

use super::{Stopped, Task};
use crate::follow::record::{Direction, StateRecord};
use crate::follow::run::{LoopRun, Outcome, Report, run_loop};
use crate::follow::walk::WalkOptions;
use crate::numerics::threads::Cancel;
use crate::physics::body::Body;
use crate::physics::control::Control;
use crate::physics::indenter::{Hertz, Indenter, Rough};
use crate::physics::law::{Morse, Shape};
use crate::physics::mesh::Grid;
use crate::physics::parameter::Refusal;
use crate::physics::pattern::Pattern;
use crate::physics::theory::Units;
use crate::physics::theory::jkr::{Jkr, PeriodicJkr};
use crate::scene::{Cell, Drive, LawChoice, Model, Part, Points, Range, Scene, Turn};
use crate::solver::methods::MethodKind;
use crate::study::plan::{plan, run_as_planned};
use ndarray::Array2;

/// gamma of the flat scenes in units of E* rho.
pub const SURFACE_ENERGY: f64 = 0.15;

fn morse(surface_energy: f64, range: Range) -> LawChoice {
    LawChoice {
        shape: Shape::Morse(Morse),
        surface_energy,
        range,
    }
}

/// Flat ground with the Morse law of range 1 and gamma = 0.15, as in Figs 2 to 4: a cell of side
/// `length` on `points`, driven from `start` to `turn` and back.
pub fn flat(title: &str, length: f64, points: Points, start: f64, turn: f64, step: f64) -> Scene {
    Scene {
        title: title.to_owned(),
        source: "Wang, Zhou, Mueser 2020".to_owned(),
        cell: Cell { length, points },
        body: Body::HalfSpace,
        law: morse(SURFACE_ENERGY, Range::Length(1.0)),
        indenter: Indenter::Flat,
        drive: Drive {
            control: Default::default(),
            start,
            turn: Turn::At(turn),
            step,
        },
        accuracy: 0.01,
        seed: 1,
        units: None,
    }
}

/// Fig. 2, as the preset `fig2`.
pub fn figure_2() -> Scene {
    flat(
        "Fig. 2: four patterns",
        256.0,
        Points::Square(64),
        4.2,
        0.2,
        0.02,
    )
}

/// Fig. 3, as the preset `fig3`.
pub fn figure_3() -> Scene {
    flat(
        "Fig. 3: a longer cell, no bulge",
        1024.0,
        Points::Square(256),
        9.0,
        0.2,
        0.04,
    )
}

/// The ridge alone, as the preset `ridge-line`: fields uniform along y.
pub fn ridge_line() -> Scene {
    flat(
        "A line cell: only the ridge",
        256.0,
        Points::Line(256),
        4.4,
        0.2,
        0.02,
    )
}

/// Rough ground for Fig. 14, `waves` of the longest self-affine waves along a side. The drive goes
/// from 1.5 above the crest down to a mean gap of `turn`. Lengths are in root mean square heights.
///
/// The paper gives the range, 0.23, and leaves surface and gamma open. Here the Hurst exponent is
/// 0.8, the self-affine wavelengths go from 8 to 2, which makes a root mean square gradient near 1,
/// and gamma = 0.2 E* h_rms, which makes a small hysteresis.
pub fn rough(waves: usize, seed: u64, turn: f64) -> Scene {
    let length = 8.0 * waves as f64;
    let points = 32 * waves;
    let surface = Rough {
        hurst: 0.8,
        rms: 1.0,
        longest: 8.0,
        shortest: 2.0,
        seed,
    };
    let mean = surface.mean_height(&Grid::square(length, points));
    let (start, turn, step) = (1.5, mean + turn, 0.01);
    let mesh = Points::Square(points);
    Scene {
        law: morse(0.2, Range::Length(0.23)),
        indenter: Indenter::Rough(surface),
        ..flat("Fig. 14: rough ground", length, mesh, start, turn, step)
    }
}

/// gamma of the tip in units of E* R.
pub const TIP_SURFACE_ENERGY: f64 = 0.5859e-3;

/// The tip of Sect. 4 in a cell with L = R = 1, driven by displacement to zero load and back.
pub fn tip(points: usize, mu_rho: f64) -> Scene {
    let range = (TIP_SURFACE_ENERGY / points as f64).sqrt() / (2.0 * mu_rho);
    // Single points that let go are close together on the way.
    let step = if mu_rho < 0.75 { 0.15 } else { 0.05 };
    // JKR lets go at 0.0113; a longer range acts from farther off, and a mesh that traps the edge of
    // the contact holds on for longer.
    let start = 0.012 + 4.0 * range + 0.02 * (mu_rho - 0.7).max(0.0);
    let title = format!("A Hertzian tip: mu_rho = {mu_rho}");
    let mut scene = Scene {
        source: "Wang, Zhou, Mueser 2020, Figs 12 and 13".to_owned(),
        law: morse(TIP_SURFACE_ENERGY, Range::MuRho(mu_rho)),
        indenter: Indenter::Hertz(Hertz { radius: 1.0 }),
        ..flat(
            &title,
            1.0,
            Points::Square(points),
            start,
            f64::NAN,
            step * range,
        )
    };
    scene.drive.turn = Turn::ZeroLoad;
    scene
}

/// A cylinder under tension, for the schematic of Fig. 1.
pub fn figure_1() -> Scene {
    let title = "Fig. 1: a cylinder, seen from the side";
    Scene {
        source: "Wang, Zhou, Mueser 2020, Fig. 1".to_owned(),
        law: morse(0.3, Range::Length(0.2)),
        indenter: Indenter::Hertz(Hertz { radius: 4.0 }),
        ..flat(title, 8.0, Points::Line(256), 1.0, -0.6, 0.02)
    }
}

/// Runs the closed loop of `scene` by a walk with these options, and tells how far it is.
pub(super) fn walked(
    scene: &Scene,
    options: WalkOptions,
    task: &mut Task<'_>,
) -> Result<LoopRun, Stopped> {
    seen(scene, options, task, &mut |_, _| {})
}

/// The same, showing every state with its gap.
pub(super) fn seen(
    scene: &Scene,
    options: WalkOptions,
    task: &mut Task<'_>,
    see: &mut dyn FnMut(&StateRecord, &Array2<f64>),
) -> Result<LoopRun, Stopped> {
    task.tell(0.0, &scene.title)?;
    closed(scene, task, &scene.title, |cancel, observe| {
        run_loop(scene, options, cancel, &mut |report| {
            if let Report::State { record, fields, .. } = &report {
                see(record, fields[0]);
            }
            observe(report);
        })
    })
}

/// The closed loop of `scene` as planned, without an error bar; `what` is told to be done.
pub(super) fn planned(
    scene: &Scene,
    task: &mut Task<'_>,
    what: &str,
) -> Result<(LoopRun, Model), Stopped> {
    let model = decided(scene)?;
    let plan = plan(scene, &model, None);
    let run = closed(scene, task, what, |cancel, observe| {
        run_as_planned(scene, MethodKind::NewtonKrylov, &plan, cancel, observe)
    })?;
    Ok((run, model))
}

/// The loop that `run` runs, if it closes.
fn closed(
    scene: &Scene,
    task: &mut Task<'_>,
    what: &str,
    run: impl FnOnce(&Cancel, &mut dyn FnMut(Report<'_>)) -> Result<LoopRun, Refusal>,
) -> Result<LoopRun, Stopped> {
    let cancel = task.cancel;
    let run = run(cancel, &mut |report| {
        if let Report::State { fraction, .. } = report {
            // A request to stop ends the loop by itself.
            let _ = task.tell(fraction, what);
        }
    })
    .map_err(|error| refused(scene, error))?;
    let failed = |why: String| Err(Stopped::Failed(format!("{}: {why}", scene.title)));
    match &run.outcome {
        Outcome::Completed => match run.record.ledger(1.0).open {
            None => Ok(run),
            Some(open) => failed(format!("loop not closed: {}", open.reason)),
        },
        Outcome::Cancelled => Err(Stopped::Cancelled),
        Outcome::NotConverged {
            mean_displacement,
            reason,
        } => failed(format!("stopped at u0 = {mean_displacement}: {reason}")),
    }
}

/// The scene with everything decided.
pub(super) fn decided(scene: &Scene) -> Result<Model, Stopped> {
    scene.model().map_err(|error| refused(scene, error))
}

/// A value of the scene that is not allowed.
fn refused(scene: &Scene, error: Refusal) -> Stopped {
    Stopped::Failed(format!("{}: {error}", scene.title))
}

/// The units of a cell of side `length` with that gamma.
pub(super) fn units(length: f64) -> Units {
    Units {
        length,
        surface_energy: SURFACE_ENERGY,
    }
}

/// The units of a scene.
pub(super) fn units_of(model: &Model) -> Units {
    Units::of(&model.law, model.grid.length)
}

/// A line cell, which has the ridge alone: without a width it has no room for bulges and dimples. Of
/// side `length` on `points`, driven from `start` to `turn` and back in steps of
/// `step` (all three u~).
pub(super) fn line_cell(
    title: &str,
    length: f64,
    points: usize,
    [start, turn, step]: [f64; 3],
) -> Scene {
    let unit = units(length).displacement();
    flat(
        title,
        length,
        Points::Line(points),
        start * unit,
        turn * unit,
        step * unit,
    )
}

/// Runs the closed loop of a line cell on this part of it.
pub(super) fn on_part(scene: &Scene, part: Part, task: &mut Task<'_>) -> Result<LoopRun, Stopped> {
    let options = WalkOptions {
        part,
        ..WalkOptions::default()
    };
    walked(scene, options, task)
}

/// (u~, p~) of a state.
pub(super) fn reduced(units: &Units, state: &StateRecord) -> [f64; 2] {
    let u0 = state.mean_displacement;
    [units.reduce(u0), units.pressure(state.stress, u0)]
}

/// (u~, p~) of the ridges of one direction.
pub(super) fn ridges(run: &LoopRun, units: &Units, direction: Direction) -> Vec<[f64; 2]> {
    let states = run
        .record
        .states
        .iter()
        .filter(|s| s.direction == direction && s.pattern == Pattern::Ridge);
    states.map(|state| reduced(units, state)).collect()
}

/// The ends (lowest and highest u~) of the ridge over both directions; `None` if there was none.
pub(super) fn ends(run: &LoopRun, units: &Units) -> Option<[f64; 2]> {
    let ridges = run
        .record
        .states
        .iter()
        .filter(|s| s.pattern == Pattern::Ridge)
        .map(|s| units.reduce(s.mean_displacement));
    ridges.fold(None, |ends, u| {
        ends.map_or(Some([u, u]), |[low, high]: [f64; 2]| {
            Some([low.min(u), high.max(u)])
        })
    })
}

/// At most one of `points` in every interval `spacing` of x, and the last: symbols that do not
/// cover each other.
pub(super) fn thinned(points: Vec<[f64; 2]>, spacing: f64) -> Vec<[f64; 2]> {
    let mut kept: Vec<[f64; 2]> = Vec::new();
    let end = points.last().copied();
    for point in points {
        if kept
            .last()
            .is_none_or(|last| (point[0] - last[0]).abs() >= spacing)
        {
            kept.push(point);
        }
    }
    if kept.last() != end.as_ref() {
        kept.extend(end);
    }
    kept
}

/// The tip of Sect. 4, R = 1.
pub(super) const TIP: Jkr = Jkr {
    radius: 1.0,
    surface_energy: TIP_SURFACE_ENERGY,
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
    let mut scene = tip(points, mu_rho);
    match drive {
        TipDrive::ToZeroLoad => {}
        TipDrive::To(turn) => scene.drive.turn = Turn::At(turn),
        TipDrive::Load => scene = by_load(scene),
    }
    scene.title += &format!(", n = {points}");
    let range = decided(&scene)?.law.range;
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
