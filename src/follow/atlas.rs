//! The atlas of branches: on flat ground a loop is a handful of branches, each followed once.
//!
//! Flat states are a closed form, ridges a line problem, bulges and dimples live on the symmetric
//! part of a quarter cell. Every branch is traced by long tangent steps to its two ends, which are
//! located directly (a fold where du0 turns, a breaking of symmetry where an eigenvalue vanishes),
//! and where the surface lands is learnt from a release. A loop of any drive, or the state under
//! the slider, is then read off. The walk is the reference, and a test holds the two together.

mod explorer;
mod read_off;
mod trace;

pub(super) use explorer::{Explorer, FLAT_KICK, Fall, KICK, angle};
pub use read_off::{Branch, Cycle, End, Leg, Place, Point};
pub(super) use read_off::{Support, Traversal};

use super::flat_branch::FlatBranch;
use super::record::Share;
use crate::numerics::threads::Cancel;
use crate::physics::body::Body;
use crate::physics::control::Control;
use crate::physics::indenter::Indenter;
use crate::physics::law::Law;
use crate::physics::mesh::{Grid, SAFE, next_fast, points_at};
use crate::physics::pattern::Pattern;
use crate::physics::system::{State, System, carried};
use crate::scene::{Model, Points, Scene, Turn};
use crate::solver::mechanics::Mechanics;
use crate::solver::method::Lost;
use crate::solver::sector::{Node, SHARP, Sector, Side};
use explorer::{Rest, pattern_of};
use read_off::node_between;
use std::fmt;
use std::sync::Arc;
use trace::{adapt, both_ways};

/// What an atlas is made for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meshes {
    /// Side L of the cell (length).
    pub length: f64,
    /// The cohesive law.
    pub law: Law,
    /// Points along a side of the whole cell, for bulge and dimple; a multiple of 8.
    pub square: usize,
    /// Points along the whole line, for ridges; a multiple of 4.
    pub line: usize,
    /// What drives the body.
    pub control: Control,
}

impl Meshes {
    /// For a law in a square cell of side `length` on `n` points along it.
    pub fn new(law: &Law, length: f64, n: usize) -> Self {
        Self {
            length,
            law: *law,
            square: n,
            line: next_fast(n + n / 3),
            control: Control::Displacement,
        }
    }

    /// Points along a side of the cell in which a surface falls.
    fn falls(&self) -> usize {
        points_at(&self.law, self.length, SAFE)
            .max(LEAST)
            .min(self.square)
    }

    /// The same of a body that is driven by `control`.
    pub fn under(self, control: Control) -> Self {
        Self { control, ..self }
    }
}

/// Fewest points along a side of the cell in which a surface falls; else the mesh that is just safe
/// is fine enough to learn in which pattern it comes to rest.
const LEAST: usize = 32;
/// How a surface is helped over an edge to see where it falls: how far beyond it, in units of the
/// control. Right at the edge it lands where it would; further on it falls also from where the edge
/// is not known so well, but may miss what lives only next to it.
const ATTEMPTS: [f64; 4] = [0.0, 0.002, 0.02, 0.1];
/// States of one pattern at one control that are no farther apart (ranges of u0) are of one branch:
/// between two branches lies what is unstable.
const SAME: f64 = 0.1;

/// Why an atlas cannot answer: the walk can.
#[derive(Clone, Debug, PartialEq)]
pub struct Unmapped {
    /// What it does not hold.
    pub what: String,
    /// At which u0 (length), if at one.
    pub at: Option<f64>,
}

impl Unmapped {
    /// What is not held anywhere.
    pub(crate) fn anywhere(what: impl Into<String>) -> Self {
        Self {
            what: what.into(),
            at: None,
        }
    }

    /// What is not held at `u0`.
    pub(super) fn at(u0: f64, what: impl Into<String>) -> Self {
        Self {
            what: what.into(),
            at: Some(u0),
        }
    }
}

impl fmt::Display for Unmapped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.at {
            Some(u0) => write!(f, "{}, at u0 = {u0:.4}", self.what),
            None => f.write_str(&self.what),
        }
    }
}

impl std::error::Error for Unmapped {}

