//! What the scene is made of: measured ground from a height file; the machine, and the map of patterns;
//! units, in which the window speaks and takes numbers; the model in words with its error, overruled by
//! hand, changed on the way.

use super::bench::{Bench, fig2};
use super::hand::{Hand, folder, opened, place_for};
use super::wrongs::signed_zero;
use egui::Key;
use egui_kittest::kittest::Queryable;
use std::fs;
use tackscope::physics::body::{Body, Layer};
use tackscope::physics::control::Control;
use tackscope::physics::indenter::Indenter;
use tackscope::scene::{Part, Strategy};
use tackscope::worker::protocol::{Command, Event};

#[test]
fn a_height_file_becomes_the_ground_and_the_tab_shows_map_and_numbers() {
    let (_home, path) = place_for("map.csv");
    let row = |j: usize| {
        let cells = (0..8).map(|i| ((i * j) % 5).to_string());
        cells.collect::<Vec<_>>().join(",")
    };
    let rows: Vec<String> = (0..8).map(row).collect();
    fs::write(&path, rows.join("\n")).expect("written");
    let mut bench = Bench::new();
    let before = bench.view().scene.clone();
    bench.open(&path);
    let scene = bench.view().scene.clone();
    let Indenter::Measured(measured) = &scene.indenter else {
        panic!("{:?}: {}", scene.indenter, bench.names());
    };
    assert_eq!(measured.topography().heights.dim(), (8, 8));
    assert_eq!(scene.cell.length, before.cell.length);
    bench.says("it fills the cell");
    // The button for another file is there, and the choices.
    assert!(bench.query_all_by_label("Height file").next().is_some());
    bench.click("Ground tab");
    bench.run_jobs();
    for words in [
        "rms height",
        "Map of the ground",
        "made periodic by \"mirror\"",
    ] {
        bench.says(words);
    }
    bench.ctrl(Key::Z);
    assert_eq!(bench.view().scene, before);
}

#[test]
fn a_broken_height_file_is_refused_with_its_line_and_the_scene_stays() {
    let (_home, path) = place_for("map.csv");
    fs::write(&path, "1,2,3,4\n5,6,seven,8\n").expect("written");
    let mut bench = Bench::new();
    let before = bench.view().scene.clone();
    bench.open(&path);
    bench.says("line 2, column 3");
    assert_eq!(bench.view().scene, before);
}

#[test]
fn a_spring_is_chosen_from_its_picture_and_the_slider_then_drives_the_stage() {
    let mut bench = Bench::new();
    bench.heard();
    bench.says("mean displacement u0");
    bench.click("machine spring");
    let drive = bench.view().scene.drive;
    let Control::Spring { stiffness } = drive.control else {
        panic!("{drive:?}")
    };
    assert!(stiffness > 0.0);
    assert!(
        matches!(&bench.heard()[..], [Command::SetScene { scene, .. }] if scene.drive == drive)
    );
    bench.says("stage w");
    bench.enter("Stiffness of the spring k", "0.005");
    let asked = Control::Spring { stiffness: 0.005 };
    assert_eq!(bench.view().scene.drive.control, asked);
    bench.says("it snaps as one block");
    bench.click("machine weight");
    assert_eq!(bench.view().scene.drive.control, Control::Load);
    bench.says("load F");
    // Back on the way it came, one edit at a time.
    bench.click("machine stiff");
    assert_eq!(bench.view().scene.drive.control, Control::Displacement);
    bench.says("mean displacement u0");
}

