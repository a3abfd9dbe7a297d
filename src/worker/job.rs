//! One piece of work on a thread of its own whose result is asked for: reading a file, which may take as long as it likes.

use crossbeam_channel::{Receiver, bounded};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// The work under way. Dropping it forgets the result: work that waits for the system cannot be cancelled, and ends with the process.
pub struct Job<T> {
    result: Receiver<Option<T>>,
}

/// What has become of a job.
#[derive(Debug, PartialEq, Eq)]
pub enum Fate<T> {
    /// It is under way.
    Working,
    /// It is done.
    Done(T),
    /// It has failed by a fault of its own.
    Lost,
}

impl<T: Send + 'static> Job<T> {
    /// Begins; `wake` is called (from the thread) when there is something to ask for.
    pub fn spawn(work: impl FnOnce() -> T + Send + 'static, wake: impl FnOnce() + Send + 'static) -> Self {
        let (post, result) = bounded(1);
        std::thread::Builder::new()
            .name("job".into())
            .spawn(move || {
                let _ = post.send(catch_unwind(AssertUnwindSafe(work)).ok());
                wake();
            })
            .expect("the system refuses to start a thread");
        Self { result }
    }

    /// What has become of it; never blocks. A result is given once.
    pub fn poll(&self) -> Fate<T> {
        match self.result.try_recv() {
            Ok(Some(result)) => Fate::Done(result),
            Ok(None) => Fate::Lost,
            Err(crossbeam_channel::TryRecvError::Empty) => Fate::Working,
            Err(crossbeam_channel::TryRecvError::Disconnected) => Fate::Lost,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn a_job_is_under_way_until_it_is_done_or_lost() {
        let (go, gate) = bounded::<bool>(0);
        let (woken, bell) = bounded(1);
        let wake = move || woken.send(()).unwrap_or_default();
        let job = Job::spawn(move || if gate.recv().unwrap_or(false) { 7 } else { panic!("for the test") }, wake);
        assert_eq!(job.poll(), Fate::Working);
        go.send(true).unwrap();
        bell.recv_timeout(Duration::from_secs(5)).unwrap();
        assert_eq!(job.poll(), Fate::Done(7));
        let (woken, bell) = bounded(1);
        let job: Job<()> = Job::spawn(|| panic!("for the test"), move || woken.send(()).unwrap_or_default());
        bell.recv_timeout(Duration::from_secs(5)).unwrap();
        assert_eq!(job.poll(), Fate::Lost);
    }
}
