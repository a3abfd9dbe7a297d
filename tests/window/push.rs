//! The surface pressed by hand: Alt and a drag on the map.

use super::bench::Bench;
use super::hand::{Hand, Window};
use super::stored::at_rest;
use super::stored::{apart, run, shown};
use super::tabs::surveyed;
use egui::{Event, Key, Modifiers, Pos2, Vec2, vec2};
use egui_kittest::kittest::Queryable;
use tackscope::follow::record::{Cause, Direction};
use tackscope::physics::pattern::Pattern;
use tackscope::worker::protocol::{self, Command, Play};

/// The window with the surface driven to this u0 from the start.
fn driven(u0: f64) -> Window {
    let mut window = at_rest();
    window.act(&u0.to_string());
    assert!(!run(&window).is_busy() && (run(&window).actual - u0).abs() < 1e-9);
    window
}

fn map(window: &Window) -> Pos2 {
    window.place("Gap map:").center()
}

/// Presses with Alt at a place, and goes so far; the button stays down.
fn alt_drag(window: &mut Window, from: Pos2, by: Vec2) {
    window.event(Event::ModifiersChanged(Modifiers::ALT));
    window.hover_at(from);
    window.step();
    window.drag_at(from);
    window.step();
    for share in [0.5, 1.0] {
        window.hover_at(from + share * by);
        window.run_steps(2);
    }
}

fn let_go(window: &mut Window, at: Pos2) {
    window.drop_at(at);
    window.step();
    window.event(Event::ModifiersChanged(Modifiers::NONE));
    window.run_steps(200);
}

fn words(window: &Window) -> String {
    window.view().push_in_words().expect("a push")
}

#[test]
fn a_small_push_is_pictured_has_an_energy_and_goes_back() {
    let mut window = driven(2.0);
    let (before, gap) = (run(&window).state.clone().expect("a state"), shown(&window));
    let (from, target) = (map(&window), window.view().target);
    alt_drag(&mut window, from, vec2(0.0, 30.0));
    assert!(matches!(run(&window).play, Play::Pressed(_)));
    assert!(apart(&gap, &shown(&window)) > 1e-3, "it is seen");
    assert!(
        (shown(&window).mean().unwrap() - 2.0).abs() < 1e-9,
        "u0 stays"
    );
    // The middle of the map is where it is pressed, whichever way the cell is rolled.
    let energy = run(&window).push.as_ref().expect("a push").energy;
    assert!(energy > 0.0);
    let gamma = window.view().model.law.surface_energy;
    let said = format!("The push has {:.2e} γL²", energy / gamma);
    assert!(words(&window).starts_with(&said), "{}", words(&window));
    window.says(&said);
    let_go(&mut window, from + vec2(0.0, 30.0));
    let after = run(&window).state.clone().expect("a state");
    assert!(
        !run(&window).is_busy()
            && run(&window)
                .record
                .jumps
                .iter()
                .all(|j| j.cause != Cause::Push)
    );
    assert_eq!(after.pattern, before.pattern);
    assert!((after.energy - before.energy).abs() < 1e-6 * gamma);
    let said = words(&window);
    assert!(said.ends_with("It went back."), "{said}");
    assert_eq!(window.view().target, target, "u0 was not driven");
}

#[test]
fn a_large_push_snaps_early_and_an_undo_brings_the_state_before_it_back() {
    let mut window = driven(3.12);
    let before = run(&window).state.clone().expect("a state");
    let states = run(&window).record.states.clone();
    let from = map(&window);
    alt_drag(&mut window, from, vec2(0.0, 150.0));
    let_go(&mut window, from + vec2(0.0, 150.0));
    let run_ = run(&window);
    let jump = run_.record.jumps.last().expect("it snapped");
    assert_eq!((jump.cause, jump.from), (Cause::Push, Pattern::Flat));
    assert_ne!(run_.state.as_ref().expect("a state").pattern, Pattern::Flat);
    let said = words(&window);
    assert!(said.contains("It snapped: flat →"), "{said}");
    window.hit("Why tab");
    window.says("pressed by hand");
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    window.run_steps(20);
    let now = run(&window).state.clone().expect("a state");
    assert_eq!(
        (now.pattern, now.control, now.energy),
        (before.pattern, before.control, before.energy)
    );
    assert_eq!(run(&window).record.states, states, "the way to it stays");
    assert!(run(&window).record.jumps.is_empty());
}

