//! Whole computations in units of the transform, as a table: `cargo bench --no-default-features
//! --bench table`, or with words behind `--` the lines whose names have one of them (`-- growth`,
//! `-- "run fig2" memory`). Lines that take more than some seconds want to be named.
//!
//! A *pair* is the duration of one forward and one back transform of 64 x 64 points on one thread,
//! measured before and after each line: machines differ, and from minute to minute, their ratio hardly
//! does. Pairs are of processor time.
//! An increment is one state of a walk, with Newton's method, the proof that it is stable, modes
//! followed, jumps and steps not taken.

use cpu_time::ProcessTime;
use ndarray::Array2;
use std::process::{Command, Stdio};
use std::time::Instant;
use tackscope::follow::atlas::Atlas;
use tackscope::follow::diagram::Diagram;
use tackscope::follow::record::StateRecord;
use tackscope::follow::run::Itinerary;
use tackscope::follow::walk::{Observed, Progress, Walk, WalkOptions};
use tackscope::numerics::fourier::Fourier;
use tackscope::numerics::precision::Precision;
use tackscope::numerics::threads::Cancel;
use tackscope::paper::scenes::{self, Order};
use tackscope::paper::{Size, Task};
use tackscope::physics::system::System;
use tackscope::scene::{Part, Points, Range, Scene, Turn};
use tackscope::solver::mechanics::{Mechanics, Slides};
use tackscope::solver::method::{Equilibrium, History};
use tackscope::solver::methods::MethodKind;
use tackscope::storage;
use tackscope::study::landscape::{Ground, Landscape, Standing};
use tackscope::study::live_loop::{Fineness, LiveLoops};
use tackscope::study::map::PatternMap;

/// Runs of a line that is quick, of which the median counts.
const RUNS: usize = 9;
/// Pairs timed together.
const PAIRS: usize = 2000;
/// Points of the mesh on which states of flat ground are found, before they are carried to another.
const COARSE: usize = 64;
/// Increments before counting begins, so that the predictor has a past, and counted ones.
const WARM: usize = 4;
const COUNTED: usize = 5;
/// Steps of u0 on flat ground and over the tip.
const STEP: f64 = 0.02;
const TIP_STEP: f64 = 0.001;
/// Meshes of the tables of growth.
const GROWTH: [usize; 5] = [64, 128, 256, 512, 1024];

/// What a computation took.
#[derive(Clone, Default)]
struct Spent {
    /// Processor time and time on the wall (s).
    processor: f64,
    wall: f64,
    /// 0 where they are not counted: those of all, of Newton's method, of proofs of stability, and of
    /// a coarser mesh than the walk's.
    transforms: usize,
    newton: usize,
    proofs: usize,
    coarse: usize,
    /// States of a walk, 0 of anything else.
    increments: usize,
    /// What else is to be said.
    note: String,
}

/// Takes the time of `work`, which returns its transforms.
fn timed(work: impl FnOnce() -> usize) -> Spent {
    let (wall, processor) = (Instant::now(), ProcessTime::now());
    let transforms = work();
    Spent {
        processor: processor.elapsed().as_secs_f64(),
        wall: wall.elapsed().as_secs_f64(),
        transforms,
        ..Spent::default()
    }
}

/// A line of the table.
struct Line {
    name: String,
    /// Of which the median counts. One that is run once wants to be named.
    runs: usize,
    work: Box<dyn FnMut() -> Spent>,
}

fn quick(name: impl Into<String>, work: impl FnMut() -> Spent + 'static) -> Line {
    Line {
        name: name.into(),
        runs: RUNS,
        work: Box::new(work),
    }
}

fn slow(name: impl Into<String>, work: impl FnMut() -> Spent + 'static) -> Line {
    Line {
        runs: 1,
        ..quick(name, work)
    }
}

