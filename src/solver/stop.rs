//! Why a computation stopped.

use std::fmt;

/// The honest end of a relaxation; every shown state carries one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stop {
    /// Residual below tolerance and no negative eigenvalue beyond its error.
    Stable,
    /// Residual below tolerance, but the smallest eigenvalue is negative.
    Unstable,
    /// Budget spent with the residual above tolerance.
    NotConverged,
    /// Read off between states that were solved and are stable; not solved itself, and so without a
    /// residual.
    ReadOff,
    /// Somebody asked to stop.
    Cancelled,
}

impl fmt::Display for Stop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Stop::Stable => "converged, stable",
            Stop::Unstable => "converged, unstable",
            Stop::NotConverged => "not converged",
            Stop::ReadOff => "read off a stable branch",
            Stop::Cancelled => "cancelled",
        })
    }
}

/// Why a branch was not followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lost {
    /// No equilibrium near the prediction.
    Gone,
    /// Negative curvature on the way.
    Unstable,
    /// The numbers stopped being finite; why, in words.
    Diverged(&'static str),
    /// Somebody asked to stop.
    Cancelled,
}
