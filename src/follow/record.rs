//! What a walk leaves behind: states and jumps.

use crate::physics::control::Control;
use crate::physics::law::Law;
use crate::physics::pattern::Pattern;
use crate::scene::Part;
use crate::solver::Stop;
use serde::{Deserialize, Serialize};
use std::fmt;

/// How closely, in ranges, the u0 of the end of a branch is found: ten times more closely than two
/// runs of any step or seed may differ.
pub const LOCATED: f64 = 1e-5;

/// Largest difference in stress (sigma_max) between two descriptions of one state.
pub(super) const SAME: f64 = 1e-4;

/// How far a `released` energy (gamma) may be off because the end of a branch is found within
/// [`LOCATED`], where the derivative of the energy with the control is one of these before and the
/// other after.
pub(super) fn located_energy(control: Control, law: &Law, [one, other]: [f64; 2]) -> f64 {
    LOCATED * control.unit(law) * (one - other).abs() / law.surface_energy
}

/// Accuracy (ranges) of u0 where a machine turns back, at most, and the share of [`LOCATED`] within
/// which the control is then known.
const TURN: f64 = 1e-3;
const TURNED: f64 = 0.1;

/// True if the control turns back so close to a state of a branch of this `slope` that it is known, with
/// u0 `off` (length) at most. Next to a fold of u0 the slope changes fast, and with it the control.
pub(super) fn has_turned(control: Control, law: &Law, slope: f64, off: f64) -> bool {
    let [driven, _] = control.balanced(off, slope * off);
    off.abs() < TURN * law.range && driven.abs() < TURNED * LOCATED * control.unit(law)
}

/// True if a state jumped into another, with which the energy of the surface falls by `released`
/// (gamma) and its derivative with the control changes from one of these to the other. What
/// releases no more than it may within [`LOCATED`] of where two branches meet goes over from one to
/// the other.
pub(super) fn is_jump(
    control: Control,
    law: &Law,
    [before, after]: [f64; 2],
    released: f64,
) -> bool {
    (after - before).abs() > SAME * control.conjugate_unit(law)
        && released > located_energy(control, law, [before, after])
}

/// Direction of the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Direction {
    /// The control decreases.
    Approach,
    /// The control increases.
    Retraction,
}

impl Direction {
    /// Both, in the order of a loop.
    pub const BOTH: [Self; 2] = [Self::Approach, Self::Retraction];
}

impl fmt::Display for Direction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Direction::Approach => "approach",
            Direction::Retraction => "retraction",
        })
    }
}

/// One equilibrium on the way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StateRecord {
    /// Direction of the drive.
    pub direction: Direction,
    /// What is driven: u0, the position of the stage (length), or the load per area (E*).
    pub control: f64,
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
    /// Energy per area of body and cohesion (E* times length).
    pub energy: f64,
    /// The part of the cell on which it was solved.
    pub part: Part,
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
    /// Why no loop begins with this state, and the remedy; `None` if one does.
    pub fn fault(&self) -> Option<(String, String)> {
        let finite = self.stress.is_finite() && self.energy.is_finite();
        let what = match self.stop {
            Stop::NotConverged => "did not converge".to_owned(),
            Stop::Cancelled => "was not reached before the stop".to_owned(),
            _ if !finite => "has no finite stress and energy".to_owned(),
            Stop::Unstable => format!(
                "is unstable (stiffness_min = {:.3} E*/L)",
                self.stiffness_min
            ),
            Stop::Stable | Stop::ReadOff => return None,
        };
        let remedy = "raise drive.start, to where the surface is at rest far from the ground";
        Some((
            format!("the first state {what}, and no loop begins with it"),
            remedy.to_owned(),
        ))
    }

    /// A record to stand in until the first state is measured.
    pub(crate) fn placeholder(mean_displacement: f64) -> Self {
        Self {
            direction: Direction::Approach,
            control: mean_displacement,
            mean_displacement,
            stress: f64::NAN,
            stress_over_max: f64::NAN,
            contact_area: f64::NAN,
            pattern: Pattern::Other,
            residual: f64::NAN,
            stiffness_min: f64::NAN,
            stiffness_error: f64::NAN,
            energy: f64::NAN,
            part: Part::Flat,
            stop: Stop::NotConverged,
            iterations: 0,
            transforms: 0,
            milliseconds: 0.0,
        }
    }
}

