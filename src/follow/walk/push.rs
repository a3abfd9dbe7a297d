//! A push by hand: a bump or a dimple pressed into the surface at a fixed control, let go, and
//! where the surface comes to rest then.

use super::landing::EVENT;
use super::{Behind, Jumping, Observed, Phase, Walk};
use crate::follow::record::{Cause, JumpRecord};
use crate::numerics::dense::add;
use crate::physics::system::Evaluation;
use crate::solver::branch::History;
use crate::solver::equilibrium::Equilibrium;
use crate::solver::release::Release;
use ndarray::Array2;

/// Most energy per area of a push (gamma): beyond it the law's wall alone is felt.
const MOST: f64 = 10.0;
/// How much shallower a push becomes that has more, and how often.
const SHALLOWER: f64 = 0.8;
const TRIALS: usize = 60;
/// Largest difference in stress (sigma_max) between two descriptions of one state.
const SAME: f64 = 1e-4;

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

impl Walk {
    /// True while the surface moves.
    pub fn is_jumping(&self) -> bool {
        matches!(self.phase, Phase::Jumping(_))
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
        let grid = *self.mechanics.system.grid();
        let (rows, columns) = self.mechanics.system.shape();
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
        let tolerance = self.mechanics.system.precision().tolerance();
        self.target = self.here.state.control;
        self.phase = Phase::Jumping(Box::new(Jumping {
            release: Release::new(pressed).with_tolerance(tolerance),
            cause: Cause::Push,
            kicks: 1,
            soft_mode: Vec::new(),
            kick: 0.0,
            energy_before: self.here.state.energy,
            landings: Vec::new(),
        }));
    }

    /// Stands on the state to which a push led: the same as before, perhaps elsewhere in the cell,
    /// or another one, of lower or of higher energy.
    pub(super) fn land_pushed(&mut self, landed: Equilibrium, observe: &mut dyn FnMut(Observed)) {
        let law = self.model.law;
        let left = std::mem::replace(&mut self.here, landed);
        self.behind = Behind {
            history: History::starting(&self.here.state),
            before: None,
            short: None,
        };
        let (from, to) = (self.record.pattern, self.pattern());
        let (before, after) = (&left.state, &self.here.state);
        let released_energy = (before.energy - after.energy) / law.surface_energy;
        let changed = (before.stress - after.stress).abs() / law.traction_max();
        if from != to || released_energy.abs() > EVENT || changed > SAME {
            observe(Observed::Jump(JumpRecord {
                direction: self.direction,
                control: after.control,
                mean_displacement: before.mean_displacement,
                mean_displacement_after: after.mean_displacement,
                from,
                to,
                stress_before: before.stress,
                stress_after: after.stress,
                released_energy,
                release_error: 0.0,
                cause: Cause::Push,
                landings: Vec::new(),
            }));
        }
        // Nothing else happened on the way.
        self.record.mean_displacement = self.here.state.mean_displacement;
        self.accept(observe);
    }
}
