//! What the figures of line cells share: the ridge alone, because a cell without width has no room
//! for bulges and dimples.
//!
//! All use a Morse law of range 1 and gamma = 0.15, as in Figs 2 and 3, or another law in its
//! place; the length of the cell then sets rho~. Results are reduced by [`Units`].

use super::task::{Stopped, Task};
use super::{scenes, walked};
use crate::follow::record::{Direction, StateRecord};
use crate::follow::run::LoopRun;
use crate::follow::walk::WalkOptions;
use crate::physics::pattern::Pattern;
use crate::physics::theory::units::Units;
use crate::scene::part::Part;
use crate::scene::{Points, Scene};

/// The units of a cell of side `length`.
pub(super) fn units(length: f64) -> Units {
    Units {
        length,
        surface_energy: scenes::SURFACE_ENERGY,
    }
}

/// A line cell of side `length` on `points`, driven from `start` to `turn` and back in steps of
/// `step` (all three u~).
pub(super) fn scene(
    title: &str,
    length: f64,
    points: usize,
    [start, turn, step]: [f64; 3],
) -> Scene {
    let unit = units(length).displacement();
    scenes::flat(
        title,
        length,
        Points::Line(points),
        start * unit,
        turn * unit,
        step * unit,
    )
}

/// Runs the closed loop, and tells how far it is.
pub(super) fn run(scene: &Scene, part: Part, task: &mut Task<'_>) -> Result<LoopRun, Stopped> {
    walked::run(
        scene,
        WalkOptions {
            part,
            ..WalkOptions::default()
        },
        task,
    )
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
