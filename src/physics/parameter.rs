//! Numbers that people give: the key in a scene file, what they mean, and the range in which they
//! are allowed.
//!
//! A law or a ground lists its own ([`Own`]): the reader and the writer of scene files, the checks,
//! the control panel and the guide's table iterate over that list. Ranges are wide: they keep
//! squares, products and counts finite, and refuse nothing that can be computed.

use std::ops::RangeInclusive;

/// A value that is not allowed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{key} = {value}: {allowed}")]
pub struct Refusal {
    /// Dotted key, as in `cell.points`.
    pub key: String,
    /// The offending value.
    pub value: String,
    /// What is allowed, and so how to mend it.
    pub allowed: String,
}

impl Refusal {
    /// Of a value of `key`; `allowed` is a clause.
    pub fn new(key: &str, value: impl std::fmt::Display, allowed: &str) -> Self {
        Self {
            key: key.to_owned(),
            value: value.to_string(),
            allowed: format!("allowed is {allowed}"),
        }
    }
}

/// A number of the scene file.
#[derive(Debug)]
pub struct Parameter {
    /// Dotted key, as in `cell.length`.
    pub key: &'static str,
    /// Its name for people.
    pub label: &'static str,
    /// Its letter.
    pub symbol: &'static str,
    /// What it is a number of.
    pub unit: Dimension,
    /// Least and greatest value.
    pub range: RangeInclusive<f64>,
    /// What it is where the file does not say; `None` where it must.
    pub default: Option<Value>,
    /// What is allowed, with an example; `{range}` stands for the range in words.
    pub hint: &'static str,
}

/// What a number is a number of: powers of the contact modulus E* and of a length, or neither.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// A pure number, or one in a unit of its own, which it names.
    Pure(&'static str),
    /// A length.
    Length,
    /// A stress or a modulus: E*.
    Stress,
    /// An energy per area: E* times length.
    SurfaceEnergy,
    /// A stiffness per area: E* per length.
    Stiffness,
    /// What the machine drives: a length, or the stress of a load.
    Driven,
    /// An energy: E* times volume.
    Energy,
    /// A force: E* times area.
    Force,
}

impl Dimension {
    /// In words, with E* = 1; empty for a pure number.
    pub fn word(self) -> &'static str {
        match self {
            Self::Pure(unit) => unit,
            Self::Length => "length",
            Self::Stress => "E*",
            Self::SurfaceEnergy => "E* times length",
            Self::Stiffness => "E* per length",
            Self::Driven => "length, or E* of a load",
            Self::Energy => "E* times volume",
            Self::Force => "E* times area",
        }
    }

    /// The powers of E* and of a length; what is driven counts as a length.
    pub fn powers(self) -> [i32; 2] {
        match self {
            Self::Pure(_) => [0, 0],
            Self::Length | Self::Driven => [0, 1],
            Self::Stress => [1, 0],
            Self::SurfaceEnergy => [1, 1],
            Self::Stiffness => [1, -1],
            Self::Energy => [1, 3],
            Self::Force => [1, 2],
        }
    }
}

/// The value of a parameter, of the kind that it takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// Any number.
    Number(f64),
    /// A whole number, all of whose digits count.
    Whole(u64),
    /// One count along x and one along y.
    Counts([usize; 2]),
    /// Yes or no.
    Flag(bool),
    /// One of some words.
    Choice {
        /// Which of them.
        chosen: usize,
        /// The words, in the order of lists.
        words: &'static [&'static str],
    },
}

/// What a law or a ground has of its own. One without parameters needs no more than a default.
pub trait Own: Default {
    /// Its parameters.
    const PARAMETERS: &'static [Parameter] = &[];

    /// Their values, in that order; of the same kinds whatever they are.
    fn values(&self) -> Vec<Value> {
        Vec::new()
    }

    /// The same with these values, as many and of the same kinds as [`Own::values`].
    fn with(&self, _values: &[Value]) -> Self {
        Self::default()
    }

    /// Checks what ties its values together; each alone is in its range.
    ///
    /// # Errors
    /// The first value that is not allowed beside the others.
    fn check(&self) -> Result<(), Refusal> {
        Ok(())
    }
}

/// Lengths, in any unit: their squares stay far from overflow and underflow.
pub const LENGTHS: RangeInclusive<f64> = 1e-110..=1e110;
/// The largest number below 1.
pub const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;
/// What a positive number is called.
pub const POSITIVE: &str = "a finite number above 0, {range}";
/// The largest integer of TOML, 2^63 - 1, as near as a double comes to it.
pub const SEED_MAX: f64 = i64::MAX as f64;

impl Parameter {
    /// The last part of the key, as it stands inside its table.
    pub fn name(&self) -> &'static str {
        self.key.rsplit('.').next().unwrap_or(self.key)
    }

    /// Its name with its letter.
    pub fn title(&self) -> String {
        format!("{} {}", self.label, self.symbol)
            .trim_end()
            .to_owned()
    }

    /// What is allowed, in words.
    pub fn allowed(&self) -> String {
        let range = format!(
            "from {} to {}",
            number(*self.range.start()),
            number(*self.range.end())
        );
        self.hint.replace("{range}", &range)
    }

    /// The value itself.
    ///
    /// # Errors
    /// A value that is out of range, or no number.
    pub fn check(&self, value: Value) -> Result<Value, Refusal> {
        let inside = match value {
            Value::Number(x) => self.range.contains(&x),
            Value::Whole(n) => self.range.contains(&(n as f64)),
            Value::Counts(both) => both.iter().all(|n| self.range.contains(&(*n as f64))),
            Value::Flag(_) | Value::Choice { .. } => true,
        };
        if inside {
            Ok(value)
        } else {
            Err(self.refuse(value))
        }
    }

    /// The refusal of a value.
    pub fn refuse(&self, value: impl std::fmt::Display) -> Refusal {
        Refusal::new(self.key, value, &self.allowed())
    }
}

