//! A lesson in the window, by keyboard alone; resumed; lecture mode.

use super::bench::{Bench, fig2};
use super::stepped::{opened, rest};
use super::stored::looped;
use egui::{Event, Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use std::collections::HashMap;
use tackscope::follow::record::Direction;
use tackscope::lessons::{Hidden, Stage};
use tackscope::ui::App;

fn says(window: &Harness<'static, App>, words: &str) -> bool {
    window.query_all_by_label_contains(words).next().is_some()
        || window.query_all_by_value(words).next().is_some()
}

fn press(window: &mut Harness<'static, App>, key: Key) {
    window.key_press(key);
    window.run();
}

#[test]
fn the_first_lesson_is_passed_by_keyboard_alone() {
    let mut window = opened(fig2());
    window.key_press_modifiers(Modifiers::COMMAND, Key::K);
    window.run();
    window.event(Event::Text("lesson first snap".to_owned()));
    window.run();
    press(&mut window, Key::Enter);
    rest(&mut window);
    let at = |window: &Harness<'static, App>| {
        let progress = window.state().state().lesson.clone().expect("a lesson");
        (progress.step, progress.stage)
    };
    assert_eq!(at(&window), (0, Stage::Explained));
    assert!(says(
        &window,
        "Now u₀ is 4.20 ranges, and the surface is flat."
    ));
    press(&mut window, Key::Enter);
    assert_eq!(at(&window), (1, Stage::Asking));
    // What is ahead is hidden while it is guessed.
    assert!(window.state().state().hides(Hidden::Forecast));
    assert!(!says(&window, "live loop") && !says(&window, "foreseen"));
    press(&mut window, Key::Enter);
    assert_eq!(at(&window), (1, Stage::Asking), "no answer yet");
    for _ in 0..8 {
        press(&mut window, Key::ArrowRight);
    }
    press(&mut window, Key::Enter);
    assert_eq!(at(&window), (1, Stage::Doing));
    // The keys move the surface again.
    press(&mut window, Key::End);
    rest(&mut window);
    assert_eq!(at(&window), (1, Stage::Explained));
    assert!(says(&window, "It snapped at 3.102 ranges; your guess was"));
    press(&mut window, Key::Enter);
    press(&mut window, Key::Num2);
    press(&mut window, Key::Enter);
    assert!(says(&window, "Right. Theory (Eq. 8 of the paper)"));
    press(&mut window, Key::Enter);
    press(&mut window, Key::Num3);
    press(&mut window, Key::Enter);
    assert!(says(&window, "No: Into heat and sound."));
    press(&mut window, Key::Backspace);
    assert_eq!(at(&window), (2, Stage::Asking));
    press(&mut window, Key::Num2);
    press(&mut window, Key::Enter);
    press(&mut window, Key::Enter);
    press(&mut window, Key::Num1);
    press(&mut window, Key::Enter);
    press(&mut window, Key::Enter);
    assert!(says(&window, "The end. You have"));
}

/// The toolkit's memory.
/// What is kept between two sittings.
#[derive(Default)]
pub struct Memory(HashMap<String, String>);

impl eframe::Storage for Memory {
    fn get_string(&self, key: &str) -> Option<String> {
        self.0.get(key).cloned()
    }

    fn set_string(&mut self, key: &str, value: String) {
        self.0.insert(key.to_owned(), value);
    }

    fn remove_string(&mut self, key: &str) {
        self.0.remove(key);
    }

    fn flush(&mut self) {}
}

#[test]
fn a_lesson_is_resumed_where_it_was_left() {
    let mut window = opened(fig2());
    window.get_by_label("Lessons").click();
    window.run();
    window.get_by_label_contains("The mesh lies").click();
    window.run();
    // By skipping.
    window.get_by_label("Skip this step").click();
    window.run();
    rest(&mut window);
    let title = |window: &Harness<'static, App>| window.state().state().scene.title.clone();
    assert!(title(&window).contains("Too coarse"), "{}", title(&window));
    let left = window.state().state().lesson.clone();
    let mut memory = Memory::default();
    eframe::App::save(window.state_mut(), &mut memory);
    let mut later = opened(fig2());
    let ctx = later.ctx.clone();
    later.state_mut().resume(&ctx, &memory);
    rest(&mut later);
    assert_eq!(later.state().state().lesson, left);
    assert_eq!(title(&later), title(&window));
    assert!(says(&later, "Step 2 of 3"));
    later.get_by_label("Leave the lesson").click();
    later.run();
    assert!(later.state().state().lesson.is_none());
    assert!(says(&later, "law morse"), "the controls are back");
}

#[test]
fn a_lecture_is_enlarged_as_far_as_there_is_room() {
    for (size, zoom) in [((1280.0, 800.0), 1.4), ((640.0, 480.0), 1.0)] {
        let mut bench = Bench::sized(size.0, size.1);
        bench.reach(4.0, Direction::Approach);
        bench.press(Modifiers::NONE, Key::F11);
        bench.settle();
        let found = bench.window.ctx.zoom_factor();
        assert!((found - zoom).abs() < 0.1, "{found} at {size:?}");
        let slider = bench.window.get_by_label("mean displacement u0").rect();
        assert!(slider.height() > 80.0, "{slider:?} at {size:?}");
        bench.press(Modifiers::NONE, Key::F11);
        bench.settle();
        assert_eq!(bench.window.ctx.zoom_factor(), 1.0);
    }
}

#[test]
fn no_kept_loop_and_no_scene_beside_tells_what_a_lesson_asks() {
    let (mut window, _) = looped();
    window.key_press(Key::L);
    window.run();
    window.get_by_label("law cosine").click();
    rest(&mut window);
    let act = |window: &mut Harness<'static, App>, words: &str| {
        window.key_press_modifiers(Modifiers::COMMAND, Key::K);
        window.step();
        window.event(Event::Text(words.to_owned()));
        window.step();
        window.key_press(Key::Enter);
        rest(window);
    };
    act(&mut window, "A | B: compare");
    let beside = |window: &Harness<'static, App>| says(window, "B, Fig. 2");
    assert!(beside(&window));
    act(&mut window, "lesson first snap");
    assert!(!beside(&window) && !says(&window, "B: Fig. 2"));
    window.get_by_label("Leave the lesson").click();
    rest(&mut window);
    assert!(beside(&window), "they are there again");
}

#[test]
fn a_lecture_shows_map_curve_and_a_line_and_takes_guesses_first() {
    let mut bench = Bench::new();
    bench.reach(4.0, Direction::Approach);
    bench.press(Modifiers::NONE, Key::F11);
    bench.settle();
    let names = bench.names();
    let line = "Flat at u₀ = 4.00 ρ, stable. Where will it snap?";
    assert!(names.contains(line), "{names}");
    for gone in ["law morse", "Why tab", "Play approach"] {
        assert!(!names.contains(gone), "{gone}");
    }
    assert_eq!(bench.window.ctx.zoom_factor(), 1.4);
    let plot = bench.plot_sentence();
    let plot = bench
        .window
        .get_by_role_and_label(egui::Role::Image, plot.as_str())
        .rect();
    bench.click_at(plot.center());
    assert_eq!(bench.state().plots.guesses.len(), 1);
    assert!(bench.names().contains("Guesses: "));
    bench.reach(3.11, Direction::Approach);
    bench.jump(3.102);
    let names = bench.names();
    assert!(names.contains("Flat → ridge set free 0.123 γ."), "{names}");
    bench.click("Leave (F11)");
    assert_eq!(bench.window.ctx.zoom_factor(), 1.0);
    assert!(bench.names().contains("law morse"));
}
