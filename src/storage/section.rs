//! A file of tables (TOML) by a typed view of each, so that every refusal names the file, the key,
//! its value and what is allowed.

use super::Failure;
use super::failure::{near, quote};
use crate::physics::parameter::{Parameter, Value as Own};
use std::sync::LazyLock;
use toml::{Table, Value};

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
