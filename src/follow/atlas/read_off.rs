//! What is read off the branches: of each as a curve stress and energy between its nodes, and of all,
//! for any drive, a loop: the legs between jumps, and the energy each jump releases.

use super::{Atlas, Unmapped};
use crate::follow::record::{Cause, Direction, JumpRecord, is_jump, located_energy};
use crate::numerics::dense::{add, hermite};
use crate::physics::control::Control;
use crate::physics::pattern::Pattern;
use crate::physics::system::{Fields, State};
use crate::physics::theory::boundary;
use crate::solver::method::Lost;
use crate::solver::sector::{Node, Sector, Side};

/// How a branch of stable states ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum End {
    /// It turns back in what is driven.
    Fold,
    /// It goes on, unstable, where a mode of another symmetry has gone soft.
    Breaking,
    /// Its pattern fades away at a limit of the flat state, which is stable beyond: no jump.
    Flat,
}

/// A branch of stable states between its two ends.
#[derive(Clone, Debug)]
pub struct Branch {
    /// Its pattern.
    pub pattern: Pattern,
    /// By growing u0; the first and the last are the ends.
    pub nodes: Vec<Node>,
    /// How it ends below and above.
    pub ends: [End; 2],
}

/// What a branch says at one u0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Mean stress (E*).
    pub stress: f64,
    /// Energy per area (E* times length).
    pub energy: f64,
    /// d stress/du0 along the branch (E* per length).
    pub slope: f64,
}

impl Branch {
    /// True for states of the line problem.
    pub fn is_ridge(&self) -> bool {
        self.pattern == Pattern::Ridge
    }

    /// u0 of the lower and the upper end (length).
    pub fn extent(&self) -> (f64, f64) {
        (self.end(Side::Lower).u0(), self.end(Side::Upper).u0())
    }

    /// Adds a node between the ends.
    pub(super) fn insert(&mut self, node: Node) {
        let i = self
            .nodes
            .partition_point(|n| n.u0() < node.u0())
            .clamp(1, self.nodes.len() - 1);
        self.nodes.insert(i, node);
    }

    /// The upper or the lower end.
    pub fn end(&self, side: Side) -> &Node {
        if side == Side::Upper {
            &self.nodes[self.nodes.len() - 1]
        } else {
            &self.nodes[0]
        }
    }

    /// The node next to the upper or the lower end.
    pub(super) fn beside(&self, side: Side) -> &Node {
        match side {
            Side::Lower => &self.nodes[1],
            Side::Upper => &self.nodes[self.nodes.len() - 2],
        }
    }

    pub(super) fn segment(&self, u0: f64) -> (&Node, &Node) {
        let last = self.nodes.len() - 1;
        let i = self.nodes.partition_point(|n| n.u0() <= u0).clamp(1, last);
        (&self.nodes[i - 1], &self.nodes[i])
    }

    /// Stress and energy at `u0`: quintic Hermite in the energy, whose derivatives are stress and
    /// slope; next to a fold a quartic in the square root of the distance. Meaningful between
    /// its ends.
    pub fn at(&self, u0: f64) -> Point {
        let (a, b) = self.segment(u0);
        Support::of(a).to(Support::of(b), u0)
    }

    /// The smallest eigenvalue under `control` at `u0` (E* per length), linear between nodes.
    pub fn softness(&self, control: Control, u0: f64) -> f64 {
        let (a, b) = self.segment(u0);
        let width = b.u0() - a.u0();
        let t = ((u0 - a.u0()) / width).clamp(0.0, 1.0);
        a.softness(control) + t * (b.softness(control) - a.softness(control))
    }

    /// u0 where the `control` has this `value`, which grows with u0 along what is stable; the nearer
    /// end where it has it nowhere.
    pub(super) fn place(&self, control: Control, value: f64) -> f64 {
        if control == Control::Displacement {
            return value;
        }
        let (low, high) = self.extent();
        let below = |u0: f64| control.balanced(u0, self.at(u0).stress)[0] < value;
        match (below(low), below(high)) {
            (false, _) => low,
            (_, true) => high,
            _ => boundary(low, high, below),
        }
    }

    /// Amplitudes at `u0`, a guess that one Newton step makes a state.
    pub fn guess(&self, u0: f64) -> Vec<f64> {
        let (a, b) = self.segment(u0);
        guess(a, b, u0)
    }
}

