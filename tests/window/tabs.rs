//! What stands below the plot: stability, forecast, time steps; all branches, and what they lay under the
//! loop; the energy landscape: the way over the saddles, and the ball; the surface in three dimensions.

use super::bench::{Asked, Bench, coarse};
use super::hand::{Hand, Window, opened};
use super::layout::TABS;
use super::stored::looped;
use egui::epaint::{ClippedShape, Mesh, Shape};
use egui::{Rect, Role, vec2};
use egui_kittest::kittest::{NodeT, Queryable};
use std::sync::Arc;
use tackscope::follow::diagram::Diagram;
use tackscope::numerics::threads::Cancel;
use tackscope::physics::theory::{flat_limits, flat_stiffness};
use tackscope::plot::style::Colours;
use tackscope::scene::{Part, Points, Scene};
use tackscope::study::landscape::{Ground, Landscape};
use tackscope::study::time_step_map::{Progress, Survey};

fn tab(bench: &mut Bench, name: &str) {
    bench.click(&format!("{name} tab"));
}

#[test]
fn the_tabs_are_reached_and_chosen_by_the_keyboard() {
    let mut bench = Bench::new();
    bench
        .get_by_role_and_label(Role::Tab, "Stability tab")
        .focus();
    bench.settle();
    bench.tap(egui::Key::Enter);
    assert!(bench.query_by_label("soft mode on map").is_some());
    assert!(bench.query_by_label("No jump yet.").is_none());
}

#[test]
fn the_stability_tab_says_the_eigenvalue_and_where_the_next_jump_is() {
    let mut bench = Bench::new();
    tab(&mut bench, "Stability");
    let (lower, upper) = flat_limits(&bench.model.law, bench.model.grid.length).unwrap();
    for u0 in [3.4, 3.38, 3.36] {
        bench.down(u0);
    }
    let eigenvalue = flat_stiffness(&bench.model.law, bench.model.grid.length, 3.36);
    let words =
        format!("now {eigenvalue:.4} E*/L; next jump at u₀ = {upper:.4} ρ going down (exact)");
    assert!(
        bench.names().contains(&words),
        "{words} in {}",
        bench.names()
    );
    for u0 in [0.3, 0.32] {
        bench.up(u0);
    }
    bench.says(&format!("next jump at u₀ = {lower:.4} ρ going up (exact)"));
    for u0 in [3.36, 3.38] {
        bench.up(u0);
    }
    bench.says("no jump foreseen going up");
}

#[test]
fn the_curve_of_the_eigenvalue_is_cut_at_a_jump() {
    let mut bench = Bench::new();
    bench.down(3.2);
    bench.down(3.12);
    bench.jump(3.102);
    bench.down(3.102);
    let pieces: Vec<usize> = bench
        .view()
        .run
        .stiffness
        .pieces
        .iter()
        .map(|piece| piece.points.len())
        .collect();
    assert_eq!(pieces, [2, 1]);
}

#[test]
fn the_time_steps_are_measured_at_the_push_of_a_button_shown_as_they_come_and_cancelled() {
    let mut bench = Bench::new();
    tab(&mut bench, "Stability");
    bench.click("time steps");
    bench.heard();
    bench.click("Measure");
    let ((scene, turn), report) = bench.time_steps();
    assert_eq!(
        (scene.title.as_str(), turn),
        (bench.view().scene.title.as_str(), bench.view().limits.0)
    );
    let mut survey = Survey::new(&scene, turn).unwrap();
    while survey.map().stable.len() < 7 {
        assert_eq!(survey.step(&Cancel::default()), Progress::Working);
    }
    report.result(survey.map().clone());
    bench.settle();
    bench.says("Time steps of GFMD against u0: 7 cells measured");
    bench.click("Cancel");
    assert!(report.cancel.requested());
    report.end(Ok(()));
    bench.settle();
    assert!(bench.query_by_label("Measure").is_some());
    assert!(
        bench.names().contains("7 cells measured"),
        "what was measured stays"
    );
}

#[test]
fn the_soft_mode_is_switched_onto_the_map() {
    let mut bench = Bench::new();
    tab(&mut bench, "Stability");
    bench.click("soft mode on map");
    assert!(bench.view().view.soft_mode);
}

