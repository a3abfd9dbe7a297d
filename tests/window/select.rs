//! Looking at stored states and jumps; the scene on the clipboard; the layout restored.

use super::bench::{Bench, fig2};
use egui::epaint::{ClippedShape, Shape};
use egui::{Key, Modifiers, OutputCommand};
use egui_kittest::kittest::Queryable;
use tackscope::follow::record::Direction;
use tackscope::plot::style::Colours;
use tackscope::storage::scene_file;
use tackscope::ui::theme;

/// Down through two jumps.
fn walked() -> Bench {
    let mut bench = Bench::new();
    for (u0, jumps) in [
        (4.0, false),
        (3.5, false),
        (3.102, true),
        (3.0, false),
        (2.9, true),
        (2.8, false),
    ] {
        if jumps {
            bench.jump(u0);
        }
        bench.reach(u0, Direction::Approach);
    }
    bench
}

#[test]
fn a_click_on_the_curve_shows_the_numbers_of_the_state_there() {
    let mut bench = walked();
    let plot = bench
        .window
        .get_by_role_and_label(egui::Role::Image, bench.plot_sentence().as_str())
        .rect();
    // The axes are the scene's; the plot's own margins are found by asking for the place of two
    // known values.
    let state = bench.state().run.record.states[1].clone();
    let found = (0..200).any(|i| {
        let x = plot.left() + plot.width() * (0.6 + 0.002 * i as f32);
        (0..8).any(|k| {
            let y = plot.bottom() - plot.height() * (0.08 + 0.02 * k as f32);
            bench.click_at(egui::pos2(x, y));
            bench
                .state()
                .run
                .selection
                .as_ref()
                .is_some_and(|s| s.state == state)
        })
    });
    assert!(found, "no click found the state at 3.5");
    let names = bench.names();
    for words in ["flat on approach", "u₀ 3.50000 ρ", "Walk to it"] {
        assert!(names.contains(words), "{words} in {names}");
    }
    bench.heard();
    bench.click("Walk to it");
    assert_eq!(bench.targets(), [3.5]);
    bench.click("Close the card");
    assert_eq!(bench.state().run.selection, None);
}

#[test]
fn j_and_k_step_through_the_jumps_and_escape_leaves_them() {
    let mut bench = walked();
    let at = |bench: &Bench| {
        bench
            .state()
            .run
            .selection
            .as_ref()
            .map(|s| (s.jump, s.state.mean_displacement))
    };
    bench.press(Modifiers::NONE, Key::K);
    assert_eq!(at(&bench), Some((Some(1), 2.9)));
    bench.press(Modifiers::NONE, Key::K);
    assert_eq!(at(&bench), Some((Some(0), 3.102)));
    bench.press(Modifiers::NONE, Key::K);
    assert_eq!(at(&bench), Some((Some(0), 3.102)));
    bench.press(Modifiers::NONE, Key::J);
    assert_eq!(at(&bench), Some((Some(1), 2.9)));
    bench.press(Modifiers::NONE, Key::Escape);
    assert_eq!(at(&bench), None);
}

#[test]
fn a_click_on_a_row_of_the_events_shows_the_state_after_that_jump() {
    let mut bench = walked();
    bench.click("Events tab");
    bench.click("3.102");
    assert_eq!(
        bench
            .state()
            .run
            .selection
            .as_ref()
            .map(|s| (s.jump, s.state.mean_displacement)),
        Some((Some(0), 3.102))
    );
    assert!(bench.names().contains("flat → ridge released 0.1234 γ"));
}

#[test]
fn the_scene_goes_to_the_clipboard_as_text_and_comes_back() {
    let mut bench = Bench::new();
    bench.unfold("Copy scene");
    bench.window.get_by_label("Copy scene").click();
    bench.window.step();
    let copied = bench
        .window
        .output()
        .platform_output
        .commands
        .iter()
        .find_map(|command| match command {
            OutputCommand::CopyText(text) => Some(text.clone()),
            _ => None,
        });
    let copied = copied.expect("text on the clipboard");
    assert_eq!(scene_file::parse(&copied, "clipboard").unwrap(), fig2());
    bench.settle();
    let text = copied.replace("length = 256", "length = 200");
    bench.window.event(egui::Event::Paste(text));
    bench.settle();
    assert_eq!(bench.state().scene.cell.length, 200.0);
    bench
        .window
        .event(egui::Event::Paste("a shopping list".to_owned()));
    bench.settle();
    assert!(bench.state().messages.failure.is_some() && bench.state().scene.cell.length == 200.0);
}

#[test]
fn restore_layout_brings_view_and_axes_back() {
    let mut bench = walked();
    bench.click("Fit");
    bench.click("Stability tab");
    bench.click("soft mode on map");
    bench.click("Restore layout");
    assert_eq!(bench.state().view, Default::default());
    assert_eq!(bench.state().plots.fit, None);
}

#[test]
fn the_map_and_its_picture_are_in_the_chosen_colours() {
    let mut bench = walked();
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (colours, word) in Colours::ALL {
        bench.click(&format!("Colours: {word}"));
        bench.press(Modifiers::NONE, Key::Escape);
        assert_eq!(bench.state().view.colours, colours);
        let path = folder.path().join(format!("{}.png", word.len()));
        bench.click("Export picture…");
        bench.click("gap map");
        write_to(&mut bench, &path);
        let picture = image::open(&path).expect("a picture").to_rgb8();
        // A uniform gap has no contrast: all of it is the colour of the scale's beginning.
        assert_eq!(picture.get_pixel(9, 9).0, colours.at(0.0), "{word}");
    }
    // On the screen the colour bar ends in the last colour.
    let last = theme::rgb(Colours::Paper.at(1.0 - 0.5 / 64.0));
    let filled =
        |shape: &ClippedShape| matches!(&shape.shape, Shape::Rect(rect) if rect.fill == last);
    assert!(bench.window.output().shapes.iter().any(filled));
}

/// Types the path of the open dialog and writes.
fn write_to(bench: &mut Bench, path: &std::path::Path) {
    bench
        .window
        .get_by_role_and_label(egui::Role::TextInput, "Path")
        .focus();
    bench.window.run();
    bench.type_path(path);
    bench.click("Write");
    assert_eq!(bench.state().messages.failure, None);
}

#[test]
fn the_curve_is_written_as_an_svg_that_names_the_scene() {
    let mut bench = walked();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("loop.svg");
    bench.click("Export picture…");
    bench.click("stress curve, SVG");
    write_to(&mut bench, &path);
    let text = std::fs::read_to_string(&path).expect("written");
    assert!(
        text.starts_with("<svg") || text.starts_with("<?xml"),
        "{text:.80}"
    );
    assert!(text.contains("four patterns") && text.contains("</svg>"));
}

#[test]
fn an_exported_picture_opens_again_as_its_scene() {
    let mut bench = walked();
    bench.click("law cosine");
    let scene = bench.state().scene.clone();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("loop.png");
    bench.click("Export picture…");
    write_to(&mut bench, &path);
    bench.click("law mie");
    bench.open(&path);
    assert_eq!(
        (
            bench.state().messages.failure.clone(),
            bench.state().scene.clone()
        ),
        (None, scene)
    );
}
