//! From a part of the cell to the whole of it, where the part was not enough.

use super::Walk;
use crate::experiment::scene::Scene;
use crate::solver::Stop;
use crate::solver::method::MethodKind;

impl Walk {
    /// A walk on the whole cell that stands where this one last stood and has the same target. A jump under way begins anew from the
    /// state before it. `None` where the unfolded state is not near an equilibrium of the whole cell (a tip's apex lies on a point
    /// there and between points here).
    pub fn widened(&mut self, scene: &Scene, method: MethodKind) -> Option<Self> {
        let mut whole = Self::new(scene, method).ok()?;
        let u0 = self.state.mean_displacement;
        (whole.target, whole.direction) = (self.target, self.direction);
        match self.flat {
            Some(flat) if self.state.is_uniform() => whole.state = flat.state(u0, whole.system.dimension()),
            _ => {
                let displacement = self.system.unfolded(self.system.field(&self.state.field, &mut self.ws));
                whole.state.mean_displacement = u0;
                whole.state.field = whole.system.amplitudes(&displacement, &mut whole.ws);
                whole.solve_here();
                if !matches!(whole.state.stop, Stop::Stable | Stop::Unstable) {
                    return None;
                }
            }
        }
        whole.accept(&mut |_| {});
        Some(whole)
    }
}
