//! Floor 8: the command line (clap) and terminal progress. No physics formulas.
//!
//! Exit codes: 0 done, 2 bad input (nothing was computed) or something that could not be written, 3
//! not converged, 130 interrupted (Ctrl-C, SIGTERM, SIGHUP); after 3 and 130 everything computed so
//! far is written, after 2 all of it that could be. Results go to files, one closing line to
//! standard output, progress and refusals to standard error. May use every room below.

mod catalogue;
mod pages;
mod run;
mod sweep;

use crate::follow::record::{JumpRecord, StateRecord};
use crate::follow::run::Report;
use crate::numerics::threads::Cancel;
use crate::plot::scale::digits;
use crate::scene::parameter::fixed;
use crate::scene::{Model, Scene};
use crate::storage::files::Folder;
use crate::storage::{self, Failure, VERSION, files, line, scene_file};
use crate::worker;
use clap::builder::{PathBufValueParser, TypedValueParser};
use clap::{Args, Parser, Subcommand};
use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{ErrorKind, IsTerminal, Write, stderr, stdout};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

/// Done.
const DONE: u8 = 0;
/// Bad input, or a file that could not be written.
const BAD_INPUT: u8 = 2;
/// A state was not found.
const NOT_CONVERGED: u8 = 3;
/// Stopped by Ctrl-C or another signal.
const INTERRUPTED: u8 = 130;

/// A desktop explorer of adhesive hysteresis: lower a soft body onto a sticky surface, pull it off,
/// and watch where it jumps.
///
/// Without a command it opens the window; without a display it runs the scene fig2 into
/// tackscope-out/.
#[derive(Parser)]
#[command(
    version = VERSION,
    about,
    after_help = "Exit codes: 0 done, 2 bad input or a file that cannot be written, 3 not \
        converged, 130 interrupted by Ctrl-C, SIGTERM or SIGHUP (3 and 130: what was computed is \
        written)."
)]
struct CommandLine {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// Compute a closed loop without a window
    ///
    /// Writes loop.csv, events.csv, loop.svg, loop.png, gaps/*.png, with --fields fields.npz, and
    /// at last summary.json into the folder, in place of those of an earlier run, which are removed
    /// at the start. Until all is written summary.json says "running".
    Run(run::RunArguments),
    /// Follow every branch of equilibria of a scene, stable and unstable
    ///
    /// Writes branches.csv, points.csv (folds, bifurcations, equal energies), diagram.svg and
    /// diagram.png into the folder. What could not be followed is said, and in the picture: exit
    /// code 3.
    Diagram(pages::DiagramArguments),
    /// Map where every jump of a scene's loop lies as one parameter goes
    ///
    /// Writes map.csv (jumps and ends of patterns, with the loss), map.svg and map.png into the
    /// folder. A value whose loop is not known is said, and in the picture: exit code 3.
    Map(pages::MapArguments),
    /// Compute the loops of a scene at many values of its numbers
    ///
    /// Writes sweep.csv, a row a loop as it is done, sweep.svg and sweep.png into the folder. The
    /// same command goes on where an earlier one was stopped or killed. A loop that fails is a row
    /// that says why: exit code 3.
    Sweep(sweep::SweepArguments),
    /// Look at the ground before anything runs
    ///
    /// Writes ground.svg and ground.png (map, distribution of heights, power spectrum), ground.json
    /// (rms height, slope and curvature, what was done to a height file), spectrum.csv and
    /// heights.csv (a height file) into the folder.
    Ground(pages::GroundArguments),
    /// Chart the speed of every method against its accuracy on the loop of a scene
    ///
    /// Writes chart.csv, chart.json, chart.svg and chart.png into the folder. Errors are against a
    /// finer mesh with half the step; failures are rows of the table and marks in the picture. Exit
    /// code 0 if the chart is complete, whatever failed in it.
    Chart(pages::ChartArguments),
    /// Compute the paper's figures anew, beside their theory
    ///
    /// Writes figure-NN.csv (data), figure-NN.svg and figure-NN.png into the folder. A figure that
    /// cannot be computed does not keep the others: exit code 3.
    Figure(catalogue::FigureArguments),
    /// Compute the paper's table anew
    ///
    /// Writes table-N.csv, table-N.svg and table-N.png into the folder.
    Table(catalogue::TableArguments),
    /// List the built-in scenes
    Presets,
    /// List the lessons
    ///
    /// With --check each is performed without the window: exit code 3 if one cannot be done.
    Lessons(catalogue::LessonsArguments),
    /// Print a scene as a scene file, with everything that it leaves open decided
    Scene(catalogue::SceneArguments),
}

