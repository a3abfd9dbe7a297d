use tackscope::experiment::{run::*, scene::*};
use tackscope::physics::{indenter::Indenter, law::*};
use tackscope::solver::method::MethodKind;
fn main() {
    let a: Vec<f64> = std::env::args().skip(1).map(|x| x.parse().unwrap()).collect();
    let g = |i: usize, d: f64| a.get(i).copied().unwrap_or(d);
    let (l, n, start, turn, step, seed, line, gf) =
        (g(0, 256.), g(1, 64.), g(2, 4.2), g(3, 0.2), g(4, 0.02), g(5, 1.), g(6, 0.), g(7, 0.));
    let scene = Scene {
        title: "".into(),
        source: "".into(),
        cell: Cell { length: l, points: if line > 0. { Points::Line(n as usize) } else { Points::Square(n as usize) } },
        law: LawChoice { shape: Shape::Morse(Morse), surface_energy: 0.15, range: Range::Length(g(8, 1.0)) },
        indenter: Indenter::Flat,
        drive: Drive { start, turn: Turn::At(turn), step },
        accuracy: 0.01,
        seed: seed as u64,
    };
    let t = std::time::Instant::now();
    let verbose = std::env::var("V").is_ok();
    let run =
        run_loop(
            &scene,
            if gf > 0. { MethodKind::Gfmd } else { MethodKind::NewtonKrylov },
            &Default::default(),
            &mut |r| match r {
                Report::Jump(j) => println!(
                    "{:10} {:.5} {} -> {}  released {:.6} {}",
                    j.branch, j.mean_displacement, j.from, j.to, j.released_energy, j.cause
                ),
                Report::State { record: s, .. } => {
                    if verbose {
                        println!(
                            "{:.5} {:8} s={:.6} k={:.4}+-{:.4} r={:.1e} it={} tr={} ms={:.2} {}",
                            s.mean_displacement,
                            s.pattern,
                            s.stress_over_max,
                            s.stiffness_min,
                            s.stiffness_error,
                            s.residual,
                            s.iterations,
                            s.transforms,
                            s.milliseconds,
                            s.stop
                        )
                    }
                }
            },
        )
        .unwrap();
    let w = run.record.work() / 0.15;
    let r = run.record.released_energy_sum();
    let pat: usize = run.record.states.iter().filter(|s| s.pattern.word() != "flat").map(|s| s.transforms).sum();
    println!(
        "{:?} work {:.6} released {:.6} mismatch {:.2e} states {} {:?} T/pat {:.1} ({pat}) min stiffness {:?} {:.3}s",
        run.outcome,
        w,
        r,
        (w - r).abs() / w,
        run.record.states.len(),
        run.counts,
        run.counts.transforms as f64 / run.counts.patterned_increments as f64,
        run.record.states.iter().map(|s| s.stiffness_min).fold(f64::INFINITY, f64::min),
        t.elapsed().as_secs_f64()
    );
}
