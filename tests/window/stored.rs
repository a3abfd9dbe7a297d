//! States that are looked at and gone on from. Stored ones: scrubbed through; the strip; undo with the
//! surface; the path as a film. And those that the live loop foresees.

use super::bench::coarse;
use super::hand::{Hand, Window, folder, foretold, opened};
use egui::{Key, Pos2, pos2};
use egui_kittest::kittest::Queryable;
use ndarray::Array2;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use tackscope::follow::record::{Direction, StateRecord};
use tackscope::physics::pattern::Pattern;
use tackscope::solver::Stop;
use tackscope::ui::view_state::{Origin, RunView, Selection, Span, spans};

/// A state, and its gap as it was seen.
pub type Seen = (StateRecord, Arc<Array2<f64>>);

/// The window after a loop of a coarse Fig. 2, and every picture that was seen of it at rest.
pub fn looped() -> (Window, Vec<Seen>) {
    let mut window = opened(coarse(48));
    window.get_by_label("Play loop").click();
    window.step();
    let mut seen = Vec::new();
    let mut frames = 0;
    while run(&window).is_busy() {
        window.step();
        let frame = window.view().frame.clone().expect("a picture");
        if let Some(state) = &frame.state {
            seen.push((state.clone(), frame.gap.clone()));
        }
        frames += 1;
        assert!(frames < 2000, "it never comes to rest");
    }
    window.run();
    (window, seen)
}

pub fn run(window: &Window) -> &RunView {
    &window.view().run
}

/// The state that is looked at.
pub fn chosen(window: &Window) -> Selection {
    run(window).selection.clone().expect("a state")
}

/// The newest state.
pub fn now(window: &Window) -> StateRecord {
    run(window).state.clone().expect("a state")
}

/// What map and profile show.
pub fn shown(window: &Window) -> Arc<Array2<f64>> {
    let frame = window.view().pictured();
    frame.expect("a picture").gap.clone()
}

/// The largest difference, in shares of the largest gap.
pub fn apart(a: &Array2<f64>, b: &Array2<f64>) -> f64 {
    let largest = a.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let off = (a - b).iter().fold(0.0f64, |m, x| m.max(x.abs()));
    off / largest
}

/// The accessible name and the place of the strip.
pub fn strip(window: &Window) -> (String, egui::Rect) {
    let words = "Patterns walked:";
    (window.name(words), window.place(words))
}

#[test]
fn a_press_on_the_strip_shows_that_very_state_and_escape_the_present() {
    let (mut window, seen) = looped();
    let (low, high) = window.view().limits;
    let present = shown(&window);
    for (direction, row) in [(Direction::Approach, 0.25), (Direction::Retraction, 0.75)] {
        for share in [0.15, 0.3, 0.5, 0.6, 0.8] {
            let (_, place) = strip(&window);
            let at = pos2(
                place.left() + share * place.width(),
                place.top() + row * place.height(),
            );
            window.click_at(at);
            let selection = chosen(&window);
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
            window.says("Gap map: stored");
        }
    }
    window.tap(Key::Escape);
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
        let state = chosen(&window).state;
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
    let found = spans(record);
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
    assert!(found.iter().all(|s: &Span| s.ends[0] != s.ends[1]));
}

