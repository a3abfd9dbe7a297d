//! How the panels share the window, at every size and zoom; and that nothing moves when a word comes.

use super::bench::Bench;
use super::hand::Hand;
use egui::{Key, Rect, Role, pos2, vec2};
use egui_kittest::kittest::Queryable;
use tackscope::follow::record::Direction;
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
            bench.reach(3.9, Direction::Approach);
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
        bench.reach(3.9, Direction::Approach);
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
        bench.reach(3.11, Direction::Approach);
        bench.jump(3.102);
        bench.reach(3.0, Direction::Retraction);
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
