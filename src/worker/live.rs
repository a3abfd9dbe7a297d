//! The thread of the live loop: the newest scene wins; a coarse loop first, a finer one when the
//! hand rests.

use super::protocol::{Envelope, Event, LiveState, RunId};
use super::system::{self, Instant, JoinHandle};
use crate::numerics::cancel::Cancel;
use crate::scene::{Drive, Model, Scene};
use crate::study::live_loop::{Fineness, LiveLoops};
use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, bounded};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Duration;

/// Silence after which the hand counts as resting.
const REST: Duration = Duration::from_millis(150);

/// A scene whose loop is wanted, with its run.
type Wanted = Envelope<Arc<Scene>>;

/// Handle of the thread.
pub(super) struct Live {
    mailbox: Option<Sender<Wanted>>,
    quit: Cancel,
    stale: Receiver<Wanted>,
    thread: Option<JoinHandle<()>>,
}

impl Live {
    /// Starts the thread; it sleeps until a scene comes.
    pub(super) fn spawn(tell: impl Fn(Envelope<Event>) + Send + 'static) -> Self {
        let (mailbox, wanted) = bounded(1);
        let stale = wanted.clone();
        let quit = Cancel::default();
        let loops = LiveLoops::obeying(&quit);
        let thread = system::spawn("live loop", move || run(&wanted, loops, &tell));
        Self {
            mailbox: Some(mailbox),
            quit,
            stale,
            thread: Some(thread),
        }
    }

    /// Asks for the loop of a scene; a scene that still waits is dropped.
    pub(super) fn ask(&self, run: RunId, scene: Arc<Scene>) {
        let _ = self.stale.try_recv();
        if let Some(mailbox) = &self.mailbox {
            let _ = mailbox.try_send(Envelope {
                run,
                message: scene,
            });
        }
    }

    /// Asks the thread to end, and gives its handle away; `None` if that was done before.
    pub(super) fn ask_to_end(&mut self) -> Option<JoinHandle<()>> {
        self.quit.request();
        let _ = self.stale.try_recv();
        self.mailbox = None;
        self.thread.take()
    }
}

fn run(wanted: &Receiver<Wanted>, mut loops: LiveLoops, tell: &dyn Fn(Envelope<Event>)) {
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
            || computed(&mut loops, &scene, &model, Fineness::Coarse),
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
                    state = computed(&mut loops, &scene, &model, Fineness::Fine);
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

fn computed(
    loops: &mut LiveLoops,
    scene: &Scene,
    model: &Model,
    fineness: Fineness,
) -> Arc<LiveState> {
    let began = Instant::now();
    let found = catch_unwind(AssertUnwindSafe(|| loops.next(scene, model, fineness)));
    let found = match found {
        Ok(found) => found.map_err(|error| error.to_string()),
        // What it holds after a panic is not to be trusted; `next` has taken it out.
        Err(_) => Err("the atlas stopped with a fault of its own".to_owned()),
    };
    Arc::new(LiveState {
        found,
        fineness,
        milliseconds: began.elapsed().as_secs_f64() * 1e3,
    })
}
