//! One increment along a branch, and the bracketing of where the branch ends.

use super::{Barrier, Before, Bracket, Observed, Phase, Progress, Stuck, Walk};
use crate::follow::atlas::{Explorer, Rest};
use crate::follow::contest::{mixture, shares};
use crate::follow::flat_branch::FlatBranch;
use crate::follow::record::{Cause, Direction, JumpRecord, LOCATED};
use crate::numerics::dense::norm;
use crate::physics::control::Control;
use crate::physics::indenter::Indenter;
use crate::physics::pattern::Pattern;
use crate::physics::system::System;
use crate::physics::theory::flat_limits;
use crate::scene::no_quarter;
use crate::solver::Lost;
use crate::solver::Stop;
use crate::solver::branch::History;
use crate::solver::equilibrium::Equilibrium;
use crate::solver::method::audit;
use crate::solver::stability::random_smooth;
use ndarray::Axis;

/// The same over the least residual: closer to its end the softest mode is undecided, and a dimple
/// that breaks up may read as a ridge.
const DECIDED: f64 = 100.0;

/// Longest step, in ranges, from a patterned state on flat and on uneven ground. Patterns live for
/// a range and more; on uneven ground a branch may be unstable for a tenth of a range alone, and a
/// step across that goes unseen.
const LONGEST_FLAT: f64 = 0.5;
const LONGEST_UNEVEN: f64 = 0.1;
/// How far beyond the end of the flat branch under a spring or a load, in units of the control, the
/// release begins: as far as the end is uncertain.
const BEYOND: f64 = 1e-9;
/// Towards the end of the flat branch under a spring a small step of the stage is a long one of u0,
/// and the work done is the integral over the states: where u0 goes so many times faster, it goes
/// no farther than so many ranges.
const SWIFT: f64 = 1.5;
const FLAT_STEP: f64 = 0.02;
/// The first step, in ranges, on a branch just landed on: there is no prediction yet from which
/// another branch would stray.
pub(super) const FIRST: f64 = 0.05;
/// Step, in ranges, below which nobody asks whether a falling eigenvalue was negative on the way.
const PASSED: f64 = 1e-3;

/// Width, in ranges, of a bracket in which a state of undecided stability is taken for its end.
const AT_END: f64 = 1e-3;

/// Energy, in gamma, that a thermostat may add between two states. A method that gains more ran
/// into the wall of the law.
const GAIN_MAX: f64 = 1e-2;

impl Walk {
    /// The next value of the control on the way: the points start - k x step, the target, or half
    /// the way to a known barrier.
    pub(super) fn next(&self) -> f64 {
        let here = self.here.state.control;
        if let Phase::Bracketing(bracket) = &self.phase {
            return self.towards(bracket);
        }
        let k = (self.start - here) / self.step;
        let short = self
            .behind
            .short
            .unwrap_or(f64::INFINITY)
            .min(self.longest());
        match self.direction {
            Direction::Approach => (self.start - ((k + 1e-6).floor() + 1.0) * self.step)
                .max(self.target)
                .max(here - short),
            Direction::Retraction => (self.start - ((k - 1e-6).ceil() - 1.0) * self.step)
                .min(self.target)
                .min(here + short),
        }
    }

    /// How far a method that locates may go without missing a jump (in the control's unit). Where
    /// gamma'' falls nowhere below that of the upper limit of the flat state, nothing can jump, and
    /// the gap closes no faster than the control goes.
    fn longest(&self) -> f64 {
        let uniform = self.flat.is_some() && self.here.is_uniform();
        if uniform || !self.method.locates() {
            return f64::INFINITY;
        }
        let law = self.mechanics.system.law();
        let Some((_, upper)) = flat_limits(law, self.model.equivalent_length) else {
            return f64::INFINITY;
        };
        let free = self
            .here
            .fields
            .gap
            .fold(f64::INFINITY, |least, g| least.min(*g))
            - upper
            - law.range;
        let free = if self.control() == Control::Load {
            0.0
        } else {
            free.max(0.0)
        };
        free + self.unit()
            * if self.mechanics.system.is_flat() {
                LONGEST_FLAT
            } else {
                LONGEST_UNEVEN
            }
    }

    /// Where the branch is expected to end, seen from its last two states: at a fold the eigenvalue
    /// vanishes as a square root.
    fn expected_fold(&self) -> Option<f64> {
        let (
            Before {
                at,
                stiffness: before,
                ..
            },
            here,
        ) = (self.behind.before?, self.here.state.control);
        let now = self.here.stiffness_min?.value;
        (now < before).then(|| here + (here - at) * now * now / (before * before - now * now))
    }

