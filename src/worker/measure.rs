//! The thread for measurements beside the walk: one at a time, the newest wins, partial results as they come.

use super::protocol::{Errand, Event, RunId};
use crate::experiment::time_step_map::{Progress, Survey};
use crate::numerics::cancel::Cancel;
use crossbeam_channel::{Receiver, Sender, unbounded};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Shortest time between two partial results.
const PACE: Duration = Duration::from_millis(80);

/// What the thread is told.
enum Order {
    Start(RunId, Errand),
    Stop,
    Quit,
}

/// Handle of the thread. Dropping it cancels and joins.
pub(super) struct Bench {
    orders: Sender<Order>,
    cancel: Cancel,
    thread: Option<JoinHandle<()>>,
}

impl Bench {
    /// Starts the thread; it sleeps until there is something to measure.
    pub(super) fn spawn(tell: impl Fn(Event) + Send + 'static) -> Self {
        let (orders, inbox) = unbounded();
        let cancel = Cancel::default();
        let token = cancel.clone();
        let thread = std::thread::Builder::new()
            .name("measurements".into())
            .spawn(move || run(&inbox, &tell, &token))
            .expect("the system refuses to start a thread");
        Self { orders, cancel, thread: Some(thread) }
    }

    /// Begins a measurement; one under way is dropped.
    pub(super) fn start(&self, run: RunId, errand: Errand) {
        self.order(Order::Start(run, errand));
    }

    /// Drops the measurement under way.
    pub(super) fn stop(&self) {
        self.order(Order::Stop);
    }

    fn order(&self, order: Order) {
        self.cancel.request();
        // The thread lives as long as this handle, so the channel is open.
        let _ = self.orders.send(order);
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        self.order(Order::Quit);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn run(inbox: &Receiver<Order>, tell: &dyn Fn(Event), cancel: &Cancel) {
    while let Ok(order) = inbox.recv() {
        let (run, errand) = match order {
            Order::Start(run, errand) => (run, errand),
            Order::Stop => continue,
            Order::Quit => return,
        };
        cancel.clear();
        // An order that came in between has asked for the cancel that was just cleared: it is seen in the inbox.
        let goes_on = || inbox.is_empty() && !cancel.requested();
        let measured = catch_unwind(AssertUnwindSafe(|| match errand {
            Errand::TimeSteps { scene, turn } => match Survey::new(&scene, turn) {
                Ok(survey) => time_steps(run, survey, tell, cancel, &goes_on),
                Err(error) => Some(error.to_string()),
            },
        }));
        let stuck = measured.unwrap_or_else(|_| Some("the solver stopped with a fault of its own".to_owned()));
        tell(Event::Measured { run, stuck });
    }
}

/// Returns why it could not be finished, if so.
fn time_steps(run: RunId, mut survey: Survey, tell: &dyn Fn(Event), cancel: &Cancel, goes_on: &dyn Fn() -> bool) -> Option<String> {
    let mut told = Instant::now();
    let mut stuck = None;
    while goes_on() {
        match survey.step(cancel) {
            Progress::Working => {}
            Progress::Done | Progress::Cancelled => break,
            Progress::Stuck(message) => {
                stuck = Some(message);
                break;
            }
        }
        if told.elapsed() >= PACE {
            told = Instant::now();
            tell(Event::TimeSteps { run, map: Arc::new(survey.map().clone()) });
        }
    }
    tell(Event::TimeSteps { run, map: Arc::new(survey.map().clone()) });
    stuck
}
