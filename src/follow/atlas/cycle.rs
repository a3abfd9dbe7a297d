//! A loop read off the branches: for any drive the legs between jumps, and the energy each jump
//! releases.

use super::{Atlas, End, Point, Unmapped};
use crate::follow::record::{Cause, Direction, JumpRecord, LOCATED};
use crate::physics::theory::flat;
use crate::solver::sector::Side;

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
    pub(in crate::follow) fn row(self) -> usize {
        match self {
            Place::Flat => 0,
            Place::On(i) => i + 1,
        }
    }
}

/// A segment of one branch.
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
    /// The segments in order.
    pub legs: Vec<Leg>,
    /// The jumps in order.
    pub jumps: Vec<JumpRecord>,
    /// Sum of the released energies, in units of gamma.
    pub dissipated_energy: f64,
}

/// Released energy (gamma) below which a jump is not told from a continuous transition, near which
/// no branch is traced well.
const LEAST_RELEASE: f64 = 1e-6;
/// Most jumps of one loop.
const JUMPS: usize = 64;

impl Atlas {
    /// Stress and energy of a place at `u0`.
    pub fn at(&self, place: Place, u0: f64) -> Point {
        match place {
            Place::Flat => {
                let response = self.meshes.law.at(u0);
                Point {
                    stress: response.traction,
                    energy: response.energy,
                }
            }
            Place::On(i) => self.branches[i].at(u0),
        }
    }

    /// Where the place ends on the way up or down; `None` if it does not.
    fn end(&self, place: Place, from: f64, side: Side) -> Option<(f64, Cause)> {
        match place {
            Place::Flat => {
                let (low, high) = self.flat_limits?;
                match side {
                    Side::Upper if from <= low => Some((low, Cause::FlatLimit)),
                    Side::Lower if from >= high => Some((high, Cause::FlatLimit)),
                    _ => None,
                }
            }
            Place::On(i) => {
                let (low, high) = self.branches[i].extent();
                let cause = match self.branches[i].ends[side.index()] {
                    End::Fold => Cause::Fold,
                    End::Breaking => Cause::SymmetryBreaking,
                };
                Some((if side == Side::Upper { high } else { low }, cause))
            }
        }
    }

    /// The closed loop from the flat state at `start` down to `turn` and back. Branches not known
    /// yet are traced on the way.
    ///
    /// # Errors
    /// What no sector holds; the walk must be asked then.
    pub fn cycle(&mut self, start: f64, turn: f64) -> Result<Cycle, Unmapped> {
        let mut cycle = Cycle {
            legs: Vec::new(),
            jumps: Vec::new(),
            dissipated_energy: 0.0,
        };
        let mut traversal = Traversal::new(self, start, turn)?;
        while let Some(leg) = traversal.leg(self) {
            cycle.legs.push(leg);
            if let Some(jump) = traversal.jump(self)? {
                cycle.dissipated_energy += jump.released_energy;
                cycle.jumps.push(jump);
            }
        }
        traversal.closed()?;
        Ok(cycle)
    }
}

/// The end of a branch that the drive makes for.
fn end_of(direction: Direction) -> Side {
    match direction {
        Direction::Approach => Side::Lower,
        Direction::Retraction => Side::Upper,
    }
}

/// A loop under way: asked in turns for the next leg and for the jump at its end.
pub(in crate::follow) struct Traversal {
    /// Goals still ahead: the turn, then the start.
    goals: Vec<(Direction, f64)>,
    place: Place,
    here: f64,
    begins: bool,
    /// Where and why the leg last given ends, if it does not end at a goal.
    end: Option<(f64, Cause)>,
    jumps: usize,
}

impl Traversal {
    pub(in crate::follow) fn new(atlas: &Atlas, start: f64, turn: f64) -> Result<Self, Unmapped> {
        if flat::stiffness_min(&atlas.meshes.law, atlas.meshes.length, start) < 0.0 {
            return Err(Unmapped::at(
                start,
                "the flat state is not stable where the drive starts",
            ));
        }
        let goals = vec![(Direction::Retraction, start), (Direction::Approach, turn)];
        Ok(Self {
            goals,
            place: Place::Flat,
            here: start,
            begins: true,
            end: None,
            jumps: 0,
        })
    }

    /// The next segment of a branch; `None` when the loop is at its end.
    pub(in crate::follow) fn leg(&mut self, atlas: &Atlas) -> Option<Leg> {
        let &(direction, goal) = self.goals.last()?;
        let side = end_of(direction);
        self.end = atlas.end(self.place, self.here, side).filter(|(at, _)| {
            if side == Side::Upper {
                *at < goal
            } else {
                *at > goal
            }
        });
        let to = self.end.map_or(goal, |(at, _)| at);
        let leg = Leg {
            direction,
            place: self.place,
            from: self.here,
            to,
            begins: self.begins,
        };
        self.here = to;
        self.begins = self.end.is_some();
        Some(leg)
    }

    /// True if the last leg ends in a jump.
    pub(in crate::follow) fn jumps_next(&self) -> bool {
        self.end.is_some()
    }

    /// The jump at the end of the last leg; `None` if it ended at a goal.
    pub(in crate::follow) fn jump(
        &mut self,
        atlas: &mut Atlas,
    ) -> Result<Option<JumpRecord>, Unmapped> {
        let Some((at, cause)) = self.end.take() else {
            self.goals.pop();
            return Ok(None);
        };
        self.jumps += 1;
        if self.jumps > JUMPS {
            return Err(Unmapped::anywhere(format!("more than {JUMPS} jumps")));
        }
        let &(direction, _) = self.goals.last().expect("a leg was given");
        let next = atlas.landing(self.place, end_of(direction))?;
        if let Place::On(i) = next
            && !atlas.branches[i].covers(at)
        {
            return Err(Unmapped::at(at, "a jump lands beside its branch"));
        }
        let (before, after) = (atlas.at(self.place, at), atlas.at(next, at));
        let released_energy = (before.energy - after.energy) / atlas.meshes.law.surface_energy;
        if released_energy.abs() < LEAST_RELEASE {
            return Err(Unmapped::at(
                at,
                "a pattern comes or goes without a jump, continuously",
            ));
        }
        if !(released_energy > 0.0) || next == self.place {
            return Err(Unmapped::at(
                at,
                format!("a jump would release {released_energy:.2e} gamma"),
            ));
        }
        let release_error = match self.place {
            // In closed form.
            Place::Flat => 0.0,
            Place::On(_) => {
                LOCATED * atlas.meshes.law.range * (before.stress - after.stress).abs()
                    / atlas.meshes.law.surface_energy
            }
        };
        let jump = JumpRecord {
            direction,
            control: at,
            mean_displacement: at,
            mean_displacement_after: at,
            from: atlas.pattern_at(self.place, at),
            to: atlas.pattern_at(next, at),
            stress_before: before.stress,
            stress_after: after.stress,
            released_energy,
            release_error,
            cause,
            landings: atlas.contested(self.place, end_of(direction)),
        };
        self.place = next;
        Ok(Some(jump))
    }

    /// # Errors
    /// The loop has come back to its start on another branch than it left.
    pub(in crate::follow) fn closed(&self) -> Result<(), Unmapped> {
        match self.place {
            Place::Flat => Ok(()),
            Place::On(_) => Err(Unmapped::anywhere(
                "the loop does not close: drive.start is below the last jump of the retraction",
            )),
        }
    }
}
