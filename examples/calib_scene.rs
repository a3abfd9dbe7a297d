use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use tackscope::experiment::plan::*;
use tackscope::experiment::scene::*;
use tackscope::physics::indenter::Indenter;
use tackscope::physics::law::{DoubleExponential, Law, Mie, Morse, Shape};
use tackscope::physics::mesh_rule;
use tackscope::physics::theory::flat;
fn main() {
    for seed in std::env::args().skip(1).map(|x| x.parse::<u64>().unwrap()) {
        let rng = &mut Pcg64::seed_from_u64(seed + 1_000_000);
        let shape = match rng.random_range(0..3) {
            0 => Shape::Morse(Morse),
            1 => { let n = rng.random_range(1.5..4.0); let m = n + rng.random_range(1.0..7.0); Shape::Mie(Mie { m, n }) }
            _ => { let r = rng.random_range(0.25..0.8); Shape::DoubleExponential(DoubleExponential { ratio: r }) }
        };
        let law = Law { shape, surface_energy: rng.random_range(0.02..0.3), range: 1.0 };
        let periods: f64 = rng.random_range(1.15..6.0);
        let length = flat::critical_length(&law) * periods;
        let mu0: f64 = rng.random_range(0.36..0.56);
        let n = next_fast(mesh_rule::points_for_mu_rho(&law, length, mu0) as usize);
        let (low, high) = flat::limits(&law, length).unwrap();
        let (start, bottom) = (2.2 * high + 1.0, law.equilibrium_gap());
        let s = Scene {
            title: String::new(), source: String::new(), cell: Cell { length, points: Points::Square(n) },
            law: LawChoice { shape, surface_energy: law.surface_energy, range: Range::Length(1.0) }, indenter: Indenter::Flat,
            drive: Drive { start, turn: Turn::At(bottom + 0.3 * (low - bottom)), step: 0.25 }, accuracy: 0.01, seed };
        std::fs::write(format!("/tmp/s/c{seed}.toml"), tackscope::storage::scene_file::to_text(&s)).unwrap();
    }
}
