//! The first minute: the body as its own handle, what one is told to do, and why it snapped; and the
//! surface pressed by hand, with Alt and a drag on the map.

use super::bench::{Bench, coarse};
use super::hand::{Hand, Window, opened};
use super::stored::{apart, at_rest, looped, now, run, shown};
use super::tabs::surveyed;
use egui::{Event as Input, Key, Modifiers, Pos2, Vec2, ViewportId, vec2};
use egui_kittest::kittest::Queryable;
use ndarray::Array2;
use std::sync::Arc;
use std::time::Duration;
use tackscope::follow::record::{Cause, Direction};
use tackscope::physics::pattern::Pattern;
use tackscope::physics::theory::flat_limits;
use tackscope::scene::Turn;
use tackscope::ui::action::ProfileLine;
use tackscope::ui::view_state::Hint;
use tackscope::worker::protocol::{Command, Event, Film, Frame, Play};

/// The window after the first jump of a coarse Fig. 2, at rest.
fn snapped() -> Window {
    let mut scene = coarse(32);
    scene.drive.turn = Turn::At(3.05);
    let mut window = opened(scene);
    window.play("Play approach");
    assert_eq!(window.view().run.record.jumps.len(), 1);
    window.run();
    window
}

#[test]
fn before_any_jump_the_tab_says_what_can_happen_in_this_scene() {
    let mut bench = Bench::new();
    bench.down(4.0);
    let (_, upper) = flat_limits(&bench.model.law, bench.model.grid.length).unwrap();
    let words = format!("It snaps at u₀ = {upper:.4} ρ on the way down");
    bench.says(&words);
    bench.tap(Key::Num3);
    bench.down(4.0);
    let names = bench.names();
    bench.lacks(&words);
    bench.says("Here nothing snaps. Make the cell longer. The cell has");
    let hints = names
        .lines()
        .filter(|line| *line == "Here nothing snaps. Make the cell longer.");
    assert_eq!(hints.count(), 1, "{names}");
}

#[test]
fn the_sentence_why_stands_there_after_a_jump_without_another_gesture() {
    let window = snapped();
    let jump = window.view().run.record.jumps[0].clone();
    for words in [
        "the pull grows faster with depth than the longest wave of the cell can resist",
        "Gap before the jump: flat",
        "waves to the cell: orange is lifted, purple lowered",
        &format!("Gap after the jump: {}", jump.to),
        &format!("{:.4} gamma released so far", jump.released_energy),
    ] {
        window.says(words);
    }
}

#[test]
fn of_every_jump_the_whole_sentence_why_is_seen_at_once_and_the_maps_with_it_or_below() {
    let (mut window, _) = looped();
    let maps = ["Gap before the jump:", "Soft mode,", "Gap after the jump:"];
    // In the least window the maps are scrolled to.
    for (size, bar, scrolls) in [
        ([900.0, 600.0], 566.0, false),
        ([640.0, 480.0], 446.0, true),
    ] {
        window.set_size(vec2(size[0], size[1]));
        window.run();
        let jumps = window.view().run.record.jumps.clone();
        assert_eq!(jumps.len(), 8);
        for jump in jumps.iter().rev() {
            window.tap(Key::K);
            let seen = |window: &Window, words: &str| {
                let rect = window.place(words);
                let inside = rect.top() > 200.0 && rect.bottom() < bar;
                assert!(inside, "{words} of {jump:?}: {rect:?} at {size:?}");
            };
            let sentence = if jump.cause == Cause::FlatLimit {
                ", in E*/L)"
            } else {
                " (E*/L)."
            };
            seen(&window, sentence);
            for map in maps {
                if scrolls {
                    window.get_by_label_contains(map).scroll_to_me();
                    window.run();
                }
                seen(&window, map);
            }
        }
        window.tap(Key::Escape);
    }
}

fn film(window: &Window) -> Arc<Film> {
    let films = &window.view().run.films;
    films.of(0).cloned().expect("a film")
}

#[test]
fn a_jump_is_replayed_by_hand_in_map_and_plot_until_the_surface_moves() {
    let mut window = snapped();
    let state = |window: &Window| window.view().run.replayed.clone();
    assert!(state(&window).is_none());
    let film = film(&window);
    assert!(film.moving.len() > 3, "{}", film.moving.len());
    window.hit("Moment of the jump");
    let shown = state(&window).expect("a moment");
    assert!(film.moving.iter().any(|frame| Arc::ptr_eq(frame, &shown)));
    window.hit("Close the replay");
    assert!(state(&window).is_none());
    window.hit("Moment of the jump");
    assert!(state(&window).is_some());
    window.get_by_label("Play retract").click();
    window.step();
    window.step();
    assert!(state(&window).is_none(), "the surface has moved on");
}

