//! A lesson performed without a window: a session does what the learner would do, and every
//! condition must be met by it, and by it alone.

use super::protocol::{Command, Envelope, Event, Sweep};
use super::session::Session;
use super::system::Instant;
use crate::follow::record::LoopRecord;
use crate::lessons::{Act, Facts, Lesson, Progress, Question};
use crate::numerics::cancel::Cancel;
use crate::scene::{Model, Scene, edit};
use crate::solver::methods::MethodKind;
use std::sync::Arc;
use std::time::Duration;

/// Longer than any pause between two states.
const LATER: Duration = Duration::from_secs(3600);

/// Performs a lesson, its scenes found by `scene`; returns what was explained, step by step.
///
/// # Errors
/// The first step whose condition is met before anything was done, or not met after it, or whose
/// explanation lacks a number.
pub fn rehearse(
    lesson: &Lesson,
    scene: &dyn Fn(&str) -> Result<Scene, String>,
    cancel: &Cancel,
) -> Result<Vec<String>, String> {
    let mut progress = Progress::new(lesson);
    let mut rehearsal = None;
    let mut told = Vec::new();
    while let Some(step) = progress.step(lesson) {
        let fault = |why: String| format!("{}, step {}: {why}", lesson.name, progress.step + 1);
        let text = progress.filled(&step.text);
        if let Some(name) = &step.scene {
            rehearsal = Some(Rehearsal::new(scene(name).map_err(&fault)?, cancel).map_err(&fault)?);
        }
        let Some(rehearsal) = &mut rehearsal else {
            return Err(fault("no scene is open".to_owned()));
        };
        if let Some(question) = progress.asks(lesson) {
            let answer = match question {
                Question::Choice { right, .. } => *right as f64,
                Question::Guess { .. } => 3.0,
            };
            let fault = fault("the answer is not taken".to_owned());
            progress.answer = Some(answer);
            progress.commit(lesson, &rehearsal.facts());
            if progress.asks(lesson).is_some() {
                return Err(fault);
            }
        }
        if let Some(task) = &step.task {
            let fault = |why: &str| format!("{}, step {}: {why}", lesson.name, progress.step + 1);
            let met =
                |rehearsal: &Rehearsal| task.until.iter().all(|c| c.holds(&rehearsal.facts()));
            if met(rehearsal) {
                return Err(fault("its condition is met before anything was done"));
            }
            for act in &task.act {
                rehearsal.act(act, cancel).map_err(|why| fault(&why))?;
            }
            let fault = fault(&format!("its condition is not met: {:?}", task.until));
            if !progress.observe(lesson, &rehearsal.facts()) {
                return Err(fault);
            }
        }
        progress.observe(lesson, &rehearsal.facts());
        let words = progress.explanation(lesson).unwrap_or_default();
        if text.contains('{') || words.contains('{') {
            let number = progress.step + 1;
            let words = text + " " + &words;
            return Err(format!(
                "{}, step {number}: no number for {words}",
                lesson.name
            ));
        }
        told.push(words);
        progress.next(lesson);
    }
    Ok(told)
}

/// A session with what it has said.
struct Rehearsal {
    scene: Arc<Scene>,
    model: Model,
    session: Session,
    record: LoopRecord,
    loss: Option<f64>,
    failed: Option<String>,
    motion: u64,
}

impl Rehearsal {
    fn new(scene: Scene, cancel: &Cancel) -> Result<Self, String> {
        let model = scene.model().map_err(|error| error.to_string())?;
        let mut rehearsal = Self {
            record: LoopRecord::of(scene.control()),
            scene: Arc::new(scene),
            model,
            session: Session::default(),
            loss: None,
            failed: None,
            motion: 0,
        };
        let begin = Command::SetScene {
            scene: rehearsal.scene.clone(),
            method: MethodKind::default(),
            asked: None,
            from: None,
        };
        rehearsal.tell(begin, cancel)?;
        Ok(rehearsal)
    }

    fn facts(&self) -> Facts<'_> {
        Facts {
            scene: &self.scene,
            model: &self.model,
            record: &self.record,
            loss: self.loss,
        }
    }

    fn act(&mut self, act: &Act, cancel: &Cancel) -> Result<(), String> {
        self.motion += 1;
        let motion = self.motion;
        match act {
            Act::GoTo(ranges) => {
                let control = ranges * self.model.law.range;
                self.tell(Command::SetTarget { motion, control }, cancel)
            }
            Act::Loop => {
                let sweep = Sweep::Loop;
                self.tell(Command::Sweep { motion, sweep }, cancel)
            }
            Act::Set(key, value) => {
                let edited = edit::with_parameter(&self.scene, &self.model, key, *value);
                let edited = edited.map_err(|error| error.to_string())?;
                *self = Self::new(edited, cancel)?;
                Ok(())
            }
        }
    }

    /// Passes a command on, and steps the session until it rests.
    fn tell(&mut self, message: Command, cancel: &Cancel) -> Result<(), String> {
        let mut said = Vec::new();
        let envelope = Envelope { run: 1, message };
        let session = &mut self.session;
        session.command(envelope, cancel, &mut |event| said.push(event));
        let now = Instant::now();
        while session.wait(now + LATER).is_some() && !cancel.requested() {
            session.step(now, cancel, &mut |event| said.push(event));
        }
        said.into_iter().for_each(|event| self.hear(event));
        if cancel.requested() {
            return Err("interrupted".to_owned());
        }
        self.failed.take().map_or(Ok(()), Err)
    }

    fn hear(&mut self, event: Event) {
        match event {
            Event::State(state) => self.record.states.push(state),
            Event::Jump(jump) => self.record.jumps.push(jump),
            Event::Cut { states, jumps } => {
                self.record.states.truncate(states);
                self.record.jumps.truncate(jumps);
                self.loss = None;
            }
            Event::Loop(summary) => self.loss = summary.ledger.dissipated_energy(),
            Event::Failed(failure) => self.failed = Some(failure.message),
            _ => {}
        }
    }
}
