use tackscope::experiment::plan::*;
use tackscope::experiment::walk::*;
use tackscope::numerics::cancel::Cancel;
use tackscope::solver::method::MethodKind;
use std::f64::consts::TAU;
fn main() {
    let text = std::fs::read_to_string("/tmp/s/vv.toml").unwrap();
    let scene = tackscope::storage::scene_file::parse(&text, "vv").unwrap();
    let model = scene.model().unwrap();
    for red in [Reduction::Quarter, Reduction::Whole] {
    let mut walk = Walk::reduced(&scene, MethodKind::NewtonKrylov, red).unwrap();
    for target in [1.25, 1.2127155] {
        walk.set_target(target);
        while let Progress::Working = walk.step(&Cancel::default(), &mut |_| {}) {}
        let s = walk.record().clone();
        let gap = walk.gap();
        let (ny, nx) = gap.dim();
        let col: Vec<f64> = gap.row(0).to_vec();
        let row: Vec<f64> = gap.column(0).to_vec();
        let spread = |v: &[f64]| v.iter().fold(0.0f64, |m, x| m.max((x - v[0]).abs()));
        let line = if spread(&col) > spread(&row) { col.clone() } else { row.clone() };
        println!("u0 {} {} along {:.3e} {:.3e} residual {:.1e} stiffness {:.6e} pm {:.1e}", s.mean_displacement, s.pattern, spread(&col), spread(&row), s.residual, s.stiffness_min, s.stiffness_error);
        let n = line.len(); let _ = (ny, nx);
        let q1 = TAU / model.grid.length;
        let m = nalgebra::DMatrix::from_fn(n, n, |i, j| {
            let mut a = 0.0;
            for k in 0..n { let kk = if 2 * k > n { k as f64 - n as f64 } else { k as f64 };
                a += 0.5 * q1 * kk.hypot(1.0) * (TAU * (k * ((i + n - j) % n)) as f64 / n as f64).cos() / n as f64; }
            a + if i == j { model.law.at(line[i]).stiffness } else { 0.0 }
        });
        let mut e: Vec<f64> = m.symmetric_eigen().eigenvalues.iter().map(|x| x * model.grid.length).collect();
        e.sort_by(f64::total_cmp);
        println!("   dense k_y=1: {:.6e} {:.6e}", e[0], e[1]);
    }}
}
