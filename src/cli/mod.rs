//! Floor 5: the command line (clap) and terminal progress. No physics formulas.

use std::process::ExitCode;

/// Runs the program and returns its exit code: 0 done, 2 bad input, 3 not converged, 130 interrupted.
pub fn main() -> ExitCode {
    #[cfg(feature = "gui")]
    if let Err(e) = crate::ui::run(crate::ui::Options::default()) {
        eprintln!("{e}");
        return ExitCode::from(2);
    }
    ExitCode::SUCCESS
}
