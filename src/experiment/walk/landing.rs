//! The release at the end of a branch, and the landing on what is stable.

use super::advance::FIRST;
use super::{Barrier, Happening, Jumping, Progress, Walk, problem};
use crate::experiment::contest::{KICK as FLAT_KICK, Share};
use crate::experiment::record::{Cause, JumpRecord};
use crate::numerics::cancel::Cancel;
use crate::numerics::krylov::{CgLimits, conjugate_gradients};
use crate::numerics::vector::{add, dot, norm};
use crate::physics::pattern::Pattern;
use crate::solver::Stop;
use crate::solver::branch::History;
use crate::solver::equilibrium::{Cost, Equilibrium};
use crate::solver::newton::{NewtonEnd, NewtonLimits, NewtonState, centred, sliding_basis, solve};
use crate::solver::problem::Slides;
use crate::solver::release::{Release, Slice};
use rand::Rng;

/// Root mean square kick along the soft mode, in ranges.
const KICK: f64 = 0.1;
/// Largest kick of any single point over the root mean square: a mode of a few points is kicked no harder than a wave.
const PEAK: f64 = 4.0;
/// The smallest one tried, where a larger one ended higher than it began.
const LEAST_KICK: f64 = 1e-4;
/// Released energy, in gamma, below which a landing on the same pattern is no jump.
pub(super) const EVENT: f64 = 1e-6;
/// Time steps of a release between two pictures.
const SLICE: usize = 6;
/// Share of a soft mode in what u0 pushes below which that is no push: of 60 ends on even and uneven ground folds have 0.01 and more,
/// and broken symmetries, which mesh and tolerance leave inexact, up to 4e-5.
const UNPUSHED: f64 = 1e-3;
/// Stiffness of what u0 pushes, in units of q1, below which it gives way: at those folds it is 0.02 at most, elsewhere 0.18 and more.
const SOFT: f64 = 0.05;
/// How often an unstable landing may be kicked on before the walk gives up.
const KICKS: usize = 8;

/// How a branch was left.
pub(super) struct Leaving {
    /// Mean stress where it ended (E*).
    pub(super) stress: f64,
    /// Energy released from there to where the surface landed (gamma).
    pub(super) released: f64,
    /// What gave way.
    pub(super) cause: Cause,
    /// Where kicks lead, if that is contested.
    pub(super) landings: Vec<Share>,
}

impl Walk {
    /// Starts the release at the end of a patterned branch, to the side of its soft mode on which the energy falls.
    pub(super) fn release(&mut self, barrier: Barrier, cancel: &Cancel) -> Progress {
        let cause = self.cause(&barrier.soft_mode, cancel);
        self.release_because(cause, barrier, Vec::new())
    }

    /// Starts the release at a barrier; from a flat limit that leads to several `landings`, to one of them.
    pub(super) fn release_because(
        &mut self,
        cause: Cause,
        Barrier { at, soft_mode, .. }: Barrier,
        landings: Vec<Share>,
    ) -> Progress {
        let (_, energy_before) = self.carried_to(at);
        let from_flat = cause == Cause::FlatLimit;
        let kick = if from_flat { FLAT_KICK } else { KICK };
        let z = self.kicked(&self.state.field.clone(), at, &soft_mode, kick, !from_flat);
        let release = Release::new(z, at).with_tolerance(self.system.precision().tolerance());
        self.jumping = Some(Jumping { release, cause, kicks: 1, soft_mode, kick, energy_before, landings });
        Progress::Working
    }

