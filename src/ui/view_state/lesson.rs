//! What somebody is told to do: the lesson under way, and who has done nothing yet, to lower the body, to
//! pull it off, and what was lost.

use super::ViewState;
use crate::follow::record::{Direction, JumpRecord, StateRecord};
use crate::lessons::{self, Facts, Hidden, Lesson, Progress, Question, Step};
use crate::physics::indenter::Indenter;
use crate::study::forecast::calm;
use crate::ui::action::LessonAct;

/// What the window must do as a step begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Begin {
    /// The preset to open.
    pub scene: Option<&'static str>,
    /// The tab to show.
    pub tab: Option<&'static str>,
}

impl ViewState {
    /// The lesson under way, and how far it is.
    pub fn lesson(&self) -> Option<(&'static Lesson, &Progress)> {
        let progress = self.lesson.as_ref()?;
        Some((lessons::find(&progress.lesson)?, progress))
    }

    /// Its step.
    fn lesson_step(&self) -> Option<&'static Step> {
        let (lesson, progress) = self.lesson()?;
        progress.step(lesson)
    }

    /// The question that waits, and the answer that is chosen.
    pub fn asked(&self) -> Option<(&'static Question, Option<f64>)> {
        let (lesson, progress) = self.lesson()?;
        Some((progress.asks(lesson)?, progress.answer))
    }

    /// True if the lesson hides this, or a lecture or the window itself before the first jump.
    pub fn hides(&self, what: Hidden) -> bool {
        let waits = self.opened.guessing || self.view.lecture && self.run.record.jumps.is_empty();
        self.lesson_hides(what) || waits && what == Hidden::Forecast
    }

    fn lesson_hides(&self, what: Hidden) -> bool {
        self.lesson_step()
            .is_some_and(|step| step.hide.contains(&what))
    }

    /// True if kept loops, and the scene beside, would tell what a lesson asks.
    pub fn hides_kept(&self) -> bool {
        self.lesson_hides(Hidden::Forecast)
    }

    /// Between which values u0 can be guessed (ranges).
    pub fn guessable(&self) -> [f64; 2] {
        let ([left, _], [right, _]) = self.axes();
        [left.max(0.0), right]
    }

    /// What a lesson knows of the model.
    fn facts(&self) -> Facts<'_> {
        Facts {
            scene: &self.scene,
            model: &self.model,
            record: &self.run.record,
            loss: self.run.loss(),
        }
    }

    /// Does what the learner asked for.
    pub fn act_in_lesson(&mut self, act: LessonAct) -> Begin {
        if act == LessonAct::Leave {
            self.lesson = None;
            return Begin::default();
        }
        if let LessonAct::Start(index) = act {
            self.lesson = lessons::all().get(index).map(Progress::new);
            return self.begin_step();
        }
        let (Some(mut progress), Some((lesson, _))) = (self.lesson.clone(), self.lesson()) else {
            return Begin::default();
        };
        match act {
            LessonAct::Choose(answer) => progress.answer = Some(answer),
            LessonAct::Commit => progress.commit(lesson, &self.facts()),
            LessonAct::Next => progress.next(lesson),
            LessonAct::Back => progress.back(lesson),
            LessonAct::Start(_) | LessonAct::Leave => {}
        }
        self.lesson = Some(progress);
        if matches!(act, LessonAct::Next | LessonAct::Back) {
            self.begin_step()
        } else {
            Begin::default()
        }
    }

    fn begin_step(&self) -> Begin {
        self.lesson_step()
            .map_or_else(Begin::default, |step| Begin {
                scene: step.scene.as_deref(),
                tab: step.tab.as_deref(),
            })
    }

    /// Takes a lesson up again where it was left.
    pub fn resume_lesson(&mut self, progress: Progress) -> Begin {
        self.lesson = Some(progress);
        let scene = self
            .lesson()
            .and_then(|(lesson, progress)| lesson.scene_at(progress.step));
        Begin {
            scene,
            ..self.begin_step()
        }
    }

    /// Ends the task if the model meets its condition.
    pub fn observe_lesson(&mut self) {
        let Some((lesson, progress)) = self.lesson() else {
            return;
        };
        let mut progress = progress.clone();
        if progress.observe(lesson, &self.facts()) {
            self.lesson = Some(progress);
        }
    }
}

/// How far somebody is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hint {
    /// Nothing was moved yet.
    Grab,
    /// Nothing has snapped yet.
    Lower,
    /// It has snapped on the way down.
    PullOff,
    /// It is back where it was.
    Loss,
}

impl ViewState {
    /// The hint in words; `None` where there is none, a lesson says what to do, or the surface
    /// moves by itself.
    pub fn hint(&self) -> Option<String> {
        let hint = self.messages.hint?;
        let moves = self.run.sweep().is_some() || self.jumping().is_some();
        if self.lesson.is_some() || moves {
            return None;
        }
        Some(match hint {
            Hint::Grab | Hint::Lower => match calm(&self.scene, &self.model) {
                Some(calm) => format!("Here nothing snaps. {}", calm.remedy),
                None if self.model.indenter == Indenter::Flat => {
                    "Drag down slowly. Something will snap.".to_owned()
                }
                None => "Drag down slowly. Something may snap.".to_owned(),
            },
            Hint::PullOff => "Now pull it off again.".to_owned(),
            Hint::Loss if self.run.closed_loop.is_some() => {
                "The shaded area is what was lost.".to_owned()
            }
            Hint::Loss => "The jumps add up to what was lost.".to_owned(),
        })
    }

    /// Something was moved.
    pub(super) fn hint_after_motion(&mut self) {
        if self.messages.hint == Some(Hint::Grab) {
            self.messages.hint = Some(Hint::Lower);
        }
    }

    /// Another run: nothing has snapped in it.
    pub(super) fn hint_afresh(&mut self) {
        if self.messages.hint.is_some_and(|hint| hint != Hint::Grab) {
            self.messages.hint = Some(Hint::Lower);
        }
    }

    pub(super) fn hint_after_jump(&mut self, jump: &JumpRecord) {
        if jump.direction == Direction::Approach && self.messages.hint.is_some() {
            self.messages.hint = Some(Hint::PullOff);
        }
    }

    pub(super) fn hint_after_state(&mut self, state: &StateRecord) {
        let record = &self.run.record;
        let first = record.states.first().map(|first| first.pattern);
        let last = record.jumps.last().map(|jump| jump.direction);
        self.messages.hint = match (self.messages.hint, state.direction) {
            (Some(Hint::Loss), Direction::Approach) => None,
            // Who has been all the way down is told nothing new.
            (Some(Hint::Grab | Hint::Lower), _) if state.control <= self.limits.0 => None,
            (Some(Hint::PullOff), Direction::Retraction)
                if last == Some(Direction::Retraction) && first == Some(state.pattern) =>
            {
                Some(Hint::Loss)
            }
            (hint, _) => hint,
        };
    }
}
