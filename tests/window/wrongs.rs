//! Kinds of things that were wrong once: what belongs to another scene, keys that are lost, values
//! that are refused without a word. And gestures at random on the window with a real session, over all
//! presets: nothing panics, what is said to be stable is, sums are sums, and undoing everything ends
//! where it began. The suite makes some hundred gestures; TACKSCOPE_GESTURES asks for more.

use super::bench::{Bench, coarse, fig2};
use super::hand::{Hand, Window, opened, place_for};
use super::plot::live;
use egui::{Event as Input, Key, Modifiers, PointerButton, pos2};
use egui_kittest::kittest::{NodeT, Queryable};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use std::cell::Cell;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;
use tackscope::follow::record::Direction;
use tackscope::physics::pattern::Pattern;
use tackscope::scene::Range;
use tackscope::scene::parameter::fixed;
use tackscope::solver::Stop;
use tackscope::solver::methods::MethodKind;
use tackscope::storage::{self, scene_file};
use tackscope::ui::view_state::ViewState;
use tackscope::worker::protocol::Event;

#[test]
fn the_method_stays_with_the_scene_that_chose_it_and_is_taken_back() {
    let mut bench = Bench::new();
    bench.click(MethodKind::Lbfgs.title());
    assert_eq!(bench.view().method, MethodKind::Lbfgs);
    bench.tap(Key::Num2);
    assert_eq!(bench.view().method, MethodKind::NewtonKrylov);
    bench.ctrl(Key::Z);
    assert_eq!(bench.view().method, MethodKind::Lbfgs);
    bench.ctrl(Key::Z);
    assert_eq!(bench.view().method, MethodKind::NewtonKrylov);
    assert_eq!(*bench.view().scene, fig2());
}

#[test]
fn states_that_are_no_equilibria_are_drawn_hollow_and_nothing_is_promised_of_them() {
    let mut window = opened(coarse(32));
    window.get_by_label("Advanced").click();
    window.run_steps(3);
    let method = MethodKind::Gfmd;
    window.get_by_label(method.title()).scroll_to_me();
    window.run_steps(3);
    window.get_by_label(method.title()).click();
    window.run_steps(3);
    assert_eq!(window.view().method, method);
    window.play("Play approach");
    window.run();
    let states = &window.view().run.record.states;
    assert!(states.iter().any(|s| s.stop == Stop::NotConverged));
    window.says("○ approach, not converged");
    let bars = ["no equilibrium", "no accuracy is promised"];
    let bar = bars
        .iter()
        .find_map(|words| window.query_by_label_contains(words));
    bar.expect("the bar says so").click();
    window.run();
    window.says("no accuracy is promised");
    for promised in ["expected error", "exact to"] {
        window.lacks(promised);
    }
}

#[test]
fn another_scene_shows_nothing_of_the_last_one_not_for_a_frame() {
    let mut bench = Bench::new();
    bench.down(3.9);
    bench.say(Event::Live(live()));
    bench.jump(3.102);
    bench.down(3.0);
    bench.says("γ a loop");
    bench.key_press(Key::Num3);
    // The frame in which the key is heard ends with the new scene.
    bench.step();
    bench.step();
    let state = bench.view();
    assert!(state.scene.title.starts_with("Below the critical length"));
    assert!(state.frame.is_none() && state.plots.live.is_none() && state.plots.ghosts.is_empty());
    for old in ["3.0000", "γ a loop", "live\n", "0.1234", "flat → ridge"] {
        bench.lacks(old);
    }
    // A live loop of the last scene that comes late.
    bench.say_of(1, Event::Live(live()));
    assert!(bench.view().plots.live.is_none());
}

/// A file as a desktop drops it.
#[derive(Debug)]
struct Dropped(PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        Err("the window reads files by their path".to_owned())
    }
}

