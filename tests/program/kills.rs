//! A run that is ended at any moment, by any signal, leaves a folder that holds one run and says
//! whether it was finished.
//!
//! `TACKSCOPE_KILLS` says how often it is tried (20 if not given); the table is printed with
//! `--nocapture`.
//!
//! And requests from outside to end: what is computed is written, whoever asks and however often.
#![cfg(unix)]

use crate::binary::{Running, content, fig2_with, folder, says, summary, tackscope};
use rand::{Rng, SeedableRng};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::{Duration, Instant};
use tackscope::storage::export::CHART_COLUMNS;
use tackscope::storage::open_scene;

const SIGNALS: [&str; 4] = ["INT", "TERM", "HUP", "KILL"];
/// Folders that take turns, so that there is an earlier run in each.
const FOLDERS: usize = 3;

/// What a folder says of itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Standing {
    Empty,
    Unfinished,
    Cancelled,
    Finished,
}

/// The start of the drive of a run, which tells the runs apart.
fn start(run: usize) -> f64 {
    4.2 + 1e-3 * run as f64
}

/// A scene whose every result tells which run it is of.
fn scene(run: usize) -> (String, tempfile::TempDir) {
    let (title, range) = (
        format!("title = \"run {run}.\" #"),
        format!("range = {} #", 1.0 + 1e-4 * run as f64),
    );
    fig2_with(&[
        ("title = ", &title),
        ("start = ", &format!("start = {} #", start(run))),
        ("range = ", &range),
    ])
}

fn run_in_title(title: &str) -> usize {
    let number = title
        .split("run ")
        .nth(1)
        .and_then(|rest| rest.split('.').next());
    number
        .and_then(|number| number.parse().ok())
        .unwrap_or_else(|| panic!("no run in {title:?}"))
}

/// Rows of a table, each with as many cells as its heading.
fn rows(path: &Path) -> Vec<Vec<String>> {
    let text = content(path);
    assert!(text.ends_with('\n'), "{} is torn", path.display());
    let mut lines = text
        .lines()
        .map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
    let columns = lines.next().expect("a heading").len();
    lines
        .inspect(|cells| {
            assert!(
                cells.len() >= columns,
                "{} is torn: {cells:?}",
                path.display()
            );
        })
        .collect()
}

/// How many states and jumps the tables hold, which are of one run; that run is added to `runs`.
fn counted(states: &Path, jumps: &Path, runs: &mut BTreeSet<usize>) -> [usize; 2] {
    let mut counts = [0; 2];
    let states = rows(states);
    counts[0] = states.len();
    // Ended before its first state, a run has none.
    runs.extend(states.first().map(|first| {
        let u0: f64 = first[1].parse().expect("a number");
        ((u0 - start(0)) / 1e-3).round() as usize
    }));
    if jumps.exists() {
        let at: BTreeSet<&str> = states.iter().map(|state| state[1].as_str()).collect();
        let jumps = rows(jumps);
        counts[1] = jumps.len();
        assert!(
            jumps.iter().all(|jump| at.contains(jump[1].as_str())),
            "jumps of another run than the states"
        );
    }
    counts
}

/// What the summary says; all that it promises is there.
fn told_standing(
    told: &serde_json::Value,
    folder: &Path,
    counts: [usize; 2],
    pictures: usize,
) -> Standing {
    let standing = match told["stop"].as_str() {
        Some("running") => Standing::Unfinished,
        Some("cancelled") => Standing::Cancelled,
        Some("completed") => Standing::Finished,
        other => panic!("stop = {other:?}"),
    };
    assert_eq!(told["completed"], standing == Standing::Finished);
    if standing != Standing::Unfinished {
        assert!(
            ["loop.csv", "events.csv", "loop.svg", "loop.png"]
                .iter()
                .all(|name| folder.join(name).exists()),
            "something is missing"
        );
        assert_eq!(
            [&told["counts"]["states"], &told["counts"]["jumps"]],
            counts.map(serde_json::Value::from).each_ref()
        );
    }
    if standing == Standing::Finished {
        assert!(
            counts[1] > 0 && pictures > 5,
            "{counts:?}, {pictures} pictures",
        );
    }
    standing
}

