//! What stands below the plot: stability, forecast, time steps.

use super::bench::Bench;
use super::stored::looped;
use egui::{Event, Key, Modifiers, Role};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use tackscope::follow::record::Direction;
use tackscope::numerics::cancel::Cancel;
use tackscope::physics::theory::flat;
use tackscope::study::time_step_map::{Progress, Survey};
use tackscope::ui::App;

fn tab(bench: &mut Bench, name: &str) {
    bench.click(&format!("{name} tab"));
}

#[test]
fn the_tabs_are_reached_and_chosen_by_the_keyboard() {
    let mut bench = Bench::new();
    bench
        .window
        .get_by_role_and_label(Role::Tab, "Stability tab")
        .focus();
    bench.settle();
    bench.press(egui::Modifiers::NONE, egui::Key::Enter);
    assert!(bench.window.query_by_label("soft mode on map").is_some());
    assert!(bench.window.query_by_label("No jump yet.").is_none());
}

#[test]
fn the_stability_tab_says_the_eigenvalue_and_where_the_next_jump_is() {
    let mut bench = Bench::new();
    tab(&mut bench, "Stability");
    let (lower, upper) = flat::limits(&bench.model.law, bench.model.grid.length).unwrap();
    for u0 in [3.4, 3.38, 3.36] {
        bench.reach(u0, Direction::Approach);
    }
    let eigenvalue = flat::stiffness_min(&bench.model.law, bench.model.grid.length, 3.36);
    let words =
        format!("now {eigenvalue:.4} E*/L; next jump at u₀ = {upper:.4} ρ going down (exact)");
    assert!(
        bench.names().contains(&words),
        "{words} in {}",
        bench.names()
    );
    for u0 in [0.3, 0.32] {
        bench.reach(u0, Direction::Retraction);
    }
    assert!(
        bench
            .names()
            .contains(&format!("next jump at u₀ = {lower:.4} ρ going up (exact)")),
        "{}",
        bench.names()
    );
    for u0 in [3.36, 3.38] {
        bench.reach(u0, Direction::Retraction);
    }
    assert!(
        bench.names().contains("no jump foreseen going up"),
        "{}",
        bench.names()
    );
}

#[test]
fn the_curve_of_the_eigenvalue_is_cut_at_a_jump() {
    let mut bench = Bench::new();
    bench.reach(3.2, Direction::Approach);
    bench.reach(3.12, Direction::Approach);
    bench.jump(3.102);
    bench.reach(3.102, Direction::Approach);
    let pieces: Vec<usize> = bench
        .state()
        .run
        .stiffness
        .pieces
        .iter()
        .map(|piece| piece.points.len())
        .collect();
    assert_eq!(pieces, [2, 1]);
}

#[test]
fn the_time_steps_are_measured_at_the_push_of_a_button_shown_as_they_come_and_cancelled() {
    let mut bench = Bench::new();
    tab(&mut bench, "Stability");
    bench.click("time steps");
    bench.heard();
    bench.click("Measure");
    let ((scene, turn), report) = bench.time_steps();
    assert_eq!(
        (scene.title.as_str(), turn),
        (bench.state().scene.title.as_str(), bench.state().limits.0)
    );
    let mut survey = Survey::new(&scene, turn).unwrap();
    while survey.map().stable.len() < 7 {
        assert_eq!(survey.step(&Cancel::default()), Progress::Working);
    }
    report.result(survey.map().clone());
    bench.settle();
    assert!(
        bench
            .names()
            .contains("Time steps of GFMD against u0: 7 cells measured"),
        "{}",
        bench.names()
    );
    bench.click("Cancel");
    assert!(report.cancel.requested());
    report.end(Ok(()));
    bench.settle();
    assert!(bench.window.query_by_label("Measure").is_some());
    assert!(
        bench.names().contains("7 cells measured"),
        "what was measured stays"
    );
}

#[test]
fn the_soft_mode_is_switched_onto_the_map() {
    let mut bench = Bench::new();
    tab(&mut bench, "Stability");
    bench.click("soft mode on map");
    assert!(bench.state().view.soft_mode);
}

#[test]
fn the_first_frame_of_a_tab_shows_what_the_later_ones_do_at_the_same_places() {
    let (mut window, _) = looped();
    for name in [
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
        "Why",
    ] {
        window.key_press_modifiers(Modifiers::COMMAND, Key::K);
        window.step();
        window.event(Event::Text(format!("Tab: {name}")));
        window.step();
        window.key_press(Key::Enter);
        // The frame of the key, and the first one of the tab.
        window.run_steps(2);
        let seen = |window: &Harness<'static, App>| -> Vec<_> {
            let nodes = window.root().children_recursive();
            let words = nodes.filter_map(|node| {
                let words = node.accesskit_node().label().or(node.value())?;
                Some((words, node.rect()))
            });
            words.collect()
        };
        let first = seen(&window);
        window.run_steps(10);
        let later = seen(&window);
        let moved: Vec<_> = first.iter().zip(&later).filter(|(a, b)| a != b).collect();
        assert!(
            first.len() == later.len() && moved.is_empty(),
            "{name}: {moved:?}"
        );
    }
}
