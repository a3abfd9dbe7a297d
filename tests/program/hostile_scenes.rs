//! A fuzzer of scene files: seeded mutations and extremes go through the real binary, under a limit
//! of memory and of time.
//!
//! Whatever a file says, the program neither panics nor aborts, answers Ctrl-C within a second, and
//! prints no NaN as a result. `TACKSCOPE_SCENES` is how many files (150 without it),
//! `TACKSCOPE_SEED` where they begin, `TACKSCOPE_KEEP` a folder for those that fail.
#![cfg(unix)]

use rand::seq::IndexedRandom;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use std::fmt::Write as _;
use std::fs;
use std::io::Read;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Files without `TACKSCOPE_SCENES`.
const SCENES: u64 = 150;
/// Address space of one run, in kilobytes.
const MEMORY_KB: u64 = 4 << 20;
/// After this long what still runs is interrupted, as by Ctrl-C.
const PATIENCE: Duration = Duration::from_secs(2);
/// Longest time to answer Ctrl-C.
const ANSWER: Duration = Duration::from_secs(1);
/// After this long without an answer it hangs.
const HANG: Duration = Duration::from_secs(20);

/// Scenes from which files are made: every law and every ground, on tiny meshes with few steps.
fn seeds() -> Vec<String> {
    let scene = |points: &str, law: &str, ground: &str, drive: &str| {
        format!(
            "format = 1\ntitle = \"seed\"\n\n[cell]\nlength = 64.0\npoints = {points}\n\n[law]\n{law}\nsurface_energy = 0.3\n\n\
             [indenter]\n{ground}\n\n[drive]\n{drive}\n\n[accuracy]\ntarget = 0.05\n\n[noise]\nseed = 1\n"
        )
    };
    let laws = [
        "kind = \"morse\"\nrange = 2.0",
        "kind = \"mie\"\nm = 8.0\nn = 2.0\nrange = 3.0",
        "kind = \"cosine\"\nsmooth = true\nrange = 4.0",
        "kind = \"double_exponential\"\nratio = 0.4\nrange = 2.0",
        "kind = \"morse\"\nmu_rho = 0.6",
    ];
    let grounds = [
        ("kind = \"flat\"", "start = 12.0\nturn = 1.0\nstep = 0.5"),
        (
            "kind = \"hertz\"\nradius = 60.0",
            "start = 8.0\nturn = \"zero_load\"\nstep = 0.5",
        ),
        (
            "kind = \"wave\"\namplitude = 0.5\nperiods = 1",
            "start = 10.0\nturn = 1.0\nstep = 0.5",
        ),
        (
            "kind = \"wave\"\namplitude = 0.5\nperiods = [1, 1]",
            "start = 10.0\nturn = 1.0\nstep = 0.5",
        ),
        (
            "kind = \"rough\"\nhurst = 0.8\nrms = 0.5\nlongest = 64.0\nshortest = 16.0\nseed = 3",
            "start = 10.0\nturn = 1.0\nstep = 0.5",
        ),
    ];
    let mut seeds = Vec::new();
    for (i, law) in laws.iter().enumerate() {
        for (j, (ground, drive)) in grounds.iter().enumerate() {
            let points = ["8", "16", "[16, 1]", "12", "[8, 1]"][(i + j) % 5];
            // Waves along y are for squares.
            let points = if ground.contains("[1, 1]") {
                "12"
            } else {
                points
            };
            seeds.push(scene(points, law, ground, drive));
        }
    }
    seeds
}

