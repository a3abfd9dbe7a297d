//! Stored states: looked at, scrubbed through, gone on from; the strip; undo with the surface; the path as
//! a film.

use super::bench::fig2;
use super::foreseen::at_rest;
use super::stepped::opened;
use egui::{Event, Key, Modifiers, Pos2, pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use ndarray::Array2;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use tackscope::follow::record::{Direction, StateRecord};
use tackscope::scene::Points;
use tackscope::ui::App;
use tackscope::ui::view_state::{Origin, RunView, Stretch, stretches};

/// A state, and its gap as it was seen.
pub type Seen = (StateRecord, Arc<Array2<f64>>);

/// The window after a loop of a coarse Fig. 2, and every picture that was seen of it at rest.
pub fn looped() -> (Harness<'static, App>, Vec<Seen>) {
    let mut scene = fig2();
    scene.cell.points = Points::Square(48);
    let mut window = opened(scene);
    window.get_by_label("Play loop").click();
    window.step();
    let mut seen = Vec::new();
    let mut frames = 0;
    while run(&window).is_busy() {
        window.step();
        let frame = window.state().state().frame.clone().expect("a picture");
        if let Some(state) = &frame.state {
            seen.push((state.clone(), frame.gap.clone()));
        }
        frames += 1;
        assert!(frames < 2000, "it never comes to rest");
    }
    window.run();
    (window, seen)
}

pub fn run<'a>(window: &'a Harness<'static, App>) -> &'a RunView {
    &window.state().state().run
}

/// What map and profile show.
pub fn shown(window: &Harness<'static, App>) -> Arc<Array2<f64>> {
    let frame = window.state().state().pictured();
    frame.expect("a picture").gap.clone()
}

/// The largest difference, in shares of the largest gap.
pub fn apart(a: &Array2<f64>, b: &Array2<f64>) -> f64 {
    let largest = a.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let off = (a - b).iter().fold(0.0f64, |m, x| m.max(x.abs()));
    off / largest
}

pub fn press_at(window: &mut Harness<'static, App>, at: Pos2) {
    window.hover_at(at);
    window.step();
    window.drag_at(at);
    window.step();
    window.drop_at(at);
    window.run();
}

/// The accessible name and the place of the strip.
pub fn strip(window: &Harness<'static, App>) -> (String, egui::Rect) {
    let node = window.get_by_label_contains("Patterns walked:");
    let name = node.accesskit_node().label().expect("a name").clone();
    (name, node.rect())
}

#[test]
fn a_press_on_the_strip_shows_that_very_state_and_escape_the_present() {
    let (mut window, seen) = looped();
    let (low, high) = window.state().state().limits;
    let present = shown(&window);
    for (direction, row) in [(Direction::Approach, 0.25), (Direction::Retraction, 0.75)] {
        for share in [0.15, 0.3, 0.5, 0.6, 0.8] {
            let (_, place) = strip(&window);
            let at = pos2(
                place.left() + share * place.width(),
                place.top() + row * place.height(),
            );
            press_at(&mut window, at);
            let selection = run(&window).selection.clone().expect("a state");
            assert_eq!(selection.state.direction, direction);
            let wanted = low + f64::from(share) * (high - low);
            assert!((selection.state.control - wanted).abs() < 0.02, "{wanted}");
            let this = |s: &StateRecord| {
                (s.direction, s.control, s.energy)
                    == (direction, selection.state.control, selection.state.energy)
            };
            // Of the states of one frame the last was pictured.
            if let Some((_, gap)) = seen.iter().find(|(state, _)| this(state)) {
                assert!(apart(gap, &shown(&window)) < 1e-6, "{direction} {share}");
            }
            assert!(
                window
                    .query_all_by_label_contains("Gap map: stored")
                    .next()
                    .is_some()
            );
        }
    }
    window.key_press(Key::Escape);
    window.run();
    assert!(run(&window).selection.is_none() && Arc::ptr_eq(&present, &shown(&window)));
}

#[test]
fn every_state_that_was_seen_is_shown_again_as_it_was() {
    let (mut window, seen) = looped();
    // Two bursts of keys: back along the whole path.
    let mut compared = 0;
    for _ in 0..run(&window).record.states.len() {
        window.key_press(Key::OpenBracket);
        window.step();
        let state = run(&window).selection.clone().expect("a state").state;
        let this = |s: &StateRecord| {
            (s.direction, s.control, s.energy) == (state.direction, state.control, state.energy)
        };
        if let Some((_, gap)) = seen.iter().find(|(state, _)| this(state)) {
            assert!(apart(gap, &shown(&window)) < 1e-6, "{state:?}");
            compared += 1;
        }
    }
    assert!(compared >= 10, "{compared}");
    assert_eq!(
        run(&window).selection.as_ref().map(|s| s.of),
        Some(Origin::Walked(0))
    );
}

#[test]
fn the_letters_of_the_strip_are_those_of_the_jumps() {
    let (window, _) = looped();
    let record = &run(&window).record;
    let mut wanted = String::new();
    for direction in Direction::BOTH {
        let jumps = record.jumps.iter().filter(|j| j.direction == direction);
        let all: Vec<&str> = jumps
            .clone()
            .take(1)
            .map(|j| j.from)
            .chain(jumps.map(|j| j.to))
            .map(|pattern| &pattern.word()[..1])
            .collect();
        wanted += &format!("{} on {direction}, ", all.join(" ").to_uppercase());
    }
    let (name, _) = strip(&window);
    let wanted = wanted.trim_end_matches(", ");
    assert!(name.contains(wanted), "{wanted} in {name}");
    assert!(wanted.starts_with("F B R D F on approach"), "{wanted}");
    let found = stretches(record);
    let ends: Vec<f64> = found
        .windows(2)
        .filter(|w| w[0].direction == w[1].direction)
        .map(|w| w[1].ends[0])
        .collect();
    let jumps: Vec<f64> = record.jumps.iter().map(|jump| jump.control).collect();
    // States stand on both sides of a jump, which is located to a hundred-thousandth of a range.
    assert_eq!(ends.len(), jumps.len());
    for (end, jump) in ends.iter().zip(&jumps) {
        assert!((end - jump).abs() <= 1e-5, "{end} {jump}");
    }
    assert!(found.iter().all(|s: &Stretch| s.ends[0] != s.ends[1]));
}

#[test]
fn go_on_from_here_forks_the_path_and_keeps_the_way_to_that_state() {
    let (mut window, _) = looped();
    let before = run(&window).record.clone();
    // After the second jump.
    window.key_press(Key::J);
    window.run();
    window.key_press(Key::J);
    window.run();
    let chosen = run(&window).selection.clone().expect("a state");
    let gap = shown(&window);
    window.key_press(Key::G);
    window.step();
    window.run();
    let after = run(&window);
    assert!(!after.is_busy() && after.selection.is_none());
    assert_eq!(after.actual, chosen.state.control);
    assert!(apart(&gap, &shown(&window)) < 1e-6);
    let Origin::Walked(index) = chosen.of else {
        panic!("{chosen:?}")
    };
    let way = &before.states[..=index];
    assert_eq!(after.record.states[..], *way, "the way to it stays");
    assert_eq!(after.record.jumps[..], before.jumps[..2]);
    assert_eq!(window.state().state().plots.ghosts.len(), 1);
    // It goes on as it went.
    window.get_by_label("Play approach").click();
    window.step();
    while run(&window).is_busy() {
        window.step();
    }
    let again = &run(&window).record;
    for (a, b) in again.jumps.iter().zip(&before.jumps).take(4) {
        assert_eq!((a.from, a.to), (b.from, b.to));
        assert!((a.control - b.control).abs() < 2e-5, "{a:?} {b:?}");
    }
    assert!(again.jumps.len() >= 4);
}

#[test]
fn the_states_on_a_path_that_a_fork_left_are_shown_and_gone_on_from() {
    let (mut window, _) = looped();
    let mut seen = Vec::new();
    for _ in 0..run(&window).record.states.len() {
        window.key_press(Key::OpenBracket);
        window.step();
        let chosen = run(&window).selection.clone().expect("a state");
        seen.push((chosen.state, shown(&window)));
    }
    for key in [Key::J, Key::J, Key::G] {
        window.key_press(key);
        window.step();
        window.run();
    }
    let reached = run(&window).record.states.len();
    let plot = window.get_by_label_contains("Stress against u0:").rect();
    // Up a line through what was walked after the fork.
    let x = plot.left() + 0.45 * plot.width();
    let state = |s: &StateRecord| (s.direction, s.control, s.energy);
    let chosen = (0..90).find_map(|k| {
        press_at(&mut window, pos2(x, plot.bottom() - 40.0 - 4.0 * k as f32));
        run(&window).selection.clone()
    });
    let chosen = chosen.expect("the grey line is met");
    assert!(matches!(chosen.of, Origin::Left(_)), "{chosen:?}");
    let this = seen.iter().find(|(s, _)| state(s) == state(&chosen.state));
    let (_, gap) = this.expect("a state that was walked");
    assert!(chosen.state.control < run(&window).actual);
    assert!(apart(gap, &shown(&window)) < 1e-6);
    assert_eq!(run(&window).record.states.len(), reached);
    window.key_press(Key::G);
    window.step();
    window.run();
    let now = run(&window).state.clone().expect("a state");
    assert_eq!(state(&now), state(&chosen.state));
    assert!(apart(gap, &shown(&window)) < 1e-6);
}

#[test]
fn an_undo_brings_the_surface_back_where_it_was() {
    let (mut window, _) = looped();
    window.key_press(Key::J);
    window.run();
    window.key_press(Key::J);
    window.run();
    window.key_press(Key::G);
    window.step();
    window.run();
    let (gap, state) = (shown(&window), run(&window).state.clone().expect("a state"));
    window.get_by_label("law cosine").click();
    window.run();
    for _ in 0..200 {
        window.step();
    }
    assert!(apart(&gap, &shown(&window)) > 1e-3);
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    window.step();
    for _ in 0..20 {
        window.step();
    }
    let now = run(&window).state.clone().expect("a state");
    assert_eq!(
        (now.pattern, now.control, now.energy, now.direction),
        (state.pattern, state.control, state.energy, state.direction)
    );
    assert!(apart(&gap, &shown(&window)) < 1e-6);
    assert!(!run(&window).is_busy());
}

/// Asks the palette for a film of this kind at this path.
fn ask(window: &mut Harness<'static, App>, kind: &str, path: &Path) {
    window.key_press_modifiers(Modifiers::COMMAND, Key::K);
    (0..3).for_each(|_| window.step());
    window.event(Event::Text(format!("film {kind}")));
    (0..2).for_each(|_| window.step());
    window.key_press(Key::Enter);
    (0..3).for_each(|_| window.step());
    window.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.step();
    window.event(Event::Text(path.display().to_string()));
    window.step();
    window.get_by_label("Write").click();
    window.step();
}

/// Waits until it is said what became of it.
fn said(window: &mut Harness<'static, App>) -> String {
    for _ in 0..2000 {
        window.step();
        if let Some(notice) = &window.state().state().messages.notice {
            return notice.clone();
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("{:?}", window.state().state().messages);
}

#[test]
fn the_stored_states_become_a_film_with_one_picture_each() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = at_rest();
    window.key_press(Key::PageDown);
    (0..60).for_each(|_| window.step());
    let states = run(&window).record.states.len();
    assert!(states > 5 && states < 300, "{states}");
    let path = folder.path().join("film.gif");
    ask(&mut window, "gif", &path);
    let words = said(&mut window);
    assert!(words.contains("film.gif written"), "{words}");
    let mut film = gif::DecodeOptions::new()
        .read_info(std::fs::File::open(&path).unwrap())
        .unwrap();
    let mut pictures = 0;
    while film.read_next_frame().unwrap().is_some() {
        pictures += 1;
    }
    assert_eq!(pictures, states);
}

#[test]
fn a_film_is_given_up_by_its_button_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = at_rest();
    window.get_by_label("Play loop").click();
    window.step();
    while run(&window).is_busy() {
        window.step();
    }
    let path = folder.path().join("film.png");
    ask(&mut window, "animated", &path);
    if let Some(button) = window.query_by_label("Cancel") {
        button.click();
    }
    let words = said(&mut window);
    // A quick machine may have written it before the button was there.
    let given_up = words == "the film was given up";
    assert!(given_up || path.exists(), "{words}");
    for _ in 0..200 {
        let left = std::fs::read_dir(folder.path()).unwrap().count();
        if left == usize::from(!given_up) {
            return;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("something is left");
}
