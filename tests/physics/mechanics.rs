//! Energy, residual and Hessian of the half-space: derivatives by finite differences, the symmetries of
//! the problem, and that even fields on a quarter of the cell say the same as the whole cell.

use crate::{close, near};
use ndarray::Array2;
use proptest::prelude::*;
use rand::SeedableRng;
use rand_pcg::Pcg64;
use std::f64::consts::{PI, TAU};
use tackscope::numerics::dense::{add, dot, norm, scale, symmetric_eigen};
use tackscope::physics::control::Control;
use tackscope::physics::indenter::{Hertz, Indenter};
use tackscope::physics::law::{Law, Mie, Morse, Shape};
use tackscope::physics::low_block::{Class, LowBlock};
use tackscope::physics::mesh::Grid;
use tackscope::physics::preconditioner::Preconditioner;
use tackscope::physics::system::{System, carried};
use tackscope::solver::stability::random_smooth;

/// Side of the cell of even fields.
const LENGTH: f64 = 256.0;

const LAW: Law = Law {
    shape: Shape::Morse(Morse),
    surface_energy: 0.15,
    range: 1.0,
};

fn system(grid: Grid) -> System {
    System::new(grid, LAW, &Indenter::Flat)
}

/// Square and line cells under every control.
fn systems() -> Vec<System> {
    let grids = [Grid::square(60.0, 12), Grid::line(60.0, 24)];
    let under = |grid: Grid| Control::all(0.05).map(|c| system(grid).with_control(c));
    grids.into_iter().flat_map(under).collect()
}

fn surface(system: &System, seed: u64, rms: f64) -> Vec<f64> {
    let mut z = random_smooth(system, &mut Pcg64::seed_from_u64(seed));
    let s = rms / norm(&z);
    scale(&mut z, s);
    z
}

/// Energy at z + t v, by the system's own sum.
fn energy(system: &System, z: &[f64], v: &[f64], t: f64, u0: f64) -> f64 {
    let mut moved = z.to_vec();
    add(&mut moved, t, v);
    system.at(moved, u0, &mut system.workspace()).state.energy
}

#[test]
fn energy_of_a_single_wave_is_that_of_eq_1_and_a_numerical_average_of_the_law() {
    let grid = Grid::square(100.0, 32);
    let (system, amplitude, u0) = (system(grid), 0.7, 1.5);
    let q = TAU / grid.length * 5f64.sqrt();
    let wave = |x: f64, y: f64| amplitude * (TAU * (2.0 * x + y)).cos();
    let field = Array2::from_shape_fn(grid.shape(), |(j, i)| {
        wave(i as f64 / 32.0, j as f64 / 32.0)
    });
    let mut ws = system.workspace();
    let z = system.amplitudes(&field, &mut ws);
    let at = system.at(z, u0, &mut ws).state;
    // |u_q|^2 = (a/2)^2 for q and for -q.
    let elastic = q / 4.0 * 2.0 * (amplitude / 2.0f64).powi(2);
    let phases = (0..4000).map(|i| u0 + amplitude * (TAU * (f64::from(i) + 0.5) / 4000.0).cos());
    let (adhesive, stress) = phases.fold((0.0, 0.0), |(e, s), gap| {
        let r = LAW.at(gap);
        (e + r.energy / 4000.0, s + r.traction / 4000.0)
    });
    near(at.energy - elastic, adhesive, 1e-13);
    near(at.stress, stress, 1e-13);
}

#[test]
fn gradient_is_the_derivative_of_the_energy_with_second_order_taylor_slope() {
    for system in systems() {
        let (z, v) = (surface(&system, 1, 0.6), surface(&system, 2, 1.0));
        let slope = dot(
            &system.at(z.clone(), 1.2, &mut system.workspace()).gradient,
            &v,
        );
        let error = |h: f64| {
            ((energy(&system, &z, &v, h, 1.2) - energy(&system, &z, &v, -h, 1.2)) / (2.0 * h)
                - slope)
                .abs()
        };
        let ratio = error(1e-2) / error(1e-3);
        assert!(
            (50.0..200.0).contains(&ratio),
            "error falls by {ratio}, not by 100"
        );
        assert!(error(1e-4) < 1e-8);
    }
}

