//! What the program does to files, folders and streams that are not as it would like them.
#![cfg(unix)]

use crate::binary::{
    Running, content, done, errors, fig2_with, folder, perform, refuses, run, says, summary,
    tackscope, without_display,
};
use std::fs::{self, File};
use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use tackscope::scene::{Range, Turn};
use tackscope::storage::{self, files, scene_file};

const RESULTS: [&str; 5] = [
    "loop.csv",
    "events.csv",
    "loop.svg",
    "loop.png",
    "summary.json",
];

fn quick(out: &Path) -> Output {
    run(
        "no-hysteresis",
        out,
        &["--quiet", "--points", "8", "--step", "0.1"],
    )
}

/// Everything below a folder that is no result of a run.
fn strangers(folder: &Path) -> Vec<String> {
    let names = fs::read_dir(folder).expect("listed").map(|entry| {
        entry
            .expect("an entry")
            .file_name()
            .into_string()
            .expect("UTF-8")
    });
    names
        .filter(|name| !RESULTS.contains(&name.as_str()) && name != "gaps")
        .collect()
}

#[test]
fn one_file_that_cannot_be_written_does_not_keep_the_others() {
    let home = folder();
    let pipe = home.path().join("pipe");
    assert!(
        Command::new("mkfifo")
            .arg(&pipe)
            .status()
            .expect("mkfifo runs")
            .success()
    );
    let out = home.path().join("out");
    fs::create_dir_all(out.join("loop.svg")).expect("made");
    symlink(&pipe, out.join("events.csv")).expect("linked");
    symlink(home.path().join("nowhere/gone.csv"), out.join("loop.csv")).expect("linked");
    let output = quick(&out);
    let told = errors(&output);
    assert_eq!(output.status.code(), Some(2), "{told}");
    says(
        &told,
        &[
            "loop.svg: cannot be written (it is a folder",
            "events.csv: cannot be written (it is a device or a pipe",
            "loop.csv",
        ],
    );
    assert_eq!(told.lines().count(), 3, "{told}");
    assert!(out.join("loop.png").exists() && summary(&out)["stop"] == "completed");
    assert!(
        fs::metadata(&pipe).expect("there").file_type().is_fifo(),
        "the pipe is still one"
    );
}

#[test]
fn what_is_read_only_is_refused_before_anything_is_computed_or_removed() {
    let home = folder();
    done(&quick(home.path()));
    let events = home.path().join("events.csv");
    fs::write(&events, "mine").expect("written");
    fs::set_permissions(&events, fs::Permissions::from_mode(0o444)).expect("set");
    let output = run("no-hysteresis", home.path(), &["--points", "8"]);
    refuses(&output, &["events.csv: cannot be written (it is read-only"]);
    assert_eq!(content(&events), "mine");
    assert_eq!(
        summary(home.path())["plan"]["points"],
        serde_json::json!([8, 8])
    );
    assert!(
        files::write_whole(&events, b"yours")
            .expect_err("refused")
            .to_string()
            .contains("read-only")
    );
    assert_eq!(strangers(home.path()), Vec::<String>::new());
}

#[test]
fn a_link_stays_a_link_and_its_file_keeps_its_mode() {
    let home = folder();
    let (old, new, link, dangling) = ["old.csv", "new.csv", "link.csv", "dangling.csv"]
        .map(|name| home.path().join(name))
        .into();
    fs::write(&old, "old").expect("written");
    fs::set_permissions(&old, fs::Permissions::from_mode(0o640)).expect("set");
    symlink("old.csv", &link).expect("linked");
    symlink(&new, &dangling).expect("linked");
    files::write_whole(&link, b"better").expect("written");
    files::write_whole(&dangling, b"first").expect("written");
    for (link, file, text) in [(&link, &old, "better"), (&dangling, &new, "first")] {
        assert!(fs::symlink_metadata(link).expect("there").is_symlink());
        assert_eq!(content(file), text);
    }
    assert_eq!(
        fs::metadata(&old).expect("there").permissions().mode() & 0o777,
        0o640
    );
    let circle = home.path().join("circle");
    symlink(&circle, &circle).expect("linked");
    assert!(
        files::write_whole(&circle, b"x")
            .expect_err("refused")
            .to_string()
            .contains("circle")
    );
    // What a process has open is no file to be replaced, though it may look like one.
    let open = File::open(&old).expect("open");
    let path = format!("/dev/fd/{}", std::os::fd::AsRawFd::as_raw_fd(&open));
    assert!(files::write_whole(Path::new(&path), b"x").is_err());
    assert_eq!(content(&old), "better");
}