/// Where results go, and what is said of them.
#[derive(Args, Clone, Debug)]
struct Output {
    /// The folder to write into; made if it is not there
    #[arg(long, value_name = "DIR", value_parser = folder())]
    out: PathBuf,
    /// Say nothing but errors
    #[arg(long, short)]
    quiet: bool,
}

/// A folder as it was typed.
fn folder() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| files::typed(&path))
}

/// Runs the program and returns its exit code: 0 done, 2 bad input or a file not written, 3 not
/// converged, 130 interrupted.
pub fn main() -> ExitCode {
    ExitCode::from(match CommandLine::try_parse() {
        Ok(CommandLine {
            command: Some(command),
        }) => code(perform(&command)),
        Ok(CommandLine { command: None }) => window_or_default_scene(),
        Err(words) => code(explain(&words)),
    })
}

/// Does what is told.
fn perform(command: &Command) -> Result<u8, Failure> {
    match command {
        Command::Run(arguments) => run::run(arguments),
        Command::Diagram(arguments) => pages::diagram(arguments),
        Command::Map(arguments) => pages::map(arguments),
        Command::Sweep(arguments) => sweep::sweep(arguments),
        Command::Ground(arguments) => pages::ground(arguments),
        Command::Chart(arguments) => pages::chart(arguments),
        Command::Figure(arguments) => catalogue::figure(arguments),
        Command::Table(arguments) => catalogue::table(arguments),
        Command::Presets => catalogue::presets(),
        Command::Lessons(arguments) => catalogue::lessons(arguments),
        Command::Scene(arguments) => catalogue::scene(arguments),
    }
}

/// The scene of this name with so many points a side in place of its own, and how to name both in a
/// refusal.
fn scene_with_points(name: &str, points: Option<usize>) -> Result<(Scene, String), Failure> {
    let (mut scene, place) = (storage::resolve(name)?, storage::place(name));
    let Some(n) = points else {
        return Ok((scene, place.to_owned()));
    };
    scene.cell.points = scene.cell.points.resized(n);
    Ok((scene, format!("{place} with --points {n}")))
}

/// The same with everything decided.
fn decided_with_points(
    name: &str,
    points: Option<usize>,
) -> Result<(Scene, Model, String), Failure> {
    let (scene, place) = scene_with_points(name, points)?;
    let model = scene.model();
    let model = model.map_err(|error| scene_file::refused(&place, error))?;
    Ok((scene, model, place))
}

/// The exit code of a command, its failure told.
fn code(result: Result<u8, Failure>) -> u8 {
    result.unwrap_or_else(|failure| {
        warn(failure);
        BAD_INPUT
    })
}

/// Help and version on standard output, what is wrong with the command line on standard error.
fn explain(words: &clap::Error) -> Result<u8, Failure> {
    let text = words.render().to_string();
    if words.use_stderr() {
        text.lines().for_each(tell);
        return Ok(BAD_INPUT);
    }
    text.lines().try_for_each(say).map(|()| DONE)
}

impl Output {
    /// Takes the folder and removes what an earlier run has left in it and in its `inner` folders,
    /// which [`Folder::clear`] does, and says so; `room` in bytes.
    ///
    /// # Errors
    /// A folder that cannot be written, or an earlier result that cannot be removed.
    fn claim(
        &self,
        inner: &[&str],
        room: u64,
        ours: impl Fn(&str) -> bool,
    ) -> Result<Folder, Failure> {
        let folder = Folder::claim(&self.out, inner, room)?;
        if folder.clear(inner, ours)? > 0 && !self.quiet {
            let place = self.out.display();
            warn(format_args!(
                "{place} held an earlier run, which this one replaces"
            ));
        }
        Ok(folder)
    }

