//! Who steps a session. The two threads: the solver's, commands in, events out, the newest picture in
//! a mailbox; and beside it the live loop's, where the newest scene wins: a coarse loop first, a finer
//! one when the hand rests. And a lesson performed without a window: a session does what the learner
//! would do, and every condition must be met by it, and by it alone.

use super::background::live_state;
use super::job::{Wake, Work};
use super::protocol::{Command, Envelope, Event, LiveState, Play, RunId, SolverHandle, Sweep};
use super::session::Session;
use super::system::{self, Instant, JoinHandle};
use crate::follow::record::LoopRecord;
use crate::lessons::{Act, Facts, Lesson, Progress, Question};
use crate::numerics::threads::Cancel;
use crate::scene::{Drive, Model, Scene, edit};
use crate::solver::methods::MethodKind;
use crate::study::live_loop::{Fineness, LiveLoops};
use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, TryRecvError, bounded, unbounded};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Duration;

/// Handle of the solver thread, and of the live loop's beside it. Dropping it cancels both, and
/// waits for them a little.
pub struct Worker {
    commands: Sender<Envelope<Command>>,
    events: Receiver<Envelope<Event>>,
    frames: Receiver<Envelope<Event>>,
    /// Raised to end the thread; never taken back.
    quit: Cancel,
    /// Raised to interrupt the present work; a part of `quit`.
    cancel: Cancel,
    thread: Option<JoinHandle<()>>,
    live: Live,
    wake: Wake,
}

impl Worker {
    /// Starts the threads. `wake` is called (from them) whenever something new can be received.
    pub fn spawn(wake: impl Fn() + Send + Sync + 'static) -> Self {
        let (commands, inbox) = unbounded();
        let (outbox, events) = unbounded();
        let (mailbox, frames) = bounded(1);
        let quit = Cancel::default();
        let cancel = quit.part();
        let wake: Wake = Arc::new(wake);
        let post = Post {
            outbox,
            mailbox,
            stale: frames.clone(),
            wake: wake.clone(),
        };
        let live = Live::spawn({
            let post = post.clone();
            move |envelope| post.send(envelope)
        });
        let token = cancel.clone();
        let thread = Some(system::spawn("solver", move || run(&inbox, &post, &token)));
        Self {
            commands,
            events,
            frames,
            quit,
            cancel,
            thread,
            live,
            wake,
        }
    }

    /// Waits for the next event, for callers without a window.
    pub fn next_event(&self, patience: Duration) -> Option<Envelope<Event>> {
        self.events.recv_timeout(patience).ok()
    }
}

impl SolverHandle for Worker {
    /// A command that makes the present work pointless interrupts it.
    fn send(&self, command: Envelope<Command>) {
        if let Command::SetScene { scene, .. } = &command.message {
            self.live.ask(command.run, scene.clone());
        }
        if matches!(
            command.message,
            Command::SetScene { .. }
                | Command::GoOn { .. }
                | Command::Play {
                    play: Play::Rest,
                    ..
                }
                | Command::Quit
        ) {
            self.cancel.request();
        }
        // The thread lives as long as this handle, so the channel is open.
        let _ = self.commands.send(command);
    }

    fn poll(&self) -> Vec<Envelope<Event>> {
        self.events
            .try_iter()
            .chain(self.frames.try_recv())
            .collect()
    }

    fn wake(&self) -> Wake {
        self.wake.clone()
    }

    fn begin(&self, work: Box<dyn Work>) {
        system::spawn("job", move || work.run());
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.quit.request();
        let _ = self.commands.send(Envelope {
            run: 0,
            message: Command::Quit,
        });
        system::end(self.thread.take().into_iter().chain(self.live.ask_to_end()));
    }
}

/// The sending side of everything the window hears.
#[derive(Clone)]
struct Post {
    outbox: Sender<Envelope<Event>>,
    mailbox: Sender<Envelope<Event>>,
    stale: Receiver<Envelope<Event>>,
    wake: Wake,
}