    /// Where on the way from here to a barrier the eigenvalue is expected to vanish, 0 to 1.
    fn expected_share(&self, barrier: &Barrier) -> Option<f64> {
        let here = self.here.state.control;
        let share = match (self.here.stiffness_min, barrier.stiffness) {
            (Some(a), Some(b)) => a.value / (a.value - b),
            _ => (self.expected_fold()? - here) / (barrier.at - here),
        };
        (0.0..1.0).contains(&share).then_some(share)
    }

    /// Width of a bracket that is narrow enough (in the control's unit).
    pub(super) fn located_within(&self) -> f64 {
        LOCATED.max(DECIDED * self.mechanics.system.precision().floor()) * self.unit()
    }

    /// The end of the branch in the bracket up to `barrier`, which is as narrow as it gets.
    fn located(&self, barrier: Barrier) -> Barrier {
        let here = self.here.state.control;
        let share = self.expected_share(&barrier).unwrap_or(1.0);
        Barrier {
            at: here + share * (barrier.at - here),
            ..barrier
        }
    }

    /// The next trial between here and a barrier: close to where the eigenvalue is expected to
    /// vanish, by the secant; the middle where there is no expectation, or it did not help last
    /// time.
    fn towards(&self, Bracket { barrier, halve, .. }: &Bracket) -> f64 {
        let here = self.here.state.control;
        let width = barrier.at - here;
        let Some(share) = self.expected_share(barrier) else {
            return here + 0.5 * width;
        };
        let fine = self.located_within() / width.abs();
        // A hair before the expected zero first, a hair behind it next: two solves close the
        // bracket.
        let trial = if share > 0.5 * fine {
            share - 0.4 * fine
        } else {
            0.9 * fine
        };
        if *halve {
            here + 0.5 * width
        } else {
            here + width * trial.clamp(0.02, 0.98)
        }
    }

    pub(super) fn step_flat(
        &mut self,
        flat: FlatBranch,
        observe: &mut dyn FnMut(Observed),
    ) -> Progress {
        let next = self.next();
        let gap = self.here.state.mean_displacement;
        let (there, unstable) = match flat.at_control(gap, next) {
            Ok(there) => (there, None),
            Err((stable, unstable)) => (stable, Some(unstable)),
        };
        let reached = self.swift_step(gap, there, next);
        let Some(unstable) = unstable.filter(|_| reached == there) else {
            self.here = flat.state(&self.mechanics.system, reached);
            if reached == there {
                // To the last bit, so that it is known to be there.
                self.here.state.control = next;
            }
            self.accept(observe);
            return Progress::Working;
        };
        if there != gap {
            self.here = flat.state(&self.mechanics.system, there);
            self.accept(observe);
        }
        let at = self.mechanics.system.uniform(unstable).state.control;
        if flat.gives_way_as_a_block() {
            let mut block = vec![0.0; self.mechanics.system.dimension()];
            block[0] = 1.0;
            // The control is largest, or least, at the end: beyond it there is no such state.
            let beyond = BEYOND * self.unit();
            let barrier = Barrier {
                at: match self.direction {
                    Direction::Approach => at - beyond,
                    Direction::Retraction => at + beyond,
                },
                stiffness: None,
                soft_mode: block,
            };
            return self.release_because(Cause::Fold, barrier, Vec::new());
        }
        let landings = self.landings_from_flat(unstable);
        if self.cancelled() {
            return Progress::Cancelled;
        }
        let shares = shares(&landings);
        let soft = self.soft_wave_to(&landings, shares.first().map(|most| most.pattern));
        let barrier = Barrier {
            at,
            stiffness: None,
            soft_mode: soft,
        };
        let contested = if shares.len() > 1 { shares } else { Vec::new() };
        self.release_because(Cause::FlatLimit, barrier, contested)
    }

    /// How far the flat state goes at once on the way from a `gap` to another while the control
    /// goes to `next`.
    fn swift_step(&self, gap: f64, there: f64, next: f64) -> f64 {
        let (way, longest) = (there - gap, FLAT_STEP * self.model.law.range);
        let asked = (next - self.here.state.control).abs();
        let is_swift = match self.control() {
            Control::Displacement => false,
            Control::Spring { .. } => way.abs() > SWIFT * asked,
            Control::Load => true,
        };
        if is_swift && way.abs() > longest {
            gap + longest.copysign(way)
        } else {
            there
        }
    }

    /// Where each mixture of the soft waves leads from the flat state at `u0`, looked at on the
    /// even quarter; empty where there is but one wave, or no such cell, or where they are not the
    /// first waves along x and y.
    fn landings_from_flat(&mut self, u0: f64) -> Vec<Pattern> {
        let grid = *self.mechanics.system.grid();
        let first = self.model.body.is_softest_at_its_longest(&grid);
        if grid.is_line() || no_quarter(grid.nx).is_some() || !first {
            return Vec::new();
        }
        let law = *self.mechanics.system.law();
        let mut explorer = Explorer::new(
            System::even(grid, law, &Indenter::Flat)
                .with_body(self.model.body)
                .with_control(self.control()),
        );
        explorer.mechanics.cancel = self.mechanics.cancel.clone();
        let landings = explorer.off_flat(u0).iter().map(Rest::pattern).collect();
        self.spent.looked += explorer.mechanics.transforms();
        landings
    }

