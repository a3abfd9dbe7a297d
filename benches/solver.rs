//! Benchmarks of the transform and of one force evaluation: `cargo bench --no-default-features
//! --bench solver`.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use ndarray::Array2;
use rayon::ThreadPoolBuilder;
use std::hint::black_box;
use std::time::{Duration, Instant};
use tackscope::numerics::fourier::Fourier;
use tackscope::numerics::threads::POINTS_MIN;
use tackscope::physics::indenter::Indenter;
use tackscope::physics::law::{Law, Morse, Shape};
use tackscope::physics::mesh::Grid;
use tackscope::physics::system::System;

const SIDES: [usize; 5] = [64, 128, 256, 512, 1024];

/// Benchmarks what `prepare` makes for n points a side, on one thread and, for fields that are
/// shared, on all.
fn on_threads<W: FnMut() + Send>(
    c: &mut Criterion,
    name: &str,
    prepare: impl Fn(usize) -> W + Sync,
) {
    let mut group = c.benchmark_group(name);
    group
        .sample_size(20)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1));
    let alone = ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .expect("a thread");
    for n in SIDES {
        let mut work = alone.install(|| prepare(n));
        group.bench_function(BenchmarkId::new("one thread", n), |b| {
            b.iter_custom(|times| alone.install(|| timed(times, &mut work)));
        });
        if n * n >= POINTS_MIN && rayon::current_num_threads() > 1 {
            let mut work = prepare(n);
            group.bench_function(BenchmarkId::new("all threads", n), |b| {
                b.iter_custom(|times| timed(times, &mut work));
            });
        }
    }
}

fn timed(times: u64, work: &mut impl FnMut()) -> Duration {
    let begun = Instant::now();
    (0..times).for_each(|_| work());
    begun.elapsed()
}

fn transforms(c: &mut Criterion) {
    on_threads(c, "transform pair", |n| {
        let plan = Fourier::new(n, n);
        let mut field = Array2::from_shape_fn((n, n), |(j, i)| (i * 7 + j * 3) as f64 % 11.0);
        let (mut spectrum, mut scratch) = (plan.spectrum(), plan.scratch());
        move || {
            plan.forward(&field, &mut spectrum, &mut scratch);
            plan.inverse(&mut spectrum, &mut field, &mut scratch);
        }
    });
}

fn forces(c: &mut Criterion) {
    on_threads(c, "force evaluation", |n| {
        let law = Law {
            shape: Shape::Morse(Morse),
            surface_energy: 0.15,
            range: 1.0,
        };
        let system = System::new(Grid::square(256.0, n), law, &Indenter::Flat);
        let mut ws = system.workspace();
        let mut at = system.at(vec![1e-3; system.dimension()], 1.0, &mut ws);
        move || {
            system.update(black_box(&mut at), &mut ws);
        }
    });
}

criterion_group!(benches, transforms, forces);
criterion_main!(benches);