/// The known branches of one scene, and where each end leads.
#[derive(Clone, Debug)]
pub struct Atlas {
    meshes: Meshes,
    pub(super) ridge: Sector,
    pub(super) square: Sector,
    explorer: Explorer,
    flat: FlatBranch,
    cancel: Cancel,
    /// Shared with the clones of the atlas.
    pub(super) branches: Vec<Arc<Branch>>,
    /// Where the surface lands: lower and upper limit of the flat state, then lower and upper end
    /// of each branch.
    landings: Vec<[Option<Place>; 2]>,
    /// Where it may land from the lower and the upper limit of the flat state, most often first.
    from_limits: [Vec<Fall>; 2],
}

impl Atlas {
    /// An atlas without branches; they are found as a loop asks for them.
    pub fn new(meshes: Meshes) -> Self {
        let Meshes {
            length,
            law,
            square,
            line,
            control,
        } = meshes;
        let falls = meshes.falls();
        Self {
            meshes,
            ridge: Sector::ridge(length, line, law),
            square: Sector::square(length, square, law),
            explorer: Explorer::new(
                System::even(Grid::square(length, falls), law, &Indenter::Flat)
                    .with_control(control),
            ),
            flat: FlatBranch::new(law, length, control),
            cancel: Cancel::default(),
            branches: Vec::new(),
            landings: vec![[None; 2]],
            from_limits: Default::default(),
        }
    }

    /// Why no atlas holds a scene, on whatever mesh; `None` if one may.
    pub fn refusal(scene: &Scene) -> Option<Unmapped> {
        let reason = if scene.body != Body::HalfSpace {
            "the atlas holds the patterns of a half-space"
        } else if scene.indenter != Indenter::Flat {
            "uneven ground has no branches of known symmetry"
        } else if matches!(scene.cell.points, Points::Line(_)) {
            "the atlas holds square cells; a line cell is small enough as it is"
        } else if scene.drive.turn == Turn::ZeroLoad {
            "the atlas holds drives to a fixed turning point"
        } else {
            return None;
        };
        Some(Unmapped::anywhere(reason))
    }

    /// The atlas of a scene on its own mesh; of no use where there is a [refusal](Atlas::refusal).
    pub fn of(scene: &Scene, model: &Model) -> Self {
        let meshes = Meshes::new(&model.law, model.grid.length, model.grid.nx);
        Self::new(meshes.under(scene.control()))
    }

    /// Lets `cancel` interrupt every solve from now on; what is under way is then lost.
    pub fn obey(&mut self, cancel: &Cancel) {
        for sector in [&mut self.ridge, &mut self.square] {
            sector.mechanics.cancel = cancel.clone();
        }
        self.explorer.mechanics.cancel = cancel.clone();
        self.cancel = cancel.clone();
    }

    /// What it was made for.
    pub fn meshes(&self) -> &Meshes {
        &self.meshes
    }

    /// The branches found so far.
    pub fn branches(&self) -> &[Arc<Branch>] {
        &self.branches
    }

    /// Transforms spent so far: on the line, on the quarter cell, and there on releases.
    pub fn transforms(&self) -> [usize; 3] {
        [
            &self.ridge.mechanics,
            &self.square.mechanics,
            &self.explorer.mechanics,
        ]
        .map(Mechanics::transforms)
    }

    /// The flat state.
    pub fn flat(&self) -> &FlatBranch {
        &self.flat
    }

    /// Where the surface lands when `place` ends on the way up or down.
    ///
    /// # Errors
    /// A landing or a branch that no sector holds.
    fn landing(&mut self, place: Place, side: Side) -> Result<Place, Unmapped> {
        let (row, end) = (place.row(), side.index());
        if let Some(known) = self.landings[row][end] {
            return Ok(known);
        }
        if self.fades(place, side) {
            return Ok(Place::Flat(side));
        }
        let from = self.end_state(place, side);
        let onwards = side.sign() * self.meshes.control.unit(&self.meshes.law);
        let mut refusal = Unmapped::at(from.mean_displacement, "the surface falls nowhere");
        // Where waves soften the limits of the flat state are known exactly.
        let is_exact = matches!(place, Place::Flat(_)) && !self.flat.gives_way_as_a_block();
        for beyond in &ATTEMPTS {
            if self.cancel.requested() {
                break;
            }
            let (rest, from) = if is_exact {
                let u0 = from.mean_displacement + beyond * side.sign() * self.meshes.law.range;
                let flat = self.explorer.system().uniform(u0).state;
                (self.off_flat(side, u0), flat)
            } else {
                let (z, mode) = self.kick(place, side)?;
                let control = from.control + beyond * onwards;
                (self.explorer.release(&z, &mode, control), from.clone())
            };
            // At the limit itself it rests where it is if a pattern comes out of it continuously.
            let stays = rest.pattern == Pattern::Flat;
            match self.settle(&from, rest) {
                Ok(next) if next != place => {
                    self.landings[row][end] = Some(next);
                    return Ok(next);
                }
                Ok(_) => {}
                Err(error) => refusal = error,
            }
            if is_exact && !stays {
                break;
            }
        }
        Err(refusal)
    }

