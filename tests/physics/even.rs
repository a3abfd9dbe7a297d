//! Even fields on a quarter of the cell say the same as the whole cell.

use ndarray::Array2;
use tackscope::numerics::eigen::symmetric_eigen;
use tackscope::physics::grid::Grid;
use tackscope::physics::indenter::{Hertz, Indenter};
use tackscope::physics::law::{Law, Morse, Shape};
use tackscope::physics::low_block::{Class, LowBlock};
use tackscope::physics::system::{System, carried};

const LENGTH: f64 = 256.0;

fn law() -> Law {
    Law {
        shape: Shape::Morse(Morse),
        surface_energy: 0.15,
        range: 1.0,
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
        let (even, whole) = (
            System::even(grid, law(), &Indenter::Flat),
            System::new(grid, law(), &Indenter::Flat),
        );
        let (mut small, mut large) = (even.workspace(), whole.workspace());
        let z = amplitudes(&even, false);
        let at = even.at(z.clone(), 1.7, &mut small);
        let field: Array2<f64> = even.unfolded(even.field(&z, &mut small));
        let big = whole.at(whole.amplitudes(&field, &mut large), 1.7, &mut large);
        let (one, other) = (&at.state, &big.state);
        assert!(
            (one.energy - other.energy).abs() < 1e-14,
            "{} {}",
            one.energy,
            other.energy
        );
        assert!((one.stress - other.stress).abs() < 1e-14);
        let norm = |v: &[f64]| v.iter().map(|v| v * v).sum::<f64>();
        assert!((norm(&at.gradient) / norm(&big.gradient) - 1.0).abs() < 1e-10);
        assert!((even.residual(&at, &mut small) - whole.residual(&big, &mut large)).abs() < 1e-10);
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
        let system = System::even(grid, law(), &Indenter::Flat);
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
                waves
                    .iter()
                    .map(|other| other.iter().zip(&image).map(|(a, b)| a * b).sum())
                    .collect()
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
        assert!(
            (softest - least).abs() < 1e-3 * least.abs(),
            "{class:?}: {softest} {least}"
        );

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
        System::even(Grid::line(LENGTH, n), law(), &Indenter::Flat),
        System::even(Grid::square(LENGTH, n), law(), &Indenter::Flat),
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
    let rayleigh: f64 = mode.iter().zip(&image).map(|(a, b)| a * b).sum();
    assert!((rayleigh - value).abs() < 1e-10, "{rayleigh} {value}");
}
