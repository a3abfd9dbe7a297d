//! Floor 6: lessons of about five minutes, each a value read from one text: what is said, asked and
//! done, the condition on the model that ends a task, and the explanation with the learner's
//! numbers; what a lesson knows of the model; and where a learner is in it.
//!
//! No drawing, files or threads: a window shows a lesson, and a session performs it
//! ([`Task::act`]). Lengths are told in ranges of the law, energies in units of gamma.

use crate::follow::record::{Direction, LoopRecord, StateRecord};
use crate::physics::control::Control;
use crate::physics::theory::{critical_length, flat_limits, flat_stiffness, ridge};
use crate::scene::parameter::fixed;
use crate::scene::{Model, Scene};
use crate::solver::Stop;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
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

/// What the model shows now.
#[derive(Clone, Copy, Debug)]
pub struct Facts<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// What it was decided to be.
    pub model: &'a Model,
    /// The path so far.
    pub record: &'a LoopRecord,
    /// What a closed loop lost (gamma).
    pub loss: Option<f64>,
}

/// A condition on the model.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(rename_all = "snake_case")]
pub enum Condition {
    /// The present pattern, by its word.
    Pattern(String),
    /// On approach it jumped from this pattern.
    Jumped(String),
    /// On retraction it jumped from this pattern.
    JumpedBack(String),
    /// So many jumps belong to the mesh, or more.
    MeshJumps(usize),
    /// u0 is below so many ranges.
    Below(f64),
    /// A loop is closed.
    LoopClosed(bool),
    /// mu_rho is above.
    MuRhoAbove(f64),
    /// The cell is longer than so many ranges.
    LengthAbove(f64),
    /// The present state is stable, or is not.
    Stable(bool),
    /// The machine, by its word: displacement, spring or load.
    Machine(String),
}

impl Condition {
    /// True if it holds.
    pub fn holds(&self, facts: &Facts<'_>) -> bool {
        let now = facts.now();
        let jumped = |from: &str, direction: Direction| {
            let this = |pattern: &str| pattern == from;
            let mut jumps = facts.record.jumps.iter();
            jumps.any(|jump| jump.direction == direction && this(jump.from.word()))
        };
        match self {
            Self::Pattern(word) => now.is_some_and(|now| now.pattern.word() == word),
            Self::Jumped(from) => jumped(from, Direction::Approach),
            Self::JumpedBack(from) => jumped(from, Direction::Retraction),
            Self::MeshJumps(least) => facts.record.tally().of_the_mesh >= *least,
            Self::Below(ranges) => u0(facts).is_some_and(|u0| u0 < *ranges),
            Self::LoopClosed(closed) => facts.loss.is_some() == *closed,
            Self::MuRhoAbove(mu_rho) => facts.model.mu_rho > *mu_rho,
            Self::LengthAbove(ranges) => facts.length() > *ranges,
            Self::Stable(stable) => now.is_some_and(|now| (now.stop == Stop::Stable) == *stable),
            Self::Machine(word) => facts.scene.drive.control.word() == word,
        }
    }
}

/// A number that a text may have in it.
struct Number {
    name: &'static str,
    decimals: usize,
    of: fn(&Facts<'_>) -> Option<f64>,
}

const fn number(name: &'static str, decimals: usize, of: fn(&Facts<'_>) -> Option<f64>) -> Number {
    Number { name, decimals, of }
}

/// The numbers by name: lengths in ranges, energies in gamma, stiffnesses in E*/L.
const NUMBERS: [Number; 19] = [
    number("u0", 2, u0),
    number("first_jump", 3, |f| f.jump(Direction::Approach, 0)),
    number("last_jump", 3, |f| f.jump(Direction::Approach, -1)),
    number("first_jump_back", 3, |f| f.jump(Direction::Retraction, 0)),
    number("last_jump_back", 3, |f| f.jump(Direction::Retraction, -1)),
    number("first_release", 4, |f| {
        f.record.jumps.first().map(|jump| jump.released_energy)
    }),
    number("released", 4, |f| Some(f.record.released_energy_sum())),
    number("loss", 4, |f| f.loss),
    number("loss_percent", 0, |f| Some(100.0 * f.loss?)),
    number("jumps", 0, |f| Some(f.record.tally().jumps as f64)),
    number("mesh_jumps", 0, |f| {
        Some(f.record.tally().of_the_mesh as f64)
    }),
    number("mu_rho", 2, |f| Some(f.model.mu_rho)),
    number("flat_limit", 3, |f| f.limit(1)),
    number("flat_limit_back", 3, |f| f.limit(0)),
    number("stiffness", 2, |f| Some(f.now()?.stiffness_min)),
    // Of the flat state at the present u0, whatever the surface does.
    number("flat_stiffness", 2, |f| {
        let (law, length) = (&f.model.law, f.model.equivalent_length);
        Some(flat_stiffness(law, length, f.now()?.mean_displacement))
    }),
    number("length", 0, |f| Some(f.length())),
    number("critical_length", 1, |f| {
        Some(critical_length(&f.model.law) / f.model.law.range)
    }),
    number("zero_range_loss", 3, |_| {
        Some(ridge::zero_range_dissipation())
    }),
];