#[test]
fn an_earlier_run_is_gone_when_the_next_one_begins_and_that_is_said() {
    let home = folder();
    done(&run("fig2", home.path(), &["--quiet"]));
    assert!(
        fs::read_dir(home.path().join("gaps"))
            .expect("listed")
            .count()
            > 2
    );
    fs::write(home.path().join("notes.txt"), "mine").expect("written");
    let (scene, _kept) = fig2_with(&[("title = ", "title = \"the second\" #")]);
    let mut running = Running::start(
        &scene,
        home.path(),
        &["--points", "512", "--step", "0.0005", "--model", "whole"],
    );
    assert!(
        running
            .line()
            .contains("held an earlier run, which this one replaces")
    );
    assert!(running.line().starts_with("the second: "));
    let begun = summary(home.path());
    assert_eq!(
        (&begun["stop"], &begun["completed"]),
        (&"running".into(), &false.into())
    );
    assert_eq!(begun["scene"]["title"], "the second");
    assert_eq!(begun["released_energy_sum"], "not available");
    assert!(
        RESULTS[..4]
            .iter()
            .all(|name| !home.path().join(name).exists())
    );
    assert_eq!(
        fs::read_dir(home.path().join("gaps"))
            .expect("listed")
            .count(),
        0
    );

    for more in [
        &["run", "fig2"][..],
        &["table", "1"],
        &["figure", "4", "--quick"],
        &["chart", "fig2", "--quick"],
    ] {
        let process = running.id();
        let why = format!("another tackscope (process {process}) is writing into it");
        refuses(&perform(more, home.path()), &[&why]);
    }
    running.signal("KILL");
    assert_eq!(running.end().0, None);
    assert_eq!(
        summary(home.path())["stop"],
        "running",
        "a killed run is recognised"
    );
    assert_eq!(content(home.path().join("notes.txt")), "mine");
    // The lock went with its process.
    done(&quick(home.path()));
    assert_eq!(strangers(home.path()), ["notes.txt"]);
}

#[test]
fn what_killed_runs_have_left_is_swept_and_what_is_being_written_is_not() {
    let home = folder();
    fs::create_dir_all(home.path().join("gaps")).expect("made");
    let left = [".tackscope-abcdef", "gaps/.tackscope-ghijkl"].map(|name| home.path().join(name));
    let alive = home.path().join(".tackscope-alive1");
    for path in left.iter().chain([&alive]) {
        fs::write(path, "half").expect("written");
    }
    let held = File::options().write(true).open(&alive).expect("open");
    held.lock().expect("locked");
    done(&quick(home.path()));
    assert!(left.iter().all(|path| !path.exists()) && alive.exists());
    drop(held);
    done(&quick(home.path()));
    assert!(!alive.exists());
}

#[test]
fn a_full_disk_is_noticed_before_the_computation() {
    let home = folder();
    let out = home.path().join("out");
    // No file may grow beyond 64 kB.
    let command = format!(
        "trap '' XFSZ; ulimit -f 128; exec {} run fig2 --out {}",
        env!("CARGO_BIN_EXE_tackscope"),
        out.display()
    );
    let output = Command::new("sh")
        .args(["-c", &command])
        .output()
        .expect("sh runs");
    refuses(&output, &["cannot be written", "MB are needed"]);
    assert_eq!(fs::read_dir(&out).expect("listed").count(), 0);
}

#[test]
fn a_standard_output_that_is_full_is_a_failure_and_a_closed_pipe_is_none() {
    let home = folder();
    let out = home.path().display().to_string();
    let run = ["run", "no-hysteresis", "--points", "8", "--out", &out];
    for arguments in [
        &["presets"][..],
        &["--help"],
        &["--version"],
        &["table", "1", "--out", &out],
        &run,
    ] {
        let full = File::options()
            .write(true)
            .open("/dev/full")
            .expect("/dev/full");
        let output = tackscope()
            .args(arguments)
            .stdout(full)
            .stderr(Stdio::piped())
            .output()
            .expect("runs");
        let told = errors(&output);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {told}");
        assert_eq!(
            told.lines()
                .filter(|line| line.contains("standard output: cannot be written"))
                .count(),
            1,
            "{told}"
        );
        let mut piped = tackscope()
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("runs");
        drop(piped.stdout.take());
        assert_eq!(piped.wait().expect("ends").code(), Some(0), "{arguments:?}");
    }
    assert_eq!(summary(home.path())["stop"], "completed");
}

#[test]
fn where_nobody_hears_it_the_work_is_done_all_the_same() {
    let home = folder();
    let deaf = || {
        File::options()
            .write(true)
            .open("/dev/full")
            .expect("/dev/full")
    };
    let status = without_display(home.path())
        .stdout(Stdio::null())
        .stderr(deaf())
        .status()
        .expect("runs");
    assert_eq!(status.code(), Some(0));
    assert_eq!(
        summary(&home.path().join("tackscope-out"))["stop"],
        "completed"
    );
    for arguments in [
        &["run", "nowhere", "--out", "x"][..],
        &["figure", "99", "--out", "x"],
        &["--magic"],
    ] {
        let status = tackscope()
            .args(arguments)
            .current_dir(home.path())
            .stderr(deaf())
            .status()
            .expect("runs");
        assert_eq!(status.code(), Some(2), "{arguments:?}");
    }
}

