//! What one increment of the walk takes on finer and finer meshes, as a table: `cargo bench
//! --no-default-features --bench increments`, on some of the meshes only with `-- 64 512` behind
//! it.
//!
//! All start from one dimple of Fig. 2, found on the coarsest mesh and carried to the finer ones.
//!
//! With `-- tip` behind it (and meshes): the whole loop over the Hertzian tip at mu_rho = 0.5, whose
//! range shrinks with the mesh, in transforms a state.

use cpu_time::ProcessTime;
use std::time::Instant;
use tackscope::follow::record::StateRecord;
use tackscope::follow::run::Itinerary;
use tackscope::follow::walk::{Observed, Progress, Walk, WalkOptions};
use tackscope::numerics::cancel::Cancel;
use tackscope::numerics::precision::Precision;
use tackscope::physics::system::System;
use tackscope::scene::part::Part;
use tackscope::scene::{Points, Scene};
use tackscope::solver::branch::History;
use tackscope::solver::equilibrium::Equilibrium;
use tackscope::solver::mechanics::{Mechanics, Slides};
use tackscope::solver::method::Method;
use tackscope::solver::methods::MethodKind;
use tackscope::storage::{presets, scene_file};

const COARSE: usize = 64;
const STEP: f64 = 0.02;
/// Increments before counting begins, so that the predictor has a past, and counted ones.
const WARM: usize = 4;
const COUNTED: usize = 5;

fn scene(n: usize) -> Scene {
    let mut scene =
        scene_file::parse(presets::find("fig2").expect("built in").text, "fig2").expect("valid");
    scene.cell.points = Points::Square(n);
    scene.drive.step = STEP;
    scene
}

/// Walks to `u0`; the records on the way.
fn walked(walk: &mut Walk, u0: f64) -> Vec<StateRecord> {
    walk.set_target(u0);
    let mut states = Vec::new();
    loop {
        match walk.step(&Cancel::default(), &mut |news| {
            states.extend(if let Observed::State(s) = news {
                Some(s)
            } else {
                None
            });
        }) {
            Progress::Working => {}
            Progress::Resting => return states,
            other => panic!("{other:?}"),
        }
    }
}

/// Amplitudes on n x n points, from those on [`COARSE`] without its last waves.
fn carried(z: &[f64], n: usize) -> Vec<f64> {
    let mut out = vec![0.0; (n / 2 + 1) * n * 2];
    let half = COARSE as i64 / 2;
    for k in 0..half {
        for l in 1 - half..half {
            let pair = |n: usize| 2 * (k as usize * n + l.rem_euclid(n as i64) as usize);
            out[pair(n)..pair(n) + 2].copy_from_slice(&z[pair(COARSE)..pair(COARSE) + 2]);
        }
    }
    out
}

/// One increment by `method` along the branch of `states`, and nothing else: no check of stability.
fn relaxed(
    name: &'static str,
    mut method: Box<dyn Method>,
    n: usize,
    states: &[Equilibrium],
) -> Row {
    let model = scene(n).model().expect("valid");
    let system = System::new(model.grid, model.law, &model.indenter);
    let mut mechanics = Mechanics::new(system, Slides::Freely);
    let mut history = History::default();
    states.iter().for_each(|state| history.push(&state.state));
    let from = states.last().expect("a state");
    mechanics.refresh(&from.fields);
    let (wall, processor) = (Instant::now(), ProcessTime::now());
    let to = from.state.mean_displacement + STEP;
    let cost = method
        .follow(&mut mechanics, &history, from, to)
        .expect("stays on its branch")
        .cost;
    Row {
        name,
        transforms: cost.transforms as f64,
        iterations: cost.iterations as f64,
        seconds: wall.elapsed().as_secs_f64(),
        processor_seconds: processor.elapsed().as_secs_f64(),
        states: Vec::new(),
    }
}

struct Row {
    name: &'static str,
    transforms: f64,
    iterations: f64,
    seconds: f64,
    processor_seconds: f64,
    /// Where it came by before counting began.
    states: Vec<Equilibrium>,
}

/// The mean over counted increments of Newton's method in the walk with some numbers, checks of
/// stability and all, from a state of the coarse mesh.
fn increment(n: usize, precision: Precision, (state, record): &(Equilibrium, StateRecord)) -> Row {
    let mut state = Equilibrium {
        soft_mode: Vec::new(),
        ..state.clone()
    };
    state.state.amplitudes = carried(&state.state.amplitudes, n);
    let start = state.state.mean_displacement;
    let walk = Walk::start(
        &scene(n),
        WalkOptions {
            part: Part::Whole,
            precision,
            ..MethodKind::NewtonKrylov.into()
        },
        &Cancel::default(),
    )
    .expect("valid");
    let mut walk = walk.standing_on(state, record.clone());
    // Up towards the dimple's limit.
    let place = |increments: usize| start + STEP * increments as f64;
    let mut reached = Vec::new();
    for warm in 1..=WARM {
        walked(&mut walk, place(warm));
        reached.push(walk.here().clone());
    }
    let (wall, processor) = (Instant::now(), ProcessTime::now());
    let states = walked(&mut walk, place(WARM + COUNTED));
    let (seconds, processor_seconds) = (
        wall.elapsed().as_secs_f64(),
        processor.elapsed().as_secs_f64(),
    );
    let mean = |total: f64| total / COUNTED as f64;
    Row {
        name: precision.word(),
        transforms: mean(states.iter().map(|s| s.transforms as f64).sum()),
        iterations: mean(states.iter().map(|s| s.iterations as f64).sum()),
        seconds: mean(seconds),
        processor_seconds: mean(processor_seconds),
        states: reached,
    }
}

