//! Scenes and their loops, for the tests of whole loops.
#![allow(dead_code, reason = "each suite uses its part")]

use tackscope::follow::record::{Direction, JumpRecord, StateRecord};
use tackscope::follow::run::{LoopRun, Outcome, run_loop};
use tackscope::follow::walk::{Observed, Progress, Walk, WalkOptions};
use tackscope::numerics::threads::Cancel;
use tackscope::physics::body::Body;
use tackscope::physics::control::Control;
use tackscope::physics::indenter::Indenter;
use tackscope::physics::law::{Law, Shape};
use tackscope::physics::pattern::Pattern;
use tackscope::physics::theory::{critical_length, flat_limits};
use tackscope::scene::{Cell, Drive, LawChoice, Part, Points, Range, Scene, Turn};
use tackscope::solver::Stop;
use tackscope::solver::methods::MethodKind;
use tackscope::storage;
use tackscope::study::plan::{plan, run_planned};

/// A built-in scene.
pub fn preset(name: &str) -> Scene {
    storage::resolve(name).unwrap()
}

/// The same on another mesh.
pub fn preset_on(name: &str, points: Points) -> Scene {
    let mut scene = preset(name);
    scene.cell.points = points;
    scene
}

/// The same scene driven so: start, turn and step.
pub fn driven(mut scene: Scene, control: Control, [start, turn, step]: [f64; 3]) -> Scene {
    let turn = Turn::At(turn);
    scene.drive = Drive {
        control,
        start,
        turn,
        step,
    };
    scene
}

/// By Newton-Krylov on this part of the cell.
pub fn on(part: Part) -> WalkOptions {
    WalkOptions {
        part,
        ..MethodKind::NewtonKrylov.into()
    }
}

/// A walk by Newton-Krylov, at rest at the start of its drive.
pub fn start(scene: &Scene, part: Part) -> Walk {
    Walk::start(scene, on(part), &Cancel::default()).unwrap()
}

/// What a walk brought on its way to a target.
pub struct Way {
    pub states: Vec<StateRecord>,
    pub jumps: Vec<JumpRecord>,
    pub end: Progress,
}

/// Walks to `target`, or until it cannot go on.
pub fn go(walk: &mut Walk, target: f64) -> Way {
    walk.set_target(target);
    let (mut states, mut jumps) = (Vec::new(), Vec::new());
    loop {
        let end = walk.step(&Cancel::default(), &mut |observed| match observed {
            Observed::State(state) => states.push(state),
            Observed::Jump(jump) => jumps.push(jump),
            Observed::Moving { .. } => {}
        });
        if end != Progress::Working {
            return Way { states, jumps, end };
        }
    }
}

/// Walks to `target` and rests there; the jumps on the way.
pub fn reach(walk: &mut Walk, target: f64) -> Vec<JumpRecord> {
    let way = go(walk, target);
    assert_eq!(way.end, Progress::Resting);
    assert_eq!(walk.surface().control, target);
    way.jumps
}

/// The patterns of a loop one way, from that before the first jump on.
pub fn sequence(run: &LoopRun, direction: Direction) -> Vec<Pattern> {
    let jumps = run.record.jumps.iter().filter(|j| j.direction == direction);
    let first = jumps.clone().take(1).map(|j| j.from);
    first.chain(jumps.map(|j| j.to)).collect()
}

/// Walked by Newton-Krylov to its end.
pub fn walked(scene: &Scene, part: Part) -> LoopRun {
    let run = run_loop(scene, on(part), &Cancel::default(), &mut |_| {}).unwrap();
    assert_eq!(run.outcome, Outcome::Completed, "{}", scene.title);
    run
}

/// Run as it is planned, to its end.
pub fn planned(scene: &Scene) -> LoopRun {
    let plan = plan(scene, &scene.model().unwrap(), None);
    let method = MethodKind::NewtonKrylov;
    let run = run_planned(scene, method, &plan, &Cancel::default(), &mut |_| {}).unwrap();
    assert_eq!(run.outcome, Outcome::Completed, "{}", scene.title);
    run
}

/// Holds every state of a loop to be a stable equilibrium within this residual.
pub fn assert_stable(run: &LoopRun, residual: f64) {
    for state in &run.record.states {
        assert_eq!(state.stop, Stop::Stable, "{state:?}");
        let good = state.residual <= residual && state.stiffness_min >= 0.0;
        assert!(good, "{state:?}");
    }
}

/// The loop integral and the sum of releases, in gamma.
pub fn accounts(scene: &Scene, run: &LoopRun) -> (f64, f64) {
    let work = run.record.work() / scene.law.surface_energy;
    (work, run.record.released_energy_sum())
}

/// Holds the jumps of two loops to be the same ones, each within so much of the control.
pub fn assert_same_jumps(ours: &[JumpRecord], theirs: &[JumpRecord], within: f64) {
    let route = |jumps: &[JumpRecord]| -> Vec<_> {
        let step = |jump: &JumpRecord| (jump.direction, jump.from, jump.to);
        jumps.iter().map(step).collect()
    };
    assert_eq!(route(ours), route(theirs));
    for (a, b) in ours.iter().zip(theirs) {
        assert!((a.control - b.control).abs() < within, "{a:?} {b:?}");
    }
}

/// L = `periods` L_c, driven from beyond every jump to half the way between the lower limit of the
/// flat state and its rest.
pub fn flat_ground(shape: Shape, periods: f64, points: Points) -> Scene {
    let law = Law {
        shape,
        surface_energy: 0.15,
        range: 1.0,
    };
    let length = periods * critical_length(&law);
    let (low, high) = flat_limits(&law, length).unwrap();
    Scene {
        title: String::new(),
        source: String::new(),
        cell: Cell { length, points },
        body: Body::HalfSpace,
        law: LawChoice {
            shape,
            surface_energy: law.surface_energy,
            range: Range::Length(law.range),
        },
        indenter: Indenter::Flat,
        drive: Drive {
            control: Default::default(),
            start: 2.2 * high + 1.0,
            turn: Turn::At(0.5 * (low + law.equilibrium_gap())),
            step: 0.2,
        },
        accuracy: 0.01,
        seed: 1,
        units: None,
    }
}