/// Values that no reader likes, of every type.
const ODD: [&str; 56] = [
    "0",
    "-0",
    "0.0",
    "-0.0",
    "1",
    "-1",
    "2",
    "3",
    "1e-300",
    "-1e-300",
    "1e300",
    "-1e300",
    "5e-324",
    "1.7976931348623157e308",
    "nan",
    "-nan",
    "inf",
    "-inf",
    "4611686018427387904",
    "9223372036854775807",
    "-9223372036854775808",
    "9223372036854775808",
    "1e15",
    "1e-15",
    "1e60",
    "1e110",
    "1e-110",
    "1e-18",
    "1e7",
    "1e9",
    "1000000000",
    "0.1",
    "1e-6",
    "0.9999999999",
    "2.000000000000001",
    "100",
    "4096",
    "513",
    "[16, 1]",
    "[64, 64]",
    "[1, 600]",
    "[]",
    "[nan]",
    "[1, 2, 3]",
    "\"\"",
    "\"auto\"",
    "\"zero_load\"",
    "\"0.5\"",
    "true",
    "1979-05-27T07:32:00Z",
    "{ a = 1 }",
    "{}",
    "0x10",
    "1_000",
    "\"\\u0007\\u001b[2J\"",
    "\"\"\"\nmany\nlines\"\"\"",
];

/// Meshes that are quick, and a few that are no meshes.
const MESHES: [&str; 16] = [
    "4",
    "6",
    "8",
    "10",
    "12",
    "16",
    "24",
    "[8, 1]",
    "[32, 1]",
    "0",
    "-8",
    "15",
    "1e1",
    "[8, 8]",
    "4611686018427387904",
    "\"Auto\"",
];

/// A number of any size, most of them near what is usual.
fn number(rng: &mut Pcg64) -> String {
    match rng.random_range(0..4) {
        0 => format!(
            "{:e}",
            10f64.powf(rng.random_range(-130.0..130.0))
                * if rng.random_bool(0.2) { -1.0 } else { 1.0 }
        ),
        1 => format!("{:e}", 10f64.powf(rng.random_range(-12.0..12.0))),
        2 => format!("{:.3}", rng.random_range(-5.0..20.0)),
        _ => rng.random_range(-3..300).to_string(),
    }
}

/// One more change of a file.
fn mutate(text: &mut String, rng: &mut Pcg64, seeds: &[String]) {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let keyed: Vec<usize> = (0..lines.len())
        .filter(|&i| lines[i].contains(" = "))
        .collect();
    let Some(&at) = keyed.choose(rng) else { return };
    let key = lines[at].split(" = ").next().unwrap_or_default().to_owned();
    let value = lines[at].split(" = ").nth(1).unwrap_or_default().to_owned();
    match rng.random_range(0..40) {
        // Another mesh, another size: most of these are allowed scenes. Large meshes are only slow.
        0..=33 if key == "points" => {
            lines[at] = format!("points = {}", MESHES.choose(rng).expect("there are some"));
        }
        0..=24 => {
            let reach = if rng.random_bool(0.7) { 0.5 } else { 4.0 };
            let share = 10f64.powf(rng.random_range(-reach..reach));
            if let Ok(whole) = value.parse::<i64>() {
                lines[at] = format!("{key} = {}", (whole as f64 * share).round());
            } else if let Ok(number) = value.parse::<f64>() {
                lines[at] = format!("{key} = {:e}", number * share);
            }
        }
        25..=28 => lines[at] = format!("{key} = {}", number(rng)),
        29..=33 => lines[at] = format!("{key} = {}", ODD.choose(rng).expect("there are some")),
        34 => drop(lines.remove(at)),
        35 => lines.insert(at, lines[at].clone()),
        36 | 37 => {
            let other = seeds.choose(rng).expect("there are some");
            let theirs: Vec<&str> = other.lines().collect();
            lines.insert(at, (*theirs.choose(rng).expect("it has lines")).to_owned());
        }
        38 => {
            let mut bytes = lines.join("\n").into_bytes();
            for _ in 0..rng.random_range(1..6) {
                let place = rng.random_range(0..bytes.len());
                bytes[place] = rng.random();
            }
            *text = String::from_utf8_lossy(&bytes).into_owned();
            return;
        }
        _ => {
            let nested = format!(
                "{}1{}",
                "[".repeat(rng.random_range(1..3000)),
                "]".repeat(rng.random_range(0..3000))
            );
            lines[at] = format!("{key} = {nested}");
        }
    }
    *text = lines.join("\n") + "\n";
}

