//! From a state to its record, and what is no jump: patterns that come and go continuously.

use super::landing::EVENT;
use super::{Observed, Walk};
use crate::follow::flat_branch::FlatBranch;
use crate::follow::record::{Cause, Direction, JumpRecord, StateRecord};
use crate::physics::pattern::{Pattern, classify, contact_area};
use crate::physics::theory::flat_limits;
use crate::scene::Part;
use crate::solver::equilibrium::{Cost, Equilibrium, Stiffness};
use crate::solver::newton::{NewtonEnd, NewtonLimits, solve};

/// Released energy, in gamma, from which nobody asks whether a landing on another pattern was a
/// jump.
const WEAK: f64 = 1e-2;
/// How far before a limit, in ranges, a jump is told from a continuous transition: more than limits
/// are uncertain.
const APART: f64 = 3e-4;

impl Walk {
    pub(super) fn pattern(&mut self) -> Pattern {
        if self.here.is_uniform() && self.mechanics.system.is_flat() {
            return Pattern::Flat;
        }
        let thermal = if self.method.locates() {
            0.0
        } else {
            0.02 * self.model.law.range
        };
        if self.mechanics.system.is_flat() && self.here.state.roughness() < thermal {
            return Pattern::Flat;
        }
        classify(
            self.mechanics.system.unfolded(&self.here.fields.gap).view(),
            &self.model.law,
            self.mechanics.system.is_flat(),
        )
    }

    /// Writes the record of the present state and hands it out.
    pub(super) fn accept(&mut self, observe: &mut dyn FnMut(Observed)) {
        let law = self.model.law;
        let uniform = self.here.is_uniform() && self.mechanics.system.is_flat();
        let pattern = self.pattern();
        if self.method.locates() {
            self.note_transition(pattern, observe);
        }
        let contact_area = if uniform {
            f64::from(u8::from(
                self.here.state.mean_displacement < law.contact_gap(),
            ))
        } else {
            contact_area(self.here.fields.gap.view(), &law)
        };
        if pattern != Pattern::Flat {
            self.spent.counts.patterned_increments += 1;
        }
        self.pause_clock();
        let stiffness = self.here.stiffness_min.unwrap_or(Stiffness {
            value: f64::NAN,
            error: f64::NAN,
        });
        let length = self.model.grid.length;
        self.record = StateRecord {
            direction: self.direction,
            control: self.here.state.control,
            mean_displacement: self.here.state.mean_displacement,
            stress: self.here.state.stress,
            stress_over_max: self.here.state.stress / law.traction_max(),
            contact_area,
            pattern,
            residual: self.here.residual,
            stiffness_min: stiffness.value * length,
            stiffness_error: stiffness.error * length,
            energy: self.here.state.body_energy(self.control()),
            part: match self.options.part {
                _ if uniform && self.flat.is_some() => Part::Flat,
                part if self.model.grid.is_line() => part.of_line(),
                part => part,
            },
            stop: self.here.stop,
            iterations: self.spent.counts.iterations - self.spent.recorded.iterations,
            transforms: self.transforms() - self.spent.recorded.transforms,
            milliseconds: std::mem::take(&mut self.spent.worked).as_secs_f64() * 1e3,
        };
        self.spent.recorded = Cost {
            iterations: self.spent.counts.iterations,
            transforms: self.transforms(),
        };
        observe(Observed::State(self.record.clone()));
    }

    /// True if the surface came to the present state, of another pattern, without a jump: then the
    /// branch it is on goes over into the one it left, as at a supercritical bifurcation, and there
    /// is no stable state of it at a distance before the limit. After a jump there is one, beside
    /// the state that was left.
    pub(super) fn is_continuous(
        &mut self,
        from: Pattern,
        to: Pattern,
        released: f64,
        event: f64,
    ) -> bool {
        let weak = released < WEAK && (from == Pattern::Flat) != (to == Pattern::Flat);
        let Some(flat) = self.flat.filter(|_| weak) else {
            return false;
        };
        let side = if self.direction == Direction::Approach {
            1.0
        } else {
            -1.0
        };
        if to == Pattern::Flat {
            let before = self.here.state.mean_displacement + side * APART * self.model.law.range;
            return !flat.is_stable(before);
        }
        let before = self.here.state.control + side * APART * self.unit();
        // So soft a state is told from the flat one only by a small residual.
        let limits = NewtonLimits {
            tolerance: self.mechanics.system.precision().floor().max(1e-10),
            ..NewtonLimits::of(&self.mechanics.system)
        };
        // The state is taken already: this last question is answered even if somebody asks to stop.
        let cancel = std::mem::take(&mut self.mechanics.cancel);
        let pattern = self.here.state.amplitudes.clone();
        let found = solve(&mut self.mechanics, pattern, before, limits);
        self.mechanics.cancel = cancel;
        match found.end {
            NewtonEnd::Converged => found.at.state.roughness() < 0.5 * self.here.state.roughness(),
            _ => released.abs() <= event,
        }
    }

    /// True where the flat state is stable and `state` no more than a trace of a pattern on it,
    /// which the tolerance lets be.
    pub(super) fn is_as_good_as_flat(&self, flat: FlatBranch, state: &Equilibrium) -> bool {
        let (at, law) = (state.state.mean_displacement, &self.model.law);
        flat.is_stable(at)
            && (state.state.body_energy(self.control()) - law.at(at).energy).abs()
                <= EVENT * law.surface_energy
    }

    /// Tells of a pattern that came out of the flat state, or went into it, on the way to the
    /// present state without the branch having come to an end: the flat state has its limit in
    /// between, on the stable side of which the surface is as good as flat.
    pub(super) fn note_transition(&self, now: Pattern, observe: &mut dyn FnMut(Observed)) {
        let Some(flat) = self.flat else { return };
        let (a, b, law) = (&self.record, &self.here.state, &self.model.law);
        let Some(limits) = flat_limits(law, self.model.equivalent_length) else {
            return;
        };
        let (low, high) = (
            a.mean_displacement.min(b.mean_displacement),
            a.mean_displacement.max(b.mean_displacement),
        );
        let Some(at) = [limits.0, limits.1]
            .into_iter()
            .find(|limit| low < *limit && *limit <= high)
        else {
            return;
        };
        let leaves = flat.is_stable(a.mean_displacement);
        let (stable, energy, pattern) = if leaves {
            (a.mean_displacement, a.energy, now)
        } else {
            (b.mean_displacement, b.energy, a.pattern)
        };
        if (energy - law.at(stable).energy).abs() > EVENT * law.surface_energy
            || pattern == Pattern::Flat
        {
            return;
        }
        let stress = law.at(at).traction;
        let work = 0.5
            * ((a.stress + stress) * (at - a.mean_displacement)
                + (stress + b.stress) * (b.mean_displacement - at));
        observe(Observed::Jump(JumpRecord {
            direction: self.direction,
            control: self.control().balanced(at, stress)[0],
            mean_displacement: at,
            mean_displacement_after: at,
            from: if leaves { Pattern::Flat } else { pattern },
            to: if leaves { pattern } else { Pattern::Flat },
            stress_before: stress,
            stress_after: stress,
            released_energy: 0.0,
            release_error: (a.energy + work - b.energy).abs() / law.surface_energy,
            cause: Cause::Transition,
            landings: Vec::new(),
        }));
    }
}