    /// A random mixture of the first waves that leads to `pattern`.
    fn soft_wave_to(&mut self, landings: &[Pattern], pattern: Option<Pattern>) -> Vec<f64> {
        loop {
            let wave = self.random_soft_wave();
            let field = self.mechanics.field(&wave);
            let along = |axis: usize| {
                let profile = field.mean_axis(Axis(axis)).expect("a mesh has points");
                profile.iter().map(|v| v * v).sum::<f64>().sqrt()
            };
            // As if drawn from all that lead there.
            if landings.get(mixture(along(0), along(1))).copied() == pattern {
                return wave;
            }
        }
    }

    /// All waves of one length go soft together, the first of a half-space's cell; the seed mixes
    /// them.
    pub(super) fn random_soft_wave(&mut self) -> Vec<f64> {
        let softest = self.mechanics.system.stiffness_unit();
        let mut z = random_smooth(&self.mechanics.system, &mut self.rng);
        for (z, e) in z.iter_mut().zip(self.mechanics.system.elastic()) {
            if 2.0 * e > 1.1 * softest {
                *z = 0.0;
            }
        }
        let length = norm(&z);
        z.iter_mut().for_each(|z| *z /= length);
        z
    }

    pub(super) fn step_patterned(&mut self, observe: &mut dyn FnMut(Observed)) -> Progress {
        let located = self.located_within();
        let here = self.here.state.control;
        let reached = match std::mem::replace(&mut self.phase, Phase::Following) {
            Phase::Bracketing(bracket) if (bracket.barrier.at - here).abs() <= located => {
                Some(bracket.barrier)
            }
            phase => {
                self.phase = phase;
                None
            }
        };
        let next = match &reached {
            // An unstable equilibrium was seen there: nothing to confirm.
            Some(barrier) if barrier.stiffness.is_some() => {
                return self.release(self.located(barrier.clone()));
            }
            // Newton failed there from afar. From this close, and from the state alone, its failure
            // means a fold.
            Some(barrier) => {
                self.behind.history = History::starting(&self.here.state);
                barrier.at
            }
            None => self.next(),
        };
        let locates = self.method.locates();
        let mut barrier = Barrier {
            at: next,
            stiffness: None,
            soft_mode: Vec::new(),
        };
        match self
            .method
            .follow(&mut self.mechanics, &self.behind.history, &self.here, next)
        {
            Ok(mut state) => {
                self.spent.counts.iterations += state.cost.iterations;
                let found = self.stability(&state);
                if self.cancelled() {
                    return Progress::Cancelled;
                }
                let (stiffness, mode) = match found {
                    Ok(found) => found,
                    Err(stuck) => return Progress::Stuck(stuck),
                };
                state.measured(stiffness, mode);
                if locates && self.barrier().is_none() && self.passed_an_end(&state) {
                    self.behind.short = Some(0.5 * (next - here).abs());
                    return Progress::Working;
                }
                // Next to an end that is known no budget tells the sign of what vanishes there.
                let at_end = self.barrier().is_some_and(|known| {
                    stiffness.value.is_nan()
                        && known.stiffness.is_some()
                        && (known.at - here).abs() < AT_END * self.unit()
                });
                if at_end {
                    (barrier.stiffness, barrier.soft_mode) = (Some(0.0), state.soft_mode);
                } else if state.stop != Stop::Unstable || !locates {
                    let faded = locates && reached.is_none() && self.faded(&state);
                    if !faded {
                        return self.take(state, observe);
                    }
                } else {
                    (barrier.stiffness, barrier.soft_mode) =
                        (Some(stiffness.value), state.soft_mode);
                }
            }
            Err(Lost::Cancelled) => return Progress::Cancelled,
            Err(Lost::Diverged(why)) => {
                return Progress::Stuck(Stuck::Diverged {
                    mean_displacement: self.placed_at(next),
                    method: self.method.name(),
                    why,
                });
            }
            Err(Lost::Unstable | Lost::Gone) => {}
        }
        let bracketed = reached.is_some() || self.barrier().is_some();
        if let Some(progress) = (!bracketed).then(|| self.fall(next, observe)).flatten() {
            return progress;
        }
        if reached.is_some() {
            if barrier.stiffness.is_none() {
                barrier.soft_mode = self.here.soft_mode.clone();
            }
            return self.release(self.located(barrier));
        }
        self.bracket(barrier);
        Progress::Working
    }