#[test]
fn a_replay_played_goes_from_before_to_after_and_then_nothing_is_drawn_again() {
    let mut window = snapped();
    let film = film(&window);
    window.get_by_label("Replay the jump").click();
    window.step();
    let mut seen: Vec<Arc<Frame>> = Vec::new();
    for _ in 0..600 {
        window.step();
        let shown = window.view().run.replayed.clone().expect("a moment");
        if seen.last().is_none_or(|last| !Arc::ptr_eq(last, &shown)) {
            seen.push(shown);
        }
    }
    assert_eq!(seen.len(), film.count());
    for (shown, frame) in seen.iter().zip(film.frames()) {
        assert!(Arc::ptr_eq(shown, frame));
    }
    assert!(repaint(&window) > Duration::from_secs(1));
}

#[test]
fn the_tab_leads_to_the_stiffness_and_to_the_other_states() {
    let mut bench = Bench::new();
    bench.down(3.2);
    bench.jump(3.102);
    bench.click("Show the stiffness");
    bench.says("Smallest eigenvalue against u0");
    bench.click("Why tab");
    bench.click("What could it do instead?");
    bench.says("Every state of equilibrium");
}

#[test]
fn the_jump_that_is_looked_at_is_the_one_that_is_explained() {
    let mut bench = Bench::new();
    for u0 in [3.102, 2.9] {
        bench.down(u0 + 0.01);
        bench.jump(u0);
        bench.down(u0);
    }
    bench.says("Below 2.900 ranges");
    bench.tap(Key::J);
    bench.says("Below 3.102 ranges");
    bench.lacks("Below 2.900");
}

#[test]
fn the_present_point_goes_down_the_drop_while_it_jumps() {
    let mut bench = Bench::new();
    bench.down(3.12);
    let top = bench.model.law.traction_max();
    for share in [0.3, 0.5] {
        let gap = Arc::new(Array2::from_elem(bench.model.grid.shape(), 3.1));
        bench.say(Event::Frame(Arc::new(Frame {
            relaxing: true,
            ..Frame::of_a_branch(3.1, [3.1, share * top], gap)
        })));
        let words = format!("jumping at u0 3.100 rho, stress {share:.3} sigma_max");
        assert!(
            bench.plot_sentence().contains(&words),
            "{}",
            bench.plot_sentence()
        );
        bench.says("Jumping, no equilibrium, u₀ = 3.1000 ρ");
    }
}

/// How long until the window wants to be drawn again.
fn repaint(window: &Window) -> Duration {
    window.output().viewport_output[&ViewportId::ROOT].repaint_delay
}

#[test]
fn the_grip_pulses_until_first_used_and_then_nothing_is_drawn_while_nothing_changes() {
    let mut bench = Bench::new();
    bench.down(4.2);
    assert!(repaint(&bench) < Duration::from_secs(1));
    let body = profile(&bench);
    bench.drag(&body, &[vec2(0.0, 4.0)]);
    assert_eq!(bench.view().messages.hint, Some(Hint::Lower));
    bench.settle();
    assert!(
        repaint(&bench) > Duration::from_secs(1),
        "{:?}",
        repaint(&bench)
    );
}

/// The accessible name of the profile, which is the handle of the body.
fn profile(bench: &Bench) -> String {
    let names = bench.names();
    let found = names.lines().find(|line| line.starts_with("Profile along"));
    found.expect("a profile").to_owned()
}

#[test]
fn the_profile_says_where_the_surfaces_pull_and_where_they_push() {
    let mut bench = Bench::new();
    for (u0, force) in [(2.0, "pulls"), (-0.2, "pushes")] {
        bench.down(u0);
        let traction = bench.model.law.at(u0).traction / bench.model.law.traction_max();
        let at = bench.place("Profile along");
        bench.hover_at(at.left_center() + egui::vec2(30.0, 0.0));
        bench.run_steps(6);
        let words = format!("{force} {:.3} σₘₐₓ", traction.abs());
        bench.says(&words);
    }
}

#[test]
fn the_elastomer_is_dragged_and_its_surface_keeps_to_the_hand() {
    let mut bench = Bench::new();
    bench.down(4.0);
    let body = profile(&bench);
    let height = f64::from(bench.place_of(&body).height());
    bench.heard();
    let start = bench.view().target;
    bench.drag(&body, &[vec2(0.0, 5.0), vec2(0.0, 15.0), vec2(0.0, 10.0)]);
    let targets = bench.targets();
    assert_eq!(targets.len(), 3, "{targets:?}");
    // The axis shows 1.44 of the largest gap of the colours, 8 ranges.
    let per_point = 1.44 * 8.0 / height;
    for (target, points) in targets.iter().zip([5.0, 15.0, 10.0]) {
        let wanted = start - points * per_point;
        assert!((target - wanted).abs() < 1e-4, "{target} {wanted}");
    }
}