#[test]
fn hessian_is_the_derivative_of_the_gradient_and_symmetric() {
    for system in systems() {
        let (z, v, w) = (
            surface(&system, 3, 0.6),
            surface(&system, 4, 1.0),
            surface(&system, 5, 1.0),
        );
        let mut ws = system.workspace();
        let at = system.at(z.clone(), 1.2, &mut ws);
        let (mut hv, mut hw) = (vec![0.0; z.len()], vec![0.0; z.len()]);
        system.hessian(&at.fields, &v, &mut hv, &mut ws);
        system.hessian(&at.fields, &w, &mut hw, &mut ws);
        near(dot(&hv, &w), dot(&hw, &v), 1e-15);
        let gradient = |t: f64| {
            let mut moved = z.clone();
            add(&mut moved, t, &v);
            system.at(moved, 1.2, &mut system.workspace()).gradient
        };
        let error = |h: f64| {
            let (mut d, minus) = (gradient(h), gradient(-h));
            add(&mut d, -1.0, &minus);
            scale(&mut d, 0.5 / h);
            add(&mut d, -1.0, &hv);
            norm(&d)
        };
        let ratio = error(1e-2) / error(1e-3);
        assert!(
            (50.0..200.0).contains(&ratio),
            "error falls by {ratio}, not by 100"
        );
    }
}

#[test]
fn mean_stress_is_the_derivative_of_the_energy_along_u0() {
    let system = system(Grid::square(60.0, 12));
    let z = surface(&system, 6, 0.5);
    let stress = system
        .at(z.clone(), 1.0, &mut system.workspace())
        .state
        .stress;
    let still = vec![0.0; z.len()];
    let h = 1e-4;
    let slope = (energy(&system, &z, &still, 0.0, 1.0 + h)
        - energy(&system, &z, &still, 0.0, 1.0 - h))
        / (2.0 * h);
    near(slope, stress, 1e-9);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn energy_does_not_change_under_mesh_translation_reflection_and_exchange_of_axes(seed in 0u64..10_000, dx in 0usize..16, dy in 0usize..16) {
        let grid = Grid::square(80.0, 16);
        let system = system(grid);
        let mut ws = system.workspace();
        let z = surface(&system, seed, 0.8);
        let field = system.field(&z, &mut ws).clone();
        let mut value = |f: &Array2<f64>| {
            let z = system.amplitudes(f, &mut ws);
            system.at(z, 1.1, &mut ws).state.energy
        };
        let e = value(&field);
        let moved = Array2::from_shape_fn((16, 16), |(j, i)| field[[(j + dy) % 16, (i + dx) % 16]]);
        let mirrored = Array2::from_shape_fn((16, 16), |(j, i)| field[[j, 15 - i]]);
        for other in [moved, mirrored, field.t().as_standard_layout().to_owned()] {
            prop_assert!((value(&other) - e).abs() < 1e-14);
        }
    }

    #[test]
    fn lengths_and_energies_in_other_units_give_the_same_state(unit in 0.01f64..100.0, seed in 0u64..1000) {
        let grid = Grid::square(80.0, 12);
        let one = system(grid);
        let law = Law { surface_energy: LAW.surface_energy * unit, range: LAW.range * unit, ..LAW };
        let other = System::new(Grid { length: grid.length * unit, ..grid }, law, &Indenter::Flat);
        let z = surface(&one, seed, 0.6);
        let scaled: Vec<f64> = z.iter().map(|z| z * unit).collect();
        let a = one.at(z, 1.3, &mut one.workspace()).state;
        let b = other.at(scaled, 1.3 * unit, &mut other.workspace()).state;
        prop_assert!((a.energy * unit - b.energy).abs() < 1e-13 * unit);
        prop_assert!((a.stress - b.stress).abs() < 1e-13);
    }
}

