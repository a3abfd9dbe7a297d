//! What outlasts a run. What a session file keeps of the window beside the scene, and how it is taken
//! up again; undo and redo: the scenes before and after the present one, and where their surfaces
//! were; the lesson under way.

use super::plots::SavedLoop;
use super::{Curve, Films, KeptLoops, Store, ViewState};
use crate::follow::record::LoopRecord;
use crate::lessons::{self, Facts, Hidden, Lesson, Progress, Question, Step};
use crate::scene::{Drive, Scene, Strategy};
use crate::solver::methods::MethodKind;
use crate::storage::session::Session;
use crate::ui::action::LessonAct;
use crate::worker::protocol::{Film, Stored};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The run of a session: how it is computed, where it went, what is kept of it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Saved {
    method: MethodKind,
    asked: Option<Strategy>,
    record: LoopRecord,
    /// In the order of the path; the last one is where the surface stands.
    states: Vec<Arc<Stored>>,
    /// With the index of their jump.
    films: Vec<(usize, Arc<Film>)>,
    kept: Vec<SavedLoop>,
}

/// How much of a run is saved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// Everything that is kept.
    Whole,
    /// Records, and of the stored states the one where the surface stands: a picture carries that.
    Present,
}

impl Saved {
    /// Its states and jumps.
    pub fn record(&self) -> &LoopRecord {
        &self.record
    }

    /// How many of its states can be shown.
    pub fn states(&self) -> usize {
        self.states.len()
    }

    /// What contradicts itself or the scene, in words.
    fn fault(&self, scene: &Scene) -> Option<String> {
        let model = match scene.model() {
            Ok(model) => model,
            Err(refusal) => return Some(refusal.to_string()),
        };
        let mesh = (model.grid.ny, model.grid.nx);
        let films = self.films.iter().flat_map(|(_, film)| film.frames());
        let of_mesh = self.states.iter().all(|state| state.gap.dim() == mesh)
            && films.into_iter().all(|frame| frame.gap.dim() == mesh);
        if !of_mesh {
            return Some("its states are of another mesh than its scene".to_owned());
        }
        let LoopRecord { states, jumps, .. } = &self.record;
        let places = self.states.iter().map(|state| state.before[0]);
        let in_order = places.clone().is_sorted_by(|a, b| a < b);
        let last = self.states.last().map_or([0, 0], |state| state.before);
        let on_path = last[0] < states.len().max(1) && last[1] <= jumps.len();
        (!(in_order && on_path)).then(|| "its states are not those of its loop".to_owned())
    }
}

impl ViewState {
    /// The session as it is now, to be saved. Its states are those that `record` still has.
    pub fn session(&self, extent: Extent) -> Session<Saved> {
        let run = &self.run;
        let renumbered = |stored: &Arc<Stored>| {
            let place = stored.before[0].checked_sub(run.store.forgotten)?;
            if run.store.forgotten == 0 {
                return Some(stored.clone());
            }
            let mut stored = Stored::clone(stored);
            stored.before[0] = place;
            Some(Arc::new(stored))
        };
        let (states, films) = match extent {
            Extent::Whole => (run.store.all().collect(), run.films.all().collect()),
            Extent::Present => (run.store.newest().into_iter().collect(), Vec::new()),
        };
        let states: Vec<&Arc<Stored>> = states;
        Session {
            scene: (*self.scene).clone(),
            notes: self.notes.clone(),
            window: Saved {
                method: self.method,
                asked: self.asked,
                record: run.record.clone(),
                states: states.into_iter().filter_map(renumbered).collect(),
                films,
                kept: self.plots.kept.saved(),
            },
        }
    }

    /// Takes a session up where it was left.
    ///
    /// # Errors
    /// In words, where it contradicts itself; nothing has changed then.
    pub fn reopen(&mut self, session: Session<Saved>) -> Result<(), String> {
        let Session {
            scene,
            notes,
            window,
        } = session;
        if let Some(fault) = window.fault(&scene) {
            return Err(fault);
        }
        let Saved {
            method,
            asked,
            mut record,
            mut states,
            films,
            kept,
        } = window;
        (self.method, self.asked, self.notes) = (method, asked, notes);
        self.open_scene(scene);
        self.plots.kept = KeptLoops::new(kept);
        let Some(here) = states.pop() else {
            return Ok(());
        };
        // Where the surface stands is told by the solver.
        record.states.truncate(here.before[0]);
        record.jumps.truncate(here.before[1]);
        let (law, run) = (&self.model.law, &mut self.run);
        run.curve = Curve::of(&record, law);
        run.stiffness = Curve::of_ordinate(&record, law, |s| s.stiffness_min);
        run.record = record;
        run.store = Store::new(states);
        run.films = Films::new(films);
        self.resume(here);
        Ok(())
    }
}