    /// The state where `place` ends, without its amplitudes.
    fn end_state(&self, place: Place, side: Side) -> State {
        match place {
            Place::Flat(_) => {
                let (low, high) = self.flat.limits().expect("an end was asked for");
                // The upper limit ends the way down, the lower the way up.
                let limit = if side == Side::Upper { low } else { high };
                self.at(place, limit)
            }
            Place::On(i) => self.branches[i].end(side).state.under(self.meshes.control),
        }
    }

    /// Where most mixtures of the soft modes lead from a limit `u0` of the flat state; all are
    /// remembered.
    fn off_flat(&mut self, side: Side, u0: f64) -> Rest {
        let found = self.explorer.off_flat(u0);
        let most = found[0].rest.clone();
        self.from_limits[side.index()] = found;
        most
    }

    /// The loops from `start` to `turn` and back for each landing of each contested limit of the
    /// flat state, and the share of that landing; none where no limit that was passed is contested.
    pub fn contested_cycles(
        &mut self,
        start: f64,
        turn: f64,
    ) -> Vec<(Share, Result<Cycle, Unmapped>)> {
        let mut cycles = Vec::new();
        for side in Side::BOTH {
            let all = self.from_limits[side.index()].clone();
            for Fall { share, rest, .. } in if all.len() > 1 { all } else { Vec::new() } {
                let usual = self.landings[0][side.index()];
                let from = self.end_state(Place::Flat(side.opposite()), side);
                let cycle = self.settle(&from, rest).and_then(|place| {
                    self.landings[0][side.index()] = Some(place);
                    self.cycle(start, turn)
                });
                self.landings[0][side.index()] = usual;
                cycles.push((share, cycle));
            }
        }
        cycles
    }

    /// Where a limit of the flat state leads, if that is contested.
    fn contested(&self, place: Place, side: Side) -> Vec<Share> {
        let all = &self.from_limits[side.index()];
        if matches!(place, Place::Flat(_)) && all.len() > 1 {
            all.iter().map(|fall| fall.share).collect()
        } else {
            Vec::new()
        }
    }

    /// The state at the end of a place and the mode along which it gives way, on the mesh for
    /// releases: of the flat state as a block.
    fn kick(&self, place: Place, side: Side) -> Result<(Vec<f64>, Vec<f64>), Unmapped> {
        let (explorer, control) = (&self.explorer, self.meshes.control);
        let Place::On(i) = place else {
            let from = self.end_state(place, side);
            let mut z = vec![0.0; explorer.system().dimension()];
            let mut block = z.clone();
            [_, z[0]] = control.balanced(from.mean_displacement, from.stress);
            block[0] = 1.0;
            return Ok((z, block));
        };
        let branch = &self.branches[i];
        let node = branch.end(side);
        let sector = self.sector(branch.pattern);
        let own = sector.system();
        let mut mode = match branch.ends[side.index()] {
            End::Fold | End::Flat => carried(&node.tangent, own, explorer.system()),
            End::Breaking if node.breaks_oddly => {
                let u0 = node.u0();
                return Err(Unmapped::at(
                    u0,
                    "the ridge meanders, which only the whole cell holds",
                ));
            }
            End::Breaking => sector.breaking_mode(node, explorer.system()),
        };
        let mut z = carried(&node.state.amplitudes, own, explorer.system());
        [_, z[0]] = control.balanced(node.u0(), node.state.stress);
        // A tangent is per unit of u0; that of a fold of u0 leaves it.
        if control.frees_mean() && branch.ends[side.index()] == End::Fold && node.slope.is_finite()
        {
            mode[0] = 1.0;
        }
        Ok((z, mode))
    }