    /// What ends the present branch, of which `mode` goes soft. Where u0 itself pushes the surface along a mode without stiffness the
    /// branch turns back; where it does not, by symmetry, the branch goes on and is unstable.
    fn cause(&mut self, mode: &[f64], cancel: &Cancel) -> Cause {
        if mode.is_empty() {
            return Cause::Fold;
        }
        let mut push = vec![0.0; mode.len()];
        self.system.evaluate(&self.state.field, self.state.mean_displacement, &mut push, &mut self.ws);
        self.system.stiffness_amplitudes(&mut push, &mut self.ws);
        if dot(&push, mode).abs() > UNPUSHED * norm(&push) * norm(mode) {
            return Cause::Fold;
        }
        // A pattern that hardly anything holds in its place may slide more easily still than it folds: what the push does tells.
        let Self { system, preconditioner, slides, ws, state, .. } = self;
        let removed = sliding_basis(system, &state.field, *slides, ws);
        let limits = CgLimits { tolerance: 0.03, products: NewtonLimits::default().products };
        let apply = |v: &[f64], out: &mut [f64]| system.hessian(v, out, ws);
        let moved = conjugate_gradients(apply, &push, |r, out| preconditioner.apply(r, out), &removed, limits, cancel).x;
        let stiffness = dot(&moved, &push) / dot(&moved, &moved);
        if stiffness < SOFT * system.grid().q1() { Cause::Fold } else { Cause::SymmetryBreaking }
    }

    /// Stress and energy of the branch at `u0`, a hair beyond the present state: to second order, with the slope of the stress from
    /// the state before.
    fn carried_to(&self, u0: f64) -> (f64, f64) {
        let (here, stress, du) = (self.state.mean_displacement, self.state.stress, u0 - self.state.mean_displacement);
        let slope = self.before.map_or(0.0, |before| (stress - before.stress) / (here - before.at));
        let there = stress + slope * du;
        (there, self.state.energy + 0.5 * (stress + there) * du)
    }

    /// `z` moved by `kick` (ranges) along `mode`: downhill where the two sides differ, and to a side drawn from the seed where they do not.
    pub(super) fn kicked(&mut self, z: &[f64], u0: f64, mode: &[f64], kick: f64, choose: bool) -> Vec<f64> {
        let mut size = kick * self.model.law.range;
        if !mode.is_empty() {
            let peak = self.system.field(mode, &mut self.ws).iter().fold(0.0, |most: f64, v| most.max(v.abs()));
            size *= (PEAK / peak).min(1.0);
        }
        let random = if self.rng.random::<bool>() { 1.0 } else { -1.0 };
        let mut side = |sign: f64| {
            let mut moved = z.to_vec();
            if !mode.is_empty() {
                add(&mut moved, sign * size, mode);
            }
            let mut g = vec![0.0; moved.len()];
            let energy = self.system.evaluate(&moved, u0, &mut g, &mut self.ws).energy;
            (moved, energy)
        };
        let (one, energy_one) = side(random);
        if !choose {
            return one;
        }
        let (other, energy_other) = side(-random);
        let equal = 1e-7 * self.model.law.surface_energy;
        if energy_other < energy_one - equal || !energy_one.is_finite() { other } else { one }
    }

    pub(super) fn relax(&mut self, mut jumping: Jumping, cancel: &Cancel, observe: &mut dyn FnMut(Happening)) -> Progress {
        let slice = jumping.release.advance(&self.system, SLICE, &mut self.preconditioner, self.slides, &mut self.ws, cancel);
        let u0 = jumping.release.u0;
        match slice {
            Slice::Moving => {
                let stress = jumping.release.stress;
                self.jumping = Some(jumping);
                observe(Happening::Moving { stress });
                Progress::Working
            }
            Slice::Cancelled => {
                self.jumping = Some(jumping);
                Progress::Cancelled
            }
            Slice::Stuck => Progress::Stuck(format!("the release at u0 = {u0:.6} found no way down")),
            Slice::Settled(settled) => self.settle(jumping, settled, cancel, observe),
        }
    }

