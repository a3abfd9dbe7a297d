//! The whole diagram: every branch, stable and unstable, against dense eigenvalues, the loops of
//! the walk and the atlas, and itself on another mesh.

use crate::dense::Dense;
use crate::loops::{flat_ground, planned, preset, preset_on, walked};
use ndarray::Array2;
use std::collections::BTreeSet;
use tackscope::follow::atlas::Atlas;
use tackscope::follow::diagram::{Branch, Diagram, Ending, Kind, Point};
use tackscope::follow::record::{Cause, JumpRecord};
use tackscope::follow::run::LoopRun;
use tackscope::numerics::threads::Cancel;
use tackscope::physics::law::{Mie, Morse, Shape};
use tackscope::physics::mesh::Grid;
use tackscope::physics::pattern::Pattern;
use tackscope::physics::system::System;
use tackscope::physics::theory::jkr::{Jkr, PeriodicJkr};
use tackscope::physics::theory::{flat_limits, ridge};
use tackscope::scene::{Part, Points, Scene, Turn};

pub fn diagram(scene: &Scene, part: Part) -> Diagram {
    let found = Diagram::of(scene, part, &Cancel::default(), &mut |_, _, _| {}).unwrap();
    assert!(found.is_complete(), "{}: {:?}", scene.title, found.missing);
    found
}

fn fig2(points: usize) -> Scene {
    preset_on("fig2", Points::Square(points))
}

pub fn branch<'d>(diagram: &'d Diagram, name: &str) -> &'d Branch {
    diagram.branches.iter().find(|b| b.name == name).unwrap()
}

/// Kind, index before and after of every fold and bifurcation, u0 beside them.
pub fn events(branch: &Branch) -> Vec<(Kind, [usize; 2], f64)> {
    let special = branch.points.iter().filter(|p| p.kind != Kind::Regular);
    special
        .map(|p| (p.kind, p.index, p.state.mean_displacement))
        .collect()
}

fn ends(branch: &Branch) -> [f64; 2] {
    let at = |p: &Point| p.state.mean_displacement;
    [
        at(&branch.points[0]),
        at(&branch.points[branch.points.len() - 1]),
    ]
}

/// How far in u0 a jump is from the nearest fold or bifurcation.
pub fn nearest_event(diagram: &Diagram, jump: &JumpRecord) -> f64 {
    let far = |p: &Point| (p.state.mean_displacement - jump.mean_displacement).abs();
    let all = diagram.events().map(|(_, point)| far(point));
    all.fold(f64::INFINITY, f64::min)
}

/// Every jump of a loop that leaves a pattern lies at a fold or a bifurcation of the diagram: both
/// are located within 1e-5 ranges.
pub fn holds_jumps_of(diagram: &Diagram, run: &LoopRun, range: f64) {
    let jumps = run.record.jumps.iter();
    let patterned: Vec<_> = jumps.filter(|j| j.cause != Cause::FlatLimit).collect();
    for jump in &patterned {
        let nearest = nearest_event(diagram, jump);
        assert!(nearest < 2e-5 * range, "{jump:?}: {nearest:e}");
    }
    assert!(patterned.len() >= 2, "{} jumps", patterned.len());
}

