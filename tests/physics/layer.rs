//! The layer on a rigid plate, against its boundary-value problem and the thin-film theory.

use crate::{close, near};
use nalgebra::{Matrix4, Vector4};
use std::f64::consts::{PI, TAU};
use tackscope::follow::flat_branch::FlatBranch;
use tackscope::physics::body::{Body, Elastic, Layer};
use tackscope::physics::control::Control;
use tackscope::physics::indenter::Indenter;
use tackscope::physics::law::{Law, Morse, Shape};
use tackscope::physics::mesh::Grid;
use tackscope::physics::system::System;
use tackscope::physics::theory::flat_limits;

/// q t, nu, f: the formula evaluated with 60 digits.
const EXACT: [[f64; 3]; 20] = [
    [1e-4, -0.9, 3.87811635355008e-05],
    [0.03, -0.9, 0.011637063928588983],
    [0.4999, -0.9, 0.20491390332635595],
    [0.5001, -0.9, 0.20500357171395978],
    [2.1, -0.9, 0.8590885955191473],
    [9.0, -0.9, 0.9999990664491866],
    [1e-4, 0.3, 4.081632655976677e-05],
    [0.03, 0.3, 0.012245684059466015],
    [0.4999, 0.3, 0.2066004755515146],
    [2.1, 0.3, 0.7862936891313098],
    [1e-4, 0.49, 3.844675715976499e-06],
    [0.4999, 0.49, 0.07061273272337358],
    [0.5001, 0.49, 0.07066967877794036],
    [9.0, 0.49, 0.9999946976258638],
    [1e-4, 0.5, 6.666666546666669e-13],
    [0.03, 0.5, 1.7970887826917713e-05],
    [0.4999, 0.5, 0.057546169164132986],
    [0.5001, 0.5, 0.057601093296147474],
    [2.1, 0.5, 0.6748950675970762],
    [9.0, 0.5, 0.9999944867747049],
];

const NUS: [f64; 5] = [-0.9, 0.0, 0.3, 0.49, 0.5];

fn layer(thickness: f64, poisson: f64) -> Layer {
    Layer { thickness, poisson }
}

/// Stiffness (E* per thickness) of a layer of thickness 1 to a wave `q`, from its plane-strain
/// boundary-value problem: Airy's function phi = F(y) cos qx with F = A cosh qy + B sinh qy + C y
/// cosh qy + D y sinh qy, and the displacements that belong to it (S. P. Timoshenko and J. N.
/// Goodier, Theory of Elasticity, Art. 18 and 37, with the constants of plane strain). No
/// displacement at y = 0; no shear and a normal traction cos qx at y = 1.
fn by_boundary_values(q: f64, nu: f64) -> f64 {
    let (c, s) = (q.cosh(), q.sinh());
    let twice_shear = 1.0 - nu;
    let inner = 1.0 - nu;
    // 2 G u_x = (q F + (1 - nu) g') sin qx, 2 G u_y = (-F' + (1 - nu) q g) cos qx, with
    // g = (2/q)(C cosh qy + D sinh qy).
    #[rustfmt::skip]
    let conditions = Matrix4::new(
        q, 0.0, 0.0, 2.0 * inner,
        0.0, -q, 2.0 * inner - 1.0, 0.0,
        q * s, q * c, c + q * s, s + q * c,
        c, s, c, s,
    );
    let given = Vector4::new(0.0, 0.0, 0.0, -1.0 / (q * q));
    let found = conditions.lu().solve(&given).expect("one solution");
    let [a, b, cc, d] = found.into();
    let slope = a * q * s + b * q * c + cc * (c + q * s) + d * (s + q * c);
    let displacement = (-slope + 2.0 * inner * (cc * c + d * s)) / twice_shear;
    1.0 / displacement
}

#[test]
fn the_stiffness_of_every_wave_is_that_of_the_boundary_value_problem() {
    for nu in NUS {
        for x in [0.2, 0.5, 1.0, 2.0, 3.0, 5.0, 8.0] {
            let exact = by_boundary_values(x, nu);
            let found = layer(3.0, nu).stiffness(x / 3.0) * 3.0;
            close(found, exact, 1e-10);
        }
    }
}