/// The Hessian as a dense matrix over real fields with zero mean, assembled in real space from
/// cosines: nothing of the system's own transforms. Returns its eigenvalues in the metric
/// mean(v^2), ascending.
fn dense_eigenvalues(grid: &Grid, gap: &Array2<f64>) -> Vec<f64> {
    let (ny, nx) = grid.shape();
    let n = nx * ny;
    let signed = |k: usize, n: usize| {
        if 2 * k > n {
            k as f64 - n as f64
        } else {
            k as f64
        }
    };
    let kernel = Array2::from_shape_fn((ny, nx), |(j, i)| {
        let mut sum = 0.0;
        for l in 0..ny {
            for k in 0..nx {
                let q = TAU / grid.length * signed(k, nx).hypot(signed(l, ny));
                sum += q / 2.0
                    * (TAU * (k * i) as f64 / nx as f64 + TAU * (l * j) as f64 / ny as f64).cos();
            }
        }
        sum / n as f64
    });
    let stiffness: Vec<f64> = gap.iter().map(|g| LAW.at(*g).stiffness).collect();
    let mut a = vec![vec![0.0; n]; n];
    for r in 0..n {
        for (s, entry) in a[r].iter_mut().enumerate() {
            *entry = kernel[[(r / nx + ny - s / nx) % ny, (r % nx + nx - s % nx) % nx]];
        }
        a[r][r] += stiffness[r];
    }
    // Project the mean out, P A P with P = 1 - mean, and lift the uniform field out of the way.
    let mean_row: Vec<f64> = (0..n)
        .map(|s| (0..n).map(|r| a[r][s]).sum::<f64>() / n as f64)
        .collect();
    let mean = mean_row.iter().sum::<f64>() / n as f64;
    for (row, row_mean) in a.iter_mut().zip(&mean_row) {
        for (entry, column_mean) in row.iter_mut().zip(&mean_row) {
            *entry += mean - row_mean - column_mean + 10.0 / n as f64;
        }
    }
    symmetric_eigen(a).0
}

#[test]
fn tracked_smallest_eigenvalue_agrees_with_a_dense_matrix_assembled_in_real_space() {
    use tackscope::solver::mechanics::{Mechanics, Slides};
    use tackscope::solver::stability::Tracker;
    for (grid, seed) in [
        (Grid::square(60.0, 8), 8),
        (Grid::line(90.0, 32), 9),
        (Grid::square(40.0, 10), 10),
    ] {
        let system = system(grid);
        let z = surface(&system, seed, 0.5);
        let mut mechanics = Mechanics::new(system, Slides::Never);
        let at = mechanics.at(z, 1.4);
        let dense = dense_eigenvalues(&grid, &at.fields.gap);
        mechanics.refresh(&at.fields);
        let mut tracker = Tracker::new(Pcg64::seed_from_u64(1));
        let (found, _) = tracker.check(&mut mechanics, &at.state.amplitudes, &at.fields);
        assert!(
            (found.value - dense[0]).abs() <= found.error + 1e-12,
            "{grid:?}: {found:?}, dense {}",
            dense[0]
        );
        assert!(
            (found.value - dense[0]).abs() < 2e-3 * PI / grid.length,
            "{grid:?}: {found:?}, dense {}",
            dense[0]
        );
    }
}

#[test]
fn preconditioner_inverts_the_hessian_exactly_within_its_block_of_long_waves() {
    for grid in [Grid::square(60.0, 24), Grid::line(60.0, 24)] {
        let system = system(grid);
        let mut ws = system.workspace();
        // The waves up to six per side: a stated property of the preconditioner, or 5 where 24
        // points allow no more.
        const BLOCK: f64 = 5.0;
        // A stiff state (deep in contact): no pivot is at its floor.
        let z = surface(&system, 11, 0.1);
        let at = system.at(z, 0.1, &mut ws);
        let mut preconditioner = Preconditioner::new(&system, 0.075);
        preconditioner.refresh(&system, &at.fields, &mut ws);
        let long = |v: &mut [f64]| {
            for (pair, z) in v.chunks_exact_mut(2).enumerate() {
                let waves = 2.0 * system.elastic()[2 * pair] / grid.q1();
                if waves > BLOCK + 0.001 || waves == 0.0 {
                    z.fill(0.0);
                }
            }
        };
        let mut r = surface(&system, 12, 1.0);
        long(&mut r);
        let mut x = vec![0.0; r.len()];
        preconditioner.apply(&r, &mut x);
        let mut back = vec![0.0; r.len()];
        system.hessian(&at.fields, &x, &mut back, &mut ws);
        long(&mut back);
        add(&mut back, -1.0, &r);
        assert!(norm(&back) < 1e-12, "{grid:?}: {:e}", norm(&back));
    }
}

