//! What comes from outside and goes there: saving, where what it does to files that are there is asked
//! for first; the palette of commands; files of every kind, numbers as people type them, small screens,
//! and scenes at the ends of their ranges; sessions, saved, opened again as they were, and gone on with.

use super::bench::{Bench, coarse, fig2};
use super::hand::{Hand, Window, folder, opened, place_for};
use super::stored::{apart, looped, run, shown};
use egui::{Key, Modifiers, Theme};
use egui_kittest::kittest::Queryable;
use std::fs;
use std::path::Path;
use tackscope::paper::GALLERY;
use tackscope::physics::indenter::{Hertz, Indenter, Wave};
use tackscope::plot::style::Colours;
use tackscope::scene::{Points, Range, Scene, Turn};
use tackscope::storage::session::{self, Session};
use tackscope::storage::{self, Opened, files, picture, scene_file};
use tackscope::ui::action::ProfileLine;
use tackscope::ui::view_state::{Extent, Saved, ViewState};
use tackscope::worker::background::Page;
use tackscope::worker::protocol::{Command, Play, Speed};

/// Opens the dialog for saving and types a path.
fn save_as(bench: &mut Bench, path: &str) {
    bench.click("Save…");
    bench.write_over(path);
}

fn written(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_default()
}

#[test]
fn a_file_that_is_there_is_replaced_only_when_that_is_said_twice() {
    let (_home, path) = place_for("mine.toml");
    fs::write(&path, "mine").expect("written");
    let mut bench = Bench::new();
    save_as(&mut bench, &path.display().to_string());
    bench.tap(Key::Enter);
    bench.says("mine.toml is there already.");
    assert_eq!(written(&path), "mine");
    // Another path is another question, here none.
    bench
        .get_by_role_and_label(egui::Role::TextInput, "Path")
        .focus();
    bench.run();
    bench.write("2");
    assert!(bench.query_by_label("Replace it").is_none());
    bench.tap(Key::Escape);
    save_as(&mut bench, &path.display().to_string());
    bench.click("Write");
    bench.click("Replace it");
    assert!(written(&path).starts_with("format = 1"));
    bench.says("mine.toml written");
}

#[test]
fn a_folder_is_made_only_when_that_is_wanted() {
    let home = folder();
    let path = home.path().join("new").join("mine.toml");
    let mut bench = Bench::new();
    save_as(&mut bench, &path.display().to_string());
    bench.click("Write");
    bench.says("new is not there.");
    assert!(!home.path().join("new").exists());
    bench.click("Make the folder");
    assert!(written(&path).starts_with("format = 1"));
}

#[test]
fn a_tilde_of_somebody_else_is_refused_in_the_dialog() {
    let mut bench = Bench::new();
    save_as(&mut bench, "~nobody-at-all/mine.toml");
    bench.click("Write");
    bench.says("write the path out");
    assert!(!Path::new("~nobody-at-all").exists());
}

/// Opens the palette and types these words.
fn asked(words: &str) -> Bench {
    let mut bench = Bench::new();
    bench.heard();
    bench.ctrl(Key::K);
    bench.write(words);
    bench
}

#[test]
fn a_command_is_found_by_parts_of_its_name_and_run_by_enter() {
    let mut bench = asked("COS law");
    bench.says("Cohesive law: cosine");
    bench.lacks("Play or pause");
    bench.tap(Key::Enter);
    assert_eq!(bench.view().scene.law.shape.word(), "cosine");
    assert!(
        !bench.names().contains("Cohesive law: cosine"),
        "it is closed"
    );
}

#[test]
fn the_profile_is_cut_and_a_guess_is_made_without_a_mouse() {
    let mut bench = asked("profile along y");
    bench.tap(Key::Enter);
    assert_eq!(bench.view().view.profile, ProfileLine::AlongY(0.5));
    bench.tap(Key::F11);
    bench.ctrl(Key::K);
    bench.write("3.3");
    bench.tap(Key::ArrowDown);
    bench.tap(Key::Enter);
    assert_eq!(bench.view().plots.guesses, [3.3]);
    bench.jump(3.1);
    bench.ctrl(Key::K);
    bench.write("3.3");
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
        bench.tap(Key::Enter);
        assert_eq!(bench.ctx.theme(), theme, "{words}");
    }
}