#[test]
fn fig_2_has_one_square_branch_one_of_ridges_and_two_that_join_them() {
    let scene = fig2(48);
    let found = diagram(&scene, Part::Whole);
    let names: Vec<&str> = found.branches.iter().map(|b| &*b.name).collect();
    assert_eq!(names, ["flat", "square", "ridge", "mixed_1", "mixed_2"]);

    let model = scene.model().unwrap();
    let (low, high) = flat_limits(&model.law, model.grid.length).unwrap();
    for name in ["square", "ridge"] {
        assert_eq!(branch(&found, name).ending, Ending::Flat);
        assert_eq!(ends(branch(&found, name)), [high, low], "{name}");
    }
    // Out of the flat state, a fold makes it stable; it breaks its symmetry; the S between bulge
    // and dimple; and so on to the last fold.
    let square = events(branch(&found, "square"));
    let kinds: Vec<_> = square.iter().map(|e| (e.0, e.1)).collect();
    let (fold, bifurcation) = (Kind::Fold, Kind::Bifurcation);
    let expected = [
        (bifurcation, [1, 1]),
        (fold, [1, 0]),
        (bifurcation, [0, 1]),
        (fold, [1, 2]),
        (fold, [2, 1]),
        (bifurcation, [1, 0]),
        (fold, [0, 1]),
        (bifurcation, [1, 1]),
    ];
    assert_eq!(kinds, expected);
    let stable = |pattern: Pattern| {
        let points = branch(&found, "square").points.iter();
        points
            .filter(|p| p.pattern == pattern && p.index == [0, 0])
            .count()
    };
    assert!(stable(Pattern::Bulge) > 2 && stable(Pattern::Dimple) > 2);

    // Both join a break-up of a square pattern to one of a ridge, and are subcritical: nowhere
    // stable.
    let breaks = |name: &str| -> Vec<f64> {
        let of_zero = events(branch(&found, name)).into_iter();
        of_zero
            .filter(|(kind, index, _)| *kind == bifurcation && index.contains(&0))
            .map(|(.., u0)| u0)
            .collect()
    };
    let (squares, ridges) = (breaks("square"), breaks("ridge"));
    for (name, from, to) in [
        ("mixed_1", squares[0], ridges[0]),
        ("mixed_2", squares[1], ridges[1]),
    ] {
        let mixed = branch(&found, name);
        assert_eq!(
            (mixed.ending, ends(mixed)),
            (Ending::Joined, [from, to]),
            "{name}"
        );
        assert!(mixed.points.iter().all(|p| p.index == [1, 1]), "{name}");
    }
    holds_jumps_of(&found, &planned(&scene), 1.0);
}

#[test]
fn folds_and_bifurcations_of_fig_2_are_the_same_on_a_finer_mesh() {
    let [coarse, fine] = [48, 64].map(|n| diagram(&fig2(n), Part::Whole));
    let (a, b): (Vec<_>, Vec<_>) = (coarse.events().collect(), fine.events().collect());
    assert_eq!(a.len(), b.len());
    for ((branch, p), (_, q)) in a.iter().zip(&b) {
        let apart = (p.state.mean_displacement - q.state.mean_displacement).abs();
        assert!(
            apart < 1e-4,
            "{}: {apart:e} at {}",
            branch.name,
            p.state.mean_displacement
        );
        assert_eq!((p.kind, p.index), (q.kind, q.index), "{}", branch.name);
    }
}

#[test]
fn a_long_cell_has_a_stable_bulge_that_no_path_reaches() {
    let scene = preset_on("fig3", Points::Square(192));
    let found = diagram(&scene, Part::Whole);
    let bulges = branch(&found, "square").points.iter();
    let stable = bulges.filter(|p| p.pattern == Pattern::Bulge && p.index == [0, 0]);
    assert!(stable.count() > 5);
    let model = scene.model().unwrap();
    let mut atlas = Atlas::of(&scene, &model);
    let drive = &scene.drive;
    let Turn::At(turn) = drive.turn else {
        panic!("a number")
    };
    let jumps = atlas.cycle(drive.start, turn).unwrap().jumps;
    let patterns: Vec<Pattern> = jumps.iter().map(|jump| jump.to).collect();
    assert!(patterns.contains(&Pattern::Ridge) && !patterns.contains(&Pattern::Bulge));
}

/// The index of points all along each branch is the number of negative eigenvalues of the dense
/// Hessian of the whole cell, which knows nothing of classes, blocks or branches. Returns the
/// branches, and the numbers.
pub fn dense_indices(scene: &Scene) -> (BTreeSet<String>, BTreeSet<usize>) {
    let law = scene.model().unwrap().law;
    let (mut names, mut seen) = (BTreeSet::new(), BTreeSet::new());
    for branch in &diagram(scene, Part::Whole).branches {
        let grid = branch.system.grid();
        // Of a ridge waves along y count that soften: two here.
        let ny = if grid.is_line() { 12 } else { grid.ny };
        let square = Grid { ny, ..*grid };
        let dense = Dense::new(square, scene.drive.control.stiffness());
        let regular = branch.points.iter().filter(|p| p.kind == Kind::Regular);
        for point in regular.step_by(4) {
            let gap = branch.gap(point);
            // A line is the row of a square.
            let gap = Array2::from_shape_fn(square.shape(), |(j, i)| gap[[j % gap.nrows(), i]]);
            // What is uniform does not slide.
            let slides = [branch.name != "flat"; 2];
            let hessian = dense.at(&gap, &gap, &law, slides, true);
            let values = hessian.symmetric_eigenvalues();
            let nearest = values
                .iter()
                .fold(f64::INFINITY, |a: f64, v| a.min(v.abs()));
            if nearest < 1e-4 * grid.q1() {
                continue;
            }
            let negative = values.iter().filter(|v| **v < 0.0).count();
            let at = point.state.mean_displacement;
            assert_eq!(point.index, [negative; 2], "{} at {at}", branch.name);
            names.insert(branch.name.clone());
            seen.insert(negative);
        }
    }
    (names, seen)
}

