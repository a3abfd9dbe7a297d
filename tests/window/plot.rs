//! The plot: its axes by the mouse; stored states and jumps that are looked at; the live loop, drawn late
//! but never dropped while a parameter is dragged, and read before the walk is there; the scene on the
//! clipboard; the layout restored.

use super::bench::{Bench, fig2};
use super::hand::{Hand, folder, place_for};
use egui::epaint::{ClippedShape, Shape};
use egui::{
    Event as Input, Key, Modifiers, MouseWheelSource, MouseWheelUnit, OutputCommand, PointerButton,
    Pos2, Rect, TouchPhase, Vec2, vec2,
};
use egui_kittest::kittest::Queryable;
use std::sync::Arc;
use tackscope::physics::pattern::Pattern;
use tackscope::plot::style::Colours;
use tackscope::storage::scene_file;
use tackscope::study::live_loop::{Fineness, LiveLoops};
use tackscope::ui::theme;
use tackscope::worker::protocol::{Event, LiveState};

/// Down through two jumps.
fn walked() -> Bench {
    let mut bench = Bench::new();
    for (u0, jumps) in [
        (4.0, false),
        (3.5, false),
        (3.102, true),
        (3.0, false),
        (2.9, true),
        (2.8, false),
    ] {
        if jumps {
            bench.jump(u0);
        }
        bench.down(u0);
    }
    bench
}

#[test]
fn a_click_on_the_curve_shows_the_numbers_of_the_state_there() {
    let mut bench = walked();
    let plot = bench
        .get_by_role_and_label(egui::Role::Image, bench.plot_sentence().as_str())
        .rect();
    // The axes are the scene's; the plot's own margins are found by asking for the place of two
    // known values.
    let state = bench.view().run.record.states[1].clone();
    let found = (0..200).any(|i| {
        let x = plot.left() + plot.width() * (0.6 + 0.002 * i as f32);
        (0..8).any(|k| {
            let y = plot.bottom() - plot.height() * (0.08 + 0.02 * k as f32);
            bench.click_at(egui::pos2(x, y));
            bench
                .view()
                .run
                .selection
                .as_ref()
                .is_some_and(|s| s.state == state)
        })
    });
    assert!(found, "no click found the state at 3.5");
    for words in ["flat on approach", "u₀ 3.50000 ρ", "Walk to it"] {
        bench.says(words);
    }
    bench.heard();
    bench.click("Walk to it");
    assert_eq!(bench.targets(), [3.5]);
    bench.click("Close the card");
    assert_eq!(bench.view().run.selection, None);
}

#[test]
fn j_and_k_step_through_the_jumps_and_escape_leaves_them() {
    let mut bench = walked();
    let at = |bench: &Bench| {
        bench
            .view()
            .run
            .selection
            .as_ref()
            .map(|s| (s.jump, s.state.mean_displacement))
    };
    bench.tap(Key::K);
    assert_eq!(at(&bench), Some((Some(1), 2.9)));
    bench.tap(Key::K);
    assert_eq!(at(&bench), Some((Some(0), 3.102)));
    bench.tap(Key::K);
    assert_eq!(at(&bench), Some((Some(0), 3.102)));
    bench.tap(Key::J);
    assert_eq!(at(&bench), Some((Some(1), 2.9)));
    bench.tap(Key::Escape);
    assert_eq!(at(&bench), None);
}

#[test]
fn a_click_on_a_row_of_the_events_shows_the_state_after_that_jump() {
    let mut bench = walked();
    bench.click("Events tab");
    bench.click("3.102");
    assert_eq!(
        bench
            .view()
            .run
            .selection
            .as_ref()
            .map(|s| (s.jump, s.state.mean_displacement)),
        Some((Some(0), 3.102))
    );
    bench.says("flat → ridge released 0.1234 γ");
}

#[test]
fn the_scene_goes_to_the_clipboard_as_text_and_comes_back() {
    let mut bench = Bench::new();
    bench.unfold("Copy scene");
    bench.get_by_label("Copy scene").click();
    bench.step();
    let copied = bench
        .output()
        .platform_output
        .commands
        .iter()
        .find_map(|command| match command {
            OutputCommand::CopyText(text) => Some(text.clone()),
            _ => None,
        });
    let copied = copied.expect("text on the clipboard");
    assert_eq!(scene_file::parse(&copied, "clipboard").unwrap(), fig2());
    bench.settle();
    let text = copied.replace("length = 256", "length = 200");
    bench.event(Input::Paste(text));
    bench.settle();
    assert_eq!(bench.view().scene.cell.length, 200.0);
    bench.event(Input::Paste("a shopping list".to_owned()));
    bench.settle();
    assert!(bench.view().messages.failure.is_some() && bench.view().scene.cell.length == 200.0);
}

