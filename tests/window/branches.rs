//! The tab of all branches, and what it lays under the loop.

use super::bench::Bench;
use egui_kittest::kittest::Queryable;
use std::sync::Arc;
use tackscope::follow::diagram::Diagram;
use tackscope::follow::record::Direction;
use tackscope::numerics::cancel::Cancel;
use tackscope::scene::part::Part;
use tackscope::scene::{Points, Scene};

fn diagram(scene: &Scene) -> Arc<Diagram> {
    Arc::new(Diagram::of(scene, Part::Whole, &Cancel::default(), &mut |_, _, _| {}).unwrap())
}

#[test]
fn branches_are_followed_while_somebody_looks_and_a_click_shows_an_unstable_state() {
    let mut bench = Bench::new();
    assert!(bench.diagrams().is_empty(), "nobody looks yet");
    bench.click("Branches tab");
    let (scene, report) = bench.diagrams().pop().expect("asked for");
    report.progress(0.3, "branch \"square\", 12 points");
    bench.settle();
    assert!(bench.names().contains("12 points"), "{}", bench.names());
    let mut small = (*scene).clone();
    small.cell.points = Points::Square(48);
    let known = diagram(&small);
    report.result(known.clone());
    report.end(Ok(()));
    bench.settle();
    let plot = bench
        .window
        .get_by_label_contains("Every branch of equilibria: 5 branches, 6 folds")
        .rect();
    assert!(plot.height() > 60.0);
    assert!(
        bench.names().contains("mixed state, unstable"),
        "the legend of the loop names what lies beneath it"
    );

    // From the middle of the plot outwards there is a point of an unstable branch somewhere.
    let places = (1..20).flat_map(|i| (1..8).map(move |j| (i, j)));
    let found = places.into_iter().any(|(i, j)| {
        let share = |k: i32, n: i32| k as f32 / n as f32;
        let at = plot.lerp_inside(egui::vec2(share(i, 20), share(j, 8)));
        bench.click_at(at);
        bench
            .names()
            .contains("unstable along one mode: a pass between two valleys")
    });
    assert!(found, "{}", bench.names());
    let frame = bench.state().frame.clone().expect("a picture");
    let of_frame = known.branches.iter().any(|branch| {
        let same = |u0: f64| u0 == frame.mean_displacement;
        branch
            .points
            .iter()
            .any(|p| same(p.state.mean_displacement) && p.index == [1, 1])
    });
    assert!(of_frame && frame.state.is_none() && !frame.relaxing);
    // The words end with what they speak of.
    bench.reach(4.0, Direction::Approach);
    assert!(
        !bench.names().contains("a pass between two valleys"),
        "{}",
        bench.names()
    );
}

#[test]
fn an_edit_begins_the_branches_anew_and_what_is_under_way_is_dropped() {
    let mut bench = Bench::new();
    bench.click("Branches tab");
    let (_, first) = bench.diagrams().pop().expect("asked for");
    bench.click("Line cell (uniform along y)");
    assert!(first.cancel.requested());
    let (scene, second) = bench.diagrams().pop().expect("asked for again");
    assert!(matches!(scene.cell.points, Points::Line(_)) && !second.cancel.requested());
    bench.click("Cancel");
    assert!(second.cancel.requested());
    second.end(Ok(()));
    bench.settle();
    assert!(bench.state().plots.beneath.is_empty());
}

#[test]
fn the_branches_of_an_edited_scene_stay_until_its_own_come_and_those_of_another_go_at_once() {
    let mut bench = Bench::new();
    bench.click("Branches tab");
    let (scene, report) = bench.diagrams().pop().expect("asked for");
    let mut small = (*scene).clone();
    small.cell.points = Points::Line(32);
    report.result(diagram(&small));
    report.end(Ok(()));
    bench.reach(4.0, Direction::Approach);
    let shown = |bench: &Bench| bench.names().contains("Every branch of equilibria:");
    assert!(shown(&bench) && !bench.state().plots.beneath.is_empty());
    bench.click("law cosine");
    assert!(shown(&bench) && bench.state().plots.beneath.is_empty());
    // The solver's first picture of the opened scene is there before the tab hears of the scene.
    bench.window.event(egui::Event::Key {
        key: egui::Key::Num2,
        physical_key: None,
        pressed: true,
        repeat: false,
        modifiers: egui::Modifiers::NONE,
    });
    bench.window.step();
    assert!(bench.state().frame.is_none());
    bench.reach(4.0, Direction::Approach);
    assert!(!shown(&bench), "{}", bench.names());
}
