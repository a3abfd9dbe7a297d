//! Saving, where what it does to files that are there is asked for first; and the palette of commands.

use super::bench::{Bench, fig2};
use egui::{Event, Key, Modifiers, Theme};
use egui_kittest::kittest::Queryable;
use std::fs;
use std::path::Path;
use tackscope::paper::GALLERY;
use tackscope::ui::action::ProfileLine;
use tackscope::worker::background::Page;
use tackscope::worker::protocol::{Command, Speed};

/// Opens the dialog for saving and types a path.
fn save_as(bench: &mut Bench, path: &str) {
    bench.click("Save…");
    bench.window.key_press_modifiers(Modifiers::COMMAND, Key::A);
    bench.window.run();
    bench.window.event(egui::Event::Text(path.to_owned()));
    bench.window.run();
}

fn written(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_default()
}

#[test]
fn a_file_that_is_there_is_replaced_only_when_that_is_said_twice() {
    let home = tempfile::tempdir().expect("a temporary folder");
    let path = home.path().join("mine.toml");
    fs::write(&path, "mine").expect("written");
    let mut bench = Bench::new();
    save_as(&mut bench, &path.display().to_string());
    bench.press(Modifiers::NONE, Key::Enter);
    assert!(
        bench.names().contains("mine.toml is there already."),
        "{}",
        bench.names()
    );
    assert_eq!(written(&path), "mine");
    // Another path is another question, here none.
    bench
        .window
        .get_by_role_and_label(egui::Role::TextInput, "Path")
        .focus();
    bench.window.run();
    bench.window.event(egui::Event::Text("2".to_owned()));
    bench.window.run();
    assert!(bench.window.query_by_label("Replace it").is_none());
    bench.press(Modifiers::NONE, Key::Escape);
    save_as(&mut bench, &path.display().to_string());
    bench.click("Write");
    bench.click("Replace it");
    assert!(written(&path).starts_with("format = 1"));
    assert!(bench.names().contains("mine.toml written"));
}

#[test]
fn a_folder_is_made_only_when_that_is_wanted() {
    let home = tempfile::tempdir().expect("a temporary folder");
    let path = home.path().join("new").join("mine.toml");
    let mut bench = Bench::new();
    save_as(&mut bench, &path.display().to_string());
    bench.click("Write");
    assert!(
        bench.names().contains("new is not there."),
        "{}",
        bench.names()
    );
    assert!(!home.path().join("new").exists());
    bench.click("Make the folder");
    assert!(written(&path).starts_with("format = 1"));
}

#[test]
fn a_tilde_of_somebody_else_is_refused_in_the_dialog() {
    let mut bench = Bench::new();
    save_as(&mut bench, "~nobody-at-all/mine.toml");
    bench.click("Write");
    assert!(
        bench.names().contains("write the path out"),
        "{}",
        bench.names()
    );
    assert!(!Path::new("~nobody-at-all").exists());
}

/// Opens the palette and types these words.
fn asked(words: &str) -> Bench {
    let mut bench = Bench::new();
    bench.heard();
    bench.press(Modifiers::COMMAND, Key::K);
    bench.window.event(Event::Text(words.to_owned()));
    bench.window.run();
    bench
}

#[test]
fn a_command_is_found_by_parts_of_its_name_and_run_by_enter() {
    let mut bench = asked("COS law");
    assert!(
        bench.names().contains("Cohesive law: cosine") && !bench.names().contains("Play or pause")
    );
    bench.press(Modifiers::NONE, Key::Enter);
    assert_eq!(bench.state().scene.law.shape.word(), "cosine");
    assert!(
        !bench.names().contains("Cohesive law: cosine"),
        "it is closed"
    );
}

