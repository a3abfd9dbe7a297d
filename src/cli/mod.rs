//! Floor 5: the command line (clap) and terminal progress. No physics formulas.
//!
//! Exit codes: 0 done, 2 bad input (nothing was computed, or nothing could be written), 3 not converged, 130 interrupted; after
//! 3 and 130 everything computed so far is written. Results go to files, one closing line to standard output, progress and
//! refusals to standard error. May use every room below.

mod chart;
mod figure;
mod presets;
mod progress;
mod report;
mod run;
mod window;

use clap::builder::PossibleValue;
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;
use std::process::ExitCode;

use crate::experiment::plan::Wish;
use crate::numerics::cancel::Cancel;
use crate::solver::method::MethodKind;
use std::sync::atomic::{AtomicBool, Ordering};

/// Done.
const DONE: u8 = 0;
/// Bad input.
const BAD_INPUT: u8 = 2;
/// A state was not found.
const NOT_CONVERGED: u8 = 3;
/// Stopped by Ctrl-C.
const INTERRUPTED: u8 = 130;

/// A desktop explorer of adhesive hysteresis: lower a soft body onto a sticky surface, pull it off, and watch where it jumps.
///
/// Without a command it opens the window; without a display it runs the scene fig2 into tackscope-out/.
#[derive(Parser)]
#[command(
    version,
    about,
    after_help = "Exit codes: 0 done, 2 bad input, 3 not converged, 130 interrupted (3 and 130: what was computed is written)."
)]
struct CommandLine {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// Compute a closed loop without a window
    ///
    /// Writes loop.csv, events.csv, summary.json, loop.svg, loop.png and gaps/*.png into the folder, replacing those of an
    /// earlier run.
    Run(RunArguments),
    /// Chart the speed of every method against its accuracy on the loop of a scene
    ///
    /// Writes chart.csv, chart.json, chart.svg and chart.png into the folder. Errors are against a finer mesh with half the step;
    /// failures are rows of the table and marks in the picture. Exit code 0 if the chart is complete, whatever failed in it.
    Chart(ChartArguments),
    /// Compute the paper's figures anew, beside their theory
    ///
    /// Writes figure-NN.csv (data), figure-NN.svg and figure-NN.png into the folder. A figure that cannot be computed does not
    /// keep the others: exit code 3.
    Figure(FigureArguments),
    /// Compute the paper's table anew
    ///
    /// Writes table-N.csv, table-N.svg and table-N.png into the folder.
    Table(TableArguments),
    /// List the built-in scenes
    Presets,
}

/// What `tackscope figure` is told.
#[derive(Args, Clone, Debug)]
struct FigureArguments {
    /// The figure's number in the paper, or all
    #[arg(value_name = "N|all")]
    figure: String,
    /// The folder to write into; made if it is not there
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Also write report.html (pictures, findings, Table 1, what the print got wrong) and findings.csv
    #[arg(long)]
    report: bool,
    /// Coarse meshes and few points: seconds in place of minutes
    #[arg(long)]
    quick: bool,
    /// Say nothing but errors
    #[arg(long, short)]
    quiet: bool,
}

/// What `tackscope table` is told.
#[derive(Args, Clone, Debug)]
struct TableArguments {
    /// The table's number in the paper
    #[arg(value_name = "N")]
    table: String,
    /// The folder to write into; made if it is not there
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Say nothing but errors
    #[arg(long, short)]
    quiet: bool,
}

/// What `tackscope chart` is told.
#[derive(Args, Clone, Debug)]
struct ChartArguments {
    /// A built-in scene (see `tackscope presets`) or the path of a scene file
    scene: String,
    /// The folder to write into; made if it is not there
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Say nothing but errors
    #[arg(long, short)]
    quiet: bool,
    /// Only coarse meshes and long steps: seconds in place of minutes
    #[arg(long)]
    quick: bool,
    /// Processor time to spend, in seconds; what does not fit is skipped, and said to be
    #[arg(long, value_name = "S", default_value_t = 180.0, conflicts_with = "quick")]
    seconds: f64,
}

