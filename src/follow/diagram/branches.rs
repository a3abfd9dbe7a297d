//! Where the branches of a diagram begin.
//!
//! On flat ground the patterns come out of the flat state: the branch of ridges and that of square
//! patterns from its limits, then those that join them where a stable pattern breaks its symmetry.
//!
//! On uneven ground there is the branch of the first state of the drive, through all its folds until
//! it leaves the range of the drive, and the branches that leave it where it loses or gains its
//! stability.

use super::trace::{Ends, Meeting, Start, Tracer};
use super::{Branch, Diagram, Ending, Kind, Observe, Point};
use crate::follow::atlas::Meshes;
use crate::follow::walk::symmetry::slides_on;
use crate::follow::walk::{Walk, WalkOptions};
use crate::numerics::dense::norm;
use crate::numerics::threads::Cancel;
use crate::physics::control::Control;
use crate::physics::indenter::Indenter;
use crate::physics::low_block::{Class, LowBlock};
use crate::physics::mesh::Grid;
use crate::physics::parameter::Refusal;
use crate::physics::pattern::Pattern;
use crate::physics::preconditioner::class_reach;
use crate::physics::system::{State, System, carried};
use crate::physics::theory::{critical_length, flat_limits};
use crate::scene::{Model, Part, Scene, Turn};
use crate::solver::continuation::{Knot, way};
use crate::solver::index::{Index, Symmetry};
use crate::solver::mechanics::Mechanics;
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// Points of the flat state, at least three between two of its bifurcations.
const FLAT_POINTS: usize = 800;
/// Longest reach of the exact block of a preconditioner: more costs more to factorise than it saves
/// in products.
const MOST_REACH: f64 = 14.0;
/// A branch that is lost so near to where another is left (ranges) has met it: a ridge is known on
/// a finer mesh than what joins it, and its break-up lies a little beside the one of that.
const ABOUT: f64 = 0.5;

/// Most mixed branches that are followed: the paper's scenes have two, a mesh that traps edges
/// breaks symmetries at every spacing.
const MIXED: usize = 6;

/// Of branches of one symmetry on one mesh.
fn tracer(
    model: &Model,
    grid: Grid,
    symmetry: Symmetry,
    control: Control,
    cancel: &Cancel,
) -> Tracer {
    let system = System::even(grid, model.law, &Indenter::Flat).with_body(model.body);
    let class = match symmetry {
        Symmetry::Square => Class::Symmetric,
        _ => Class::Even,
    };
    let index = Index::of_symmetry(&system, symmetry);
    let reach = class_reach(&system, MOST_REACH);
    let mut mechanics = Mechanics::of_class(system, class, reach);
    mechanics.cancel = cancel.clone();
    Tracer {
        mechanics,
        index,
        control,
    }
}

/// All branches of a flat scene.
pub(super) fn on_flat_ground(
    diagram: &mut Diagram,
    scene: &Scene,
    model: &Model,
    cancel: &Cancel,
    observe: Observe<'_>,
) {
    let (length, control) = (model.grid.length, diagram.control);
    diagram.branches.push(flat_state(scene, model, control));
    let Some(limits) = flat_limits(&model.law, model.equivalent_length) else {
        return;
    };
    if !model.body.is_softest_at_its_longest(&model.grid) {
        let what = "patterns of a layer whose softest wave is not the longest of the cell";
        diagram.missing.push(what.to_owned());
        return;
    }
    // The quarter of the cell has an even number of points along a side.
    let n = model.grid.nx.next_multiple_of(8);
    let meshes = Meshes::new(&model.law, length, n);
    let line = Grid::line(length, meshes.line);
    let square = Grid::square(length, n);
    let primary: &[_] = if model.grid.is_line() {
        &[("ridge", Grid::line(length, n), Symmetry::Line)]
    } else {
        &[
            ("square", square, Symmetry::Square),
            ("ridge", line, Symmetry::Ridge),
        ]
    };
    for (name, grid, symmetry) in primary {
        if !cancel.requested() {
            let mut tracer = tracer(model, *grid, *symmetry, control, cancel);
            from_flat(diagram, &mut tracer, name, limits, observe);
        }
    }
    if !model.grid.is_line() {
        let mut tracer = tracer(model, square, Symmetry::Even, control, cancel);
        joining(diagram, &mut tracer, observe);
    }
}