impl Post {
    /// A picture replaces one that nobody took yet.
    fn send(&self, envelope: Envelope<Event>) {
        if matches!(envelope.message, Event::Frame(_)) {
            let _ = self.stale.try_recv();
            let _ = self.mailbox.try_send(envelope);
        } else {
            let _ = self.outbox.send(envelope);
        }
        (self.wake)();
    }
}

fn run(inbox: &Receiver<Envelope<Command>>, post: &Post, cancel: &Cancel) {
    let mut session = Session::default();
    loop {
        let wait = session.wait(Instant::now());
        let command = match wait {
            // Nothing to do: sleep until somebody speaks.
            None => inbox.recv().map_err(|_| ()),
            Some(pause) if pause.is_zero() => match inbox.try_recv() {
                Ok(command) => Ok(command),
                Err(TryRecvError::Empty) => {
                    step(&mut session, post, cancel);
                    continue;
                }
                Err(TryRecvError::Disconnected) => Err(()),
            },
            Some(pause) => match inbox.recv_timeout(pause) {
                Ok(command) => Ok(command),
                Err(RecvTimeoutError::Timeout) => continue,
                Err(RecvTimeoutError::Disconnected) => Err(()),
            },
        };
        match command {
            Err(())
            | Ok(Envelope {
                message: Command::Quit,
                ..
            }) => return,
            Ok(command) => {
                cancel.clear();
                let run = command.run;
                guarded(&mut session, post, run, |session, sink| {
                    session.command(command, cancel, sink);
                });
            }
        }
    }
}

fn step(session: &mut Session, post: &Post, cancel: &Cancel) {
    guarded(session, post, session.run(), |session, sink| {
        session.step(Instant::now(), cancel, sink);
    });
}

/// Runs `work`, whose events are those of `run`; a panic in it is told once, and the session goes
/// on from its last good state.
fn guarded(
    session: &mut Session,
    post: &Post,
    run: RunId,
    work: impl FnOnce(&mut Session, &mut dyn FnMut(Event)),
) {
    let mut sink = |event| {
        post.send(Envelope {
            run,
            message: event,
        });
    };
    let caught = catch_unwind(AssertUnwindSafe(|| work(session, &mut sink)));
    if let Err(panic) = caught {
        let words = panic
            .downcast_ref::<&str>()
            .map(|s| (*s).to_owned())
            .or_else(|| panic.downcast_ref::<String>().cloned());
        session.recover();
        let words = words.unwrap_or_else(|| "no words".into());
        sink(Event::failed(
            format!("The solver stopped with a fault of its own: {words}"),
            "It rests on the last good state. Please save the scene and report it.",
        ));
    }
}

/// Silence after which the hand counts as resting.
const REST: Duration = Duration::from_millis(150);

/// A scene whose loop is wanted, with its run.
type Wanted = Envelope<Arc<Scene>>;

/// Handle of the live loop's thread.
struct Live {
    mailbox: Option<Sender<Wanted>>,
    quit: Cancel,
    stale: Receiver<Wanted>,
    thread: Option<JoinHandle<()>>,
}

impl Live {
    /// Starts the thread; it sleeps until a scene comes.
    fn spawn(tell: impl Fn(Envelope<Event>) + Send + 'static) -> Self {
        let (mailbox, wanted) = bounded(1);
        let stale = wanted.clone();
        let quit = Cancel::default();
        let loops = LiveLoops::obeying(&quit);
        let thread = system::spawn("live loop", move || run_live(&wanted, loops, &tell));
        Self {
            mailbox: Some(mailbox),
            quit,
            stale,
            thread: Some(thread),
        }
    }

    /// Asks for the loop of a scene; a scene that still waits is dropped.
    fn ask(&self, run: RunId, scene: Arc<Scene>) {
        let _ = self.stale.try_recv();
        if let Some(mailbox) = &self.mailbox {
            let _ = mailbox.try_send(Envelope {
                run,
                message: scene,
            });
        }
    }

