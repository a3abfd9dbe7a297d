//! How often the stated error holds: random loops on flat ground against an independent walk on a
//! mesh half as fine again.
//!
//! Prints one row a loop, then the table of the guide: `cargo run --release --no-default-features
//! --example coverage`. Arguments: `COUNT` (200), `FIRST` seed (1), and between which L/L_c the cells
//! lie (1.15 and 5). Every smooth law, squares and lines, every strategy, stiff machines and springs,
//! targets from 0.1 to 1e-5. A loop that does not complete, loses a jump or has one too many counts
//! as outside.

use rand::seq::IndexedRandom;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use tackscope::follow::run::{Outcome, run_loop};
use tackscope::follow::walk::WalkOptions;
use tackscope::numerics::threads::Cancel;
use tackscope::physics::body::Body;
use tackscope::physics::control::Control;
use tackscope::physics::indenter::Indenter;
use tackscope::physics::law::{DoubleExponential, Law, Mie, Morse, Shape};
use tackscope::physics::mesh::next_fast;
use tackscope::physics::theory::{critical_length, flat_limits};
use tackscope::scene::{self, Cell, Drive, LawChoice, Model, Part, Points, Scene, Strategy, Turn};
use tackscope::solver::methods::MethodKind::NewtonKrylov;
use tackscope::study::plan::{Plan, measured_error, plan, read_off, run_planned};

/// What came of one scene.
struct Trial {
    strategy: &'static str,
    target: f64,
    predicted: f64,
    /// Relative error of the loss or of a jump's u0, whichever is larger; 1 where the jumps are not
    /// the same, NaN without a reference.
    measured: f64,
}

/// A loop in a cell of so many critical lengths, from beyond every jump to below the lowest limit of
/// the flat state, and how it is to be computed.
fn random(seed: u64, periods: Range<f64>) -> (Scene, Option<Strategy>) {
    let rng = &mut Pcg64::seed_from_u64(seed);
    let shape = match rng.random_range(0..3) {
        0 => Shape::Morse(Morse),
        1 => {
            let n = rng.random_range(1.5..4.0);
            Shape::Mie(Mie {
                m: n + rng.random_range(1.0..7.0),
                n,
            })
        }
        _ => Shape::DoubleExponential(DoubleExponential {
            ratio: rng.random_range(0.25..0.8),
        }),
    };
    let law = Law {
        shape,
        surface_energy: rng.random_range(0.02..0.3),
        range: 1.0,
    };
    let length = critical_length(&law) * rng.random_range(periods);
    let line = rng.random_bool(0.3);
    let target = 10f64.powf(rng.random_range(-5.0..-1.0));
    let (low, high) = flat_limits(&law, length).expect("longer than the critical length");
    // Of three machines one is a spring, which the largest stress stretches by `sag`.
    let stiffness = law.traction_max() / law.range * 10f64.powf(rng.random_range(-1.0..1.5));
    let (control, sag) = if rng.random_range(0..3) == 0 {
        (
            Control::Spring { stiffness },
            law.traction_max() / stiffness,
        )
    } else {
        (Control::Displacement, 0.0)
    };
    let (start, bottom) = (2.2 * high + 1.0 + 1.3 * sag, law.equilibrium_gap());
    let turn = bottom + rng.random_range(0.2..0.9) * (low - bottom) - 1.3 * sag;
    let scene = Scene {
        title: format!("seed {seed}"),
        source: String::new(),
        cell: Cell {
            length,
            points: Points::Auto,
        },
        body: Body::HalfSpace,
        law: LawChoice {
            shape,
            surface_energy: law.surface_energy,
            range: scene::Range::Length(1.0),
        },
        indenter: Indenter::Flat,
        drive: Drive {
            control,
            start,
            turn: Turn::At(turn),
            step: (start - turn) / rng.random_range(10.0..100.0),
        },
        accuracy: target,
        units: None,
        seed,
    };
    if !line {
        return (
            scene,
            *[None, None, Some(Strategy::QUARTER), Some(Strategy::WHOLE)]
                .choose(rng)
                .expect("not empty"),
        );
    }
    let n = scene.model().expect("a legal scene").grid.nx;
    (
        Scene {
            cell: Cell {
                length,
                points: Points::Line(n),
            },
            ..scene
        },
        None,
    )
}