#[test]
fn a_click_on_the_map_opens_the_scene_of_that_range_and_the_map_stays() {
    let mut bench = Bench::new();
    bench.click("Map tab");
    bench.run_jobs();
    let map = bench.place_of("Map of patterns: approach");
    let before = bench.view().model.law.range;
    bench.click_at(map.lerp_inside(egui::vec2(0.6, 0.7)));
    bench.settle();
    let after = bench.view().model.law.range;
    assert!(after < 0.9 * before && after > 0.5 * before, "{after}");
    // It holds this scene too: nothing is begun anew.
    bench.get_by_label("Map of patterns: approach");
    // The loop under the pointer lies in the plot while it is there.
    let preview = |bench: &Bench| bench.view().plots.preview.clone();
    bench.hover_at(map.lerp_inside(egui::vec2(0.6, 0.3)));
    bench.settle();
    let shown = preview(&bench).expect("a loop");
    assert!(shown.name.starts_with("ρ = ") && shown.points.len() > 100);
    bench.hover_at(egui::pos2(2.0, 2.0));
    bench.settle();
    assert!(preview(&bench).is_none());
    // Of another law it says nothing.
    bench.click("law cosine");
    let maps = bench.query_all_by_label("Map of patterns: approach");
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
    assert!(!window.view().run.record.jumps.is_empty());
}

#[test]
fn labels_and_typed_values_are_in_the_units_of_the_scene() {
    let mut bench = Bench::new();
    let before = bench.names();
    assert!(
        before.contains("4.2000 ρ") && !before.contains(" nm"),
        "{before}"
    );
    bench.command("preset rubber");
    assert!(bench.view().scene.units.is_some());
    // 0.55 um, where the drive begins.
    bench.says("550.00 nm");
    let found = bench.command("300");
    assert!(found.contains("Go to u₀ = 300 nm"), "{found}");
    let target = bench.view().target;
    assert!((target / 0.3 - 1.0).abs() < 1e-12, "300 nm of um: {target}");
}

#[test]
fn whether_the_scene_is_real_stands_below_the_equations() {
    let mut bench = Bench::new();
    bench.click("Equations tab");
    let plain = bench.names();
    assert!(
        plain.contains("Is this scene real?") && plain.contains("Largest strain: holds"),
        "{plain}"
    );
    assert!(!plain.contains("Range: "), "no metres are known");
    bench.command("preset rubber");
    let told = bench.names();
    assert!(
        told.contains("Range: doubtful") && told.contains("E* = 2.00 MPa"),
        "{told}"
    );
}

/// What a command of the palette writes.
fn exported(bench: &mut Bench, name: &str, path: &std::path::Path) -> String {
    bench.command(name);
    bench.write_over(&path.display().to_string());
    bench.click("Write");
    std::fs::read_to_string(path).unwrap_or_default()
}

#[test]
fn the_curves_of_a_tab_are_written_as_it_shows_them() {
    let home = folder();
    let at = |name: &str| home.path().join(name);
    let mut bench = Bench::new();
    for u0 in [4.0, 3.9, 3.8] {
        bench.down(u0);
    }
    let text = exported(&mut bench, "curves of the tab as", &at("why.csv"));
    assert!(text.is_empty());
    bench.says("the tab Why has no curves");
    bench.tap(Key::Escape);
    bench.tap(Key::Escape);
    bench.command("tab stability");
    let text = exported(&mut bench, "curves of the tab as", &at("stability.csv"));
    assert!(text.contains("smallest eigenvalue (E*/L)"), "{text}");
    let numbers = |line: &str| {
        let cells: Vec<f64> = line
            .split(',')
            .filter_map(|cell| cell.parse().ok())
            .collect();
        (cells.len() == 2).then(|| [cells[0], cells[1]])
    };
    let mut written: Vec<[f64; 2]> = text.lines().filter_map(numbers).collect();
    written.sort_by(|a, b| b[0].total_cmp(&a[0]));
    let states = bench.view().run.record.states.clone();
    assert_eq!(written.len(), states.len(), "{text}");
    for (written, state) in written.iter().zip(&states) {
        let [u0, eigenvalue] = *written;
        assert_eq!(u0, state.mean_displacement / bench.view().rho());
        assert!((eigenvalue / state.stiffness_min - 1.0).abs() < 1e-9);
    }
    bench.command("preset rubber");
    let text = exported(&mut bench, "curves of the tab as", &at("rubber.csv"));
    assert!(text.contains("x = u_0 (nm)"), "{text}");
}

