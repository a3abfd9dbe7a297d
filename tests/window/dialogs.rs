//! Saving: what it does to files that are there is asked for first.

use super::bench::Bench;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use std::fs;
use std::path::Path;

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
