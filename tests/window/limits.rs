//! What comes from outside: files of every kind, numbers as people type them, small screens, and
//! scenes at the ends of their ranges.

use super::bench::{Bench, fig2};
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use std::path::Path;
use std::time::{Duration, Instant};
use tackscope::follow::record::Direction;
use tackscope::physics::indenter::{Hertz, Indenter, Wave};
use tackscope::plot::style::Colours;
use tackscope::scene::{Range, Scene, Turn};
use tackscope::storage::{files, picture, presets, scene_file};

impl Bench {
    /// Types a path into the dialog that opens a file, and waits for what becomes of it.
    pub fn open(&mut self, path: &Path) {
        self.click("Open…");
        self.type_path(path);
        self.window.get_by_label("Open").click();
        self.window.run_steps(2);
        let begin = Instant::now();
        while self
            .state()
            .messages
            .notice
            .as_ref()
            .is_some_and(|notice| notice.starts_with("opening"))
        {
            assert!(
                begin.elapsed() < Duration::from_secs(10),
                "it is opened or refused"
            );
            std::thread::sleep(Duration::from_millis(2));
            self.window.step();
        }
        self.settle();
    }
}

fn hertz() -> Scene {
    presets::resolve("hertz").unwrap()
}

#[test]
fn a_scene_file_and_a_picture_with_its_scene_open_whatever_they_are_called() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (text, shot) = (folder.path().join("scene.txt"), folder.path().join("loop"));
    scene_file::save(&text, &hertz()).expect("saved");
    picture::write_gap_png(&shot, &ndarray::Array2::zeros((4, 4)), Colours::default())
        .expect("written");
    picture::attach(&shot, &hertz(), None).expect("attached");
    for path in [text, shot] {
        let mut bench = Bench::new();
        bench.open(&path);
        assert_eq!(*bench.state().scene, hertz());
        assert!(bench.names().contains("opened") && bench.state().messages.failure.is_none());
    }
}

#[test]
fn what_is_no_scene_is_refused_in_words_and_never_waited_for() {
    let folder = tempfile::tempdir().expect("a temporary folder");
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
        let failure = bench.state().messages.failure.clone().expect("refused");
        assert!(
            failure.message.contains(words) && failure.message.contains(name),
            "{failure:?}"
        );
        assert_eq!(*bench.state().scene, fig2());
    }
}

#[test]
fn a_decimal_comma_is_taken_in_every_field() {
    let mut bench = Bench::new();
    bench.enter("Target", "3,25");
    assert_eq!(bench.targets(), [3.25]);
    bench.click("Advanced");
    bench.enter("Surface energy γ", "0,175");
    assert_eq!(bench.state().scene.law.surface_energy, 0.175);
    bench.press(Modifiers::COMMAND, Key::K);
    bench.window.event(egui::Event::Text("2,5".to_owned()));
    bench.window.run();
    bench.press(Modifiers::NONE, Key::Enter);
    assert_eq!(bench.state().target, 2.5);
}

#[test]
fn the_last_scenes_picture_is_gone_at_once_when_another_is_opened() {
    let mut bench = Bench::new();
    bench.reach(3.9, Direction::Approach);
    assert!(bench.names().contains("Gap map: flat"));
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("scene.toml");
    scene_file::save(&path, &hertz()).expect("saved");
    bench.open(&path);
    assert!(
        bench.state().frame.is_none()
            && bench.names().contains("Gap map: waiting for the solver …")
    );
}

#[test]
fn an_edited_scene_waits_for_its_picture_in_words() {
    let mut bench = Bench::new();
    bench.reach(3.9, Direction::Approach);
    bench.click("law cosine");
    assert!(bench.names().contains("Gap map: waiting for the solver …"));
    bench.reach(3.9, Direction::Approach);
    assert!(bench.names().contains("Gap map: flat"));
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
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("scene.toml");
        // What is refused is no matter of the window.
        if scene_file::save(&path, &scene).is_ok() {
            bench.open(&path);
            assert_eq!(*bench.state().scene, scene, "{index}");
            bench.reach(scene.drive.start, Direction::Approach);
        }
    }
}
