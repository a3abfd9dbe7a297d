//! The end of threads: all are asked at once, and whoever does not answer in time is left to end with the process.

use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How long threads may take to end, all together: a window closes within two seconds.
const PATIENCE: Duration = Duration::from_secs(1);

/// How often a thread is looked at.
const LOOK: Duration = Duration::from_millis(2);

/// Something with a thread.
pub(super) trait Ending {
    /// Asks the thread to end, and gives its handle away; `None` if that was done before.
    fn ask_to_end(&mut self) -> Option<JoinHandle<()>>;
}

/// Ends the threads of `all`.
pub(super) fn end(all: &mut [&mut dyn Ending]) {
    let threads: Vec<_> = all.iter_mut().filter_map(|one| one.ask_to_end()).collect();
    let begin = Instant::now();
    for thread in threads {
        while !thread.is_finished() && begin.elapsed() < PATIENCE {
            std::thread::sleep(LOOK);
        }
        if thread.is_finished() {
            // A panic has been told by the thread itself.
            let _ = thread.join();
        }
    }
}