/// Amplitudes at `u0` between two nodes: cubic Hermite, next to a vertical one in the root of the
/// distance.
pub(super) fn guess(a: &Node, b: &Node, u0: f64) -> Vec<f64> {
    let (fold, regular) = match (a.is_vertical(), b.is_vertical()) {
        (false, false) => return between(a, b, u0),
        (false, true) => (b, a),
        _ => (a, b),
    };
    // z = z_f + c1 s + c2 s^2 with s = sqrt((u0 - u_f)/(u_r - u_f)).
    let width = regular.u0() - fold.u0();
    let s = ((u0 - fold.u0()) / width).max(0.0).sqrt();
    let mut z = fold.state.amplitudes.clone();
    let mut change = regular.state.amplitudes.clone();
    add(&mut change, -1.0, &fold.state.amplitudes);
    if regular.is_vertical() {
        add(&mut z, s * s, &change);
        return z;
    }
    add(&mut z, 2.0 * s - s * s, &change);
    add(&mut z, 2.0 * width * (s * s - s), &regular.tangent);
    z
}

/// The node at `u0` on the curve between two others, with its fields. Near a fold of u0, and far from
/// the other node, the curve may be too far from the branch: then it is drawn to a node in between,
/// where the surface is twice as far from the fold.
///
/// # Errors
/// As [`Sector::node`].
pub fn node_between(
    sector: &mut Sector,
    (a, b): (&Node, &Node),
    u0: f64,
    before: Option<&Node>,
    tolerance: f64,
) -> Result<(Node, Fields), Lost> {
    let mut found = sector.node(u0, guess(a, b, u0), before, tolerance);
    let (fold, other) = if a.is_vertical() { (a, b) } else { (b, a) };
    let (off, width) = (u0 - fold.u0(), other.u0() - fold.u0());
    let share = off / width;
    if found.is_err() && fold.is_vertical() && 0.0 < share && share < 0.25 {
        let farther = fold.u0() + 4.0 * off;
        let (nearer, _) = node_between(sector, (a, b), farther, before, tolerance)?;
        found = sector.node(u0, guess(&nearer, fold, u0), Some(&nearer), tolerance);
    }
    found
}

/// Cubic Hermite between two regular nodes, at any u0.
pub fn between(a: &Node, b: &Node, u0: f64) -> Vec<f64> {
    let h = b.u0() - a.u0();
    let t = (u0 - a.u0()) / h;
    let (y, z) = (&a.state.amplitudes, &b.state.amplitudes);
    hermite([y, &a.tangent, z, &b.tangent], h, t)
}

/// What is known of a branch at one u0.
#[derive(Clone, Copy, Debug)]
pub(in crate::follow) struct Support {
    /// Mean displacement (length).
    pub u0: f64,
    /// Energy per area (E* times length).
    pub energy: f64,
    /// Mean stress (E*).
    pub stress: f64,
    /// d stress/du0; infinite at a fold.
    pub slope: f64,
}

impl Support {
    pub(super) fn of(node: &Node) -> Self {
        Self {
            u0: node.u0(),
            energy: node.state.energy,
            stress: node.state.stress,
            slope: node.slope,
        }
    }

    /// The branch between two supports, at `u0`: as [`Branch::at`].
    pub fn to(self, b: Self, u0: f64) -> Point {
        match (self.slope.is_finite(), b.slope.is_finite()) {
            (true, true) => quintic(self, b, u0),
            (true, false) => root(b, self, u0),
            (false, true) => root(self, b, u0),
            (false, false) => {
                let t = (u0 - self.u0) / (b.u0 - self.u0);
                Point {
                    stress: self.stress + t * (b.stress - self.stress),
                    energy: self.energy + t * (b.energy - self.energy),
                    slope: (b.stress - self.stress) / (b.u0 - self.u0),
                }
            }
        }
    }
}

