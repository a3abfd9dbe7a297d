//! A typed view of one table of a scene file.

use crate::physics::parameter::Parameter;
use crate::storage::Failure;
use crate::storage::failure::{near, quote};
use std::sync::LazyLock;
use toml::{Table, Value};

/// One table, with what an error needs to name its place.
pub(super) struct Section<'a> {
    file: &'a str,
    name: &'static str,
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

    /// A table `[name]` that is not there: everything in it has its default.
    pub(super) fn empty(&self, name: &'static str) -> Section<'a> {
        static NOTHING: LazyLock<Table> = LazyLock::new(Table::new);
        Section {
            file: self.file,
            name,
            table: &NOTHING,
        }
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

    /// The refusal of a value; `allowed` is a clause.
    pub(super) fn refuse(&self, key: &str, value: &Value, allowed: &str) -> Failure {
        Failure::Value {
            file: self.file.to_owned(),
            key: self.dotted(key),
            value: quote(&value.to_string()),
            allowed: allowed.to_owned(),
        }
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