impl std::fmt::Display for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Value::Number(x) => f.write_str(&number(*x)),
            Value::Whole(n) => n.fmt(f),
            Value::Counts(both) => write!(f, "{both:?}"),
            Value::Flag(flag) => flag.fmt(f),
            Value::Choice { chosen, words } => write!(f, "\"{}\"", words[*chosen]),
        }
    }
}

impl Value {
    /// A number; NaN if it is of another kind.
    pub(crate) fn number(self) -> f64 {
        if let Value::Number(x) = self {
            x
        } else {
            f64::NAN
        }
    }

    /// A whole number; 0 if it is of another kind.
    pub(crate) fn whole(self) -> u64 {
        if let Value::Whole(n) = self { n } else { 0 }
    }

    /// Yes or no; no if it is of another kind.
    pub(crate) fn flag(self) -> bool {
        self == Value::Flag(true)
    }

    /// Which of its words; the first if it is of another kind.
    pub(crate) fn chosen(self) -> usize {
        if let Value::Choice { chosen, .. } = self {
            chosen
        } else {
            0
        }
    }
}

/// A number as people write it.
pub fn number(x: f64) -> String {
    let size = x.abs();
    if x == SEED_MAX {
        i64::MAX.to_string()
    } else if size == 0.0 || (1e-3..1e10).contains(&size) {
        x.to_string()
    } else {
        format!("{x:e}")
    }
}

/// A parameter in a row: key, label, symbol, unit, range, default, hint.
macro_rules! parameter {
    ($key:expr, $label:expr, $symbol:expr, $unit:expr, $range:expr, $default:expr, $hint:expr) => {
        $crate::physics::parameter::Parameter {
            key: $key,
            label: $label,
            symbol: $symbol,
            unit: $unit,
            range: $range,
            default: $default,
            hint: $hint,
        }
    };
}
pub(crate) use parameter;

/// [`Own`] of a type whose fields are its parameters: of each the field, the kind of its value and
/// its row. After them come the methods that it has otherwise.
macro_rules! own {
    ($name:ident { $($field:ident: $kind:ident = $($row:expr),*;)* } $($method:item)*) => {
        impl $crate::physics::parameter::Own for $name {
            const PARAMETERS: &'static [$crate::physics::parameter::Parameter] =
                &[$($crate::physics::parameter::parameter!($($row),*),)*];

            fn values(&self) -> Vec<$crate::physics::parameter::Value> {
                vec![$($crate::physics::parameter::Value::$kind(self.$field),)*]
            }

            fn with(&self, values: &[$crate::physics::parameter::Value]) -> Self {
                let mut values = values.iter();
                $(let $field = match values.next() {
                    Some($crate::physics::parameter::Value::$kind(value)) => *value,
                    _ => self.$field,
                };)*
                Self { $($field,)* }
            }

            $($method)*
        }
    };
}
pub(crate) use own;

/// An enum of kinds, each a type of its own with an [`Own`]: its word, its parameters and their
/// values come from there. A `method` gives what all kinds have in common, a trait. Kinds in
/// brackets have no [`Own`].
macro_rules! kinds {
    ($(#[$doc:meta])* $name:ident: $method:ident -> $trait:ident [$($unit:ident = $unit_word:literal),*] $($file:ident::$kind:ident = $word:literal),*) => {
        $(pub use $file::$kind;)*

        $(#[$doc])*
        pub enum $name {
            $(#[doc = concat!("`", $unit_word, "`.")] $unit,)*
            $(#[doc = concat!("`", $word, "`.")] $kind($kind),)*
        }

        impl $name {
            /// What all kinds have in common.
            pub fn $method(&self) -> &dyn $trait {
                match self { $(Self::$unit => &$unit,)* $(Self::$kind(own) => own,)* }
            }

            /// Every kind with its default parameters, in the order of lists.
            pub fn all() -> Vec<Self> {
                vec![$(Self::$unit,)* $(Self::$kind($kind::default()),)*]
            }

            /// The word of the scene file.
            pub fn word(&self) -> &'static str {
                match self { $(Self::$unit => $unit_word,)* $(Self::$kind(_) => $word,)* }
            }

            /// What only this kind has.
            pub fn parameters(&self) -> &'static [Parameter] {
                match self { $(Self::$unit => &[],)* $(Self::$kind(_) => $kind::PARAMETERS,)* }
            }

            /// Their values, in that order.
            pub fn values(&self) -> Vec<Value> {
                match self { $(Self::$unit => Vec::new(),)* $(Self::$kind(own) => own.values(),)* }
            }

            /// The same kind with other values, as many and of the same kinds.
            pub fn with(&self, values: &[Value]) -> Self {
                match self { $(Self::$unit => Self::$unit,)* $(Self::$kind(own) => Self::$kind(own.with(values)),)* }
            }

            /// Checks what ties its values together.
            ///
            /// # Errors
            /// The first value that is not allowed beside the others.
            pub fn check(&self) -> Result<(), Refusal> {
                match self { $(Self::$unit => Ok(()),)* $(Self::$kind(own) => own.check(),)* }
            }
        }
    };
}
pub(crate) use kinds;
