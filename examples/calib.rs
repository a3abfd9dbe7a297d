use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use std::sync::atomic::{AtomicU64, Ordering};
use tackscope::experiment::plan::*;
use tackscope::experiment::record::*;
use tackscope::experiment::run::*;
use tackscope::experiment::scene::*;
use tackscope::numerics::cancel::Cancel;
use tackscope::physics::indenter::Indenter;
use tackscope::physics::law::{DoubleExponential, Law, Mie, Morse, Shape};
use tackscope::physics::mesh_rule;
use tackscope::physics::theory::flat;
use tackscope::solver::method::MethodKind::NewtonKrylov;

fn errs(a: &LoopRecord, b: &LoopRecord) -> (f64, f64, f64) {
    let least = 1e-3 * b.released_energy_sum();
    let f = |r: &LoopRecord| r.jumps.iter().filter(|j| j.released_energy > least).cloned().collect::<Vec<_>>();
    let (x, y) = (f(a), f(b));
    let nm = |j: &JumpRecord| (j.branch, j.from, j.to);
    if !x.iter().map(nm).eq(y.iter().map(nm)) { return (1.0, 1.0, 1.0) }
    let j = x.iter().zip(&y).map(|(a, b)| (a.mean_displacement / b.mean_displacement - 1.0).abs()).fold(0.0, f64::max);
    let jr = x.iter().zip(&y).map(|(a, b)| (a.mean_displacement - b.mean_displacement).abs()).fold(0.0, f64::max);
    ((a.released_energy_sum() / b.released_energy_sum() - 1.0).abs(), j, jr)
}

fn main() {
    let a: Vec<u64> = std::env::args().skip(1).map(|x| x.parse().unwrap()).collect();
    let next = AtomicU64::new(a[1]);
    println!("seed,kind,law,c1,c2,gamma,periods,n,mu,loss,jumps,jumps_ranges,release_error,extra");
    let work = || loop {
        let seed = next.fetch_add(1, Ordering::Relaxed);
        if seed >= a[0] + a[1] { return }
        let rng = &mut Pcg64::seed_from_u64(seed + 1_000_000);
        let (shape, nm, c1, c2) = match rng.random_range(0..3) {
            0 => (Shape::Morse(Morse), "morse", 0.0, 0.0),
            1 => { let n = rng.random_range(1.5..4.0); let m = n + rng.random_range(1.0..7.0); (Shape::Mie(Mie { m, n }), "mie", m, n) }
            _ => { let r = rng.random_range(0.25..0.8); (Shape::DoubleExponential(DoubleExponential { ratio: r }), "dexp", r, 0.0) }
        };
        let law = Law { shape, surface_energy: rng.random_range(0.02..0.3), range: 1.0 };
        let periods: f64 = rng.random_range(1.15..6.0);
        let length = flat::critical_length(&law) * periods;
        let mu0: f64 = rng.random_range(0.36..0.56);
        let n = next_fast(mesh_rule::points_for_mu_rho(&law, length, mu0) as usize);
        let (low, high) = flat::limits(&law, length).unwrap();
        let (start, bottom) = (2.2 * high + 1.0, law.equilibrium_gap());
        let mk = |pts| Scene {
            title: String::new(), source: String::new(), cell: Cell { length, points: pts },
            law: LawChoice { shape, surface_energy: law.surface_energy, range: Range::Length(1.0) }, indenter: Indenter::Flat,
            drive: Drive { start, turn: Turn::At(bottom + 0.3 * (low - bottom)), step: 0.25 }, accuracy: 0.01, seed };
        let c = Cancel::default();
        let run = |pts, wish| { let s: Scene = mk(pts); let m = s.model().unwrap(); let p = plan(&s, &m, wish);
            let r = run_planned(&s, NewtonKrylov, &p, &c, &mut |_| {}).unwrap(); (r, m) };
        let mut rows = vec![];
        let fine = next_fast(n * 8 / 5);
        let (lf, _) = run(Points::Line(2 * n), Wish::Quarter);
        let (l, m) = run(Points::Line(n), Wish::Quarter);
        if lf.outcome == Outcome::Completed && l.outcome == Outcome::Completed { rows.push(("line", l, errs_of(&lf), m.clone())); let k = rows.len()-1; let e = errs(&rows[k].1.record, &lf.record); rows[k].2 = e; }
        let (af, _) = run(Points::Square(fine), Wish::Plan);
        if af.deviation.is_none() && af.outcome == Outcome::Completed {
            let (x, m) = run(Points::Square(n), Wish::Plan);
            if x.deviation.is_none() { let e = errs(&x.record, &af.record); rows.push(("atlas", x, e, m)); }
            if n <= 96 {
                let (x, m) = run(Points::Square(n), Wish::Quarter);
                if x.deviation.is_none() && x.outcome == Outcome::Completed { let e = errs(&x.record, &af.record); rows.push(("quarter", x, e, m)); }
            }
        }
        for (kind, r, (l, j, jr), m) in rows {
            let led = r.record.ledger(law.surface_energy);
            println!("{seed},{kind},{nm},{c1:.3},{c2:.3},{:.3},{periods:.3},{n},{:.4},{l:.3e},{j:.3e},{jr:.3e},{:.2e},{}", law.surface_energy, m.mu_rho, led.released_energy_error / led.released_energy_sum, r.record.jumps.len());
        }
    };
    std::thread::scope(|s| for _ in 0..2 { s.spawn(&work); });
}
fn errs_of(_: &LoopRun) -> (f64, f64, f64) { (0.0, 0.0, 0.0) }