    /// Asks the thread to end, and gives its handle away; `None` if that was done before.
    fn ask_to_end(&mut self) -> Option<JoinHandle<()>> {
        self.quit.request();
        let _ = self.stale.try_recv();
        self.mailbox = None;
        self.thread.take()
    }
}

fn run_live(wanted: &Receiver<Wanted>, mut loops: LiveLoops, tell: &dyn Fn(Envelope<Event>)) {
    let mut known: Option<(Model, Drive, u64, Arc<LiveState>)> = None;
    let mut next = wanted.recv().ok();
    while let Some(Envelope {
        run,
        message: scene,
    }) = next.take()
    {
        let Ok(model) = scene.model() else {
            next = wanted.recv().ok();
            continue;
        };
        let (drive, seed) = (scene.drive, scene.seed);
        // A reset, another method: the loop stays what it was.
        let same = known
            .take()
            .filter(|(m, d, s, _)| *m == model && *d == drive && *s == seed);
        let mut state = same.map_or_else(
            || live_state(&mut loops, &scene, &model, Fineness::Coarse),
            |(.., state)| state,
        );
        tell(Envelope {
            run,
            message: Event::Live(state.clone()),
        });
        if state.fineness == Fineness::Coarse {
            match wanted.recv_timeout(REST) {
                Ok(newer) => next = Some(newer),
                Err(RecvTimeoutError::Disconnected) => return,
                Err(RecvTimeoutError::Timeout) => {
                    state = live_state(&mut loops, &scene, &model, Fineness::Fine);
                    tell(Envelope {
                        run,
                        message: Event::Live(state.clone()),
                    });
                }
            }
        }
        known = Some((model, drive, seed, state));
        if next.is_none() {
            next = wanted.recv().ok();
        }
    }
}

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
                let play = Play::ToTarget(control);
                self.tell(Command::Play { motion, play }, cancel)
            }
            Act::Loop => {
                let play = Play::Sweep(Sweep::Loop);
                self.tell(Command::Play { motion, play }, cancel)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::tests::fig2;

    #[test]
    fn a_panic_is_told_once_and_the_session_goes_on_from_the_last_good_state() {
        let (outbox, events) = unbounded();
        let (mailbox, stale) = bounded(1);
        let post = Post {
            outbox,
            mailbox,
            stale,
            wake: Arc::new(|| {}),
        };
        let mut session = Session::default();
        let scene = Arc::new(fig2(32));
        let method = MethodKind::NewtonKrylov;
        let commands = [
            Command::SetScene {
                scene,
                method,
                asked: None,
                from: None,
            },
            Command::Play {
                motion: 1,
                play: Play::ToTarget(4.0),
            },
        ];
        let of_run_3 = |message| Envelope { run: 3, message };
        let cancel = Cancel::default();
        for command in commands {
            guarded(&mut session, &post, 3, |session, sink| {
                session.command(of_run_3(command), &cancel, sink);
            });
        }
        for _ in 0..4 {
            step(&mut session, &post, &cancel);
        }
        events.try_iter().for_each(drop);
        guarded(&mut session, &post, 3, |_, _| {
            panic!("a fault for the test")
        });
        let told: Vec<Envelope<Event>> = events.try_iter().collect();
        let [
            Envelope {
                run: 3,
                message: Event::Failed(failure),
            },
        ] = &told[..]
        else {
            panic!("{told:?}")
        };
        assert!(failure.message.contains("a fault for the test"), "{told:?}");
        let target = of_run_3(Command::Play {
            motion: 2,
            play: Play::ToTarget(4.19),
        });
        guarded(&mut session, &post, 3, |session, sink| {
            session.command(target, &cancel, sink);
        });
        step(&mut session, &post, &cancel);
        let next = events.try_iter().find_map(|e| {
            if let Event::State(state) = e.message {
                Some(state.mean_displacement)
            } else {
                None
            }
        });
        // Four steps of 0.02 down from 4.2, then one up.
        assert!((next.unwrap() - 4.14).abs() < 1e-9, "{next:?}");
    }
}