#[test]
fn escape_lets_what_is_pressed_be_as_it_was() {
    let mut window = driven(2.0);
    let gap = shown(&window);
    let from = map(&window);
    alt_drag(&mut window, from, vec2(0.0, 60.0));
    window.key_press(Key::Escape);
    window.run_steps(5);
    assert!(!run(&window).is_busy());
    assert!(apart(&gap, &shown(&window)) < 1e-6, "no longer pressed");
    let states = run(&window).record.states.len();
    let_go(&mut window, from + vec2(0.0, 60.0));
    assert_eq!(
        run(&window).record.states.len(),
        states,
        "nothing was let go"
    );
}

#[test]
fn nothing_is_pressed_beside_the_map_during_a_sweep_or_without_alt() {
    let mut window = driven(2.0);
    let beside = window.place("Stress against u0:").center();
    alt_drag(&mut window, beside, vec2(0.0, 40.0));
    assert!(run(&window).push.is_none() && !window.view().is_pressed());
    let_go(&mut window, beside);
    window.key_press(Key::Escape);
    window.run_steps(3);
    let from = map(&window);
    window.get_by_label("Play loop").click();
    window.step();
    alt_drag(&mut window, from, vec2(0.0, 20.0));
    assert!(!window.view().is_pressed());
    window.drop_at(from);
    window.event(Event::ModifiersChanged(Modifiers::NONE));
    window.rest();
    assert!(
        run(&window)
            .record
            .jumps
            .iter()
            .all(|jump| jump.cause != Cause::Push)
    );
    assert!(run(&window).push.is_none());
}

#[test]
fn in_lecture_mode_the_surface_is_pressed_as_well() {
    let mut window = driven(2.0);
    window.key_press(Key::F11);
    window.run_steps(4);
    let from = map(&window);
    alt_drag(&mut window, from, vec2(0.0, 20.0));
    assert!(window.view().is_pressed());
    let_go(&mut window, from + vec2(0.0, 20.0));
    assert!(!run(&window).is_busy());
    assert!(words(&window).contains("It "), "{}", words(&window));
}

#[test]
fn the_palette_presses_the_middle_without_a_mouse() {
    let mut window = driven(2.0);
    window.act("press a dimple");
    assert!(!run(&window).is_busy() && run(&window).push.is_some());
}

#[test]
fn the_barrier_is_said_beside_the_push_where_the_landscape_knows_it() {
    let (mut bench, found): (Bench, _) = surveyed();
    bench.heard();
    let from = bench.place("Gap map:").center();
    alt_drag(&mut bench, from, vec2(0.0, 20.0));
    let heard = bench.heard();
    let pressed = |command: &Command| matches!(command, Command::Press { .. });
    assert!(heard.iter().any(pressed), "{heard:?}");
    let gamma = bench.model.law.surface_energy;
    bench.say(protocol::Event::Pressed {
        energy: 2e-3 * gamma,
    });
    let barrier = found.passes[0].barrier() / gamma;
    let words = bench.state().push_in_words().expect("a push");
    let wanted = format!("2.00e-3 γL²; the lowest barrier is {barrier:.2e} γL²");
    assert!(words.contains(&wanted), "{words}");
}

#[test]
fn nothing_is_moved_out_of_its_place_when_alt_is_held_in_a_small_window() {
    let mut bench = Bench::sized(900.0, 600.0);
    bench.reach(3.5, Direction::Approach);
    let place = |bench: &Bench| bench.place("Gap map:");
    let before = place(&bench);
    bench.hover_at(before.center());
    bench.event(Event::ModifiersChanged(Modifiers::ALT));
    bench.run_steps(4);
    assert!(bench.query_by_label("Width of the push").is_some());
    assert_eq!(place(&bench), before);
}