    /// The end of a command: tells every file that could not be written, or else, on standard
    /// output, what was done; returns the exit code.
    ///
    /// # Errors
    /// A standard output that cannot be written.
    fn close(&self, unwritten: &[Failure], code: u8, done: &str) -> Result<u8, Failure> {
        unwritten.iter().for_each(warn);
        if !unwritten.is_empty() {
            return Ok(BAD_INPUT);
        }
        if !self.quiet {
            say(&format!("{done}: written to {}", self.out.display()))?;
        }
        Ok(code)
    }
}

/// Says that somebody asked to stop, and where `what` there is by then is; the exit code.
fn interrupted(what: &str, out: &Path) -> u8 {
    warn(format_args!("interrupted; {what} is in {}", out.display()));
    INTERRUPTED
}

/// What of all that was written could not be.
fn failures(written: impl IntoIterator<Item = Result<(), Failure>>) -> Vec<Failure> {
    written.into_iter().filter_map(Result::err).collect()
}

// The way to the window: the one place outside `ui` that asks for the feature `gui`.

/// Why there is no window.
enum NoWindow {
    /// Nothing to open it on.
    NoDisplay(String),
    /// There is a display, yet it did not open.
    #[cfg_attr(not(feature = "gui"), expect(dead_code, reason = "needs a window"))]
    Broken(String),
}

/// Opens the window and returns when it is closed.
#[cfg(feature = "gui")]
fn open_window() -> Result<(), NoWindow> {
    crate::ui::display_available().map_err(NoWindow::NoDisplay)?;
    crate::ui::run().map_err(NoWindow::Broken)
}

/// Says that there is none in this build.
#[cfg(not(feature = "gui"))]
fn open_window() -> Result<(), NoWindow> {
    Err(NoWindow::NoDisplay("this build has none".to_owned()))
}

/// The window, or where there is no display the default scene without it.
fn window_or_default_scene() -> u8 {
    match open_window() {
        Ok(()) => DONE,
        Err(NoWindow::Broken(reason)) => {
            warn(format_args!(
                "the window could not be opened ({reason}): try tackscope run fig2 --out DIR \
                 instead"
            ));
            BAD_INPUT
        }
        Err(NoWindow::NoDisplay(reason)) => {
            warn(format_args!(
                "no window here ({reason}): running the scene fig2 into tackscope-out/ instead"
            ));
            let words = ["tackscope", "run", "fig2", "--out", "tackscope-out"];
            let instead = CommandLine::parse_from(words).command;
            instead.map_or(DONE, |command| code(perform(&command)))
        }
    }
}

/// A token that the first request from outside raises; one that comes later than a moment after it
/// ends the program at once.
fn cancel_on_signal() -> Cancel {
    let status = files::read_bytes(Path::new("/proc/self/status"), 1 << 16).unwrap_or_default();
    worker::cancel_on_signal(
        &String::from_utf8_lossy(&status),
        files::at_rest,
        i32::from(INTERRUPTED),
    )
}

/// Prints a line to standard output; a reader that has gone away (`| head`) is no error.
///
/// # Errors
/// A standard output that cannot be written, as on a full disk.
fn say(text: &str) -> Result<(), Failure> {
    print(&line(text))
}

/// Prints a text as it is, of whatever lines.
///
/// # Errors
/// As [`say`].
fn print(text: &str) -> Result<(), Failure> {
    let mut out = stdout().lock();
    match writeln!(out, "{text}").and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            let remedy = "make room where it goes, or send it elsewhere";
            Err(Failure::refused(
                Path::new("standard output"),
                &error.to_string(),
                remedy,
            ))
        }
        _ => Ok(()),
    }
}

/// Prints a line to standard error; nobody listening is no error.
fn tell(text: &str) {
    let _ = writeln!(stderr(), "{}", line(text));
}

