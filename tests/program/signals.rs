//! Requests from outside to end: what is computed is written, whoever asks and however often.
#![cfg(unix)]

use crate::binary::{Running, folder, summary, tackscope};
use std::fs;
use std::thread::sleep;
use std::time::Duration;

/// A walk that takes much longer than a test.
const LONG: [&str; 6] = ["--points", "256", "--step", "0.0005", "--model", "whole"];

#[test]
fn every_request_to_end_writes_what_there_is_even_when_it_comes_twice() {
    for signals in [
        &["TERM"][..],
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
        assert!(
            told.contains("interrupted; what was computed is in"),
            "{signals:?}: {told}"
        );
        let summary = summary(&out);
        assert_eq!(
            (&summary["stop"], &summary["completed"]),
            (&"cancelled".into(), &false.into())
        );
        let states = summary["counts"]["states"].as_u64().expect("a count") as usize;
        assert!(states > 0);
        assert_eq!(
            fs::read_to_string(out.join("loop.csv"))
                .expect("loop.csv")
                .lines()
                .count(),
            states + 1
        );
        assert!(out.join("loop.png").exists() && !out.join(".tackscope.lock").exists());
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
        assert!(
            told.contains(&format!(
                "interrupted before the {word} was done; the loop itself is complete"
            )),
            "{told}"
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
    let home = folder();
    let mut command = tackscope();
    command.args(["chart", "fig2", "--out"]).arg(home.path());
    let mut running = Running::spawn(command);
    running.line();
    running.signal("TERM");
    let (code, told) = running.end();
    assert_eq!(code, Some(130), "{told}");
    let short: serde_json::Value =
        serde_json::from_slice(&fs::read(home.path().join("chart.json")).expect("chart.json"))
            .expect("JSON");
    assert_eq!(short["completed"], false);
}
