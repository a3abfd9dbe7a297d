//! A computation in the background: begun, heard of while it goes on, and stopped by dropping it.

use super::system::{self, Instant};
use crate::numerics::threads::{Cancel, FAULT};
use crossbeam_channel::{Receiver, Sender, unbounded};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Shortest time between two reports that are not urgent.
const PACE: Duration = Duration::from_millis(80);

/// Called, from whatever thread, when there is something new to hear.
pub type Wake = Arc<dyn Fn() + Send + Sync>;

/// A computation under way or done, as its owner sees it. Dropping it cancels it.
#[derive(Debug)]
pub struct Job<T> {
    /// The newest result, partial until the job has ended.
    pub so_far: Option<T>,
    /// Share of the work that is done, 0 to 1.
    pub fraction: f64,
    /// What is being done, in words.
    pub doing: String,
    /// Why it could not be finished.
    pub failed: Option<String>,
    running: bool,
    reports: Receiver<Report<T>>,
    cancel: Cancel,
}

/// The same, as the computation sees it.
pub struct Reporter<T> {
    /// Raised when the result is no longer wanted.
    pub cancel: Cancel,
    reports: Sender<Report<T>>,
    wake: Wake,
    pace: Pace,
}

/// What a job does with its input: it reports as it goes, polls its reporter's `cancel`, and says
/// why it could not be finished.
pub type Compute<I, T> = fn(&I, &Reporter<T>) -> Result<(), String>;

/// Work that waits for somebody to run it, on whatever thread.
pub trait Work: Any + Send {
    /// Does all of it.
    fn run(self: Box<Self>);
}

/// The work of a job.
pub struct Computation<I, T> {
    /// Of what.
    pub input: I,
    /// To whom.
    pub report: Reporter<T>,
    /// How.
    pub compute: Compute<I, T>,
}

impl<I: Send + 'static, T: Send + 'static> Work for Computation<I, T> {
    fn run(self: Box<Self>) {
        to_the_end(&self.report, |report| (self.compute)(&self.input, report));
    }
}

/// Computes, and reports how it ended; a panic is such an end.
fn to_the_end<T>(report: &Reporter<T>, work: impl FnOnce(&Reporter<T>) -> Result<(), String>) {
    let end = catch_unwind(AssertUnwindSafe(|| work(report)));
    report.end(end.unwrap_or_else(|_| Err(FAULT.to_owned())));
}

/// Keeps reports that are not urgent apart.
#[derive(Default)]
pub(super) struct Pace {
    told: Mutex<Option<Instant>>,
}

#[derive(Debug)]
enum Report<T> {
    Progress(f64, String),
    Result(T),
    End(Result<(), String>),
}

impl<T> Job<T> {
    /// Both ends of a job that somebody else computes; `wake` is called when there is something to
    /// hear.
    pub fn new(wake: Wake) -> (Self, Reporter<T>) {
        let (sender, reports) = unbounded();
        let cancel = Cancel::default();
        let reporter = Reporter {
            cancel: cancel.clone(),
            reports: sender,
            wake,
            pace: Pace::default(),
        };
        (
            Self {
                so_far: None,
                fraction: 0.0,
                doing: "beginning".to_owned(),
                failed: None,
                running: true,
                reports,
                cancel,
            },
            reporter,
        )
    }

    /// Takes in what was reported; never blocks. Tells once how the job ended, unless it was
    /// stopped: the error is why it could not be finished.
    pub fn poll(&mut self) -> Option<Result<(), String>> {
        for report in self.reports.try_iter() {
            match report {
                Report::Progress(fraction, doing) => {
                    (self.fraction, self.doing) = (fraction, doing);
                }
                Report::Result(result) => self.so_far = Some(result),
                Report::End(end) => {
                    let heard = self.is_running();
                    self.running = false;
                    self.failed = end.as_ref().err().filter(|_| heard).cloned();
                    return heard.then_some(end);
                }
            }
        }
        None
    }

    /// True until it has ended or was stopped.
    pub fn is_running(&self) -> bool {
        self.running && !self.cancel.requested()
    }

    /// Stops it; what there is stays, and what it still finds on its way out is taken in.
    pub fn stop(&self) {
        self.cancel.request();
    }

    /// What stops it, for somebody who does not hold it.
    pub fn cancel(&self) -> Cancel {
        self.cancel.clone()
    }
}