#[test]
fn arrows_choose_among_what_is_found_and_a_click_runs_it() {
    let mut bench = asked("tab:");
    bench.tap(Key::ArrowDown);
    bench.tap(Key::ArrowDown);
    bench.tap(Key::ArrowUp);
    bench.tap(Key::Enter);
    bench.says("No jump yet.");
    bench.ctrl(Key::K);
    bench.click("Play approach");
    assert!(bench.view().run.sweep().is_some());
}

#[test]
fn a_figure_opens_in_its_tab() {
    let mut bench = asked("fig. 12");
    bench.tap(Key::Enter);
    let title = GALLERY.iter().find(|entry| entry.number == 12);
    let title = format!("Fig. 12: {}", title.expect("Fig. 12").title);
    bench.says(&title);
    let asked: Vec<Page> = bench.pages().into_iter().map(|(page, _)| page).collect();
    assert_eq!(asked, [Page::Figure(12)]);
}

#[test]
fn a_number_alone_is_a_mean_displacement_if_the_drive_reaches_it() {
    let mut bench = asked("2.5");
    bench.tap(Key::Enter);
    assert_eq!(bench.view().target, 2.5);
    assert!(bench.heard().iter().any(|command| matches!(
        command,
        Command::Play {
            play: Play::ToTarget(_),
            ..
        }
    )));
    assert!(!asked("17").names().contains("Go to u₀ = 17"));
}

#[test]
fn escape_and_words_that_find_nothing_change_nothing() {
    let mut bench = asked("no such thing");
    bench.says("Nothing has all these words");
    bench.tap(Key::Enter);
    bench.tap(Key::Escape);
    bench.lacks("Nothing has all these words");
    assert!(bench.heard().is_empty());
    assert_eq!(*bench.view().scene, fig2());
}

#[test]
fn the_speed_is_told_once_and_survives_another_scene() {
    let mut bench = asked("slow motion");
    bench.tap(Key::Enter);
    let told = |bench: &mut Bench| {
        bench
            .heard()
            .iter()
            .filter(|command| matches!(command, Command::SetSpeed { speed: Speed::Slow }))
            .count()
    };
    assert_eq!(told(&mut bench), 1);
    bench.tap(Key::Num2);
    assert_eq!(
        (told(&mut bench), bench.view().view.speed),
        (0, Speed::Slow)
    );
}

impl Bench {
    /// Types a path into the dialog that opens a file, and waits for what becomes of it.
    pub fn open(&mut self, path: &Path) {
        self.click("Open…");
        self.write_over(&path.display().to_string());
        self.hit("Open");
        self.wait_for_file();
    }
}

fn hertz() -> Scene {
    storage::resolve("hertz").unwrap()
}

#[test]
fn a_scene_file_and_a_picture_with_its_scene_open_whatever_they_are_called() {
    let folder = folder();
    let (text, shot) = (folder.path().join("scene.txt"), folder.path().join("loop"));
    scene_file::save(&text, &hertz()).expect("saved");
    picture::write_gap_png(&shot, &ndarray::Array2::zeros((4, 4)), Colours::default())
        .expect("written");
    picture::attach(&shot, &hertz(), None).expect("attached");
    for path in [text, shot] {
        let mut bench = Bench::new();
        bench.open(&path);
        assert_eq!(*bench.view().scene, hertz());
        assert!(bench.view().messages.failure.is_none());
        bench.says("opened");
    }
}

