//! A thread for jobs beside the walk: one at a time, and the newest wins.

use crate::numerics::cancel::Cancel;
use crossbeam_channel::{Receiver, Sender, unbounded};
use std::thread::JoinHandle;

/// What the thread is told.
enum Order<J> {
    Start(J),
    Stop,
    Quit,
}

/// Handle of the thread. Dropping it cancels and joins.
pub(super) struct Aside<J> {
    orders: Sender<Order<J>>,
    cancel: Cancel,
    thread: Option<JoinHandle<()>>,
}

/// What a job may ask while it works.
pub(super) struct Leave<'a> {
    /// Raised when a newer order has come.
    pub(super) cancel: &'a Cancel,
    waiting: &'a (dyn Fn() -> bool + Sync),
}

impl Leave<'_> {
    /// Whether to go on. An order that came just before the job began is seen here, and in the cancel token from then on.
    pub(super) fn goes_on(&self) -> bool {
        if (self.waiting)() {
            self.cancel.request();
        }
        !self.cancel.requested()
    }
}

impl<J: Send + 'static> Aside<J> {
    /// Starts the thread; it sleeps until there is a job.
    pub(super) fn spawn(name: &str, work: impl Fn(J, &Leave<'_>) + Send + 'static) -> Self {
        let (orders, inbox) = unbounded();
        let cancel = Cancel::default();
        let token = cancel.clone();
        let thread = std::thread::Builder::new()
            .name(name.into())
            .spawn(move || run(&inbox, &work, &token))
            .expect("the system refuses to start a thread");
        Self { orders, cancel, thread: Some(thread) }
    }

    /// Begins a job; one under way is dropped.
    pub(super) fn start(&self, job: J) {
        self.order(Order::Start(job));
    }

    /// Drops the job under way.
    pub(super) fn stop(&self) {
        self.order(Order::Stop);
    }
}

impl<J> Aside<J> {
    fn order(&self, order: Order<J>) {
        self.cancel.request();
        // The thread lives as long as this handle, so the channel is open.
        let _ = self.orders.send(order);
    }
}

impl<J> Drop for Aside<J> {
    fn drop(&mut self) {
        self.order(Order::Quit);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn run<J: Send>(inbox: &Receiver<Order<J>>, work: &dyn Fn(J, &Leave<'_>), cancel: &Cancel) {
    while let Ok(order) = inbox.recv() {
        match order {
            Order::Start(job) => {
                cancel.clear();
                // An order that came in between has asked for the cancel that was just cleared: it is seen in the inbox.
                work(job, &Leave { cancel, waiting: &|| !inbox.is_empty() });
            }
            Order::Stop => {}
            Order::Quit => return,
        }
    }
}