    /// Checks the stability of where the release came to rest; lands there, or kicks on.
    pub(super) fn settle(
        &mut self,
        mut jumping: Jumping,
        settled: NewtonState,
        cancel: &Cancel,
        observe: &mut dyn FnMut(Happening),
    ) -> Progress {
        let u0 = jumping.release.u0;
        let dimension = self.system.dimension();
        let landed = match self.flat {
            Some(flat) if norm(&settled.z) < 1e-4 * self.model.law.range => {
                let mut state = flat.state(u0, dimension);
                if state.stop == Stop::Unstable {
                    state.soft_mode = self.random_soft_wave();
                }
                state
            }
            _ => match self.measure(settled, u0, jumping.release.steps, cancel) {
                Ok(state) => state,
                Err(progress) => {
                    self.jumping = Some(jumping);
                    return progress;
                }
            },
        };
        if landed.stop == Stop::Unstable {
            if jumping.kicks >= KICKS {
                return Progress::Stuck(format!("after the jump at u0 = {u0:.6} every resting place found was unstable"));
            }
            jumping.kicks += 1;
            let z = self.kicked(&landed.field, u0, &landed.soft_mode, KICK, true);
            // Where a saddle and the minima beside it all meet the tolerance, only a tighter one tells them apart.
            let tolerance = (jumping.release.tolerance() * 0.1).max(1e-10).max(self.system.precision().floor());
            jumping.release = Release::new(z, u0).with_tolerance(tolerance);
            self.jumping = Some(jumping);
            return Progress::Working;
        }
        self.land(jumping, landed, observe)
    }

    /// Centres, polishes and measures a pattern that settled after `steps` of a release; `Err` as [`Walk::assessed`].
    pub(super) fn measure(
        &mut self,
        mut settled: NewtonState,
        u0: f64,
        steps: usize,
        cancel: &Cancel,
    ) -> Result<Equilibrium, Progress> {
        settled = self.centred(&settled.z, u0, cancel).unwrap_or(settled);
        let mut gradient = vec![0.0; settled.z.len()];
        self.system.evaluate(&settled.z, u0, &mut gradient, &mut self.ws);
        self.forget_modes();
        settled.steps += steps;
        self.assessed(settled, u0, cancel)
    }

    /// The pattern `z` where the mesh does not pull at it and its energy is the lowest, if it slides.
    fn centred(&mut self, z: &[f64], u0: f64, cancel: &Cancel) -> Option<NewtonState> {
        self.system.evaluate(z, u0, &mut vec![0.0; z.len()], &mut self.ws);
        if sliding_basis(&self.system, z, self.slides, &mut self.ws).is_empty() {
            return None;
        }
        let rounding = self.system.precision().rounding() * self.model.law.surface_energy;
        let mut lowest: Option<NewtonState> = None;
        let all = [[false, false], [true, false], [false, true], [true, true]];
        for between in if self.slides == Slides::Freely { &all[..1] } else { &all } {
            let moved = centred(&self.system, z, *between);
            let problem = problem(&self.system, &self.preconditioner, self.slides);
            let polished = solve(&problem, moved, u0, NewtonLimits::of(&self.system), &mut self.ws, cancel);
            let lower = lowest.as_ref().is_none_or(|lowest| polished.at.energy < lowest.at.energy - rounding);
            if polished.end == NewtonEnd::Converged && lower {
                lowest = Some(polished);
            }
        }
        lowest
    }

    /// Forgets the soft modes of a branch that is left.
    pub(super) fn forget_modes(&mut self) {
        self.tracker.reset();
        if let Some(guard) = &mut self.guard {
            guard.reset();
        }
    }

    /// The equilibrium at which the workspace was last evaluated, with its stability; `Err` if cancelled, or if it leaves the symmetry
    /// of the model.
    pub(super) fn assessed(&mut self, settled: NewtonState, u0: f64, cancel: &Cancel) -> Result<Equilibrium, Progress> {
        self.preconditioner.refresh(&self.system, &mut self.ws);
        let (stiffness, mode) =
            self.tracker.check(&self.system, &settled.z, self.slides, &self.preconditioner, &mut self.ws, cancel);
        let stiffness = self.all_modes(stiffness, cancel).map_err(Progress::Stuck)?;
        if cancel.requested() {
            return Err(Progress::Cancelled);
        }
        let mut state = Equilibrium::unmeasured(
            u0,
            settled.z,
            settled.residual,
            settled.at,
            Stop::Stable,
            Cost { iterations: settled.steps, transforms: 0 },
        );
        state.measured(stiffness, mode);
        Ok(state)
    }

