//! What can go wrong between the program and its files.

use super::line;
use std::path::Path;

/// Longest piece of somebody else's text that is quoted in a sentence, in characters.
const QUOTE_MAX: usize = 60;

/// A file that cannot be used, said in one sentence with its remedy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Failure {
    /// A value of a scene file is not allowed.
    #[error("{file}: {key} = {value}: {allowed}")]
    Value {
        /// The scene file.
        file: String,
        /// Dotted key, as in `cell.points`.
        key: String,
        /// The offending value.
        value: String,
        /// What is allowed, and so how to mend it.
        allowed: String,
    },
    /// A scene file lacks something.
    #[error("{file}: {key} is missing: {allowed}")]
    Missing {
        /// The scene file.
        file: String,
        /// Dotted key, or a table in brackets.
        key: String,
        /// What to write.
        allowed: String,
    },
    /// A scene file has a key or table that means nothing.
    #[error("{file}: {key} is not a key of the scene file{near}: allowed in {place}: {allowed}")]
    UnknownKey {
        /// The scene file.
        file: String,
        /// Dotted key.
        key: String,
        /// ", did you mean ..." or nothing.
        near: String,
        /// The table in words.
        place: String,
        /// The keys that are allowed there.
        allowed: String,
    },
    /// A scene file is not TOML.
    #[error(
        "{file}, line {line}, column {column}: not TOML ({message}): mend this line, as in length = 256.0"
    )]
    Syntax {
        /// The scene file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column in characters, from 1.
        column: usize,
        /// What the parser says.
        message: String,
    },
    /// A file cannot be read, or is no scene file at all.
    #[error("{file}: cannot be read ({reason}): {remedy}")]
    Read {
        /// The file.
        file: String,
        /// Why.
        reason: String,
        /// How to mend it.
        remedy: String,
    },
    /// A file cannot be written.
    #[error("{file}: cannot be written ({reason}): {remedy}")]
    Write {
        /// The file.
        file: String,
        /// Why.
        reason: String,
        /// How to mend it.
        remedy: String,
    },
    /// What was typed is no path.
    #[error("{path}: is no path here ({reason}): {remedy}")]
    Path {
        /// What was typed.
        path: String,
        /// Why.
        reason: String,
        /// How to mend it.
        remedy: String,
    },
    /// A word names neither a preset nor a file.
    #[error(
        "{name}: no such preset or scene file{near}: give the path of a file, or a preset: {presets}"
    )]
    NoScene {
        /// The word.
        name: String,
        /// ", did you mean ..." or nothing.
        near: String,
        /// The presets.
        presets: String,
    },
}

impl Failure {
    /// A failure of the system to write `path`.
    pub fn write(path: &Path, reason: impl std::fmt::Display) -> Self {
        let remedy =
            "choose a folder that exists or can be made, that you may write to, with free space";
        Self::refused(path, &reason.to_string(), remedy)
    }

    /// A path that is not to be written to.
    pub fn refused(path: &Path, reason: &str, remedy: &str) -> Self {
        Self::Write {
            file: path.display().to_string(),
            reason: reason.to_owned(),
            remedy: remedy.to_owned(),
        }
    }
}

/// Somebody else's text on one line, cut at a readable length.
pub(super) fn quote(text: &str) -> String {
    let mut quoted = line(text);
    if let Some((end, _)) = quoted.char_indices().nth(QUOTE_MAX) {
        quoted.truncate(end);
        quoted.push_str("...");
    }
    quoted
}

/// ", did you mean X" where one of `candidates` is near `word`, else nothing.
pub(super) fn near<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    if word.len() > QUOTE_MAX {
        return String::new();
    }
    let scored = candidates
        .into_iter()
        .map(|candidate| (strsim::jaro_winkler(word, candidate), candidate));
    match scored.max_by(|a, b| a.0.total_cmp(&b.0)) {
        Some((score, candidate)) if score > 0.8 => format!(", did you mean {candidate}"),
        _ => String::new(),
    }
}
