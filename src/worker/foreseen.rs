//! A state that the live loop foresees, as one to be shown and gone on from: read off the atlas,
//! solved on the mesh of the scene, and kept only if it is stable there.

use super::job::Reporter;
use super::protocol::{LiveState, Stored};
use super::system::Instant;
use crate::follow::walk::{Walk, WalkOptions};
use crate::scene::Scene;
use crate::scene::part::Part;
use crate::solver::Lost;
use crate::study::live_loop::{Fineness, LiveLoops, Spot};
use std::sync::Arc;

/// How far before the end of a branch (units of the control) its state is looked for, where nearer
/// there is none: the atlas knows the end on a mesh of its own.
const BEFORE: [f64; 3] = [0.0, 1e-3, 1e-2];

/// A place on the live loop of a scene.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// The scene.
    pub scene: Arc<Scene>,
    /// The part of the cell on which the state is to be solved.
    pub part: Part,
    /// Its live loop.
    pub live: Arc<LiveState>,
    /// The place.
    pub spot: Spot,
}

/// Finds the state at a place.
///
/// # Errors
/// Why there is none, in words.
pub fn foreseen(wanted: &Wanted, report: &Reporter<Arc<Stored>>) -> Result<(), String> {
    let live = wanted.live.found.as_ref().map_err(Clone::clone)?;
    let leg = &live.legs[wanted.spot.leg];
    let (low, high) = (leg.from.min(leg.to), leg.from.max(leg.to));
    let options = WalkOptions {
        part: wanted.part,
        ..WalkOptions::default()
    };
    let mut refused = Lost::Gone;
    let mut tried = None;
    for before in BEFORE {
        let inside = (before * live.control.unit(&live.law)).min(0.5 * (high - low));
        let control = wanted.spot.control.clamp(low + inside, high - inside);
        if tried.replace(control) == Some(control) {
            continue;
        }
        let walk = Walk::start(&wanted.scene, options, &report.cancel);
        let walk = walk.map_err(|error| error.to_string())?;
        let place = live.segments[leg.segment].place;
        let z = live.atlas.guess(place, control, walk.system());
        match walk.standing_near(z, control, leg.direction) {
            Ok(walk) => {
                report.result(Arc::new(Stored::of(&walk, wanted.part, [0, 0])));
                return Ok(());
            }
            Err(Lost::Cancelled) => return Ok(()),
            Err(lost) => refused = lost,
        }
    }
    Err(match refused {
        Lost::Unstable => "on this mesh the state there is not stable".to_owned(),
        _ => format!(
            "there is no such state on this mesh: the live loop is of {} points",
            live.points
        ),
    })
}

/// The live loop of a scene, as fine as it gets.
///
/// # Errors
/// The first value of the scene that is not allowed.
pub fn live_loop(scene: &Arc<Scene>, report: &Reporter<Arc<LiveState>>) -> Result<(), String> {
    let model = scene.model().map_err(|error| error.to_string())?;
    let (began, fineness) = (Instant::now(), Fineness::Fine);
    let found = LiveLoops::obeying(&report.cancel).next(scene, &model, fineness);
    report.result(Arc::new(LiveState {
        found: found.map_err(|why| why.to_string()),
        fineness,
        milliseconds: began.elapsed().as_secs_f64() * 1e3,
    }));
    Ok(())
}