impl<T: Send + 'static> Job<T> {
    /// Begins a computation on a thread of its own. It polls its reporter's `cancel`, and says why
    /// it could not be finished.
    pub fn start(
        wake: Wake,
        work: impl FnOnce(&Reporter<T>) -> Result<(), String> + Send + 'static,
    ) -> Self {
        let (job, reporter) = Self::new(wake);
        system::spawn("job", move || {
            to_the_end(&reporter, work);
        });
        job
    }
}

impl Pace {
    /// True, at most once in a while.
    pub(super) fn is_due(&self) -> bool {
        let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
        let due = told.is_none_or(|told| told.elapsed() >= PACE);
        if due {
            *told = Some(Instant::now());
        }
        due
    }
}

impl<T> Drop for Job<T> {
    fn drop(&mut self) {
        self.cancel.request();
    }
}

impl<T> Reporter<T> {
    /// True if the last report was long enough ago for another one that is not urgent.
    pub fn is_due(&self) -> bool {
        self.pace.is_due()
    }

    /// Reports the share that is done (0 to 1) and what is being done.
    pub fn progress(&self, fraction: f64, doing: &str) {
        self.send(Report::Progress(fraction, doing.to_owned()));
    }

    /// Reports a result, partial or not; it replaces the one before.
    pub fn result(&self, result: T) {
        self.send(Report::Result(result));
    }

    /// Reports the end, after which nothing more is heard.
    pub fn end(&self, end: Result<(), String>) {
        self.send(Report::End(end));
    }

    fn send(&self, report: Report<T>) {
        // A job that was dropped hears nothing.
        let _ = self.reports.send(report);
        (self.wake)();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Waits for the end.
    fn ended<T>(job: &mut Job<T>) -> Result<(), String> {
        let began = Instant::now();
        while began.elapsed() < Duration::from_secs(5) {
            if let Some(end) = job.poll() {
                return end;
            }
            system::sleep(Duration::from_millis(1));
        }
        panic!("it did not end");
    }

    #[test]
    fn a_job_is_heard_of_while_it_goes_on_and_ends_once_well_or_badly() {
        let (go, gate) = unbounded::<()>();
        let (woken, bell) = unbounded();
        let mut job = Job::start(
            Arc::new(move || woken.send(()).unwrap_or_default()),
            move |report| {
                report.progress(0.5, "half");
                report.result(7);
                let _ = gate.recv();
                Ok(())
            },
        );
        bell.recv_timeout(Duration::from_secs(5)).unwrap();
        bell.recv_timeout(Duration::from_secs(5)).unwrap();
        assert_eq!(
            (
                job.poll(),
                job.so_far,
                job.fraction,
                job.doing.as_str(),
                job.is_running()
            ),
            (None, Some(7), 0.5, "half", true)
        );
        go.send(()).unwrap();
        assert_eq!(ended(&mut job), Ok(()));
        assert_eq!(
            (job.poll(), job.so_far, job.is_running()),
            (None, Some(7), false)
        );
        let mut job = Job::<()>::start(Arc::new(|| {}), |_| Err("no".to_owned()));
        assert_eq!(ended(&mut job), Err("no".to_owned()));
        assert_eq!(job.failed.as_deref(), Some("no"));
        let mut job = Job::<()>::start(Arc::new(|| {}), |_| panic!("for the test"));
        assert_eq!(ended(&mut job), Err(FAULT.to_owned()));
    }

    #[test]
    fn a_job_is_cancelled_by_a_stop_and_by_dropping_it_and_neither_waits() {
        let (say, heard) = unbounded();
        let start = |name: u32| {
            let say = say.clone();
            Job::<u32>::start(Arc::new(|| {}), move |report| {
                while !report.cancel.requested() {
                    system::sleep(Duration::from_millis(1));
                }
                report.result(name);
                say.send(name).map_err(|error| error.to_string())
            })
        };
        let next = || {
            heard
                .recv_timeout(Duration::from_secs(5))
                .expect("cancelled")
        };
        let mut job = start(1);
        job.stop();
        assert!(!job.is_running());
        assert_eq!(next(), 1);
        assert_eq!(
            (job.poll(), job.so_far),
            (None, Some(1)),
            "what it found on its way out stays"
        );
        job = start(2);
        job = {
            drop(job);
            start(3)
        };
        assert_eq!(next(), 2);
        drop(job);
        assert_eq!(next(), 3);
        let began = Instant::now();
        drop(Job::<()>::start(Arc::new(|| {}), |_| {
            system::sleep(Duration::from_secs(60));
            Ok(())
        }));
        assert!(began.elapsed() < Duration::from_secs(1));
    }
}
