//! A loop read off the branches: for any drive the legs between jumps, and the energy each jump releases.

use super::{Atlas, End, Point, Unmapped};
use crate::experiment::record::{Branch as Direction, Cause, JumpRecord};
use crate::physics::theory::flat;

/// Where the surface is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Place {
    /// On the flat state.
    Flat,
    /// On the branch with this index.
    On(usize),
}

impl Place {
    /// Row of the landings.
    pub(super) fn row(self) -> usize {
        match self {
            Place::Flat => 0,
            Place::On(i) => i + 1,
        }
    }
}

/// A stretch of one branch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// Direction of the drive.
    pub direction: Direction,
    /// The branch.
    pub place: Place,
    /// u0 where it begins (length).
    pub from: f64,
    /// u0 where it ends (length).
    pub to: f64,
    /// True if it begins with a landing (or is the first); false where the drive only turned.
    pub begins: bool,
}

/// A closed loop.
#[derive(Clone, Debug, PartialEq)]
pub struct Cycle {
    /// The stretches in order.
    pub legs: Vec<Leg>,
    /// The jumps in order.
    pub jumps: Vec<JumpRecord>,
    /// Sum of the released energies, in units of gamma.
    pub dissipated_energy: f64,
}

/// Most jumps of one loop.
const JUMPS: usize = 64;

impl Atlas {
    /// Stress and energy of a place at `u0`.
    pub fn at(&self, place: Place, u0: f64) -> Point {
        match place {
            Place::Flat => {
                let response = self.chart.law.at(u0);
                Point { stress: response.traction, energy: response.energy }
            }
            Place::On(i) => self.branches[i].at(u0),
        }
    }

    /// Where the place ends on the way up or down; `None` if it does not.
    fn end(&self, place: Place, from: f64, up: bool) -> Option<(f64, Cause)> {
        match place {
            Place::Flat => {
                let (low, high) = self.flat_limits?;
                match up {
                    true if from <= low => Some((low, Cause::FlatLimit)),
                    false if from >= high => Some((high, Cause::FlatLimit)),
                    _ => None,
                }
            }
            Place::On(i) => {
                let (low, high) = self.branches[i].extent();
                let cause = match self.branches[i].ends[usize::from(up)] {
                    End::Fold => Cause::Fold,
                    End::Breaking => Cause::SymmetryBreaking,
                };
                Some((if up { high } else { low }, cause))
            }
        }
    }

    /// The closed loop from the flat state at `start` down to `turn` and back. Branches not known yet are traced on the way.
    ///
    /// # Errors
    /// What no sector holds; the walk must be asked then.
    pub fn cycle(&mut self, start: f64, turn: f64) -> Result<Cycle, Unmapped> {
        if flat::stiffness_min(&self.chart.law, self.chart.length, start) < 0.0 {
            return Err(Unmapped(format!("the flat state is not stable at the start, u0 = {start}")));
        }
        let mut cycle = Cycle { legs: Vec::new(), jumps: Vec::new(), dissipated_energy: 0.0 };
        let (mut place, mut here, mut begins) = (Place::Flat, start, true);
        for (direction, goal) in [(Direction::Approach, turn), (Direction::Retraction, start)] {
            let up = direction == Direction::Retraction;
            loop {
                let end = self.end(place, here, up).filter(|(at, _)| if up { *at < goal } else { *at > goal });
                let to = end.map_or(goal, |(at, _)| at);
                cycle.legs.push(Leg { direction, place, from: here, to, begins });
                begins = true;
                here = to;
                let Some((at, cause)) = end else {
                    begins = false;
                    break;
                };
                if cycle.jumps.len() == JUMPS {
                    return Err(Unmapped(format!("more than {JUMPS} jumps")));
                }
                let next = self.landing(place, up)?;
                let (before, after) = (self.at(place, at), self.at(next, at));
                let released_energy = (before.energy - after.energy) / self.chart.law.surface_energy;
                if !(released_energy >= 0.0) || next == place {
                    return Err(Unmapped(format!("the jump at u0 = {at:.4} would release {released_energy:.2e} gamma")));
                }
                if let Place::On(i) = next
                    && !self.branches[i].covers(at)
                {
                    return Err(Unmapped(format!("the jump at u0 = {at:.4} lands beside its branch")));
                }
                cycle.jumps.push(JumpRecord {
                    branch: direction,
                    mean_displacement: at,
                    from: self.pattern_at(place, at),
                    to: self.pattern_at(next, at),
                    stress_before: before.stress,
                    stress_after: after.stress,
                    released_energy,
                    cause,
                });
                cycle.dissipated_energy += released_energy;
                place = next;
            }
        }
        if place != Place::Flat {
            return Err(Unmapped("the loop does not close: drive.start is below the last jump of the retraction".to_owned()));
        }
        Ok(cycle)
    }
}
