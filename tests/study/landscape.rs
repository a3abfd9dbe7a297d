//! The energy landscape: saddles, barriers and the paths over them, against how barriers must
//! vanish, dense eigenvalues, the gradient, and the work of the stress.

use crate::dense::Dense;
use crate::loops::{flat_ground, preset_on};
use ndarray::Array2;
use std::f64::consts::{LN_2, PI};
use tackscope::follow::diagram::{Branch, Diagram, Kind};
use tackscope::numerics::dense::{dot, norm};
use tackscope::numerics::threads::Cancel;
use tackscope::physics::control::Control;
use tackscope::physics::indenter::{Indenter, Wave};
use tackscope::physics::law::{Morse, Shape};
use tackscope::physics::mesh::Grid;
use tackscope::physics::pattern::Pattern;
use tackscope::physics::system::System;
use tackscope::physics::theory::flat_limits;
use tackscope::scene::{Model, Points, Scene, Turn};
use tackscope::solver::Lost;
use tackscope::solver::mechanics::{Mechanics, Slides};
use tackscope::study::landscape::{Ground, Landscape, Pass, Place, Saddle, Standing};
use tackscope::study::plan;

/// A scene with its branches.
struct Known {
    scene: Scene,
    model: Model,
    diagram: Diagram,
    cancel: Cancel,
}

impl Known {
    fn of(scene: Scene) -> Self {
        let cancel = Cancel::default();
        let diagram = plan::diagram(&scene, &cancel, &mut |_, _, _| {}).unwrap();
        Self {
            model: scene.model().unwrap(),
            scene,
            diagram,
            cancel,
        }
    }

    fn fig2() -> Self {
        Self::of(preset_on("fig2", Points::Square(48)))
    }

    fn ground(&self) -> Ground<'_> {
        Ground {
            scene: &self.scene,
            model: &self.model,
            diagram: &self.diagram,
            cancel: &self.cancel,
        }
    }

    /// The stable state of a branch of this name at `u0`.
    fn state(&self, branch: &str, u0: f64) -> Standing {
        let mut stable = self.diagram.pieces(0);
        let piece = stable.find(|piece| piece.branch.name == branch && piece.holds(u0));
        Standing::on(&piece.unwrap_or_else(|| panic!("{branch} at {u0}")), u0)
    }

    fn around(&self, branch: &str, u0: f64) -> Landscape {
        let state = self.state(branch, u0);
        let found = Landscape::around(self.ground(), state, None, &mut |_, _| {}).unwrap();
        assert!(found.missing.is_empty(), "{:?}", found.missing);
        found
    }

    /// u0 of the events of a branch.
    fn events(&self, branch: &str, kind: Kind) -> Vec<f64> {
        let of = |(b, _): &(&Branch, _)| b.name == branch;
        let events = self.diagram.events().filter(of);
        events
            .filter(|(_, point)| point.kind == kind)
            .map(|(_, point)| point.state.mean_displacement)
            .collect()
    }

    /// How a barrier falls towards the end of its state at `end`: the power of the distance,
    /// between distances that are halved from `first` ranges on, away from the end in the direction
    /// `side`.
    fn powers(&self, branch: &str, end: f64, side: f64, first: f64) -> Vec<f64> {
        let barriers: Vec<f64> = (0..4)
            .map(|i| {
                let far = first * 0.5f64.powi(i) * self.model.law.range;
                let found = self.around(branch, end + side * far);
                found.passes[0].barrier()
            })
            .collect();
        let powers = barriers.windows(2).map(|pair| (pair[0] / pair[1]).log2());
        powers.collect()
    }
}