/// What made a state give way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Cause {
    /// The flat state lost stability (Eq. 8).
    FlatLimit,
    /// The branch turned back.
    Fold,
    /// An eigenvalue went through zero on a branch that goes on, unstable.
    SymmetryBreaking,
    /// The edge of the contact moved on by a spacing of the mesh: it vanishes with refinement, and
    /// is none of the physics.
    Mesh,
    /// No jump: the branch goes over into another one without a release, as at a supercritical
    /// bifurcation.
    Transition,
    /// Seen as a change of pattern between two increments of a method that locates nothing.
    PatternChange,
    /// Nothing: the surface was pressed by hand and let go.
    Push,
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Cause::FlatLimit => "flat limit",
            Cause::Fold => "fold",
            Cause::SymmetryBreaking => "symmetry breaking",
            Cause::Mesh => "mesh",
            Cause::Transition => "transition",
            Cause::PatternChange => "pattern change",
            Cause::Push => "push",
        })
    }
}

/// A pattern and the share of the mixtures that lead to it, 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Share {
    /// Where they lead.
    pub pattern: Pattern,
    /// How many of all.
    pub share: f64,
}

/// A jump at fixed control, or a transition without one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JumpRecord {
    /// Direction of the drive.
    pub direction: Direction,
    /// Where the control was (length; E* of a load).
    pub control: f64,
    /// u0 before (length).
    pub mean_displacement: f64,
    /// u0 after; the same where it is the control (length).
    pub mean_displacement_after: f64,
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
    /// How far that may be off because the end of the branch is located only so well (gamma).
    pub release_error: f64,
    /// What gave way.
    pub cause: Cause,
    /// All places where it might have landed, most often first; empty unless that is contested.
    pub landings: Vec<Share>,
}

impl JumpRecord {
    /// What it changed, in words: "flat → bulge"; "contact spreads" where the pattern has the same
    /// name before and after.
    pub fn change(&self) -> String {
        let down = self.direction == Direction::Approach;
        match (self.from, self.to) {
            (from, to) if from != to => format!("{} → {}", from.words(), to.words()),
            (Pattern::Contact, _) if down => "contact spreads".to_owned(),
            (Pattern::Contact, _) => "contact shrinks".to_owned(),
            (Pattern::Flat, _) if down => "flat → flat in contact".to_owned(),
            (Pattern::Flat, _) => "flat in contact → flat".to_owned(),
            (same, _) => format!("one {0} → another {0}", same.words()),
        }
    }

    /// What gave way, and where it lands if that is contested: "flat limit; contested: ridge 57 % /
    /// bulge 43 %".
    pub fn cause_words(&self) -> String {
        self.contested_words().map_or_else(
            || self.cause.to_string(),
            |words| format!("{}; {words}", self.cause),
        )
    }

    /// Where it may land, if that is contested: "contested: ridge 57 % / bulge 43 %".
    pub fn contested_words(&self) -> Option<String> {
        let say = |share: &Share| format!("{} {:.0} %", share.pattern, 100.0 * share.share);
        let all: Vec<String> = self.landings.iter().map(say).collect();
        (!all.is_empty()).then(|| format!("contested: {}", all.join(" / ")))
    }
}

/// Everything recorded along a path, in order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LoopRecord {
    /// What was driven.
    pub control: Control,
    /// The states in the order they were reached. A jump stands between two states of equal
    /// control.
    pub states: Vec<StateRecord>,
    /// The jumps and transitions in the order they happened.
    pub jumps: Vec<JumpRecord>,
}

impl LoopRecord {
    /// Nothing recorded yet of a path of this control.
    pub fn of(control: Control) -> Self {
        Self {
            control,
            ..Self::default()
        }
    }

    /// The path in pieces along which direction and pattern stay.
    pub fn pieces(&self) -> impl Iterator<Item = &[StateRecord]> {
        let same =
            |a: &StateRecord, b: &StateRecord| (a.direction, a.pattern) == (b.direction, b.pattern);
        self.states.chunk_by(same)
    }

    /// How many there are of each kind.
    pub fn tally(&self) -> Tally {
        let of = |cause: Cause| self.jumps.iter().filter(|jump| jump.cause == cause).count();
        let (of_the_mesh, transitions) = (of(Cause::Mesh), of(Cause::Transition));
        Tally {
            jumps: self.jumps.len() - of_the_mesh - transitions,
            of_the_mesh,
            transitions,
        }
    }
}

/// What happened along a path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Jumps of the physics.
    pub jumps: usize,
    /// Jumps of the mesh.
    pub of_the_mesh: usize,
    /// Transitions without a jump.
    pub transitions: usize,
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let counted = |n: usize, what: &str| format!("{n} {what}{}", if n == 1 { "" } else { "s" });
        f.write_str(&counted(self.jumps, "jump"))?;
        if self.of_the_mesh > 0 {
            write!(f, " and {} of the mesh", self.of_the_mesh)?;
        }
        if self.transitions > 0 {
            write!(f, ", {}", counted(self.transitions, "transition"))?;
        }
        Ok(())
    }
}
