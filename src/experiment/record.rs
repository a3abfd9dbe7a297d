//! What a walk leaves behind: states, jumps, and the loop with its energy ledger.

use crate::numerics::quadrature::integral;
use crate::physics::pattern::Pattern;
use crate::solver::Stop;
use std::fmt;

/// Direction of the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Branch {
    /// u0 decreases.
    Approach,
    /// u0 increases.
    Retraction,
}

impl fmt::Display for Branch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Branch::Approach => "approach",
            Branch::Retraction => "retraction",
        })
    }
}

/// One equilibrium on the way.
#[derive(Clone, Debug, PartialEq)]
pub struct StateRecord {
    /// Direction of the drive.
    pub branch: Branch,
    /// Mean displacement u0 (length).
    pub mean_displacement: f64,
    /// Mean stress, positive in tension (E*).
    pub stress: f64,
    /// Mean stress over the law's largest traction.
    pub stress_over_max: f64,
    /// Share of the cell with a gap below that of the largest traction, 0 to 1.
    pub contact_area: f64,
    /// Pattern by topology.
    pub pattern: Pattern,
    /// max |residual traction| / sigma_max.
    pub residual: f64,
    /// Smallest Hessian eigenvalue per area, sliding modes removed (E*/L).
    pub stiffness_min: f64,
    /// Bound on the error of `stiffness_min` (E*/L).
    pub stiffness_error: f64,
    /// Energy per area (E* times length).
    pub energy: f64,
    /// Which model produced it ("flat, closed form"; "whole cell 64 x 64"; ...).
    pub model: &'static str,
    /// Why the solver stopped here.
    pub stop: Stop,
    /// Iterations of the method spent on it (Newton steps or time steps).
    pub iterations: usize,
    /// Fourier transforms spent on it.
    pub transforms: usize,
    /// Wall milliseconds spent on it.
    pub milliseconds: f64,
}

impl StateRecord {
    /// A record to stand in until the first state is measured.
    pub(crate) fn placeholder(mean_displacement: f64) -> Self {
        Self {
            branch: Branch::Approach,
            mean_displacement,
            stress: f64::NAN,
            stress_over_max: f64::NAN,
            contact_area: f64::NAN,
            pattern: Pattern::Other,
            residual: f64::NAN,
            stiffness_min: f64::NAN,
            stiffness_error: f64::NAN,
            energy: f64::NAN,
            model: "",
            stop: Stop::NotConverged,
            iterations: 0,
            transforms: 0,
            milliseconds: 0.0,
        }
    }
}

/// What made a state give way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Cause {
    /// The flat state lost stability (Eq. 8).
    FlatLimit,
    /// The branch turned back.
    Fold,
    /// An eigenvalue went through zero on a branch that goes on, unstable.
    SymmetryBreaking,
    /// Seen as a change of pattern between two increments of a method that locates nothing.
    PatternChange,
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Cause::FlatLimit => "flat limit",
            Cause::Fold => "fold",
            Cause::SymmetryBreaking => "symmetry breaking",
            Cause::PatternChange => "pattern change",
        })
    }
}

/// A jump at fixed u0.
#[derive(Clone, Debug, PartialEq)]
pub struct JumpRecord {
    /// Direction of the drive.
    pub branch: Branch,
    /// Where it happened (length).
    pub mean_displacement: f64,
    /// Pattern before.
    pub from: Pattern,
    /// Pattern after.
    pub to: Pattern,
    /// Mean stress before (E*).
    pub stress_before: f64,
    /// Mean stress after (E*).
    pub stress_after: f64,
    /// Energy released per area, in units of gamma.
    pub released_energy: f64,
    /// What gave way.
    pub cause: Cause,
}

/// Everything recorded along a path, in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoopRecord {
    /// The states in the order they were reached. A jump stands between two states of equal u0.
    pub states: Vec<StateRecord>,
    /// The jumps in the order they happened.
    pub jumps: Vec<JumpRecord>,
}

impl LoopRecord {
    /// The loop integral of stress du0 over the recorded states, energy per area (E* times length).
    ///
    /// Smooth branches by [`integral`]; at a jump the stress before it holds up to the jump, which is a vertical line. Positive for a
    /// closed approach and retraction.
    pub fn work(&self) -> f64 {
        self.branches().iter().map(|branch| integral(branch)).sum()
    }

    /// The points (u0, stress) of each stretch without a jump or a turn.
    pub fn branches(&self) -> Vec<Vec<[f64; 2]>> {
        let mut jumps = self.jumps.iter().peekable();
        let mut branches = Vec::new();
        let mut branch: Vec<[f64; 2]> = Vec::new();
        let mut way = 0.0;
        for pair in self.states.windows(2) {
            let [a, b] = [&pair[0], &pair[1]].map(|state| [state.mean_displacement, state.stress]);
            if branch.is_empty() {
                branch.push(a);
            }
            let du = b[0] - a[0];
            let jump = jumps.next_if(|j| j.branch == pair[1].branch && j.mean_displacement == b[0]);
            if du * way < 0.0 {
                branches.push(std::mem::replace(&mut branch, vec![a]));
            }
            way = du;
            match jump {
                Some(jump) if jump.cause != Cause::PatternChange => {
                    if du != 0.0 {
                        branch.push([b[0], jump.stress_before]);
                    }
                    branches.push(std::mem::replace(&mut branch, vec![b]));
                }
                // Somewhere on the way it jumped: a straight line from state to state.
                Some(_) => {
                    branches.push(std::mem::replace(&mut branch, vec![b]));
                    branches.push(vec![a, b]);
                }
                None if du == 0.0 => branches.push(std::mem::replace(&mut branch, vec![b])),
                None => branch.push(b),
            }
        }
        branches.push(branch);
        branches
    }

    /// Sum of the released energies, in units of gamma.
    pub fn released_energy_sum(&self) -> f64 {
        self.jumps.iter().map(|jump| jump.released_energy).sum()
    }
}
