//! One increment along a branch of patterns, and the bracketing of where the branch ends.
//!
//! A mesh that traps the edge of a contact lets go of single points every few steps. To bracket each
//! of these jumps as closely as a collective one, and to release it by dynamics, would cost more than
//! the way between them. There a step that Newton's method refuses is gone downhill from where the
//! branch was heading, which always ends somewhere. The energy tells whether something let go on the
//! way; then the step is halved until it is short enough to say where.

use super::landing::Leaving;
use super::{Barrier, Before, Bracket, Observed, Phase, Progress, Stuck, Walk};
use crate::follow::record::{Cause, Direction, LOCATED};
use crate::physics::control::Control;
use crate::physics::mesh;
use crate::physics::pattern::{contact_set, moves_by_a_spacing};
use crate::physics::theory::flat_limits;
use crate::solver::method::{Equilibrium, History, Lost, Stop, audit, predicted};
use crate::solver::newton::{NewtonLimits, descend};

/// [`LOCATED`] over the least residual: closer to its end the softest mode is undecided, and a dimple
/// that breaks up may read as a ridge.
const DECIDED: f64 = 100.0;

/// Longest step, in ranges, from a patterned state on flat and on uneven ground. Patterns live for
/// a range and more; on uneven ground a branch may be unstable for a tenth of a range alone, and a
/// step across that goes unseen.
const LONGEST_FLAT: f64 = 0.5;
const LONGEST_UNEVEN: f64 = 0.1;
/// The first step, in ranges, on a branch just landed on: there is no prediction yet from which
/// another branch would stray.
pub(super) const FIRST: f64 = 0.05;
/// Step, in ranges, below which nobody asks whether a falling eigenvalue was negative on the way.
const PASSED: f64 = 1e-3;

/// What three states may miss of the energy, over what two miss, and over the way times the largest
/// traction: a quarter where the stress falls off like a root towards a fold.
const BENT: f64 = 0.25;
const MISSED: f64 = 1e-4;

/// Width, in ranges, of a bracket in which a state of undecided stability is taken for its end.
const AT_END: f64 = 1e-3;

/// Energy, in gamma, that a thermostat may add between two states. A method that gains more ran
/// into the wall of the law.
const GAIN_MAX: f64 = 1e-2;

