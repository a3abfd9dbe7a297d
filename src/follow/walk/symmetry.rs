//! The part of the cell: a state that is stable among even fields may still give way to a mode of
//! another symmetry. Such modes are watched beside the walk, which goes over to the whole cell
//! where one goes soft.

use super::{Stuck, Walk, WalkOptions, solved};
use crate::numerics::cancel::Cancel;
use crate::physics::grid::Grid;
use crate::physics::indenter::Indenter;
use crate::physics::preconditioner::Preconditioner;
use crate::physics::system::{State, System};
use crate::scene::mesh::points_at;
use crate::scene::part::Part;
use crate::scene::{Model, Scene};
use crate::solver::Stop;
use crate::solver::branch::History;
use crate::solver::equilibrium::{Equilibrium, Stiffness};
use crate::solver::mechanics::{Mechanics, Slides, preconditioner_stiffness};
use crate::solver::stability::Tracker;
use ndarray::Array2;

/// Largest mu_rho at which patterns on flat ground still slide freely over the mesh; beyond it the
/// mesh pins them (Fig. 8).
const SLIDING_MU_RHO: f64 = 0.45;

/// mu_rho of a mesh that resolves soft modes.
const RESOLVED: f64 = 0.33;

/// Tracks the smallest eigenvalue of the whole cell beside a walk on its even part.
pub(in crate::follow) struct Guard {
    pub(in crate::follow) mechanics: Mechanics,
    tracker: Tracker,
}

impl Guard {
    /// Watches a whole cell.
    pub(in crate::follow) fn new(mechanics: Mechanics, tracker: Tracker) -> Self {
        Self {
            tracker: with_coarse(tracker, &mechanics),
            mechanics,
        }
    }

    /// Watches the whole cell of the `even` system.
    pub(super) fn of_even(even: &System, slides: Slides, tracker: Tracker) -> Self {
        let whole = System::whole(even);
        let preconditioner = Preconditioner::new(&whole, preconditioner_stiffness(even));
        Self::new(
            Mechanics::with_preconditioner(preconditioner, whole, slides),
            tracker,
        )
    }

    /// Transforms of the whole cell spent.
    pub(in crate::follow) fn transforms(&self) -> usize {
        self.mechanics.transforms() + self.tracker.coarse_transforms()
    }

    /// Transforms spent on proofs.
    pub(in crate::follow) fn proof_transforms(&self) -> usize {
        self.tracker.proof_transforms()
    }

    /// Forgets the branch.
    pub(in crate::follow) fn reset(&mut self) {
        self.tracker.reset();
    }

    /// The smallest eigenvalue over all modes of the whole cell, and u0 where it is free, at the
    /// `displacement` field u of mean `u0` in equilibrium with the mean `stress`. `even` is an upper
    /// bound of it: modes are followed only while there are softer ones.
    pub(in crate::follow) fn check(
        &mut self,
        even: Stiffness,
        displacement: &Array2<f64>,
        [u0, stress]: [f64; 2],
    ) -> Stiffness {
        let mut z = self.mechanics.amplitudes(displacement);
        let control;
        [control, z[0]] = self.mechanics.system.control().balanced(u0, stress);
        let at = self.mechanics.at(z, control);
        self.mechanics.refresh(&at.fields);
        let Self { mechanics, tracker } = self;
        let (z, fields) = (&at.state.amplitudes, &at.fields);
        let bounded = tracker.bounded(mechanics, z, fields, even.value);
        bounded.unwrap_or_else(|| tracker.check(mechanics, z, fields).0)
    }
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
        let (system, gap) = (&mechanics.system, &fields.gap);
        let u0 =
            gap.mean().unwrap_or(f64::NAN) + system.height().and_then(|h| h.mean()).unwrap_or(0.0);
        let mut displacement = system.unfolded(gap);
        if let Some(height) = system.height() {
            displacement += &system.unfolded(height);
        }
        guard.mechanics.cancel = mechanics.cancel.clone();
        let all = guard.check(even, &displacement, [u0, found.state.stress]);
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
