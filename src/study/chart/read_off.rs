//! Loops read off branches in place of walked: those of an atlas on flat square ground, and the
//! stable pieces of a diagram on lines and over tips.
//!
//! A diagram does not know where a surface lands: that says a walk on a coarser mesh. The ends of
//! the pieces are exact to the square of how well a fold is located along its branch, and the
//! states where a jump lands are solved as sharply: what is left of the error is the mesh's.

use super::{Errors, Measured};
use crate::follow::atlas::{Atlas, Leg, Place};
use crate::follow::diagram::Piece;
use crate::follow::record::{Cause, Direction, JumpRecord, LoopRecord, StateRecord};
use crate::follow::run::{LoopRun, Outcome};
use crate::follow::walk::Stuck;
use crate::numerics::dense::{dot, norm, scale};
use crate::numerics::threads::Cancel;
use crate::physics::control::Control;
use crate::physics::law::Law;
use crate::physics::pattern::Pattern;
use crate::scene::{Model, Part, Scene};
use crate::solver::Stop;
use crate::solver::continuation::way;
use crate::study::landscape::{Ground, Standing};
use crate::study::plan::diagram;

/// The farthest that a jump may be from that of the walk on a coarser mesh (ranges).
const NEAR: f64 = 0.05;
/// The same where a closed form tells both where it is.
const EXACT: f64 = 1e-5;
/// The share of its own correction by which a located fold may be off.
const UNSURE: f64 = 0.1;

/// The loop of a scene on flat ground, off its atlas. Where that has no answer the loop has not
/// converged, and says why.
pub(super) fn of_atlas(scene: &Scene, model: &Model) -> LoopRun {
    // As the live loop does.
    let mut atlas = Atlas::of(scene, model);
    let start = scene.drive.start;
    let mut run = LoopRun::of(scene.control());
    match atlas.cycle(start, scene.depth()) {
        Ok(cycle) => {
            run.record.states = cycle
                .legs
                .iter()
                .flat_map(|leg| states_of(&atlas, leg, scene, model))
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
    counted(run)
}

fn counted(mut run: LoopRun) -> LoopRun {
    let states = run.record.states.iter();
    run.counts.patterned_increments = states.filter(|s| s.pattern != Pattern::Flat).count();
    run
}

/// The states along a leg of an atlas.
fn states_of<'a>(
    atlas: &'a Atlas,
    leg: &'a Leg,
    scene: &'a Scene,
    model: &'a Model,
) -> impl Iterator<Item = StateRecord> {
    let (pattern, part) = match leg.place {
        Place::Flat(_) => (Pattern::Flat, Part::Flat),
        Place::On(i) => {
            let branch = &atlas.branches()[i];
            let part = if branch.is_ridge() {
                Part::Ridge
            } else {
                Part::Quarter
            };
            (branch.pattern, part)
        }
    };
    let control = atlas.meshes().control;
    let places = places([leg.from, leg.to], scene.drive.start, scene.drive.step);
    places.into_iter().map(move |value| {
        let at = atlas.at(leg.place, value);
        StateRecord {
            direction: leg.direction,
            stress: at.stress,
            stress_over_max: at.stress / model.law.traction_max(),
            energy: at.body_energy(control),
            pattern,
            part,
            stop: Stop::ReadOff,
            control: value,
            ..StateRecord::placeholder(at.mean_displacement)
        }
    })
}

/// Values of the control on the way from one to another: both, and start - k x step between them.
fn places([from, to]: [f64; 2], start: f64, step: f64) -> Vec<f64> {
    let (low, high) = (from.min(to), from.max(to));
    let (first, last) = (
        ((start - high) / step).floor() as i64,
        ((start - low) / step).ceil() as i64,
    );
    let mut places: Vec<f64> = (first..=last)
        .map(|k| start - k as f64 * step)
        .filter(|u| *u > low && *u < high)
        .collect();
    places.extend([from, to]);
    places.sort_by(|a, b| {
        if from < to {
            a.total_cmp(b)
        } else {
            b.total_cmp(a)
        }
    });
    places
}

/// The loop of `scene`, whose u0 is driven, along the pieces of its diagram on which the loop
/// `walked` on a coarser mesh lies; cancelled where one of them, or a landing, is not found, or not
/// before `cancel`. `tell` is called now and then.
pub(super) fn of_diagram(
    scene: &Scene,
    model: &Model,
    walked: &LoopRecord,
    cancel: &Cancel,
    tell: &mut dyn FnMut(),
) -> LoopRun {
    let mut run = LoopRun {
        outcome: Outcome::Cancelled,
        ..LoopRun::of(scene.control())
    };
    if let Ok(diagram) = diagram(scene, cancel, &mut |_, _, _| tell()) {
        let ground = Ground {
            scene,
            model,
            diagram: &diagram,
            cancel,
        };
        run.counts.transforms = diagram.transforms;
        if let Some(record) = along(ground, walked) {
            (run.record, run.outcome) = (record, Outcome::Completed);
        }
    }
    counted(run)
}

/// The loop along the pieces on which the `walked` one lies, with the steps of the scene.
fn along(ground: Ground<'_>, walked: &LoopRecord) -> Option<LoopRecord> {
    let drive = &ground.scene.drive;
    let ways = ways(ground, walked)?;
    let mut record = LoopRecord::of(Control::Displacement);
    let (mut jumps, mut from) = (walked.jumps.iter(), drive.start);
    for (i, way) in ways.iter().enumerate() {
        let mut to = way.to;
        if way.jumps {
            let jump = jump(ground, jumps.next()?, [&way.piece, &ways.get(i + 1)?.piece])?;
            to = jump.control;
            record.jumps.push(jump);
        }
        let places = places([from, to], drive.start, drive.step).into_iter();
        let states = places.map(|u0| way.state(u0, ground.model));
        record.states.extend(states);
        from = to;
    }
    Some(record)
}

/// The way between two jumps, or between one and an end of the drive.
struct Way<'d> {
    piece: Piece<'d>,
    /// The states of the walk on it.
    walked: Vec<&'d StateRecord>,
    /// Where it ends; of one that ends in a jump about.
    to: f64,
    /// True if it ends in a jump.
    jumps: bool,
}