#[test]
fn the_first_frame_of_a_tab_shows_what_the_later_ones_do_at_the_same_places() {
    let (mut window, _) = looped();
    for name in TABS {
        window.begin(&format!("Tab: {name}"));
        // The frame of the key, and the first one of the tab.
        window.run_steps(2);
        let seen = |window: &Window| -> Vec<_> {
            let nodes = window.root().children_recursive();
            let words = nodes.filter_map(|node| {
                let words = node.accesskit_node().label().or(node.value())?;
                Some((words, node.rect()))
            });
            words.collect()
        };
        let first = seen(&window);
        window.run_steps(10);
        let later = seen(&window);
        let moved: Vec<_> = first.iter().zip(&later).filter(|(a, b)| a != b).collect();
        assert!(
            first.len() == later.len() && moved.is_empty(),
            "{name}: {moved:?}"
        );
    }
}

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
    bench.says("12 points");
    let mut small = (*scene).clone();
    small.cell.points = Points::Square(48);
    let known = diagram(&small);
    bench.answer(&report, known.clone());
    let plot = bench.place("Every branch of equilibria: 5 branches, 6 folds");
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
    let frame = bench.view().frame.clone().expect("a picture");
    let of_frame = known.branches.iter().any(|branch| {
        let same = |u0: f64| u0 == frame.mean_displacement;
        branch
            .points
            .iter()
            .any(|p| same(p.state.mean_displacement) && p.index == [1, 1])
    });
    assert!(of_frame && frame.state.is_none() && !frame.relaxing);
    // The words end with what they speak of.
    bench.down(4.0);
    bench.lacks("a pass between two valleys");
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
    assert!(bench.view().plots.beneath.is_empty());
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
    bench.down(4.0);
    let shown = |bench: &Bench| bench.names().contains("Every branch of equilibria:");
    assert!(shown(&bench) && !bench.view().plots.beneath.is_empty());
    bench.click("law cosine");
    assert!(shown(&bench) && bench.view().plots.beneath.is_empty());
    // The solver's first picture of the opened scene is there before the tab hears of the scene.
    bench.event(egui::Event::Key {
        key: egui::Key::Num2,
        physical_key: None,
        pressed: true,
        repeat: false,
        modifiers: egui::Modifiers::NONE,
    });
    bench.step();
    assert!(bench.view().frame.is_none());
    bench.down(4.0);
    assert!(!shown(&bench), "{}", bench.names());
}

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
pub fn surveyed() -> (Bench, Landscape) {
    let mut bench = Bench::new();
    bench.down(3.5);
    bench.click("Landscape tab");
    bench.says("The branches come first");
    assert!(bench.landscapes().is_empty());
    let (scene, report) = bench.diagrams().pop().expect("branches are asked for");
    let mut small = (*scene).clone();
    small.cell.points = Points::Square(48);
    let diagram = Diagram::of(&small, Part::Whole, &Cancel::default(), &mut |_, _, _| {});
    bench.answer(&report, Arc::new(diagram.unwrap()));
    let (asked, report) = bench.landscapes().pop().expect("then the landscape");
    let found = computed(&asked);
    bench.answer(&report, Arc::new(found.clone()));
    (bench, found)
}

#[test]
fn the_landscape_says_the_lowest_barrier_and_follows_the_surface() {
    let (mut bench, found) = surveyed();
    let gamma = bench.model.law.surface_energy;
    let words = format!(
        "The lowest barrier is {:.2e} γL², to bulge",
        found.passes[0].barrier() / gamma
    );
    bench.says(&words);
    bench.settle();
    assert!(bench.landscapes().is_empty(), "nothing has moved");
    bench.down(3.4);
    let (asked, _) = bench.landscapes().pop().expect("it has moved");
    assert_eq!(asked.2.control, 3.4);
    bench.click("Events tab");
    bench.down(3.3);
    assert!(bench.landscapes().is_empty(), "nobody looks");
}

#[test]
fn the_place_under_the_pointer_is_pictured_until_it_leaves() {
    let (mut bench, found) = surveyed();
    let before = bench.view().frame.clone().expect("a picture");
    let path = &found.passes[0].path;
    // A square plot with margins: somewhere across it lies the path.
    let plots = bench.query_all_by_label_contains("Landscape: The lowest");
    let plot = plots.map(|node| node.rect()).next().expect("the paths");
    let share = |k: i32| k as f32 / 24.0;
    let places = (1..24).flat_map(|i| (1..24).map(move |j| egui::vec2(share(i), share(j))));
    let shown = places.into_iter().find_map(|place| {
        bench.hover_at(plot.lerp_inside(place));
        bench.settle();
        let frame = bench.view().frame.clone().expect("a picture");
        (!Arc::ptr_eq(&frame, &before)).then_some(frame)
    });
    let shown = shown.expect("a place of the path");
    assert!(path.iter().any(|place| Arc::ptr_eq(&place.gap, &shown.gap)));
    bench.hover_at(egui::pos2(2.0, 2.0));
    bench.settle();
    let frame = bench.view().frame.clone().expect("a picture");
    assert!(Arc::ptr_eq(&frame, &before));
}