fn trial(scene: &Scene, model: &Model, plan: &Plan) -> Trial {
    let strategy = match plan.strategy {
        Strategy::Walk(_) if model.grid.is_line() => "line",
        Strategy::Walk(reduction) => reduction.word(),
        Strategy::Atlas => "atlas",
    };
    let cancel = Cancel::default();
    let mut finer = scene.clone();
    let n = next_fast(model.grid.nx * 3 / 2);
    finer.cell.points = if model.grid.is_line() {
        Points::Line(n)
    } else {
        Points::Square(n)
    };
    finer.drive.step = 0.2 * model.law.range;
    let run = run_planned(scene, NewtonKrylov, plan, &cancel, &mut |_| {}).expect("a legal scene");
    let better = run_loop(
        &finer,
        WalkOptions {
            part: Part::Quarter,
            ..NewtonKrylov.into()
        },
        &cancel,
        &mut |_| {},
    )
    .expect("a legal scene");
    let measured = match (&run.outcome, &better.outcome) {
        (_, Outcome::NotConverged { .. } | Outcome::Cancelled) => f64::NAN,
        (Outcome::Completed, _) => {
            // Where it is contested which of two loops it is, the reference has both.
            let contested = [&run, &better].iter().any(|run| {
                run.record
                    .jumps
                    .iter()
                    .any(|jump| !jump.landings.is_empty())
            });
            let loops = contested
                .then(|| read_off(&finer, &cancel))
                .flatten()
                .unwrap_or_default();
            let all = loops.iter().chain([&better.record.jumps]);
            all.map(|jumps| measured_error(&run.record.jumps, jumps))
                .fold(1.0, f64::min)
        }
        _ => 1.0,
    };
    let predicted = run.error_bar.unwrap_or(plan.predicted_error);
    Trial {
        strategy,
        target: scene.accuracy,
        predicted,
        measured,
    }
}

fn main() {
    let arguments: Vec<f64> = std::env::args()
        .skip(1)
        .filter_map(|argument| argument.parse().ok())
        .collect();
    let argument = |i: usize, usual: f64| arguments.get(i).copied().unwrap_or(usual);
    let (count, first) = (argument(0, 200.0) as u64, argument(1, 1.0) as u64);
    let periods = argument(2, 1.15)..argument(3, 5.0);
    let (next, trials) = (AtomicU64::new(first), Mutex::new(Vec::new()));
    println!("seed,strategy,target,law,periods,points,mu_rho,predicted,measured");
    let work = || {
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed >= first + count {
                return;
            }
            let (scene, asked) = random(seed, periods.clone());
            let model = scene.model().expect("a legal scene");
            let plan = plan(&scene, &model, asked);
            let trial = trial(&scene, &model, &plan);
            let periods = model.grid.length / critical_length(&model.law);
            let Trial {
                strategy,
                target,
                predicted,
                measured,
            } = trial;
            println!(
                "{seed},{strategy},{target:.1e},{:?},{periods:.3},{},{:.4},{predicted:.2e},{measured:.2e}",
                model.law.shape, model.grid.nx, model.mu_rho
            );
            trials.lock().expect("no other thread panicked").push(trial);
        }
    };
    std::thread::scope(|scope| {
        (0..std::thread::available_parallelism().map_or(1, usize::from))
            .for_each(|_| _ = scope.spawn(work));
    });
    let trials = trials.into_inner().expect("no thread panicked");
    println!(
        "\n| strategy | loops | inside | nothing promised | met the target | median predicted / measured |\n|---|---|---|---|---|---|"
    );
    for strategy in ["atlas", "quarter", "whole", "line"] {
        row(
            strategy,
            trials
                .iter()
                .filter(|trial| trial.strategy == strategy)
                .collect(),
        );
    }
    row("all", trials.iter().collect());
}

fn row(strategy: &str, trials: Vec<&Trial>) {
    // A bar of 1 says that a finer mesh has other jumps.
    let refused = trials.iter().filter(|t| t.predicted >= 1.0).count();
    let inside = trials
        .iter()
        .filter(|t| t.measured <= t.predicted && t.predicted < 1.0)
        .count();
    let met = trials.iter().filter(|t| t.measured <= t.target).count();
    let mut ratios: Vec<f64> = trials
        .iter()
        .map(|t| t.predicted / t.measured)
        .filter(|ratio| ratio.is_finite())
        .collect();
    ratios.sort_by(f64::total_cmp);
    let median = ratios.get(ratios.len() / 2).copied().unwrap_or(f64::NAN);
    println!(
        "| {strategy} | {} | {inside} | {refused} | {met} | {median:.1} |",
        trials.len()
    );
}