#[test]
fn restore_layout_brings_view_and_axes_back() {
    let mut bench = walked();
    bench.click("Fit");
    bench.click("Stability tab");
    bench.click("soft mode on map");
    bench.click("Restore layout");
    assert_eq!(bench.view().view, Default::default());
    assert_eq!(bench.view().plots.fit, None);
}

#[test]
fn the_map_and_its_picture_are_in_the_chosen_colours() {
    let mut bench = walked();
    let folder = folder();
    for (colours, word) in Colours::ALL {
        bench.click(&format!("Colours: {word}"));
        bench.tap(Key::Escape);
        assert_eq!(bench.view().view.colours, colours);
        let path = folder.path().join(format!("{}.png", word.len()));
        bench.click("Export picture…");
        bench.click("gap map");
        write_to(&mut bench, &path);
        let picture = image::open(&path).expect("a picture").to_rgb8();
        // A uniform gap has no contrast: all of it is the colour of the scale's beginning.
        assert_eq!(picture.get_pixel(9, 9).0, colours.at(0.0), "{word}");
    }
    // On the screen the colour bar ends in the last colour.
    let last = theme::rgb(Colours::Paper.at(1.0 - 0.5 / 64.0));
    let filled =
        |shape: &ClippedShape| matches!(&shape.shape, Shape::Rect(rect) if rect.fill == last);
    assert!(bench.output().shapes.iter().any(filled));
}

/// Types the path of the open dialog and writes.
fn write_to(bench: &mut Bench, path: &std::path::Path) {
    bench
        .get_by_role_and_label(egui::Role::TextInput, "Path")
        .focus();
    bench.run();
    bench.write_over(&path.display().to_string());
    bench.click("Write");
    assert_eq!(bench.view().messages.failure, None);
}

#[test]
fn the_curve_is_written_as_an_svg_that_names_the_scene() {
    let mut bench = walked();
    let (_folder, path) = place_for("loop.svg");
    bench.click("Export picture…");
    bench.click("stress curve, SVG");
    write_to(&mut bench, &path);
    let text = std::fs::read_to_string(&path).expect("written");
    assert!(
        text.starts_with("<svg") || text.starts_with("<?xml"),
        "{text:.80}"
    );
    assert!(text.contains("four patterns") && text.contains("</svg>"));
}

#[test]
fn an_exported_picture_opens_again_as_its_scene() {
    let mut bench = walked();
    bench.click("law cosine");
    let scene = bench.view().scene.clone();
    let (_folder, path) = place_for("loop.png");
    bench.click("Export picture…");
    write_to(&mut bench, &path);
    bench.click("law mie");
    bench.open(&path);
    assert_eq!(
        (
            bench.view().messages.failure.clone(),
            bench.view().scene.clone()
        ),
        (None, scene)
    );
}

/// A window with a curve, and the place of its plot.
fn zoomable() -> (Bench, Rect) {
    let mut bench = Bench::new();
    for i in 0..8 {
        bench.down(4.0 - 0.1 * f64::from(i));
    }
    let plot = bench.place("Stress against u0:");
    (bench, plot)
}

fn wheel(bench: &mut Bench, at: Pos2, turned: f32) {
    bench.hover_at(at);
    bench.step();
    bench.event(Input::MouseWheel {
        unit: MouseWheelUnit::Point,
        delta: vec2(0.0, turned),
        phase: TouchPhase::Move,
        source: MouseWheelSource::Wheel,
        modifiers: Modifiers::NONE,
    });
    bench.settle();
}

/// The value at a place in shares of the axes.
fn at(bench: &Bench, share: [f64; 2]) -> [f64; 2] {
    let (low, high) = bench.view().axes();
    [0, 1].map(|k| low[k] + share[k] * (high[k] - low[k]))
}

fn near(a: [f64; 2], b: [f64; 2], within: f64) -> bool {
    (0..2).all(|k| (a[k] - b[k]).abs() < within)
}

