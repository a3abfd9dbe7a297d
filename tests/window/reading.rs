//! What is written where: readings cover nothing, words are whole, and the present point lies on none.

use super::bench::fig2;
use super::stepped::{act, foretold, opened};
use super::stored::looped;
use egui::epaint::{ClippedShape, Shape};
use egui::{Event, Key, Modifiers, Rect, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use tackscope::scene::Points;
use tackscope::ui::App;

/// Everything that is drawn, one by one.
fn shapes(window: &Harness<'static, App>) -> Vec<Shape> {
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
fn written(window: &Harness<'static, App>, letters: &str) -> Vec<(String, Rect, bool)> {
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
    let mut scene = fig2();
    scene.cell.points = Points::Square(32);
    let mut window = opened(scene);
    act(&mut window, "3.05");
    for size in [[1280.0, 800.0], [900.0, 600.0]] {
        window.set_size(vec2(size[0], size[1]));
        window.run();
        let profile = window.get_by_label_contains("Profile along").rect();
        let map = window.get_by_label_contains("Gap map:").rect();
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
            act(&mut window, &format!("{:.2}", 4.1 - 0.3 * f64::from(step)));
            let plot = window.get_by_label_contains("Stress against u0:").rect();
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
    window.key_press_modifiers(Modifiers::COMMAND, Key::K);
    window.step();
    window.event(Event::Text("1.4".to_owned()));
    window.step();
    window.key_press(Key::Enter);
    window.run_steps(4);
    let mut seen = 0;
    while window.state().state().run.is_busy() {
        window.step();
        let plot = window.get_by_label_contains("Stress against u0:").rect();
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
