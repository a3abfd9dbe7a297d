//! The solver thread: commands in, events out, one picture in a mailbox.

use super::aside::Aside;
use super::end::{Ending, end};
use super::live::Live;
use super::protocol::{Command, Errand, Event, Frame, Output, Page, RunId};
use super::session::Session;
use super::{measure, paper};
use crate::numerics::cancel::Cancel;
use crossbeam_channel::{Receiver, Sender, TryRecvError, bounded, unbounded};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Instant;

/// Handle of the solver thread and of those that work beside it. Dropping it cancels all, and waits for them a little.
pub struct Worker {
    solver: Solver,
    events: Receiver<Event>,
    frames: Receiver<(RunId, Arc<Frame>)>,
    bench: Aside<(RunId, Errand)>,
    live: Live,
    paper: Aside<Page>,
}

/// Handle of the solver thread alone.
struct Solver {
    commands: Sender<Command>,
    /// Raised to end the thread; never taken back.
    quit: Cancel,
    /// Raised to interrupt the present work; a part of `quit`.
    cancel: Cancel,
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    /// Starts the threads. `wake` is called (from them) whenever something new can be received.
    pub fn spawn(wake: impl Fn() + Send + Sync + 'static) -> Self {
        let (commands, inbox) = unbounded();
        let (outbox, events) = unbounded();
        let (mailbox, frames) = bounded(1);
        let quit = Cancel::default();
        let cancel = quit.part();
        let wake: Arc<dyn Fn() + Send + Sync> = Arc::new(wake);
        let aside = || {
            let (outbox, wake) = (outbox.clone(), wake.clone());
            move |event| {
                let _ = outbox.send(event);
                wake();
            }
        };
        let (bench, live, paper) = (measure::spawn(aside()), Live::spawn(aside()), paper::spawn(aside()));
        let post = Post { outbox, mailbox, stale: frames.clone(), wake };
        let token = cancel.clone();
        let thread = std::thread::Builder::new()
            .name("solver".into())
            .spawn(move || run(&inbox, &post, &token))
            .expect("the system refuses to start a thread");
        let solver = Solver { commands, quit, cancel, thread: Some(thread) };
        Self { solver, events, frames, bench, live, paper }
    }

    /// Hands a command over; never blocks. A command that makes the present work pointless interrupts it.
    pub fn send(&self, command: Command) {
        match &command {
            Command::Measure { run, errand } => self.bench.start((*run, errand.clone())),
            Command::StopMeasuring => self.bench.stop(),
            Command::OpenPage { page } => self.paper.start(*page),
            Command::ClosePage => self.paper.stop(),
            Command::SetScene { run, scene, .. } => {
                // Another scene makes the measurement of this one pointless.
                self.bench.stop();
                self.live.ask(*run, scene.clone());
            }
            _ => {}
        }
        if matches!(command, Command::SetScene { .. } | Command::Stop { .. } | Command::Quit) {
            self.solver.cancel.request();
        }
        // The thread lives as long as this handle, so the channel is open.
        let _ = self.solver.commands.send(command);
    }

    /// Drains the events that have arrived; never blocks.
    pub fn events(&self) -> impl Iterator<Item = Event> + '_ {
        self.events.try_iter()
    }

    /// Waits for the next event, for callers without a window.
    pub fn next_event(&self, patience: std::time::Duration) -> Option<Event> {
        self.events.recv_timeout(patience).ok()
    }

    /// The newest picture, if there is one that was not taken yet.
    pub fn take_frame(&self) -> Option<(RunId, Arc<Frame>)> {
        self.frames.try_recv().ok()
    }
}

impl Ending for Solver {
    fn ask_to_end(&mut self) -> Option<JoinHandle<()>> {
        self.quit.request();
        let _ = self.commands.send(Command::Quit);
        self.thread.take()
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        end(&mut [&mut self.solver, &mut self.bench, &mut self.live, &mut self.paper]);
    }
}

/// The sending side of everything the window hears.
pub(super) struct Post {
    outbox: Sender<Event>,
    mailbox: Sender<(RunId, Arc<Frame>)>,
    stale: Receiver<(RunId, Arc<Frame>)>,
    wake: Arc<dyn Fn() + Send + Sync>,
}

impl Post {
    fn event(&self, event: Event) {
        let _ = self.outbox.send(event);
        (self.wake)();
    }

    /// Replaces a picture that nobody took yet.
    fn frame(&self, run: RunId, frame: Frame) {
        let _ = self.stale.try_recv();
        let _ = self.mailbox.try_send((run, Arc::new(frame)));
        (self.wake)();
    }
}

