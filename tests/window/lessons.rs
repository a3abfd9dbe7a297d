//! A lesson in the window, by keyboard alone; resumed; lecture mode; the click at a snap.

use super::bench::{Bench, fig2};
use super::hand::{Hand, Window, opened};
use super::stored::looped;
use eframe::App;
use egui::Key;
use egui_kittest::kittest::Queryable;
use std::collections::HashMap;
use tackscope::follow::record::{Cause, Direction, JumpRecord};
use tackscope::lessons::{Hidden, Stage};
use tackscope::worker::protocol::Event;

#[test]
fn the_first_lesson_is_passed_by_keyboard_alone() {
    let mut window = opened(fig2());
    window.act("lesson first snap");
    let at = |window: &Window| {
        let progress = window.view().lesson.clone().expect("a lesson");
        (progress.step, progress.stage)
    };
    assert_eq!(at(&window), (0, Stage::Explained));
    window.says("Now u₀ is 4.20 ranges, and the surface is flat.");
    window.tap(Key::Enter);
    assert_eq!(at(&window), (1, Stage::Asking));
    // What is ahead is hidden while it is guessed.
    assert!(window.view().hides(Hidden::Forecast));
    window.lacks("live loop");
    window.lacks("foreseen");
    window.tap(Key::Enter);
    assert_eq!(at(&window), (1, Stage::Asking), "no answer yet");
    for _ in 0..8 {
        window.tap(Key::ArrowRight);
    }
    window.tap(Key::Enter);
    assert_eq!(at(&window), (1, Stage::Doing));
    // The keys move the surface again.
    window.tap(Key::End);
    window.rest();
    assert_eq!(at(&window), (1, Stage::Explained));
    window.says("It snapped at 3.102 ranges; your guess was");
    window.tap(Key::Enter);
    window.tap(Key::Num2);
    window.tap(Key::Enter);
    window.says("Right. Theory (Eq. 8 of the paper)");
    window.tap(Key::Enter);
    window.tap(Key::Num3);
    window.tap(Key::Enter);
    window.says("No: Into heat and sound.");
    window.tap(Key::Backspace);
    assert_eq!(at(&window), (2, Stage::Asking));
    window.tap(Key::Num2);
    window.tap(Key::Enter);
    window.tap(Key::Enter);
    window.tap(Key::Num1);
    window.tap(Key::Enter);
    window.tap(Key::Enter);
    window.says("The end. You have");
}

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
    window.hit("Lessons");
    window.get_by_label_contains("The mesh lies").click();
    window.run();
    // By skipping.
    window.hit("Skip this step");
    window.rest();
    let title = |window: &Window| window.view().scene.title.clone();
    assert!(title(&window).contains("Too coarse"), "{}", title(&window));
    let left = window.view().lesson.clone();
    let mut memory = Memory::default();
    eframe::App::save(window.state_mut(), &mut memory);
    let mut later = opened(fig2());
    let ctx = later.ctx.clone();
    later.state_mut().resume(&ctx, &memory);
    later.rest();
    assert_eq!(later.view().lesson, left);
    assert_eq!(title(&later), title(&window));
    later.says("Step 2 of 3");
    later.hit("Leave the lesson");
    assert!(later.view().lesson.is_none());
    later.says("law morse");
}

#[test]
fn a_lecture_is_enlarged_as_far_as_there_is_room() {
    for (size, zoom) in [((1280.0, 800.0), 1.4), ((640.0, 480.0), 1.0)] {
        let mut bench = Bench::sized(size.0, size.1);
        bench.down(4.0);
        bench.tap(Key::F11);
        bench.settle();
        let found = bench.ctx.zoom_factor();
        assert!((found - zoom).abs() < 0.1, "{found} at {size:?}");
        let slider = bench.place_of("mean displacement u0");
        assert!(slider.height() > 80.0, "{slider:?} at {size:?}");
        bench.tap(Key::F11);
        bench.settle();
        assert_eq!(bench.ctx.zoom_factor(), 1.0);
    }
}

#[test]
fn no_kept_loop_and_no_scene_beside_tells_what_a_lesson_asks() {
    let (mut window, _) = looped();
    window.tap(Key::L);
    window.get_by_label("law cosine").click();
    window.rest();
    window.act("A | B: compare");
    window.says("B, Fig. 2");
    window.act("lesson first snap");
    window.lacks("B, Fig. 2");
    window.lacks("B: Fig. 2");
    window.get_by_label("Leave the lesson").click();
    window.rest();
    window.says("B, Fig. 2");
}