    pub(super) fn land(&mut self, mut jumping: Jumping, landed: Equilibrium, observe: &mut dyn FnMut(Happening)) -> Progress {
        let law = self.model.law;
        let released = (jumping.energy_before - landed.energy) / law.surface_energy;
        let (stress_before, _) = self.carried_to(landed.mean_displacement);
        self.counts.iterations += landed.cost.iterations;
        if released < -EVENT && jumping.kick > LEAST_KICK {
            // Where minima lie close together (a law whose stiffness jumps), so large a kick has gone up and over into another one.
            jumping.kick *= 0.1;
            let u0 = landed.mean_displacement;
            let z = self.kicked(&self.state.field.clone(), u0, &jumping.soft_mode.clone(), jumping.kick, true);
            jumping.release = Release::new(z, u0).with_tolerance(self.system.precision().tolerance());
            self.jumping = Some(jumping);
            return Progress::Working;
        }
        if released < -EVENT {
            return Progress::Stuck(format!(
                "the release at u0 = {:.6} would have gained energy ({released:.2e} gamma), which is a failure of the solver",
                landed.mean_displacement
            ));
        }
        let Jumping { cause, landings, .. } = jumping;
        self.arrive(landed, Leaving { stress: stress_before, released, cause, landings }, EVENT, observe);
        Progress::Working
    }

    /// Stands on the state where a jump ended. What released less than `event` (gamma) was none, unless the flat state was left or
    /// reached: Newton can fail on a branch that goes on, a mode can soften without a jump, and faint patterns change their names.
    pub(super) fn arrive(
        &mut self,
        landed: Equilibrium,
        Leaving { stress: stress_before, released, cause, landings }: Leaving,
        event: f64,
        observe: &mut dyn FnMut(Happening),
    ) {
        let left = std::mem::replace(&mut self.state, landed);
        // The flat state is known everywhere.
        let first = (!(self.flat.is_some() && self.state.is_uniform())).then_some(FIRST * self.model.law.range);
        (self.before, self.short) = (None, first.filter(|first| *first < self.step));
        let (from, to) = (self.record.pattern, self.pattern());
        let as_good_as_flat = |state: &Equilibrium| self.flat.is_some_and(|flat| self.is_as_good_as_flat(flat, state));
        let from = if as_good_as_flat(&left) { Pattern::Flat } else { from };
        let to = if as_good_as_flat(&self.state) { Pattern::Flat } else { to };
        if released <= event && (from == to || (from != Pattern::Flat && to != Pattern::Flat)) {
            self.remember();
            return self.accept(observe);
        }
        let du = (self.state.mean_displacement - left.mean_displacement).abs();
        // The end lies somewhere on the way from the last state: what the release changes on it, and what the energy was carried.
        let changed = (self.state.stress - stress_before).abs() + 0.5 * (stress_before - left.stress).abs();
        let located = du * changed / self.model.law.surface_energy;
        let (released_energy, release_error, cause) = if self.is_continuous(from, to, released, event) {
            (0.0, released.abs(), Cause::Transition)
        } else if from == to && self.is_of_the_mesh(&left) {
            (released, located, Cause::Mesh)
        } else {
            (released, located, cause)
        };
        self.history = History::starting(self.state.mean_displacement, self.state.field.clone());
        // Nothing else happened on the way.
        self.record.mean_displacement = self.state.mean_displacement;
        observe(Happening::Jump(JumpRecord {
            direction: self.direction,
            mean_displacement: self.state.mean_displacement,
            from,
            to,
            stress_before,
            stress_after: self.state.stress,
            released_energy,
            release_error,
            cause,
            landings,
        }));
        self.accept(observe);
    }
}
