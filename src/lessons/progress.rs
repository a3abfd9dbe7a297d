//! Where a learner is in a lesson: the step and its stage, the answers, the score.

use super::{Facts, Lesson, Question, Step};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

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
