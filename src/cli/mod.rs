//! Floor 5: the command line (clap) and terminal progress. No physics formulas.

use std::process::ExitCode;

/// Runs the program and returns its exit code: 0 done, 2 bad input, 3 not converged, 130 interrupted.
pub fn main() -> ExitCode {
    ExitCode::SUCCESS
}