#[test]
fn what_is_no_scene_is_refused_in_words_and_never_waited_for() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    assert!(
        std::process::Command::new("mkfifo")
            .arg(at("pipe.toml"))
            .status()
            .expect("mkfifo")
            .success()
    );
    files::write_whole(&at("long.toml"), &vec![b'#'; (1 << 20) + 1]).expect("written");
    // A picture whose text is longer than any scene: length, name, keyword and data, checksum.
    let mut bytes = Vec::new();
    picture::write_gap_png(
        &at("plain.png"),
        &ndarray::Array2::zeros((4, 4)),
        Colours::default(),
    )
    .expect("written");
    bytes.extend(std::fs::read(at("plain.png")).expect("there"));
    let mut chunk = b"iTXttackscope-scene\0\0\0\0\0".to_vec();
    chunk.extend(std::iter::repeat_n(b'#', 3 << 20));
    let length = (chunk.len() as u32 - 4).to_be_bytes();
    bytes.splice(33..33, length.into_iter().chain(chunk).chain([0; 4]));
    files::write_whole(&at("huge.png"), &bytes).expect("written");
    for (name, words) in [
        ("pipe.toml", "a pipe or a device"),
        ("long.toml", "longer than"),
        ("huge.png", "longer than"),
        ("plain.png", "no scene in this picture"),
        ("nowhere.toml", "No such file"),
    ] {
        let mut bench = Bench::new();
        bench.open(&at(name));
        let failure = bench.view().messages.failure.clone().expect("refused");
        assert!(
            failure.message.contains(words) && failure.message.contains(name),
            "{failure:?}"
        );
        assert_eq!(*bench.view().scene, fig2());
    }
}

#[test]
fn a_decimal_comma_is_taken_in_every_field() {
    let mut bench = Bench::new();
    bench.enter("Target", "3,25");
    assert_eq!(bench.targets(), [3.25]);
    bench.click("Advanced");
    bench.enter("Surface energy γ", "0,175");
    assert_eq!(bench.view().scene.law.surface_energy, 0.175);
    bench.command("2,5");
    assert_eq!(bench.view().target, 2.5);
}

#[test]
fn the_last_scenes_picture_is_gone_at_once_when_another_is_opened() {
    let mut bench = Bench::new();
    bench.down(3.9);
    bench.says("Gap map: flat");
    let (_folder, path) = place_for("scene.toml");
    scene_file::save(&path, &hertz()).expect("saved");
    bench.open(&path);
    assert!(bench.view().frame.is_none());
    bench.says("Gap map: waiting for the solver …");
}

#[test]
fn an_edited_scene_waits_for_its_picture_in_words() {
    let mut bench = Bench::new();
    bench.down(3.9);
    bench.click("law cosine");
    bench.says("Gap map: waiting for the solver …");
    bench.down(3.9);
    bench.says("Gap map: flat");
}

#[test]
fn scenes_at_the_ends_of_their_ranges_are_drawn() {
    let extremes: [fn(&mut Scene); 8] = [
        |scene| scene.drive.start = 1e15,
        |scene| (scene.drive.start, scene.drive.step) = (1e15, 1e9),
        |scene| {
            (scene.drive.start, scene.drive.turn, scene.drive.step) =
                (1e17, Turn::At(1e17 - 16.0), 1e8);
        },
        |scene| scene.cell.length = 1e100,
        |scene| scene.law.range = Range::Length(1e-3),
        |scene| scene.law.surface_energy = 1e-50,
        |scene| {
            (scene.indenter, scene.drive.turn) =
                (Indenter::Hertz(Hertz { radius: 1e-100 }), Turn::ZeroLoad);
        },
        |scene| {
            (scene.indenter, scene.drive.turn) = (
                Indenter::Wave(Wave {
                    amplitude: 1e100,
                    periods: [1, 0],
                }),
                Turn::At(-1e3),
            );
        },
    ];
    for (index, extreme) in extremes.iter().enumerate() {
        let mut scene = fig2();
        extreme(&mut scene);
        let mut bench = Bench::new();
        let (_folder, path) = place_for("scene.toml");
        // What is refused is no matter of the window.
        if scene_file::save(&path, &scene).is_ok() {
            bench.open(&path);
            assert_eq!(*bench.view().scene, scene, "{index}");
            bench.down(scene.drive.start);
        }
    }
}

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
    let (_folder, path) = place_for("mine.tackscope");
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
    let (_folder, path) = place_for("mine.tackscope");
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
        window.play("Play approach");
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
    let (_folder, path) = place_for("loop.png");
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
    let (_folder, path) = place_for("mine.tackscope");
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
