//! Floor 6: lessons of about five minutes, each a value read from one text: what is said, asked and
//! done, the condition on the model that ends a task, and the explanation with the learner's
//! numbers.
//!
//! No drawing, files or threads: a window shows a lesson, and a session performs it
//! ([`Task::act`]). Lengths are told in ranges of the law, energies in units of gamma.

mod facts;
mod progress;

pub use facts::{Condition, Facts};
pub use progress::{Progress, Stage};

use serde::Deserialize;
use std::sync::LazyLock;

/// A lesson.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Lesson {
    /// Its word on the command line.
    #[serde(skip)]
    pub name: String,
    /// Its title.
    pub title: String,
    /// What it teaches, in a sentence.
    pub teaches: String,
    /// How long it takes.
    pub minutes: u32,
    /// Its steps in order.
    #[serde(rename = "step")]
    pub steps: Vec<Step>,
}

/// A step: a text, then a question, then a task, then an explanation; all but the text may be
/// missing.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Step {
    /// What is said first.
    pub text: String,
    /// The preset that is opened as the step begins.
    pub scene: Option<String>,
    /// What is hidden meanwhile.
    #[serde(default)]
    pub hide: Vec<Hidden>,
    /// The tab that is shown.
    pub tab: Option<String>,
    /// What is asked.
    pub question: Option<Question>,
    /// What is to be done.
    pub task: Option<Task>,
    /// What is said at the end; `{name}` stands for a number of the model, `{step2.name}` for what
    /// it was when the second step ended.
    #[serde(default)]
    pub explain: String,
}

/// What a step may hide.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Hidden {
    /// The panel with law, cell and mesh.
    Controls,
    /// Everything that tells what is ahead.
    Forecast,
    /// The tabs below the plot.
    Tabs,
}

/// A question.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(untagged)]
pub enum Question {
    /// A place on the axis of u0 (ranges).
    Guess {
        /// The question.
        asks: String,
        /// The number of the model that is guessed.
        of: String,
    },
    /// One of three.
    Choice {
        /// The question.
        asks: String,
        /// The answers.
        options: [String; 3],
        /// The index of the right one.
        right: usize,
    },
}

/// What the learner does.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Task {
    /// In words.
    pub words: String,
    /// It is done when all of these hold.
    pub until: Vec<Condition>,
    /// One way of doing it, for whoever performs the lesson without a window.
    pub act: Vec<Act>,
}

/// Something a learner can do.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(rename_all = "snake_case")]
pub enum Act {
    /// Move u0, or the stage, to so many ranges.
    GoTo(f64),
    /// Play a closed loop.
    Loop,
    /// Edit a number of the scene.
    Set(String, f64),
}

macro_rules! lessons {
    ($($name:literal)*) => {
        const TEXTS: &[(&str, &str)] = &[$((
            $name,
            include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/lessons/", $name, ".toml")),
        ),)*];
    };
}

lessons! { "first-snap" "four-patterns" "way-back" "held-by-nothing" "mesh-lies" "slow-loss" "machine" }

/// The lessons that are built in, in the order in which they are taken.
pub fn all() -> &'static [Lesson] {
    static ALL: LazyLock<Vec<Lesson>> = LazyLock::new(|| {
        let read = |(name, text): &(&str, &str)| parse(name, text).expect("a test reads them all");
        TEXTS.iter().map(read).collect()
    });
    &ALL
}

/// The lesson of this name.
pub fn find(name: &str) -> Option<&'static Lesson> {
    all().iter().find(|lesson| lesson.name == name)
}

/// Reads a lesson.
///
/// # Errors
/// A text that is none: where, and why.
pub fn parse(name: &str, text: &str) -> Result<Lesson, String> {
    let mut lesson: Lesson =
        toml::from_str(text).map_err(|error| format!("assets/lessons/{name}.toml: {error}"))?;
    name.clone_into(&mut lesson.name);
    let right = |step: &Step| !matches!(step.question, Some(Question::Choice { right: 3.., .. }));
    if lesson.steps.is_empty() || !lesson.steps.iter().all(right) {
        return Err(format!(
            "assets/lessons/{name}.toml: steps are needed, and right is 0, 1 or 2"
        ));
    }
    Ok(lesson)
}

impl Lesson {
    /// The preset that is open in this step: its own, or that of a step before.
    pub fn scene_at(&self, step: usize) -> Option<&str> {
        let known = self.steps.iter().take(step + 1).rev();
        known.filter_map(|step| step.scene.as_deref()).next()
    }
}
