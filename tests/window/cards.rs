//! Every word on the screen has a card.

use super::bench::{fig2, named_from};
use super::stepped::computing;
use super::stored::looped;
use egui::{Event, Key, Modifiers, Pos2, Role};
use egui_kittest::kittest::{NodeT, Queryable};
use egui_kittest::{Harness, LazyRenderer};
use tackscope::scene::Points;
use tackscope::ui::App;
use tackscope::ui::view_state::ViewState;

/// Everything that is said.
fn said(window: &Harness<'static, App>) -> Vec<String> {
    let nodes = window.root().children_recursive();
    nodes
        .filter_map(|node| node.accesskit_node().label().or(node.value()))
        .collect()
}

/// What explains itself: sentences, formulas, numbers, and pictures, which say what they show.
fn is_plain(role: Role, name: &str) -> bool {
    let sentence = name.ends_with('.') || name.split_whitespace().count() > 6;
    let letters = name.chars().any(char::is_alphabetic);
    matches!(role, Role::Image | Role::Splitter) || sentence || !letters || name.contains('=')
}

/// The words in sight, with their places.
fn words(window: &Harness<'static, App>) -> Vec<(Role, String, Pos2)> {
    let screen = window.ctx.content_rect();
    let chip = |words| named_from(window, words);
    let chip = chip("exact to").or_else(|| chip("no accuracy is promised"));
    let bar = chip.expect("the chip of the bar").rect();
    let nodes = window.root().children_recursive();
    let words = nodes.filter_map(|node| {
        let (role, name) = (node.accesskit_node().role(), node.accesskit_node().label());
        let (name, at) = (name.or(node.value())?, node.rect().center());
        // What scrolls lies under the bar at the foot of the window.
        let of_bar = ["flat", "stable"].contains(&&*name) || name.starts_with("exact to");
        let seen = of_bar || at.y < bar.top() - 14.0;
        (screen.contains(at) && seen && !is_plain(role, &name)).then_some((role, name, at))
    });
    words.collect()
}

/// Those over which nothing more is said while the pointer rests on them.
fn lacking(window: &mut Harness<'static, App>) -> Vec<String> {
    let mut lacking = Vec::new();
    for (role, name, at) in words(window) {
        window.event(Event::PointerGone);
        window.run_steps(2);
        let before = said(window).len();
        window.hover_at(at);
        window.run_steps(3);
        if said(window).len() <= before {
            lacking.push(format!("{name} ({role:?})"));
        }
    }
    window.event(Event::PointerGone);
    window.run_steps(2);
    lacking
}

const TABS: [&str; 12] = [
    "Why",
    "Events",
    "Loops",
    "Stability",
    "Branches",
    "Landscape",
    "Map",
    "Ground",
    "Accuracy",
    "Study",
    "Equations",
    "Paper",
];

fn tab(window: &mut Harness<'static, App>, name: &str) {
    window.key_press_modifiers(Modifiers::COMMAND, Key::K);
    window.step();
    window.event(Event::Text(format!("Tab: {name}")));
    window.step();
    window.key_press(Key::Enter);
    window.run_steps(5);
}

/// Cards come at once.
fn at_once(window: &Harness<'static, App>) {
    window.ctx.all_styles_mut(|style| {
        style.interaction.tooltip_delay = 0.0;
        style.interaction.show_tooltips_only_when_still = false;
    });
}

#[test]
fn every_word_on_the_screen_and_on_each_tab_has_a_card() {
    let (mut window, _) = looped();
    at_once(&window);
    window.get_by_label("Advanced").click();
    window.run_steps(3);
    let mut seen = 0;
    for name in TABS {
        tab(&mut window, name);
        seen += words(&window).len();
        assert_eq!(lacking(&mut window), [""; 0], "on the tab {name}");
    }
    assert!(seen > 40 * TABS.len(), "{seen}");
}

#[test]
fn the_words_of_a_computed_map_study_and_ground_have_cards_too() {
    let opened = |points| {
        let mut scene = fig2();
        scene.cell.points = points;
        let state = ViewState::new(scene).expect("allowed");
        let window = computing(state, LazyRenderer::default());
        at_once(&window);
        window
    };
    let check = |window: &mut Harness<'static, App>, shown: &[&str]| {
        for words in shown {
            let there = said(window).iter().any(|said| said.contains(words));
            assert!(there, "{words}: {:?}", said(window));
        }
        assert_eq!(lacking(window), [""; 0], "beside {shown:?}");
    };
    let mut window = opened(Points::Square(32));
    tab(&mut window, "Map");
    check(&mut window, &["approach", "retraction", "Loss"]);
    tab(&mut window, "Study");
    window.get_by_label("Compute").click();
    window.run_steps(5);
    check(&mut window, &["15 of 15 loops"]);
    for (points, seen) in [
        (Points::Square(32), "height"),
        (Points::Line(64), "profile"),
    ] {
        let mut window = opened(points);
        window.get_by_label("ground waves").click();
        tab(&mut window, "Ground");
        let panels = [
            "rms height",
            "power spectrum",
            "distribution of heights",
            seen,
        ];
        check(&mut window, &panels);
    }
}
