//! A loop read off the branches: for any drive the legs between jumps, and the energy each jump
//! releases.

use super::{Atlas, End, Unmapped};
use crate::follow::record::{Cause, Direction, JumpRecord, LOCATED};
use crate::physics::control::Control;
use crate::physics::system::State;
use crate::solver::sector::Side;

/// Where the surface is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Place {
    /// On the flat state, on a side of what is unstable of it: towards the ground, or off it.
    Flat(Side),
    /// On the branch with this index.
    On(usize),
}

impl Place {
    /// Row of the landings.
    pub(in crate::follow) fn row(self) -> usize {
        match self {
            Place::Flat(_) => 0,
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
    /// The control where it begins.
    pub from: f64,
    /// The control where it ends.
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
    /// The state of a place where the control has this `value`, without its amplitudes; meaningful
    /// between its ends.
    pub fn at(&self, place: Place, value: f64) -> State {
        let control = self.meshes.control;
        let (mean_displacement, stress, energy) = match place {
            Place::Flat(side) => {
                let gap = self.flat.gap_on(side, value);
                let response = self.meshes.law.at(gap);
                (gap, response.traction, response.energy)
            }
            Place::On(i) => {
                let branch = &self.branches[i];
                let u0 = branch.place(control, value);
                let point = branch.at(u0);
                (u0, point.stress, point.energy)
            }
        };
        State {
            control: value,
            mean_displacement,
            amplitudes: Vec::new(),
            energy: energy + control.energy(value, mean_displacement),
            stress,
        }
    }

    /// The control at the lower and the upper end of branch `i`.
    pub fn extent(&self, i: usize) -> [f64; 2] {
        Side::BOTH.map(|side| self.end_state(Place::On(i), side).control)
    }

    /// True if branch `i` has a state where the control has this `value`.
    pub(super) fn covers(&self, i: usize, value: f64) -> bool {
        let [low, high] = self.extent(i);
        (low..=high).contains(&value)
    }

    /// Where the place ends on the way up or down; `None` if it does not.
    fn end(&self, place: Place, side: Side) -> Option<(f64, Cause)> {
        let cause = match place {
            Place::Flat(on) if on == side || self.flat.limits().is_none() => return None,
            Place::Flat(_) if self.flat.gives_way_as_a_block() => Cause::Fold,
            Place::Flat(_) => Cause::FlatLimit,
            Place::On(i) => match self.branches[i].ends[side.index()] {
                End::Fold => Cause::Fold,
                End::Breaking => Cause::SymmetryBreaking,
            },
        };
        Some((self.end_state(place, side).control, cause))
    }

    /// The closed loop from the flat state at the control's `start` down to `turn` and back.
    /// Branches not known yet are traced on the way.
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
        let place = match (atlas.meshes.control, atlas.flat.limits()) {
            (Control::Displacement, _) => Place::Flat(atlas.flat.side_of(start)),
            _ => Place::Flat(Side::Upper),
        };
        if atlas
            .end(place, Side::Lower)
            .is_some_and(|(end, _)| start < end)
        {
            return Err(Unmapped::at(
                start,
                "the flat state is not stable where the drive starts",
            ));
        }
        let goals = vec![(Direction::Retraction, start), (Direction::Approach, turn)];
        Ok(Self {
            goals,
            place,
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
        self.end = atlas.end(self.place, side).filter(|(at, _)| {
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
            && !atlas.covers(i, at)
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
        let control = atlas.meshes.control;
        let release_error = match self.place {
            // In closed form.
            Place::Flat(_) => 0.0,
            Place::On(_) => {
                let [one, other] = [&before, &after]
                    .map(|state| control.conjugate(state.mean_displacement, state.stress));
                LOCATED * control.unit(&atlas.meshes.law) * (one - other).abs()
                    / atlas.meshes.law.surface_energy
            }
        };
        let [u0, landed] = [&before, &after].map(|state| state.mean_displacement);
        let jump = JumpRecord {
            direction,
            control: at,
            mean_displacement: u0,
            mean_displacement_after: landed,
            from: atlas.pattern_at(self.place, u0),
            to: atlas.pattern_at(next, landed),
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
            Place::Flat(_) => Ok(()),
            Place::On(_) => Err(Unmapped::anywhere(
                "the loop does not close: drive.start is below the last jump of the retraction",
            )),
        }
    }
}
