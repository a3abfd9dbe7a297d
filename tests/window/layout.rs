//! How the panels share the window, at every size and zoom, and that nothing moves when a word comes;
//! what is written where: readings cover nothing, words are whole, and the present point lies on none;
//! and every word on the screen has a card.

use super::bench::{Bench, coarse, fig2};
use super::hand::{Hand, Window, computing, foretold, named_from, opened};
use super::stored::looped;
use egui::epaint::{ClippedShape, Shape};
use egui::{Event as Input, Key, Pos2, Rect, Role, pos2, vec2};
use egui_kittest::LazyRenderer;
use egui_kittest::kittest::{NodeT, Queryable};
use tackscope::scene::Points;
use tackscope::ui::view_state::ViewState;
use tackscope::worker::protocol::{Event, Failure};

/// Sides in pixels, and zooms.
const SIZES: [(f32, f32); 6] = [
    (640.0, 480.0),
    (900.0, 600.0),
    (1024.0, 768.0),
    (1280.0, 800.0),
    (1920.0, 1080.0),
    (2560.0, 1440.0),
];
const ZOOMS: [f32; 4] = [0.8, 1.0, 1.5, 2.0];

/// The window with a flat state, at every size and zoom.
fn each(mut look: impl FnMut(&mut Bench, Rect, &str)) {
    for (width, height) in SIZES {
        for zoom in ZOOMS {
            let size = vec2(width, height) / zoom;
            let mut bench = Bench::sized(size.x, size.y);
            bench.down(3.9);
            let screen = Rect::from_min_size(pos2(0.0, 0.0), size);
            look(&mut bench, screen, &format!("{width} x {height} at {zoom}"));
        }
    }
}

/// Shows a panel that is not in sight.
fn turn_to(bench: &mut Bench, page: &str) {
    if bench.query_by_label(page).is_none() && bench.query_by_label("Page").is_some() {
        bench.click("Page");
    }
    if bench.query_by_label(page).is_some() {
        bench.click(page);
    }
}

#[test]
fn the_bar_is_one_row_at_every_size_and_zoom_and_nothing_of_it_is_cut() {
    each(|bench, screen, which| {
        let bar = [
            "Preset",
            "Play approach",
            "Play retract",
            "Play loop",
            "Pause",
            "Menu",
        ];
        let places = bar.map(|label| bench.place_of(label));
        for (label, rect) in bar.iter().zip(places) {
            assert!(screen.contains_rect(rect), "{label} {rect:?}, {which}");
            let off = (rect.center().y - places[0].center().y).abs();
            assert!(off < 2.0, "{label} is in another row, {which}");
        }
        let apart = places.windows(2).all(|pair| pair[0].max.x <= pair[1].min.x);
        assert!(apart, "{places:?}, {which}");
    });
}

#[test]
fn every_panel_is_in_sight_or_one_choice_away_and_inside_at_every_size_and_zoom() {
    each(|bench, screen, which| {
        for (page, labels) in [
            ("Map", ["mean displacement u0", "Map options"]),
            ("Curve", ["Fit", "Why tab"]),
            ("Scene", ["ground flat", "law mie"]),
        ] {
            turn_to(bench, page);
            for label in labels {
                let rect = bench.place_of(label);
                let inside = rect.min.x >= 0.0 && rect.max.x <= screen.max.x;
                assert!(inside && rect.width() > 8.0, "{label} {rect:?}, {which}");
            }
        }
    });
}

#[test]
fn both_headlines_stand_over_map_and_plot_at_every_size_and_zoom() {
    each(|bench, screen, which| {
        let full = screen.size() == vec2(1280.0, 800.0);
        for (page, words, least, at_full) in [
            ("Map", "Flat, stable, u₀ = 3.9000 ρ", 15.0, 22.0),
            ("Curve", "Nothing lost yet", 18.0, 28.0),
        ] {
            turn_to(bench, page);
            let height = bench.place_of(words).height();
            let wanted = if full { at_full } else { least };
            assert!(height >= wanted, "{words} is {height} high, {which}");
        }
    });
}