#[test]
fn a_scene_dropped_on_the_window_opens() {
    let (_folder, path) = place_for("mine.toml");
    let mut scene = fig2();
    (scene.title, scene.cell.length) = ("Mine".to_owned(), 300.0);
    scene_file::save(&path, &scene).expect("saved");
    let mut bench = Bench::new();
    let files = &mut bench.input_mut().dropped_files;
    files.push(Arc::new(Dropped(path)));
    for _ in 0..500 {
        bench.step();
        if bench.view().scene.title == "Mine" {
            break;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    assert_eq!(*bench.view().scene, scene);
}

#[test]
fn a_digit_pressed_by_mistake_is_taken_back() {
    let mut bench = Bench::new();
    bench.down(3.9);
    bench.tap(Key::Num5);
    assert_ne!(*bench.view().scene, fig2());
    bench.ctrl(Key::Z);
    assert_eq!(*bench.view().scene, fig2());
}

#[test]
fn the_sign_that_opens_the_sheet_does_so_wherever_it_lies_and_is_typed_where_one_types() {
    let mut bench = Bench::new();
    // A layout on which it is neither Shift and slash nor a key of its own.
    bench.write("?");
    bench.says("Keys and marks");
    bench.tap(Key::Escape);
    bench.lacks("Keys and marks");
    bench.ctrl(Key::K);
    bench.write("?");
    bench.lacks("Keys and marks");
}

#[test]
fn letters_typed_while_the_palette_opens_are_not_lost_and_do_nothing_else() {
    let mut bench = Bench::new();
    bench.heard();
    let key = |key, modifiers| Input::Key {
        key,
        physical_key: None,
        pressed: true,
        repeat: false,
        modifiers,
    };
    // All of it before the window draws once.
    let together = [
        key(Key::K, Modifiers::COMMAND),
        key(Key::L, Modifiers::NONE),
        Input::Text("l".to_owned()),
        key(Key::A, Modifiers::NONE),
        Input::Text("a".to_owned()),
    ];
    bench.input_mut().events.extend(together);
    bench.step();
    for letters in ["w", ": c", "os"] {
        bench.event(Input::Text(letters.to_owned()));
    }
    bench.settle();
    bench.says("law: cos\n");
    bench.says("Cohesive law: cosine");
    bench.tap(Key::Enter);
    assert_eq!(bench.view().scene.law.shape.word(), "cosine");
    assert!(bench.view().messages.notice.is_none(), "L keeps no loop");
}

#[test]
fn escape_closes_what_is_on_top_and_only_that() {
    let mut bench = Bench::new();
    bench.click("Play loop");
    bench.click("Files");
    assert!(bench.query_by_label("Copy scene").is_some());
    bench.tap(Key::Escape);
    assert!(bench.query_by_label("Copy scene").is_none());
    assert!(bench.view().run.is_busy(), "the sweep goes on");
    bench.tap(Key::F1);
    bench.tap(Key::Escape);
    assert!(bench.view().run.is_busy());
    bench.lacks("Keys and marks");
    bench.tap(Key::Escape);
    assert!(!bench.view().run.is_busy());
    bench.tap(Key::F11);
    bench.tap(Key::Escape);
    assert!(!bench.view().view.lecture);
}

#[test]
fn a_typed_value_that_is_refused_says_why_at_the_field() {
    let mut bench = Bench::new();
    bench.heard();
    for (field, text, words) in [
        (
            "Target",
            "17",
            "Target = 17: allowed is a number from 0.2 to 4.2 ρ",
        ),
        ("Target", "soon", "Target = soon: no number: allowed is"),
        ("Length L", "-3", "Length L = -3: allowed is a number from"),
        (
            "Seed",
            "1.5",
            "Seed = 1.5: allowed is a whole number from 0",
        ),
    ] {
        bench.enter(field, text);
        assert!(
            bench.names().contains(words),
            "{words} in {}",
            bench.names()
        );
        assert!(bench.heard().is_empty(), "{field} = {text}");
        let field = bench.field(field);
        let below = bench
            .query_all_by_label_contains(words)
            .next()
            .expect("shown");
        assert!(
            field.rect().distance_to_pos(below.rect().center()) < 260.0,
            "{words}"
        );
    }
    bench.enter("Target", "3.5");
    assert!(
        !bench.names().contains("Target = "),
        "what is taken says nothing"
    );
}

#[test]
fn a_field_that_is_left_as_it_stands_rounds_nothing() {
    let mut scene = fig2();
    scene.law.range = Range::Length(1.0 / 3.0);
    let mut bench = Bench::new();
    bench.event(Input::Paste(scene_file::to_text(&scene)));
    bench.settle();
    assert_eq!(*bench.view().scene, scene);
    let field = || egui::Role::SpinButton;
    bench.get_by_role_and_label(field(), "Range ρ").click();
    bench.settle();
    bench.tap(Key::Enter);
    assert_eq!(*bench.view().scene, scene);
}

#[test]
fn up_and_down_move_the_upright_slider() {
    let mut bench = Bench::new();
    let (high, step) = (bench.view().limits.1, bench.view().scene.drive.step);
    for _ in 0..2 {
        bench.tap(Key::ArrowDown);
    }
    bench.tap(Key::ArrowUp);
    assert!((bench.view().target - (high - step)).abs() < 1e-9);
    bench.get_by_label("mean displacement u0").focus();
    bench.settle();
    bench.tap(Key::ArrowDown);
    assert!((bench.view().target - (high - 2.0 * step)).abs() < 1e-9);
}

#[test]
fn from_law_to_law_and_back_ends_where_it_began() {
    let mut bench = Bench::new();
    for way in [
        ["law cosine", "law mie", "law morse"],
        ["law double exponential", "law cosine", "law morse"],
        ["machine spring", "machine weight", "machine stiff"],
        ["ground tip", "ground waves", "ground flat"],
    ] {
        for label in way {
            bench.click(label);
        }
        assert_eq!(*bench.view().scene, fig2(), "{way:?}");
    }
}

#[test]
fn a_double_click_on_the_name_of_a_number_brings_back_what_the_scene_was_opened_with() {
    let mut bench = Bench::new();
    let double_click = |bench: &mut Bench, name: &str| {
        let field = bench.field(name).rect();
        let at = pos2(24.0, field.center().y);
        bench.hover_at(at);
        bench.run();
        for pressed in [true, false, true, false] {
            bench.button(at, PointerButton::Primary, pressed);
        }
        bench.settle();
    };
    // A frame of the harness takes a quarter of a second.
    let ctx = bench.ctx.clone();
    ctx.options_mut(|options| options.input_options.max_double_click_delay = 2.0);
    bench.enter("Range ρ", "1.3");
    bench.enter("Length L", "250");
    let edited = bench.view().scene.clone();
    assert_eq!(edited.law.range, Range::Length(1.3));
    double_click(&mut bench, "Range ρ");
    assert_eq!(bench.view().scene.law.range, Range::Length(1.0));
    assert_eq!(bench.view().scene.cell.length, edited.cell.length);
    double_click(&mut bench, "Length L");
    assert_eq!(bench.view().scene.cell.length, fig2().cell.length);
    for _ in 0..2 {
        bench.ctrl(Key::Z);
    }
    assert_eq!(bench.view().scene, edited);
}

#[test]
fn a_change_that_has_one_name_on_both_sides_gets_words() {
    let mut bench = Bench::new();
    bench.jump(3.102);
    let mut jump = bench.view().run.record.jumps[0].clone();
    (jump.from, jump.to) = (Pattern::Contact, Pattern::Contact);
    assert_eq!(jump.change(), "contact spreads");
    jump.direction = Direction::Retraction;
    assert_eq!(jump.change(), "contact shrinks");
    jump.to = Pattern::Other;
    assert_eq!(jump.change(), "contact → apart");
}

#[test]
fn the_window_opens_before_the_first_jump_and_tells_of_it_only_afterwards() {
    let state = ViewState::at_first_jump(fig2()).expect("allowed");
    let (_, upper) = tackscope::physics::theory::flat_limits(&state.model.law, 256.0).unwrap();
    let before = (state.target - upper) / state.rho();
    assert!(
        (0.05..0.3).contains(&before),
        "{before} ranges before the jump"
    );
    assert_eq!(*state.scene, fig2(), "the scene stays what it is");
    let mut bench = Bench::opened(state);
    bench.down(4.2);
    bench.down(3.25);
    bench.say(Event::Live(live()));
    for told in ["γ a loop", "live\n", "foreseen", "3.1023", "next jump"] {
        bench.lacks(told);
    }
    bench.says("Where will it snap?");
    bench.jump(3.102);
    bench.down(3.1);
    bench.says("γ a loop");
    bench.says("foreseen");
}

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
        1 => (0..storage::presets().len()).prop_map(G::Preset),
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
            let words = format!("preset {}", storage::presets()[*index].name);
            window.event(Input::Text(words));
            window.step();
            key(window, Modifiers::NONE, Key::Enter);
        }
        Gesture::Type(words) => {
            key(window, Modifiers::COMMAND, Key::K);
            window.event(Input::Text((*words).to_owned()));
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