/// Newton steps of a descent, and the longest of them (root mean square, ranges): a few points
/// settle so. What needs more is a collective jump.
const DESCENT: usize = 40;
const LONGEST: f64 = 0.02;
/// Energy, in gamma, above which a step released some. On 512 x 512 points at mu_rho = 1 what is
/// below adds up to 5e-4 of the loss of JKR, a thousandth of the loop's own.
const RELEASED: f64 = 1e-7;

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
        let law = self.system().law();
        let Some((_, upper)) = flat_limits(law, self.model.equivalent_length) else {
            return f64::INFINITY;
        };
        let gap = &self.here.fields.gap;
        let nearest = gap.fold(f64::INFINITY, |least, g| least.min(*g));
        let free = if self.control() == Control::Load {
            0.0
        } else {
            (nearest - upper - law.range).max(0.0)
        };
        let longest = if self.system().is_flat() {
            LONGEST_FLAT
        } else {
            LONGEST_UNEVEN
        };
        free + self.unit() * longest
    }

    /// Where the branch is expected to end, seen from its last two states: the eigenvalue vanishes
    /// as a square root at a fold, and linearly where a symmetry breaks.
    fn expected_end(&self, cause: Cause) -> Option<f64> {
        let Before { at, stiffness, .. } = self.behind.before?;
        let (here, now) = (self.here.state.control, self.here.stiffness_min?.value);
        let power = if cause == Cause::Fold { 2 } else { 1 };
        let (left, fallen) = (now.powi(power), stiffness.powi(power) - now.powi(power));
        (now < stiffness).then(|| here + (here - at) * left / fallen)
    }

    /// Where on the way from here to a barrier the eigenvalue is expected to vanish, 0 to 1, if
    /// that ends the branch for this `cause`.
    fn expected_share(&self, barrier: &Barrier, cause: Cause) -> Option<f64> {
        let here = self.here.state.control;
        let share = match (self.here.stiffness_min, barrier.stiffness) {
            (Some(a), Some(b)) => a.value / (a.value - b),
            _ => (self.expected_end(cause)? - here) / (barrier.at - here),
        };
        (0.0..1.0).contains(&share).then_some(share)
    }

    /// Width of a bracket that is narrow enough (in the control's unit).
    pub(super) fn located_within(&self) -> f64 {
        LOCATED.max(DECIDED * self.system().precision().floor()) * self.unit()
    }

    /// The end of the branch in the bracket up to `barrier`, which is as narrow as it gets.
    pub(super) fn located(&self, barrier: &Barrier, cause: Cause) -> f64 {
        let here = self.here.state.control;
        let share = self.expected_share(barrier, cause).unwrap_or(1.0);
        here + share * (barrier.at - here)
    }

    /// The next trial between here and a barrier: close to where the eigenvalue is expected to
    /// vanish, by the secant; the middle where there is no expectation, or it did not help last
    /// time.
    fn towards(&self, Bracket { barrier, halve, .. }: &Bracket) -> f64 {
        let here = self.here.state.control;
        let width = barrier.at - here;
        let Some(share) = self.expected_share(barrier, Cause::Fold) else {
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
                return self.release(barrier.clone());
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
        let mut barrier = Barrier::blind(next, Vec::new());
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
                let unseen = self.passed_an_end(&state) || self.lost_energy(&state);
                if locates && self.barrier().is_none() && unseen {
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
                    // Where a pattern is gone it may have come to its end on the way; where it only
                    // faded, a bracket says so.
                    let faded = locates
                        && reached.is_none()
                        && self.is_as_good_as_flat(&state.state, state.residual)
                        && !self.is_as_good_as_flat(&self.here.state, self.here.residual);
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
            return self.release(barrier);
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

    /// True if on the way to `next` over uneven ground more energy is missing than along a branch
    /// that bends as its last three states tell: a jump may hide in a step of two states.
    fn lost_energy(&self, next: &Equilibrium) -> bool {
        let (here, there) = (&self.here.state, &next.state);
        let step = there.control - here.control;
        let Some(before) = self.behind.before.filter(|_| !self.system().is_flat()) else {
            return false;
        };
        if step.abs() <= PASSED * self.unit() {
            return false;
        }
        let [a, b, c] = [
            before.conjugate,
            self.conjugate(here),
            self.conjugate(there),
        ];
        let bend =
            ((c - b) / step - (b - a) / (here.control - before.at)) / (there.control - before.at);
        let curved = bend * step.powi(3) / 6.0;
        let missing = there.energy - here.energy - 0.5 * (b + c) * step + curved;
        let scale = self.control().conjugate_unit(&self.model.law);
        missing.abs() > BENT * curved.abs() + MISSED * scale * step.abs()
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
            .expected_end(Cause::Fold)
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
    fn take(&mut self, state: Equilibrium, observe: &mut dyn FnMut(Observed)) -> Progress {
        let (from, energy, conjugate, stress) = (
            self.record.pattern,
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
        let smooth = audit(self.system(), &self.here.state, &state.state);
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
        let to = self.pattern();
        if !self.method.locates() && to != from {
            let changed = self.conjugate(&self.here.state) - conjugate;
            let error = (step * changed).abs() / self.model.law.surface_energy;
            let before = [self.here.state.mean_displacement, stress];
            let jump = self.jumped(Cause::PatternChange, before, [from, to], [released, error]);
            observe(Observed::Jump(jump));
        }
        self.accept(observe);
        Progress::Working
    }

    /// The step to `next` downhill. `None` if it is not for this walk, or is more than the jump of
    /// a few points: then the end of the branch is to be bracketed.
    fn fall(&mut self, next: f64, observe: &mut dyn FnMut(Observed)) -> Option<Progress> {
        let within = self.options.trapped_within?;
        let (law, step) = (self.model.law, next - self.here.state.control);
        let limits = NewtonLimits {
            steps: DESCENT,
            ..NewtonLimits::of(self.system())
        };
        let heading = predicted(&mut self.mechanics, &self.behind.history, &self.here, next);
        let settled = descend(
            &mut self.mechanics,
            heading,
            next,
            LONGEST * law.range,
            limits,
        );
        if let Err(lost) = settled.end {
            return (lost == Lost::Cancelled).then_some(Progress::Cancelled);
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
                jumped: true,
                landings: Vec::new(),
            },
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
                self.system().unfolded(&of.fields.gap).view(),
                law.contact_gap(),
            )
        };
        moves_by_a_spacing(&contact(left), &contact(&self.here))
    }
}
