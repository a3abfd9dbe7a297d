//! The two threads: the solver's, commands in, events out, the newest picture in a mailbox; and
//! beside it the live loop's, where the newest scene wins: a coarse loop first, a finer one when
//! the hand rests.

use super::background::live_state;
use super::job::{Wake, Work};
use super::protocol::{Command, Envelope, Event, Failure, LiveState, RunId, SolverHandle};
use super::session::Session;
use super::system::{self, Instant, JoinHandle};
use crate::numerics::cancel::Cancel;
use crate::scene::{Drive, Model, Scene};
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
            Command::SetScene { .. } | Command::GoOn { .. } | Command::Stop { .. } | Command::Quit
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
        sink(Event::Failed(Failure {
            message: format!(
                "The solver stopped with a fault of its own: {}",
                words.unwrap_or_else(|| "no words".into())
            ),
            remedy: "It rests on the last good state. Please save the scene and report it.".into(),
        }));
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::tests::fig2;
    use crate::solver::methods::MethodKind;

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
            Command::SetTarget {
                motion: 1,
                control: 4.0,
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
        let target = of_run_3(Command::SetTarget {
            motion: 2,
            control: 4.19,
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