/// The present u0 in ranges.
fn u0(facts: &Facts<'_>) -> Option<f64> {
    Some(facts.now()?.mean_displacement / facts.model.law.range)
}

impl Facts<'_> {
    /// The newest state.
    pub fn now(&self) -> Option<&StateRecord> {
        self.record.states.last()
    }

    /// The length of the cell in ranges.
    fn length(&self) -> f64 {
        self.model.grid.length / self.model.law.range
    }

    /// u0 of the first (0) or last (-1) jump of the physics in this direction.
    fn jump(&self, direction: Direction, which: isize) -> Option<f64> {
        let mut jumps = self
            .record
            .jumps
            .iter()
            .filter(|jump| jump.direction == direction);
        let jump = if which == 0 {
            jumps.next()
        } else {
            jumps.next_back()
        };
        Some(jump?.mean_displacement / self.model.law.range)
    }

    /// The lower (0) or upper (1) limit of the flat state, where u0 is held.
    fn limit(&self, which: usize) -> Option<f64> {
        if self.scene.control() != Control::Displacement {
            return None;
        }
        let (lower, upper) = flat_limits(&self.model.law, self.model.equivalent_length)?;
        Some([lower, upper][which] / self.model.law.range)
    }

    /// The number of this name.
    pub fn number(&self, name: &str) -> Option<f64> {
        let known = NUMBERS.iter().find(|number| number.name == name);
        known.and_then(|number| (number.of)(self))
    }

    /// All that is known, as it is written in a text.
    pub fn words(&self) -> BTreeMap<String, String> {
        let value = |number: &Number| {
            let value = (number.of)(self).filter(|value| value.is_finite())?;
            Some((number.name.to_owned(), fixed(value, number.decimals)))
        };
        let pattern = self.now().map(|now| now.pattern.word().to_owned());
        let pattern = pattern.map(|word| ("pattern".to_owned(), word));
        NUMBERS.iter().filter_map(value).chain(pattern).collect()
    }
}

/// Most points of a question.
const POINTS: u32 = 3;
/// A guess within such a share of the number has this many points.
const NEAR: [(f64, u32); 3] = [(0.02, POINTS), (0.05, 2), (0.15, 1)];

/// How far a step is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Stage {
    /// Its question waits.
    #[default]
    Asking,
    /// Its task waits for its condition.
    Doing,
    /// It is done, and explained.
    Explained,
}

/// A lesson under way; what is kept between two sittings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// The lesson's name.
    pub lesson: String,
    /// The present step, from 0; their number at the end.
    pub step: usize,
    /// How far it is.
    pub stage: Stage,
    /// The answer to its question: u0 in ranges, or the index of the choice.
    pub answer: Option<f64>,
    /// The points so far, of the most there were.
    pub score: [u32; 2],
    /// What was known when each step ended, in words.
    known: Vec<BTreeMap<String, String>>,
}

impl Progress {
    /// At the first step.
    pub fn new(lesson: &Lesson) -> Self {
        let mut progress = Self {
            lesson: lesson.name.clone(),
            ..Self::default()
        };
        progress.enter(lesson, 0);
        progress
    }