fn main() {
    // `cargo test` runs this too, only to see that it compiles.
    let words: Vec<String> = std::env::args().skip(1).collect();
    if !words.iter().any(|word| word == "--bench") {
        return;
    }
    let words: Vec<_> = words
        .into_iter()
        .filter(|word| !word.starts_with("--"))
        .collect();
    let lines = [loops(), around(), programs(), walks(), growth()];
    let (mut chosen, left): (Vec<Line>, Vec<Line>) =
        lines.into_iter().flatten().partition(|line| {
            let named = words.iter().any(|word| line.name.contains(word.as_str()));
            named || words.is_empty() && line.runs > 1
        });
    if chosen.is_empty() {
        left.iter().for_each(|line| println!("{}", line.name));
        return;
    }
    println!(
        "{:<46} {:>7} {:>9} {:>10} {:>10} {:>10} {:>5}  an increment: ms, transforms (Newton, proofs; of a coarser mesh)",
        "", "pair us", "pairs", "proc. ms", "wall ms", "transforms", "incr."
    );
    chosen.iter_mut().for_each(show);
}

/// Runs a line and prints it.
fn show(Line { name, runs, work }: &mut Line) {
    let before = pair();
    let mut all: Vec<Spent> = (0..*runs).map(|_| work()).collect();
    let pair = 0.5 * (before + pair());
    all.sort_by(|a, b| a.processor.total_cmp(&b.processor));
    let spent = all[*runs / 2].clone();
    let count = |n: usize| {
        if n == 0 {
            "-".to_owned()
        } else {
            n.to_string()
        }
    };
    print!(
        "{name:<46} {:>7.1} {:>9.0} {:>10.1} {:>10.1} {:>10} {:>5}",
        1e6 * pair,
        spent.processor / pair,
        1e3 * spent.processor,
        1e3 * spent.wall,
        count(spent.transforms),
        count(spent.increments)
    );
    if spent.increments > 0 {
        let mean = |total: usize| total as f64 / spent.increments as f64;
        print!(
            "  {:8.2} {:6.1} ({:.1}, {:.1}; {:.1})",
            1e3 * spent.processor / spent.increments as f64,
            mean(spent.transforms),
            mean(spent.newton),
            mean(spent.proofs),
            mean(spent.coarse)
        );
    }
    println!("{}", spent.note);
}

/// The duration of a pair (s).
fn pair() -> f64 {
    let plan = Fourier::new(64, 64);
    let mut field = Array2::from_shape_fn((64, 64), |(j, i)| (i * 7 + j * 3) as f64 % 11.0);
    let (mut spectrum, mut scratch) = (plan.spectrum(), plan.scratch());
    let mut times = [0.0; RUNS].map(|_| {
        let spent = timed(|| {
            for _ in 0..PAIRS {
                plan.forward(&field, &mut spectrum, &mut scratch);
                plan.inverse(&mut spectrum, &mut field, &mut scratch);
            }
            2 * PAIRS
        });
        spent.processor / PAIRS as f64
    });
    times.sort_by(f64::total_cmp);
    times[RUNS / 2]
}

/// A preset on `n` points a side.
fn on(preset: &str, n: usize) -> Scene {
    let mut scene = storage::resolve(preset).expect("built in");
    scene.cell.points = Points::Square(n);
    scene
}

/// The whole loop by the atlas, made afresh, and adapted after a change of the range by 1 %.
fn loops() -> Vec<Line> {
    let atlas = |scene: &Scene| Atlas::of(scene, &scene.model().expect("allowed"));
    let round = |atlas: &mut Atlas, scene: &Scene| {
        let Turn::At(turn) = scene.drive.turn else {
            unreachable!("it has a turning point")
        };
        atlas.cycle(scene.drive.start, turn).expect("a loop");
        atlas.transforms().iter().sum::<usize>()
    };
    let mut lines = Vec::new();
    for (preset, n) in [("fig2", 48), ("fig2", 64), ("fig3", 192)] {
        let cold = on(preset, n);
        lines.push(quick(
            format!("{preset}, n = {n}, loop by the atlas, cold"),
            move || timed(|| round(&mut atlas(&cold), &cold)),
        ));
        let (mut known, scene) = (None, on(preset, n));
        lines.push(quick(
            format!("{preset}, n = {n}, loop by the atlas, warm"),
            move || {
                let known = known.get_or_insert_with(|| {
                    let mut known = atlas(&scene);
                    round(&mut known, &scene);
                    known
                });
                let mut changed = scene.clone();
                changed.law.range = Range::Length(1.01);
                let meshes = *atlas(&changed).meshes();
                timed(|| {
                    let mut adapted = known.adapted(meshes).expect("the same branches");
                    round(&mut adapted, &changed)
                })
            },
        ));
    }
    lines
}

