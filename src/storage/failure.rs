//! What can go wrong between the program and its files, in sentences; the one rule by which
//! somebody else's words (titles, sources, file names) enter a sentence, a terminal, a picture or a
//! page; and a file of tables (TOML) by a typed view of each, so that every refusal names the file,
//! the key, its value and what is allowed.

use crate::physics::parameter::{Parameter, Value as Own};
use std::path::Path;
use std::sync::LazyLock;
use toml::{Table, Value};

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

/// The tables of a text; `file_name` is used in messages.
///
/// # Errors
/// What is not TOML.
pub(super) fn table(text: &str, file_name: &str) -> Result<Table, Failure> {
    text.parse()
        .map_err(|error| syntax(text, file_name, &error))
}

/// Where a text is not TOML, and why.
fn syntax(text: &str, file_name: &str, error: &toml::de::Error) -> Failure {
    let at = error.span().map_or(0, |span| span.start).min(text.len());
    let before = String::from_utf8_lossy(&text.as_bytes()[..at]);
    let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
    Failure::Syntax {
        file: file_name.to_owned(),
        line: before.matches('\n').count() + 1,
        column: before[line_start..].chars().count() + 1,
        message: error
            .message()
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" "),
    }
}

/// One table, with what an error needs to name its place.
pub(super) struct Section<'a> {
    pub(super) file: &'a str,
    name: &'a str,
    table: &'a Table,
}

impl<'a> Section<'a> {
    /// The file's own, outermost table.
    pub(super) fn root(file: &'a str, table: &'a Table) -> Self {
        Self {
            file,
            name: "",
            table,
        }
    }

    /// A table that is called `name` in messages.
    pub(super) fn of(file: &'a str, name: &'a str, table: &'a Table) -> Self {
        Self { file, name, table }
    }