/// The file of this number, and what else the command line says.
fn file(number: u64, seeds: &[String]) -> (String, Vec<&'static str>) {
    let mut rng = Pcg64::seed_from_u64(number);
    let mut text = seeds.choose(&mut rng).expect("there are some").clone();
    for _ in 0..rng.random_range(1..4) {
        mutate(&mut text, &mut rng, seeds);
    }
    let mut more = Vec::new();
    if rng.random_bool(0.25) {
        more.extend([
            "--model",
            ["plan", "atlas", "quarter", "whole"][rng.random_range(0..4)],
        ]);
    }
    if rng.random_bool(0.1) {
        more.extend([
            "--method",
            ["newton", "gfmd", "fire", "lbfgs"][rng.random_range(0..4)],
        ]);
    }
    (text, more)
}

/// What a run came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum End {
    Done,
    Refused,
    NotConverged,
    Interrupted,
    /// Ctrl-C was answered, yet later than it should.
    Late,
    Usage,
    Panic,
    Abort,
    Hang,
    NoNumber,
}

impl End {
    fn is_fault(self) -> bool {
        matches!(
            self,
            End::Panic | End::Abort | End::Hang | End::NoNumber | End::Late
        )
    }
}

fn interrupt(process: u32) {
    let _ = Command::new("kill")
        .args(["-INT", &process.to_string()])
        .status();
}

/// Processor time a process has spent, where the system tells (Linux counts hundredths of a
/// second).
fn worked(process: u32) -> Option<Duration> {
    let stat = fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    let fields: Vec<&str> = stat.rsplit(')').next()?.split_whitespace().collect();
    let ticks = |i: usize| fields.get(i)?.parse::<u64>().ok();
    Some(Duration::from_millis(10 * (ticks(11)? + ticks(12)?)))
}

/// Runs one file; also says how long it took to answer Ctrl-C, if it was asked.
fn run(folder: &Path, text: &str, more: &[&str]) -> (End, String, Option<Duration>) {
    let (scene, out) = (folder.join("scene.toml"), folder.join("out"));
    fs::write(&scene, text).expect("written");
    let _ = fs::remove_dir_all(&out);
    let mut child = Command::new("sh")
        .args([
            "-c",
            &format!("ulimit -v {MEMORY_KB}; exec \"$0\" \"$@\""),
            env!("CARGO_BIN_EXE_tackscope"),
            "run",
        ])
        .arg(&scene)
        .arg("--quiet")
        .arg("--out")
        .arg(&out)
        .args(more)
        .env("RAYON_NUM_THREADS", "1")
        .env("RUST_BACKTRACE", "0")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the binary runs");
    let mut pipe = child.stderr.take().expect("a pipe");
    let reader = std::thread::spawn(move || {
        let mut words = Vec::new();
        let _ = pipe.read_to_end(&mut words);
        String::from_utf8_lossy(&words).into_owned()
    });
    let await_end = |child: &mut std::process::Child, patience: Duration| -> Option<ExitStatus> {
        let begin = Instant::now();
        loop {
            if let Some(status) = child.try_wait().expect("a child") {
                return Some(status);
            }
            if begin.elapsed() > patience {
                return None;
            }
            std::thread::sleep(Duration::from_millis(2));
        }
    };
    let (mut status, mut answer) = (await_end(&mut child, PATIENCE), None);
    if status.is_none() {
        let before = worked(child.id());
        interrupt(child.id());
        let asked = Instant::now();
        let mut after = before;
        while status.is_none() && asked.elapsed() < HANG {
            after = worked(child.id()).or(after);
            status = await_end(&mut child, Duration::from_millis(10));
        }
        // On a busy machine others take their share of the time: what counts is the work done after
        // the request, if it is known.
        let spent = before
            .zip(after)
            .map(|(before, after)| after.saturating_sub(before));
        answer = Some(spent.map_or(asked.elapsed(), |spent| spent.min(asked.elapsed())));
    }
    let Some(status) = status else {
        let _ = child.kill();
        let _ = child.wait();
        let words = reader.join().unwrap_or_default();
        return (End::Hang, words, answer);
    };
    let words = reader.join().unwrap_or_default();
    let late = answer.is_some_and(|answer| answer > ANSWER);
    let end = match (status.code(), status.signal()) {
        _ if words.contains("panicked at") => End::Panic,
        (None, _) => End::Abort,
        _ if late => End::Late,
        (Some(0), _) if !is_all_numbers(&out) => End::NoNumber,
        (Some(0), _) => End::Done,
        (Some(2), _) if words.starts_with("tackscope: ") => End::Refused,
        (Some(2), _) => End::Usage,
        (Some(3), _) => End::NotConverged,
        (Some(130), _) => End::Interrupted,
        _ => End::Abort,
    };
    (end, words, answer)
}