#[test]
fn the_wheel_over_the_plot_zooms_about_the_pointer_and_scene_axes_brings_it_back() {
    let (mut bench, plot) = zoomable();
    let scene = bench.view().axes();
    let length = |bench: &Bench| {
        let (low, high) = bench.view().axes();
        [high[0] - low[0], high[1] - low[1]]
    };
    let (begun, target) = (length(&bench), bench.view().target);
    // Something stays where it is: the place under the pointer, wherever that is in the frame.
    let pointer = plot.lerp_inside(vec2(0.7, 0.4));
    wheel(&mut bench, pointer, 80.0);
    let (closer, (low, high)) = (length(&bench), bench.view().axes());
    assert!(
        (0..2).all(|k| closer[k] < 0.8 * begun[k]),
        "{closer:?} {begun:?}"
    );
    assert!((0..2).all(|k| low[k] > scene.0[k] && high[k] < scene.1[k]));
    assert!(
        (closer[0] / begun[0] - closer[1] / begun[1]).abs() < 1e-9,
        "both alike"
    );
    // The fixed place is the same from step to step.
    let fixed = |before: ([f64; 2], [f64; 2]), after: ([f64; 2], [f64; 2])| {
        [0, 1].map(|k| {
            let shrunk = (after.1[k] - after.0[k]) / (before.1[k] - before.0[k]);
            (after.0[k] - shrunk * before.0[k]) / (1.0 - shrunk)
        })
    };
    let first = fixed(scene, (low, high));
    wheel(&mut bench, pointer, 80.0);
    let second = fixed((low, high), bench.view().axes());
    assert!(near(first, second, 1e-3), "{first:?} {second:?}");
    wheel(&mut bench, pointer, -400.0);
    assert!(length(&bench)[0] > begun[0]);
    // Never lost in the void.
    for _ in 0..20 {
        wheel(&mut bench, pointer, -800.0);
    }
    assert!(length(&bench)[0] < 5.0 * begun[0]);
    assert_eq!(bench.view().target, target, "the body has not moved");
    bench.click("Scene axes");
    assert_eq!(bench.view().axes(), scene);
}

#[test]
fn a_drag_with_the_second_button_moves_the_axes_and_shows_no_stored_state() {
    let (mut bench, plot) = zoomable();
    let before = at(&bench, [0.0, 0.0]);
    let from = plot.center();
    bench.hover_at(from);
    bench.step();
    bench.button(from, PointerButton::Secondary, true);
    let by: Vec2 = vec2(-60.0, 30.0);
    bench.hover_at(from + by);
    bench.step();
    bench.step();
    bench.button(from + by, PointerButton::Secondary, false);
    bench.settle();
    let after = at(&bench, [0.0, 0.0]);
    // What lay at the right comes in, and what lay above.
    assert!(
        after[0] > before[0] && after[1] > before[1],
        "{before:?} {after:?}"
    );
    assert!(bench.view().run.selection.is_none());
}

pub fn live() -> Arc<LiveState> {
    let scene = fig2();
    let found = LiveLoops::default()
        .next(&scene, &scene.model().unwrap(), Fineness::Coarse)
        .map_err(|e| e.to_string());
    assert!(found.is_ok(), "{found:?}");
    Arc::new(LiveState {
        found,
        fineness: Fineness::Coarse,
        milliseconds: 7.3,
    })
}

#[test]
fn the_live_loop_is_drawn_and_its_energy_and_milliseconds_are_in_the_status_bar() {
    let mut bench = Bench::new();
    bench.down(4.2);
    let live = live();
    let lost = live.found.as_ref().unwrap().dissipated_energy;
    bench.say(Event::Live(live));
    let names = bench.status();
    let status = format!("loop {lost:.4} γ in 7 ms (atlas, 40 points)");
    let headline = format!("{lost:.4} γ a loop");
    for words in ["live\n", &status, &headline, "live loop, 8 jumps"] {
        assert!(names.contains(words), "{words} in {names}");
    }
}

#[test]
fn a_loop_of_an_older_run_is_shown_until_a_newer_one_comes_and_never_after_it() {
    let mut bench = Bench::new();
    bench.click("law cosine");
    bench.click("law mie");
    let shown = |bench: &Bench| bench.view().plots.live.as_ref().map(|live| live.run);
    bench.say_of(2, Event::Live(live()));
    assert_eq!(shown(&bench), Some(2));
    bench.say_of(1, Event::Live(live()));
    assert_eq!(shown(&bench), Some(2));
    bench.tap(Key::End);
    assert_eq!(bench.view().foreseen(), None, "it belongs to another law");
    bench.say_of(3, Event::Live(live()));
    assert_eq!(shown(&bench), Some(3));
}

#[test]
fn where_the_surface_will_stand_is_said_in_the_frame_in_which_the_slider_moves() {
    let mut bench = Bench::new();
    bench.down(4.2);
    bench.say_of(1, Event::Live(live()));
    assert_eq!(bench.view().foreseen(), None);
    bench.enter("Target", "2.0");
    let (pattern, sample) = bench.view().foreseen().expect("an answer from the atlas");
    assert_eq!((pattern, sample.control), (Pattern::Ridge, 2.0));
    bench.says("ahead: ridge, stress");
    bench.down(2.0);
    assert_eq!(bench.view().foreseen(), None, "the walk is there");
}

#[test]
fn a_scene_the_atlas_does_not_hold_says_so_in_words() {
    let mut bench = Bench::new();
    bench.down(4.2);
    let found = Err("the atlas holds square cells on flat ground".to_owned());
    bench.say(Event::Live(Arc::new(LiveState {
        found,
        fineness: Fineness::Coarse,
        milliseconds: 0.0,
    })));
    let names = bench.status();
    let words = "no live loop: the atlas holds square cells on flat ground";
    assert!(names.contains(words), "{names}");
}
