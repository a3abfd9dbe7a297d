//! From a part of the cell to the whole of it, where the part was not enough.

use super::{Walk, solved};
use crate::experiment::plan::Reduction;
use crate::experiment::scene::Scene;
use crate::numerics::cancel::Cancel;
use crate::solver::Stop;
use crate::solver::branch::History;
use crate::solver::methods::MethodKind;

/// A walk on the whole cell that takes over from one on a part.
pub struct Widened {
    /// The walk, with the target of the one before.
    pub walk: Walk,
    /// True if it stands where the one before stood; false if it is back at the start of the drive.
    pub stays: bool,
}

impl Walk {
    /// Goes over to the whole cell, where a part proved too small: from where it stands, or, if that is not near an equilibrium of the
    /// whole cell (a tip's apex lies on a point there and between points here), from the start of the drive. A jump under way begins
    /// anew from the state before it. `None` if this is the whole cell already, or a surface that is to be held mirror-symmetric.
    pub fn widen(&mut self, scene: &Scene, method: MethodKind, cancel: &Cancel) -> Option<Widened> {
        self.guard.as_ref()?;
        let precision = self.mechanics.system.precision();
        let afresh = || Self::begun(scene, method.build(scene.seed), Reduction::Whole, precision, cancel).ok();
        let mut walk = afresh()?;
        let stays = self.stand(&mut walk);
        if !stays {
            walk = afresh()?;
        }
        (walk.target, walk.falls_within) = (self.target, self.falls_within);
        Some(Widened { walk, stays })
    }

    /// Puts `whole` on the present state; false where that is near no equilibrium of it.
    fn stand(&mut self, whole: &mut Self) -> bool {
        let u0 = self.here.state.mean_displacement;
        whole.direction = self.direction;
        match self.flat {
            Some(flat) if self.here.is_uniform() => whole.here = flat.state(&whole.mechanics.system, u0),
            _ => {
                let even = self.mechanics.field(&self.here.state.amplitudes).clone();
                let displacement = self.mechanics.system.unfolded(&even);
                let amplitudes = whole.mechanics.amplitudes(&displacement);
                whole.here = solved(&mut whole.mechanics, &mut whole.tracker, amplitudes, u0);
                whole.history = History::starting(&whole.here.state);
                if !matches!(whole.here.stop, Stop::Stable | Stop::Unstable) {
                    return false;
                }
            }
        }
        whole.accept(&mut |_| {});
        true
    }
}