/// Tells what went wrong, or what must be known.
fn warn(text: impl std::fmt::Display) {
    tell(&format!("tackscope: {text}"));
}

/// Resolution of the bar.
const TICKS: u64 = 1000;

/// Listens to a walk and tells the user.
enum Monitor {
    /// `--quiet`.
    Silent,
    /// A terminal.
    Bar(ProgressBar),
    /// A file or a pipe: a line per jump and every tenth of the way.
    Lines {
        /// Tenths already told.
        tenths: u64,
    },
}

impl Monitor {
    /// The fitting monitor, which at once says what begins.
    fn new(quiet: bool, heading: &str) -> Self {
        if quiet {
            return Monitor::Silent;
        }
        if !std::io::stderr().is_terminal() {
            tell(heading);
            return Monitor::Lines { tenths: 0 };
        }
        let bar =
            ProgressBar::with_draw_target(Some(TICKS), ProgressDrawTarget::stderr_with_hz(15));
        let style =
            ProgressStyle::with_template("{bar:32} {percent:>3} %  {elapsed}, {eta} left  {msg}");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        bar.println(line(heading));
        Monitor::Bar(bar)
    }

    /// Tells one piece of news, u0 to a hundredth of the drive's `step`.
    fn tell(&mut self, news: &Report<'_>, step: f64) {
        match news {
            Report::Jump(jump) => self.note(&jump_words(jump, step)),
            Report::State {
                record, fraction, ..
            } => self.reached(*fraction, || state_words(record, step), String::new),
        }
    }

    /// Moves the bar, with `words` beside it; in lines says them and what is `left` every tenth of
    /// the way.
    fn reached(&mut self, fraction: f64, words: impl Fn() -> String, left: impl Fn() -> String) {
        match self {
            Monitor::Silent => {}
            Monitor::Bar(_) => {
                self.fraction(fraction);
                self.now(&words());
            }
            Monitor::Lines { tenths } => {
                let reached = (fraction.clamp(0.0, 1.0) * 10.0 + 1e-9) as u64;
                if reached > *tenths {
                    *tenths = reached;
                    tell(&format!("{:>3} %  {}{}", 10 * reached, words(), left()));
                }
            }
        }
    }

    /// Says what is being done, where there is a bar.
    fn now(&self, words: &str) {
        if let Monitor::Bar(bar) = self {
            bar.set_message(line(words));
        }
    }

    /// Moves the bar, where there is one.
    fn fraction(&self, fraction: f64) {
        if let Monitor::Bar(bar) = self {
            bar.set_position((fraction.clamp(0.0, 1.0) * TICKS as f64) as u64);
        }
    }

    /// Tells how many loops of so many are done after so many `seconds`, and which share of the work
    /// that is expected to be.
    fn loops(&mut self, [done, of]: [usize; 2], fraction: f64, seconds: f64) {
        let left = || {
            let left = (seconds * (1.0 / fraction - 1.0)).max(0.0);
            format!(", {} left", HumanDuration(Duration::from_secs_f64(left)))
        };
        self.reached(fraction, || format!("{done} of {of} loops"), left);
    }

    /// Says something that stays.
    fn note(&self, words: &str) {
        match self {
            Monitor::Silent => {}
            Monitor::Bar(bar) => bar.println(line(words)),
            Monitor::Lines { .. } => tell(words),
        }
    }

    /// Takes the bar away.
    fn finish(&self) {
        if let Monitor::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}

fn state_words(state: &StateRecord, step: f64) -> String {
    format!(
        "{} at u0 = {}: {}",
        state.direction,
        digits(state.mean_displacement, 0.01 * step),
        state.pattern
    )
}

fn jump_words(jump: &JumpRecord, step: f64) -> String {
    format!(
        "jump   {} at u0 = {}: {} to {}, released {} gamma ({})",
        jump.direction,
        digits(jump.mean_displacement, 0.01 * step),
        jump.from,
        jump.to,
        fixed(jump.released_energy, 4),
        jump.cause_words()
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        CommandLine::command().debug_assert();
    }
}
