//! The part of the cell: a state that is stable among even fields may still give way to a mode of
//! another symmetry. Such modes are watched beside the walk, which goes over to the whole cell
//! where one goes soft.

use super::{Stuck, Walk, WalkOptions, solved};
use crate::numerics::threads::Cancel;
use crate::physics::indenter::Indenter;
use crate::physics::low_block::Class;
use crate::physics::mesh::{Grid, points_at};
use crate::physics::preconditioner::class_reach;
use crate::physics::system::{Fields, State, System};
use crate::scene::{Model, Part, Scene};
use crate::solver::class_proof::{ClassProof, Known, softest};
use crate::solver::mechanics::{Mechanics, Slides};
use crate::solver::method::{Equilibrium, History, Stiffness, Stop};
use crate::solver::stability::Tracker;
use ndarray::Array2;
use rand::SeedableRng;
use rand_pcg::Pcg64;

/// Largest mu_rho at which patterns on flat ground still slide freely over the mesh; beyond it the
/// mesh pins them (Fig. 8).
const SLIDING_MU_RHO: f64 = 0.45;

/// mu_rho of a mesh that resolves soft modes.
const RESOLVED: f64 = 0.33;

/// Longest reach of the exact blocks for proofs over flat ground: fig3 in steps of 0.2 takes 6.2, 5.2
/// and 5.3 s with 10, 16 and 20 waves; `run ridge-line` with all waves of a line 2.6 times as long.
const MOST_REACH: f64 = 16.0;
/// What is asked of odd modes as a share of what is proved of even ones: with .9 a loop of Fig. 3 and
/// one over the tip at n = 128 take 2 and 3 % more transforms than with .5.
const ODD: f64 = 0.9;
/// How closely gamma'' keeps x <-> y in a pattern that does, over [`System::stiffness_unit`].
const SAME: f64 = 1e-6;