#[test]
fn a_moved_surface_has_the_field_of_the_surface_moved() {
    let grid = Grid::square(50.0, 16);
    let system = system(grid);
    let mut ws = system.workspace();
    // Waves at the end of the mesh's spectrum cannot move: leave them out.
    let mut z = surface(&system, 13, 1.0);
    for (z, e) in z.iter_mut().zip(system.elastic()) {
        if 2.0 * e > 7.5 * grid.q1() {
            *z = 0.0;
        }
    }
    let before = system.field(&z, &mut ws).clone();
    let moved = system.moved(&z, 3.0 * grid.spacing(), 0.0);
    let after = system.field(&moved, &mut ws);
    for ((j, i), u) in after.indexed_iter() {
        near(*u, before[[j, (i + 13) % 16]], 1e-13);
    }
}

#[test]
fn a_mie_law_across_zero_gap_has_no_finite_energy() {
    let law = Law {
        shape: Shape::Mie(Mie { m: 8.0, n: 2.0 }),
        ..LAW
    };
    let system = System::new(Grid::square(60.0, 12), law, &Indenter::Flat);
    let z = surface(&system, 14, 2.0);
    assert!(
        !system
            .at(z, 0.5, &mut system.workspace())
            .state
            .energy
            .is_finite()
    );
}

#[test]
fn threads_do_not_change_energy_force_or_hessian_by_a_single_bit() {
    let grid = Grid::square(256.0, 256);
    for make in [System::new, System::even] {
        // A quarter cell is shared from 512 points a side on.
        let grid = if make(grid, LAW, &Indenter::Flat).is_even() {
            Grid::square(256.0, 512)
        } else {
            grid
        };
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| {
                let system = make(grid, LAW, &Indenter::Flat);
                let (z, v) = (surface(&system, 3, 0.4), surface(&system, 4, 1.0));
                let (mut ws, mut hv) = (system.workspace(), vec![0.0; z.len()]);
                let at = system.at(z, 1.5, &mut ws);
                system.hessian(&at.fields, &v, &mut hv, &mut ws);
                (at.state, at.gradient, hv)
            })
        };
        assert_eq!(on(1), on(3));
    }
}

/// A smooth even field of long waves, symmetric under x <-> y only if `symmetric`.
fn amplitudes(system: &System, symmetric: bool) -> Vec<f64> {
    let (ny, nx) = system.shape();
    let mut z = vec![0.0; nx * ny];
    for k in 0..nx.min(7) {
        for l in 0..ny.min(7) {
            let (a, b) = if symmetric {
                (k.max(l), k.min(l))
            } else {
                (k, l)
            };
            z[k * ny + l] = 0.6 * ((3 * a + 5 * b) as f64).sin() / (1 + a * a + b * b) as f64;
        }
    }
    z[0] = 0.0;
    z
}

#[test]
fn energy_stress_and_forces_of_an_even_field_are_those_of_the_whole_cell() {
    for grid in [Grid::square(LENGTH, 32), Grid::line(LENGTH, 32)] {
        let (even, whole) = (System::even(grid, LAW, &Indenter::Flat), system(grid));
        let (mut small, mut large) = (even.workspace(), whole.workspace());
        let z = amplitudes(&even, false);
        let at = even.at(z.clone(), 1.7, &mut small);
        let field: Array2<f64> = even.unfolded(even.field(&z, &mut small));
        let big = whole.at(whole.amplitudes(&field, &mut large), 1.7, &mut large);
        let (one, other) = (&at.state, &big.state);
        near(one.energy, other.energy, 1e-14);
        near(one.stress, other.stress, 1e-14);
        let square = |v: &[f64]| dot(v, v);
        close(square(&at.gradient), square(&big.gradient), 1e-10);
        near(
            even.residual(&at, &mut small),
            whole.residual(&big, &mut large),
            1e-10,
        );
    }
}