#[test]
fn the_map_is_dragged_like_the_body_and_the_profile_line_by_its_grip() {
    let mut bench = Bench::new();
    bench.down(3.9);
    bench.heard();
    let label = "Gap map: flat, gap from 3.900 to 3.900 rho";
    bench.drag(label, &[vec2(0.0, 10.0), vec2(0.0, 60.0)]);
    let targets = bench.targets();
    assert!(targets.len() == 2 && targets[1] < targets[0], "{targets:?}");
    assert_eq!(bench.view().view.profile, ProfileLine::Auto);
    bench.drag("Profile line", &[vec2(0.0, 10.0), vec2(0.0, 60.0)]);
    assert!(bench.targets().is_empty());
    let line = bench.view().view.profile;
    assert!(
        matches!(line, ProfileLine::AlongX(y) if y < 0.45),
        "{line:?}"
    );
}

#[test]
fn the_hint_goes_on_to_pulling_off_and_to_what_was_lost_and_is_then_gone() {
    let mut bench = Bench::new();
    bench.down(4.0);
    let hint = |bench: &Bench| {
        let names = bench.names();
        let all = [
            "Drag down slowly. Something will snap.",
            "Now pull it off again.",
            "The jumps add up to what was lost.",
        ];
        all.iter().position(|words| names.contains(words))
    };
    assert_eq!(hint(&bench), Some(0));
    bench.jump(3.102);
    bench.down(3.1);
    assert_eq!(hint(&bench), Some(1));
    bench.up(3.5);
    assert_eq!(hint(&bench), Some(1));
    bench.jump_on(Direction::Retraction, 3.9);
    bench.up(3.9);
    assert_eq!(hint(&bench), Some(2));
    bench.down(3.8);
    assert_eq!(hint(&bench), None);
}

#[test]
fn the_hint_covers_no_word_and_moves_nothing() {
    for (width, height) in [(1280.0, 800.0), (900.0, 600.0), (760.0, 480.0)] {
        let mut bench = Bench::sized(width, height);
        bench.down(4.0);
        let place = |bench: &Bench, label: &str| bench.place_of(label);
        let fixed = ["Play loop", "Profile line", "Why tab", "Fit"];
        let before = fixed.map(|label| place(&bench, label));
        let bubble = place(&bench, "Drag down slowly. Something will snap.");
        let profile = place(&bench, &profile(&bench));
        assert!(profile.contains_rect(bubble), "{bubble:?} in {profile:?}");
        bench.down(0.2);
        bench.lacks("Something will snap.");
        assert_eq!(fixed.map(|label| place(&bench, label)), before);
    }
}

#[test]
fn the_equations_have_the_numbers_of_the_scene() {
    let mut bench = Bench::new();
    bench.down(4.0);
    bench.click("Equations tab");
    let (lower, upper) = flat_limits(&bench.model.law, bench.model.grid.length).unwrap();
    // As it is typeset: indices are runs of their own on the line.
    for words in [
        "V/A = ∑q≠0 (q E*/4) |u\u{303}q|2 + ⟨γ(g)⟩",
        "γ(g) = γ0 (e−2g/ρ − 2 e−g/ρ)",
        "γ″(u0) + π E*/L = 0",
        &format!("at u0 = {upper:.4} ρ on approach, {lower:.4} ρ on retraction"),
        "u0 = 4.0000 ρ",
    ] {
        bench.says(words);
    }
}

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
    window.event(Input::ModifiersChanged(Modifiers::ALT));
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
    window.event(Input::ModifiersChanged(Modifiers::NONE));
    window.run_steps(200);
}

fn words(window: &Window) -> String {
    window.view().push_in_words().expect("a push")
}

#[test]
fn a_small_push_is_pictured_has_an_energy_and_goes_back() {
    let mut window = driven(2.0);
    let (before, gap) = (now(&window), shown(&window));
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
    let after = now(&window);
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
    let before = now(&window);
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
    window.undo();
    let now = now(&window);
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
    window.event(Input::ModifiersChanged(Modifiers::NONE));
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
    let pressed = |command: &Command| {
        matches!(
            command,
            Command::Play {
                play: Play::Pressed(_),
                ..
            }
        )
    };
    assert!(heard.iter().any(pressed), "{heard:?}");
    let gamma = bench.model.law.surface_energy;
    bench.say(Event::Pressed {
        energy: 2e-3 * gamma,
    });
    let barrier = found.passes[0].barrier() / gamma;
    let words = bench.view().push_in_words().expect("a push");
    let wanted = format!("2.00e-3 γL²; the lowest barrier is {barrier:.2e} γL²");
    assert!(words.contains(&wanted), "{words}");
}

#[test]
fn nothing_is_moved_out_of_its_place_when_alt_is_held_in_a_small_window() {
    let mut bench = Bench::sized(900.0, 600.0);
    bench.down(3.5);
    let place = |bench: &Bench| bench.place("Gap map:");
    let before = place(&bench);
    bench.hover_at(before.center());
    bench.event(Input::ModifiersChanged(Modifiers::ALT));
    bench.run_steps(4);
    assert!(bench.query_by_label("Width of the push").is_some());
    assert_eq!(place(&bench), before);
}