/// What the window computes beside a loop.
fn around() -> Vec<Line> {
    let mut lines = vec![quick("fig2, first live loop", || {
        let scene = on("fig2", 64);
        let model = scene.model().expect("allowed");
        timed(|| {
            let found = LiveLoops::default().next(&scene, &model, Fineness::Coarse);
            found.expect("a loop");
            0
        })
    })];
    let (mut live, mut scene) = (LiveLoops::default(), on("fig2", 64));
    lines.push(quick("fig2, live loop, range changed by 1 %", move || {
        let was = scene.law.range == Range::Length(1.0);
        scene.law.range = Range::Length(if was { 1.01 } else { 1.0 });
        let model = scene.model().expect("allowed");
        timed(|| {
            live.next(&scene, &model, Fineness::Coarse).expect("a loop");
            0
        })
    }));
    lines.push(slow("fig2, map of 100 loops, range .8 to 1.2", || {
        let vary = "law.range=0.8..1.2".parse().expect("a parameter");
        let cancel = &Cancel::default();
        timed(|| {
            let map = PatternMap::of(&on("fig2", 64), &vary, 100, cancel, &mut |_, _| {});
            assert_eq!(map.expect("allowed").missing().count(), 0);
            0
        })
    }));
    for n in [48, 64] {
        lines.push(slow(format!("fig2, n = {n}, whole diagram"), move || {
            timed(|| whole_diagram(&on("fig2", n)).transforms)
        }));
    }
    lines.push(slow("fig2, n = 48, saddles and paths at 3.5", || {
        landscape(false)
    }));
    lines.push(slow("the same with the barriers along the drive", || {
        landscape(true)
    }));
    lines
}

fn whole_diagram(scene: &Scene) -> Diagram {
    let report = &mut |_: &str, _: usize, _: f64| {};
    let found = Diagram::of(scene, Part::Whole, &Cancel::default(), report).expect("allowed");
    assert!(found.is_complete(), "{:?}", found.missing);
    found
}

/// The saddles around the bulge with their paths, and the barriers along the drive.
fn landscape(barriers: bool) -> Spent {
    let (scene, cancel) = (on("fig2", 48), Cancel::default());
    let (model, diagram) = (scene.model().expect("allowed"), whole_diagram(&scene));
    let ground = Ground {
        scene: &scene,
        model: &model,
        diagram: &diagram,
        cancel: &cancel,
    };
    let bulge = diagram
        .pieces(0)
        .find(|piece| piece.holds(3.5) && piece.branch.name == "square");
    let bulge = Standing::on(&bulge.expect("it is there"), 3.5);
    timed(|| {
        let found = if barriers {
            let found = Landscape::around(ground, bulge, None, &mut |_, _| {});
            found.expect("not cancelled").passes.len()
        } else {
            ground.saddles(3.5).expect("not cancelled").found.len()
        };
        assert_eq!(found, 2);
        0
    })
}

/// The program as it is called, with all that it writes.
fn programs() -> Vec<Line> {
    let called = |arguments: &'static [&'static str]| {
        let name = format!("tackscope {}", arguments.join(" "));
        (name, move || child(arguments))
    };
    let mut lines = Vec::new();
    for arguments in [
        ["run", "fig2"].as_slice(),
        &["run", "fig2", "--fields", "all"],
    ] {
        let (name, work) = called(arguments);
        lines.push(quick(name, work));
    }
    for arguments in [
        ["run", "fig3"].as_slice(),
        &["run", "fig3", "--fields", "all"],
        &["figure", "all", "--quick"],
    ] {
        let (name, work) = called(arguments);
        lines.push(slow(name, work));
    }
    lines
}

/// Runs the program in a folder of its own.
fn child(arguments: &[&str]) -> Spent {
    let folder = tempfile::tempdir().expect("a folder");
    let mut command = Command::new(env!("CARGO_BIN_EXE_tackscope"));
    command.args(arguments).arg("--quiet").arg("--out");
    command
        .arg(folder.path())
        .stdin(Stdio::null())
        .stdout(Stdio::null());
    let before = of_children();
    let mut spent = timed(|| {
        assert!(command.status().expect("it runs").success());
        0
    });
    spent.processor = of_children() - before;
    let counted = std::fs::read(folder.path().join("summary.json"))
        .ok()
        .and_then(|bytes| serde_json::from_slice::<serde_json::Value>(&bytes).ok());
    if let Some(summary) = counted {
        spent.transforms = summary["counts"]["transforms"].as_u64().unwrap_or(0) as usize;
    }
    spent
}

