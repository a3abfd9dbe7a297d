//! The click at a snap.

use super::bench::Bench;
use super::lessons::Memory;
use eframe::App;
use egui::{Event as Input, Key, Modifiers};
use egui_kittest::kittest::Queryable;
use tackscope::follow::record::{Cause, Direction, JumpRecord};
use tackscope::worker::protocol::Event;

/// How often the player was called.
fn clicks(bench: &mut Bench) -> usize {
    bench.run_jobs();
    bench.player.lock().unwrap().0
}

/// Finds it in the palette.
fn switch(bench: &mut Bench) {
    bench.press(Modifiers::COMMAND, Key::K);
    bench.window.event(Input::Text("click snap".to_owned()));
    bench.window.run();
    bench.press(Modifiers::NONE, Key::Enter);
}

#[test]
fn a_snap_clicks_once_where_that_is_wanted_and_nothing_clicks_at_first() {
    let mut bench = Bench::new();
    bench.jump(3.1);
    assert_eq!(clicks(&mut bench), 0);
    bench.click("Click at a snap");
    assert!(bench.state().messages.click);
    bench.reach(3.0, Direction::Approach);
    assert_eq!(clicks(&mut bench), 0, "nothing snapped");
    bench.jump(2.9);
    assert_eq!(clicks(&mut bench), 1);
    bench.jump_on(Direction::Retraction, 3.8);
    assert_eq!(clicks(&mut bench), 2);
    bench.press(Modifiers::NONE, Key::Escape);
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
    let last: JumpRecord = bench.state().run.record.jumps[0].clone();
    bench.say(Event::Jump(JumpRecord {
        cause: Cause::Transition,
        ..last.clone()
    }));
    let before = bench.state().run.id - 1;
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
    let names = bench.names();
    assert!(
        names.contains("no click at a snap: no player is there"),
        "{names}"
    );
    assert!(!bench.state().messages.click);
    bench.jump(2.9);
    assert_eq!(clicks(&mut bench), 1);
}

#[test]
fn the_click_is_kept_between_two_sittings_and_survives_restore_layout() {
    let mut bench = Bench::new();
    switch(&mut bench);
    bench.click("Restore layout");
    assert!(bench.state().messages.click);
    let mut memory = Memory::default();
    bench.window.state_mut().save(&mut memory);
    let mut next = Bench::new();
    let ctx = next.window.ctx.clone();
    next.window.state_mut().resume(&ctx, &memory);
    next.settle();
    next.jump(3.1);
    assert_eq!(clicks(&mut next), 1);
    next.window.get_by_label("Menu").click();
    next.settle();
    next.window.get_by_label("Click at a snap").click();
    next.settle();
    next.window.state_mut().save(&mut memory);
    let mut last = Bench::new();
    last.window.state_mut().resume(&ctx, &memory);
    assert!(!last.state().messages.click);
}