/// Crests in a row: what breaks their symmetry does so in several equal ways.
#[test]
fn copies_of_a_saddle_by_symmetry_are_one() {
    let mut scene = flat_ground(Shape::Morse(Morse), 2.04, Points::Line(40));
    scene.law.surface_energy = 0.19;
    scene.indenter = Indenter::Wave(Wave {
        amplitude: 0.0777,
        periods: [2, 0],
    });
    (scene.drive.start, scene.drive.turn) = (6.0, Turn::At(-0.3));
    scene.cell.length = 135.0887;
    let known = Known::of(scene);
    let (ground, gamma) = (known.ground(), known.model.law.surface_energy);
    let pieces: Vec<_> = known.diagram.pieces(1).collect();
    let pairs = pieces.iter().enumerate();
    let pairs = pairs.flat_map(|(i, a)| pieces[i + 1..].iter().filter_map(|b| a.common(b)));
    let mut copies = 0;
    for [low, high] in pairs {
        let control = low + 0.9 * (high - low);
        let energies = ground.saddles(control).unwrap().found.into_iter();
        let mut energies: Vec<f64> = energies.map(|(saddle, _)| saddle.place.energy).collect();
        energies.sort_by(f64::total_cmp);
        let apart = energies.windows(2).map(|pair| (pair[1] - pair[0]) / gamma);
        let nearest = apart.fold(f64::INFINITY, f64::min);
        assert!(nearest > 1e-7, "{nearest:e} gamma apart at {control}");
        let held = pieces.iter().filter(|piece| piece.holds(control));
        copies += held.count() - energies.len();
    }
    assert!(copies > 0, "the test needs copies");
}

/// True if these powers tend to `goal`: each is nearer than the one before, or as near as located
/// ends allow, and the last is `near`.
fn tends(powers: &[f64], goal: f64, near: f64) -> bool {
    let off: Vec<f64> = powers.iter().map(|power| (power - goal).abs()).collect();
    let nearer = |pair: &[f64]| pair[1] < pair[0].max(3e-3);
    off.windows(2).all(nearer) && off[off.len() - 1] < near
}

#[test]
fn a_barrier_vanishes_as_the_square_of_the_distance_to_a_subcritical_bifurcation() {
    let known = Known::fig2();
    let (low, high) = flat_limits(&known.model.law, known.model.grid.length).unwrap();
    let bulge = known.events("square", Kind::Bifurcation)[1];
    for (branch, end, side) in [
        ("flat", high, 1.0),
        ("flat", low, -1.0),
        ("square", bulge, 1.0),
    ] {
        let powers = known.powers(branch, end, side, 0.02);
        assert!(tends(&powers, 2.0, 0.04), "{branch} at {end}: {powers:?}");
    }
}

#[test]
fn a_barrier_vanishes_as_the_distance_to_a_fold_to_the_power_of_three_halves() {
    let known = Known::fig2();
    let folds = known.events("square", Kind::Fold);
    for (end, side) in [(folds[0], -1.0), (folds[3], 1.0)] {
        let powers = known.powers("square", end, side, 0.04);
        assert!(tends(&powers, 1.5, 6e-3), "at {end}: {powers:?}");
    }
}

#[test]
fn a_tip_is_held_by_barriers_that_vanish_at_both_its_folds() {
    // The coarsest mesh on which this tip still jumps.
    let known = Known::of(preset_on("hertz", Points::Square(64)));
    let rho = known.model.law.range;
    let folds = known.events("contact", Kind::Fold);
    let (low, high) = (folds[1].min(folds[0]), folds[1].max(folds[0]));
    for (end, side) in [(low, 1.0), (high, -1.0)] {
        // Next to the end the state that ends is the first of the two stable ones.
        let barriers: Vec<f64> = (0..3)
            .map(|i| {
                let u0 = end + side * 0.02 * 0.5f64.powi(i) * rho;
                let stable = known.diagram.pieces(0).filter(|piece| piece.holds(u0));
                let lowest = stable.map(|piece| {
                    let state = Standing::on(&piece, u0);
                    let found =
                        Landscape::around(known.ground(), state, None, &mut |_, _| {}).unwrap();
                    assert_eq!(found.passes.len(), 1);
                    found.passes[0].barrier()
                });
                lowest.fold(f64::INFINITY, f64::min)
            })
            .collect();
        let powers: Vec<f64> = barriers.windows(2).map(|p| (p[0] / p[1]).log2()).collect();
        assert!(
            tends(&powers, 1.5, 2e-3),
            "at {end}: {barriers:?} {powers:?}"
        );
    }
}

