//! The atlas of branches: on flat ground a loop is a handful of branches, each followed once.
//!
//! Flat states are a closed form, ridges a line problem, bulges and dimples live on the symmetric
//! part of a quarter cell. Every branch is traced by long tangent steps to its two ends, which are
//! located directly (a fold where du0 turns, a breaking of symmetry where an eigenvalue vanishes),
//! and where the surface lands is learnt from a release. A loop of any drive, or the state under
//! the slider, is then read off. The walk is the reference, and a test holds the two together.

mod adapt;
mod curve;
mod cycle;
mod explorer;
mod trace;

pub(super) use curve::Support;
pub use curve::{Branch, Point};
pub(super) use cycle::Traversal;
pub use cycle::{Cycle, Leg, Place};
pub(super) use explorer::{Explorer, Rest};
pub use trace::End;

use super::contest::{Share, shares};
use crate::numerics::cancel::Cancel;
use crate::physics::grid::Grid;
use crate::physics::indenter::Indenter;
use crate::physics::law::Law;
use crate::physics::pattern::Pattern;
use crate::physics::system::{System, carried};
use crate::physics::theory::flat;
use crate::scene::mesh::next_fast;
use crate::solver::Lost;
use crate::solver::mechanics::Mechanics;
use crate::solver::sector::{NODE, Node, Sector, Side};
use std::fmt;
use trace::trace;

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
}

impl Meshes {
    /// For a law in a square cell of side `length` on `n` points along it.
    pub fn new(law: &Law, length: f64, n: usize) -> Self {
        Self {
            length,
            law: *law,
            square: n,
            line: next_fast(n + n / 3),
        }
    }
}

/// How a surface is helped over an edge to see where it falls: how far beyond it (ranges). Right at
/// the edge it lands where it would; further on it falls also from where the edge is not known so
/// well, but may miss what lives only next to it.
const ATTEMPTS: [f64; 4] = [0.0, 0.002, 0.02, 0.1];

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
    flat_limits: Option<(f64, f64)>,
    cancel: Cancel,
    pub(super) branches: Vec<Branch>,
    /// Where the surface lands: lower and upper limit of the flat state, then lower and upper end
    /// of each branch.
    landings: Vec<[Option<Place>; 2]>,
    /// Where it may land from the lower and the upper limit of the flat state, most often first.
    from_limits: [Vec<(Share, Rest)>; 2],
}

