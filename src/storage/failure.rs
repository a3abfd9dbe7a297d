//! What can go wrong between the program and its files, in sentences; and the one rule by which
//! somebody else's words (titles, sources, file names) enter a sentence, a terminal, a picture or a
//! page.

use std::path::Path;

/// Longest piece of somebody else's text that is quoted in a sentence, in characters.
const QUOTE_MAX: usize = 60;

/// A file that cannot be used, said in one sentence with its remedy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Failure {
    /// A value of a file is not allowed.
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
    /// A file lacks something.
    #[error("{file}: {key} is missing: {allowed}")]
    Missing {
        /// The scene file.
        file: String,
        /// Dotted key, or a table in brackets.
        key: String,
        /// What to write.
        allowed: String,
    },
    /// A file has a key or table that means nothing.
    #[error("{file}: {key} is not a key of this file{near}: allowed in {place}: {allowed}")]
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
    /// A file is not TOML.
    #[error(
        "{file}, line {line}, column {column}: not TOML ({message}): mend this line, as in length \
         = 256.0"
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
    /// A file cannot be read, or not as what it should be; it cannot be written; or what was typed is
    /// no path.
    #[error("{file}: {what} ({reason}): {remedy}")]
    File {
        /// The file.
        file: String,
        /// What is the matter with it.
        what: &'static str,
        /// Why.
        reason: String,
        /// How to mend it.
        remedy: String,
    },
    /// A word names neither a preset nor a file.
    #[error(
        "{name}: no such preset or scene file{near}: give the path of a file, or a preset: \
         {presets}"
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

    /// A value that is not allowed; `file` is where it stands, `allowed` a clause.
    pub fn value(file: &str, key: &str, value: &str, allowed: &str) -> Self {
        Self::Value {
            file: file.to_owned(),
            key: key.to_owned(),
            value: value.to_owned(),
            allowed: allowed.to_owned(),
        }
    }

    /// A file that cannot be read, or not as what it should be.
    pub(super) fn unreadable(path: &Path, reason: &str, remedy: &str) -> Self {
        Self::file(path, "cannot be read", reason, remedy)
    }

    /// A file too long for a scene, which may have `limit` bytes.
    pub(super) fn too_long(path: &Path, limit: u64) -> Self {
        let remedy = "a scene file is a page of text; check that this is one";
        Self::unreadable(path, &format!("longer than {limit} bytes"), remedy)
    }

    /// A path that is not to be written to.
    pub fn refused(path: &Path, reason: &str, remedy: &str) -> Self {
        Self::file(path, "cannot be written", reason, remedy)
    }

    /// What was typed is no path.
    pub(super) fn no_path(path: &Path, reason: &str, remedy: &str) -> Self {
        Self::file(path, "is no path here", reason, remedy)
    }

    fn file(path: &Path, what: &'static str, reason: &str, remedy: &str) -> Self {
        Self::File {
            file: path.display().to_string(),
            what,
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

/// The text on one line: line breaks and tabs are spaces, and what has no sign of its own is
/// written by its number, as in `\u{1b}`. That is what could steer a terminal or spoil an XML text:
/// control characters, marks that turn the direction of writing, code points that are no
/// characters.
pub fn line(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\t' | '\n' | '\r' | '\u{2028}' | '\u{2029}' => out.push(' '),
            c if signless(c) => out.extend(c.escape_unicode()),
            c => out.push(c),
        }
    }
    out
}

fn signless(c: char) -> bool {
    let turns = matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    let no_character = u32::from(c) & 0xfffe == 0xfffe || matches!(c, '\u{fdd0}'..='\u{fdef}');
    c.is_control() || turns || no_character
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_steers_a_terminal_is_written_by_its_number() {
        assert_eq!(
            line("\u{1b}[31mred\u{7}\u{9b}"),
            "\\u{1b}[31mred\\u{7}\\u{9b}"
        );
        assert_eq!(line("one\ntwo\tthree\r"), "one two three ");
        assert_eq!(
            line("M\u{fc}ser \u{3c1}\u{303} \u{4e2d} \u{5d0} \u{1f600}"),
            "M\u{fc}ser \u{3c1}\u{303} \u{4e2d} \u{5d0} \u{1f600}"
        );
    }

    proptest! {
        #[test]
        fn whatever_comes_in_is_one_line_of_legal_xml_and_stays_what_it_is(
            text in any::<String>(),
            odd in "[\u{0}-\u{9f}\u{202e}\u{fffe}\u{ffff}\u{1fffe}a]*",
        ) {
            for text in [text, odd] {
                let once = line(&text);
                // The characters of XML 1.0, without its line breaks and the C1 controls.
                let legal = |c: char| {
                    matches!(c, ' '..='~' | '\u{a0}'..='\u{d7ff}' | '\u{e000}'..='\u{fffd}')
                        || c >= '\u{10000}'
                };
                prop_assert!(once.chars().all(legal), "{once:?}");
                prop_assert_eq!(line(&once), once.clone());
            }
        }
    }
}
