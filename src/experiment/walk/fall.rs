//! Jumps of a mesh that traps the edge of a contact: single points let go every few steps.
//!
//! To bracket each of them as closely as a collective jump, and to release it by dynamics, would cost more than the way between them.
//! Here a step that Newton's method refuses is gone downhill from where the branch was heading, which always ends somewhere. The
//! energy tells whether something let go on the way; then the step is halved until it is short enough to say where.

use super::landing::Leaving;
use super::{Before, Happening, Progress, Walk};
use crate::experiment::record::Cause;
use crate::solver::Stop;
use crate::solver::method::predicted;
use crate::solver::newton::{NewtonEnd, NewtonLimits, descend};

/// Newton steps of a descent, and the longest of them (root mean square, ranges): a few points settle so. What needs more is a
/// collective jump.
const DESCENT: usize = 40;
const REACH: f64 = 0.02;
/// Energy, in gamma, above which a step released some. On 512 x 512 points at mu_rho = 1 what is below adds up to 5e-4 of the loss of
/// JKR, a thousandth of the loop's own.
const RELEASED: f64 = 1e-7;

impl Walk {
    /// The same walk, for a mesh that traps the edge of a contact: jumps of a few points are located within so many `ranges`.
    pub fn locating_within(self, ranges: f64) -> Self {
        Self { falls_within: Some(ranges), ..self }
    }

    /// The step to `next` downhill. `None` if it is not for this walk, or is more than the jump of a few points: then the end of the
    /// branch is to be bracketed.
    pub(super) fn fall(&mut self, next: f64, observe: &mut dyn FnMut(Happening)) -> Option<Progress> {
        let within = self.falls_within?;
        let (law, du) = (self.model.law, next - self.here.state.mean_displacement);
        let limits = NewtonLimits { steps: DESCENT, ..NewtonLimits::of(&self.mechanics.system) };
        let heading = predicted(&mut self.mechanics, &self.history, &self.here, next);
        let settled = descend(&mut self.mechanics, heading, next, REACH * law.range, limits);
        if settled.end != NewtonEnd::Converged {
            return (settled.end == NewtonEnd::Cancelled).then_some(Progress::Cancelled);
        }
        // To second order in the step, which is long against what a single point releases.
        let (here, stress) = (self.here.state.mean_displacement, self.here.state.stress);
        let slope = |before: Before| (stress - before.stress) / (here - before.at);
        let stress_before = stress + self.before.map_or(0.0, slope) * du;
        let work = 0.5 * (stress + stress_before) * du;
        let released = (self.here.state.energy + work - settled.at.state.energy) / law.surface_energy;
        let jumped = released.abs() > RELEASED;
        if jumped && du.abs() > within * law.range {
            self.short = Some(0.5 * du.abs());
            return Some(Progress::Working);
        }
        if jumped {
            self.forget_modes();
        }
        let state = match self.assessed(settled) {
            Ok(state) => state,
            Err(progress) => return Some(progress),
        };
        if state.stop == Stop::Unstable || released < -RELEASED {
            return None;
        }
        self.counts.iterations += state.cost.iterations;
        if !jumped {
            return Some(self.take(state, observe));
        }
        self.arrive(
            state,
            Leaving { stress: stress_before, released, cause: Cause::Fold, landings: Vec::new() },
            RELEASED,
            observe,
        );
        Some(Progress::Working)
    }
}
