//! The flat state on flat ground, which is known everywhere: its increments, the way it gives way,
//! and patterns that come out of it or go into it without a jump.
//!
//! Under a load also the body apart from the ground, on a stop of the machine. A load that pulls at a
//! free body has no equilibrium: the body would fly off, and one that pushes would bring it back from
//! any distance. The machine holds it where the ground is not felt any more; how far that is adds to
//! the energy that a pull-off releases, load times way.

use super::{Barrier, Observed, Progress, Walk};
use crate::follow::atlas::{Explorer, Fall, angle};
use crate::follow::flat_branch::FlatBranch;
use crate::follow::record::{Cause, Direction, JumpRecord};
use crate::numerics::dense::{norm, scale};
use crate::physics::control::Control;
use crate::physics::indenter::Indenter;
use crate::physics::pattern::Pattern;
use crate::physics::system::{State, System, carried};
use crate::physics::theory::flat_limits;
use crate::scene::{Model, no_quarter};
use crate::solver::mechanics::Mechanics;
use crate::solver::method::{Cost, Equilibrium, Stiffness, Stop};
use crate::solver::stability::random_smooth;
use ndarray::{Array2, Axis};
use std::f64::consts::PI;

/// How far beyond the end of the flat branch under a spring or a load, in units of the control, the
/// release begins: as far as the end is uncertain.
const BEYOND: f64 = 1e-9;
/// Towards the end of the flat branch under a spring a small step of the stage is a long one of u0,
/// and the work done is the integral over the states: where u0 goes so many times faster, it goes
/// no farther than so many ranges.
const SWIFT: f64 = 1.5;
const FLAT_STEP: f64 = 0.02;
/// Distance (ranges) of the end of a block from which on it does so: a soft spring may begin millions of
/// ranges farther off.
const BLOCK_END: f64 = 4.0;

/// The flat body on the stop under the load `control`. Two transforms.
pub(in crate::follow) fn apart(mechanics: &mut Mechanics, control: f64) -> Equilibrium {
    let system = &mechanics.system;
    let (law, length) = (*system.law(), system.equivalent_length());
    let mut z = vec![0.0; system.dimension()];
    z[0] = Control::stop(&law, length);
    let mut at = mechanics.at(z, control);
    // What is left of the load the stop bears.
    at.gradient[0] = 0.0;
    let residual = mechanics.residual(&at);
    // The stop holds the mean; the softest wave is softened by no more than this.
    let softest = at.fields.stiffness.fold(0.0, |least: f64, s| least.min(*s));
    let mut state = Equilibrium::unmeasured(at, residual, Stop::Stable, Cost::default());
    let stiffness = Stiffness {
        value: PI / length,
        error: -softest,
    };
    state.measured(stiffness, Vec::new());
    state
}

