//! The window of a scene with units: it speaks in them, and takes numbers in them.

use super::bench::Bench;
use egui::{Event, Key, Modifiers};
use tackscope::follow::record::Direction;

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

/// What a command of the palette writes.
fn exported(bench: &mut Bench, name: &str, path: &std::path::Path) -> String {
    command(bench, name);
    bench.type_path(path);
    bench.click("Write");
    std::fs::read_to_string(path).unwrap_or_default()
}

#[test]
fn the_curves_of_a_tab_are_written_as_it_shows_them() {
    let home = tempfile::tempdir().expect("a temporary folder");
    let at = |name: &str| home.path().join(name);
    let mut bench = Bench::new();
    for u0 in [4.0, 3.9, 3.8] {
        bench.reach(u0, Direction::Approach);
    }
    let text = exported(&mut bench, "curves of the tab as", &at("why.csv"));
    assert!(text.is_empty() && bench.names().contains("the tab Why has no curves"));
    bench.press(Modifiers::NONE, Key::Escape);
    bench.press(Modifiers::NONE, Key::Escape);
    command(&mut bench, "tab stability");
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
    let states = bench.state().run.record.states.clone();
    assert_eq!(written.len(), states.len(), "{text}");
    for (written, state) in written.iter().zip(&states) {
        let [u0, eigenvalue] = *written;
        assert_eq!(u0, state.mean_displacement / bench.state().rho());
        assert!((eigenvalue / state.stiffness_min - 1.0).abs() < 1e-9);
    }
    command(&mut bench, "preset rubber");
    let text = exported(&mut bench, "curves of the tab as", &at("rubber.csv"));
    assert!(text.contains("x = u0 (nm)"), "{text}");
}

#[test]
fn every_curve_of_the_plot_is_written_in_the_units_of_its_axes() {
    let home = tempfile::tempdir().expect("a temporary folder");
    let path = home.path().join("curves.csv");
    let mut bench = Bench::new();
    command(&mut bench, "preset rubber");
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
