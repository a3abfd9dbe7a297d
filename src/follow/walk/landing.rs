//! The release at the end of a branch, and the landing on what is stable; and a push by hand, a bump
//! or a dimple pressed into the surface at a fixed control and let go, with where it leads.

use super::advance::FIRST;
use super::flat::apart;
use super::{Barrier, Behind, Jumping, Observed, Phase, Progress, Stuck, Walk};
use crate::follow::atlas::{FLAT_KICK, Fall, KICK};
use crate::follow::record::{Cause, JumpRecord, SAME, Share, is_jump};
use crate::numerics::dense::{add, dot, norm};
use crate::numerics::krylov::CgLimits;
use crate::physics::pattern::Pattern;
use crate::physics::system::{Evaluation, State};
use crate::solver::mechanics::{Slides, centred};
use crate::solver::method::{Cost, Equilibrium, History, Stop};
use crate::solver::newton::{NewtonLimits, NewtonState, solve};
use crate::solver::release::{Release, Slice};
use ndarray::Array2;
use rand::Rng;

/// Largest kick of any single point over the root mean square: a mode of a few points is kicked no
/// harder than a wave.
const PEAK: f64 = 4.0;
/// The smallest one tried, where a larger one ended higher than it began.
const LEAST_KICK: f64 = 1e-4;
/// Time steps of a release between two pictures.
const SLICE: usize = 6;
/// Share of a soft mode in what the control pushes below which that is no push: of 60 ends on even
/// and uneven ground folds have 0.01 and more, and broken symmetries, which mesh and tolerance
/// leave inexact, up to 4e-5.
const UNPUSHED: f64 = 1e-3;
/// Stiffness of what the control pushes, over twice that of the softest wave, below which it gives
/// way: at those folds it is 0.02 at most, elsewhere 0.18 and more.
const SOFT: f64 = 0.05;
/// Root mean square of a pattern (ranges) below which an unstable flat state is taken for it.
pub(super) const FAINT: f64 = 1e-7;
/// How often an unstable landing may be kicked on before the walk gives up.
const KICKS: usize = 8;
/// Most energy per area of a push (gamma): beyond it the law's wall alone is felt.
const MOST: f64 = 10.0;
/// How much shallower a push becomes that has more, and how often.
const SHALLOWER: f64 = 0.8;
const TRIALS: usize = 60;
/// Energy (gamma) by which a landing may seem to lie higher than where it began.
const HIGHER: f64 = 1e-6;
/// How much farther on a release is tried again that came back to its branch, as a share of the way
/// on which that ends somewhere.
const FARTHER: f64 = 0.1;

/// What is pressed into the surface: a Gaussian, less its mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Push {
    /// Its middle (length), x and y; the first point of the mesh lies at 0.
    pub at: [f64; 2],
    /// The distance from there at which it is 1/e as deep (length).
    pub width: f64,
    /// How far it presses the surface towards the ground (length); a negative one lifts it.
    pub depth: f64,
}

/// How a branch was left.
pub(super) struct Leaving {
    /// The derivative of the energy with the control where it ended.
    pub(super) conjugate: f64,
    /// Energy released from there to where the surface landed (gamma).
    pub(super) released: f64,
    /// What gave way.
    pub(super) cause: Cause,
    /// False if it may as well have gone over into where it landed.
    pub(super) jumped: bool,
    /// Where kicks lead, if that is contested.
    pub(super) landings: Vec<Share>,
}

impl Walk {
    /// Starts the release at the end of a patterned branch, to the side of its soft mode on which
    /// the energy falls.
    pub(super) fn release(&mut self, barrier: Barrier) -> Progress {
        let cause = self.cause(&barrier.soft_mode);
        let at = self.located(&barrier, cause);
        self.release_because(cause, at, barrier, Vec::new())
    }

    /// Starts the release where the control is `at`, no farther than a barrier; from a flat limit
    /// that leads to several `landings`, to the first of them.
    pub(super) fn release_because(
        &mut self,
        cause: Cause,
        at: f64,
        barrier: Barrier,
        landings: Vec<Fall>,
    ) -> Progress {
        let (latest, soft_mode) = (barrier.at, barrier.soft_mode);
        let (_, energy_before) = self.carried_to(at);
        let from_flat = cause == Cause::FlatLimit;
        let kick = if from_flat { FLAT_KICK } else { KICK };
        let kicked = self.kicked(
            &self.here.state.amplitudes.clone(),
            at,
            &soft_mode,
            kick,
            !from_flat,
        );
        self.jump_on(Box::new(Jumping {
            release: self.release_from(kicked),
            cause,
            kicks: 1,
            soft_mode,
            kick,
            energy_before,
            latest,
            landings,
        }))
    }