#[test]
fn the_tabs_are_one_row_with_the_chosen_one_in_it_and_the_others_in_a_menu() {
    each(|bench, screen, which| {
        turn_to(bench, "Curve");
        let tabs = |bench: &Bench| -> Vec<Rect> {
            let all = bench.query_all_by_role(Role::Tab);
            all.map(|tab| tab.rect()).collect()
        };
        let row = tabs(bench);
        assert!(!row.is_empty(), "{which}");
        for rect in &row {
            assert_eq!(rect.center().y, row[0].center().y, "{which}");
            assert!(rect.max.x <= screen.max.x, "{rect:?}, {which}");
        }
        bench.click("Paper tab");
        let chosen = bench.place_of("Paper tab");
        assert_eq!(chosen.center().y, tabs(bench)[0].center().y, "{which}");
    });
}

#[test]
fn nothing_moves_when_a_word_comes() {
    for (width, height) in [(1280.0, 800.0), (900.0, 600.0)] {
        let mut bench = Bench::sized(width, height);
        bench.down(3.9);
        let fixed = [
            "Play loop",
            "Map options",
            "mean displacement u0",
            "Profile line",
            "Why tab",
            "Fit",
            "Advanced",
        ];
        let before = fixed.map(|label| bench.place_of(label));
        let same = |bench: &Bench, what: &str| {
            for (label, before) in fixed.iter().zip(before) {
                let now = bench.place_of(label);
                assert!(
                    (now.min - before.min).length() < 0.6,
                    "{label}: {before:?} {now:?} {what}"
                );
            }
        };
        bench.tap(Key::L);
        same(&bench, "a notice");
        bench.say(Event::Failed(Failure {
            message: "did not converge at u0 = 0.31".to_owned(),
            remedy: "Take a smaller step.".to_owned(),
        }));
        same(&bench, "a failure");
        bench.click("Dismiss");
        bench.down(3.11);
        bench.jump(3.102);
        bench.up(3.0);
        same(&bench, "a jump");
        bench.tap(Key::End);
        same(&bench, "a target");
    }
}

#[test]
fn a_mesh_that_becomes_too_coarse_moves_nothing() {
    let mut bench = Bench::new();
    let map = bench.place_of("Map options");
    bench.click("Advanced");
    assert_eq!(
        bench.place_of("Map options"),
        map,
        "the fold widens nothing"
    );
    let before = bench.place_of("Advanced");
    bench.click("mu_rho of Hui, 1.09");
    bench.says("Mesh: too coarse");
    assert_eq!(bench.place_of("Advanced"), before);
}

#[test]
fn a_notice_goes_by_itself() {
    let mut bench = Bench::new();
    bench.tap(Key::L);
    bench.says("no loop to keep");
    // Four frames a second.
    bench.run_steps(45);
    bench.lacks("no loop to keep");
}

#[test]
fn restore_layout_brings_the_panels_back() {
    let mut bench = Bench::new();
    let edge = |bench: &Bench| bench.place_of("Why tab").min.x;
    let before = edge(&bench);
    let from = pos2(before - 8.0, 330.0);
    bench.drag_along(from, &[vec2(-20.0, 0.0), vec2(-60.0, 0.0)]);
    assert!(edge(&bench) < before - 30.0, "{} {before}", edge(&bench));
    bench.click("Restore layout");
    bench.settle();
    assert!(
        (edge(&bench) - before).abs() < 1.0,
        "{} {before}",
        edge(&bench)
    );
}

/// Everything that is drawn, one by one.
fn shapes(window: &Window) -> Vec<Shape> {
    fn flat(shape: &Shape, all: &mut Vec<Shape>) {
        match shape {
            Shape::Vec(shapes) => shapes.iter().for_each(|shape| flat(shape, all)),
            shape => all.push(shape.clone()),
        }
    }
    let mut all = Vec::new();
    let drawn = &window.output().shapes;
    drawn
        .iter()
        .for_each(|ClippedShape { shape, .. }| flat(shape, &mut all));
    all
}

/// The words that are drawn with these letters in them, with their places, and whether they are cut.
fn written(window: &Window, letters: &str) -> Vec<(String, Rect, bool)> {
    let text = |shape: &Shape| match shape {
        Shape::Text(text) if text.galley.text().contains(letters) => Some((
            text.galley.text().to_owned(),
            text.visual_bounding_rect(),
            text.galley.elided,
        )),
        _ => None,
    };
    shapes(window).iter().filter_map(text).collect()
}

