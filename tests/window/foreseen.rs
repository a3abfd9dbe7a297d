//! States that the live loop foresees: looked at, and gone on from.

use super::bench::fig2;
use super::stepped::foretold;
use super::stored::{apart, press_at, run, shown, strip};
use egui::{Key, Modifiers, Pos2, pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use tackscope::follow::record::Direction;
use tackscope::physics::pattern::Pattern;
use tackscope::scene::Points;
use tackscope::solver::Stop;
use tackscope::ui::App;
use tackscope::ui::view_state::Origin;

/// The window at rest at the start of a coarse Fig. 2, with its live loop.
pub fn at_rest() -> Harness<'static, App> {
    let mut scene = fig2();
    scene.cell.points = Points::Square(48);
    let mut window = foretold(scene);
    window.step();
    window.run();
    assert!(window.state().state().live().is_some());
    window
}

/// Where a control lies on a row of the strip.
fn on_strip(window: &Harness<'static, App>, control: f64, direction: Direction) -> Pos2 {
    let (low, high) = window.state().state().limits;
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
fn map_sentence(window: &Harness<'static, App>) -> String {
    let node = window.get_by_label_contains("Gap map:");
    node.accesskit_node().label().expect("a name").clone()
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
        press_at(&mut window, at);
        let selection = run(&window).selection.clone().expect("a state");
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
    window.key_press(Key::Escape);
    window.run();
    assert!(run(&window).selection.is_none());
    assert_eq!(shown(&window), present);
    assert!(!run(&window).is_busy() && run(&window).record.states.len() == 1);
}

#[test]
fn go_on_from_here_puts_the_surface_into_a_foreseen_state_and_it_goes_on_from_there() {
    let mut window = at_rest();
    let at = on_strip(&window, 2.0, Direction::Retraction);
    press_at(&mut window, at);
    let chosen = run(&window).selection.clone().expect("a state").state;
    let gap = shown(&window);
    window.key_press(Key::G);
    window.step();
    window.run();
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
    let live = window.state().state().live().expect("a loop").clone();
    let ahead = live
        .jumps
        .iter()
        .filter(|jump| jump.direction == Direction::Retraction && jump.control > now.control);
    let ahead: Vec<_> = ahead.map(|jump| (jump.from, jump.to)).collect();
    window.get_by_label("Play retract").click();
    window.step();
    while run(&window).is_busy() {
        window.step();
    }
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
    press_at(&mut window, at);
    window.key_press(Key::G);
    window.step();
    window.run();
    let before = run(&window).state.clone().expect("a state");
    window.get_by_label("law cosine").click();
    for _ in 0..200 {
        window.step();
    }
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    for _ in 0..20 {
        window.step();
    }
    let now = run(&window).state.clone().expect("a state");
    assert_eq!((now.pattern, now.energy), (before.pattern, before.energy));
}

#[test]
fn a_click_on_the_live_loop_in_the_plot_shows_that_state_and_a_drag_goes_along_it() {
    let mut window = at_rest();
    let place = window.get_by_label_contains("Stress against u0:").rect();
    // Up a line through the ridges, away from the jumps, where nothing was walked.
    let x = place.left() + 0.62 * place.width();
    let found = (0..60).find_map(|k| {
        let at = pos2(x, place.bottom() - 40.0 - 6.0 * k as f32);
        press_at(&mut window, at);
        run(&window).selection.is_some().then_some(at)
    });
    let at = found.expect("the live loop is met");
    let first = run(&window).selection.clone().expect("a state");
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
