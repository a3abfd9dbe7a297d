//! Loops over a layer on a rigid plate.

use crate::diagram::{diagram, nearest_event};
use crate::loops::{preset, preset_on, walked};
use tackscope::follow::diagram::Diagram;
use tackscope::follow::record::StateRecord;
use tackscope::follow::run::LoopRun;
use tackscope::numerics::threads::Cancel;
use tackscope::physics::body::{Body, Layer};
use tackscope::physics::control::Control;
use tackscope::physics::theory::flat_limits;
use tackscope::scene::{Part, Points, Scene, Strategy, Turn};
use tackscope::study::plan::{plan, refusal};

fn over(mut scene: Scene, thickness: f64, poisson: f64) -> Scene {
    scene.body = Body::Layer(Layer { thickness, poisson });
    scene
}

fn line() -> Scene {
    let mut scene = preset_on("fig2", Points::Line(64));
    scene.drive.step = 0.1;
    scene
}

/// What is the same in two runs, without times.
fn numbers(run: &LoopRun) -> Vec<[f64; 5]> {
    let of = |s: &StateRecord| {
        let StateRecord {
            control,
            mean_displacement,
            stress,
            stiffness_min,
            energy,
            ..
        } = *s;
        [control, mean_displacement, stress, stiffness_min, energy]
    };
    run.record.states.iter().map(of).collect()
}

#[test]
fn a_thick_layer_has_the_loop_of_the_half_space_to_the_last_bit_and_a_thinner_one_comes_near() {
    let half_space = walked(&line(), Part::Whole);
    let length = line().cell.length;
    let thick = walked(&over(line(), 10.0 * length, 0.5), Part::Whole);
    assert_eq!(numbers(&thick), numbers(&half_space));
    let released = |run: &LoopRun| run.record.released_energy_sum();
    let off = [0.5, 0.7, 1.0].map(|share| {
        let near = walked(&over(line(), share * length, 0.5), Part::Whole);
        assert_eq!(near.record.jumps.len(), half_space.record.jumps.len());
        (released(&near) - released(&half_space)).abs()
    });
    // 1 - f goes as exp(-2 q t).
    assert!(off[0] > 5.0 * off[1] && off[1] > 20.0 * off[2], "{off:?}");
}

/// Of an incompressible film, driven through its limit.
fn film(periods: f64, points: usize) -> Scene {
    let thickness = 4.0;
    // 2.96 thicknesses (V. Shenoy and A. Sharma, Phys. Rev. Lett. 86, 119 (2001)).
    let mut scene = over(line(), thickness, 0.5);
    scene.cell.length = 2.96 * thickness * periods;
    scene.cell.points = Points::Line(points);
    scene.law.surface_energy = 3.0;
    scene.drive.step = 0.2;
    scene
}

#[test]
fn a_film_breaks_into_ridges_three_thicknesses_apart_whatever_the_cell() {
    for (periods, points) in [(4, 180), (6, 270)] {
        let run = walked(&film(f64::from(periods), points), Part::Whole);
        let gap = &run.landings[1].gap;
        let mean = gap.mean().unwrap();
        let sides: Vec<bool> = gap.iter().map(|gap| *gap < mean).collect();
        let edges = (0..points).filter(|i| sides[*i] != sides[(i + 1) % points]);
        assert_eq!(edges.count(), 2 * periods as usize);
        let ledger = run.record.ledger(3.0);
        assert_eq!(ledger.open, None);
        assert!(ledger.mismatch().unwrap() < 1e-3, "{:?}", ledger.mismatch());
    }
}

#[test]
fn what_knows_half_spaces_alone_steps_aside_for_a_layer() {
    let mut scene = over(preset("fig2"), 90.0, 0.5);
    let model = scene.model().unwrap();
    let plan = plan(&scene, &model, None);
    assert_eq!(plan.strategy, Strategy::WHOLE);
    assert_eq!(plan.predicted_error, 1.0);
    let refused = refusal(&scene, &model, Some(Strategy::Atlas)).unwrap();
    assert!(refused.contains("half-space"), "{refused}");
    scene.cell.points = Points::Square(32);
    scene.body = Body::HalfSpace;
    let model = scene.model().unwrap();
    assert_eq!(refusal(&scene, &model, Some(Strategy::Atlas)), None);
}

/// The branch of ridges between two bifurcations of the flat state: its folds are where the walk
/// jumps.
#[test]
fn the_diagram_of_a_layer_has_its_folds_where_the_walk_jumps() {
    let scene = over(line(), 80.0, 0.5);
    let run = walked(&scene, Part::Whole);
    let diagram = diagram(&scene, Part::Whole);
    for jump in &run.record.jumps {
        let nearest = nearest_event(&diagram, jump);
        assert!(nearest < 2e-5, "{jump:?}: {nearest}");
    }
}

#[test]
fn the_diagram_of_a_film_has_every_bifurcation_of_the_flat_state_and_says_what_it_leaves_out() {
    let scene = film(6.0, 270);
    let model = scene.model().unwrap();
    let diagram = Diagram::of(&scene, Part::Whole, &Cancel::default(), &mut |_, _, _| {}).unwrap();
    assert_eq!(diagram.branches.len(), 1);
    assert!(
        diagram.missing[0].contains("layer"),
        "{:?}",
        diagram.missing
    );
    let (lower, upper) = flat_limits(&model.law, model.equivalent_length).unwrap();
    let places: Vec<f64> = diagram
        .events()
        .map(|event| event.1.state.mean_displacement)
        .collect();
    assert!(places.len() >= 2 && places.len().is_multiple_of(2));
    assert_eq!((places[0], places[places.len() - 1]), (upper, lower));
    // One wave and its mirror image for each pair of bifurcations.
    let most = diagram.branches[0]
        .points
        .iter()
        .map(|point| point.index[0])
        .max();
    assert_eq!(most, Some(places.len()));
}

#[test]
fn a_compressible_layer_is_driven_through_its_own_mean_as_through_a_spring() {
    let (thickness, poisson) = (10.0 * line().cell.length, 0.3);
    let layer = over(line(), thickness, poisson);
    // M/t = (1 - nu)^2/(1 - 2 nu) E*/t.
    let stiffness = 0.49 / 0.4 / thickness;
    assert!(layer.turn_of_u0().is_none());
    let long = |mut scene: Scene| {
        (scene.drive.start, scene.drive.turn, scene.drive.step) = (300.0, Turn::At(-100.0), 5.0);
        scene
    };
    let mut sprung = line();
    sprung.drive.control = Control::Spring { stiffness };
    let (one, other) = (
        walked(&long(layer), Part::Whole),
        walked(&long(sprung), Part::Whole),
    );
    assert_eq!(one.record.jumps.len(), 2);
    for (a, b) in numbers(&one).iter().zip(numbers(&other)) {
        for (a, b) in a.iter().zip(b) {
            assert!((a - b).abs() <= 1e-9 * b.abs().max(1.0), "{a} {b}");
        }
    }
}