/// The closed form between the ends of the drive, with the bifurcations of all waves and the folds
/// of the control, where the body moves as a block.
fn flat_state(scene: &Scene, model: &Model, control: Control) -> Branch {
    let (law, length) = (model.law, model.grid.length);
    let system = System::even(
        Grid::line(length, model.grid.nx.next_multiple_of(4)),
        law,
        &Indenter::Flat,
    );
    let (start, turn) = match scene.drive.turn {
        Turn::At(turn) => (scene.drive.start, turn),
        Turn::ZeroLoad => (scene.drive.start, law.equilibrium_gap()),
    };
    // Waves that can soften and that the mesh has, by the square of their number of periods, with
    // how many there are of each. A layer is stiffer to each than a half-space.
    let softest = (length / critical_length(&law)).floor() as i64;
    let most = softest.min(model.grid.nx as i64 / 2);
    let across = if model.grid.is_line() { 0 } else { most };
    let mut waves: BTreeMap<i64, usize> = BTreeMap::new();
    for k in -most..=most {
        for l in -across..=across {
            if k * k + l * l > 0 {
                *waves.entry(k * k + l * l).or_default() += 1;
            }
        }
    }
    let equivalent = |(square, many): (i64, usize)| {
        let periods = (square as f64).sqrt();
        (model.body.equivalent(&model.grid, periods), many)
    };
    let waves: Vec<(f64, usize)> = waves.into_iter().map(equivalent).collect();
    let index = |u0: f64| {
        let stiffness = law.at(u0).stiffness;
        let soft = waves.iter().filter(|(length, _)| -length * stiffness > PI);
        let soft: usize = soft.map(|(_, many)| many).sum();
        soft + usize::from(control.softens([1.0, stiffness]))
    };
    // A machine softens as the longest wave of some cell does.
    let mut places: Vec<(f64, Kind)> = waves
        .iter()
        .map(|(length, _)| (*length, Kind::Bifurcation))
        .chain([(PI / control.stiffness(), Kind::Fold)])
        .filter_map(|(length, kind)| Some((flat_limits(&law, length)?, kind)))
        .flat_map(|((low, high), kind)| [(low, kind), (high, kind)])
        .filter(|(u0, _)| turn < *u0 && *u0 < start)
        .chain([(start, Kind::Regular), (turn, Kind::Regular)])
        .collect();
    places.sort_by(|a, b| b.0.total_cmp(&a.0));
    let between = (FLAT_POINTS / places.len()).max(3);
    let mut points = Vec::new();
    for pair in places.windows(2) {
        let ((high, kind), (low, _)) = (pair[0], pair[1]);
        let within = index(0.5 * (high + low));
        let above = points.last().map_or(within, |p: &Point| p.index[1]);
        points.push(uniform(model, high, start - high, kind, [above, within]));
        for i in 1..between {
            let u0 = high + (low - high) * i as f64 / between as f64;
            points.push(uniform(model, u0, start - u0, Kind::Regular, [within; 2]));
        }
    }
    let last = points.last().map_or(0, |p| p.index[1]);
    points.push(uniform(model, turn, start - turn, Kind::Regular, [last; 2]));
    Branch {
        name: "flat".to_owned(),
        system,
        points,
        ending: Ending::Window,
    }
}

/// The uniform state at a gap, downwards along the flat branch.
fn uniform(model: &Model, u0: f64, arc: f64, kind: Kind, index: [usize; 2]) -> Point {
    let response = model.law.at(u0);
    Point {
        state: State {
            control: u0,
            mean_displacement: u0,
            amplitudes: Vec::new(),
            energy: response.energy,
            stress: response.traction,
        },
        arc,
        rates: [-1.0, -response.stiffness],
        kind,
        index,
        pattern: Pattern::Flat,
        residual: 0.0,
        class: None,
        mode: Vec::new(),
    }
}

