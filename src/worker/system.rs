//! The one door to threads and to the clock: what a program without either (a browser's) replaces.

pub(super) use std::thread::{JoinHandle, sleep};
pub(super) use std::time::Instant;

use std::io;
use std::thread::{Builder, available_parallelism, scope};
use std::time::Duration;

/// The niceness of a thread that computes: its share of a busy core is a ninth of the window's.
#[cfg(target_os = "linux")]
const GIVES_WAY: i32 = 10;
/// How long threads may take to end, all together: a window closes within two seconds.
const PATIENCE: Duration = Duration::from_secs(1);
/// How often a thread is looked at.
const LOOK: Duration = Duration::from_millis(2);

/// Starts a thread.
///
/// # Errors
/// The system refuses.
pub(super) fn try_spawn(
    name: &str,
    work: impl FnOnce() + Send + 'static,
) -> io::Result<JoinHandle<()>> {
    Builder::new().name(name.into()).spawn(work)
}

/// Starts a thread that computes, which the program cannot do without. Others go first: where there
/// are few cores a frame of the window waits for no solver.
pub(super) fn spawn(name: &str, work: impl FnOnce() + Send + 'static) -> JoinHandle<()> {
    let work = || {
        // A refusal changes nothing. Linux alone has a priority for each thread.
        #[cfg(target_os = "linux")]
        let _ = rustix::process::setpriority_process(Some(rustix::thread::gettid()), GIVES_WAY);
        work();
    };
    try_spawn(name, work).expect("the system refuses to start a thread")
}

/// Waits for threads that were asked to end; one that does not answer in time is left to end with
/// the process.
pub(super) fn end(threads: impl IntoIterator<Item = JoinHandle<()>>) {
    let begin = Instant::now();
    for thread in threads {
        while !thread.is_finished() && begin.elapsed() < PATIENCE {
            sleep(LOOK);
        }
        if thread.is_finished() {
            // A panic has been told by the thread itself.
            let _ = thread.join();
        }
    }
}

/// Runs `work` on as many threads as there are cores, at most `most`, and `meanwhile` on this one;
/// returns when all are done.
pub(super) fn on_every_core(most: usize, work: impl Fn() + Sync, meanwhile: impl FnOnce()) {
    let cores = available_parallelism().map_or(1, usize::from);
    scope(|scope| {
        for _ in 0..cores.min(most) {
            scope.spawn(&work);
        }
        meanwhile();
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thread_that_does_not_answer_does_not_keep_the_caller() {
        let began = Instant::now();
        end([
            spawn("busy", || sleep(Duration::from_secs(60))),
            spawn("done", || {}),
        ]);
        assert!(began.elapsed() < Duration::from_secs(2));
    }
}
