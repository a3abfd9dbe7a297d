//! The diagram on uneven ground: the loop's own branch through all its folds, from the start of the
//! drive until it leaves its range.

use super::trace::{Start, Tracer};
use super::{Branch, Diagram, Ending, Report};
use crate::follow::walk::symmetry::slides_on;
use crate::follow::walk::{Walk, WalkOptions};
use crate::numerics::cancel::Cancel;
use crate::physics::parameter::Refusal;
use crate::scene::part::Part;
use crate::scene::{Scene, Turn};
use crate::solver::continuation::Knot;
use crate::solver::index::Index;

/// Follows the branch of the first state of the drive on `part` of the cell.
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
    let mut mechanics = walk.mechanics().clone();
    let mut index = Index::of_cell(&mechanics.system, slides_on(walk.model()), scene.seed);
    let mut down = vec![0.0; mechanics.system.dimension()];
    down[0] = -1.0;
    let from = Knot {
        state: walk.here().state.clone(),
        tangent: down,
        stress_rate: f64::NAN,
        arc: 0.0,
        residual: walk.here().residual,
    };
    let start = scene.drive.start;
    let (low, high) = match scene.drive.turn {
        Turn::At(turn) => (turn, start),
        Turn::ZeroLoad => (f64::NEG_INFINITY, start),
    };
    let mut beyond = |before: &Knot, after: &Knot| {
        let u0 = after.state.mean_displacement;
        // In contact, and unloaded: there a loop with the turn at zero load turns.
        let unloaded = scene.drive.turn == Turn::ZeroLoad
            && before.state.stress > 0.0
            && after.state.stress <= 0.0
            && after.rate() < 0.0;
        if u0 < low || u0 > high || unloaded {
            Err(Ending::Window)
        } else {
            Ok(f64::INFINITY)
        }
    };
    let mut points = 0;
    let (points, ending) = Tracer {
        mechanics: &mut mechanics,
        index: &mut index,
        report: &mut |knot: &Knot| {
            points += 1;
            report("contact", points, knot.state.mean_displacement);
        },
    }
    .follow(Start::Point(from), &mut beyond);
    diagram.transforms += mechanics.transforms() + index.transforms();
    if ending != Ending::Window {
        diagram.missing.push(format!(
            "the branch \"contact\" beyond {}: {ending}",
            points.len()
        ));
    }
    diagram.branches.push(
        Branch {
            name: "contact".to_owned(),
            system: mechanics.system,
            points,
            ending,
        }
        .classified(),
    );
    Ok(())
}
