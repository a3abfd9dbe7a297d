//! The thread of the live loop: the newest scene wins; a coarse loop first, a finer one when the hand rests.

use super::end::{Ending, end};
use super::protocol::{Event, LiveState, RunId};
use crate::experiment::live_loop::{Fineness, LiveLoops};
use crate::experiment::scene::{Drive, Model, Scene};
use crate::numerics::cancel::Cancel;
use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, bounded};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Silence after which the hand counts as resting.
const REST: Duration = Duration::from_millis(150);

/// A scene whose loop is wanted.
struct Wish {
    run: RunId,
    scene: Arc<Scene>,
}

/// Handle of the thread. Dropping it cancels, and waits for it a little.
pub(super) struct Live {
    mailbox: Option<Sender<Wish>>,
    quit: Cancel,
    stale: Receiver<Wish>,
    thread: Option<JoinHandle<()>>,
}

impl Live {
    /// Starts the thread; it sleeps until a scene comes.
    pub(super) fn spawn(tell: impl Fn(Event) + Send + 'static) -> Self {
        let (mailbox, wishes) = bounded(1);
        let stale = wishes.clone();
        let quit = Cancel::default();
        let loops = LiveLoops::obeying(&quit);
        let thread = std::thread::Builder::new()
            .name("live loop".into())
            .spawn(move || run(&wishes, loops, &tell))
            .expect("the system refuses to start a thread");
        Self { mailbox: Some(mailbox), quit, stale, thread: Some(thread) }
    }

    /// Asks for the loop of a scene; a scene that still waits is dropped.
    pub(super) fn ask(&self, run: RunId, scene: Arc<Scene>) {
        let _ = self.stale.try_recv();
        if let Some(mailbox) = &self.mailbox {
            let _ = mailbox.try_send(Wish { run, scene });
        }
    }
}

impl Ending for Live {
    fn ask_to_end(&mut self) -> Option<JoinHandle<()>> {
        self.quit.request();
        let _ = self.stale.try_recv();
        self.mailbox = None;
        self.thread.take()
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        end(&mut [self]);
    }
}

fn run(wishes: &Receiver<Wish>, mut loops: LiveLoops, tell: &dyn Fn(Event)) {
    let mut known: Option<(Model, Drive, u64, Arc<LiveState>)> = None;
    let mut next = wishes.recv().ok();
    while let Some(wish) = next.take() {
        let Ok(model) = wish.scene.model() else {
            next = wishes.recv().ok();
            continue;
        };
        let (drive, seed) = (wish.scene.drive, wish.scene.seed);
        // A reset, another method: the loop stays what it was.
        let same = known.take().filter(|(m, d, s, _)| *m == model && *d == drive && *s == seed);
        let mut state = same.map_or_else(|| computed(&mut loops, &wish.scene, &model, Fineness::Coarse), |(.., state)| state);
        tell(Event::Live { run: wish.run, live: state.clone() });
        if state.fineness == Fineness::Coarse {
            match wishes.recv_timeout(REST) {
                Ok(newer) => next = Some(newer),
                Err(RecvTimeoutError::Disconnected) => return,
                Err(RecvTimeoutError::Timeout) => {
                    state = computed(&mut loops, &wish.scene, &model, Fineness::Fine);
                    tell(Event::Live { run: wish.run, live: state.clone() });
                }
            }
        }
        known = Some((model, drive, seed, state));
        if next.is_none() {
            next = wishes.recv().ok();
        }
    }
}

fn computed(loops: &mut LiveLoops, scene: &Scene, model: &Model, fineness: Fineness) -> Arc<LiveState> {
    let began = Instant::now();
    let found = catch_unwind(AssertUnwindSafe(|| loops.next(scene, model, fineness)));
    let found = match found {
        Ok(found) => found.map_err(|error| error.to_string()),
        // What it holds after a panic is not to be trusted; `next` has taken it out.
        Err(_) => Err("the atlas stopped with a fault of its own".to_owned()),
    };
    Arc::new(LiveState { found, fineness, milliseconds: began.elapsed().as_secs_f64() * 1e3 })
}