#[test]
fn after_a_jump_the_ball_rolls_down_the_path_of_the_state_that_gave_way() {
    let (mut bench, _) = surveyed();
    bench.down(3.103);
    let (asked, report) = bench.landscapes().pop().expect("of what gives way");
    assert_eq!(asked.2.control, 3.103);
    bench.jump(3.103);
    report.result(Arc::new(computed(&asked)));
    report.end(Ok(()));
    bench.down(3.0);
    let gone = |bench: &Bench| bench.names().contains("The barrier is gone");
    assert!(
        gone(&bench) && bench.landscapes().is_empty(),
        "{}",
        bench.names()
    );
    // It takes its time, and is seen where it came to rest until the next landscape is there.
    let mut frames = 0;
    let (asked, report) = loop {
        bench.step();
        frames += 1;
        if let Some(asked) = bench.landscapes().pop() {
            break asked;
        }
        assert!(frames < 200, "the ball never comes down");
    };
    assert!(frames > 2 && gone(&bench), "{frames}");
    report.result(Arc::new(Landscape::default()));
    bench.settle();
    bench.says("No saddle");
    assert_eq!(asked.2.control, 3.0);
}

#[test]
fn another_scene_shows_nothing_of_the_landscape_before() {
    let (mut bench, _) = surveyed();
    bench.click("law cosine");
    bench.lacks("The lowest barrier");
    assert_eq!(bench.diagrams().len(), 1, "its own branches are asked for");
}

/// The window with the tab open.
fn seen() -> Window {
    let mut window = opened(coarse(32));
    window.act("Tab: 3D");
    window
}

/// Ground and surface.
fn sheets(window: &Window) -> [Arc<Mesh>; 2] {
    let area = window.place("in three dimensions");
    let sheet = |shape: &ClippedShape| match &shape.shape {
        Shape::Mesh(mesh)
            if area.contains_rect(mesh.calc_bounds()) && mesh.vertices.len() > 1000 =>
        {
            Some(mesh.clone())
        }
        _ => None,
    };
    let all: Vec<Arc<Mesh>> = window.output().shapes.iter().filter_map(sheet).collect();
    all.try_into().expect("ground and surface, within the tab")
}

/// By how many degrees it is turned, and from how high it is seen.
fn angles(window: &Window) -> [i32; 2] {
    let words = window.name("in three dimensions");
    let numbers = words
        .split_whitespace()
        .filter_map(|word| word.parse().ok());
    let numbers: Vec<i32> = numbers.collect();
    numbers.try_into().expect("two angles")
}

#[test]
fn the_surface_is_seen_in_three_dimensions_and_turned_by_a_drag_or_by_name() {
    let mut window = seen();
    let [turn, lift] = angles(&window);
    let area = window.place("in three dimensions");
    window.drag_along(area.center(), &[vec2(50.0, 30.0); 2]);
    let [turned, lifted] = angles(&window);
    // A hundredth of a radian for each point, told in whole degrees.
    assert!((turned - turn - 29).abs() <= 1 && (lifted - lift - 17).abs() <= 1);
    window.act("3D: turn left");
    assert_eq!(angles(&window), [turned - 15, lifted]);
    for _ in 0..8 {
        window.act("3D: higher");
    }
    assert_eq!(
        angles(&window)[1],
        90,
        "from straight above, and no farther"
    );
    window.act("Restore layout");
    window.act("Tab: 3D");
    assert_eq!(angles(&window), [turn, lift]);
}

#[test]
fn a_flat_surface_lies_as_flat_as_the_ground_and_a_bulge_reaches_down_to_it() {
    let mut window = seen();
    let bounds = |window: &Window| sheets(window).map(|sheet| sheet.calc_bounds());
    let [ground, flat] = bounds(&window);
    let same = |a: Rect, b: Rect| (a.size() - b.size()).length() < 0.5;
    assert!(
        same(ground, flat) && flat.bottom() < ground.bottom(),
        "{ground:?} {flat:?}"
    );
    window.act("3.0");
    assert!(!window.view().run.record.jumps.is_empty());
    let lowest = |mesh: &Mesh| {
        let ys = mesh.vertices.iter().map(|vertex| vertex.pos.y);
        ys.fold(f32::MIN, f32::max)
    };
    let [ground, bulge] = sheets(&window);
    // The pattern is in the middle of the cell: there the surface all but touches the ground.
    let middle = |mesh: &Mesh| mesh.vertices[mesh.vertices.len() / 2].pos;
    let gap = (middle(&ground) - middle(&bulge)).length();
    let apart = (ground.vertices[0].pos - bulge.vertices[0].pos).length();
    assert!(
        gap < 0.25 * apart && lowest(&bulge) <= lowest(&ground),
        "{gap} {apart}"
    );
    // In the colours of the map.
    let inks = |mesh: &Mesh| {
        mesh.vertices
            .iter()
            .map(|vertex| vertex.color)
            .collect::<Vec<_>>()
    };
    window.act("colours: as in the paper");
    assert_eq!(window.view().view.colours, Colours::Paper);
    assert_ne!(inks(&sheets(&window)[1]), inks(&bulge));
}
