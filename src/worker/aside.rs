//! A thread for jobs beside the walk: one at a time, and the newest wins.

use super::end::{Ending, end};
use crate::numerics::cancel::Cancel;
use crossbeam_channel::{Receiver, Sender, unbounded};
use std::sync::{Mutex, PoisonError};
use std::thread::JoinHandle;

/// Handle of the thread. Dropping it cancels, and waits for it a little.
pub(super) struct Aside<J> {
    /// `None` once it is told to end.
    orders: Option<Sender<(J, Cancel)>>,
    /// Raised when the thread shall end; every job's token is a part of it.
    quit: Cancel,
    /// The token of the newest job.
    newest: Mutex<Cancel>,
    thread: Option<JoinHandle<()>>,
}

impl<J: Send + 'static> Aside<J> {
    /// Starts the thread; it sleeps until there is a job. A job polls the token it is given.
    pub(super) fn spawn(name: &str, work: impl Fn(J, &Cancel) + Send + 'static) -> Self {
        let (orders, inbox) = unbounded();
        let thread = std::thread::Builder::new()
            .name(name.into())
            .spawn(move || run(&inbox, &work))
            .expect("the system refuses to start a thread");
        Self { orders: Some(orders), quit: Cancel::default(), newest: Mutex::default(), thread: Some(thread) }
    }

    /// Begins a job; one under way, or one that waits, is dropped.
    pub(super) fn start(&self, job: J) {
        let token = self.quit.part();
        std::mem::replace(&mut *self.newest.lock().unwrap_or_else(PoisonError::into_inner), token.clone()).request();
        if let Some(orders) = &self.orders {
            // The thread lives as long as this handle, so the channel is open.
            let _ = orders.send((job, token));
        }
    }

    /// Drops the job under way.
    pub(super) fn stop(&self) {
        self.newest.lock().unwrap_or_else(PoisonError::into_inner).request();
    }
}

impl<J> Ending for Aside<J> {
    fn ask_to_end(&mut self) -> Option<JoinHandle<()>> {
        self.quit.request();
        self.orders = None;
        self.thread.take()
    }
}

impl<J> Drop for Aside<J> {
    fn drop(&mut self) {
        end(&mut [self]);
    }
}

fn run<J>(inbox: &Receiver<(J, Cancel)>, work: &dyn Fn(J, &Cancel)) {
    for (job, token) in inbox {
        // One that was dropped while it waited says that it is over.
        work(job, &token);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::{Duration, Instant};

    #[test]
    fn a_job_is_cancelled_by_the_next_one_by_a_stop_and_by_the_end() {
        let (say, heard) = unbounded();
        let aside = Aside::spawn("test", move |job: u32, cancel: &Cancel| {
            while !cancel.requested() {
                std::thread::sleep(Duration::from_millis(1));
            }
            let _ = say.send(job);
        });
        let next = || heard.recv_timeout(Duration::from_secs(5)).expect("cancelled");
        aside.start(1);
        std::thread::sleep(Duration::from_millis(50));
        aside.start(2);
        assert_eq!(next(), 1);
        std::thread::sleep(Duration::from_millis(50));
        aside.stop();
        assert_eq!(next(), 2);
        aside.start(3);
        std::thread::sleep(Duration::from_millis(50));
        drop(aside);
        assert_eq!(next(), 3);
    }

    #[test]
    fn a_job_that_does_not_answer_does_not_keep_its_handle() {
        let aside = Aside::spawn("deaf", |(), _: &Cancel| std::thread::sleep(Duration::from_secs(60)));
        aside.start(());
        std::thread::sleep(Duration::from_millis(20));
        let began = Instant::now();
        drop(aside);
        assert!(began.elapsed() < Duration::from_secs(2));
    }
}