    /// Its keys.
    pub(super) fn keys(&self) -> Vec<&'a str> {
        self.table.keys().map(String::as_str).collect()
    }

    /// Refuses every version of its format but this one, which is told of `what` it is.
    pub(super) fn format_version(&self, version: i64, what: &str) -> Result<(), Failure> {
        let first = format!("format = {version} as the first line of {what}");
        let value = self.value("format", &first)?;
        if value.as_integer() == Some(version) {
            return Ok(());
        }
        let allowed = format!("allowed is {version}, the only version that this program reads");
        Err(self.refuse("format", value, &allowed))
    }

    /// The table `[name]` inside this one, or `None` if it is not there.
    pub(super) fn inside(&self, name: &'static str) -> Result<Option<Section<'a>>, Failure> {
        match self.table.get(name) {
            None => Ok(None),
            Some(Value::Table(table)) => Ok(Some(Section {
                file: self.file,
                name,
                table,
            })),
            Some(other) => Err(self.refuse(name, other, &format!("allowed is a table, [{name}]"))),
        }
    }

    /// The table `[name]`; where it is not there everything in it has its default.
    pub(super) fn optional(&self, name: &'static str) -> Result<Section<'a>, Failure> {
        static NOTHING: LazyLock<Table> = LazyLock::new(Table::new);
        Ok(self.inside(name)?.unwrap_or(Section {
            file: self.file,
            name,
            table: &NOTHING,
        }))
    }

    /// The table `[name]`, which must be there.
    pub(super) fn required(&self, name: &'static str, keys: &str) -> Result<Section<'a>, Failure> {
        self.inside(name)?.ok_or_else(|| Failure::Missing {
            file: self.file.to_owned(),
            key: format!("[{name}]"),
            allowed: format!("add this table with {keys}"),
        })
    }

    /// Refuses every key that is not in `allowed`.
    pub(super) fn only(&self, allowed: &[&str]) -> Result<(), Failure> {
        match self
            .table
            .keys()
            .find(|key| !allowed.contains(&key.as_str()))
        {
            None => Ok(()),
            Some(key) => Err(Failure::UnknownKey {
                file: self.file.to_owned(),
                key: self.dotted(&quote(key)),
                near: near(key, allowed.iter().copied()),
                place: if self.name.is_empty() {
                    "its top level".to_owned()
                } else {
                    format!("[{}]", self.name)
                },
                allowed: allowed.join(", "),
            }),
        }
    }

    /// True if the key is there.
    pub(super) fn has(&self, key: &str) -> bool {
        self.table.contains_key(key)
    }

    /// The raw value, which must be there.
    pub(super) fn value(&self, key: &str, allowed: &str) -> Result<&'a Value, Failure> {
        self.table
            .get(key)
            .ok_or_else(|| self.missing(key, allowed))
    }

    /// The number of a parameter (an integer will do), or its default if it has one and is not
    /// there; the scene checks its range.
    pub(super) fn number(&self, parameter: &Parameter) -> Result<f64, Failure> {
        let key = parameter.name();
        match (self.table.get(key), parameter.default) {
            (None, Some(default)) => Ok(default.number()),
            (None, None) => Err(self.missing(key, &parameter.allowed())),
            (Some(value), _) => finite(value).ok_or_else(|| self.refuse_number(parameter, value)),
        }
    }

    /// The raw value of a parameter, which must be there.
    pub(super) fn given(&self, parameter: &Parameter) -> Result<&'a Value, Failure> {
        self.value(parameter.name(), &parameter.allowed())
    }

    /// The refusal of what a parameter cannot be.
    pub(super) fn refuse_number(&self, parameter: &Parameter, value: &Value) -> Failure {
        self.refuse(
            parameter.name(),
            value,
            &format!("allowed is {}", parameter.allowed()),
        )
    }

    /// A text.
    pub(super) fn text(&self, key: &str, allowed: &str) -> Result<&'a str, Failure> {
        let value = self.value(key, allowed)?;
        value
            .as_str()
            .ok_or_else(|| self.refuse(key, value, &format!("allowed is {allowed}")))
    }

    /// A text, or `default` if it is not there.
    pub(super) fn text_or(&self, key: &str, default: &str) -> Result<String, Failure> {
        if self.has(key) {
            self.text(key, "a text in quotes").map(str::to_owned)
        } else {
            Ok(default.to_owned())
        }
    }

    /// The flag of a parameter, or its default if it has one and is not there.
    pub(super) fn flag(&self, parameter: &Parameter) -> Result<bool, Failure> {
        match (self.table.get(parameter.name()), parameter.default) {
            (None, Some(default)) => Ok(default.flag()),
            (None, None) => Err(self.missing(parameter.name(), &parameter.allowed())),
            (Some(value), _) => value
                .as_bool()
                .ok_or_else(|| self.refuse_number(parameter, value)),
        }
    }

    /// Which of the words of a parameter, or its default if it has one and is not there.
    pub(super) fn choice(
        &self,
        parameter: &Parameter,
        words: &'static [&'static str],
    ) -> Result<Own, Failure> {
        let key = parameter.name();
        if let (false, Some(default)) = (self.has(key), parameter.default) {
            return Ok(default);
        }
        let word = self.text(key, &parameter.allowed())?;
        let chosen = words.iter().position(|known| *known == word);
        let chosen = chosen.ok_or_else(|| {
            let near = near(word, words.iter().copied());
            let allowed = format!("allowed is {}{near}", parameter.allowed());
            self.refuse(key, &Value::String(word.to_owned()), &allowed)
        })?;
        Ok(Own::Choice { chosen, words })
    }

    /// The refusal of a value; `allowed` is a clause.
    pub(super) fn refuse(&self, key: &str, value: &Value, allowed: &str) -> Failure {
        let value = quote(&value.to_string());
        Failure::value(self.file, &self.dotted(key), &value, allowed)
    }

    /// The refusal of a word that is none of `words`.
    pub(super) fn refuse_word(&self, key: &str, word: &str, words: &[&str]) -> Failure {
        let listed: Vec<_> = words.iter().map(|word| format!("\"{word}\"")).collect();
        let allowed = format!(
            "allowed are {}{}",
            listed.join(", "),
            near(word, words.iter().copied())
        );
        self.refuse(key, &Value::String(word.to_owned()), &allowed)
    }

    /// The complaint that a key is not there.
    pub(super) fn missing(&self, key: &str, allowed: &str) -> Failure {
        Failure::Missing {
            file: self.file.to_owned(),
            key: self.dotted(key),
            allowed: format!("allowed is {allowed}"),
        }
    }

    fn dotted(&self, key: &str) -> String {
        if self.name.is_empty() {
            key.to_owned()
        } else {
            format!("{}.{key}", self.name)
        }
    }
}

/// A value as a finite number.
pub(super) fn finite(value: &Value) -> Option<f64> {
    let number = match value {
        Value::Float(number) => *number,
        Value::Integer(number) => *number as f64,
        _ => return None,
    };
    number.is_finite().then_some(number)
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