/// Energy rises to the saddle and falls beyond it, along a way that never turns back.
fn assert_is_a_pass(pass: &Pass) {
    let arcs = pass.path.windows(2).all(|pair| pair[0].arc < pair[1].arc);
    let (up, down) = (&pass.path[..=pass.saddle], &pass.path[pass.saddle..]);
    let rises = up.windows(2).all(|pair| pair[0].energy <= pair[1].energy);
    let falls = down.windows(2).all(|pair| pair[0].energy >= pair[1].energy);
    assert!(arcs && rises && falls && pass.path[0].arc == 0.0);
    let (first, last) = (&pass.path[0], &pass.path[pass.path.len() - 1]);
    let top = &pass.path[pass.saddle];
    assert!(top.energy > first.energy && top.energy > last.energy);
}

#[test]
fn every_stable_state_of_fig_2_has_its_neighbours_and_energy_falls_on_both_sides_of_each_saddle() {
    let known = Known::fig2();
    let expected: [(&str, f64, &[Pattern]); 7] = [
        ("flat", 3.99, &[]),
        ("flat", 3.5, &[Pattern::Bulge]),
        ("square", 3.5, &[Pattern::Ridge, Pattern::Flat]),
        ("ridge", 3.5, &[Pattern::Bulge]),
        ("ridge", 2.0, &[Pattern::Dimple]),
        ("square", 0.7, &[Pattern::Flat]),
        ("flat", 0.7, &[Pattern::Dimple]),
    ];
    for (branch, u0, neighbours) in expected {
        let found = known.around(branch, u0);
        let patterns: Vec<Pattern> = found.passes.iter().map(|pass| pass.to).collect();
        assert_eq!(patterns, neighbours, "{branch} at {u0}");
        let state = known.state(branch, u0);
        for pass in &found.passes {
            assert_is_a_pass(pass);
            // The path begins where the state is, on whatever mesh its branch was followed.
            let off = (pass.path[0].energy - state.energy).abs() / known.model.law.surface_energy;
            assert!(off < 1e-6, "{branch} at {u0}: {off:e}");
        }
    }
}

/// The derivative of the energy at a place of a flat square cell.
fn gradient(mechanics: &mut Mechanics, place: &Place) -> (Vec<f64>, Vec<f64>) {
    let z = mechanics.amplitudes(&place.gap);
    let at = mechanics.at(z, place.mean_displacement);
    (at.state.amplitudes, at.gradient)
}

#[test]
fn the_path_goes_against_the_gradient() {
    let known = Known::fig2();
    let found = known.around("square", 3.5);
    let pass = &found.passes[0];
    assert_eq!(pass.branch, "mixed_1");
    let grid = Grid::square(known.model.grid.length, 48);
    let system = System::new(grid, known.model.law, &Indenter::Flat);
    let mut mechanics = Mechanics::new(system, Slides::Freely);
    let range = known.model.law.range;
    let mut compared = 0;
    for three in pass.path.windows(3) {
        let way = three[2].arc - three[0].arc;
        // Next to an equilibrium the gradient vanishes.
        let near = |place: &Place| (three[1].arc - place.arc).abs() < 0.1 * range;
        let top = &pass.path[pass.saddle];
        if near(top) || near(&pass.path[0]) || near(&pass.path[pass.path.len() - 1]) {
            continue;
        }
        let [before, here, after] = [0, 1, 2].map(|i| gradient(&mut mechanics, &three[i]));
        let chord: Vec<f64> = after.0.iter().zip(&before.0).map(|(a, b)| a - b).collect();
        let cosine = dot(&chord, &here.1) / (norm(&chord) * norm(&here.1));
        let uphill = three[1].arc < top.arc;
        let along = if uphill { cosine } else { -cosine };
        assert!(along > 0.995, "{along} at {}", three[1].arc / range);
        // And arc length is the distance of whole surfaces.
        assert!((norm(&chord) / way - 1.0).abs() < 5e-3);
        compared += 1;
    }
    assert!(compared > 15, "{compared}");
}

