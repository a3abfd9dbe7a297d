use tackscope::numerics::cancel::Cancel;
use tackscope::physics::theory::discs::Kind;
use tackscope::physics::theory::{circular, ridge};
use tackscope::solver::boundary_elements as be;
#[test]
fn r() {
    let c = Cancel::default();
    for (n, f) in [(32, 4), (32, 16), (32, 28), (64, 60), (64, 62)] {
        let alpha = f as f64 / n as f64;
        let e = ridge::elastic_energy(alpha);
        for l in 2..7 {
            let t = std::time::Instant::now();
            let x = be::ridge_extrapolated(n, f, l, &c).unwrap();
            println!("{n} {f} {l} rel {:.2e} err {:.2e} {:?}", x.value / e[0] - 1.0, x.error / e[0], t.elapsed());
        }
        for n in [128, 1024usize] {
            let v = be::ridge(n, (alpha * n as f64) as usize, &c).unwrap();
            println!("shift {}", (v - e[0]) / e[1] * n as f64 / 2.0);
        }
    }
    for (kind, p) in [(Kind::Dimple, circular::dimple()), (Kind::Bulge, circular::bulge())] {
        for s in [0.2, 0.5, 0.8, 0.9] {
            let e = p.elastic_energy(s);
            for n in [32, 64, 128, 256, 512] {
                for radii in [4, 8, 16] {
                    let t = std::time::Instant::now();
                    let d = be::disc_on_mesh(kind, s, n, radii, &c).unwrap();
                    println!(
                        "{kind:?} {s} {n} {radii} rel {:.3e} noise {:.1e} shift {:.4} pm {:.4} {:?}",
                        d.elastic_energy / e[0] - 1.0,
                        d.noise / e[0],
                        (d.elastic_energy - e[0]) / e[1] * n as f64 / 2.0,
                        d.noise / e[1].abs() * n as f64 / 2.0,
                        t.elapsed()
                    );
                }
            }
        }
    }
}
