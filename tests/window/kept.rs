//! Loops that are kept: the list, the scales, and a scene beside the present one.

use super::bench::{Bench, fig2};
use super::hand::{Hand, Window};
use super::stored::{at_rest, run};
use egui::Key;
use egui_kittest::kittest::Queryable;
use tackscope::plot::panel::Role;
use tackscope::study::live_loop::{Fineness, LiveLoops};
use tackscope::ui::view_state::Kept;

/// Three states of Fig. 2, kept, under another law.
fn kept() -> (Bench, Vec<[f64; 2]>) {
    let mut bench = Bench::new();
    bench.tap(Key::L);
    assert!(list(&bench).is_empty());
    bench.says("no loop to keep");
    for u0 in [4.0, 3.9, 3.8] {
        bench.down(u0);
    }
    let drawn = bench.view().run.curve.points().collect();
    bench.tap(Key::L);
    bench.click("law cosine");
    bench.click("Loops tab");
    (bench, drawn)
}

fn list(bench: &Bench) -> &[Kept] {
    &bench.view().plots.kept.list
}

#[test]
fn a_kept_loop_stays_while_the_law_changes_until_it_is_deleted_and_comes_back() {
    let (mut bench, drawn) = kept();
    assert!(bench.view().run.curve.points().next().is_none());
    let [loop_] = list(&bench) else { panic!("one") };
    assert_eq!(loop_.name, fig2().title);
    let there = bench.view().lines_of(loop_).concat();
    assert_eq!(there.len(), drawn.len());
    for (a, b) in there.iter().zip(&drawn) {
        assert!(
            (a[0] - b[0]).abs() < 1e-12 && (a[1] - b[1]).abs() < 1e-12,
            "{a:?} {b:?}"
        );
    }
    let title = fig2().title;
    bench.click(&format!("Delete {title}"));
    assert!(list(&bench).is_empty());
    bench.click("Bring the deleted loop back");
    assert_eq!(list(&bench).len(), 1);
}

#[test]
fn a_kept_loop_is_hidden_and_renamed_in_place_and_its_scene_is_opened_again() {
    let (mut bench, _) = kept();
    let title = fig2().title;
    bench.click(&format!("Show {title}"));
    assert_eq!(bench.view().plots.kept.drawn().count(), 0);
    bench.click(&format!("Show {title}"));
    assert_eq!(bench.view().plots.kept.drawn().count(), 1);
    bench.click(&format!("Name of {title}"));
    bench.write_over("first");
    assert_eq!(list(&bench)[0].name, "first");
    bench.says("first");
    bench.click("Open the scene of first");
    assert_eq!(*bench.view().scene, fig2());
    assert_eq!(list(&bench).len(), 1, "it stays");
}

#[test]
fn in_absolute_units_a_kept_loop_is_drawn_by_the_ratio_of_the_laws() {
    let (mut bench, drawn) = kept();
    bench.click("Absolute units");
    let state = bench.view();
    let [own, law] = [&fig2().model().unwrap().law, &state.model.law];
    let ratio = [
        own.range / law.range,
        own.traction_max() / law.traction_max(),
    ];
    assert!((ratio[1] - 1.0).abs() > 0.05, "the laws differ: {ratio:?}");
    let there = state.lines_of(&list(&bench)[0]).concat();
    for (a, b) in there.iter().zip(&drawn) {
        for k in 0..2 {
            assert!((a[k] - ratio[k] * b[k]).abs() < 1e-12, "{a:?} {b:?}");
        }
    }
    bench.click("Absolute units");
    let there = bench.view().lines_of(&list(&bench)[0]).concat();
    assert!((there[0][1] - drawn[0][1]).abs() < 1e-12);
}

#[test]
fn more_loops_than_can_be_told_apart_are_refused_in_words() {
    let (mut bench, _) = kept();
    for u0 in [4.0, 3.9, 3.8] {
        bench.down(u0);
    }
    for _ in 0..9 {
        bench.tap(Key::L);
    }
    assert_eq!(list(&bench).len(), 8);
    bench.says("delete one of them first");
    let looks: Vec<_> = list(&bench).iter().map(Kept::look).collect();
    for (i, a) in looks.iter().enumerate() {
        assert!(!looks[..i].contains(a), "{a:?} twice");
        assert!(Role::ORDER.contains(&Role::Kept(a.1)), "it is drawn");
    }
}

/// The accessible sentence of the map beside.
fn map_b(window: &Window) -> String {
    window.name("B, ")
}