#[test]
fn the_closed_form_keeps_its_digits_for_thick_and_thin() {
    for [x, nu, exact] in EXACT {
        let found = layer(1.0, nu).compliance(x);
        close(found, exact, 2e-15);
    }
}

#[test]
fn a_thick_layer_is_a_half_space_and_a_thin_one_a_uniaxial_spring() {
    for nu in NUS {
        for x in [20.0, 1e3, 1e300] {
            let short = (layer(1.0, nu).compliance(x) - 1.0).abs();
            assert!(short <= 2e-14, "{nu} {x}: {short}");
        }
        let thin = layer(2.0, nu);
        if nu < 0.5 {
            let ratio = thin.stiffness(1e-6) / thin.mean_stiffness();
            assert!((ratio - 1.0).abs() < 1e-9, "{nu}: {ratio}");
        } else {
            // Lubrication: f = 2 x^3/3 (1 - 9 x^2/5 ...).
            let (x, cube) = (1e-3_f64, 2e-9 / 3.0);
            let ratio = thin.compliance(x) / cube;
            assert!((ratio - 1.0 + 1.8 * x * x).abs() < 1e-11, "{ratio}");
            assert_eq!(thin.mean_stiffness(), f64::INFINITY);
        }
        for i in 1..2000 {
            let x = f64::from(i) * 0.01;
            let found = layer(1.0, nu).compliance(x);
            assert!(found > 0.0 && found <= 1.0, "{nu} {x}: {found}");
        }
    }
}

