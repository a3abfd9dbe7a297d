//! The diagram on uneven ground: the branch of the first state of the drive through all its folds,
//! until it leaves the range of the drive, and the branches that leave it where it loses or gains
//! its stability.

use super::meeting::{Ends, Meeting};
use super::trace::{Start, Tracer};
use super::{Diagram, Ending, Kind, Observe, Point};
use crate::follow::walk::symmetry::slides_on;
use crate::follow::walk::{Walk, WalkOptions};
use crate::numerics::threads::Cancel;
use crate::physics::control::Control;
use crate::physics::parameter::Refusal;
use crate::physics::system::State;
use crate::scene::{Part, Scene, Turn};
use crate::solver::continuation::Knot;
use crate::solver::index::Index;
use crate::solver::mechanics::Mechanics;

/// Most branches that are followed: rough ground has as many as its crests can be in contact in
/// different orders.
const BRANCHES: usize = 12;

/// Follows the branch of the first state of the drive on `part` of the cell, and what leaves it.
pub(super) fn fill(
    diagram: &mut Diagram,
    scene: &Scene,
    part: Part,
    cancel: &Cancel,
    observe: Observe<'_>,
) -> Result<(), Refusal> {
    let options = WalkOptions {
        part,
        ..WalkOptions::default()
    };
    let walk = Walk::start(scene, options, cancel)?;
    if let Some((what, _)) = walk.record().fault() {
        diagram.missing.push(what);
        return Ok(());
    }
    let mut mechanics = walk.mechanics().clone();
    let mut state = walk.here().state.clone();
    if walk.control().frees_mean() {
        // The plate of a layer was driven: the same surface is in equilibrium at its own u0.
        let (system, slides) = (mechanics.system.clone(), mechanics.slides);
        mechanics = Mechanics::new(system.with_control(Control::Displacement), slides);
        state.amplitudes[0] = 0.0;
        state = mechanics
            .at(state.amplitudes, state.mean_displacement)
            .state;
    }
    let index = Index::of_cell(&mechanics.system, slides_on(walk.model()), scene.seed);
    let mut down = vec![0.0; mechanics.system.dimension()];
    down[0] = -1.0;
    let first = Knot {
        state,
        tangent: down,
        stress_rate: f64::NAN,
        arc: 0.0,
        residual: walk.here().residual,
    };
    let control = diagram.control;
    let mut tracer = Tracer {
        mechanics,
        index,
        control,
    };
    let beyond = |before: &Knot, after: &Knot| beyond(scene, before, after);
    let mut meetings: Vec<Meeting> = Vec::new();
    let mut next = Some(("contact".to_owned(), Start::Point(first)));
    while let Some((name, from)) = next {
        // It may also come back to where it began.
        let others: Vec<usize> = (0..meetings.len())
            .filter(|i| !meetings[*i].joined)
            .collect();
        let states: Vec<State> = others.iter().map(|i| meetings[*i].state.clone()).collect();
        if let Start::Meeting(knot) = &from {
            for meeting in &mut meetings {
                meeting.joined |= meeting.state == knot.state;
            }
        }
        let ends = Ends {
            others: &|_| states.clone(),
            met: Ending::Joined,
            about: 0.0,
            beyond: &beyond,
        };
        let known = diagram.branches.len();
        if let Some(which) = diagram.follow(&mut tracer, name, from, &ends, observe) {
            meetings[others[which]].joined = true;
        }
        let new = diagram.branches[known..]
            .iter()
            .flat_map(|branch| &branch.points);
        meetings.extend(new.filter_map(|point| left_by(point, control)));
        // What leaves the symmetry of a part is found on the whole cell.
        if part.is_even() && !meetings.is_empty() && !cancel.requested() {
            *diagram = Diagram {
                transforms: diagram.transforms,
                control,
                ..Diagram::default()
            };
            return fill(diagram, scene, Part::Whole, cancel, observe);
        }
        next = meetings
            .iter()
            .find(|meeting| !meeting.joined && !cancel.requested())
            .map(|meeting| {
                (
                    format!("broken_{}", diagram.branches.len()),
                    meeting.leave(),
                )
            });
        if next.is_some() && diagram.branches.len() == BRANCHES {
            let left = meetings.iter().filter(|meeting| !meeting.joined).count();
            diagram.missing.push(format!(
                "what leaves at {left} more places, beyond {BRANCHES} branches"
            ));
            break;
        }
    }
    Ok(())
}

/// The point as one at which a branch leaves, if a piece that is stable at fixed u0 begins or ends
/// there.
fn left_by(point: &Point, control: Control) -> Option<Meeting> {
    let leaves = point.kind == Kind::Bifurcation && point.bounds_stable(control);
    (leaves && !point.mode.is_empty()).then(|| Meeting {
        state: point.state.clone(),
        mode: point.mode.clone(),
        residual: point.residual,
        joined: false,
    })
}

/// True if the way between two knots leaves the range of the drive.
fn beyond(scene: &Scene, before: &Knot, after: &Knot) -> bool {
    let u0 = after.state.mean_displacement;
    let below = match scene.drive.turn {
        Turn::At(turn) => u0 < turn,
        // In contact, and unloaded: there the loop turns.
        Turn::ZeroLoad => {
            before.state.stress > 0.0 && after.state.stress <= 0.0 && after.rate() < 0.0
        }
    };
    below || u0 > scene.drive.start
}