#[test]
fn go_on_from_here_forks_the_path_and_keeps_the_way_to_that_state() {
    let (mut window, _) = looped();
    let before = run(&window).record.clone();
    // After the second jump.
    window.tap(Key::J);
    window.tap(Key::J);
    let chosen = chosen(&window);
    let gap = shown(&window);
    window.go_on();
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
    assert_eq!(window.view().plots.ghosts.len(), 1);
    // It goes on as it went.
    window.play("Play approach");
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
        let chosen = chosen(&window);
        seen.push((chosen.state, shown(&window)));
    }
    for key in [Key::J, Key::J, Key::G] {
        window.key_press(key);
        window.step();
        window.run();
    }
    let reached = run(&window).record.states.len();
    let plot = window.place("Stress against u0:");
    // Up a line through what was walked after the fork.
    let x = plot.left() + 0.45 * plot.width();
    let state = |s: &StateRecord| (s.direction, s.control, s.energy);
    let chosen = (0..90).find_map(|k| {
        window.click_at(pos2(x, plot.bottom() - 40.0 - 4.0 * k as f32));
        run(&window).selection.clone()
    });
    let chosen = chosen.expect("the grey line is met");
    assert!(matches!(chosen.of, Origin::Left(_)), "{chosen:?}");
    let this = seen.iter().find(|(s, _)| state(s) == state(&chosen.state));
    let (_, gap) = this.expect("a state that was walked");
    assert!(chosen.state.control < run(&window).actual);
    assert!(apart(gap, &shown(&window)) < 1e-6);
    assert_eq!(run(&window).record.states.len(), reached);
    window.go_on();
    let now = now(&window);
    assert_eq!(state(&now), state(&chosen.state));
    assert!(apart(gap, &shown(&window)) < 1e-6);
}

#[test]
fn an_undo_brings_the_surface_back_where_it_was() {
    let (mut window, _) = looped();
    window.tap(Key::J);
    window.tap(Key::J);
    window.go_on();
    let (gap, state) = (shown(&window), now(&window));
    window.hit("law cosine");
    for _ in 0..200 {
        window.step();
    }
    assert!(apart(&gap, &shown(&window)) > 1e-3);
    window.undo();
    let now = now(&window);
    assert_eq!(
        (now.pattern, now.control, now.energy, now.direction),
        (state.pattern, state.control, state.energy, state.direction)
    );
    assert!(apart(&gap, &shown(&window)) < 1e-6);
    assert!(!run(&window).is_busy());
}

/// Asks the palette for a film of this kind at this path.
fn ask(window: &mut Window, kind: &str, path: &Path) {
    window.act(&format!("film {kind}"));
    window.write_over(&path.display().to_string());
    window.get_by_label("Write").click();
    window.step();
}