    /// The present step; `None` at the end.
    pub fn step<'l>(&self, lesson: &'l Lesson) -> Option<&'l Step> {
        lesson.steps.get(self.step)
    }

    /// The question that waits.
    pub fn asks<'l>(&self, lesson: &'l Lesson) -> Option<&'l Question> {
        let step = self.step(lesson)?;
        step.question
            .as_ref()
            .filter(|_| self.stage == Stage::Asking)
    }

    fn enter(&mut self, lesson: &Lesson, step: usize) {
        self.known.truncate(step);
        (self.step, self.answer) = (step, None);
        self.stage = match self.step(lesson) {
            Some(Step {
                question: Some(_), ..
            }) => Stage::Asking,
            Some(_) => Stage::Doing,
            None => Stage::Explained,
        };
    }

    /// Gives the answer that was chosen; without one nothing happens.
    pub fn commit(&mut self, lesson: &Lesson, facts: &Facts<'_>) {
        if self.answer.is_none() || self.asks(lesson).is_none() {
            return;
        }
        self.stage = Stage::Doing;
        if self.step(lesson).is_some_and(|step| step.task.is_none()) {
            self.end(lesson, facts);
        }
    }

    /// Ends the step if the condition of its task is met; true if it was just met. A step without a
    /// task ends as soon as there is a state.
    pub fn observe(&mut self, lesson: &Lesson, facts: &Facts<'_>) -> bool {
        let doing = self.step(lesson).filter(|_| self.stage == Stage::Doing);
        let holds = |step: &Step| {
            let task = step.task.as_ref();
            task.is_none_or(|task| task.until.iter().all(|c| c.holds(facts)))
        };
        let met = facts.now().is_some() && doing.is_some_and(holds);
        if met {
            self.end(lesson, facts);
        }
        met
    }

    /// The step is done: what is known is kept, and the answer judged.
    fn end(&mut self, lesson: &Lesson, facts: &Facts<'_>) {
        self.stage = Stage::Explained;
        let mut known = facts.words();
        let question = self.step(lesson).and_then(|step| step.question.as_ref());
        if let (Some(question), Some(answer)) = (question, self.answer) {
            let points = match question {
                Question::Choice { right, .. } if answer == *right as f64 => POINTS,
                Question::Choice { .. } => 0,
                Question::Guess { of, .. } => {
                    known.insert("guess".to_owned(), format!("{answer:.2}"));
                    facts.number(of).map_or(0, |right| near(answer, right))
                }
            };
            self.score[0] += points;
            self.score[1] += POINTS;
            known.insert("points".to_owned(), points.to_string());
        }
        self.known.resize_with(self.step, BTreeMap::new);
        self.known.push(known);
    }

    /// Goes on to the next step, whether this one is done or not.
    pub fn next(&mut self, lesson: &Lesson) {
        if self.step < lesson.steps.len() {
            let step = self.step + 1;
            self.known.resize_with(step, BTreeMap::new);
            self.enter(lesson, step);
        }
    }

    /// Goes back to the step before.
    pub fn back(&mut self, lesson: &Lesson) {
        let step = self.step.saturating_sub(1);
        self.enter(lesson, step);
    }

    /// What is said now that the step is done: the answer judged, and the explanation with its
    /// numbers.
    pub fn explanation(&self, lesson: &Lesson) -> Option<String> {
        let step = self
            .step(lesson)
            .filter(|_| self.stage == Stage::Explained)?;
        let verdict = match (&step.question, self.answer) {
            (Some(Question::Choice { right, options, .. }), Some(answer)) => {
                if answer == *right as f64 {
                    "Right. ".to_owned()
                } else {
                    format!("No: {}. ", options[*right].trim_end_matches('.'))
                }
            }
            _ => String::new(),
        };
        Some(verdict + &self.filled(&step.explain))
    }

    /// A text with the numbers filled in that are known; others stay as they are.
    pub fn filled(&self, text: &str) -> String {
        let mut text = text.trim().to_owned();
        for (index, known) in self.known.iter().enumerate() {
            for (name, value) in known {
                text = text.replace(&format!("{{step{}.{name}}}", index + 1), value);
                if index == self.step {
                    text = text.replace(&format!("{{{name}}}"), value);
                }
            }
        }
        text
    }
}

/// The points of a guess.
fn near(guess: f64, right: f64) -> u32 {
    let off = (guess - right).abs() / right.abs();
    let points = NEAR.iter().find(|(share, _)| off <= *share);
    points.map_or(0, |(_, points)| *points)
}