    /// The place of a state at rest, fallen `from` another at the same control: a known branch, or a
    /// new one traced from it both ways.
    fn settle(&mut self, from: &State, rest: Rest) -> Result<Place, Unmapped> {
        let (law, control, u0) = (self.meshes.law, from.control, rest.mean_displacement);
        let most = from.energy + 1e-6 * law.surface_energy;
        let pattern = rest.pattern;
        match pattern {
            Pattern::Flat
                if self.flat.is_stable(u0)
                    || self.meshes.control.is_apart(&law, self.meshes.length, u0) =>
            {
                return Ok(Place::Flat(self.flat.side_of(u0)));
            }
            Pattern::Flat => return Err(Unmapped::at(u0, "no rest was found")),
            Pattern::Other => {
                return Err(Unmapped::at(
                    u0,
                    "the surface comes to rest without the symmetry of a known pattern",
                ));
            }
            _ => {}
        }
        let known = (0..self.branches.len()).find(|&i| {
            let (b, there) = (&self.branches[i], self.at(Place::On(i), control));
            b.pattern == pattern
                && self.covers(i, control)
                && (there.mean_displacement - u0).abs() < SAME * law.range
                && there.energy <= most
        });
        if let Some(i) = known {
            // Where Newton fails from so good a guess, the interpolated energy stands.
            let _ = self.pin(i, control);
            return Ok(Place::On(i));
        }
        let driven = self.meshes.control;
        let onto = self.sector(pattern).system();
        let z = carried(&rest.amplitudes, self.explorer.system(), onto);
        let sector = self.sector_mut(pattern);
        let lost = |error: Lost| {
            Unmapped::at(
                u0,
                format!("the {pattern} could not be followed ({error:?})"),
            )
        };
        let settled = sector.settle(u0, z).ok_or(Lost::Gone);
        let (mut first, fields) = settled
            .and_then(|z| sector.node(u0, z, None, SHARP))
            .map_err(lost)?;
        let there = first.state.under(driven);
        // On its own mesh it is a little beside the control of the release.
        let beside = control - there.control;
        let energy = there.energy + beside * driven.conjugate(u0, there.stress);
        let unstable = first.own <= 0.0 || driven.softens([1.0, first.slope]);
        if !(energy <= most) || unstable {
            return Err(Unmapped::at(
                u0,
                format!("the {pattern} is not what the release found"),
            ));
        }
        sector.sharpen(&mut first, &fields);
        if first.breaking < 0.0 {
            return Err(Unmapped::at(u0, format!("the {pattern} is unstable")));
        }
        let (nodes, ends) = both_ways(sector, driven, first).map_err(lost)?;
        self.branches.push(Arc::new(Branch {
            pattern,
            nodes,
            ends,
        }));
        self.landings.push([None; 2]);
        Ok(Place::On(self.branches.len() - 1))
    }

    /// Makes the state of branch `i` at this value of the control, whose energy enters a jump, a
    /// node, unless there is one close by.
    fn pin(&mut self, i: usize, control: f64) -> Result<(), Lost> {
        let near = 1e-3 * self.meshes.law.range;
        if !self.covers(i, control) {
            return Ok(());
        }
        let branch = &self.branches[i];
        let u0 = branch.place(self.meshes.control, control);
        let is_near = |n: &Node| n.slope.is_finite() && (n.u0() - u0).abs() < near;
        if branch.nodes.iter().any(is_near) {
            return Ok(());
        }
        let (branch, pattern) = (branch.clone(), branch.pattern);
        let node = node_between(
            self.sector_mut(pattern),
            branch.segment(u0),
            u0,
            None,
            SHARP,
        )?;
        Arc::make_mut(&mut self.branches[i]).insert(node.0);
        Ok(())
    }