/// What `tackscope run` is told.
#[derive(Args, Clone, Debug)]
struct RunArguments {
    /// A built-in scene (see `tackscope presets`) or the path of a scene file
    scene: String,
    /// The folder to write into; made if it is not there
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Say nothing but errors
    #[arg(long, short)]
    quiet: bool,
    /// Which method follows the branches
    #[arg(long, value_enum, default_value_t = MethodKind::NewtonKrylov)]
    method: MethodKind,
    /// How the loop is computed, in place of the plan's choice
    #[arg(long, value_enum, default_value_t = Wish::Plan)]
    model: Wish,
    /// Seed in place of the scene's: it chooses between equivalent patterns
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64))]
    seed: Option<u64>,
    /// Points a side in place of the scene's (a line cell stays a line)
    #[arg(long, value_name = "N")]
    points: Option<usize>,
    /// Largest step of u0 in place of the scene's
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    step: Option<f64>,
    /// Afterwards run the paper's method on the same loop and write the ratio of processor time into summary.json
    #[arg(long)]
    yardstick: bool,
    /// Afterwards walk the same loop on the next finer mesh of the whole cell and write the measured error into summary.json
    #[arg(long)]
    verify: bool,
}

impl ValueEnum for Wish {
    fn value_variants<'a>() -> &'a [Self] {
        &Wish::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.word()).help(match self {
            Wish::Plan => "the cheapest model that is good enough",
            Wish::Atlas => "branches of flat, ridge and square patterns",
            Wish::Quarter => "the walk on the even quarter of the cell",
            Wish::Whole => "the walk on the whole cell",
        }))
    }
}

impl ValueEnum for MethodKind {
    fn value_variants<'a>() -> &'a [Self] {
        &MethodKind::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.word()).help(self.title()))
    }
}

/// Runs the program and returns its exit code: 0 done, 2 bad input, 3 not converged, 130 interrupted.
pub fn main() -> ExitCode {
    ExitCode::from(match CommandLine::parse().command {
        Some(Command::Run(arguments)) => run::run(&arguments),
        Some(Command::Chart(arguments)) => chart::chart(&arguments),
        Some(Command::Figure(arguments)) => figure::figure(&arguments),
        Some(Command::Table(arguments)) => figure::table(&arguments),
        Some(Command::Presets) => presets::list(),
        None => window_or_default_scene(),
    })
}

/// The window, or where there is no display the default scene without it.
fn window_or_default_scene() -> u8 {
    match window::open() {
        Ok(()) => DONE,
        Err(window::NoWindow::Broken(reason)) => {
            eprintln!("tackscope: the window could not be opened ({reason}): try tackscope run fig2 --out DIR instead");
            BAD_INPUT
        }
        Err(window::NoWindow::NoDisplay(reason)) => {
            eprintln!("tackscope: no window here ({reason}): running the scene fig2 into tackscope-out/ instead");
            run::run(&RunArguments {
                scene: "fig2".to_owned(),
                out: PathBuf::from("tackscope-out"),
                quiet: false,
                method: MethodKind::NewtonKrylov,
                seed: None,
                points: None,
                step: None,
                verify: false,
                model: Wish::Plan,
                yardstick: false,
            })
        }
    }
}

/// A token that the first Ctrl-C raises; the second one ends the program at once.
fn cancel_on_interrupt() -> Cancel {
    let cancel = Cancel::default();
    let (token, before) = (cancel.clone(), AtomicBool::new(false));
    // Without a handler Ctrl-C ends the program the hard way: worse, yet no reason not to run.
    let _ = ctrlc::set_handler(move || {
        if before.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(INTERRUPTED));
        }
        token.request();
    });
    cancel
}

/// Prints a line to standard output; a reader that has gone away (`| head`) is no error.
fn say(line: &str) {
    use std::io::Write;
    let _ = writeln!(std::io::stdout(), "{line}");
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