#[test]
fn every_curve_of_the_plot_is_written_in_the_units_of_its_axes() {
    let (_home, path) = place_for("curves.csv");
    let mut bench = Bench::new();
    bench.command("preset rubber");
    let text = exported(&mut bench, "curves of the plot as", &path);
    assert!(text.contains("x = u₀ (nm), y = stress (kPa)"), "{text}");
    // The flat state in full contact at its strongest: 250 kPa at 100 nm ln 2.
    let flat = text
        .lines()
        .filter(|line| line.starts_with("a,\"flat state") || line.starts_with("a,flat state"));
    let points = flat.map(|line| {
        let numbers: Vec<f64> = line
            .rsplit(',')
            .skip(2)
            .take(2)
            .map(|x| x.parse().unwrap())
            .collect();
        [numbers[1], numbers[0]]
    });
    let top = points
        .max_by(|a, b| a[1].total_cmp(&b[1]))
        .expect("it is on flat ground");
    assert!(
        (top[1] - 250.0).abs() < 0.05 && (top[0] - 69.3).abs() < 1.5,
        "{top:?}"
    );
}

#[test]
fn the_status_bar_says_the_model_in_use_and_the_error_it_is_expected_to_have() {
    let mut bench = Bench::new();
    assert!(
        bench.status().contains("mesh 64 × 64"),
        "before the solver has spoken"
    );
    bench.ready();
    bench.down(3.9);
    assert!(bench.names().contains("exact to 0.005 %"), "the chip");
    let names = bench.status();
    for words in [
        "quarter of 64 × 64, expected error 0.005 %",
        "Plan: flat in closed form, ridge on half a line",
    ] {
        assert!(names.contains(words), "{words} in {names}");
    }
}

#[test]
fn the_plan_is_overruled_by_hand_which_begins_a_new_run() {
    let mut bench = Bench::new();
    bench.heard();
    bench.click("Advanced");
    for (label, asked) in [
        ("Model: whole cell", Some(Strategy::WHOLE)),
        ("Model: quarter", Some(Strategy::QUARTER)),
        ("Model: plan", None),
    ] {
        bench.get_by_label(label).scroll_to_me();
        bench.settle();
        bench.click(label);
        let heard = bench.heard();
        assert!(
            matches!(&heard[..], [Command::SetScene { asked: heard, .. }] if *heard == asked),
            "{heard:?}"
        );
    }
}

#[test]
fn a_model_changed_on_the_way_is_a_notice_and_no_failure() {
    let mut bench = Bench::new();
    bench.ready();
    let mut choice = bench.view().run.ready.as_ref().unwrap().choice.clone();
    choice.part = Part::Whole;
    choice.because = Some("a mode that is not mirror-symmetric goes soft here".to_owned());
    bench.say(Event::Remodelled(choice));
    assert_eq!(bench.view().messages.failure, None);
    bench.says("now on the whole cell: a mode that is not mirror-symmetric goes soft here");
    assert!(
        bench
            .status()
            .contains("whole cell 64 × 64, expected error")
    );
}

#[test]
fn the_body_becomes_a_layer_by_its_list_and_its_numbers_are_edited_like_those_of_a_law() {
    let mut bench = Bench::new();
    bench.click("Advanced");
    bench.lacks("Poisson");
    fn list(bench: &Bench) -> egui_kittest::Node<'_> {
        bench.get_by_role_and_label(egui::Role::ComboBox, "Body")
    }
    list(&bench).scroll_to_me();
    bench.settle();
    list(&bench).click();
    bench.settle();
    bench.click("layer");
    let thickness = bench.view().model.grid.length / 8.0;
    let layer = |poisson| Body::Layer(Layer { thickness, poisson });
    assert_eq!(bench.view().scene.body, layer(0.5));
    bench.enter("Poisson's ratio ν", "0.3");
    assert_eq!(bench.view().scene.body, layer(0.3));
    let scene = bench.scenes().pop().expect("a new run");
    assert_eq!(scene.body, layer(0.3));
    // The plate is driven, and pulls at the surface through the layer.
    bench.says("stage w");
}
