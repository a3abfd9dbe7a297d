//! Measured ground in the window: a height file is opened, the scene stands on it, the tab looks at it.
//! The machine, and the map of patterns.

use super::bench::{Bench, fig2};
use super::random::signed_zero;
use super::stepped::opened;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use std::fs;
use tackscope::physics::control::Control;
use tackscope::physics::indenter::Indenter;
use tackscope::worker::protocol::Command;

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
    bench.open(&path);
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
    bench.open(&path);
    assert!(
        bench.names().contains("line 2, column 3"),
        "{}",
        bench.names()
    );
    assert_eq!(bench.state().scene, before);
}

#[test]
fn a_spring_is_chosen_from_its_picture_and_the_slider_then_drives_the_stage() {
    let mut bench = Bench::new();
    bench.heard();
    assert!(bench.names().contains("mean displacement u0"));
    bench.click("machine spring");
    let drive = bench.state().scene.drive;
    let Control::Spring { stiffness } = drive.control else {
        panic!("{drive:?}")
    };
    assert!(stiffness > 0.0);
    assert!(
        matches!(&bench.heard()[..], [Command::SetScene { scene, .. }] if scene.drive == drive)
    );
    assert!(bench.names().contains("stage w"), "{}", bench.names());
    bench.enter("Stiffness of the spring k", "0.005");
    let asked = Control::Spring { stiffness: 0.005 };
    assert_eq!(bench.state().scene.drive.control, asked);
    assert!(bench.names().contains("it snaps as one block"));
    bench.click("machine weight");
    assert_eq!(bench.state().scene.drive.control, Control::Load);
    assert!(bench.names().contains("load F"), "{}", bench.names());
    // Back on the way it came, one edit at a time.
    bench.click("machine stiff");
    assert_eq!(bench.state().scene.drive.control, Control::Displacement);
    assert!(bench.names().contains("mean displacement u0"));
}

#[test]
fn a_click_on_the_map_opens_the_scene_of_that_range_and_the_map_stays() {
    let mut bench = Bench::new();
    bench.click("Map tab");
    bench.run_jobs();
    let map = bench
        .window
        .get_by_label("Map of patterns: approach")
        .rect();
    let before = bench.state().model.law.range;
    bench.click_at(map.lerp_inside(egui::vec2(0.6, 0.7)));
    bench.settle();
    let after = bench.state().model.law.range;
    assert!(after < 0.9 * before && after > 0.5 * before, "{after}");
    // It holds this scene too: nothing is begun anew.
    bench.window.get_by_label("Map of patterns: approach");
    // The loop under the pointer lies in the plot while it is there.
    let preview = |bench: &Bench| bench.state().plots.preview.clone();
    bench.window.hover_at(map.lerp_inside(egui::vec2(0.6, 0.3)));
    bench.settle();
    let shown = preview(&bench).expect("a loop");
    assert!(shown.name.starts_with("ρ = ") && shown.points.len() > 100);
    bench.window.hover_at(egui::pos2(2.0, 2.0));
    bench.settle();
    assert!(preview(&bench).is_none());
    // Of another law it says nothing.
    bench.click("law cosine");
    let maps = bench.window.query_all_by_label("Map of patterns: approach");
    assert_eq!(maps.count(), 0);
}

#[test]
fn under_a_weight_no_zero_has_a_sign_on_the_way_through_a_loop() {
    let mut window = opened(fig2());
    window.get_by_label("machine weight").click();
    window.step();
    window.key_press(Key::Space);
    for _ in 0..40 {
        window.step();
        assert_eq!(signed_zero(&window), None);
    }
    assert!(!window.state().state().run.record.jumps.is_empty());
}