#[test]
fn the_profile_is_cut_and_a_guess_is_made_without_a_mouse() {
    let mut bench = asked("profile along y");
    bench.press(Modifiers::NONE, Key::Enter);
    assert_eq!(bench.state().view.profile, ProfileLine::AlongY(0.5));
    bench.press(Modifiers::NONE, Key::F11);
    bench.press(Modifiers::COMMAND, Key::K);
    bench.window.event(Event::Text("3.3".to_owned()));
    bench.window.run();
    bench.press(Modifiers::NONE, Key::ArrowDown);
    bench.press(Modifiers::NONE, Key::Enter);
    assert_eq!(bench.state().plots.guesses, [3.3]);
    bench.jump(3.1);
    bench.press(Modifiers::COMMAND, Key::K);
    bench.window.event(Event::Text("3.3".to_owned()));
    bench.window.run();
    assert!(
        !bench.names().contains("Guess the first jump"),
        "it is over"
    );
}

#[test]
fn the_theme_is_found_by_its_name_in_any_order() {
    for (words, theme) in [
        ("theme dark", Theme::Dark),
        ("light theme", Theme::Light),
        ("dark", Theme::Dark),
        ("light", Theme::Light),
    ] {
        let mut bench = asked(words);
        bench.press(Modifiers::NONE, Key::Enter);
        assert_eq!(bench.window.ctx.theme(), theme, "{words}");
    }
}

#[test]
fn arrows_choose_among_what_is_found_and_a_click_runs_it() {
    let mut bench = asked("tab:");
    bench.press(Modifiers::NONE, Key::ArrowDown);
    bench.press(Modifiers::NONE, Key::ArrowDown);
    bench.press(Modifiers::NONE, Key::ArrowUp);
    bench.press(Modifiers::NONE, Key::Enter);
    assert!(bench.names().contains("No jump yet."));
    bench.press(Modifiers::COMMAND, Key::K);
    bench.click("Play approach");
    assert!(bench.state().run.sweep().is_some());
}

#[test]
fn a_figure_opens_in_its_tab() {
    let mut bench = asked("fig. 12");
    bench.press(Modifiers::NONE, Key::Enter);
    let title = GALLERY.iter().find(|entry| entry.number == 12);
    let title = format!("Fig. 12: {}", title.expect("Fig. 12").title);
    assert!(bench.names().contains(&title), "{}", bench.names());
    let asked: Vec<Page> = bench.pages().into_iter().map(|(page, _)| page).collect();
    assert_eq!(asked, [Page::Figure(12)]);
}

#[test]
fn a_number_alone_is_a_mean_displacement_if_the_drive_reaches_it() {
    let mut bench = asked("2.5");
    bench.press(Modifiers::NONE, Key::Enter);
    assert_eq!(bench.state().target, 2.5);
    assert!(
        bench
            .heard()
            .iter()
            .any(|command| matches!(command, Command::SetTarget { .. }))
    );
    assert!(!asked("17").names().contains("Go to u₀ = 17"));
}

#[test]
fn escape_and_words_that_find_nothing_change_nothing() {
    let mut bench = asked("no such thing");
    assert!(bench.names().contains("Nothing has all these words"));
    bench.press(Modifiers::NONE, Key::Enter);
    bench.press(Modifiers::NONE, Key::Escape);
    assert!(!bench.names().contains("Nothing has all these words"));
    assert!(bench.heard().is_empty());
    assert_eq!(*bench.state().scene, fig2());
}

#[test]
fn the_speed_is_told_once_and_survives_another_scene() {
    let mut bench = asked("slow motion");
    bench.press(Modifiers::NONE, Key::Enter);
    let told = |bench: &mut Bench| {
        bench
            .heard()
            .iter()
            .filter(|command| matches!(command, Command::SetSpeed { speed: Speed::Slow }))
            .count()
    };
    assert_eq!(told(&mut bench), 1);
    bench.press(Modifiers::NONE, Key::Num2);
    assert_eq!(
        (told(&mut bench), bench.state().view.speed),
        (0, Speed::Slow)
    );
}