#[test]
fn a_lecture_shows_map_curve_and_a_line_and_takes_guesses_first() {
    let mut bench = Bench::new();
    bench.down(4.0);
    bench.tap(Key::F11);
    bench.settle();
    let line = "Flat at u₀ = 4.00 ρ, stable. Where will it snap?";
    bench.says(line);
    for gone in ["law morse", "Why tab", "Play approach"] {
        bench.lacks(gone);
    }
    assert_eq!(bench.ctx.zoom_factor(), 1.4);
    let plot = bench.plot_sentence();
    let plot = bench
        .get_by_role_and_label(egui::Role::Image, plot.as_str())
        .rect();
    bench.click_at(plot.center());
    assert_eq!(bench.view().plots.guesses.len(), 1);
    bench.says("Guesses: ");
    bench.down(3.11);
    bench.jump(3.102);
    bench.says("Flat → ridge set free 0.123 γ.");
    bench.click("Leave (F11)");
    assert_eq!(bench.ctx.zoom_factor(), 1.0);
    bench.says("law morse");
}

/// How often the player was called.
fn clicks(bench: &mut Bench) -> usize {
    bench.run_jobs();
    bench.player.lock().unwrap().0
}

/// Finds it in the palette.
fn switch(bench: &mut Bench) {
    bench.command("click snap");
}

#[test]
fn a_snap_clicks_once_where_that_is_wanted_and_nothing_clicks_at_first() {
    let mut bench = Bench::new();
    bench.jump(3.1);
    assert_eq!(clicks(&mut bench), 0);
    bench.click("Click at a snap");
    assert!(bench.view().messages.click);
    bench.down(3.0);
    assert_eq!(clicks(&mut bench), 0, "nothing snapped");
    bench.jump(2.9);
    assert_eq!(clicks(&mut bench), 1);
    bench.jump_on(Direction::Retraction, 3.8);
    assert_eq!(clicks(&mut bench), 2);
    bench.tap(Key::Escape);
    switch(&mut bench);
    bench.jump(1.3);
    assert_eq!(clicks(&mut bench), 2, "it is off again");
}

#[test]
fn what_is_no_snap_is_silent_and_a_rush_of_them_is_one_click() {
    let mut bench = Bench::new();
    switch(&mut bench);
    bench.jump(3.1);
    bench.jump(3.0);
    bench.jump(2.9);
    assert_eq!(clicks(&mut bench), 1, "the first still sounds");
    let last: JumpRecord = bench.view().run.record.jumps[0].clone();
    bench.say(Event::Jump(JumpRecord {
        cause: Cause::Transition,
        ..last.clone()
    }));
    let before = bench.view().run.id - 1;
    bench.say_of(before, Event::Jump(last));
    assert_eq!(
        clicks(&mut bench),
        1,
        "a transition, and a jump of a run that is over"
    );
}

#[test]
fn where_nothing_plays_sounds_it_is_said_once_and_nothing_is_tried_any_more() {
    let mut bench = Bench::new();
    bench.player.lock().unwrap().1 = Err("no player is there".to_owned());
    switch(&mut bench);
    bench.jump(3.1);
    assert_eq!(clicks(&mut bench), 1);
    bench.says("no click at a snap: no player is there");
    assert!(!bench.view().messages.click);
    bench.jump(2.9);
    assert_eq!(clicks(&mut bench), 1);
}

#[test]
fn the_click_is_kept_between_two_sittings_and_survives_restore_layout() {
    let mut bench = Bench::new();
    switch(&mut bench);
    bench.click("Restore layout");
    assert!(bench.view().messages.click);
    let mut memory = Memory::default();
    bench.state_mut().save(&mut memory);
    let mut next = Bench::new();
    let ctx = next.ctx.clone();
    next.state_mut().resume(&ctx, &memory);
    next.settle();
    next.jump(3.1);
    assert_eq!(clicks(&mut next), 1);
    next.hit("Menu");
    next.hit("Click at a snap");
    next.state_mut().save(&mut memory);
    let mut last = Bench::new();
    last.state_mut().resume(&ctx, &memory);
    assert!(!last.view().messages.click);
}