/// Processor time of all programs that were run so far (s), to a hundredth; not known but on Linux.
fn of_children() -> f64 {
    /// Clock ticks a second, on every Linux.
    const TICKS: f64 = 100.0;
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // After the name in brackets, which may have blanks, the state is the third field.
    let fields = stat.rsplit(')').next().unwrap_or_default();
    let ticks = fields.split_whitespace().skip(13).take(2);
    ticks
        .map(|ticks| ticks.parse::<f64>().unwrap_or(f64::NAN) / TICKS)
        .sum()
}

/// Whole loops and single increments of the walk.
fn walks() -> Vec<Line> {
    let mut lines = Vec::new();
    for part in [Part::Quarter, Part::Whole] {
        for n in [64, 128, 256, 512] {
            let name = format!("tip, mu_rho .5, n = {n}, {} cell, loop", part.word());
            let work = move || tip(n, part, None);
            lines.push(if n * n <= 64 * 64 {
                quick(name, work)
            } else {
                slow(name, work)
            });
        }
    }
    for mu_rho in [0.5, 1.0, 2.0] {
        lines.push(slow(
            format!("tip, mu_rho {mu_rho}, n = 512, loop of Fig. 13"),
            move || {
                let cancel = Cancel::default();
                let quiet = &mut |_: f64, _: &str| {};
                let mut task = Task::new(Size::Full, &cancel, quiet);
                timed(|| {
                    scenes::run(&Order::new(mu_rho, 512), &mut task).expect("a loop");
                    0
                })
            },
        ));
    }
    for start in [&BULGE, &RIDGE] {
        lines.push(slow(
            format!("fig2, n = 512, {}, whole cell, increments", start.0),
            move || increment(512, Precision::Double, start),
        ));
    }
    lines.push(slow("memory: ridge, whole cell, n = 2048", || {
        let spent = increment(2048, Precision::Double, &RIDGE);
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let peak = status.lines().find(|line| line.starts_with("VmHWM"));
        Spent {
            note: format!("  {}", peak.unwrap_or("peak not known")),
            ..spent
        }
    }));
    lines
}

/// Transforms and time of an increment on finer and finer meshes.
fn growth() -> Vec<Line> {
    let mut lines = Vec::new();
    for n in GROWTH {
        lines.push(slow(format!("growth, flat ground, n = {n}"), move || {
            increment(n, Precision::Double, &DIMPLE)
        }));
    }
    for n in GROWTH {
        lines.push(slow(
            format!("growth, tip, mu_rho .5, n = {n}"),
            move || tip(n, Part::Quarter, Some(WARM + 2 * COUNTED)),
        ));
    }
    for precision in [Precision::Mixed, Precision::Single] {
        for n in GROWTH {
            let name = format!("numbers: {}, flat ground, n = {n}", precision.word());
            lines.push(slow(name, move || increment(n, precision, &DIMPLE)));
        }
    }
    for method in [MethodKind::NewtonKrylov, MethodKind::Gfmd] {
        for n in [64, 512] {
            lines.push(slow(
                format!("method alone: {}, n = {n}", method.word()),
                move || alone(method, n),
            ));
        }
    }
    lines
}

/// A pattern of Fig. 2, and where the drive goes to come to it.
type Standpoint = (&'static str, &'static [f64]);

const BULGE: Standpoint = ("bulge", &[2.95]);
const RIDGE: Standpoint = ("ridge", &[2.5]);
const DIMPLE: Standpoint = ("dimple", &[0.3, 1.8]);

fn fig2(n: usize) -> Scene {
    let mut scene = on("fig2", n);
    scene.drive.step = STEP;
    scene
}