#[test]
fn every_index_is_that_of_the_dense_hessian() {
    let shapes = [Shape::Morse(Morse), Shape::Mie(Mie { m: 8.0, n: 2.0 })];
    for (shape, periods) in shapes.into_iter().zip([2.2, 1.7]) {
        let (_, seen) = dense_indices(&flat_ground(shape, periods, Points::Square(24)));
        assert!(seen.len() > 3, "{seen:?}");
    }
}

/// dV = stress du0 along a branch, through its folds: the integral of cubics through both, exact by
/// three points of Gauss. Their error is of the fourth order in the distance of points.
#[test]
fn along_every_branch_the_energy_is_the_integral_of_the_stress() {
    let gauss = [
        (-0.6_f64.sqrt(), 5.0 / 18.0),
        (0.0, 4.0 / 9.0),
        (0.6_f64.sqrt(), 5.0 / 18.0),
    ];
    let scene = fig2(48);
    for branch in &diagram(&scene, Part::Whole).branches {
        let mut work = 0.0;
        for pair in branch.points.windows(2) {
            let (a, b) = (&pair[0], &pair[1]);
            let h = b.arc - a.arc;
            let cubic = |a: f64, b: f64, p: f64, q: f64| {
                let rise = b - a;
                let (c, d) = (3.0 * rise - (2.0 * p + q) * h, (p + q) * h - 2.0 * rise);
                let value = move |t: f64| a + t * (p * h + t * (c + t * d));
                let slope = move |t: f64| p * h + t * (2.0 * c + 3.0 * t * d);
                (value, slope)
            };
            let [u, v] = [a, b].map(|p| (p.state.mean_displacement, p.state.stress));
            let (_, du) = cubic(u.0, v.0, a.rates[0], b.rates[0]);
            let (stress, _) = cubic(u.1, v.1, a.rates[1], b.rates[1]);
            let at = |x: f64| stress(0.5 + 0.5 * x) * du(0.5 + 0.5 * x);
            work += gauss.iter().map(|(x, weight)| weight * at(*x)).sum::<f64>();
        }
        let (first, last) = (&branch.points[0], &branch.points[branch.points.len() - 1]);
        let missing = work - (last.state.energy - first.state.energy);
        assert!(
            missing.abs() < 2e-5 * scene.law.surface_energy,
            "{}: {missing:e}",
            branch.name
        );
    }
}

#[test]
fn a_tip_goes_through_an_s_whose_folds_are_its_jumps() {
    let scene = preset_on("hertz", Points::Square(64));
    let found = diagram(&scene, Part::Quarter);
    let contact = branch(&found, "contact");
    let kinds: Vec<_> = events(contact).iter().map(|e| (e.0, e.1)).collect();
    assert_eq!(kinds, [(Kind::Fold, [0, 1]), (Kind::Fold, [1, 0])]);
    let range = scene.model().unwrap().law.range;
    holds_jumps_of(&found, &walked(&scene, Part::Quarter), range);
}

/// Crests touch one after the other: the loop goes over branches that break the symmetry of the
/// ground.
#[test]
fn wavy_ground_has_the_branches_that_its_loop_goes_over() {
    let scene = preset("wavy");
    let found = diagram(&scene, Part::Whole);
    let range = scene.model().unwrap().law.range;
    holds_jumps_of(&found, &planned(&scene), range);
    let bifurcations = found.events().filter(|(_, p)| p.kind == Kind::Bifurcation);
    assert!(bifurcations.count() > 2);
}