    fn release_from(&self, at: Evaluation) -> Release {
        Release::new(at).with_tolerance(self.system().precision().tolerance())
    }

    /// The surface moves.
    fn jump_on(&mut self, jumping: Box<Jumping>) -> Progress {
        self.phase = Phase::Jumping(jumping);
        Progress::Working
    }

    /// What ends the present branch, of which `mode` goes soft. Where the control pushes the
    /// surface along a mode without stiffness the branch turns back; where it does not, by
    /// symmetry, the branch goes on and is unstable.
    fn cause(&mut self, mode: &[f64]) -> Cause {
        if mode.is_empty() {
            return Cause::Fold;
        }
        let push = self.mechanics.push(&self.here.fields);
        if dot(&push, mode).abs() > UNPUSHED * norm(&push) * norm(mode) {
            return Cause::Fold;
        }
        // A pattern that hardly anything holds in its place may slide more easily still than it
        // folds: what the push does tells.
        let Self {
            mechanics, here, ..
        } = self;
        let removed = mechanics.sliding_basis(&here.state.amplitudes, &here.fields);
        let limits = CgLimits::new(0.03, NewtonLimits::default().products);
        let moved = mechanics
            .solve_linear(&here.fields, &push, &removed, limits)
            .x;
        let stiffness = dot(&moved, &push) / dot(&moved, &moved);
        if stiffness < SOFT * mechanics.system.stiffness_unit() {
            Cause::Fold
        } else {
            Cause::SymmetryBreaking
        }
    }

    /// Where the control is `control`, a hair beyond the present state, the energy of the branch
    /// and its derivative with the control: to second order, with the slope from the state before.
    pub(super) fn carried_to(&self, control: f64) -> (f64, f64) {
        let here = &self.here.state;
        let (conjugate, step) = (self.conjugate(here), control - here.control);
        let slope = self.behind.before.map_or(0.0, |before| {
            (conjugate - before.conjugate) / (here.control - before.at)
        });
        let there = conjugate + slope * step;
        (there, here.energy + 0.5 * (conjugate + there) * step)
    }

    /// u0 of the present branch where the control is `control`, close by (length).
    pub(super) fn placed_at(&self, control: f64) -> f64 {
        let conjugate = self.conjugate(&self.here.state);
        self.control().place(control, conjugate)[0]
    }

    /// `z` moved by `kick` (ranges) along `mode`: downhill where the two sides differ, and to a
    /// side drawn from the seed where they do not.
    pub(super) fn kicked(
        &mut self,
        z: &[f64],
        control: f64,
        mode: &[f64],
        kick: f64,
        choose: bool,
    ) -> Evaluation {
        let mut size = kick * self.model.law.range;
        if !mode.is_empty() {
            let peak = self
                .mechanics
                .field(mode)
                .iter()
                .fold(0.0, |most: f64, v| most.max(v.abs()));
            size *= (PEAK / peak).min(1.0);
        }
        let random = if self.rng.random::<bool>() { 1.0 } else { -1.0 };
        let mut side = |sign: f64| {
            let mut moved = z.to_vec();
            if !mode.is_empty() {
                add(&mut moved, sign * size, mode);
            }
            self.mechanics.at(moved, control)
        };
        let one = side(random);
        if !choose {
            return one;
        }
        let other = side(-random);
        let (energy, equal) = (one.state.energy, 1e-7 * self.model.law.surface_energy);
        if other.state.energy < energy - equal || !energy.is_finite() {
            other
        } else {
            one
        }
    }

    pub(super) fn relax(
        &mut self,
        mut jumping: Box<Jumping>,
        observe: &mut dyn FnMut(Observed),
    ) -> Progress {
        let slice = jumping.release.advance(&mut self.mechanics, SLICE);
        let State {
            control,
            mean_displacement: u0,
            ..
        } = jumping.release.at.state;
        match slice {
            Slice::Moving if self.is_apart(u0) => {
                let landed = apart(&mut self.mechanics, control);
                self.land(jumping, landed, observe)
            }
            Slice::Moving => {
                let stress = jumping.release.at.state.stress;
                observe(Observed::Moving { stress });
                self.jump_on(jumping)
            }
            Slice::Cancelled => {
                self.phase = Phase::Jumping(jumping);
                Progress::Cancelled
            }
            Slice::Stuck => Progress::Stuck(Stuck::NoWayDown {
                mean_displacement: u0,
            }),
            Slice::Settled(settled) => self.settle(jumping, *settled, observe),
        }
    }

