//! Requests from outside to end: Ctrl-C, SIGTERM (batch systems, `kill`), SIGHUP (a terminal that
//! closes).

use super::system::{Instant, sleep, try_spawn};
use crate::numerics::cancel::Cancel;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::process::exit;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// SIGHUP, which only Unix has.
const SIGHUP: i32 = 1;
/// Requests within this time of the first are the same one: `timeout` sends two, a batch system one
/// to each of several processes.
const SAME: Duration = Duration::from_secs(2);
/// How often the flag is looked at.
const PACE: Duration = Duration::from_millis(20);
/// Longest time that the end waits for a file to be complete.
const PATIENCE: Duration = Duration::from_secs(2);

/// What a request means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Meaning {
    /// Stop computing and write what there is.
    Stop,
    /// What has been asked for already.
    Same,
    /// End at once.
    End,
}

fn meaning(first: Option<Instant>, now: Instant) -> Meaning {
    match first {
        None => Meaning::Stop,
        Some(first) if now.duration_since(first) < SAME => Meaning::Same,
        Some(_) => Meaning::End,
    }
}

/// A token that the first request raises. A later one, after two seconds, ends the process with
/// `code` as soon as `at_rest` gives the guard that keeps files from being half written. Signals
/// that the process was told to ignore when it was started (`nohup`, `&` in a script) stay ignored:
/// `status` is what the system says of it, as in /proc/self/status.
pub fn cancel_on_signal<G>(status: &str, at_rest: fn() -> Option<G>, code: i32) -> Cancel
where
    G: 'static,
{
    let ignored = ignored_in(status);
    let cancel = Cancel::default();
    let (token, heard) = (cancel.clone(), Arc::new(AtomicBool::new(false)));
    let asked = heard.clone();
    let watch = try_spawn("signals", move || {
        let mut first = None;
        loop {
            sleep(PACE);
            if !asked.swap(false, Ordering::Relaxed) {
                continue;
            }
            match meaning(first, Instant::now()) {
                Meaning::Stop => {
                    first = Some(Instant::now());
                    token.request();
                }
                Meaning::Same => {}
                Meaning::End => end(at_rest, code),
            }
        }
    });
    // Without somebody who listens a signal ends the process the hard way: worse, yet no reason not
    // to run.
    if watch.is_ok() {
        for signal in [SIGINT, SIGTERM]
            .into_iter()
            .chain(cfg!(unix).then_some(SIGHUP))
        {
            if ignored >> (signal - 1) & 1 == 0 {
                let _ = flag::register(signal, heard.clone());
            }
        }
    }
    cancel
}

/// The signals that are ignored, as a mask: bit 0 is signal 1. None where the status does not say.
fn ignored_in(status: &str) -> u64 {
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .unwrap_or(0)
}

fn end<G>(at_rest: fn() -> Option<G>, code: i32) {
    let begin = Instant::now();
    let mut guard = at_rest();
    while guard.is_none() && begin.elapsed() < PATIENCE {
        sleep(PACE);
        guard = at_rest();
    }
    exit(code);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_requests_in_a_row_are_one_and_only_a_later_one_ends_the_process() {
        let begin = Instant::now();
        let after = |ms| begin + Duration::from_millis(ms);
        assert_eq!(meaning(None, begin), Meaning::Stop);
        assert_eq!(
            [0, 5, 1999].map(|ms| meaning(Some(begin), after(ms))),
            [Meaning::Same; 3]
        );
        assert_eq!(
            [2000, 60_000].map(|ms| meaning(Some(begin), after(ms))),
            [Meaning::End; 2]
        );
    }

    #[test]
    fn the_mask_is_read_where_there_is_one() {
        assert_eq!(
            ignored_in("Name:\tx\nSigBlk:\t0000000000000002\nSigIgn:\t0000000000001001\n"),
            0x1001
        );
        assert_eq!([ignored_in(""), ignored_in("SigIgn:\tmany\n")], [0, 0]);
    }
}