impl Way<'_> {
    fn state(&self, u0: f64, model: &Model) -> StateRecord {
        let [low, high] = self.piece.extent();
        let at = self.piece.at(u0.clamp(low, high));
        let far = |state: &&&StateRecord| (state.mean_displacement - u0).abs();
        let nearest = self
            .walked
            .iter()
            .min_by(|a, b| far(a).total_cmp(&far(b)))
            .expect("a way has states");
        StateRecord {
            direction: nearest.direction,
            stress: at.stress,
            stress_over_max: at.stress / model.law.traction_max(),
            energy: at.energy,
            pattern: nearest.pattern,
            part: nearest.part,
            stop: Stop::ReadOff,
            ..StateRecord::placeholder(u0)
        }
    }
}

/// The ways of the loop, each on the piece of the diagram on which the walked states lie.
fn ways<'d>(ground: Ground<'d>, walked: &'d LoopRecord) -> Option<Vec<Way<'d>>> {
    let mut ways = Vec::new();
    let start = ground.scene.drive.start;
    for direction in Direction::BOTH {
        let states = walked.states.iter().filter(|s| s.direction == direction);
        let states: Vec<&StateRecord> = states.collect();
        let end = match direction {
            Direction::Approach => states.last()?.control,
            Direction::Retraction => start,
        };
        let jumps = walked.jumps.iter().filter(|j| j.direction == direction);
        let ends = jumps.map(|jump| (jump.control, true)).chain([(end, false)]);
        // Where the way begins, which belongs to what was before a jump too.
        let mut from = match direction {
            Direction::Approach => start,
            Direction::Retraction => ways.last().map(|way: &Way<'_>| way.to)?,
        };
        for (to, jumps) in ends {
            let within = |s: &&&StateRecord| {
                let (low, high) = (from.min(to), from.max(to));
                low < s.control && s.control < high
            };
            let own: Vec<&StateRecord> = states.iter().filter(within).copied().collect();
            let middle = own.get(own.len() / 2)?;
            let piece = ground.stable(Standing::of(middle, Control::Displacement))?;
            ways.push(Way {
                piece,
                walked: own,
                to,
                jumps,
            });
            from = to;
        }
    }
    Some(ways)
}

/// A jump of the walk, from the end of one piece to another; `None` if it is neither a fold nor a
/// limit of the flat state, or elsewhere.
fn jump(
    ground: Ground<'_>,
    recorded: &JumpRecord,
    [from, to]: [&Piece<'_>; 2],
) -> Option<JumpRecord> {
    let Law {
        range,
        surface_energy,
        ..
    } = ground.model.law;
    let [low, high] = from.extent();
    let end = match recorded.direction {
        Direction::Approach => low,
        Direction::Retraction => high,
    };
    let far = (end - recorded.control).abs() / range;
    let late = match recorded.cause {
        // Known in closed form, from which the walk stands a hair off.
        Cause::FlatLimit if far < EXACT => 0.0,
        Cause::Fold if far < NEAR => beyond(ground, from, end)?,
        _ => return None,
    };
    if !recorded.landings.is_empty() {
        return None;
    }
    let (before, u0) = (from.at(end), end + late);
    let driven = Control::Displacement;
    let mut mechanics = to.branch.on_whole_cell(ground.model, driven, ground.cancel);
    let after = ground.equilibrium(to, u0, &mut mechanics).ok()?.state;
    let released = before.energy + before.stress * late - after.energy;
    let unsure = UNSURE * late * (before.stress - after.stress);
    Some(JumpRecord {
        control: u0,
        mean_displacement: u0,
        mean_displacement_after: u0,
        stress_before: before.stress,
        stress_after: after.stress,
        released_energy: released / surface_energy,
        release_error: unsure.abs() / surface_energy,
        ..recorded.clone()
    })
}

/// How much farther along u0 than the `end` of a piece the fold lies there (length): as far as what
/// is left of the force at the located state, and of du0 along the branch, tell to first order.
fn beyond(ground: Ground<'_>, piece: &Piece<'_>, end: f64) -> Option<f64> {
    let [mut near, mut last] = piece.around(end);
    if near.state.control == end {
        std::mem::swap(&mut near, &mut last);
    }
    let (branch, driven) = (piece.branch, Control::Displacement);
    let mut mechanics = branch.on_whole_cell(ground.model, driven, ground.cancel);
    let before = branch.surface(near, &mut mechanics).state;
    let at = branch.surface(last, &mut mechanics);
    let mut onwards = way(before.joint(), at.state.joint());
    let length = norm(&onwards);
    scale(&mut onwards, 1.0 / length);
    let (z, u0) = at.state.joint();
    let (knot, _) = mechanics.knot(z.to_vec(), u0, &onwards).ok()?;
    let mut null = knot.tangent;
    let rate = std::mem::take(&mut null[0]);
    let forces = mechanics.rates(&at.fields).forces;
    let unbalanced = -dot(&null, &at.gradient) / dot(&null, &forces);
    let bend = (last.rates[0] - near.rates[0]) / (last.arc - near.arc);
    Some(unbalanced - 0.5 * rate * rate / bend)
}

/// How well the jumps of a loop along branches are located: what [`beyond`] leaves.
pub(super) fn located(measured: &Measured) -> Errors {
    let gamma = measured.law.surface_energy;
    let jumps = &measured.record.jumps;
    let energy: f64 = jumps.iter().map(|jump| jump.release_error).sum();
    let late = jumps
        .iter()
        .map(|jump| jump.release_error * gamma / (jump.stress_before - jump.stress_after).abs());
    Errors {
        dissipated_energy: energy / measured.dissipated_energy().abs(),
        jumps: late.fold(0.0, f64::max) / measured.law.range,
        stress: 0.0,
    }
}
