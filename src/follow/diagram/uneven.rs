//! The diagram on uneven ground: the branch of the first state of the drive through all its folds,
//! until it leaves the range of the drive, and the branches that leave it where it loses or gains
//! its stability.

use super::meeting::{meeting, way_to};
use super::trace::{Start, Tracer};
use super::{Branch, Diagram, Ending, Kind, Point, Report};
use crate::follow::walk::symmetry::slides_on;
use crate::follow::walk::{Walk, WalkOptions};
use crate::numerics::cancel::Cancel;
use crate::physics::parameter::Refusal;
use crate::physics::system::State;
use crate::scene::part::Part;
use crate::scene::{Scene, Turn};
use crate::solver::continuation::Knot;
use crate::solver::index::Index;
use crate::solver::mechanics::Mechanics;
use std::collections::VecDeque;

/// Most branches that are followed: rough ground has as many as its crests can be in contact in
/// different orders.
const BRANCHES: usize = 12;

/// Follows the branch of the first state of the drive on `part` of the cell, and what leaves it.
pub(super) fn fill(
    diagram: &mut Diagram,
    scene: &Scene,
    part: Part,
    cancel: &Cancel,
    report: Report<'_>,
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
    let mechanics = walk.mechanics().clone();
    let index = Index::of_cell(&mechanics.system, slides_on(walk.model()), scene.seed);
    let mut down = vec![0.0; mechanics.system.dimension()];
    down[0] = -1.0;
    let first = Knot {
        state: walk.here().state.clone(),
        tangent: down,
        stress_rate: f64::NAN,
        arc: 0.0,
        residual: walk.here().residual,
    };
    let mut search = Search {
        scene,
        mechanics,
        index,
        report,
        meetings: Vec::new(),
        leaving: VecDeque::new(),
    };
    search.follow(diagram, "contact".to_owned(), Start::Point(first));
    // What leaves the symmetry of a part is found on the whole cell.
    if part.is_even() && !search.meetings.is_empty() && !cancel.requested() {
        let report = search.report;
        *diagram = Diagram {
            transforms: diagram.transforms,
            ..Diagram::default()
        };
        return fill(diagram, scene, Part::Whole, cancel, report);
    }
    while let Some(point) = search.leaving.pop_front() {
        if cancel.requested() {
            break;
        }
        let count = diagram.branches.len();
        let u0 = point.state.mean_displacement;
        if count == BRANCHES {
            diagram.missing.push(format!(
                "what leaves at u0 = {u0:.5} and {} more places, beyond {BRANCHES} branches",
                search.leaving.len()
            ));
            break;
        }
        if search
            .meetings
            .iter()
            .all(|m| m.joined || m.state != point.state)
        {
            continue;
        }
        let begin = Knot {
            tangent: point.mode,
            state: point.state,
            stress_rate: 0.0,
            arc: 0.0,
            residual: point.residual,
        };
        search.follow(diagram, format!("broken_{count}"), Start::Meeting(begin));
    }
    Ok(())
}

/// Where a branch can be left or met.
struct Place {
    state: State,
    /// True once the branch that leaves it is known.
    joined: bool,
}

/// Branches that are known, and where others leave them.
struct Search<'a> {
    scene: &'a Scene,
    mechanics: Mechanics,
    index: Index,
    report: Report<'a>,
    meetings: Vec<Place>,
    leaving: VecDeque<Point>,
}

impl Search<'_> {
    /// Follows one branch to its end, and notes where others leave it.
    fn follow(&mut self, diagram: &mut Diagram, name: String, from: Start) {
        let spent = self.mechanics.transforms() + self.index.transforms();
        let begin = match &from {
            Start::Meeting(knot) => Some(knot.state.clone()),
            Start::Point(_) => None,
        };
        // It may also come back to where it began.
        let others: Vec<usize> = (0..self.meetings.len())
            .filter(|i| !self.meetings[*i].joined)
            .collect();
        for place in &mut self.meetings {
            place.joined |= Some(&place.state) == begin.as_ref();
        }
        let states: Vec<State> = others
            .iter()
            .map(|i| self.meetings[*i].state.clone())
            .collect();
        let (scene, range) = (self.scene, self.mechanics.system.law().range);
        let mut reached = None;
        let mut end = |before: &Knot, after: &Knot| {
            if beyond(scene, before, after) {
                return Err(Ending::Window);
            }
            way_to(&states, &before.state, &after.state, range).map_err(|which| {
                reached = Some(others[which]);
                Ending::Joined
            })
        };
        let mut count = 0;
        let report = &mut *self.report;
        let (mut points, ending) = Tracer {
            mechanics: &mut self.mechanics,
            index: &mut self.index,
            report: &mut |knot: &Knot| {
                count += 1;
                report(&name, count, knot.state.mean_displacement);
            },
        }
        .follow(from, &mut end);
        for point in points.iter().filter(|p| p.kind == Kind::Bifurcation) {
            if point.index.contains(&0) {
                self.meetings.push(Place {
                    state: point.state.clone(),
                    joined: false,
                });
                self.leaving.push_back(point.clone());
            }
        }
        if let Some(state) = begin {
            let first = points.first().map_or(0, |p| p.index[0]);
            points.insert(0, meeting(state, None, first));
        }
        if let Some(i) = reached {
            self.meetings[i].joined = true;
            let state = self.meetings[i].state.clone();
            let last = points.last().map_or(0, |p| p.index[1]);
            let met = meeting(state, points.last(), last);
            points.push(met);
        }
        diagram.transforms += self.mechanics.transforms() + self.index.transforms() - spent;
        diagram.add(Branch {
            name,
            system: self.mechanics.system.clone(),
            points,
            ending,
        });
    }
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