impl Atlas {
    /// An atlas without branches; they are found as a loop asks for them.
    pub fn new(meshes: Meshes) -> Self {
        let Meshes {
            length,
            law,
            square,
            line,
        } = meshes;
        Self {
            meshes,
            ridge: Sector::ridge(length, line, law),
            square: Sector::square(length, square, law),
            explorer: Explorer::new(System::even(
                Grid::square(length, square),
                law,
                &Indenter::Flat,
            )),
            flat_limits: flat::limits(&law, length),
            cancel: Cancel::default(),
            branches: Vec::new(),
            landings: vec![[None; 2]],
            from_limits: Default::default(),
        }
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
    pub fn branches(&self) -> &[Branch] {
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

    /// Lower and upper limit of the flat state (length); `None` where it is always stable.
    pub fn flat_limits(&self) -> Option<(f64, f64)> {
        self.flat_limits
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
        let (u0, energy) = self.end_point(place, side);
        let onwards = side.sign() * self.meshes.law.range;
        let mut refusal = Unmapped::at(u0, "the surface falls nowhere");
        // The limits of the flat state are known exactly.
        let attempts = if place == Place::Flat {
            &ATTEMPTS[..1]
        } else {
            &ATTEMPTS[..]
        };
        for beyond in attempts {
            if self.cancel.requested() {
                break;
            }
            let rest = match place {
                Place::Flat => self.off_flat(side, u0 + beyond * onwards),
                Place::On(i) => {
                    let (z, mode) = self.kick(i, side)?;
                    self.explorer.release(&z, &mode, u0 + beyond * onwards)
                }
            };
            match self.settle(u0, energy, rest) {
                Ok(next) if next != place => {
                    self.landings[row][end] = Some(next);
                    return Ok(next);
                }
                Ok(_) => {}
                Err(error) => refusal = error,
            }
        }
        Err(refusal)
    }

    /// u0 and energy where `place` ends.
    fn end_point(&self, place: Place, side: Side) -> (f64, f64) {
        match place {
            Place::Flat => {
                let (low, high) = self.flat_limits.expect("an end was asked for");
                // The upper limit ends the way down, the lower the way up.
                let u0 = if side == Side::Upper { low } else { high };
                (u0, self.meshes.law.at(u0).energy)
            }
            Place::On(i) => {
                let node = self.branches[i].end(side);
                (node.state.mean_displacement, node.state.energy)
            }
        }
    }

    /// Where most mixtures of the soft modes lead from a limit of the flat state; all are
    /// remembered.
    fn off_flat(&mut self, side: Side, u0: f64) -> Rest {
        let rests = self.explorer.off_flat(u0);
        let shares = shares(&rests.iter().map(Rest::pattern).collect::<Vec<_>>());
        let first = |share: Share| {
            let rest = rests
                .iter()
                .find(|rest| rest.pattern() == share.pattern)
                .cloned()
                .expect("it was counted");
            (share, rest)
        };
        let found: Vec<_> = shares.into_iter().map(first).collect();
        let most = found[0].1.clone();
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
            for (share, rest) in if all.len() > 1 { all } else { Vec::new() } {
                let usual = self.landings[0][side.index()];
                let (u0, energy) = self.end_point(Place::Flat, side);
                let cycle = self.settle(u0, energy, rest).and_then(|place| {
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
        if place == Place::Flat && all.len() > 1 {
            all.iter().map(|(share, _)| *share).collect()
        } else {
            Vec::new()
        }
    }

    /// The state at the end of branch `i` and the mode along which it gives way, on the mesh for
    /// releases.
    fn kick(&self, i: usize, side: Side) -> Result<(Vec<f64>, Vec<f64>), Unmapped> {
        let explorer = &self.explorer;
        let branch = &self.branches[i];
        let node = branch.end(side);
        let sector = if branch.is_ridge {
            &self.ridge
        } else {
            &self.square
        };
        let own = sector.system();
        let mode = match branch.ends[side.index()] {
            End::Fold => carried(&node.tangent, own, explorer.system()),
            End::Breaking if node.breaks_oddly => {
                let u0 = node.state.mean_displacement;
                return Err(Unmapped::at(
                    u0,
                    "the ridge meanders, which only the whole cell holds",
                ));
            }
            End::Breaking => sector.breaking_mode(node, explorer.system()),
        };
        Ok((
            carried(&node.state.amplitudes, own, explorer.system()),
            mode,
        ))
    }

    /// The place of a state at rest: a known branch, or a new one traced from it both ways.
    fn settle(&mut self, u0: f64, energy_before: f64, rest: Rest) -> Result<Place, Unmapped> {
        let gamma = self.meshes.law.surface_energy;
        let (is_ridge, pattern, landed) = match rest {
            Rest::Flat => {
                let stable = flat::stiffness_min(&self.meshes.law, self.meshes.length, u0) > 0.0;
                return if stable {
                    Ok(Place::Flat)
                } else {
                    Err(Unmapped::at(u0, "no rest was found"))
                };
            }
            Rest::Ridge(line) => (true, Pattern::Ridge, line),
            Rest::Square(pattern, z) => (false, pattern, z),
            Rest::Other => {
                return Err(Unmapped::at(
                    u0,
                    "the surface comes to rest without the symmetry of a known pattern",
                ));
            }
        };
        let known = (0..self.branches.len()).find(|&i| {
            let b = &self.branches[i];
            b.is_ridge == is_ridge
                && b.pattern == pattern
                && b.covers(u0)
                && b.at(u0).energy <= energy_before + 1e-6 * gamma
        });
        if let Some(i) = known {
            // Where Newton fails from so good a guess, the interpolated energy stands.
            let _ = self.pin(i, u0);
            return Ok(Place::On(i));
        }
        let sector = if is_ridge {
            &mut self.ridge
        } else {
            &mut self.square
        };
        let z = carried(&landed, self.explorer.system(), sector.system());
        let lost = |error: Lost| {
            Unmapped::at(
                u0,
                format!("the {pattern} could not be followed ({error:?})"),
            )
        };
        let settled = sector.settle(u0, z).ok_or(Lost::Gone);
        let (mut first, fields) = settled
            .and_then(|z| sector.node(u0, z, None, NODE))
            .map_err(lost)?;
        if !(first.state.energy <= energy_before + 1e-6 * gamma) || first.own <= 0.0 {
            return Err(Unmapped::at(
                u0,
                format!("the {pattern} is not what the release found"),
            ));
        }
        sector.sharpen(&mut first, &fields);
        if first.breaking < 0.0 {
            return Err(Unmapped::at(u0, format!("the {pattern} is unstable")));
        }
        let regular = |nodes: &[Node]| nodes.first().filter(|n| n.slope.is_finite()).cloned();
        let ((mut nodes, below), (after, above)) = match trace(sector, &first, None, Side::Lower) {
            Ok(down) => {
                let up =
                    trace(sector, &first, regular(&down.0).as_ref(), Side::Upper).map_err(lost)?;
                (down, up)
            }
            // Right above a fold only the way up is open, and tells where the fold is.
            Err(_) => {
                let up = trace(sector, &first, None, Side::Upper).map_err(lost)?;
                (
                    trace(sector, &first, regular(&up.0).as_ref(), Side::Lower).map_err(lost)?,
                    up,
                )
            }
        };
        nodes.reverse();
        nodes.push(first);
        nodes.extend(after);
        self.branches.push(Branch {
            pattern,
            is_ridge,
            nodes,
            ends: [below, above],
        });
        self.landings.push([None; 2]);
        Ok(Place::On(self.branches.len() - 1))
    }

    /// Makes `u0`, whose energy enters a jump, a node of branch `i`, unless there is one close by.
    fn pin(&mut self, i: usize, u0: f64) -> Result<(), Lost> {
        let near = 1e-3 * self.meshes.law.range;
        let branch = &self.branches[i];
        if !branch.covers(u0)
            || branch
                .nodes
                .iter()
                .any(|n| n.slope.is_finite() && (n.state.mean_displacement - u0).abs() < near)
        {
            return Ok(());
        }
        let guess = branch.guess(u0);
        let sector = if branch.is_ridge {
            &mut self.ridge
        } else {
            &mut self.square
        };
        let (node, _) = sector.node(u0, guess, None, NODE)?;
        self.branches[i].insert(node);
        Ok(())
    }

    /// The pattern of `place` at `u0`, by its topology on the mesh for releases: a dimple that
    /// grows ends as a bulge.
    fn pattern_at(&mut self, place: Place, u0: f64) -> Pattern {
        let Place::On(i) = place else {
            return Pattern::Flat;
        };
        let branch = &self.branches[i];
        if branch.is_ridge {
            return Pattern::Ridge;
        }
        let z = carried(
            &branch.guess(u0),
            self.square.system(),
            self.explorer.system(),
        );
        self.explorer.pattern(&z, u0)
    }

    fn sector_of(&self, branch: &Branch) -> &Sector {
        if branch.is_ridge {
            &self.ridge
        } else {
            &self.square
        }
    }

    /// The mechanics of branch `i`.
    pub(super) fn system_of(&self, i: usize) -> &System {
        self.sector_of(&self.branches[i]).system()
    }
}