impl Walk {
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
        let [held, _] = self
            .control()
            .balanced(there, self.model.law.at(there).traction);
        let driven = (held - self.here.state.control).abs();
        // At the end of a block the control turns back, however far it has come.
        let near = (BLOCK_END * self.model.law.range).copysign(there - gap);
        let reached = if unstable.is_none() || !flat.gives_way_as_a_block() {
            self.swift_step(gap, there, driven)
        } else if (there - gap).abs() > near.abs() {
            there - near
        } else {
            self.swift_step(gap, there, 0.0)
        };
        let Some(unstable) = unstable.filter(|_| reached == there) else {
            self.here = flat.state(self.system(), reached);
            if reached == there {
                // To the last bit, so that it is known to be there.
                self.here.state.control = next;
            }
            self.accept(observe);
            return Progress::Working;
        };
        if there != gap {
            self.here = flat.state(self.system(), there);
            self.accept(observe);
        }
        let at = self.system().uniform(unstable).state.control;
        if flat.gives_way_as_a_block() {
            // The control is largest, or least, at the end: beyond it there is no such state.
            let beyond = BEYOND * self.unit();
            return self.release_block(match self.direction {
                Direction::Approach => at - beyond,
                Direction::Retraction => at + beyond,
            });
        }
        let landings = self.landings_from_flat(unstable);
        if self.cancelled() {
            return Progress::Cancelled;
        }
        let soft = self.soft_wave_to(landings.first());
        self.release_because(Cause::FlatLimit, at, Barrier::blind(at, soft), landings)
    }

    /// Lets the body go as a block where the control is `at`.
    fn release_block(&mut self, at: f64) -> Progress {
        let mut block = vec![0.0; self.system().dimension()];
        block[0] = 1.0;
        self.release_because(Cause::Fold, at, Barrier::blind(at, block), Vec::new())
    }

    /// How far the flat state goes at once on the way from a `gap` to another while the control
    /// goes as far as `driven`.
    fn swift_step(&self, gap: f64, there: f64, driven: f64) -> f64 {
        let (way, longest) = (there - gap, FLAT_STEP * self.model.law.range);
        let is_swift = match self.control() {
            Control::Displacement => false,
            Control::Spring { .. } => way.abs() > SWIFT * driven,
            Control::Load => true,
        };
        if is_swift && way.abs() > longest {
            gap + longest.copysign(way)
        } else {
            there
        }
    }

    /// Where mixtures of the soft waves lead from the flat state at `u0`, looked at on the even
    /// quarter and laid out on the walk's cell; empty where there is but one wave, or no such cell,
    /// or where they are not the first waves along x and y.
    fn landings_from_flat(&mut self, u0: f64) -> Vec<Fall> {
        let grid = *self.system().grid();
        let first = self.model.body.is_softest_at_its_longest(&grid);
        if grid.is_line() || no_quarter(grid.nx).is_some() || !first {
            return Vec::new();
        }
        let law = *self.system().law();
        let mut explorer = Explorer::new(
            System::even(grid, law, &Indenter::Flat)
                .with_body(self.model.body)
                .with_control(self.control()),
        );
        explorer.mechanics.cancel = self.mechanics.cancel.clone();
        let mut landings = explorer.off_flat(u0);
        for Fall { rest, .. } in &mut landings {
            if !rest.amplitudes.is_empty() {
                rest.amplitudes = carried(&rest.amplitudes, explorer.system(), self.system());
                [_, rest.amplitudes[0]] = self.control().balanced(rest.mean_displacement, 0.0);
            }
        }
        self.spent.looked += explorer.mechanics.transforms();
        landings
    }

    /// The mixture of a `fall`, with random phases; any where none was looked at.
    fn soft_wave_to(&mut self, fall: Option<&Fall>) -> Vec<f64> {
        let wave = self.random_soft_wave();
        let Some(Fall { mixture, .. }) = fall else {
            return wave;
        };
        let field = self.mechanics.field(&wave);
        let [x, y] = [0, 1].map(|axis| field.mean_axis(Axis(axis)).expect("a mesh has points"));
        let [along_x, along_y] = [&x, &y].map(|wave| wave.dot(wave).sqrt());
        let (less, more) = angle(*mixture).sin_cos();
        let shares = if along_x < along_y {
            [less, more]
        } else {
            [more, less]
        };
        let (x, y) = (x * (shares[0] / along_x), y * (shares[1] / along_y));
        let mixed = Array2::from_shape_fn(field.dim(), |(j, i)| x[i] + y[j]);
        let mut wave = self.mechanics.amplitudes(&mixed);
        let length = norm(&wave);
        scale(&mut wave, 1.0 / length);
        wave
    }

    /// All waves of one length go soft together, the first of a half-space's cell; the seed mixes
    /// them.
    pub(super) fn random_soft_wave(&mut self) -> Vec<f64> {
        let softest = self.system().stiffness_unit();
        let mut z = random_smooth(&self.mechanics.system, &mut self.rng);
        for (z, e) in z.iter_mut().zip(self.system().elastic()) {
            if 2.0 * e > 1.1 * softest {
                *z = 0.0;
            }
        }
        let length = norm(&z);
        z.iter_mut().for_each(|z| *z /= length);
        z
    }

    /// True if a body at `u0` is on the stop, or has flown beyond it.
    pub(super) fn is_apart(&self, u0: f64) -> bool {
        let Model {
            law,
            equivalent_length,
            ..
        } = &self.model;
        self.control().is_apart(law, *equivalent_length, u0)
    }

    /// One increment on the stop: it holds as long as the load does not push.
    pub(super) fn step_apart(&mut self, observe: &mut dyn FnMut(Observed)) -> Progress {
        let (next, touch) = (self.next(), self.here.state.stress);
        if next > touch || next > self.here.state.control {
            self.here = apart(&mut self.mechanics, next);
            self.accept(observe);
            return Progress::Working;
        }
        if self.here.state.control > touch {
            self.here = apart(&mut self.mechanics, touch);
            self.accept(observe);
        }
        self.release_block(touch - self.located_within())
    }

    /// True where the flat state is stable and `state` no more than a trace of a pattern on it, which
    /// its `residual` lets be.
    pub(super) fn is_as_good_as_flat(&self, state: &State, residual: f64) -> bool {
        let (u0, energy) = (state.mean_displacement, state.body_energy(self.control()));
        self.flat.is_some_and(|flat| flat.is_stable(u0)) && self.is_trace([u0, energy, residual])
    }

    /// True if a state at gap `u0` with this `energy` of body and cohesion is no more than a trace of
    /// a pattern on the flat one: as much as its `residual` leaves open along the softest wave.
    fn is_trace(&self, [u0, energy, residual]: [f64; 3]) -> bool {
        let (Some(flat), law) = (self.flat, &self.model.law) else {
            return false;
        };
        let open = self.energy_open(residual, flat.stiffness(u0));
        let rounding = self.system().precision().rounding() * law.surface_energy.max(energy.abs());
        (energy - law.at(u0).energy).abs() <= open + rounding
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
        let passed = |limit: &f64| (a.mean_displacement < *limit) != (b.mean_displacement < *limit);
        let Some(at) = [limits.0, limits.1].into_iter().find(passed) else {
            return;
        };
        let leaves = flat.is_stable(a.mean_displacement);
        let energy = b.body_energy(self.control());
        let (stable, pattern) = if leaves {
            ([a.mean_displacement, a.energy, a.residual], now)
        } else {
            let residual = self.here.residual;
            ([b.mean_displacement, energy, residual], a.pattern)
        };
        if !self.is_trace(stable) || pattern == Pattern::Flat {
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
            release_error: (a.energy + work - energy).abs() / law.surface_energy,
            cause: Cause::Transition,
            landings: Vec::new(),
        }));
    }
}
