//! The real binary, started, listened to and stopped.
#![allow(dead_code, reason = "each test file uses its part")]

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, ChildStderr, Command, Output, Stdio};
use tackscope::storage::presets;
use tempfile::TempDir;

/// Holds a sentence to name each of these parts.
#[track_caller]
pub fn says(sentence: &str, parts: &[&str]) {
    for part in parts {
        assert!(
            sentence.contains(part),
            "{part:?} is missing in: {sentence}"
        );
    }
}

pub fn tackscope() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tackscope"));
    command.stdin(Stdio::null());
    command
}

pub fn folder() -> TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

pub fn run(scene: &str, out: &Path, more: &[&str]) -> Output {
    tackscope()
        .args(["run", scene, "--out"])
        .arg(out)
        .args(more)
        .output()
        .expect("the binary runs")
}

/// Holds a run to have ended with this code; what it told.
#[track_caller]
pub fn ended(output: &Output, code: i32) -> String {
    let told = errors(output);
    assert_eq!(output.status.code(), Some(code), "{told}");
    told
}

/// What a run wrote to the standard output.
pub fn said(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).expect("UTF-8")
}

pub fn errors(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).expect("UTF-8")
}

pub fn summary(folder: &Path) -> serde_json::Value {
    serde_json::from_str(&fs::read_to_string(folder.join("summary.json")).expect("summary.json"))
        .expect("JSON")
}

/// The path of a scene file in a folder of its own: Fig. 2, in which the beginnings of lines are
/// replaced.
pub fn fig2_with(replacements: &[(&str, &str)]) -> (String, TempDir) {
    let home = folder();
    let mut text = presets::find("fig2").expect("built in").text.to_owned();
    for (start, replacement) in replacements {
        assert!(text.contains(start), "{start}");
        text = text.replacen(start, replacement, 1);
    }
    let path = home.path().join("scene.toml");
    fs::write(&path, text).expect("written");
    (path.display().to_string(), home)
}

/// A run that is going on; killed if a test fails.
pub struct Running {
    child: Child,
    told: BufReader<ChildStderr>,
}

impl Running {
    pub fn start(scene: &str, out: &Path, more: &[&str]) -> Self {
        let mut command = tackscope();
        command.args(["run", scene, "--out"]).arg(out).args(more);
        Self::spawn(command)
    }

    pub fn spawn(mut command: Command) -> Self {
        let mut child = command
            .stderr(Stdio::piped())
            .stdout(Stdio::null())
            .spawn()
            .expect("the binary runs");
        let told = BufReader::new(child.stderr.take().expect("a pipe"));
        Self { child, told }
    }

    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// The next line that it tells.
    pub fn line(&mut self) -> String {
        let mut line = String::new();
        self.told.read_line(&mut line).expect("a line");
        line
    }

    pub fn signal(&self, name: &str) {
        let sent = Command::new("kill")
            .args([&format!("-{name}"), &self.id().to_string()])
            .status()
            .expect("kill runs");
        assert!(sent.success(), "it has ended before {name}");
    }

    pub fn is_going(&mut self) -> bool {
        self.child.try_wait().expect("asked").is_none()
    }

    /// Exit code and the rest of what it told.
    pub fn end(mut self) -> (Option<i32>, String) {
        let mut rest = String::new();
        self.told.read_to_string(&mut rest).expect("text");
        (self.child.wait().expect("it ends").code(), rest)
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