/// A walk on a pattern of Fig. 2 on `n` points a side, found on the coarse mesh.
fn standing(n: usize, precision: Precision, (pattern, way): &Standpoint) -> Walk {
    let walk = |n, precision| {
        let options = WalkOptions {
            precision,
            ..MethodKind::NewtonKrylov.into()
        };
        Walk::start(&fig2(n), options, &Cancel::default()).expect("valid")
    };
    let mut coarse = walk(COARSE, Precision::Double);
    for u0 in *way {
        walked(&mut coarse, *u0);
    }
    let record = coarse.record().clone();
    assert_eq!(record.pattern.word(), *pattern);
    let mut state = Equilibrium {
        soft_mode: Vec::new(),
        ..coarse.here().clone()
    };
    state.state.amplitudes = carried(&state.state.amplitudes, n);
    walk(n, precision).standing_on(state, record)
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

/// Increments of Newton's method upwards from a pattern of Fig. 2, checks of stability and all.
fn increment(n: usize, precision: Precision, start: &Standpoint) -> Spent {
    let mut walk = standing(n, precision, start);
    let from = walk.record().mean_displacement;
    walked(&mut walk, from + STEP * WARM as f64);
    let before = walk.counts();
    let (mut increments, mut newton) = (0, 0);
    let spent = timed(|| {
        for step in 1..=COUNTED {
            let taken = walked(&mut walk, from + STEP * (WARM + step) as f64).len();
            increments += taken;
            newton += taken * walk.here().cost.transforms;
        }
        0
    });
    let counts = walk.counts();
    Spent {
        transforms: counts.transforms - before.transforms,
        proofs: counts.proof_transforms - before.proof_transforms,
        coarse: counts.coarse_transforms - before.coarse_transforms,
        newton,
        increments,
        ..spent
    }
}

/// One increment by `method` along the branch of the dimple, and nothing else: no check of
/// stability.
fn alone(method: MethodKind, n: usize) -> Spent {
    let mut walk = standing(n, Precision::Double, &DIMPLE);
    let start = walk.record().mean_displacement;
    let (mut history, mut to) = (History::default(), start);
    for _ in 0..WARM {
        to += STEP;
        walked(&mut walk, to);
        history.push(&walk.here().state);
    }
    let model = walk.model();
    let system = System::new(model.grid, model.law, &model.indenter);
    let mut mechanics = Mechanics::new(system, Slides::Freely);
    mechanics.refresh(&walk.here().fields);
    let (mut method, mut newton) = (method.build(1), 0);
    let spent = timed(|| {
        let found = method.follow(&mut mechanics, &history, walk.here(), to + STEP);
        newton = found.expect("stays on its branch").cost.transforms;
        newton
    });
    Spent {
        newton,
        increments: 1,
        ..spent
    }
}

/// The loop over the tip at mu_rho = .5 on a part of the cell; or only so many increments in
/// contact, of which the first are not counted.
fn tip(n: usize, part: Part, only: Option<usize>) -> Spent {
    let mut scene = on("hertz", n);
    scene.drive.step = TIP_STEP;
    let options = WalkOptions {
        part,
        ..MethodKind::NewtonKrylov.into()
    };
    let cancel = Cancel::default();
    let mut walk = Walk::start(&scene, options, &cancel).expect("valid");
    let mut itinerary = Itinerary::closed(&scene);
    let (mut begun, mut before) = ((Instant::now(), ProcessTime::now()), walk.counts());
    let (mut states, mut newton, mut in_contact) = (0, 0, None);
    while let Some(target) = itinerary.target() {
        walk.set_target(target);
        let (mut taken, mut jumped) = (0, false);
        let progress = walk.step(&cancel, &mut |news| match news {
            Observed::State(_) => taken += 1,
            Observed::Jump(_) => jumped = true,
            _ => {}
        });
        assert!(
            matches!(progress, Progress::Working | Progress::Resting),
            "{progress:?}"
        );
        states += taken;
        newton += taken * walk.here().cost.transforms;
        if let Some(only) = only {
            if jumped {
                in_contact = Some(0);
            } else if let Some(count) = &mut in_contact {
                *count += taken;
                if *count == WARM && taken > 0 {
                    (begun, before) = ((Instant::now(), ProcessTime::now()), walk.counts());
                    (states, newton) = (0, 0);
                }
                if *count == only {
                    break;
                }
            }
        }
        itinerary.step(&progress, walk.record());
    }
    let counts = walk.counts();
    Spent {
        processor: begun.1.elapsed().as_secs_f64(),
        wall: begun.0.elapsed().as_secs_f64(),
        transforms: counts.transforms - before.transforms,
        proofs: counts.proof_transforms - before.proof_transforms,
        coarse: counts.coarse_transforms - before.coarse_transforms,
        newton,
        increments: states,
        note: String::new(),
    }
}