/// Waits until it is said what became of it.
fn said(window: &mut Window) -> String {
    for _ in 0..2000 {
        window.step();
        if let Some(notice) = &window.view().messages.notice {
            return notice.clone();
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("{:?}", window.view().messages);
}

#[test]
fn the_stored_states_become_a_film_with_one_picture_each() {
    let folder = folder();
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
    let folder = folder();
    let mut window = at_rest();
    window.play("Play loop");
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

/// The window at rest at the start of a coarse Fig. 2, with its live loop.
pub fn at_rest() -> Window {
    let mut window = foretold(coarse(48));
    window.step();
    window.run();
    assert!(window.view().live().is_some());
    window
}

/// Where a control lies on a row of the strip.
fn on_strip(window: &Window, control: f64, direction: Direction) -> Pos2 {
    let (low, high) = window.view().limits;
    let (_, place) = strip(window);
    let share = ((control - low) / (high - low)) as f32;
    let row = if direction == Direction::Approach {
        0.25
    } else {
        0.75
    };
    pos2(
        place.left() + share * place.width(),
        place.top() + row * place.height(),
    )
}

/// The accessible sentence of the map.
fn map_sentence(window: &Window) -> String {
    window.name("Gap map:")
}

#[test]
fn a_press_on_what_the_strip_foresees_shows_that_state_and_escape_the_present() {
    let mut window = at_rest();
    let present = shown(&window);
    for (control, direction, pattern) in [
        (3.0, Direction::Approach, Pattern::Bulge),
        (2.0, Direction::Approach, Pattern::Ridge),
        (2.0, Direction::Retraction, Pattern::Dimple),
        (3.0, Direction::Retraction, Pattern::Ridge),
    ] {
        let at = on_strip(&window, control, direction);
        window.click_at(at);
        let selection = chosen(&window);
        let state = &selection.state;
        assert_eq!(selection.of, Origin::Foreseen, "nobody was there");
        assert_eq!((state.pattern, state.direction), (pattern, direction));
        assert_eq!(state.stop, Stop::Stable);
        assert!((state.control - control).abs() < 0.02, "{state:?}");
        let mean = shown(&window).mean().expect("points");
        assert!((mean - state.mean_displacement).abs() < 1e-6, "{mean}");
        let words = map_sentence(&window);
        assert!(words.contains(&format!("foreseen {pattern}")), "{words}");
    }
    window.tap(Key::Escape);
    assert!(run(&window).selection.is_none());
    assert_eq!(shown(&window), present);
    assert!(!run(&window).is_busy() && run(&window).record.states.len() == 1);
}

#[test]
fn go_on_from_here_puts_the_surface_into_a_foreseen_state_and_it_goes_on_from_there() {
    let mut window = at_rest();
    let at = on_strip(&window, 2.0, Direction::Retraction);
    window.click_at(at);
    let chosen = chosen(&window).state;
    let gap = shown(&window);
    window.go_on();
    let after = run(&window);
    let now = after.state.clone().expect("a state");
    assert_eq!(
        (now.pattern, now.control, now.direction, now.energy),
        (
            chosen.pattern,
            chosen.control,
            chosen.direction,
            chosen.energy
        )
    );
    assert!(after.selection.is_none() && !after.is_busy());
    assert_eq!(after.record.states.len(), 1, "nothing leads there");
    assert!(apart(&gap, &shown(&window)) < 1e-6);
    // Pulled off from there, it takes the jumps that the live loop foresees.
    let live = window.view().live().expect("a loop").clone();
    let ahead = live
        .jumps
        .iter()
        .filter(|jump| jump.direction == Direction::Retraction && jump.control > now.control);
    let ahead: Vec<_> = ahead.map(|jump| (jump.from, jump.to)).collect();
    window.play("Play retract");
    let jumps = run(&window).record.jumps.iter();
    assert_eq!(
        jumps.map(|jump| (jump.from, jump.to)).collect::<Vec<_>>(),
        ahead
    );
    assert!(ahead.len() >= 3, "{ahead:?}");
}

#[test]
fn an_undo_brings_back_a_surface_that_was_put_into_a_foreseen_state() {
    let mut window = at_rest();
    let at = on_strip(&window, 2.0, Direction::Approach);
    window.click_at(at);
    window.go_on();
    let before = now(&window);
    window.get_by_label("law cosine").click();
    window.run_steps(200);
    window.undo();
    let now = now(&window);
    assert_eq!((now.pattern, now.energy), (before.pattern, before.energy));
}

#[test]
fn a_click_on_the_live_loop_in_the_plot_shows_that_state_and_a_drag_goes_along_it() {
    let mut window = at_rest();
    let place = window.place("Stress against u0:");
    // Up a line through the ridges, away from the jumps, where nothing was walked.
    let x = place.left() + 0.62 * place.width();
    let found = (0..60).find_map(|k| {
        let at = pos2(x, place.bottom() - 40.0 - 6.0 * k as f32);
        window.click_at(at);
        run(&window).selection.is_some().then_some(at)
    });
    let at = found.expect("the live loop is met");
    let first = chosen(&window);
    assert_eq!(
        (first.of, first.state.stop),
        (Origin::Foreseen, Stop::Stable)
    );
    window.hover_at(at);
    window.step();
    window.drag_at(at);
    window.step();
    let mut seen = Vec::new();
    for k in 1..12 {
        window.hover_at(at + egui::vec2(8.0 * k as f32, 0.0));
        window.step();
        window.step();
        window.step();
        seen.extend(run(&window).selection.as_ref().map(|s| s.state.control));
    }
    window.drop_at(at + egui::vec2(96.0, 0.0));
    window.run();
    seen.dedup();
    assert!(
        seen.len() >= 8 && seen[seen.len() - 1] > first.state.control,
        "{seen:?}"
    );
    assert!(
        run(&window)
            .selection
            .as_ref()
            .is_some_and(|s| s.of == Origin::Foreseen)
    );
}
