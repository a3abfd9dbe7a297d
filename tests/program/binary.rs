//! The real binary, started, listened to and stopped.
#![allow(dead_code, reason = "each test file uses its part")]

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, ChildStderr, Command, Output, Stdio};
use tackscope::storage;
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

/// Where there is no display.
pub fn without_display(place: &Path) -> Command {
    let mut command = tackscope();
    for display in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
        command.env_remove(display);
    }
    command.current_dir(place);
    command
}

/// What it says to these words.
pub fn answer(words: &[&str]) -> String {
    done(&tackscope().args(words).output().expect("the binary runs"))
}

/// A command with the folder that it writes into.
pub fn command(words: &[&str], out: &Path) -> Command {
    let mut command = tackscope();
    command.args(words).arg("--out").arg(out);
    command
}

pub fn perform(words: &[&str], out: &Path) -> Output {
    command(words, out).output().expect("the binary runs")
}

pub fn run(scene: &str, out: &Path, more: &[&str]) -> Output {
    perform(&[&["run", scene], more].concat(), out)
}

/// What it says on standard output.
pub fn said(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).expect("UTF-8")
}

/// The same, all being well.
#[track_caller]
pub fn done(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(0), "{}", errors(output));
    said(output)
}

/// Holds it to have refused in one sentence that names each of these parts; the sentence.
#[track_caller]
pub fn refuses(output: &Output, parts: &[&str]) -> String {
    let sentence = errors(output);
    assert_eq!(output.status.code(), Some(2), "{sentence}");
    assert_eq!(sentence.lines().count(), 1, "{sentence}");
    says(&sentence, parts);
    sentence
}

/// The text of a file.
#[track_caller]
pub fn content(path: impl AsRef<Path>) -> String {
    fs::read_to_string(&path).unwrap_or_else(|why| panic!("{}: {why}", path.as_ref().display()))
}

pub fn is_png(path: &Path) -> bool {
    fs::read(path).is_ok_and(|bytes| bytes.starts_with(b"\x89PNG"))
}

pub fn errors(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).expect("UTF-8")
}

pub fn summary(folder: &Path) -> serde_json::Value {
    serde_json::from_str(&content(folder.join("summary.json"))).expect("JSON")
}

/// The path of a scene file in a folder of its own: Fig. 2, in which the beginnings of lines are
/// replaced.
pub fn fig2_with(replacements: &[(&str, &str)]) -> (String, TempDir) {
    with("fig2", replacements)
}

/// The same of another preset.
pub fn with(preset: &str, replacements: &[(&str, &str)]) -> (String, TempDir) {
    let home = folder();
    let path = home.path().join("scene.toml");
    fs::write(&path, text_with(preset, replacements)).expect("written");
    (path.display().to_string(), home)
}

/// The text of a preset in which the beginnings of lines are replaced.
#[track_caller]
pub fn text_with(preset: &str, replacements: &[(&str, &str)]) -> String {
    let text = storage::preset(preset).expect("built in").text.to_owned();
    replacements
        .iter()
        .fold(text, |text, (start, replacement)| {
            assert!(text.contains(start), "{start} is in {preset}");
            text.replacen(start, replacement, 1)
        })
}

/// A run that is going on; killed if a test fails.
pub struct Running {
    child: Child,
    told: BufReader<ChildStderr>,
}

impl Running {
    pub fn start(scene: &str, out: &Path, more: &[&str]) -> Self {
        Self::spawn(command(&[&["run", scene], more].concat(), out))
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
