//! Whole computations in units of the transform: `cargo bench --no-default-features --bench pairs`.
//!
//! A *pair* is the duration of one forward and one back transform of 64 x 64 points on one thread,
//! measured in the same run: machines differ, their ratio hardly does.

use ndarray::Array2;
use std::time::{Duration, Instant};
use tackscope::follow::atlas::Atlas;
use tackscope::follow::diagram::Diagram;
use tackscope::numerics::cancel::Cancel;
use tackscope::numerics::fourier::Fourier;
use tackscope::scene::part::Part;
use tackscope::scene::{Points, Range, Scene, Turn};
use tackscope::storage::presets;
use tackscope::study::landscape::{Ground, Landscape, Standing};
use tackscope::study::live_loop::{Fineness, LiveLoops};
use tackscope::study::map::PatternMap;

/// Runs of each row, of which the median counts.
const RUNS: usize = 9;
/// Pairs timed together.
const PAIRS: usize = 2000;

fn main() {
    let pair = pair();
    println!("pair: {:.1} us", 1e6 * pair.as_secs_f64());
    println!("{:<44} {:>9} {:>11}", "", "pairs", "transforms");
    for (name, n) in [("fig2", 48), ("fig2", 64), ("fig3", 192)] {
        row(
            &format!("{name}, n = {n}, loop by the atlas, cold"),
            pair,
            || {
                let scene = on(name, n);
                let model = scene.model().expect("allowed");
                let mut atlas = Atlas::of(&scene, &model);
                let Turn::At(turn) = scene.drive.turn else {
                    unreachable!("it has a turning point")
                };
                atlas.cycle(scene.drive.start, turn).expect("a loop");
                atlas.transforms().iter().sum()
            },
        );
    }
    for n in [48, 64] {
        row(&format!("fig2, n = {n}, whole diagram, cold"), pair, || {
            let report = &mut |_: &str, _: usize, _: f64| {};
            let found = Diagram::of(&on("fig2", n), Part::Whole, &Cancel::default(), report);
            let found = found.expect("allowed");
            assert!(found.is_complete(), "{:?}", found.missing);
            found.transforms
        });
    }
    loops_of_a_parameter(pair);
    landscape(pair);
}

/// One loop after the other while the range goes, and a map of a hundred.
fn loops_of_a_parameter(pair: Duration) {
    let mut scene = on("fig2", 64);
    let mut live = LiveLoops::default();
    row("fig2, live loop, range changed by 1 %", pair, || {
        let was = scene.law.range == Range::Length(1.0);
        scene.law.range = Range::Length(if was { 1.01 } else { 1.0 });
        let model = scene.model().expect("allowed");
        let found = live.next(&scene, &model, Fineness::Coarse);
        found.expect("a loop");
        0
    });
    row("fig2, map of 100 loops, range .8 to 1.2", pair, || {
        let vary = "law.range=0.8..1.2".parse().expect("a parameter");
        let cancel = &Cancel::default();
        let map = PatternMap::of(&on("fig2", 64), &vary, 100, cancel, &mut |_, _| {});
        assert_eq!(map.expect("allowed").missing().count(), 0);
        0
    });
}

/// The saddles around the bulge with their paths, and the same with the barriers along the drive.
fn landscape(pair: Duration) {
    let (scene, cancel) = (on("fig2", 48), Cancel::default());
    let model = scene.model().expect("allowed");
    let report = &mut |_: &str, _: usize, _: f64| {};
    let diagram = Diagram::of(&scene, Part::Whole, &cancel, report).expect("allowed");
    let ground = Ground {
        scene: &scene,
        model: &model,
        diagram: &diagram,
        cancel: &cancel,
    };
    row("fig2, n = 48, saddles and paths at 3.5", pair, || {
        let saddles = ground.saddles(3.5).expect("not cancelled");
        assert_eq!(saddles.found.len(), 2);
        0
    });
    let bulge = diagram
        .pieces(0)
        .find(|piece| piece.holds(3.5) && piece.branch.name == "square");
    let bulge = Standing::on(&bulge.expect("it is there"), 3.5);
    row("the same with the barriers along the drive", pair, || {
        let found = Landscape::around(ground, bulge, None, &mut |_, _| {});
        assert_eq!(found.expect("not cancelled").passes.len(), 2);
        0
    });
}

/// A preset on `n` points a side.
fn on(preset: &str, n: usize) -> Scene {
    let mut scene = presets::resolve(preset).expect("built in");
    scene.cell.points = Points::Square(n);
    scene
}

/// The duration of a pair.
fn pair() -> Duration {
    let plan = Fourier::new(64, 64);
    let mut field = Array2::from_shape_fn((64, 64), |(j, i)| (i * 7 + j * 3) as f64 % 11.0);
    let (mut spectrum, mut scratch) = (plan.spectrum(), plan.scratch());
    let times = || {
        let begun = Instant::now();
        for _ in 0..PAIRS {
            plan.forward(&field, &mut spectrum, &mut scratch);
            plan.inverse(&mut spectrum, &mut field, &mut scratch);
        }
        begun.elapsed() / PAIRS as u32
    };
    median(times)
}

fn median(mut time: impl FnMut() -> Duration) -> Duration {
    let mut times: Vec<Duration> = (0..RUNS).map(|_| time()).collect();
    times.sort();
    times[RUNS / 2]
}

/// Prints what `work` takes; it returns its transforms, 0 where they are not counted.
fn row(name: &str, pair: Duration, mut work: impl FnMut() -> usize) {
    let mut transforms = 0;
    let time = median(|| {
        let begun = Instant::now();
        transforms = work();
        begun.elapsed()
    });
    let pairs = time.as_secs_f64() / pair.as_secs_f64();
    println!("{name:<44} {pairs:>9.0} {transforms:>11}");
}