    /// Checks the stability of where the release came to rest; lands there, or kicks on.
    fn settle(
        &mut self,
        mut jumping: Box<Jumping>,
        settled: NewtonState,
        observe: &mut dyn FnMut(Observed),
    ) -> Progress {
        let State {
            control,
            mean_displacement: u0,
            ..
        } = settled.at.state;
        // Next to a saddle the order of the unknowns decides where a release ends: it is to be where
        // most lead.
        if jumping.kicks == 1
            && let Some(Fall { rest, .. }) = jumping.landings.first()
            && !rest.amplitudes.is_empty()
            && self.pattern_of(&settled.at.fields.gap) != rest.pattern
        {
            let there = self.mechanics.at(rest.amplitudes.clone(), control);
            (jumping.kicks, jumping.release) = (2, self.release_from(there));
            return self.jump_on(jumping);
        }
        let (range, roughness) = (self.model.law.range, settled.at.state.roughness());
        let is_flat = roughness < 1e-4 * range
            || self.is_as_good_as_flat(&settled.at.state, settled.residual);
        let landed = match self.flat {
            Some(flat) if is_flat && (flat.is_stable(u0) || roughness < FAINT * range) => {
                let mut state = flat.state_at(self.system(), u0, control);
                if state.stop == Stop::Unstable {
                    state.soft_mode = self.random_soft_wave();
                }
                state
            }
            _ => match self.measure(settled, jumping.release.steps) {
                Ok(state) => state,
                Err(progress) => {
                    self.phase = Phase::Jumping(jumping);
                    return progress;
                }
            },
        };
        if landed.stop == Stop::Unstable {
            if jumping.kicks >= KICKS {
                if jumping.cause == Cause::FlatLimit && jumping.latest == control {
                    // Where gamma'' jumps a pattern grows in proportion to the way beyond the limit.
                    let beyond = self
                        .located_within()
                        .copysign(control - self.here.state.control);
                    let barrier = Barrier::blind(control, jumping.soft_mode);
                    let at = control + beyond;
                    return self.release_because(jumping.cause, at, barrier, Vec::new());
                }
                return Progress::Stuck(Stuck::OnlyUnstable {
                    mean_displacement: u0,
                });
            }
            jumping.kicks += 1;
            let soft_mode = &landed.soft_mode;
            let kicked = self.kicked(&landed.state.amplitudes, control, soft_mode, KICK, true);
            // Where a saddle and the minima beside it all meet the tolerance, only a tighter one
            // tells them apart.
            let tolerance = (jumping.release.tolerance() * 0.1)
                .max(1e-10)
                .max(self.system().precision().floor());
            jumping.release = Release::new(kicked).with_tolerance(tolerance);
            return self.jump_on(jumping);
        }
        self.land(jumping, landed, observe)
    }

    /// Centres, polishes and measures a pattern that settled after `steps` of a release; `Err` as
    /// [`Walk::assessed`].
    pub(super) fn measure(
        &mut self,
        mut settled: NewtonState,
        steps: usize,
    ) -> Result<Equilibrium, Progress> {
        settled = self.centred(&settled.at).unwrap_or(settled);
        self.forget_modes();
        settled.steps += steps;
        self.assessed(settled)
    }

