//! Gestures at random on the window with a real session, over all presets: nothing panics, what is
//! said to be stable is, sums are sums, and undoing everything ends where it began.
//!
//! The suite makes some hundred gestures; TACKSCOPE_GESTURES asks for more.

use super::bench::fig2;
use super::hand::{Hand, Window};
use super::stepped::opened;
use egui::{Event, Key, Modifiers, pos2};
use egui_kittest::kittest::{NodeT, Queryable};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use std::cell::Cell;
use tackscope::scene::units::fixed;
use tackscope::solver::Stop;
use tackscope::storage::presets;

/// Gestures of the suite, and in one window.
const USUAL: u32 = 240;
const LONGEST: usize = 24;

#[derive(Clone, Debug)]
enum Gesture {
    Key(Key),
    Command(Key),
    /// Click what has this name, if it is there.
    Click(&'static str),
    /// Press, drag and let go, in shares of the window.
    Drag([f32; 2], [f32; 2]),
    /// Choose a preset.
    Preset(usize),
    /// Type into the palette, and run what is found.
    Type(&'static str),
    /// Let the solver work for so many frames.
    Wait(usize),
}

fn gesture() -> impl Strategy<Value = Gesture> {
    use Gesture as G;
    let keys = [
        Key::ArrowLeft,
        Key::ArrowUp,
        Key::PageDown,
        Key::PageUp,
        Key::Home,
        Key::End,
        Key::Space,
        Key::Period,
        Key::R,
        Key::L,
        Key::J,
        Key::K,
        Key::G,
        Key::OpenBracket,
        Key::CloseBracket,
        Key::Escape,
        Key::F11,
        Key::F1,
        Key::Tab,
        Key::Enter,
    ];
    let names = [
        "Play approach",
        "Play retract",
        "Play loop",
        "Stop",
        "Reset",
        "law morse",
        "law mie",
        "law cosine",
        "machine spring",
        "machine weight",
        "machine stiff",
        "ground flat",
        "ground waves",
        "Events tab",
        "Stability tab",
        "Why tab",
        "Branches tab",
        "Map options",
        "Menu",
        "Files",
        "Preset",
        "Fit",
        "Replay the jump",
        "Refine",
        "Advanced",
    ];
    let words = [
        "2.5",
        "0.4",
        "method l-bfgs",
        "model quarter",
        "speed as fast",
        "restore",
    ];
    let place = || [0.0f32..1.0, 0.0f32..1.0];
    prop_oneof![
        4 => prop::sample::select(keys.to_vec()).prop_map(G::Key),
        2 => prop::sample::select(vec![Key::Z, Key::Y, Key::K]).prop_map(G::Command),
        4 => prop::sample::select(names.to_vec()).prop_map(G::Click),
        3 => (place(), place()).prop_map(|(from, to)| G::Drag(from, to)),
        1 => (0..presets::all().len()).prop_map(G::Preset),
        1 => prop::sample::select(words.to_vec()).prop_map(G::Type),
        3 => (1usize..12).prop_map(G::Wait),
    ]
}

fn make(window: &mut Window, gesture: &Gesture) {
    let key = |window: &mut Window, modifiers, key| {
        window.key_press_modifiers(modifiers, key);
        window.step();
    };
    match gesture {
        Gesture::Key(pressed) => key(window, Modifiers::NONE, *pressed),
        Gesture::Command(pressed) => key(window, Modifiers::COMMAND, *pressed),
        Gesture::Click(name) => {
            if let Some(node) = window.query_all_by_label(name).next() {
                node.click();
            }
            window.step();
        }
        Gesture::Drag(from, to) => {
            let screen = window.ctx.content_rect();
            let at = |[x, y]: [f32; 2]| pos2(x * screen.width(), y * screen.height());
            window.hover_at(at(*from));
            window.drag_at(at(*from));
            window.step();
            window.hover_at(at(*to));
            window.step();
            window.drop_at(at(*to));
            window.step();
        }
        Gesture::Preset(index) => {
            key(window, Modifiers::COMMAND, Key::K);
            let words = format!("preset {}", presets::all()[*index].name);
            window.event(Event::Text(words));
            window.step();
            key(window, Modifiers::NONE, Key::Enter);
        }
        Gesture::Type(words) => {
            key(window, Modifiers::COMMAND, Key::K);
            window.event(Event::Text((*words).to_owned()));
            window.step();
            key(window, Modifiers::NONE, Key::Enter);
        }
        Gesture::Wait(frames) => window.run_steps(*frames),
    }
}

/// The first words in which a zero has a sign.
pub fn signed_zero(window: &Window) -> Option<String> {
    let signed = |word: &str| {
        let unsigned = word.strip_prefix(['-', '−']);
        unsigned.is_some_and(|digits| digits.parse() == Ok(0.0))
    };
    let nodes = window.root().children_recursive();
    let mut words = nodes.filter_map(|node| node.value().or(node.accesskit_node().label()));
    words.find(|words| words.split_whitespace().any(signed))
}

/// What holds at every moment.
fn check(window: &Window) -> Result<(), TestCaseError> {
    let state = window.view();
    if let Some(now) = state
        .run
        .state
        .as_ref()
        .filter(|now| now.stop == Stop::Stable)
    {
        prop_assert!(now.stiffness_min > 0.0, "stable is said of {now:?}");
    }
    let (low, high) = state.limits;
    prop_assert!(
        (low..=high).contains(&state.target),
        "{} {:?}",
        state.target,
        state.limits
    );
    let zero = signed_zero(window);
    prop_assert!(zero.is_none(), "a zero has no sign: {zero:?}");
    let jumps = &state.run.record.jumps;
    let sum: f64 = jumps.iter().map(|jump| jump.released_energy).sum();
    let told = state.run.record.released_energy_sum();
    prop_assert!(
        (sum - told).abs() <= 1e-12 * sum.abs().max(1.0),
        "{sum} {told}"
    );
    // Before a loop is closed or foreseen the headline is the sum so far, to the digit.
    let natural = state.scene.units.is_none();
    if natural
        && window
            .query_all_by_label_contains("lost so far")
            .next()
            .is_some()
    {
        let words = format!("{} γ lost so far", fixed(told, 4));
        let same = window.query_all_by_label_contains(&words).next().is_some();
        prop_assert!(same, "{words} is not what the headline says");
    }
    Ok(())
}

#[test]
fn random_gestures_break_nothing_and_are_all_taken_back() {
    let asked = std::env::var("TACKSCOPE_GESTURES").ok();
    let gestures: u32 = asked.and_then(|text| text.parse().ok()).unwrap_or(USUAL);
    let config = Config {
        cases: (gestures / (LONGEST as u32 / 2)).max(1),
        max_shrink_iters: 40,
        failure_persistence: None,
        ..Config::default()
    };
    let strategy = prop::collection::vec(gesture(), 1..LONGEST);
    let made = Cell::new(0);
    let outcome = TestRunner::new(config).run(&strategy, |gestures| {
        let mut window = opened(fig2());
        for gesture in &gestures {
            make(&mut window, gesture);
            // What was asked for is drawn in the frame after.
            window.step();
            check(&window)?;
            made.set(made.get() + 1);
        }
        // Whatever is open closes, and everything is taken back.
        for _ in 0..4 {
            window.key_press(Key::Escape);
            window.step();
        }
        for _ in 0..LONGEST + 4 {
            window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
            window.step();
        }
        let state = window.view();
        prop_assert_eq!(&*state.scene, &fig2());
        prop_assert_eq!(state.method, Default::default());
        prop_assert_eq!(state.asked, None);
        Ok(())
    });
    println!("{} gestures", made.get());
    outcome.unwrap();
}