    /// True if `next` lies beyond where the eigenvalue, falling as it did, would have vanished: the
    /// branch may have been unstable on the way.
    fn passed_an_end(&self, next: &Equilibrium) -> bool {
        let (Some(before), Some(now)) = (self.behind.before, self.here.stiffness_min) else {
            return false;
        };
        let (here, there) = (self.here.state.control, next.state.control);
        let expected =
            now.value + (now.value - before.stiffness) / (here - before.at) * (there - here);
        expected < 0.0 && next.stop == Stop::Stable && (there - here).abs() > PASSED * self.unit()
    }

    /// True if a pattern is gone in `next`: it may have come to its end on the way. Where it only
    /// faded, a bracket says so.
    fn faded(&self, next: &Equilibrium) -> bool {
        self.flat.is_some_and(|flat| {
            self.is_as_good_as_flat(flat, next) && !self.is_as_good_as_flat(flat, &self.here)
        })
    }

    /// After a step that went well: a barrier behind which nothing is expected was only too long a
    /// step.
    fn reconsider(&mut self, step: f64) {
        let short = &mut self.behind.short;
        *short = short
            .map(|short| 1.5 * short.max(step.abs()))
            .filter(|short| *short < self.step);
        let Some(barrier) = self.barrier().cloned() else {
            return;
        };
        let left = barrier.at - self.here.state.control;
        let expected = self
            .expected_fold()
            .is_some_and(|fold| (fold - self.here.state.control) / left < 1.5);
        if barrier.stiffness.is_none() && !expected && left.abs() > self.located_within() {
            self.phase = Phase::Following;
            self.behind.short = Some(step.abs());
        } else {
            self.bracket(barrier);
        }
    }

    /// What the end of the branch is known to lie before, if anything.
    fn barrier(&self) -> Option<&Barrier> {
        match &self.phase {
            Phase::Bracketing(bracket) => Some(&bracket.barrier),
            _ => None,
        }
    }

    /// Brackets the end of the branch between the present state and `barrier`.
    fn bracket(&mut self, barrier: Barrier) {
        let width = (barrier.at - self.here.state.control).abs();
        let halve = match &self.phase {
            Phase::Bracketing(last) => width > 0.5 * last.width && !last.halve,
            _ => false,
        };
        self.phase = Phase::Bracketing(Bracket {
            barrier,
            width,
            halve,
        });
    }

    /// Takes the present state into the history of its branch.
    pub(super) fn remember(&mut self) {
        self.behind.history.push(&self.here.state);
    }

    /// Stands on a new state of the same branch; a method that locates nothing may have jumped on
    /// the way.
    pub(super) fn take(
        &mut self,
        state: Equilibrium,
        observe: &mut dyn FnMut(Observed),
    ) -> Progress {
        let (before, energy, conjugate, stress) = (
            self.record.clone(),
            self.here.state.energy,
            self.conjugate(&self.here.state),
            self.here.state.stress,
        );
        let step = state.state.control - self.here.state.control;
        let work = 0.5 * (conjugate + self.conjugate(&state.state)) * step;
        let released = (energy + work - state.state.energy) / self.model.law.surface_energy;
        if !self.method.locates() && !(released > -GAIN_MAX) {
            let (mean_displacement, method) = (state.state.mean_displacement, self.method.name());
            return Progress::Stuck(Stuck::EnergyGained {
                mean_displacement,
                method,
                gained: -released,
            });
        }
        // An extrapolation over a jump that nobody noticed would be of neither branch.
        let smooth = audit(&self.mechanics.system, &self.here.state, &state.state);
        let (at, stiffness_min) = (self.here.state.control, self.here.stiffness_min);
        self.behind.before = stiffness_min.filter(|_| smooth).map(|s| Before {
            at,
            stiffness: s.value,
            conjugate,
        });
        self.here = state;
        self.reconsider(step);
        if smooth {
            self.remember();
        } else {
            self.behind.history = History::starting(&self.here.state);
        }
        if self.method.locates() {
            self.mechanics.refresh(&self.here.fields);
        }
        let pattern = self.pattern();
        if !self.method.locates() && pattern != before.pattern {
            observe(Observed::Jump(JumpRecord {
                direction: self.direction,
                control: self.here.state.control,
                mean_displacement: self.here.state.mean_displacement,
                mean_displacement_after: self.here.state.mean_displacement,
                from: before.pattern,
                to: pattern,
                stress_before: stress,
                stress_after: self.here.state.stress,
                released_energy: released,
                release_error: (step * (self.conjugate(&self.here.state) - conjugate)).abs()
                    / self.model.law.surface_energy,
                cause: Cause::PatternChange,
                landings: Vec::new(),
            }));
        }
        self.accept(observe);
        Progress::Working
    }
}
