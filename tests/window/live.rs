//! The live loop in the window: drawn late but never dropped while a parameter is dragged, and read
//! before the walk is there.

use super::bench::{Bench, fig2};
use egui::{Key, Modifiers};
use std::sync::Arc;
use tackscope::follow::record::Direction;
use tackscope::physics::pattern::Pattern;
use tackscope::study::live_loop::{Fineness, LiveLoops};
use tackscope::worker::protocol::{Event, LiveState};

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
    bench.reach(4.2, Direction::Approach);
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
    let shown = |bench: &Bench| bench.state().plots.live.as_ref().map(|live| live.run);
    bench.say_of(2, Event::Live(live()));
    assert_eq!(shown(&bench), Some(2));
    bench.say_of(1, Event::Live(live()));
    assert_eq!(shown(&bench), Some(2));
    bench.press(Modifiers::NONE, Key::End);
    assert_eq!(bench.state().foreseen(), None, "it belongs to another law");
    bench.say_of(3, Event::Live(live()));
    assert_eq!(shown(&bench), Some(3));
}

#[test]
fn where_the_surface_will_stand_is_said_in_the_frame_in_which_the_slider_moves() {
    let mut bench = Bench::new();
    bench.reach(4.2, Direction::Approach);
    bench.say_of(1, Event::Live(live()));
    assert_eq!(bench.state().foreseen(), None);
    bench.enter("Target", "2.0");
    let (pattern, sample) = bench.state().foreseen().expect("an answer from the atlas");
    assert_eq!((pattern, sample.control), (Pattern::Ridge, 2.0));
    assert!(
        bench.names().contains("ahead: ridge, stress"),
        "{}",
        bench.names()
    );
    bench.reach(2.0, Direction::Approach);
    assert_eq!(bench.state().foreseen(), None, "the walk is there");
}

#[test]
fn a_scene_the_atlas_does_not_hold_says_so_in_words() {
    let mut bench = Bench::new();
    bench.reach(4.2, Direction::Approach);
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
