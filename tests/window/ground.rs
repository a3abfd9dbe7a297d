//! Measured ground in the window: a height file is opened, the scene stands on it, the tab looks at it.

use super::bench::Bench;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use std::fs;
use std::path::Path;
use std::time::Duration;
use tackscope::physics::indenter::Indenter;

/// Opens a file by its typed path and waits until something was said of it.
fn open(bench: &mut Bench, path: &Path) {
    bench.press(Modifiers::COMMAND, Key::O);
    bench.window.key_press_modifiers(Modifiers::COMMAND, Key::A);
    bench.window.run();
    bench
        .window
        .event(egui::Event::Text(path.display().to_string()));
    bench.window.run();
    bench.press(Modifiers::NONE, Key::Enter);
    for _ in 0..500 {
        bench.window.step();
        let messages = &bench.state().messages;
        let waits = |notice: &String| notice.starts_with("opening");
        if messages.failure.is_some() || !messages.notice.as_ref().is_some_and(waits) {
            return bench.settle();
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("it was never opened: {}", bench.names());
}

#[test]
fn a_height_file_becomes_the_ground_and_the_tab_shows_map_and_numbers() {
    let home = tempfile::tempdir().expect("a temporary folder");
    let path = home.path().join("map.csv");
    let row = |j: usize| {
        let cells = (0..8).map(|i| ((i * j) % 5).to_string());
        cells.collect::<Vec<_>>().join(",")
    };
    let rows: Vec<String> = (0..8).map(row).collect();
    fs::write(&path, rows.join("\n")).expect("written");
    let mut bench = Bench::new();
    let before = bench.state().scene.clone();
    open(&mut bench, &path);
    let scene = bench.state().scene.clone();
    let Indenter::Measured(measured) = &scene.indenter else {
        panic!("{:?}: {}", scene.indenter, bench.names());
    };
    assert_eq!(measured.topography().heights.dim(), (8, 8));
    assert_eq!(scene.cell.length, before.cell.length);
    assert!(
        bench.names().contains("it fills the cell"),
        "{}",
        bench.names()
    );
    // The button for another file is there, and the choices.
    assert!(
        bench
            .window
            .query_all_by_label("Height file")
            .next()
            .is_some()
    );
    bench.click("Ground tab");
    bench.run_jobs();
    for words in [
        "rms height",
        "Map of the ground",
        "made periodic by \"mirror\"",
    ] {
        assert!(bench.names().contains(words), "{words}: {}", bench.names());
    }
    bench.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(bench.state().scene, before);
}

#[test]
fn a_broken_height_file_is_refused_with_its_line_and_the_scene_stays() {
    let home = tempfile::tempdir().expect("a temporary folder");
    let path = home.path().join("map.csv");
    fs::write(&path, "1,2,3,4\n5,6,seven,8\n").expect("written");
    let mut bench = Bench::new();
    let before = bench.state().scene.clone();
    open(&mut bench, &path);
    assert!(
        bench.names().contains("line 2, column 3"),
        "{}",
        bench.names()
    );
    assert_eq!(bench.state().scene, before);
}