#[test]
fn a_tip_on_the_quarter_cell_falls_off_from_its_corner() {
    let grid = Grid::square(2.0, 8);
    let height = Indenter::Hertz(Hertz { radius: 3.0 })
        .even_height(&grid)
        .unwrap();
    // Half a spacing of 0.25 from the apex along each axis, and three and a half along x at the far
    // end.
    assert!((height[[0, 0]] + 2.0 * 0.125_f64.powi(2) / 6.0).abs() < 1e-15);
    assert!((height[[0, 3]] + (0.125_f64.powi(2) + 0.875_f64.powi(2)) / 6.0).abs() < 1e-15);
}

/// The block, assembled from one transform, has the eigenvalues of the Hessian applied to each of
/// its waves.
#[test]
fn the_low_block_is_the_hessian_among_its_waves() {
    for (grid, class) in [
        (Grid::square(LENGTH, 32), Class::Even),
        (Grid::square(LENGTH, 32), Class::Symmetric),
        (Grid::square(LENGTH, 32), Class::Antisymmetric),
        (Grid::line(LENGTH, 24), Class::Even),
    ] {
        let system = System::even(grid, LAW, &Indenter::Flat);
        let mut ws = system.workspace();
        // On the line the waves reach the end of the mesh, where products fold back.
        let reach = if grid.is_line() { 64.0 } else { 6.0 };
        let z = amplitudes(&system, class != Class::Even);
        let at = system.at(z.clone(), 1.7, &mut ws);
        let mut block = LowBlock::new(&system, class, reach);
        block.refresh(&system, &at.fields, &mut ws);

        let unit = |i: usize, n: usize| {
            (0..n)
                .map(|j| if i == j { 1.0 } else { 0.0 })
                .collect::<Vec<f64>>()
        };
        let waves: Vec<Vec<f64>> = (0..block.size())
            .map(|i| block.mode(&unit(i, block.size()), &system))
            .collect();
        let mut image = vec![0.0; z.len()];
        let dense: Vec<Vec<f64>> = waves
            .iter()
            .map(|wave| {
                system.hessian(&at.fields, wave, &mut image, &mut ws);
                waves.iter().map(|other| dot(other, &image)).collect()
            })
            .collect();
        let (values, _) = symmetric_eigen(dense);
        assert_eq!(
            block.negative(),
            values.iter().filter(|v| **v < 0.0).count(),
            "{class:?}"
        );
        let least = values.iter().copied().min_by(f64::total_cmp).unwrap();
        let (softest, _) = block.softest(None);
        // The error goes with the square of a residual of two thousandths.
        near(softest, least, 1e-3 * least.abs());

        // Where it is positive and complete, preconditioning with it undoes the Hessian.
        if block.negative() == 0 && grid.is_line() {
            let mut back = vec![0.0; z.len()];
            system.hessian(&at.fields, &z, &mut image, &mut ws);
            block.precondition(&image, &mut back);
            let worst = back
                .iter()
                .zip(&z)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max);
            assert!(worst < 1e-10, "{worst:e}");
        }
    }
}

/// A ridge modulated along y: the block of modulations has the eigenvalue of the whole cell's
/// Hessian for that mode.
#[test]
fn modulations_of_a_ridge_are_modes_of_the_whole_cell() {
    let (n, u0) = (32, 1.7);
    let (line, square) = (
        System::even(Grid::line(LENGTH, n), LAW, &Indenter::Flat),
        System::even(Grid::square(LENGTH, n), LAW, &Indenter::Flat),
    );
    let z = amplitudes(&line, false);
    let (mut small, mut large) = (line.workspace(), square.workspace());
    let ridge = line.at(z, u0, &mut small);
    let mut block = LowBlock::new(&line, Class::Varicose(1), 64.0);
    block.refresh(&line, &ridge.fields, &mut small);
    let (value, waves) = block.softest(None);
    let mode = block.mode(&waves, &square);

    let on_square = square.at(
        carried(&ridge.state.amplitudes, &line, &square),
        u0,
        &mut large,
    );
    let mut image = vec![0.0; mode.len()];
    square.hessian(&on_square.fields, &mode, &mut image, &mut large);
    let rayleigh = dot(&mode, &image);
    near(rayleigh, value, 1e-10);
}