#[test]
fn nothing_that_steers_a_terminal_or_spoils_an_svg_gets_out() {
    const EVIL: &str = "bad \u{1b}]0;owned\u{7} \u{9b}31m\u{202e}\n";
    let escaped = EVIL.trim_end().chars().map(|c| {
        if c == ' ' || c.is_ascii_graphic() {
            c.to_string()
        } else {
            c.escape_unicode().to_string()
        }
    });
    let escaped: String = escaped.collect();
    let toml = "bad \\u001b]0;owned\\u0007 \\u009b31m\\u202e\\ufffe\\n";
    let (scene, home) = fig2_with(&[
        ("title = ", &format!("title = \"{toml}\" #")),
        ("source = ", &format!("source = \"{toml}\" #")),
    ]);
    let out = home.path().join(EVIL);
    let named = home.path().join(format!("{EVIL}.toml"));
    fs::copy(&scene, &named).expect("copied");
    fs::write(
        home.path().join("broken.toml"),
        format!("format = 1\n'{}' = 3", EVIL.trim()),
    )
    .expect("written");
    let evil = named.display().to_string();
    let broken = home.path().join("broken.toml").display().to_string();
    let missing = format!("{evil}.gone");
    for arguments in [
        &["run", &evil][..],
        &["run", &broken],
        &["run", &missing],
        &["run", "fig2", "--points", EVIL],
        &["figure", EVIL],
        &[EVIL],
    ] {
        let mut command = tackscope();
        command.args(arguments);
        if arguments.len() > 1 {
            command.arg("--out").arg(&out);
        }
        let output = command.output().expect("runs");
        for text in
            [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).expect("UTF-8"))
        {
            assert!(
                text.chars()
                    .all(|c| c == '\n' || !c.is_control() && c != '\u{202e}' && c != '\u{fffe}'),
                "{text:?}"
            );
        }
    }
    let svg = content(out.join("loop.svg"));
    // The characters of XML 1.0.
    assert!(svg.chars().all(|c| matches!(c, '\t' | '\n' | '\r' | ' '..='\u{d7ff}' | '\u{e000}'..='\u{fffd}' | '\u{10000}'..)));
    assert!(
        svg.contains(&escaped) && svg.contains("\\u{fffe}"),
        "it stays visible what the title is"
    );
    assert_eq!(
        summary(&out)["scene"]["title"].as_str().expect("text"),
        EVIL.replace('\n', "\u{fffe}\n")
    );
}

#[test]
fn a_tilde_that_no_shell_has_replaced_is_the_home_folder_or_refused() {
    let (scene, home) = fig2_with(&[]);
    fs::rename(&scene, home.path().join("mine.toml")).expect("moved");
    let place = folder();
    let go = |scene: &str, out: &str| {
        let mut command = tackscope();
        command.env("HOME", home.path()).current_dir(place.path());
        command
            .args(["run", scene, "--quiet", "--points", "16", "--out", out])
            .output()
            .expect("runs")
    };
    let output = go("~/mine.toml", "~/results");
    done(&output);
    assert_eq!(summary(&home.path().join("results"))["stop"], "completed");
    for (scene, out) in [
        ("fig2", "~nobody/results"),
        ("~nobody/mine.toml", "results"),
        ("fig2", ""),
    ] {
        let output = go(scene, out);
        assert_eq!(output.status.code(), Some(2));
        let told = errors(&output);
        assert!(
            told.contains("write the path out")
                || told.contains("give the path")
                || told.contains("required"),
            "{told}"
        );
    }
    assert_eq!(fs::read_dir(place.path()).expect("listed").count(), 0);
    let output = go("fig2", "./~");
    done(&output);
    assert!(
        place.path().join("~").is_dir(),
        "a name that begins so can be had"
    );
}

#[test]
fn a_budget_that_is_none_is_refused_before_anything_is_made() {
    for seconds in ["-5", "nan", "inf", "0", "1e300", "many"] {
        let home = folder();
        let out = home.path().join("out");
        let budget = format!("--seconds={seconds}");
        let output = perform(&["chart", "fig2", &budget], &out);
        assert_eq!(output.status.code(), Some(2));
        says(
            &errors(&output),
            &["--seconds", seconds, "a number above 0"],
        );
        assert!(!out.exists());
    }
}

#[test]
fn progress_in_any_unit_of_length_tells_states_apart() {
    let preset = storage::resolve("no-hysteresis").expect("built in");
    let home = folder();
    for unit in [1e-9, 1.0, 1e12] {
        let mut scene = preset.clone();
        scene.cell.length *= unit;
        scene.law.surface_energy *= unit;
        if let Range::Length(range) = &mut scene.law.range {
            *range *= unit;
        }
        scene.drive.start *= unit;
        scene.drive.step *= unit;
        if let Turn::At(turn) = &mut scene.drive.turn {
            *turn *= unit;
        }
        let path = home.path().join("scaled.toml");
        scene_file::save(&path, &scene).expect("saved");
        let told = errors(&run(
            &path.display().to_string(),
            &home.path().join("out"),
            &[],
        ));
        let mut places: Vec<&str> = told
            .lines()
            .filter_map(|line| line.split("approach at u0 = ").nth(1)?.split(':').next())
            .collect();
        let all = places.len();
        places.dedup();
        assert!(
            all >= 4 && places.len() == all && places.iter().all(|place| place.len() < 16),
            "{told}"
        );
    }
}
