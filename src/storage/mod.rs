//! Floor 7: the only room that touches the file system.
//!
//! Scene files and studies are read and written ([`scene_file`], [`presets()`], [`study_file`]),
//! sessions of the window too ([`session`]), height files read ([`heights`]), results exported
//! ([`export`], [`fields`], [`summary`], [`picture`], [`drawing`]). Every file is written whole or
//! not at all, and one folder holds one run ([`files`]); everything that can go wrong is a
//! [`Failure`], one sentence that names the file and says how to mend it. May use `paper` and all
//! below it; computes nothing, opens no dialogs.

pub mod drawing;
pub mod export;
mod failure;
pub mod fields;
pub mod files;
pub mod heights;
pub mod picture;
pub mod scene_file;
pub mod session;
pub mod study_file;
pub mod summary;

/// The version of the program, in a release with the commit it was built from.
pub const VERSION: &str = env!("TACKSCOPE_VERSION");

use failure::near;
pub use failure::{Failure, line};
pub use files::{read_regular, remove};

use crate::follow::record::Direction;
use crate::physics::topography::Topography;
use crate::scene::Scene;
use std::path::Path;

/// The scene of a regular file, told by its content and not by its name.
///
/// # Errors
/// A file that cannot be read, or that holds no allowed scene.
pub fn open_scene(path: &Path) -> Result<Scene, Failure> {
    scene_in(path, files::read_regular(path, session::BYTES_MAX)?)
}

/// The scene in the bytes of a file.
///
/// # Errors
/// What holds no allowed scene.
fn scene_in(path: &Path, bytes: Vec<u8>) -> Result<Scene, Failure> {
    if picture::is_png(&bytes) {
        picture::scene_of(path, &bytes)
    } else if session::is_session(&bytes) {
        session::scene_of(path, &bytes)
    } else {
        scene_file::scene_of(path, bytes)
    }
}

/// What a file holds.
#[derive(Debug)]
pub enum Opened {
    /// A scene.
    Scene(Scene),
    /// The bytes of a session.
    Session(Vec<u8>),
    /// Measured heights.
    Heights(Topography),
}

/// The scene, session or heights of a regular file. A scene is a picture that holds one, a file
/// named `.toml`, or text with a line that begins with `format` or a bracket.
///
/// # Errors
/// A file that cannot be read, or that holds none of them.
pub fn open(path: &Path) -> Result<Opened, Failure> {
    let bytes = files::read_regular(path, session::BYTES_MAX)?;
    if picture::is_png(&bytes) {
        return match picture::session_in(&bytes) {
            Some(session) => Ok(Opened::Session(session.to_vec())),
            None => picture::scene_of(path, &bytes).map(Opened::Scene),
        };
    }
    let named = path
        .extension()
        .is_some_and(|end| end.eq_ignore_ascii_case("toml"));
    let is_key = |line: &str| line.starts_with("format") || line.starts_with('[');
    let has_keys = || std::str::from_utf8(&bytes).is_ok_and(|text| text.lines().any(is_key));
    if session::is_session(&bytes) {
        Ok(Opened::Session(bytes))
    } else if named || has_keys() {
        scene_file::scene_of(path, bytes).map(Opened::Scene)
    } else {
        heights::of_bytes(path, &bytes).map(Opened::Heights)
    }
}

/// A built-in scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Preset {
    /// The word of the command line and the menu.
    pub name: &'static str,
    /// Its scene file; the comment it opens with says what to look for.
    pub text: &'static str,
}

macro_rules! presets {
    ($($name:literal)*) => {
        const ALL: &[Preset] = &[$(Preset {
            name: $name,
            text: include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/presets/", $name, ".toml")),
        },)*];
    };
}

presets! { "fig2" "fig3" "no-hysteresis" "coarse-mesh" "ridge-line" "hertz" "wavy" "rough" "soft-machine" "thin-film" "rubber" }

/// Every preset, in the order of the menu.
pub fn presets() -> &'static [Preset] {
    ALL
}

/// The preset of this name.
pub fn preset(name: &str) -> Option<&'static Preset> {
    ALL.iter().find(|preset| preset.name == name)
}