/// The branch that leaves the flat state at its upper limit, back to it; where it is lost on the
/// way also from the lower limit.
fn from_flat(
    diagram: &mut Diagram,
    tracer: &mut Tracer,
    name: &str,
    (low, high): (f64, f64),
    observe: Observe<'_>,
) {
    let system = tracer.mechanics.system.clone();
    let mut mode = vec![0.0; system.dimension()];
    let ny = system.shape().0;
    if ny > 1 {
        (mode[1], mode[ny]) = (FRAC_1_SQRT_2, FRAC_1_SQRT_2);
    } else {
        mode[1] = 1.0;
    }
    for (limit, other, name) in [
        (high, low, name.to_owned()),
        (low, high, format!("{name}_2")),
    ] {
        let [flat, other] = [limit, other].map(|u0| system.uniform(u0).state);
        let begin = Meeting {
            state: flat,
            mode: mode.clone(),
            residual: 0.0,
            joined: false,
        };
        let ends = Ends {
            others: &|_| vec![other.clone()],
            met: Ending::Flat,
            about: 0.0,
            beyond: &|_, _| false,
        };
        let met = diagram.follow(tracer, name, begin.leave(), &ends, observe);
        if met.is_some() || tracer.mechanics.cancel.requested() {
            break;
        }
    }
}

/// Where a piece of a branch that is stable at fixed u0 breaks its symmetry along y, in the system
/// of the branch that leaves it there.
fn break_up(branch: &Branch, point: &Point, tracer: &Tracer) -> Option<Meeting> {
    let (class, to) = (point.class?, &tracer.mechanics.system);
    let breaks = matches!(class, Class::Antisymmetric | Class::Varicose(1));
    if !breaks || !point.bounds_stable(tracer.control) {
        return None;
    }
    let waves = LowBlock::new(&branch.system, class, f64::INFINITY);
    let state = State {
        amplitudes: carried(&point.state.amplitudes, &branch.system, to),
        ..point.state.clone()
    };
    Some(Meeting {
        mode: waves.mode(&point.mode, to),
        residual: point.residual,
        state,
        joined: false,
    })
}

/// The branches of states that are even and no more, from each end of a stable piece where its
/// symmetry breaks to another one.
fn joining(diagram: &mut Diagram, tracer: &mut Tracer, observe: Observe<'_>) {
    let mut meetings: Vec<Meeting> = diagram
        .events()
        .filter_map(|(branch, point)| break_up(branch, point, tracer))
        .collect();
    let mut count = 0;
    for i in 0..meetings.len() {
        if meetings[i].joined || tracer.mechanics.cancel.requested() {
            continue;
        }
        if count == MIXED {
            let left = meetings.iter().filter(|m| !m.joined).count();
            diagram.missing.push(format!(
                "what leaves {left} more break-ups, beyond {MIXED} mixed branches"
            ));
            break;
        }
        meetings[i].joined = true;
        count += 1;
        let others: Vec<usize> = (0..meetings.len())
            .filter(|j| !meetings[*j].joined)
            .collect();
        let ends = Ends {
            others: &|at| {
                let image = |j: &usize| nearest_image(&meetings[*j].state, &at.amplitudes);
                others.iter().map(image).collect()
            },
            met: Ending::Joined,
            about: ABOUT,
            beyond: &|_, _| false,
        };
        let (name, from) = (format!("mixed_{count}"), meetings[i].leave());
        if let Some(which) = diagram.follow(tracer, name, from, &ends, observe) {
            meetings[others[which]].joined = true;
        }
    }
}

/// The image of an even state, with x and y exchanged or moved by half a cell, that is nearest to
/// the amplitudes `z`.
fn nearest_image(state: &State, z: &[f64]) -> State {
    let n = z.len().isqrt();
    let image = |exchange: bool, flip: [bool; 2]| {
        let at = |i: usize| {
            let (k, l) = (i / n, i % n);
            let odd = (flip[0] && k % 2 == 1) != (flip[1] && l % 2 == 1);
            let from = state.amplitudes[if exchange { l * n + k } else { i }];
            if odd { -from } else { from }
        };
        let amplitudes = (0..z.len()).map(at).collect();
        State {
            amplitudes,
            ..state.clone()
        }
    };
    let flips = [[false; 2], [true, false], [false, true], [true; 2]];
    let images = [false, true]
        .into_iter()
        .flat_map(|exchange| flips.map(|flip| image(exchange, flip)));
    let far = |image: &State| norm(&way(image.joint(), (z, state.mean_displacement)));
    images
        .min_by(|a, b| far(a).total_cmp(&far(b)))
        .expect("there are eight")
}

/// Most branches that are followed on uneven ground: rough ground has as many as its crests can be in contact in
/// different orders.
const BRANCHES: usize = 12;

/// Follows the branch of the first state of the drive on `part` of the cell, and what leaves it.
pub(super) fn on_uneven_ground(
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
            return on_uneven_ground(diagram, scene, Part::Whole, cancel, observe);
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