#[test]
fn a_saddle_has_one_negative_eigenvalue_over_all_modes_and_its_sides_have_none() {
    let scene = flat_ground(Shape::Morse(Morse), 1.6, Points::Square(16));
    let known = Known::of(scene);
    let law = known.model.law;
    let (_, high) = flat_limits(&law, known.model.grid.length).unwrap();
    let mut looked = 0;
    for u0 in [high + 0.05, high - 0.3, high - 0.6] {
        for (Saddle { place, sides, .. }, piece) in known.ground().saddles(u0).unwrap().found {
            let own = piece.branch.system.grid();
            let grid = Grid::square(own.length, own.nx);
            let dense = Dense::new(grid, f64::INFINITY);
            let negative = |place: &Place| {
                let gap: &Array2<f64> = &place.gap;
                let matrix = dense.at(gap, gap, &law, [true; 2], true);
                let values = matrix.symmetric_eigenvalues();
                // A flat state's own limit is not met here.
                values.iter().filter(|value| **value < -1e-7).count()
            };
            assert_eq!(negative(&place), 1, "{} at {u0}", piece.branch.name);
            for side in &sides {
                assert_eq!(negative(&side[side.len() - 1]), 0, "beside it at {u0}");
            }
            looked += 1;
        }
    }
    assert!(looked >= 3, "{looked}");
}

#[test]
fn a_barrier_changes_with_u0_by_the_stress_of_the_saddle_less_that_of_the_state() {
    let known = Known::fig2();
    let step = 1e-3 * known.model.law.range;
    for (branch, u0) in [("flat", 3.5), ("square", 3.2), ("ridge", 2.0)] {
        let [below, here, above] = [-step, 0.0, step].map(|by| known.around(branch, u0 + by));
        for (i, pass) in here.passes.iter().enumerate() {
            let [low, high] = [&below, &above].map(|found| found.passes[i].barrier());
            let rate = (high - low) / (2.0 * step);
            let expected = pass.path[pass.saddle].stress - pass.path[0].stress;
            assert!((rate / expected - 1.0).abs() < 1e-6, "{rate} {expected}");
        }
    }
}

#[test]
fn the_curve_of_a_barrier_goes_through_it_and_ends_at_zero_where_the_state_gives_way() {
    let known = Known::fig2();
    let gamma = known.model.law.surface_energy;
    let (_, high) = flat_limits(&known.model.law, known.model.grid.length).unwrap();
    let found = known.around("flat", 3.5);
    let curve = &found.passes[0].barriers;
    let folds = known.events("square", Kind::Fold);
    let (first, last) = (curve[0], curve[curve.len() - 1]);
    // From the flat limit, where it is zero, to the fold where the other state ends.
    assert!((first[0] - high).abs() < 1e-9 && (last[0] - folds[0]).abs() < 1e-9);
    assert!(first[1].abs() < 1e-9 * gamma && last[1] > 5e-3 * gamma);
    let next = curve.partition_point(|[u0, _]| *u0 < 3.5);
    let [a, b] = [curve[next - 1], curve[next]];
    let between = a[1] + (3.5 - a[0]) / (b[0] - a[0]) * (b[1] - a[1]);
    let off = (between - found.passes[0].barrier()).abs() / gamma;
    assert!(off < 2e-6, "{off:e}");
}

/// Where `value` falls below zero between two gaps.
fn root(mut low: f64, mut high: f64, value: impl Fn(f64) -> f64) -> f64 {
    let rising = value(high) > 0.0;
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if (value(middle) > 0.0) == rising {
            high = middle;
        } else {
            low = middle;
        }
    }
    0.5 * (low + high)
}

