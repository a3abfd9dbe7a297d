//! The first minute: the body as its own handle, what one is told to do, and why it snapped.

use super::bench::{Bench, coarse};
use super::hand::{Hand, Window};
use super::stepped::opened;
use super::stored::looped;
use egui::{Key, ViewportId, vec2};
use egui_kittest::kittest::Queryable;
use ndarray::Array2;
use std::sync::Arc;
use std::time::Duration;
use tackscope::follow::record::{Cause, Direction};
use tackscope::physics::theory::flat;
use tackscope::scene::Turn;
use tackscope::ui::action::ProfileLine;
use tackscope::ui::view_state::Hint;
use tackscope::worker::protocol::{Event, Film, Frame};

/// The window after the first jump of a coarse Fig. 2, at rest.
fn snapped() -> Window {
    let mut scene = coarse(32);
    scene.drive.turn = Turn::At(3.05);
    let mut window = opened(scene);
    window.get_by_label("Play approach").click();
    window.step();
    window.rest();
    assert_eq!(window.view().run.record.jumps.len(), 1);
    window.run();
    window
}

#[test]
fn before_any_jump_the_tab_says_what_can_happen_in_this_scene() {
    let mut bench = Bench::new();
    bench.reach(4.0, Direction::Approach);
    let (_, upper) = flat::limits(&bench.model.law, bench.model.grid.length).unwrap();
    let words = format!("It snaps at u₀ = {upper:.4} ρ on the way down");
    bench.says(&words);
    bench.tap(Key::Num3);
    bench.reach(4.0, Direction::Approach);
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
    bench.reach(3.2, Direction::Approach);
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
        bench.reach(u0 + 0.01, Direction::Approach);
        bench.jump(u0);
        bench.reach(u0, Direction::Approach);
    }
    bench.says("Below 2.900 ranges");
    bench.tap(Key::J);
    bench.says("Below 3.102 ranges");
    bench.lacks("Below 2.900");
}

#[test]
fn the_present_point_goes_down_the_drop_while_it_jumps() {
    let mut bench = Bench::new();
    bench.reach(3.12, Direction::Approach);
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
    bench.reach(4.2, Direction::Approach);
    assert!(repaint(&bench) < Duration::from_secs(1));
    let body = profile(&bench);
    bench.drag(&body, &[vec2(0.0, 4.0)]);
    assert_eq!(bench.state().messages.hint, Some(Hint::Lower));
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
        bench.reach(u0, Direction::Approach);
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
    bench.reach(4.0, Direction::Approach);
    let body = profile(&bench);
    let height = f64::from(bench.place_of(&body).height());
    bench.heard();
    let start = bench.state().target;
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
    bench.reach(3.9, Direction::Approach);
    bench.heard();
    let label = "Gap map: flat, gap from 3.900 to 3.900 rho";
    bench.drag(label, &[vec2(0.0, 10.0), vec2(0.0, 60.0)]);
    let targets = bench.targets();
    assert!(targets.len() == 2 && targets[1] < targets[0], "{targets:?}");
    assert_eq!(bench.state().view.profile, ProfileLine::Auto);
    bench.drag("Profile line", &[vec2(0.0, 10.0), vec2(0.0, 60.0)]);
    assert!(bench.targets().is_empty());
    let line = bench.state().view.profile;
    assert!(
        matches!(line, ProfileLine::AlongX(y) if y < 0.45),
        "{line:?}"
    );
}

#[test]
fn the_hint_goes_on_to_pulling_off_and_to_what_was_lost_and_is_then_gone() {
    let mut bench = Bench::new();
    bench.reach(4.0, Direction::Approach);
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
    bench.reach(3.1, Direction::Approach);
    assert_eq!(hint(&bench), Some(1));
    bench.reach(3.5, Direction::Retraction);
    assert_eq!(hint(&bench), Some(1));
    bench.jump_on(Direction::Retraction, 3.9);
    bench.reach(3.9, Direction::Retraction);
    assert_eq!(hint(&bench), Some(2));
    bench.reach(3.8, Direction::Approach);
    assert_eq!(hint(&bench), None);
}

#[test]
fn the_hint_covers_no_word_and_moves_nothing() {
    for (width, height) in [(1280.0, 800.0), (900.0, 600.0), (760.0, 480.0)] {
        let mut bench = Bench::sized(width, height);
        bench.reach(4.0, Direction::Approach);
        let place = |bench: &Bench, label: &str| bench.place_of(label);
        let fixed = ["Play loop", "Profile line", "Why tab", "Fit"];
        let before = fixed.map(|label| place(&bench, label));
        let bubble = place(&bench, "Drag down slowly. Something will snap.");
        let profile = place(&bench, &profile(&bench));
        assert!(profile.contains_rect(bubble), "{bubble:?} in {profile:?}");
        bench.reach(0.2, Direction::Approach);
        bench.lacks("Something will snap.");
        assert_eq!(fixed.map(|label| place(&bench, label)), before);
    }
}

#[test]
fn the_equations_have_the_numbers_of_the_scene() {
    let mut bench = Bench::new();
    bench.reach(4.0, Direction::Approach);
    bench.click("Equations tab");
    let (lower, upper) = flat::limits(&bench.model.law, bench.model.grid.length).unwrap();
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