/// Among how many of the last scenes one that comes back is looked for.
const RECENT: usize = 16;
/// Most edits that can be taken back.
const DEPTH: usize = 200;

/// A scene, how it was computed, and where its surface was; `None` at the start of the drive.
#[derive(Clone, Debug)]
pub struct Past {
    scene: Arc<Scene>,
    method: MethodKind,
    asked: Option<Strategy>,
    surface: Option<Arc<Stored>>,
}

/// Undo and redo of scene edits: the scenes before and after the present one. One drag is one undo,
/// however many values it passes.
#[derive(Clone, Debug, Default)]
pub struct History {
    undo: Vec<Past>,
    redo: Vec<Past>,
    in_gesture: bool,
}

impl History {
    /// Notes that `before` is about to be replaced. Within one gesture only the first call counts.
    pub fn remember(&mut self, before: Past) {
        if !self.in_gesture {
            self.undo.push(before);
            if self.undo.len() > DEPTH {
                self.undo.remove(0);
            }
        }
        self.in_gesture = true;
        self.redo.clear();
    }

    /// The newest of the scenes before that the `edited` one differs from in title and drive alone:
    /// there and back, as from law to law, the drive would else stay adapted to the way. None where
    /// it is the drive of the `present` scene that was edited.
    pub(super) fn known(&self, edited: &Scene, present: &Scene) -> Option<Scene> {
        let same = |a: &Scene| {
            let like = Scene {
                title: edited.title.clone(),
                drive: Drive {
                    control: a.drive.control,
                    ..edited.drive
                },
                ..a.clone()
            };
            like == *edited
        };
        if same(present) {
            return None;
        }
        let before = self.undo.iter().rev().take(RECENT);
        before
            .map(|past| &*past.scene)
            .find(|scene| same(scene))
            .cloned()
    }

    /// The pointer is up: the next edit is another one.
    pub fn end_gesture(&mut self) {
        self.in_gesture = false;
    }

    /// What was before `present`, if anything.
    pub fn undo(&mut self, present: Past) -> Option<Past> {
        let past = self.undo.pop()?;
        self.redo.push(present);
        Some(past)
    }

    /// What came after `present`, if anything.
    pub fn redo(&mut self, present: Past) -> Option<Past> {
        let past = self.redo.pop()?;
        self.undo.push(present);
        Some(past)
    }

    /// The scene that an undo brings back.
    pub fn before(&self) -> Option<&Arc<Scene>> {
        self.undo.last().map(|past| &past.scene)
    }

    /// True if there is something to take back.
    pub fn can_undo(&self) -> bool {
        !self.undo.is_empty()
    }

    /// True if there is something to do again.
    pub fn can_redo(&self) -> bool {
        !self.redo.is_empty()
    }
}

impl ViewState {
    /// Undoes a scene edit, and brings the surface back where it was.
    pub fn undo(&mut self) {
        let past = self.history.undo(self.past());
        self.bring_back(past);
    }

    /// Takes an undo back.
    pub fn redo(&mut self) {
        let past = self.history.redo(self.past());
        self.bring_back(past);
    }

    /// What an undo brings back. The start of the drive is come to by itself.
    pub(super) fn past(&self) -> Past {
        let Drive { start, step, .. } = self.scene.drive;
        // Behind a spring it may be a rounding off.
        let at_start = |control: f64| (control - start).abs() < 1e-6 * step;
        let is_start = |s: &&Arc<Stored>| s.before == [0, 0] && at_start(s.record.control);
        let stored = self.run.store.newest();
        Past {
            scene: self.scene.clone(),
            method: self.method,
            asked: self.asked,
            surface: stored.filter(|s| !is_start(s)).cloned(),
        }
    }

    fn bring_back(&mut self, past: Option<Past>) {
        let Some(Past {
            scene,
            method,
            asked,
            surface,
        }) = past
        else {
            return;
        };
        if let Some(surface) = surface
            .as_ref()
            .filter(|_| Arc::ptr_eq(&scene, &self.scene))
            .filter(|_| (method, asked) == (self.method, self.asked))
        {
            // Nothing but the surface has changed.
            return self.resume(surface.clone());
        }
        (self.method, self.asked) = (method, asked);
        if surface.is_none() {
            self.target = self.limits.1;
        }
        if self.set_scene((*scene).clone())
            && let Some(surface) = surface
        {
            self.resume(surface);
        }
    }
}

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