#[test]
fn a_line_cell_has_the_flat_state_and_the_ridge() {
    let scene = preset("ridge-line");
    let found = diagram(&scene, Part::Line);
    let names: Vec<&str> = found.branches.iter().map(|b| &*b.name).collect();
    assert_eq!(names, ["flat", "ridge"]);
    holds_jumps_of(&found, &planned(&scene), 1.0);
    assert_eq!(found.equal_energies.len(), 2);
}

/// Of points all along the branches the modes are as many as the index, and the energy, with that
/// of the machine, falls along each. Returns the numbers.
pub fn modes_are_as_many_as_the_index(scene: &Scene) -> BTreeSet<usize> {
    let (model, control) = (scene.model().unwrap(), scene.drive.control);
    let mut seen = BTreeSet::new();
    for branch in diagram(scene, Part::Whole).branches.iter().skip(1) {
        let inner = branch.points.iter().step_by(5);
        for point in inner.filter(|p| p.kind == Kind::Regular && p.index[0] < 5) {
            let none = Cancel::default();
            let modes = branch.negative_modes(point, &model, &none).unwrap();
            assert_eq!(modes.len(), point.index[0], "{} {point:?}", branch.name);
            let gap = branch.picture(point, &model.grid);
            let grid = Grid::square(model.grid.length, gap.ncols());
            let system = System::new(grid, model.law, &model.indenter).with_control(control);
            let mut ws = system.workspace();
            let mut z = system.amplitudes(&gap, &mut ws);
            z[0] = point.state.amplitudes[0];
            for mode in &modes {
                let mut v = system.amplitudes(mode, &mut ws);
                v[0] = mode.mean().unwrap();
                let mut energy = |t: f64| {
                    let moved = z.iter().zip(&v).map(|(z, v)| z + t * v).collect();
                    system.at(moved, point.state.control, &mut ws).state.energy
                };
                let bend = energy(1e-3) + energy(-1e-3) - 2.0 * energy(0.0);
                let u0 = point.state.mean_displacement;
                assert!(bend < 0.0, "{} {u0}: {bend:e}", branch.name);
            }
            seen.insert(modes.len());
        }
    }
    seen
}

#[test]
fn the_modes_of_an_unstable_state_are_as_many_as_its_index_and_lower_the_energy() {
    let seen = modes_are_as_many_as_the_index(&fig2(64));
    assert!(seen.contains(&0) && seen.contains(&1), "{seen:?}");
}

/// The upper fold of the ridge of a line cell against the exact flattening, and its unstable part
/// just beyond against the exact unstable ridge (shares out of contact above alpha_c).
fn away_from_the_exact_ridge(length: f64, points: usize) -> [f64; 2] {
    let mut scene = preset_on("ridge-line", Points::Line(points));
    scene.cell.length = length;
    let unit = (0.15 * length).sqrt();
    scene.drive.start = 0.9 * unit;
    scene.drive.turn = Turn::At(0.2);
    let found = diagram(&scene, Part::Line);
    let points = &branch(&found, "ridge").points;
    let u = |p: &Point| p.state.mean_displacement / unit;
    let folds = points.iter().filter(|p| p.kind == Kind::Fold);
    let fold = folds.max_by(|a, b| u(a).total_cmp(&u(b))).unwrap();
    let end = ridge::critical();
    // Where the exact unstable ridge has 97 % of that displacement: by bisection in its share.
    let wanted = 0.97 * end.displacement;
    let at = |alpha: f64| (-1.0 / ridge::elastic_energy(alpha)[1]).sqrt();
    let (mut low, mut high) = (end.alpha, 0.999);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        (low, high) = if at(middle) > wanted {
            (middle, high)
        } else {
            (low, middle)
        };
    }
    let exact = 2.0 * wanted * wanted * ridge::elastic_energy(low)[0];
    // At the same share of its own fold: the range moves that.
    let share = |p: &Point| u(p) / u(fold);
    let unstable = points
        .iter()
        .filter(|p| p.index == [1, 1] && share(p) > 0.9);
    let nearest =
        unstable.min_by(|a, b| (share(a) - 0.97).abs().total_cmp(&(share(b) - 0.97).abs()));
    let p = nearest.unwrap();
    // Along the branch to that share by its own slope.
    let du = 0.97 * fold.state.mean_displacement - p.state.mean_displacement;
    let stress = p.state.stress + p.rates[1] / p.rates[0] * du;
    let tension = stress * 0.97 * fold.state.mean_displacement / 0.15;
    [u(fold) / end.displacement - 1.0, tension / exact - 1.0].map(f64::abs)
}