    /// The pattern `at` moved to where the mesh does not pull at it and its energy is the lowest,
    /// if it slides.
    fn centred(&mut self, at: &Evaluation) -> Option<NewtonState> {
        let (z, control) = (&at.state.amplitudes, at.state.control);
        if self.mechanics.sliding_basis(z, &at.fields).is_empty() {
            return None;
        }
        let rounding = self.system().precision().rounding() * self.model.law.surface_energy;
        let mut lowest: Option<NewtonState> = None;
        let all = [[false, false], [true, false], [false, true], [true, true]];
        for between in if self.mechanics.slides == Slides::Freely {
            &all[..1]
        } else {
            &all
        } {
            let moved = centred(self.system(), z, *between);
            let limits = NewtonLimits::of(self.system());
            let polished = solve(&mut self.mechanics, moved, control, limits);
            let lower = lowest
                .as_ref()
                .is_none_or(|lowest| polished.at.state.energy < lowest.at.state.energy - rounding);
            if polished.end.is_ok() && lower {
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

    /// The equilibrium that was found, with its stability; `Err` if cancelled, or if it leaves the
    /// symmetry of the model.
    pub(super) fn assessed(&mut self, settled: NewtonState) -> Result<Equilibrium, Progress> {
        self.mechanics.refresh(&settled.at.fields);
        let cost = Cost {
            iterations: settled.steps,
            transforms: 0,
        };
        let mut state = Equilibrium::unmeasured(settled.at, settled.residual, Stop::Stable, cost);
        let found = self.stability(&state);
        if self.cancelled() {
            return Err(Progress::Cancelled);
        }
        let (stiffness, mode) = found.map_err(Progress::Stuck)?;
        state.measured(stiffness, mode);
        Ok(state)
    }

    fn land(
        &mut self,
        mut jumping: Box<Jumping>,
        landed: Equilibrium,
        observe: &mut dyn FnMut(Observed),
    ) -> Progress {
        if jumping.cause == Cause::Push {
            self.spent.counts.iterations += landed.cost.iterations;
            self.land_pushed(landed, observe);
            return Progress::Working;
        }
        let law = self.model.law;
        let control = landed.state.control;
        let released = (jumping.energy_before - landed.state.energy) / law.surface_energy;
        let (conjugate, _) = self.carried_to(control);
        self.spent.counts.iterations += landed.cost.iterations;
        if released < -HIGHER && jumping.kick > LEAST_KICK {
            // Where minima lie close together (a law whose stiffness jumps), so large a kick has
            // gone up and over into another one.
            jumping.kick *= 0.1;
            let kicked = self.kicked(
                &self.here.state.amplitudes.clone(),
                control,
                &jumping.soft_mode.clone(),
                jumping.kick,
                true,
            );
            jumping.release = self.release_from(kicked);
            return self.jump_on(jumping);
        }
        if released < -HIGHER {
            return Progress::Stuck(Stuck::NegativeRelease {
                mean_displacement: self.placed_at(control),
                released,
            });
        }
        let after = self.conjugate(&landed.state);
        let open = self.left_open(&self.here) + self.left_open(&landed);
        let jumped = is_jump(self.control(), &law, [conjugate, after], released - open);
        if !jumped && jumping.latest != control {
            // The end lies a hair farther on than was expected.
            let left = self.here.state.control;
            let at = control + FARTHER * (jumping.latest - left);
            let barrier = Barrier::blind(at, jumping.soft_mode);
            return self.release_because(jumping.cause, at, barrier, Vec::new());
        }
        let Jumping {
            cause, landings, ..
        } = *jumping;
        let contested = landings.len() > 1;
        let shares = landings.into_iter().filter(|_| contested);
        self.arrive(
            landed,
            Leaving {
                conjugate,
                released,
                cause,
                jumped,
                landings: shares.map(|fall| fall.share).collect(),
            },
            observe,
        );
        Progress::Working
    }

    /// Stands on the state where a release ended. If nothing jumped it goes on there, unless the flat
    /// state was left or reached: Newton can fail on a branch that goes on, a mode can soften without a
    /// jump, and faint patterns change their names.
    pub(super) fn arrive(
        &mut self,
        landed: Equilibrium,
        Leaving {
            conjugate,
            released,
            cause,
            jumped,
            landings,
        }: Leaving,
        observe: &mut dyn FnMut(Observed),
    ) {
        let left = std::mem::replace(&mut self.here, landed);
        // The flat state is known everywhere.
        let first =
            (!(self.flat.is_some() && self.here.is_uniform())).then_some(FIRST * self.unit());
        (self.behind.before, self.behind.short) = (None, first.filter(|first| *first < self.step));
        let (from, to) = (self.record.pattern, self.pattern());
        let [from, to] = [(&left, from), (&self.here, to)].map(|(state, pattern)| {
            if self.is_as_good_as_flat(&state.state, state.residual) {
                Pattern::Flat
            } else {
                pattern
            }
        });
        if !jumped && (from == to || (from != Pattern::Flat && to != Pattern::Flat)) {
            self.remember();
            return self.accept(observe);
        }
        // The end lies somewhere on the way from the last state: what the release changes on it,
        // and what the energy was carried. That of the flat state is exact.
        let control = self.here.state.control;
        let mut way = (control - left.state.control).abs();
        if !left.is_uniform() {
            way = way.max(self.located_within());
        }
        let changed = (self.conjugate(&self.here.state) - conjugate).abs()
            + 0.5 * (conjugate - self.conjugate(&left.state)).abs();
        let located = way * changed / self.model.law.surface_energy;
        let (released_energy, release_error, cause) = if !jumped {
            (0.0, released.abs(), Cause::Transition)
        } else if from == to && self.is_of_the_mesh(&left) {
            (released, located, Cause::Mesh)
        } else {
            (released, located, cause)
        };
        self.behind.history = History::starting(&self.here.state);
        let before = self.control().place(control, conjugate);
        // Nothing else happened on the way.
        self.record.mean_displacement = self.here.state.mean_displacement;
        observe(Observed::Jump(JumpRecord {
            landings,
            ..self.jumped(cause, before, [from, to], [released_energy, release_error])
        }));
        self.accept(observe);
    }

    /// The state it stands on with a push pressed into it, less deep where the law does not allow
    /// it. The control stays, and with it u0 where that is driven.
    pub fn pressed(&mut self, push: &Push) -> Evaluation {
        let shape = self.shape(push);
        let here = self.here.state.clone();
        let most = MOST * self.model.law.surface_energy;
        let mut depth = -push.depth;
        for _ in 0..TRIALS {
            let mut z = here.amplitudes.clone();
            add(&mut z, depth, &shape);
            let at = self.mechanics.uncounted(|m| m.at(z, here.control));
            // Written so that NaN is not taken for little.
            if at.state.energy - here.energy <= most {
                return at;
            }
            depth *= SHALLOWER;
        }
        let still = here.amplitudes;
        self.mechanics.uncounted(|m| m.at(still, here.control))
    }

    /// Amplitudes of a push of depth 1, upwards.
    fn shape(&mut self, push: &Push) -> Vec<f64> {
        let grid = *self.system().grid();
        let (rows, columns) = self.system().shape();
        let off = |i: usize, k: usize| {
            let x = i as f64 * grid.spacing() - push.at[k];
            // The nearest of its periodic copies.
            x - (x / grid.length).round() * grid.length
        };
        let mut bump = Array2::from_shape_fn((rows, columns), |(j, i)| {
            let y = if rows > 1 { off(j, 1) } else { 0.0 };
            (-(off(i, 0).powi(2) + y * y) / (push.width * push.width)).exp()
        });
        bump -= bump.mean().unwrap_or(0.0);
        self.mechanics.uncounted(|m| m.amplitudes(&bump))
    }

    /// Lets the surface go that was pressed so; it moves in the steps that follow.
    pub fn let_go(&mut self, push: &Push) {
        let pressed = self.pressed(push);
        self.target = self.here.state.control;
        self.phase = Phase::Jumping(Box::new(Jumping {
            release: self.release_from(pressed),
            cause: Cause::Push,
            kicks: 1,
            soft_mode: Vec::new(),
            kick: 0.0,
            energy_before: self.here.state.energy,
            latest: self.here.state.control,
            landings: Vec::new(),
        }));
    }

    /// Stands on the state to which a push led: the same as before, perhaps elsewhere in the cell,
    /// or another one, of lower or of higher energy.
    fn land_pushed(&mut self, landed: Equilibrium, observe: &mut dyn FnMut(Observed)) {
        let law = self.model.law;
        let left = std::mem::replace(&mut self.here, landed);
        self.behind = Behind::starting(&self.here);
        let (from, to) = (self.record.pattern, self.pattern());
        let (before, after) = (&left.state, &self.here.state);
        let released_energy = (before.energy - after.energy) / law.surface_energy;
        let changed = (before.stress - after.stress).abs() / law.traction_max();
        if from != to || released_energy.abs() > HIGHER || changed > SAME {
            let before = [before.mean_displacement, before.stress];
            let released = [released_energy, 0.0];
            observe(Observed::Jump(self.jumped(
                Cause::Push,
                before,
                [from, to],
                released,
            )));
        }
        // Nothing else happened on the way.
        self.record.mean_displacement = self.here.state.mean_displacement;
        self.accept(observe);
    }
}