/// The soft even modes that are known at a state.
pub(in crate::follow) enum Soft<'a> {
    /// One, with its eigenvalue (E* per length).
    Mode(f64, &'a [f64]),
    /// Those of the classes of a pattern that keeps x <-> y.
    Classes(&'a [Known]),
}

/// Tracks the smallest eigenvalue among all modes of the whole cell over even patterns: even ones,
/// and those that are odd along x, y or both, which know nothing of each other.
pub(in crate::follow) struct Guard {
    modes: Vec<(Mechanics, Tracker)>,
    proof: Option<ClassProof>,
    pub(in crate::follow) cancel: Cancel,
}

impl Guard {
    /// Watches the modes over patterns of the `even` system, which slide so on its whole cell;
    /// random directions come from `seed`.
    pub(in crate::follow) fn new(even: &System, slides: Slides, seed: u64) -> Self {
        let is_line = even.grid().is_line();
        let reach = class_reach(even, MOST_REACH).min(MOST_REACH);
        let modes = [[false, false], [true, false], [false, true], [true, true]]
            .into_iter()
            .filter(|[x, y]| {
                !(*y && (is_line || *x && even.orders_modes() && slides == Slides::Never))
            })
            .enumerate()
            .map(|(i, odd)| {
                let (system, slides) = match odd {
                    [false, false] => (even.clone(), Slides::Never),
                    _ => (System::odd(even, odd), slides),
                };
                let rng = Pcg64::seed_from_u64(seed ^ i as u64);
                let mut mechanics = if even.is_flat() {
                    Mechanics::of_class(system.clone(), Class::of(&system), reach)
                } else {
                    Mechanics::new(system, Slides::Never)
                };
                mechanics.slides = slides;
                (mechanics, Tracker::new(rng))
            });
        Self {
            modes: modes.collect(),
            proof: ClassProof::new(even, slides),
            cancel: Cancel::default(),
        }
    }

    /// Transforms spent.
    pub(in crate::follow) fn transforms(&self) -> usize {
        self.modes
            .iter()
            .map(|(mechanics, _)| mechanics.transforms())
            .sum()
    }

    /// Transforms spent on proofs.
    pub(in crate::follow) fn proof_transforms(&self) -> usize {
        self.modes
            .iter()
            .map(|(_, tracker)| tracker.proof_transforms())
            .sum()
    }

    /// Forgets the branch.
    pub(in crate::follow) fn reset(&mut self) {
        self.modes
            .iter_mut()
            .for_each(|(_, tracker)| tracker.reset());
    }

    /// The fields of the even surface `z` where the control is `control`. Two transforms.
    pub(in crate::follow) fn fields(&mut self, z: &[f64], control: f64) -> Fields {
        self.modes[0].0.at(z.to_vec(), control).fields
    }

    /// The smallest eigenvalue over all modes of the whole cell, and u0 where it is free, at the
    /// even surface `z` with these `fields`, where `soft` even modes are known, the softest among
    /// them.
    pub(in crate::follow) fn check(
        &mut self,
        soft: Soft<'_>,
        z: &[f64],
        fields: &Fields,
    ) -> Stiffness {
        let (even, _) = &mut self.modes[0];
        even.cancel = self.cancel.clone();
        // What is odd along y is what is odd along x with x and y exchanged, as far as the pattern
        // allows that: no eigenvalue moves by more than gamma'' does.
        let swapped = skew(&fields.stiffness);
        let is_square = swapped <= SAME * even.system.stiffness_unit();
        if let Some(proof) = self.proof.as_mut().filter(|_| is_square) {
            let part;
            let known = match soft {
                Soft::Mode(_, mode) => {
                    part = [Known::of(even, fields, mode)];
                    &part[..]
                }
                Soft::Classes(known) => known,
            };
            if let Some(Stiffness { value, error }) = proof.least(even, z, fields, known) {
                let error = error + swapped;
                return Stiffness { value, error };
            }
        }
        let rates = even.rates(fields);
        let seen = match soft {
            Soft::Mode(value, _) => value,
            Soft::Classes(known) => softest(known),
        };
        let (mut value, mut lower, mut odd) = (seen, f64::INFINITY, f64::INFINITY);
        let mut weakened = None;
        for (mechanics, tracker) in &mut self.modes {
            if is_square && mechanics.system.is_odd() == [false, true] {
                continue;
            }
            mechanics.cancel = self.cancel.clone();
            let (shift, is_odd) = (ODD * lower, mechanics.system.is_odd() != [false; 2]);
            if is_odd
                && shift > 0.0
                && mechanics.system.orders_modes()
                && let Some(weakened) = &weakened
                && tracker.odd_above(mechanics, z, [fields, weakened], [lower, shift])
            {
                odd = shift;
                continue;
            }
            mechanics.renew(fields, &rates);
            let found = tracker
                .bounded(mechanics, z, fields, seen)
                .unwrap_or_else(|| tracker.check(mechanics, z, fields).0);
            if !found.is_stable() {
                return found;
            }
            value = value.min(found.value);
            lower = lower.min(found.value - found.error);
            if !is_odd {
                weakened = tracker.weakened(fields);
            }
        }
        let unsure = if is_square { swapped } else { 0.0 };
        Stiffness {
            value,
            error: value - lower.min(odd) + unsure,
        }
    }
}

/// How far a field is from one that keeps x <-> y; infinite on a line.
fn skew(field: &Array2<f64>) -> f64 {
    if !field.is_square() {
        return f64::INFINITY;
    }
    let pairs = field.indexed_iter();
    pairs.fold(0.0, |most: f64, ((j, i), here)| {
        most.max((here - field[[i, j]]).abs())
    })
}

/// How much softer than the softest even mode followed, as a share of it, another may be before the
/// even ones are looked for anew.
const SOFTER: f64 = 0.25;

impl Walk {
    /// The smallest eigenvalue of `found`, and the softest mode of the part of the cell. On a
    /// quarter cell the eigenvalue is over all modes of the whole cell: what is proved of those is
    /// proved of the even ones among them, which are only followed. `Err` where a mode that is not
    /// even has a negative one.
    pub(super) fn stability(
        &mut self,
        found: &Equilibrium,
    ) -> Result<(Stiffness, Vec<f64>), Stuck> {
        let Self {
            mechanics, tracker, ..
        } = self;
        let (z, fields) = (&found.state.amplitudes, &found.fields);
        let Some(guard) = &mut self.guard else {
            return Ok(tracker.check(mechanics, z, fields));
        };
        let (mut even, mut mode) = tracker.above(mechanics, z, fields);
        if !even.is_stable() {
            return Ok((even, mode));
        }
        guard.cancel = mechanics.cancel.clone();
        let all = guard.check(Soft::Mode(even.value, &mode), z, fields);
        if all.value < (1.0 - SOFTER) * even.value {
            (even, mode) = tracker.check(mechanics, z, fields);
        }
        if all.value < 0.0 && even.is_stable() {
            return Err(Stuck::LeavesSymmetry);
        }
        Ok((even.among(all), mode))
    }
}

/// A walk on the whole cell that takes over from one on a part.
pub struct Widened {
    /// The walk, with the target of the one before.
    pub walk: Walk,
    /// True if it stands where the one before stood; false if it is back at the start of the drive.
    pub stays: bool,
}

impl Walk {
    /// Goes over to the whole cell, where a part proved too small: from where it stands, or, if
    /// that is not near an equilibrium of the whole cell (a tip's apex lies on a point there and
    /// between points here), from the start of the drive. A jump under way begins anew from the
    /// state before it. `None` unless it is `because` a mode, or a push, leaves the symmetry of the part.
    pub fn widen(&mut self, because: &Stuck, scene: &Scene, cancel: &Cancel) -> Option<Widened> {
        if !matches!(because, Stuck::LeavesSymmetry | Stuck::Pushed) {
            return None;
        }
        let options = WalkOptions {
            part: Part::Whole,
            ..self.options
        };
        let afresh = || Self::start(scene, options, cancel).ok();
        let mut walk = afresh()?;
        let stays = self.stand(&mut walk);
        if !stays {
            walk = afresh()?;
        }
        walk.target = self.target;
        Some(Widened { walk, stays })
    }

    /// Puts `whole` on the present state; false where that is near no equilibrium of it.
    fn stand(&mut self, whole: &mut Self) -> bool {
        let State {
            control,
            mean_displacement: u0,
            ..
        } = self.here.state;
        whole.direction = self.direction;
        match self.flat {
            Some(flat) if self.here.is_uniform() => {
                whole.here = flat.state(&whole.mechanics.system, u0);
                whole.here.state.control = control;
            }
            _ => {
                let even = self.mechanics.field(&self.here.state.amplitudes).clone();
                let displacement = self.mechanics.system.unfolded(&even);
                let amplitudes = whole.mechanics.amplitudes(&displacement);
                let (mechanics, tracker) = (&mut whole.mechanics, &mut whole.tracker);
                whole.here = solved(mechanics, tracker, amplitudes, control);
                whole.behind.history = History::starting(&whole.here.state);
                if !matches!(whole.here.stop, Stop::Stable | Stop::Unstable) {
                    return false;
                }
            }
        }
        whole.accept(&mut |_| {});
        true
    }
}

/// The tracker with a coarser mesh to look for modes on, where the one of `mechanics` has points to
/// spare.
pub(super) fn with_coarse(
    tracker: Tracker,
    Mechanics { system, slides, .. }: &Mechanics,
) -> Tracker {
    let (law, grid) = (system.law(), system.grid());
    let n = points_at(law, grid.length, RESOLVED);
    if !system.is_flat() || !law.is_smooth() || 2 * n > grid.nx {
        return tracker;
    }
    let coarse = if grid.is_line() {
        Grid::line(grid.length, n)
    } else {
        Grid::square(grid.length, n)
    };
    let make = if system.is_even() {
        System::even
    } else {
        System::new
    };
    let coarse = make(coarse, *law, &Indenter::Flat)
        .with_body(system.body())
        .with_control(system.control());
    tracker.with_coarse(Mechanics::new(coarse, *slides))
}

/// Whether patterns slide on the whole cell of `model`.
pub(in crate::follow) fn slides_on(model: &Model) -> Slides {
    match model.indenter.ground().is_uniform() {
        [false, false] => Slides::Never,
        _ if model.law.is_smooth() && model.mu_rho <= SLIDING_MU_RHO => Slides::Freely,
        _ => Slides::UnlessPinned,
    }
}