#[test]
fn the_ridge_of_a_line_cell_tends_to_the_exact_one_through_its_fold_as_the_range_shrinks() {
    // The range halves against sqrt(gamma L/E*) each time, at equal mu_rho.
    let d = [(256.0, 64), (1024.0, 256), (4096.0, 1024)]
        .map(|(length, points)| away_from_the_exact_ridge(length, points));
    for k in 0..2 {
        assert!(d[2][k] < d[1][k] && d[1][k] < 0.1 * d[0][k], "{d:?}");
        assert!(d[2][k] < 2e-3, "{d:?}");
    }
}

#[test]
fn the_flat_index_counts_the_waves_that_are_soft() {
    let scene = fig2(48);
    let model = scene.model().unwrap();
    for point in &branch(&diagram(&scene, Part::Whole), "flat").points {
        let softening = -model.law.at(point.state.mean_displacement).stiffness;
        let q1 = std::f64::consts::TAU / model.grid.length;
        let soft = |k: i32, l: i32| 0.5 * q1 * f64::from(k * k + l * l).sqrt() < softening;
        let waves = (-9..=9).flat_map(|k| (-9..=9).map(move |l| (k, l)));
        let count = waves
            .filter(|&(k, l)| (k, l) != (0, 0) && soft(k, l))
            .count();
        let [few, many] = [
            point.index[0].min(point.index[1]),
            point.index[0].max(point.index[1]),
        ];
        assert!(
            (few..=many).contains(&count),
            "{count} of {:?}",
            point.index
        );
    }
}

#[test]
fn a_stopped_diagram_keeps_what_it_has_and_says_so() {
    let cancel = Cancel::default();
    let mut told = 0;
    let found = Diagram::of(&fig2(48), Part::Whole, &cancel, &mut |_, _, _| {
        told += 1;
        if told == 12 {
            cancel.request();
        }
    })
    .unwrap();
    assert!(found.cancelled && !found.is_complete());
    assert!(branch(&found, "square").points.len() > 10);
    assert_eq!(
        branch(&found, "square").ending.to_string(),
        "a request to stop"
    );
}

/// The unstable part of the S is what becomes of the unstable branch of JKR (in a periodic cell, in
/// closed form): the displacement at a force in its middle comes closer with the range to the power
/// 2/3, by 1.26 from mesh to mesh.
#[test]
fn the_unstable_states_of_a_tip_tend_to_those_of_periodic_jkr() {
    let apart = |points: usize| {
        let scene = preset_on("hertz", Points::Square(points));
        let found = diagram(&scene, Part::Quarter);
        let law = scene.model().unwrap().law;
        let tip = Jkr {
            radius: 1.0,
            surface_energy: law.surface_energy,
        };
        let jkr = PeriodicJkr::new(tip, 1.0);
        // Contacts smaller than the last stable one are unstable.
        let (mut low, mut high) = (0.0, jkr.end_of_displacement().radius);
        let force = 0.6 * jkr.contact(high).force;
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if jkr.contact(middle).force < force {
                low = middle;
            } else {
                high = middle;
            }
        }
        let theory = jkr.contact(low).mean_displacement;
        let unstable: Vec<&Point> = branch(&found, "contact")
            .points
            .iter()
            .filter(|p| p.index.contains(&1))
            .collect();
        let pair = unstable
            .windows(2)
            .find(|pair| (pair[0].state.stress - force) * (pair[1].state.stress - force) <= 0.0)
            .expect("the force lies between the folds");
        let [a, b] = [&pair[0].state, &pair[1].state];
        let share = (force - a.stress) / (b.stress - a.stress);
        let u0 = a.mean_displacement + share * (b.mean_displacement - a.mean_displacement);
        (u0 - theory).abs()
    };
    let [coarse, middle, fine] = [64, 128, 256].map(apart);
    assert!(
        coarse > 1.2 * middle && middle > 1.2 * fine,
        "{coarse:e} {middle:e} {fine:e}"
    );
}
