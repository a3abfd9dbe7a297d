//! The path as a film: asked for by its name, written beside the window, given up.

use super::foreseen::at_rest;
use super::stored::run;
use egui::{Event, Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use std::path::Path;
use std::time::Duration;
use tackscope::ui::App;

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
