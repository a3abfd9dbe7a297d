//! The window of a scene with units: it speaks in them, and takes numbers in them.

use super::bench::Bench;
use egui::{Event, Key, Modifiers};
use tackscope::scene::units::SUGGESTED;

/// Runs the command that these words find.
fn command(bench: &mut Bench, words: &str) -> String {
    bench.press(Modifiers::COMMAND, Key::K);
    bench.window.event(Event::Text(words.to_owned()));
    bench.settle();
    let found = bench.names();
    bench.press(Modifiers::NONE, Key::Enter);
    bench.settle();
    found
}

#[test]
fn labels_and_typed_values_are_in_the_units_of_the_scene() {
    let mut bench = Bench::new();
    let before = bench.names();
    assert!(
        before.contains("4.2000 ρ") && !before.contains(" nm"),
        "{before}"
    );
    command(&mut bench, "preset rubber");
    assert!(bench.state().scene.units.is_some());
    // 0.55 um, where the drive begins.
    assert!(bench.names().contains("550.00 nm"), "{}", bench.names());
    let found = command(&mut bench, "300");
    assert!(found.contains("Go to u₀ = 300 nm"), "{found}");
    let target = bench.state().target;
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
    command(&mut bench, "preset rubber");
    let told = bench.names();
    assert!(
        told.contains("Range: doubtful") && told.contains("E* = 2.00 MPa"),
        "{told}"
    );
}

#[test]
fn a_scene_is_given_units_by_the_picker_and_loses_them_by_undo() {
    let mut bench = Bench::new();
    bench.click("Advanced");
    bench.click("Units");
    bench.click("SI");
    let scene = bench.state().scene.clone();
    assert_eq!(scene.units, Some(SUGGESTED));
    // Nothing that is computed has changed.
    assert_eq!(scene.law.surface_energy, 0.15);
    assert!(
        bench.names().contains("Contact modulus E*"),
        "{}",
        bench.names()
    );
    bench.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(bench.state().scene.units, None);
}
