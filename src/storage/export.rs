//! The tables of a walk as CSV.
//!
//! Numbers are written with as many digits as bring back the same number; one that is not finite is
//! written `NaN` or `inf`.

use super::{Failure, files};
use crate::follow::record::{JumpRecord, StateRecord};
use std::fmt::Write;
use std::path::Path;

/// First line of `loop.csv`.
pub const LOOP_COLUMNS: &str = "branch,mean_displacement,stress,stress_over_max,contact_area,pattern,residual,stiffness_min,energy,model,milliseconds";

/// First line of `events.csv`.
pub const EVENT_COLUMNS: &str = "branch,mean_displacement,from,to,released_energy,cause";

/// Writes the states in order; u0 in the scene's length, stress in E*, stiffness in E*/L, energy
/// per area in E* times length.
///
/// # Errors
/// A file that cannot be written.
pub fn write_loop_csv(path: &Path, states: &[StateRecord]) -> Result<(), Failure> {
    let mut text = format!("{LOOP_COLUMNS}\n");
    for s in states {
        let cells = [
            s.direction.to_string(),
            number(s.mean_displacement),
            number(s.stress),
            number(s.stress_over_max),
            number(s.contact_area),
            s.pattern.to_string(),
            number(s.residual),
            number(s.stiffness_min),
            number(s.energy),
            quoted(&s.part.to_string()),
            format!("{:.4}", s.milliseconds),
        ];
        let _ = writeln!(text, "{}", cells.join(","));
    }
    files::write_whole(path, text.as_bytes())
}

/// Writes the jumps in order; u0 in the scene's length, released energy per area in units of gamma.
///
/// # Errors
/// A file that cannot be written.
pub fn write_events_csv(path: &Path, jumps: &[JumpRecord]) -> Result<(), Failure> {
    let mut text = format!("{EVENT_COLUMNS}\n");
    for jump in jumps {
        let (u0, released) = (number(jump.mean_displacement), number(jump.released_energy));
        let _ = writeln!(
            text,
            "{},{u0},{},{},{released},{}",
            jump.direction,
            jump.from,
            jump.to,
            quoted(&jump.cause_words())
        );
    }
    files::write_whole(path, text.as_bytes())
}

/// The shortest text that reads back as the same number.
pub(super) fn number(value: f64) -> String {
    format!("{value:?}")
}

/// A cell in quotes if it needs them.
pub(super) fn quoted(cell: &str) -> String {
    if cell.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", cell.replace('"', "\"\""))
    } else {
        cell.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_back_exactly() {
        for value in [0.1, 4.2, 1e-300, -3.0, 1.0 / 3.0] {
            assert_eq!(number(value).parse::<f64>(), Ok(value));
        }
    }

    #[test]
    fn a_cell_with_a_comma_is_quoted() {
        assert_eq!(quoted("flat, closed form"), "\"flat, closed form\"");
        assert_eq!(quoted("line"), "line");
    }
}