/// What the folder says, and of which run it is; every file in it is looked into.
fn look(folder: &Path, killed: bool) -> (Standing, Option<usize>) {
    let mut runs = BTreeSet::new();
    let mut pictures: Vec<PathBuf> = Vec::new();
    for inner in [folder.to_owned(), folder.join("gaps")] {
        for entry in fs::read_dir(inner).into_iter().flatten() {
            let path = entry.expect("an entry").path();
            let name = path
                .file_name()
                .and_then(|name| name.to_str())
                .expect("UTF-8")
                .to_owned();
            assert!(killed || !name.starts_with('.'), "{name} is left");
            if path.extension().is_some_and(|end| end == "png") {
                pictures.push(path);
            }
        }
    }
    for path in &pictures {
        // A picture gets its scene in a second step.
        match open_scene(path) {
            Ok(scene) => drop(runs.insert(run_in_title(&scene.title))),
            Err(failure) => assert!(
                killed && failure.to_string().contains("there is no scene"),
                "{failure}"
            ),
        }
        assert!(image::open(path).is_ok(), "{} is torn", path.display());
    }
    let [states, jumps, svg, summary] =
        ["loop.csv", "events.csv", "loop.svg", "summary.json"].map(|name| folder.join(name));
    let mut counts = [0; 2];
    if states.exists() {
        counts = counted(&states, &jumps, &mut runs);
    } else {
        assert!(killed || !jumps.exists());
    }
    if svg.exists() {
        let text = content(&svg);
        assert!(text.trim_end().ends_with("</svg>"), "loop.svg is torn");
        runs.insert(run_in_title(&text));
    }
    let mut standing = if runs.is_empty() {
        Standing::Empty
    } else {
        Standing::Unfinished
    };
    if let Ok(text) = fs::read_to_string(&summary) {
        let told: serde_json::Value = serde_json::from_str(&text).expect("summary.json is torn");
        runs.insert(run_in_title(
            told["scene"]["title"].as_str().expect("a title"),
        ));
        standing = told_standing(&told, folder, counts, pictures.len());
    }
    assert!(
        runs.len() <= 1,
        "{}: files of the runs {runs:?}",
        folder.display()
    );
    (standing, runs.first().copied())
}

#[test]
fn whenever_a_run_is_killed_its_folder_is_one_runs_and_says_whether_it_was_finished() {
    let count: usize =
        std::env::var("TACKSCOPE_KILLS").map_or(20, |count| count.parse().expect("a number"));
    let home = folder();
    let place = |k: usize| home.path().join(format!("{}", k % FOLDERS));
    let go = |k: usize| {
        let (path, kept) = scene(k);
        (
            Running::start(
                &path,
                &place(k),
                &["--quiet", "--model", "quarter", "--points", "48"],
            ),
            kept,
        )
    };
    let all_finish = || {
        for k in 0..FOLDERS {
            let (running, _kept) = go(k);
            assert_eq!(running.end().0, Some(0));
            assert_eq!(look(&place(k), false), (Standing::Finished, Some(k)));
        }
    };
    // How long it takes where nobody disturbs it.
    let began = Instant::now();
    all_finish();
    let whole = began.elapsed() / FOLDERS as u32;
    let mut chance = rand_pcg::Pcg64::seed_from_u64(count as u64);
    let mut table: BTreeMap<(usize, &str), usize> = BTreeMap::new();
    for k in FOLDERS..FOLDERS + count {
        let (signal, before) = (k % SIGNALS.len(), look(&place(k), true));
        let (mut running, _kept) = go(k);
        sleep(whole.mul_f64(chance.random_range(0.0..1.15)));
        if running.is_going() {
            running.signal(SIGNALS[signal]);
        }
        let (code, told) = running.end();
        let (standing, run) = look(&place(k), code.is_none());
        let what = match (code, standing) {
            (Some(0), Standing::Finished) => "was faster",
            (Some(130), Standing::Cancelled) => "cancelled, all written",
            // It heard the request when there was nothing left to cancel.
            (Some(130), Standing::Finished) => "was faster",
            (None, _) if (standing, run) == before => "killed before it began",
            (None, Standing::Empty | Standing::Unfinished) => "killed, unfinished",
            (None, Standing::Finished) => "killed after the end",
            _ => panic!("{} gave {code:?}, {standing:?}: {told}", SIGNALS[signal]),
        };
        assert!(
            run.is_none_or(|run| run == k || what.starts_with("killed") && Some(run) == before.1),
            "{what}: run {run:?}, not {k}"
        );
        *table.entry((signal, what)).or_default() += 1;
    }
    for ((signal, what), times) in &table {
        println!("{:5} {times:5}  {what}", SIGNALS[*signal]);
    }
    println!("all   {count:5}  a run takes {whole:.0?}");
    // Whatever was left is swept by the next run.
    all_finish();
}