/// The minimum of a function with one between two ends, by golden sections: (where, value).
fn minimum(of: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> [f64; 2] {
    let share = (5f64.sqrt() - 1.0) / 2.0;
    for _ in 0..60 {
        let (a, b) = (high - share * (high - low), low + share * (high - low));
        if of(a) < of(b) {
            high = b;
        } else {
            low = a;
        }
    }
    let at = 0.5 * (low + high);
    [at, of(at)]
}

fn morse(surface_energy: f64) -> Law {
    Law {
        shape: Shape::Morse(Morse),
        surface_energy,
        range: 1.0,
    }
}

/// V. Shenoy and A. Sharma, Phys. Rev. Lett. 86, 119 (2001): an incompressible film gives way to a
/// wave of 2.96 thicknesses where the softening is 6.22 G/t.
#[test]
fn an_incompressible_film_gives_way_to_a_wave_of_three_thicknesses_whatever_the_cell() {
    let shear = 0.25;
    let [q, stiffness] = minimum(|q| by_boundary_values(q, 0.5), 1.0, 4.0);
    near(TAU / q, 2.96, 5e-3);
    near(stiffness / shear, 6.22, 5e-3);
    let thickness = 0.02;
    for length in [30.0, 41.0] {
        let grid = Grid::line(length, 4096);
        let body = Body::Layer(layer(thickness, 0.5));
        let system = System::new(grid, morse(1.0), &Indenter::Flat).with_body(body);
        let waves = system.elastic().iter().step_by(2).copied().enumerate();
        let (periods, softest) = waves.skip(1).min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        let wavelength = length / periods as f64;
        close(wavelength * q / thickness, TAU, 1e-3);
        close(softest * thickness, stiffness, 1e-6);
        assert_eq!(PI / system.equivalent_length(), softest);
        // A law that softens a little less, and a little more.
        let critical = |share: f64| morse(4.0 * share * stiffness / thickness);
        for (share, unstable) in [(1.0 - 1e-3, false), (1.0 + 1e-3, true)] {
            let limits = flat_limits(&critical(share), system.equivalent_length());
            assert_eq!(limits.is_some(), unstable, "{share}");
        }
    }
}

#[test]
fn the_softest_wave_is_the_softest_of_the_mesh_also_where_two_directions_mix() {
    for (points, thickness, nu) in [
        (16, 5.0, 0.5),
        (32, 1.7, 0.45),
        (8, 0.05, 0.5),
        (32, 90.0, 0.3),
    ] {
        let (grid, body) = (
            Grid::square(20.0, points),
            Body::Layer(layer(thickness, nu)),
        );
        let system = System::new(grid, morse(1.0), &Indenter::Flat).with_body(body);
        let least = system.elastic()[2..]
            .iter()
            .fold(f64::INFINITY, |a, b| a.min(*b));
        let ratio = PI / body.equivalent_length(&grid) / least;
        assert!((ratio - 1.0).abs() < 1e-14, "{points} {thickness}: {ratio}");
        let wave = system.softest_wave();
        let energy: f64 = wave
            .iter()
            .zip(system.elastic())
            .map(|(z, e)| e * z * z)
            .sum();
        close(energy, least, 1e-14);
        let longest = (system.elastic()[2 * grid.ny] / least - 1.0).abs() < 1e-14;
        assert_eq!(body.is_softest_at_its_longest(&grid), longest);
    }
}

/// At its limit the flat state has no stiffness left along the softest wave, and some along every
/// other.
#[test]
fn the_flat_state_of_a_layer_ends_where_its_hessian_says() {
    let (grid, body) = (Grid::square(20.0, 16), Body::Layer(layer(2.0, 0.5)));
    let (law, length) = (morse(6.0), body.equivalent_length(&grid));
    let (lower, upper) = flat_limits(&law, length).unwrap();
    let system = System::new(grid, law, &Indenter::Flat).with_body(body);
    let mut workspace = system.workspace();
    for gap in [lower, upper] {
        let at = system.uniform(gap);
        let mut least = f64::INFINITY;
        for i in (2..system.dimension()).step_by(2) {
            let mut wave = vec![0.0; system.dimension()];
            wave[i] = 1.0;
            system.make_real(&mut wave);
            let mut image = wave.clone();
            system.hessian(&at.fields, &wave, &mut image, &mut workspace);
            least = least.min(image[i] / wave[i]);
        }
        assert!(least.abs() < 1e-12, "{gap}: {least}");
    }
    let branch = FlatBranch::new(law, length, Control::Displacement);
    assert!(branch.is_stable(upper + 1e-6) && !branch.is_stable(upper - 1e-6));
}

#[test]
fn force_and_hessian_of_a_layer_are_derivatives_of_its_energy() {
    let body = Body::Layer(layer(1.5, 0.4));
    let control = Control::Displacement.in_series(body.elastic().mean_stiffness());
    assert!(control.frees_mean());
    for system in [
        System::new(Grid::square(10.0, 8), morse(0.5), &Indenter::Flat),
        System::even(Grid::square(10.0, 8), morse(0.5), &Indenter::Flat),
    ] {
        let system = system.with_body(body).with_control(control);
        let mut ws = system.workspace();
        let wave = |seed: f64| {
            let mut z: Vec<f64> = (0..system.dimension())
                .map(|i| 0.05 * (seed * (i + 1) as f64).sin())
                .collect();
            system.make_real(&mut z);
            z
        };
        let (z, v, h) = (wave(1.3), wave(0.7), 1e-4);
        let moved = |t: f64| z.iter().zip(&v).map(|(z, v)| z + t * v).collect::<Vec<_>>();
        let here = system.at(z.clone(), 1.2, &mut ws);
        let [up, down] = [h, -h].map(|t| system.at(moved(t), 1.2, &mut system.workspace()));
        let along = |g: &[f64]| g.iter().zip(&v).map(|(g, v)| g * v).sum::<f64>();
        let slope = (up.state.energy - down.state.energy) / (2.0 * h);
        near(slope, along(&here.gradient), 1e-9);
        let mut image = v.clone();
        system.hessian(&here.fields, &v, &mut image, &mut ws);
        for ((a, b), i) in up.gradient.iter().zip(&down.gradient).zip(&image) {
            near((a - b) / (2.0 * h), *i, 1e-9);
        }
    }
}

#[test]
fn a_machine_pulls_through_a_compressible_layer_and_holds_the_surface_of_an_incompressible_one() {
    let mean = layer(2.0, 0.25).mean_stiffness();
    // M = (1 - nu)^2/(1 - 2 nu) E*.
    near(mean, 0.5625 / 0.5 / 2.0, 1e-15);
    let spring = |stiffness| Control::Spring { stiffness };
    assert_eq!(Control::Displacement.in_series(mean), spring(mean));
    assert_eq!(spring(mean).in_series(mean), spring(0.5 * mean));
    assert_eq!(Control::Load.in_series(mean), Control::Load);
    for control in Control::all(0.3) {
        assert_eq!(control.in_series(layer(2.0, 0.5).mean_stiffness()), control);
    }
}