fn run(inbox: &Receiver<Command>, post: &Post, cancel: &Cancel) {
    let mut session = Session::default();
    loop {
        let wait = session.wait(Instant::now());
        let command = match wait {
            // Nothing to do: sleep until somebody speaks.
            None => inbox.recv().map_err(|_| ()),
            Some(pause) if pause.is_zero() => match inbox.try_recv() {
                Ok(command) => Ok(command),
                Err(TryRecvError::Empty) => {
                    work(&mut session, post, cancel);
                    continue;
                }
                Err(TryRecvError::Disconnected) => Err(()),
            },
            Some(pause) => match inbox.recv_timeout(pause) {
                Ok(command) => Ok(command),
                Err(crossbeam_channel::RecvTimeoutError::Timeout) => continue,
                Err(crossbeam_channel::RecvTimeoutError::Disconnected) => Err(()),
            },
        };
        match command {
            Ok(Command::Quit) | Err(()) => return,
            Ok(command) => {
                cancel.clear();
                guarded(&mut session, post, |session, sink| session.command(command, cancel, sink));
            }
        }
    }
}

fn work(session: &mut Session, post: &Post, cancel: &Cancel) {
    guarded(session, post, |session, sink| session.step(Instant::now(), cancel, sink));
}

/// Runs `job`; a panic in it is told once, and the session goes on from its last good state.
fn guarded(session: &mut Session, post: &Post, job: impl FnOnce(&mut Session, &mut dyn FnMut(Output))) {
    let mut sink = |output| match output {
        Output::Event(event) => post.event(event),
        Output::Frame(run, frame) => post.frame(run, frame),
    };
    let caught = catch_unwind(AssertUnwindSafe(|| job(session, &mut sink)));
    if let Err(panic) = caught {
        let words = panic.downcast_ref::<&str>().map(|s| (*s).to_owned()).or_else(|| panic.downcast_ref::<String>().cloned());
        let run = session.recover();
        post.event(Event::Failed {
            run,
            message: format!("The solver stopped with a fault of its own: {}", words.unwrap_or_else(|| "no words".into())),
            remedy: "It rests on the last good state. Please save the scene and report it.".into(),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::scene::{Cell, Drive, LawChoice, Points, Range, Scene, Turn};
    use crate::physics::indenter::Indenter;
    use crate::physics::law::{Morse, Shape};
    use crate::solver::methods::MethodKind;

    fn scene() -> Scene {
        Scene {
            title: "test".into(),
            source: String::new(),
            cell: Cell { length: 256.0, points: Points::Square(32) },
            law: LawChoice { shape: Shape::Morse(Morse), surface_energy: 0.15, range: Range::Length(1.0) },
            indenter: Indenter::Flat,
            drive: Drive { start: 4.2, turn: Turn::At(0.2), step: 0.02 },
            accuracy: 0.01,
            seed: 1,
        }
    }

    #[test]
    fn a_panic_is_told_once_and_the_session_goes_on_from_the_last_good_state() {
        let (outbox, events) = unbounded();
        let (mailbox, stale) = bounded(1);
        let post = Post { outbox, mailbox, stale, wake: Arc::new(|| {}) };
        let mut session = Session::default();
        let scene = Arc::new(scene());
        let method = MethodKind::NewtonKrylov;
        let commands = [
            Command::SetScene { run: 3, scene, method, asked: None },
            Command::SetTarget { run: 3, motion: 1, mean_displacement: 4.0 },
        ];
        let cancel = Cancel::default();
        for command in commands {
            guarded(&mut session, &post, |session, sink| session.command(command, &cancel, sink));
        }
        for _ in 0..4 {
            work(&mut session, &post, &cancel);
        }
        events.try_iter().for_each(drop);
        guarded(&mut session, &post, |_, _| panic!("a fault for the test"));
        let told: Vec<Event> = events.try_iter().collect();
        assert!(
            matches!(&told[..], [Event::Failed { run: 3, message, .. }] if message.contains("a fault for the test")),
            "{told:?}"
        );
        guarded(&mut session, &post, |session, sink| {
            session.command(Command::SetTarget { run: 3, motion: 2, mean_displacement: 4.19 }, &cancel, sink)
        });
        work(&mut session, &post, &cancel);
        let next =
            events.try_iter().find_map(|e| if let Event::State { state, .. } = e { Some(state.mean_displacement) } else { None });
        // Four steps of 0.02 down from 4.2, then one up.
        assert!((next.unwrap() - 4.14).abs() < 1e-9, "{next:?}");
    }
}