/// A walk that takes much longer than a test.
const LONG: [&str; 6] = ["--points", "256", "--step", "0.0005", "--model", "whole"];

#[test]
fn every_request_to_end_writes_what_there_is_even_when_it_comes_twice() {
    for signals in [
        &["INT"][..],
        &["TERM"],
        &["HUP"],
        &["INT", "INT"],
        &["TERM", "TERM", "HUP", "INT"],
    ] {
        let home = folder();
        let out = home.path().join("out");
        let mut running = Running::start("fig2", &out, &LONG);
        running.line();
        sleep(Duration::from_millis(300));
        for signal in signals {
            running.signal(signal);
            // As far apart as `timeout` sends them, and much nearer than a second thought.
            sleep(Duration::from_millis(5));
            if !running.is_going() {
                break;
            }
        }
        let (code, told) = running.end();
        assert_eq!(code, Some(130), "{signals:?}: {told}");
        says(
            &told,
            &["cancelled at u0 = ", "interrupted; what was computed is in"],
        );
        let summary = summary(&out);
        assert_eq!(
            (&summary["stop"], &summary["completed"]),
            (&"cancelled".into(), &false.into())
        );
        assert_eq!(summary["dissipated_energy"], "not available");
        let states = summary["counts"]["states"].as_u64().expect("a count") as usize;
        assert!(states > 0);
        let written = |name: &str| content(out.join(name));
        assert_eq!(written("loop.csv").lines().count(), states + 1);
        assert!(written("loop.svg").contains("Loop not closed"));
        assert!(out.join("events.csv").exists() && out.join("loop.png").exists());
        assert!(!out.join(".tackscope.lock").exists());
    }
}

#[test]
fn a_signal_that_is_ignored_from_the_start_stays_ignored() {
    // As nohup and a background job of a script begin.
    let home = folder();
    let mut command = std::process::Command::new("sh");
    command.args([
        "-c",
        "trap '' HUP INT; exec \"$@\"",
        "sh",
        env!("CARGO_BIN_EXE_tackscope"),
        "run",
        "fig2",
        "--out",
    ]);
    command.arg(home.path()).args(LONG);
    let mut running = Running::spawn(command);
    running.line();
    for signal in ["HUP", "INT"] {
        running.signal(signal);
        sleep(Duration::from_millis(300));
        assert!(running.is_going(), "{signal} was to be ignored");
    }
    running.signal("TERM");
    assert_eq!(running.end().0, Some(130));
    assert_eq!(summary(home.path())["stop"], "cancelled");
}

#[test]
fn an_interrupted_comparison_is_an_interruption_and_the_loop_stays() {
    for (option, second, word) in [
        ("--verify", "whole cell", "verification"),
        ("--yardstick", "gfmd", "yardstick"),
    ] {
        let home = folder();
        let mut running = Running::start(
            "fig2",
            home.path(),
            &[option, "--points", "128", "--step", "0.005"],
        );
        let first = running.line();
        let title = first.split(':').next().expect("a title").to_owned();
        while !{
            let line = running.line();
            assert!(!line.is_empty(), "{option}: it ended");
            line.starts_with(&title)
        } {}
        running.signal("INT");
        let (code, told) = running.end();
        assert_eq!(code, Some(130), "{option} ({second}): {told}");
        says(
            &told,
            &[&format!(
                "interrupted before the {word} was done; the loop itself is complete"
            )],
        );
        let summary = summary(home.path());
        assert_eq!(
            (&summary["stop"], &summary["measured_error"]),
            (&"completed".into(), &"not available".into())
        );
        assert!(home.path().join("loop.png").exists());
    }
}

#[test]
fn a_chart_that_is_asked_to_end_keeps_what_it_has_measured() {
    for signal in ["INT", "TERM"] {
        let home = folder();
        let mut command = tackscope();
        command.args(["chart", "fig3", "--out"]).arg(home.path());
        let mut running = Running::spawn(command);
        running.line();
        sleep(Duration::from_millis(700));
        running.signal(signal);
        let (code, told) = running.end();
        assert_eq!(code, Some(130), "{told}");
        says(&told, &["interrupted; what was measured is in"]);
        let written = |name: &str| content(home.path().join(name));
        let short: serde_json::Value = serde_json::from_str(&written("chart.json")).expect("JSON");
        assert_eq!(short["completed"], false);
        assert!(written("chart.csv").starts_with(CHART_COLUMNS));
        assert!(written("chart.svg").contains("Interrupted"));
    }
}
