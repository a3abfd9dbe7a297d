//! The one door to threads, to the clock, to other programs, of which one plays a file of sound, and to
//! requests from outside to end: Ctrl-C, SIGTERM (batch systems, `kill`), SIGHUP (a terminal that
//! closes). It is what a program without them (a browser's) replaces.

use crate::numerics::threads::Cancel;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::io::{self, ErrorKind};
use std::path::Path;
use std::process::{Command, Stdio, exit};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{Builder, available_parallelism, scope};
use std::time::Duration;

pub(super) use std::thread::{JoinHandle, sleep};
pub(super) use std::time::Instant;

/// The niceness of a thread that computes: its share of a busy core is a ninth of the window's.
#[cfg(target_os = "linux")]
const GIVES_WAY: i32 = 10;
/// How long threads may take to end, all together: a window closes within two seconds.
const PATIENCE: Duration = Duration::from_secs(1);
/// How often a thread or a program is looked at.
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

/// A program that plays files.
#[derive(Clone, Copy)]
struct Player {
    program: &'static str,
    /// What it is told; [`FILE`] stands for the path.
    arguments: &'static [&'static str],
}

const FILE: &str = "FILE";
/// Where a player that is a language finds the path, whatever letters it has.
const VARIABLE: &str = "TACKSCOPE_SOUND";

/// The players in the order in which they are tried. With their own latencies some of them take two
/// seconds for a click.
const PLAYERS: &[Player] = if cfg!(windows) {
    &[Player {
        program: "powershell",
        arguments: &[
            "-NoProfile",
            "-Command",
            "(New-Object System.Media.SoundPlayer $env:TACKSCOPE_SOUND).PlaySync()",
        ],
    }]
} else if cfg!(target_os = "macos") {
    &[Player {
        program: "afplay",
        arguments: &[FILE],
    }]
} else {
    &[
        Player {
            program: "pw-play",
            arguments: &["--latency=30ms", FILE],
        },
        Player {
            program: "paplay",
            arguments: &["--latency-msec=30", FILE],
        },
        Player {
            program: "aplay",
            arguments: &["-q", "--buffer-time=50000", FILE],
        },
    ]
};

/// The Debian package of a player.
const PACKAGE: &str = "pulseaudio-utils";

/// How long a player may take: one that waits for a server of sound that does not answer is ended.
const PLAYED: Duration = Duration::from_secs(3);

/// Plays a file of sound to its end by the first program that can.
///
/// # Errors
/// In words, there is none.
pub fn play(file: &Path) -> Result<(), String> {
    by_one_of(PLAYERS, file)
}

fn by_one_of(players: &[Player], file: &Path) -> Result<(), String> {
    let mut failed = Vec::new();
    for player in players {
        match player.play(file) {
            Some(Ok(())) => return Ok(()),
            Some(Err(why)) => failed.push(format!("{}: {why}", player.program)),
            None => {}
        }
    }
    if !failed.is_empty() {
        return Err(failed.join("; "));
    }
    let names: Vec<&str> = players.iter().map(|player| player.program).collect();
    let debian = if cfg!(target_os = "linux") {
        format!(" (on Debian: apt install {PACKAGE})")
    } else {
        String::new()
    };
    let names = names.join(", ");
    Err(format!("none of these players is there: {names}{debian}"))
}

impl Player {
    /// Plays a file; `None` where there is no such program.
    fn play(&self, file: &Path) -> Option<Result<(), String>> {
        let mut command = Command::new(self.program);
        for argument in self.arguments {
            if *argument == FILE {
                command.arg(file);
            } else {
                command.arg(argument);
            }
        }
        command
            .env(VARIABLE, file)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null());
        // No console opens for it.
        #[cfg(windows)]
        {
            const NO_WINDOW: u32 = 0x0800_0000;
            std::os::windows::process::CommandExt::creation_flags(&mut command, NO_WINDOW);
        }
        let mut child = match command.spawn() {
            Ok(child) => child,
            Err(error) if error.kind() == ErrorKind::NotFound => return None,
            Err(error) => return Some(Err(error.to_string())),
        };
        let begun = Instant::now();
        Some(loop {
            match child.try_wait() {
                Ok(Some(status)) if status.success() => break Ok(()),
                Ok(Some(status)) => break Err(status.to_string()),
                Ok(None) if begun.elapsed() < PLAYED => sleep(LOOK),
                Ok(None) => {
                    // One that has ended meanwhile needs no end.
                    let _ = child.kill();
                    let _ = child.wait();
                    break Err("it does not come to its end".to_owned());
                }
                Err(error) => break Err(error.to_string()),
            }
        })
    }
}

/// SIGHUP, which only Unix has.
const SIGHUP: i32 = 1;
/// Requests within this time of the first are the same one: `timeout` sends two, a batch system one
/// to each of several processes.
const SAME: Duration = Duration::from_secs(2);
/// How often the flag is looked at.
const LISTEN: Duration = Duration::from_millis(20);
/// Longest time that the end waits for a file to be complete.
const AT_REST: Duration = Duration::from_secs(2);

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
            sleep(LISTEN);
            if !asked.swap(false, Ordering::Relaxed) {
                continue;
            }
            match meaning(first, Instant::now()) {
                Meaning::Stop => {
                    first = Some(Instant::now());
                    token.request();
                }
                Meaning::Same => {}
                Meaning::End => end_process(at_rest, code),
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

fn end_process<G>(at_rest: fn() -> Option<G>, code: i32) {
    let begin = Instant::now();
    let mut guard = at_rest();
    while guard.is_none() && begin.elapsed() < AT_REST {
        sleep(LISTEN);
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

    #[cfg(unix)]
    mod threads_and_players {
        use super::*;

        const MISSING: Player = Player {
            program: "no-such-player-of-sound",
            arguments: &[FILE],
        };

        const fn shell(arguments: &'static [&'static str]) -> Player {
            Player {
                program: "sh",
                arguments,
            }
        }

        #[test]
        fn the_first_player_that_can_plays_and_hears_the_path_whatever_its_letters() {
            let path = Path::new("/a folder/it's a \"click\".wav");
            let by_place = shell(&[
                "-c",
                "test \"$1\" = \"/a folder/it's a \\\"click\\\".wav\"",
                "sh",
                FILE,
            ]);
            let by_name = shell(&[
                "-c",
                "test \"$TACKSCOPE_SOUND\" = \"/a folder/it's a \\\"click\\\".wav\"",
            ]);
            let fails = shell(&["-c", "exit 3"]);
            for can in [by_place, by_name] {
                assert_eq!(by_one_of(&[MISSING, fails, can], path), Ok(()));
            }
        }

        #[test]
        fn where_nothing_plays_it_is_said_what_would() {
            let why = by_one_of(&[MISSING], Path::new("a.wav")).unwrap_err();
            assert!(why.contains("no-such-player-of-sound"), "{why}");
            assert_eq!(why.contains(PACKAGE), cfg!(target_os = "linux"), "{why}");
            let fails = shell(&["-c", "exit 3"]);
            let why = by_one_of(&[MISSING, fails], Path::new("a.wav")).unwrap_err();
            assert!(why.starts_with("sh: ") && why.contains('3'), "{why}");
        }

        #[test]
        fn a_player_that_does_not_end_is_ended() {
            let begun = Instant::now();
            let waits = shell(&["-c", "exec sleep 60"]);
            let why = by_one_of(&[waits], Path::new("a.wav")).unwrap_err();
            assert!(why.contains("does not come to its end"), "{why}");
            assert!(begun.elapsed() < Duration::from_secs(20));
        }

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
}
