//! Benchmarks of the transform, one force evaluation, and one increment by each method: `cargo bench --no-default-features`.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use ndarray::Array2;
use std::hint::black_box;
use tackscope::experiment::scene::{Points, Scene};
use tackscope::experiment::walk::{Progress, Walk};
use tackscope::numerics::cancel::Cancel;
use tackscope::numerics::fourier::Fourier;
use tackscope::physics::grid::Grid;
use tackscope::physics::indenter::Indenter;
use tackscope::physics::law::{Law, Morse, Shape};
use tackscope::physics::system::System;
use tackscope::solver::method::MethodKind;
use tackscope::storage::{presets, scene_file};

fn transforms(c: &mut Criterion) {
    let mut group = c.benchmark_group("transform pair");
    for n in [64, 128, 256, 512] {
        let plan = Fourier::new(n, n);
        let mut field = Array2::from_shape_fn((n, n), |(j, i)| (i * 7 + j * 3) as f64 % 11.0);
        let (mut spectrum, mut scratch) = (plan.spectrum(), plan.scratch());
        group.bench_function(BenchmarkId::from_parameter(n), |b| {
            b.iter(|| {
                plan.forward(&field, &mut spectrum, &mut scratch);
                plan.inverse(&mut spectrum, &mut field, &mut scratch);
            });
        });
    }
}

fn forces(c: &mut Criterion) {
    let mut group = c.benchmark_group("force evaluation");
    for n in [64, 128, 256, 512] {
        let law = Law { shape: Shape::Morse(Morse), surface_energy: 0.15, range: 1.0 };
        let system = System::new(Grid::square(256.0, n), law, &Indenter::Flat);
        let mut ws = system.workspace();
        let (z, mut g) = (vec![1e-3; system.dimension()], vec![0.0; system.dimension()]);
        group.bench_function(BenchmarkId::from_parameter(n), |b| b.iter(|| black_box(system.evaluate(&z, 1.0, &mut g, &mut ws))));
    }
}

/// Walks until the target is reached.
fn walk_to(walk: &mut Walk, u0: f64) {
    walk.set_target(u0);
    while walk.step(&Cancel::default(), &mut |_| {}) == Progress::Working {}
}

fn increments(c: &mut Criterion) {
    let mut group = c.benchmark_group("increment of a ridge, 0.02 range");
    for method in [MethodKind::NewtonKrylov, MethodKind::Gfmd] {
        let mut scene: Scene = scene_file::parse(presets::find("fig2").expect("built in").text, "fig2").expect("valid");
        scene.cell.points = Points::Square(64);
        let mut walk = Walk::new(&scene, method).expect("valid");
        walk_to(&mut walk, 2.6);
        let mut down = false;
        group.bench_function(method.word(), |b| {
            b.iter(|| {
                // To and fro over one step of the same branch.
                down = !down;
                walk_to(&mut walk, if down { 2.5 } else { 2.52 });
            });
        });
    }
}

criterion_group!(benches, transforms, forces, increments);
criterion_main!(benches);