#[test]
fn what_is_read_over_the_profile_stands_below_the_map_and_covers_no_map_of_why() {
    let mut window = opened(coarse(32));
    window.act("3.05");
    for size in [[1280.0, 800.0], [900.0, 600.0]] {
        window.set_size(vec2(size[0], size[1]));
        window.run();
        let profile = window.place("Profile along");
        let map = window.place("Gap map:");
        // At the right, next to the tabs.
        window.hover_at(profile.lerp_inside(vec2(0.95, 0.4)));
        window.run_steps(40);
        let all = written(&window, "gap ");
        let readings: Vec<_> = all
            .iter()
            .filter(|(words, ..)| words.starts_with("x "))
            .collect();
        let [(words, place, _)] = readings[..] else {
            panic!("{all:?} at {size:?}")
        };
        assert!(
            words.contains("pulls") || words.contains("pushes"),
            "{words}"
        );
        assert!(
            place.top() >= map.bottom() && place.bottom() <= profile.top(),
            "{place:?} at {size:?}"
        );
    }
}

#[test]
fn the_present_point_lies_on_no_name_of_a_pattern_and_names_are_whole_in_small_plots() {
    let (mut window, _) = looped();
    for size in [[1280.0, 800.0], [900.0, 600.0]] {
        window.set_size(vec2(size[0], size[1]));
        window.run();
        let mut covered = Vec::new();
        for step in 0..12 {
            window.act(&format!("{:.2}", 4.1 - 0.3 * f64::from(step)));
            let plot = window.place("Stress against u0:");
            let ring = |shape: &Shape| match shape {
                Shape::Circle(circle) if circle.radius == 7.5 && plot.contains(circle.center) => {
                    Some(circle.center)
                }
                _ => None,
            };
            let rings: Vec<_> = shapes(&window).iter().filter_map(ring).collect();
            assert_eq!(rings.len(), 1, "the present point");
            for name in [" bulge ", " ridge ", " dimple "] {
                for (_, place, _) in written(&window, name) {
                    if !plot.intersects(place) {
                        continue;
                    }
                    let inside = plot.x_range().contains(place.left() + 4.0)
                        && plot.x_range().contains(place.right() - 4.0);
                    let all = [" bulge ", " ridge ", " dimple "].map(|name| written(&window, name));
                    let others = all.iter().flatten().filter(|(_, other, _)| *other != place);
                    let on_another =
                        others.filter(|(_, other, _)| other.shrink(2.0).intersects(place));
                    if place.contains(rings[0]) || !inside || on_another.count() > 0 {
                        covered.push((step, name, place, rings[0]));
                    }
                }
            }
        }
        assert!(covered.is_empty(), "{covered:?} at {size:?}");
    }
}

#[test]
fn the_name_of_what_is_ahead_is_whole_while_the_body_is_on_its_way() {
    let mut window = foretold(fig2());
    window.set_size(vec2(900.0, 600.0));
    window.run();
    window.begin("1.4");
    window.run_steps(4);
    let mut seen = 0;
    while window.view().run.is_busy() {
        window.step();
        let plot = window.place("Stress against u0:");
        for (words, place, _) in written(&window, " ahead ") {
            seen += 1;
            let inside = plot.x_range().shrink(-1.0);
            let whole = inside.contains(place.left()) && inside.contains(place.right());
            assert!(whole, "{words}: {place:?} in {plot:?}");
        }
    }
    assert!(seen > 0);
}

#[test]
fn the_line_below_the_headline_of_the_loss_is_whole_in_a_small_window() {
    for (mut window, words) in [
        (looped().0, "in one loop, exact to"),
        (foretold(fig2()), "live loop, 8 jumps, exact to"),
    ] {
        window.set_size(vec2(900.0, 600.0));
        window.run();
        let lines = written(&window, words);
        assert!(!lines.is_empty(), "{words}");
        assert!(lines.iter().all(|(_, _, cut)| !cut), "{lines:?}");
    }
}

/// Everything that is said.
fn said(window: &Window) -> Vec<String> {
    let nodes = window.root().children_recursive();
    nodes
        .filter_map(|node| node.accesskit_node().label().or(node.value()))
        .collect()
}

