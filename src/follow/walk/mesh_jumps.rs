//! Jumps of a mesh that traps the edge of a contact: single points let go every few steps.
//!
//! To bracket each of them as closely as a collective jump, and to release it by dynamics, would
//! cost more than the way between them. Here a step that Newton's method refuses is gone downhill
//! from where the branch was heading, which always ends somewhere. The energy tells whether
//! something let go on the way; then the step is halved until it is short enough to say where.

use super::landing::Leaving;
use super::{Observed, Progress, Walk};
use crate::follow::record::Cause;
use crate::physics::mesh;
use crate::physics::pattern::{contact_set, moves_by_a_spacing};
use crate::solver::Stop;
use crate::solver::equilibrium::Equilibrium;
use crate::solver::method::predicted;
use crate::solver::newton::{NewtonEnd, NewtonLimits, descend};

/// Newton steps of a descent, and the longest of them (root mean square, ranges): a few points
/// settle so. What needs more is a collective jump.
const DESCENT: usize = 40;
const LONGEST: f64 = 0.02;
/// Energy, in gamma, above which a step released some. On 512 x 512 points at mu_rho = 1 what is
/// below adds up to 5e-4 of the loss of JKR, a thousandth of the loop's own.
const RELEASED: f64 = 1e-7;

impl Walk {
    /// The step to `next` downhill. `None` if it is not for this walk, or is more than the jump of
    /// a few points: then the end of the branch is to be bracketed.
    pub(super) fn fall(
        &mut self,
        next: f64,
        observe: &mut dyn FnMut(Observed),
    ) -> Option<Progress> {
        let within = self.options.trapped_within?;
        let (law, step) = (self.model.law, next - self.here.state.control);
        let limits = NewtonLimits {
            steps: DESCENT,
            ..NewtonLimits::of(&self.mechanics.system)
        };
        let heading = predicted(&mut self.mechanics, &self.behind.history, &self.here, next);
        let settled = descend(
            &mut self.mechanics,
            heading,
            next,
            LONGEST * law.range,
            limits,
        );
        if settled.end != NewtonEnd::Converged {
            return (settled.end == NewtonEnd::Cancelled).then_some(Progress::Cancelled);
        }
        // To second order in the step, which is long against what a single point releases.
        let (conjugate, energy) = self.carried_to(next);
        let released = (energy - settled.at.state.energy) / law.surface_energy;
        let jumped = released.abs() > RELEASED;
        if jumped && step.abs() > within * self.unit() {
            self.behind.short = Some(0.5 * step.abs());
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
        self.spent.counts.iterations += state.cost.iterations;
        if !jumped {
            return Some(self.take(state, observe));
        }
        self.arrive(
            state,
            Leaving {
                conjugate,
                released,
                cause: Cause::Fold,
                landings: Vec::new(),
            },
            RELEASED,
            observe,
        );
        Some(Progress::Working)
    }

    /// True if a coarse mesh is why the surface jumped from `left` to the present state: on no mesh
    /// does the edge of the contact move by more than a spacing in such a jump, so that it vanishes
    /// with refinement. Meshes on which the shortest wave that a smooth law makes unstable is many
    /// spacings long have no such jumps.
    pub(super) fn is_of_the_mesh(&mut self, left: &Equilibrium) -> bool {
        let law = self.model.law;
        if law.is_smooth() && mesh::is_safe(self.model.mu_rho) {
            return false;
        }
        let contact = |of: &Equilibrium| {
            contact_set(
                self.mechanics.system.unfolded(&of.fields.gap).view(),
                law.contact_gap(),
            )
        };
        moves_by_a_spacing(&contact(left), &contact(&self.here))
    }
}