/// The quintic with the energies, stresses and slopes of two supports.
fn quintic(a: Support, b: Support, u0: f64) -> Point {
    let h = b.u0 - a.u0;
    let t = (u0 - a.u0) / h;
    // V = V_a + p_a h t + s_a h^2 t^2/2 + c3 t^3 + c4 t^4 + c5 t^5.
    let (p0, s0) = (a.stress * h, a.slope * h * h);
    let (v, p, s) = (
        b.energy - a.energy - p0 - 0.5 * s0,
        b.stress * h - p0 - s0,
        b.slope * h * h - s0,
    );
    let (c3, c4, c5) = (
        10.0 * v - 4.0 * p + 0.5 * s,
        -15.0 * v + 7.0 * p - s,
        6.0 * v - 3.0 * p + 0.5 * s,
    );
    Point {
        energy: a.energy + t * (p0 + t * (0.5 * s0 + t * (c3 + t * (c4 + t * c5)))),
        stress: (p0 + t * (s0 + t * (3.0 * c3 + t * (4.0 * c4 + t * 5.0 * c5)))) / h,
        slope: (s0 + t * (6.0 * c3 + t * (12.0 * c4 + t * 20.0 * c5))) / (h * h),
    }
}

/// Between a `fold` and a regular node: stress = p_f + c1 s + c2 s^2 + c3 s^3 with s the root of
/// the relative distance, which has the stress, the slope and the energy of the regular node.
fn root(fold: Support, regular: Support, u0: f64) -> Point {
    let width = regular.u0 - fold.u0;
    let s = ((u0 - fold.u0) / width).clamp(0.0, 1.0).sqrt();
    let p = regular.stress - fold.stress;
    let slope = 2.0 * width * regular.slope;
    let work = (regular.energy - fold.energy) / width - fold.stress;
    // c1 + c2 + c3 = p, c1 + 2 c2 + 3 c3 = slope, 2/3 c1 + 1/2 c2 + 2/5 c3 = work.
    let c1 = 1.5 * slope + 15.0 * work - 10.5 * p;
    let c2 = -4.0 * slope - 30.0 * work + 24.0 * p;
    let c3 = 2.5 * slope + 15.0 * work - 12.5 * p;
    Point {
        stress: fold.stress + s * (c1 + s * (c2 + s * c3)),
        energy: fold.energy
            + width * s * s * (fold.stress + s * (2.0 / 3.0 * c1 + s * (0.5 * c2 + s * 0.4 * c3))),
        slope: (0.5 * c1 / s + c2 + 1.5 * c3 * s) / width,
    }
}

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
    /// True if it begins with a landing (or is the first); false where the drive only turned, or
    /// where the branch goes over into another continuously.
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

    /// True if the pattern of `place` fades away on this `side`.
    pub(in crate::follow) fn fades(&self, place: Place, side: Side) -> bool {
        matches!(place, Place::On(i) if self.branches[i].ends[side.index()] == End::Flat)
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
                End::Flat => Cause::Transition,
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
        let end = atlas.end(self.place, side);
        self.end = end.filter(|(at, _)| side.sign() * (goal - at) > 0.0);
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

    /// The jump at the end of the last leg; `None` if it ended at a goal, or without a jump.
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
        let side = end_of(direction);
        let next = atlas.landing(self.place, side)?;
        if let Place::On(i) = next
            && !atlas.covers(i, at)
        {
            return Err(Unmapped::at(at, "a jump lands beside its branch"));
        }
        let (before, after) = (atlas.at(self.place, at), atlas.at(next, at));
        let fades = match self.place {
            Place::Flat(_) => atlas.fades(next, side.opposite()),
            Place::On(_) => atlas.fades(self.place, side),
        };
        let freed = (before.energy - after.energy) / atlas.meshes.law.surface_energy;
        let patterned = [self.place, next]
            .iter()
            .filter(|at| matches!(at, Place::On(_)))
            .count();
        let (control, law) = (atlas.meshes.control, &atlas.meshes.law);
        let conjugates =
            [&before, &after].map(|state| control.conjugate(state.mean_displacement, state.stress));
        let jumped = is_jump(control, law, conjugates, freed);
        if patterned == 2 && !jumped && next != self.place {
            (self.place, self.begins) = (next, false);
            return Ok(None);
        }
        let is_continuous = fades || patterned == 1 && !jumped;
        let released_energy = if is_continuous { 0.0 } else { freed };
        if !(released_energy > 0.0 || is_continuous) || next == self.place {
            return Err(Unmapped::at(
                at,
                format!("a jump would release {released_energy:.2e} gamma"),
            ));
        }
        let release_error = match self.place {
            _ if is_continuous => freed.abs(),
            // In closed form.
            Place::Flat(_) => 0.0,
            Place::On(_) => located_energy(control, law, conjugates),
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
            cause: if is_continuous {
                Cause::Transition
            } else {
                cause
            },
            landings: atlas.contested(self.place, side),
        };
        self.place = next;
        self.begins = !fades;
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
