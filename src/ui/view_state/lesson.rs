//! The lesson under way.

use super::ViewState;
use crate::lessons::{self, Facts, Hidden, Lesson, Progress, Question};
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
        let step = self
            .lesson()
            .and_then(|(lesson, progress)| progress.step(lesson));
        step.is_some_and(|step| step.hide.contains(&what))
    }

    /// True if kept loops, and the scene beside, would tell what a lesson asks.
    pub fn hides_kept(&self) -> bool {
        self.lesson_hides(Hidden::Forecast)
    }

    /// What a lesson knows of the model.
    fn facts(&self) -> Facts<'_> {
        let closed = self.run.closed_loop.as_ref();
        Facts {
            scene: &self.scene,
            model: &self.model,
            record: &self.run.record,
            loss: closed.and_then(|closed| closed.summary.ledger.dissipated_energy()),
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
        let step = self
            .lesson()
            .and_then(|(lesson, progress)| progress.step(lesson));
        step.map_or_else(Begin::default, |step| Begin {
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
