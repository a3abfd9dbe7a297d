//! Sessions: saved, opened again as they were, and gone on with.

use super::bench::coarse;
use super::hand::{Hand, Window};
use super::stepped::opened;
use super::stored::{apart, looped, run, shown};
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use std::path::Path;
use tackscope::scene::Points;
use tackscope::storage::session::{self, Session};
use tackscope::storage::{self, Opened, files};
use tackscope::ui::view_state::{Extent, Saved, ViewState};

/// Types a path into the open dialog and presses its button.
fn use_path(window: &mut Window, path: &Path, button: &str) {
    let role = egui::Role::TextInput;
    window.get_by_role_and_label(role, "Path").focus();
    window.run();
    window.write_over(&path.display().to_string());
    window.get_by_label(button).click();
    window.run_steps(2);
    window.wait_for_file();
}

fn open(window: &mut Window, path: &Path) {
    window.key_press_modifiers(Modifiers::COMMAND, Key::O);
    window.run();
    use_path(window, path, "Open");
    window.run_steps(20);
}

/// A window on another scene.
fn elsewhere() -> Window {
    let mut scene = coarse(32);
    scene.law.range = tackscope::scene::Range::Length(1.2);
    opened(scene)
}

/// Saves the session of a window by its dialog.
fn save(window: &mut Window, path: &Path) {
    window.key_press_modifiers(Modifiers::COMMAND, Key::S);
    window.run();
    window.get_by_label_contains("session").click();
    window.run();
    let role = egui::Role::MultilineTextInput;
    window.get_by_role_and_label(role, "Notes").focus();
    window.run();
    window.write("why the ridge turns");
    use_path(window, path, "Write");
}

#[test]
fn a_session_opens_again_with_its_path_its_states_its_films_and_its_loss() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("mine.tackscope");
    let (mut window, _) = looped();
    window.tap(Key::L);
    save(&mut window, &path);
    assert!(path.exists(), "{:?}", window.view().messages);
    let mut again = elsewhere();
    open(&mut again, &path);
    let (before, after) = (window.view(), again.view());
    assert_eq!(
        (&after.scene, &*after.notes),
        (&before.scene, "why the ridge turns")
    );
    assert_eq!(after.run.record, before.run.record);
    assert_eq!(
        (after.run.actual, after.target),
        (before.run.actual, before.target)
    );
    let ledger = |window: &Window| {
        let closed = run(window).closed_loop.as_ref();
        closed.expect("a closed loop").summary.ledger.clone()
    };
    assert_eq!(ledger(&again), ledger(&window));
    assert!(!after.run.is_busy() && after.plots.ghosts.is_empty());
    for jump in 0..before.run.record.jumps.len() {
        let films = [before, after].map(|state| state.run.films.of(jump).map(|film| film.count()));
        assert!(
            films[0].is_some() && films[0] == films[1],
            "{jump}: {films:?}"
        );
    }
    let kept = |state: &ViewState| {
        let list = state.plots.kept.list.iter();
        let list = list.map(|kept| (kept.name.clone(), kept.lines.clone(), kept.loss));
        list.collect::<Vec<_>>()
    };
    assert_eq!((kept(before).len(), kept(after)), (1, kept(before)));
    // Every stored state, from the last back to the first.
    for _ in 0..before.run.record.states.len() {
        for window in [&mut window, &mut again] {
            window.key_press(Key::OpenBracket);
            window.step();
        }
        assert_eq!(run(&window).selection, run(&again).selection);
        assert!(apart(&shown(&window), &shown(&again)) < 1e-12);
    }
}

#[test]
fn a_session_saved_on_the_way_goes_on_as_it_would_have() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("mine.tackscope");
    let (mut window, _) = looped();
    // After the second jump, by a fork.
    for key in [Key::J, Key::J, Key::G] {
        window.tap(key);
    }
    let session = window.view().session(Extent::Whole);
    session::save(&path, &session, session.window.record()).expect("saved");
    let mut again = elsewhere();
    open(&mut again, &path);
    assert!(apart(&shown(&window), &shown(&again)) < 1e-6);
    for window in [&mut window, &mut again] {
        window.get_by_label("Play approach").click();
        window.step();
        window.rest();
    }
    let [a, b] = [&window, &again].map(|window| run(window).record.clone());
    assert_eq!(a.jumps.len(), b.jumps.len());
    assert!(a.jumps.len() >= 4 && a.states.len() == b.states.len());
    for (a, b) in a.states.iter().zip(&b.states) {
        assert_eq!((a.pattern, a.control), (b.pattern, b.control));
        assert!(
            (a.stress_over_max - b.stress_over_max).abs() < 1e-6,
            "{a:?} {b:?}"
        );
    }
}

#[test]
fn a_picture_opens_again_with_the_path_and_the_present_state() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("loop.png");
    let (mut window, _) = looped();
    for key in [Key::J, Key::J, Key::G] {
        window.tap(key);
    }
    window.tap(Key::S);
    use_path(&mut window, &path, "Write");
    assert!(std::fs::metadata(&path).expect("written").len() < 2_000_000);
    let mut again = elsewhere();
    open(&mut again, &path);
    assert_eq!(run(&again).record, run(&window).record);
    assert!(apart(&shown(&window), &shown(&again)) < 1e-6);
    // The command line reads its scene.
    assert_eq!(
        storage::open_scene(&path).ok().as_ref(),
        Some(&*window.view().scene)
    );
}

#[test]
fn a_session_that_contradicts_its_scene_is_refused_and_changes_nothing() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("mine.tackscope");
    let (window, _) = looped();
    let mut session = window.view().session(Extent::Whole);
    session.scene.cell.points = Points::Square(40);
    session::save(&path, &session, session.window.record()).expect("saved");
    let mut again = elsewhere();
    let before = again.view().scene.clone();
    open(&mut again, &path);
    let failure = again.view().messages.failure.clone().expect("refused");
    assert!(failure.message.contains("another mesh"), "{failure:?}");
    assert_eq!(again.view().scene, before);
    let bytes = files::read_regular(&path, session::BYTES_MAX).expect("read");
    let read: Session<Saved> = session::of_bytes(&path, &bytes).expect("whole");
    assert_eq!(read.window.record(), session.window.record());
    assert!(matches!(storage::open(&path), Ok(Opened::Session(_))));
}
