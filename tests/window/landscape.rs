//! The tab of the energy landscape: the way over the saddles, and the ball.

use super::bench::{Asked, Bench};
use egui_kittest::kittest::Queryable;
use std::sync::Arc;
use tackscope::follow::diagram::Diagram;
use tackscope::follow::record::Direction;
use tackscope::numerics::cancel::Cancel;
use tackscope::scene::Points;
use tackscope::scene::part::Part;
use tackscope::study::landscape::{Ground, Landscape};

/// The landscape that was asked for, on a mesh of 48 points.
fn computed((scene, diagram, state, _): &Asked) -> Landscape {
    let mut small = (**scene).clone();
    small.cell.points = Points::Square(48);
    let model = small.model().unwrap();
    let ground = Ground {
        scene: &small,
        model: &model,
        diagram,
        cancel: &Cancel::default(),
    };
    Landscape::around(ground, *state, None, &mut |_, _| {}).unwrap()
}

/// The window at rest at u0 = 3.5 with the landscape of that state.
pub fn opened() -> (Bench, Landscape) {
    let mut bench = Bench::new();
    bench.reach(3.5, Direction::Approach);
    bench.click("Landscape tab");
    assert!(bench.names().contains("The branches come first"));
    assert!(bench.landscapes().is_empty());
    let (scene, report) = bench.diagrams().pop().expect("branches are asked for");
    let mut small = (*scene).clone();
    small.cell.points = Points::Square(48);
    let diagram = Diagram::of(&small, Part::Whole, &Cancel::default(), &mut |_, _, _| {});
    report.result(Arc::new(diagram.unwrap()));
    report.end(Ok(()));
    bench.settle();
    let (asked, report) = bench.landscapes().pop().expect("then the landscape");
    let found = computed(&asked);
    report.result(Arc::new(found.clone()));
    report.end(Ok(()));
    bench.settle();
    (bench, found)
}

#[test]
fn the_landscape_says_the_lowest_barrier_and_follows_the_surface() {
    let (mut bench, found) = opened();
    let gamma = bench.model.law.surface_energy;
    let words = format!(
        "The lowest barrier is {:.2e} γL², to bulge",
        found.passes[0].barrier() / gamma
    );
    assert!(bench.names().contains(&words), "{}", bench.names());
    bench.settle();
    assert!(bench.landscapes().is_empty(), "nothing has moved");
    bench.reach(3.4, Direction::Approach);
    let (asked, _) = bench.landscapes().pop().expect("it has moved");
    assert_eq!(asked.2.control, 3.4);
    bench.click("Events tab");
    bench.reach(3.3, Direction::Approach);
    assert!(bench.landscapes().is_empty(), "nobody looks");
}

#[test]
fn the_place_under_the_pointer_is_pictured_until_it_leaves() {
    let (mut bench, found) = opened();
    let before = bench.state().frame.clone().expect("a picture");
    let path = &found.passes[0].path;
    // A square plot with margins: somewhere across it lies the path.
    let plots = bench
        .window
        .query_all_by_label_contains("Landscape: The lowest");
    let plot = plots.map(|node| node.rect()).next().expect("the paths");
    let share = |k: i32| k as f32 / 24.0;
    let places = (1..24).flat_map(|i| (1..24).map(move |j| egui::vec2(share(i), share(j))));
    let shown = places.into_iter().find_map(|place| {
        bench.window.hover_at(plot.lerp_inside(place));
        bench.settle();
        let frame = bench.state().frame.clone().expect("a picture");
        (!Arc::ptr_eq(&frame, &before)).then_some(frame)
    });
    let shown = shown.expect("a place of the path");
    assert!(path.iter().any(|place| Arc::ptr_eq(&place.gap, &shown.gap)));
    bench.window.hover_at(egui::pos2(2.0, 2.0));
    bench.settle();
    let frame = bench.state().frame.clone().expect("a picture");
    assert!(Arc::ptr_eq(&frame, &before));
}

#[test]
fn after_a_jump_the_ball_rolls_down_the_path_of_the_state_that_gave_way() {
    let (mut bench, _) = opened();
    bench.reach(3.103, Direction::Approach);
    let (asked, report) = bench.landscapes().pop().expect("of what gives way");
    assert_eq!(asked.2.control, 3.103);
    bench.jump(3.103);
    report.result(Arc::new(computed(&asked)));
    report.end(Ok(()));
    bench.reach(3.0, Direction::Approach);
    let gone = |bench: &Bench| bench.names().contains("The barrier is gone");
    assert!(
        gone(&bench) && bench.landscapes().is_empty(),
        "{}",
        bench.names()
    );
    // It takes its time, and is seen where it came to rest until the next landscape is there.
    let mut frames = 0;
    let (asked, report) = loop {
        bench.window.step();
        frames += 1;
        if let Some(asked) = bench.landscapes().pop() {
            break asked;
        }
        assert!(frames < 200, "the ball never comes down");
    };
    assert!(frames > 2 && gone(&bench), "{frames}");
    report.result(Arc::new(Landscape::default()));
    bench.settle();
    assert!(bench.names().contains("No saddle"), "{}", bench.names());
    assert_eq!(asked.2.control, 3.0);
}

#[test]
fn another_scene_shows_nothing_of_the_landscape_before() {
    let (mut bench, _) = opened();
    bench.click("law cosine");
    assert!(!bench.names().contains("The lowest barrier"));
    assert_eq!(bench.diagrams().len(), 1, "its own branches are asked for");
}