#[test]
fn the_scene_before_the_edit_stands_beside_this_one_at_the_same_u0() {
    let mut window = at_rest();
    let before = window.view().scene.clone();
    window.hit("law double exponential");
    window.hit("Loops tab");
    window.hit("Compare with the scene before the last edit");
    let drive = |window: &mut Window, key: Key| {
        window.key_press(key);
        window.run_steps(400);
    };
    drive(&mut window, Key::PageDown);
    let state = window.view();
    let (beside, kept) = state.beside().expect("B");
    assert_eq!(kept.scene, before);
    let frame = beside.shown.as_ref().expect("a surface");
    let now = state.run.state.clone().expect("a state");
    let (a, b) = (now.mean_displacement / state.rho(), frame.mean_displacement);
    assert!((a - b / kept.model.law.range).abs() < 1e-9, "{a} {b}");
    assert!(
        (frame.gap.mean().unwrap() - b).abs() < 1e-6,
        "its own surface"
    );
    let pattern = frame.state.as_ref().expect("its record").pattern;
    assert!(map_b(&window).contains(pattern.word()));
    // What is said of the losses is what both live loops lose.
    let loss = |scene: &tackscope::scene::Scene| {
        let model = scene.model().unwrap();
        LiveLoops::default()
            .next(scene, &model, Fineness::Fine)
            .unwrap()
            .dissipated_energy
    };
    let (a, b) = (loss(&window.view().scene), loss(&before));
    let words = window.view().losses_in_words().expect("both are known");
    assert!(
        words.starts_with(&format!("A loses {a:.4}, B {b:.4} γ")),
        "{words}"
    );
    // A drag on B drives both.
    let target = window.view().target;
    let at = window.place("B, ").center();
    window.drag_along(at, &[egui::vec2(0.0, 20.0)]);
    window.run_steps(200);
    let state = window.view();
    assert!(state.target < target);
    let frame = state
        .beside()
        .expect("B")
        .0
        .shown
        .clone()
        .expect("a surface");
    let now = state.run.state.as_ref().expect("a state");
    let off = now.mean_displacement / state.rho() - frame.mean_displacement;
    assert!(off.abs() < 1e-6, "{off}");
}

#[test]
fn both_maps_are_large_enough_to_be_seen_in_a_small_window() {
    let mut window = at_rest();
    window.hit("law double exponential");
    window.hit("Loops tab");
    window
        .get_by_label("Compare with the scene before the last edit")
        .click();
    window.run_steps(200);
    for (size, least) in [
        (egui::vec2(900.0, 600.0), 130.0),
        (egui::vec2(1280.0, 800.0), 170.0),
        (egui::vec2(1920.0, 1080.0), 250.0),
    ] {
        window.set_size(size);
        window.run();
        let [a, b] = ["Gap map:", "B, "].map(|map| window.place(map));
        let foot = window.place("Profile along").top();
        assert_eq!(a.size(), b.size());
        assert!(
            a.width() >= least && (a.width() - a.height()).abs() < 0.1,
            "{a:?} at {size}"
        );
        assert!(
            !a.intersects(b) && a.bottom().max(b.bottom()) < foot,
            "{a:?} {b:?}"
        );
    }
}

#[test]
fn a_scene_without_an_atlas_says_beside_why_there_is_nothing_to_see() {
    let mut window = at_rest();
    // The tip.
    window.key_press(Key::Num6);
    window.run_steps(20);
    assert!(window.view().live().is_none(), "no atlas");
    window.get_by_label("law cosine").click();
    window.run_steps(20);
    window.hit("Loops tab");
    window
        .get_by_label("Compare with the scene before the last edit")
        .click();
    window.run_steps(20);
    let words = map_b(&window);
    assert!(words.contains("it has no live loop"), "{words}");
}

#[test]
fn a_click_on_a_kept_loop_of_another_scene_says_why_its_state_is_not_shown() {
    let mut window = at_rest();
    window.tap(Key::L);
    assert!(!window.view().plots.kept.list[0].is_walked);
    window.hit("law cosine");
    let place = window.place("Stress against u0:");
    let x = place.left() + 0.5 * place.width();
    let said = (0..80).any(|k| {
        window.click_at(egui::pos2(x, place.bottom() - 30.0 - 4.0 * k as f32));
        let notice = window.view().messages.notice.clone();
        notice.is_some_and(|words| words.contains("is of another scene"))
    });
    assert!(said);
    assert!(run(&window).record.states.len() == 1, "the surface stays");
}