/// The preset whose scene has this title.
pub fn preset_titled(title: &str) -> Option<&'static Preset> {
    ALL.iter().find(|preset| preset.title() == title)
}

/// What the question of a preset begins with.
const QUESTION: &str = "Question:";

/// The small pictures of all loops, as the example `thumbnails` prints them.
const THUMBNAILS: &str = include_str!("../../assets/thumbnails.csv");

/// The word of the command line for a scene that comes by standard input.
const STANDARD_INPUT: &str = "-";

/// What a word of the command line is called in a refusal.
pub fn place(word: &str) -> &str {
    if word == STANDARD_INPUT {
        "standard input"
    } else {
        word
    }
}

/// The scene that a word of the command line means: a preset's name, `-` for standard input, or
/// else the path of a scene file, of a picture that holds one, or of a session.
///
/// # Errors
/// A word that is neither or cannot be a path, or a file that is not an allowed scene.
pub fn resolve(word: &str) -> Result<Scene, Failure> {
    if let Some(preset) = preset(word) {
        return preset.scene();
    }
    if word == STANDARD_INPUT {
        return scene_file::received(place(word), std::io::stdin().lock());
    }
    let path = files::typed(Path::new(word))?;
    if path.exists() {
        return scene_in(&path, files::read_bytes(&path, session::BYTES_MAX)?);
    }
    Err(unknown(word))
}

/// The refusal of a word that is neither a preset nor a file.
fn unknown(word: &str) -> Failure {
    let names: Vec<_> = ALL.iter().map(|preset| preset.name).collect();
    Failure::NoScene {
        name: word.to_owned(),
        near: near(word, names.iter().copied()),
        presets: names.join(", "),
    }
}

impl Preset {
    /// Its scene.
    ///
    /// # Errors
    /// None for the built-in ones, as a test makes sure.
    pub fn scene(&self) -> Result<Scene, Failure> {
        scene_file::parse(self.text, &format!("presets/{}.toml", self.name))
    }

    /// The title in its file.
    pub fn title(&self) -> &'static str {
        let title = self
            .text
            .lines()
            .find_map(|line| line.strip_prefix("title = \"")?.strip_suffix('"'));
        title.unwrap_or_default()
    }

    /// The comment that its file opens with, as one paragraph.
    fn comment(&self) -> String {
        let comment = self.text.lines().map_while(|line| line.strip_prefix('#'));
        comment.map(str::trim).collect::<Vec<_>>().join(" ")
    }

    /// What to look for, with these words: the comment up to its question.
    pub fn hint(&self) -> String {
        let comment = self.comment();
        let hint = comment.split(QUESTION).next().unwrap_or_default();
        hint.trim_end().to_owned()
    }

    /// The question that it asks: the end of the comment.
    pub fn question(&self) -> String {
        let comment = self.comment();
        let question = comment.split_once(QUESTION).map(|(_, words)| words);
        question.unwrap_or_default().trim().to_owned()
    }

    /// Its loop as a small picture: along each direction places (u0, stress) in shares of what they
    /// span. Empty for a preset without one.
    pub fn thumbnail(&self) -> Vec<(Direction, Vec<[f32; 2]>)> {
        let rows = THUMBNAILS.lines().filter_map(|row| {
            let mut cells = row.split(',');
            let mut next = || cells.next();
            let is_its_own = next()? == self.name;
            let direction = next()?;
            let at = [next()?.parse().ok()?, next()?.parse().ok()?];
            is_its_own.then_some((direction, at))
        });
        let rows: Vec<(&str, [f32; 2])> = rows.collect();
        Direction::BOTH
            .map(|direction| {
                let of = rows
                    .iter()
                    .filter(|(word, _)| *word == direction.to_string());
                (direction, of.map(|(_, at)| *at).collect())
            })
            .into()
    }

    /// The same without these words, as a sentence of its own.
    pub fn look_for(&self) -> String {
        let hint = self.hint();
        let words = hint
            .split_once(": ")
            .map_or(hint.as_str(), |(_, words)| words);
        let mut rest = words.chars();
        rest.next()
            .map(|first| first.to_uppercase().chain(rest).collect())
            .unwrap_or_default()
    }
}