/// The loop over the tip on a part of the cell: transforms a state of Newton's method, of proofs of
/// stability, and of all. What is neither is modes followed, jumps and steps not taken.
fn tip(n: usize, part: Part) {
    let mut scene = presets::resolve("hertz").expect("built in");
    scene.cell.points = Points::Square(n);
    scene.drive.step = 0.001;
    let options = WalkOptions {
        part,
        ..MethodKind::NewtonKrylov.into()
    };
    let cancel = Cancel::default();
    let mut walk = Walk::start(&scene, options, &cancel).expect("valid");
    let mut itinerary = Itinerary::closed(&scene);
    let (mut states, mut newton) = (0, 0);
    let (begun, before) = (ProcessTime::now(), walk.counts());
    while let Some(target) = itinerary.target() {
        walk.set_target(target);
        let mut taken = 0;
        let progress = walk.step(&cancel, &mut |news| {
            taken += usize::from(matches!(news, Observed::State(_)));
        });
        assert!(
            matches!(progress, Progress::Working | Progress::Resting),
            "{progress:?}"
        );
        states += taken;
        newton += taken * walk.here().cost.transforms;
        itinerary.step(&progress, walk.record());
    }
    let (seconds, counts) = (begun.elapsed().as_secs_f64(), walk.counts());
    let mean = |total: usize| total as f64 / states as f64;
    println!(
        "{:7} {n:5}  {states:6}  {:6.1}  {:6.1}  {:6.1}  {seconds:17.1}",
        part.word(),
        mean(newton),
        mean(counts.proof_transforms - before.proof_transforms),
        mean(counts.transforms - before.transforms),
    );
}

fn main() {
    // `cargo test` runs this too, only to see that it compiles.
    if !std::env::args().any(|argument| argument == "--bench") {
        return;
    }
    let asked: Vec<usize> = std::env::args()
        .filter_map(|argument| argument.parse().ok())
        .collect();
    if std::env::args().any(|argument| argument == "tip") {
        println!("part        n  states  newton  proofs     all  processor seconds");
        for n in [64, 128, 256, 512] {
            if asked.is_empty() || asked.contains(&n) {
                tip(n, Part::Quarter);
                tip(n, Part::Whole);
            }
        }
        return;
    }
    let mut walk = Walk::start(
        &scene(COARSE),
        MethodKind::NewtonKrylov.into(),
        &Cancel::default(),
    )
    .expect("valid");
    walked(&mut walk, 0.3);
    walked(&mut walk, 1.8);
    let start = (walk.here().clone(), walk.record().clone());
    println!("a {}", walk.record().pattern);
    println!(
        "double, mixed, single: the walk with these numbers; newton: its method alone; paper: 200 time steps alone"
    );
    println!("what        n  transforms  iterations  wall ms  processor ms");
    for n in [64, 128, 256, 512, 1024]
        .into_iter()
        .filter(|n| asked.is_empty() || asked.contains(n))
    {
        let newton = shown(n, increment(n, Precision::Double, &start));
        for precision in [Precision::Mixed, Precision::Single] {
            let row = shown(n, increment(n, precision, &start));
            println!(
                "double over {}: {:.2} in processor time",
                row.name,
                newton.processor_seconds / row.processor_seconds
            );
        }
        let alone = shown(
            n,
            relaxed(
                "newton",
                MethodKind::NewtonKrylov.build(1),
                n,
                &newton.states,
            ),
        );
        if [64, 512].contains(&n) {
            let paper = shown(
                n,
                relaxed("paper", MethodKind::Gfmd.build(1), n, &newton.states),
            );
            let ratio = |other: &Row| paper.processor_seconds / other.processor_seconds;
            println!(
                "paper over double: {:.1}, over newton alone: {:.1} in processor time",
                ratio(&newton),
                ratio(&alone)
            );
        }
    }
}

fn shown(n: usize, row: Row) -> Row {
    let (seconds, processor_seconds) = (1e3 * row.seconds, 1e3 * row.processor_seconds);
    println!(
        "{:7} {n:5}  {:10.1}  {:10.1}  {seconds:7.1}  {processor_seconds:12.1}",
        row.name, row.transforms, row.iterations
    );
    row
}
