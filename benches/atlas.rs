//! Whole loops read off an atlas of branches, made afresh and adapted: `cargo bench
//! --no-default-features --bench atlas`.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use std::time::Duration;
use tackscope::follow::atlas::{Atlas, Meshes};
use tackscope::physics::law::{Law, Morse, Shape};

fn law(range: f64) -> Law {
    Law {
        shape: Shape::Morse(Morse),
        surface_energy: 0.15,
        range,
    }
}

/// The loop of a cell of side `length` on n points, u0 from `start` to 0.2 and back; adapted: after
/// a change of the range by 1 %.
fn loops(c: &mut Criterion, name: &str, length: f64, n: usize, start: f64) {
    let mut group = c.benchmark_group(name);
    group
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(2));
    let (old, new) = (
        Meshes::new(&law(1.0), length, n),
        Meshes::new(&law(1.01), length, n),
    );
    let mut known = Atlas::new(old);
    known.cycle(start, 0.2).expect("a loop");
    let mut again = known.adapted(new).expect("the same branches");
    again.cycle(start, 0.2).expect("a loop");
    println!(
        "{name}: transforms on the line, the quarter and releases: {:?} afresh, {:?} adapted",
        known.transforms(),
        again.transforms()
    );
    group.bench_function("afresh", |b| {
        b.iter(|| black_box(Atlas::new(old).cycle(start, 0.2)));
    });
    group.bench_function("adapted", |b| {
        b.iter(|| black_box(known.adapted(new).map(|mut atlas| atlas.cycle(start, 0.2))));
    });
}

fn atlas(c: &mut Criterion) {
    loops(c, "Fig. 2, n = 48", 256.0, 48, 4.4);
    loops(c, "Fig. 3, n = 192", 1024.0, 192, 9.5);
}

criterion_group!(benches, atlas);
criterion_main!(benches);