    /// The pattern of `place` at `u0`, by its topology: a dimple that grows ends as a bulge.
    fn pattern_at(&mut self, place: Place, u0: f64) -> Pattern {
        let Place::On(i) = place else {
            return Pattern::Flat;
        };
        let branch = &self.branches[i];
        if branch.is_ridge() {
            return Pattern::Ridge;
        }
        // Where it fades there is none: that of the node next to it.
        let [low, high] = Side::BOTH.map(|side| branch.beside(side).u0());
        let u0 = match branch.ends {
            [End::Flat, _] if u0 < low => low,
            [_, End::Flat] if u0 > high => high,
            _ => u0,
        };
        pattern_of(&mut self.square.mechanics, &branch.guess(u0), u0)
    }

    /// The solver of the states of this pattern.
    fn sector(&self, pattern: Pattern) -> &Sector {
        match pattern {
            Pattern::Ridge => &self.ridge,
            _ => &self.square,
        }
    }

    pub(super) fn sector_mut(&mut self, pattern: Pattern) -> &mut Sector {
        match pattern {
            Pattern::Ridge => &mut self.ridge,
            _ => &mut self.square,
        }
    }

    /// Amplitudes of `place` where the control has this `value`, on another mesh of the same cell: a
    /// guess from which Newton's method finds the state.
    pub fn guess(&self, place: Place, value: f64, onto: &System) -> Vec<f64> {
        let State {
            mean_displacement: u0,
            stress,
            ..
        } = self.at(place, value);
        let mut z = match place {
            Place::Flat(_) => vec![0.0; onto.dimension()],
            Place::On(i) => carried(&self.branches[i].guess(u0), self.system_of(i), onto),
        };
        [_, z[0]] = self.meshes.control.balanced(u0, stress);
        z
    }

    /// The mechanics of branch `i`.
    pub(super) fn system_of(&self, i: usize) -> &System {
        self.sector(self.branches[i].pattern).system()
    }

    /// The same branches on `n` points a side, if surfaces fall on the same mesh as in this one: then
    /// they come to rest in the same patterns.
    pub fn refined(&self, n: usize) -> Option<Self> {
        let Meshes {
            law,
            length,
            control,
            ..
        } = self.meshes;
        let meshes = Meshes::new(&law, length, n).under(control);
        let alike = meshes.falls() == self.meshes.falls();
        alike.then(|| self.adapted(meshes).ok()).flatten()
    }

    /// The same branches for `meshes`, whose law and cell should differ by a few percent at most.
    /// Landings are taken over as they are: the caller compares the order of jumps before and
    /// after.
    ///
    /// # Errors
    /// A branch that was not found again; then a new atlas must be made.
    pub fn adapted(&self, meshes: Meshes) -> Result<Self, Lost> {
        let mut new = Self::new(meshes);
        new.obey(&self.cancel);
        let landings = |i: usize| -> Vec<f64> {
            self.landed()
                .filter(|l| l.2 == i)
                .map(|l| {
                    let control = self.end_state(l.0, l.1).control;
                    self.branches[i].place(self.meshes.control, control)
                })
                .collect()
        };
        for (i, old) in self.branches.iter().enumerate() {
            let (from, to) = (self.sector(old.pattern), new.sector_mut(old.pattern));
            let branch = adapt(old, &landings(i), meshes.control, from, to)?;
            new.branches.push(Arc::new(branch));
        }
        new.landings.clone_from(&self.landings);
        new.from_limits.clone_from(&self.from_limits);
        let (from, to) = (self.explorer.system(), new.explorer.system());
        for Fall { rest, .. } in new.from_limits.iter_mut().flatten() {
            if !rest.amplitudes.is_empty() {
                rest.amplitudes = carried(&rest.amplitudes, from, to);
            }
        }
        for (place, side, i) in self.landed() {
            if matches!(place, Place::Flat(_)) && new.flat.limits().is_none() {
                return Err(Lost::Gone);
            }
            new.pin(i, new.end_state(place, side).control)?;
        }
        Ok(new)
    }

    /// The known landings on branches: place, its end, and the branch landed on.
    fn landed(&self) -> impl Iterator<Item = (Place, Side, usize)> + '_ {
        self.landings.iter().enumerate().flat_map(|(row, ends)| {
            Side::BOTH.into_iter().filter_map(move |side| {
                let place = match row {
                    0 => Place::Flat(side.opposite()),
                    _ => Place::On(row - 1),
                };
                match ends[side.index()] {
                    Some(Place::On(i)) => Some((place, side, i)),
                    _ => None,
                }
            })
        })
    }
}