/// True if the loop has finite numbers everywhere, and the summary a loss: null stands there for
/// what is no number.
fn is_all_numbers(out: &Path) -> bool {
    let read = |name: &str| fs::read_to_string(out.join(name)).unwrap_or_default();
    let finite = |table: &str| {
        table.lines().skip(1).all(|row| {
            row.split(',')
                .all(|cell| cell.parse::<f64>().map_or(true, f64::is_finite))
        })
    };
    let summary: serde_json::Value =
        serde_json::from_str(&read("summary.json")).unwrap_or_default();
    let given = |key: &str| {
        summary
            .get(key)
            .is_some_and(|value| value.as_f64().is_some_and(f64::is_finite))
    };
    // An open loop gives no loss, and says that it is open.
    let open = summary.get("closed").and_then(serde_json::Value::as_bool) == Some(false);
    let table = read("loop.csv");
    table.lines().count() > 1
        && finite(&table)
        && finite(&read("events.csv"))
        && (open || given("dissipated_energy") && given("released_energy_sum"))
}

fn asked(name: &str, otherwise: u64) -> u64 {
    std::env::var(name)
        .ok()
        .and_then(|value| value.parse().ok())
        .unwrap_or(otherwise)
}

#[test]
fn no_scene_file_makes_the_program_panic_hang_or_print_what_is_no_number() {
    let (count, first) = (
        asked("TACKSCOPE_SCENES", SCENES),
        asked("TACKSCOPE_SEED", 1),
    );
    let seeds = seeds();
    let (next, told) = (AtomicU64::new(first), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism()
            .map_or(1, usize::from)
            .min(8)
        {
            scope.spawn(|| {
                let folder = tempfile::tempdir().expect("a temporary folder");
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= first + count {
                        return;
                    }
                    let (text, more) = file(number, &seeds);
                    let (end, words, answer) = run(folder.path(), &text, &more);
                    if end.is_fault()
                        && let Some(keep) = std::env::var_os("TACKSCOPE_KEEP")
                    {
                        let _ = fs::create_dir_all(&keep);
                        let _ = fs::write(
                            Path::new(&keep).join(format!("{end:?}-{number}.toml")),
                            format!("# {more:?}\n{text}"),
                        );
                    }
                    told.lock()
                        .expect("nobody panics with it")
                        .push((end, number, answer, words));
                }
            });
        }
    });
    let told = told.into_inner().expect("nobody panicked with it");
    let mut ends: Vec<End> = told.iter().map(|(end, ..)| *end).collect();
    ends.sort_unstable();
    ends.dedup();
    let mut table = format!("{count} scene files from {first}\n");
    for end in ends {
        let _ = writeln!(
            table,
            "{end:?}: {}",
            told.iter().filter(|(other, ..)| *other == end).count()
        );
    }
    let slowest = told
        .iter()
        .filter_map(|(.., answer, _)| *answer)
        .max()
        .unwrap_or_default();
    let _ = writeln!(
        table,
        "slowest answer to Ctrl-C: {:.3} s",
        slowest.as_secs_f64()
    );
    println!("{table}");
    for (end, number, answer, words) in told.iter().filter(|(end, ..)| end.is_fault()) {
        let _ = writeln!(
            table,
            "{end:?} {number} {answer:?}: {}",
            words.lines().take(3).collect::<Vec<_>>().join(" | ")
        );
    }
    assert!(!told.iter().any(|(end, ..)| end.is_fault()), "{table}");
}