#[test]
fn a_block_on_a_soft_spring_is_held_by_the_barrier_of_its_closed_form() {
    let mut scene = flat_ground(Shape::Morse(Morse), 1.6, Points::Square(16));
    let law = scene.model().unwrap().law;
    // Softer than the longest wave: no pattern is near.
    let longest = PI / scene.cell.length;
    let stiffness = 0.5 * longest;
    scene.drive.control = Control::Spring { stiffness };
    // The stage stands at w = u0 + traction/k, which falls where gamma'' < -k.
    let stage = |u0: f64| u0 + law.at(u0).traction / stiffness;
    let rest = law.equilibrium_gap();
    let soft = |stiffness: f64| move |u0: f64| law.at(u0).stiffness + stiffness;
    let inflexion = rest + 2.0 * LN_2 * law.range;
    let first = root(rest, inflexion, soft(stiffness));
    let last = root(inflexion, 60.0 * law.range, soft(stiffness));
    // Too soft for the spring, and not for the longest wave.
    let top = root(rest, inflexion, soft(0.75 * longest));
    let w = stage(top);
    scene.drive.start = stage(first) + 10.0 * law.range;
    scene.drive.turn = Turn::At(rest);
    let energy = |u0: f64| law.at(u0).energy + 0.5 * stiffness * (w - u0).powi(2);
    let off = |u0: f64| stage(u0) - w;
    let (near, far) = (root(rest, first, off), root(last, w, off));
    let known = Known::of(scene);
    for (u0, other) in [(near, far), (far, near)] {
        let state = Standing {
            control: w,
            stress: law.at(u0).traction,
            energy: energy(u0),
        };
        let found = Landscape::around(known.ground(), state, None, &mut |_, _| {}).unwrap();
        let pass = found.passes.iter().find(|pass| pass.branch == "flat");
        let pass = pass.expect("the block's own saddle");
        let exact = [energy(top) - energy(u0), energy(u0) - energy(other)];
        for (computed, exact) in [pass.barrier(), pass.released()].into_iter().zip(exact) {
            let error = (computed - exact).abs() / law.surface_energy;
            assert!(error < 1e-10, "{computed} {exact}");
        }
        assert_is_a_pass(pass);
        // All of the body moves by as much.
        let arc = pass.path[pass.path.len() - 1].arc;
        assert!((arc / (far - near) - 1.0).abs() < 1e-6, "{arc}");
    }
}

#[test]
fn under_a_load_a_body_in_contact_is_held_by_the_barrier_to_where_the_traction_is_the_load_again() {
    let mut scene = flat_ground(Shape::Morse(Morse), 1.05, Points::Square(16));
    let law = scene.model().unwrap().law;
    let longest = PI / scene.cell.length;
    // Where the law softens, but less than the longest wave is stiff.
    let inflexion = law.equilibrium_gap() + 2.0 * LN_2 * law.range;
    let softer = |u0: f64| law.at(u0).stiffness + 0.5 * longest;
    let top = root(law.equilibrium_gap(), inflexion, softer);
    let load = law.at(top).traction;
    let near = root(law.equilibrium_gap(), law.contact_gap(), |u0| {
        law.at(u0).traction - load
    });
    scene.drive.control = Control::Load;
    scene.drive.start = 1.1 * law.traction_max();
    scene.drive.turn = Turn::At(-0.1 * law.traction_max());
    let known = Known::of(scene);
    let energy = |u0: f64| law.at(u0).energy - load * u0;
    let state = Standing {
        control: load,
        stress: load,
        energy: energy(near),
    };
    let found = Landscape::around(known.ground(), state, None, &mut |_, _| {}).unwrap();
    assert!(found.missing.is_empty(), "{:?}", found.missing);
    let pass = &found.passes[0];
    let error = (pass.barrier() - energy(top) + energy(near)).abs() / law.surface_energy;
    assert!(error < 1e-12, "{error:e}");
    assert_is_a_pass(pass);
    // It is let go of far from the ground.
    let end = &pass.path[pass.path.len() - 1];
    assert!(law.at(end.mean_displacement).traction < 0.05 * load);
    assert_eq!(pass.to, Pattern::Flat);
}

#[test]
fn a_search_that_is_cancelled_ends_at_once() {
    let known = Known::fig2();
    let state = known.state("flat", 3.5);
    known.cancel.request();
    let end = Landscape::around(known.ground(), state, None, &mut |_, _| {});
    assert_eq!(end.unwrap_err(), Lost::Cancelled);
}