/// What explains itself: sentences, formulas, numbers, and pictures, which say what they show.
fn is_plain(role: Role, name: &str) -> bool {
    let sentence = name.ends_with('.') || name.split_whitespace().count() > 6;
    let letters = name.chars().any(char::is_alphabetic);
    matches!(role, Role::Image | Role::Splitter) || sentence || !letters || name.contains('=')
}

/// The words in sight, with their places.
fn words(window: &Window) -> Vec<(Role, String, Pos2)> {
    let screen = window.ctx.content_rect();
    let chip = |words| named_from(window, words);
    let chip = chip("exact to").or_else(|| chip("no accuracy is promised"));
    let bar = chip.expect("the chip of the bar").rect();
    let nodes = window.root().children_recursive();
    let words = nodes.filter_map(|node| {
        let (role, name) = (node.accesskit_node().role(), node.accesskit_node().label());
        let (name, at) = (name.or(node.value())?, node.rect().center());
        // What scrolls lies under the bar at the foot of the window.
        let of_bar = ["flat", "stable"].contains(&&*name) || name.starts_with("exact to");
        let seen = of_bar || at.y < bar.top() - 14.0;
        (screen.contains(at) && seen && !is_plain(role, &name)).then_some((role, name, at))
    });
    words.collect()
}

/// Those over which nothing more is said while the pointer rests on them.
fn lacking(window: &mut Window) -> Vec<String> {
    let mut lacking = Vec::new();
    for (role, name, at) in words(window) {
        window.event(Input::PointerGone);
        window.run_steps(2);
        let before = said(window).len();
        window.hover_at(at);
        window.run_steps(3);
        if said(window).len() <= before {
            lacking.push(format!("{name} ({role:?})"));
        }
    }
    window.event(Input::PointerGone);
    window.run_steps(2);
    lacking
}

pub const TABS: [&str; 12] = [
    "Why",
    "Events",
    "Loops",
    "Stability",
    "Branches",
    "Landscape",
    "Map",
    "Ground",
    "Accuracy",
    "Study",
    "Equations",
    "Paper",
];

/// Cards come at once.
fn at_once(window: &Window) {
    window.ctx.all_styles_mut(|style| {
        style.interaction.tooltip_delay = 0.0;
        style.interaction.show_tooltips_only_when_still = false;
    });
}

#[test]
fn every_word_on_the_screen_and_on_each_tab_has_a_card() {
    let (mut window, _) = looped();
    at_once(&window);
    window.get_by_label("Advanced").click();
    window.run_steps(3);
    let mut seen = 0;
    for name in TABS {
        window.act(&format!("Tab: {name}"));
        seen += words(&window).len();
        assert_eq!(lacking(&mut window), [""; 0], "on the tab {name}");
    }
    assert!(seen > 40 * TABS.len(), "{seen}");
}

#[test]
fn the_words_of_a_computed_map_study_and_ground_have_cards_too() {
    let opened = |points| {
        let mut scene = fig2();
        scene.cell.points = points;
        let state = ViewState::new(scene).expect("allowed");
        let window = computing(state, LazyRenderer::default());
        at_once(&window);
        window
    };
    let check = |window: &mut Window, shown: &[&str]| {
        for words in shown {
            let there = said(window).iter().any(|said| said.contains(words));
            assert!(there, "{words}: {:?}", said(window));
        }
        assert_eq!(lacking(window), [""; 0], "beside {shown:?}");
    };
    let mut window = opened(Points::Square(32));
    window.act("Tab: Map");
    check(&mut window, &["approach", "retraction", "Loss"]);
    window.act("Tab: Study");
    window.get_by_label("Compute").click();
    window.run_steps(5);
    check(&mut window, &["15 of 15 loops"]);
    for (points, seen) in [
        (Points::Square(32), "height"),
        (Points::Line(64), "profile"),
    ] {
        let mut window = opened(points);
        window.get_by_label("ground waves").click();
        window.act("Tab: Ground");
        let panels = [
            "rms height",
            "power spectrum",
            "distribution of heights",
            seen,
        ];
        check(&mut window, &panels);
    }
}
