//! The energy landscape around a state: over which saddles its neighbours are reached, how high
//! they are, and the path of steepest descent from each to both sides.
//!
//! The saddles are the states of the diagram with one negative eigenvalue over all modes of the
//! whole cell, at the value of the control at which the state stands.

use crate::follow::diagram::{Diagram, Piece, negative_modes};
use crate::follow::record::StateRecord;
use crate::numerics::dense::{add, norm, scale};
use crate::numerics::threads::Cancel;
use crate::physics::control::Control;
use crate::physics::indenter::Indenter;
use crate::physics::law::Law;
use crate::physics::pattern::{Pattern, classify};
use crate::physics::system::{Evaluation, State, System};
use crate::scene::{Model, Scene};
use crate::solver::Lost;
use crate::solver::continuation::way;
use crate::solver::mechanics::Mechanics;
use crate::solver::release::steepest_descent;
use ndarray::Array2;
use std::f64::consts::PI;
use std::sync::Arc;

/// How closely the control of a saddle is that of the state (its units): its energy then errs by
/// this share of the stress's work over a range.
const PLACED: f64 = 1e-9;
/// Most trials to place it.
const TRIALS: usize = 20;
/// Largest difference between two descriptions of one state, on meshes that differ, in stress over
/// sigma_max and energy over gamma. Two stable states are never so near but where one becomes two.
const SAME: f64 = 5e-3;
/// Largest difference in energy between copies of one saddle by symmetry (gamma): ten times what
/// [`PLACED`] leaves open.
const COPY: f64 = 1e-8;
/// Unstable states that a path may come to by symmetry before it is given up.
const LEGS: usize = 4;
/// Largest traction over the load below which a body is off.
const OFF: f64 = 0.05;
/// Most points along a side of a picture.
const PICTURE: usize = 128;
/// A state nearer than this to where it ends (units of the control) is looked at so far before it:
/// there the barrier is a millionth, and the path the one that it takes when it gives way.
pub const BEFORE: f64 = 1e-3;
/// Largest change of a state on that way, as [`SAME`]: at a fold it goes as the root of the way.
const CHANGED: f64 = 0.1;
/// Points of a barrier along the control.
const CURVE: usize = 60;
/// Places towards each end at which it is looked whether the saddle still leads from the state.
const LOOKS: usize = 3;

/// A state with one negative eigenvalue, and what lies on both sides of it.
#[derive(Clone, Debug)]
pub struct Saddle {
    /// The name of its branch in the diagram.
    pub branch: String,
    /// The saddle itself.
    pub place: Place,
    /// The way down to each side, the minimum last, by the arc length from the saddle.
    pub sides: [Vec<Place>; 2],
}

/// The saddles at one value of the control.
#[derive(Clone, Debug, Default)]
pub struct Saddles<'d> {
    /// Each with its piece of a branch.
    pub found: Vec<(Saddle, Piece<'d>)>,
    /// Which could not be followed, in words.
    pub missing: Vec<String>,
}

/// The ways out of a state.
#[derive(Clone, Debug, Default)]
pub struct Landscape {
    /// The value of the control, within [`BEFORE`] of the state's.
    pub control: f64,
    /// One for each saddle that leads from the state, the lowest first.
    pub passes: Vec<Pass>,
    /// What could not be found, in words.
    pub missing: Vec<String>,
}

/// The way out of a state over one saddle.
#[derive(Clone, Debug)]
pub struct Pass {
    /// The name of the saddle's branch in the diagram.
    pub branch: String,
    /// The neighbour's pattern.
    pub to: Pattern,
    /// From the state over the saddle to the neighbour.
    pub path: Vec<Place>,
    /// Which place is the saddle.
    pub saddle: usize,
    /// The barrier along the control, as far as this saddle leads from this state: the control's
    /// value, and energy per area.
    pub barriers: Vec<[f64; 2]>,
}

impl Pass {
    /// Energy per area of the saddle less that of the state (E* times length).
    pub fn barrier(&self) -> f64 {
        self.path[self.saddle].energy - self.path[0].energy
    }

    /// Energy per area of the state less that of its neighbour: what is released (E* times length).
    pub fn released(&self) -> f64 {
        self.path[0].energy - self.path[self.path.len() - 1].energy
    }
}

/// A place on a path.
#[derive(Clone, Debug)]
pub struct Place {
    /// Arc length from the state: root mean square way of the surface (length).
    pub arc: f64,
    /// Energy per area, that of the machine with it (E* times length).
    pub energy: f64,
    /// Mean displacement u0 (length).
    pub mean_displacement: f64,
    /// Mean stress (E*).
    pub stress: f64,
    /// The gap over the cell (length), for a picture: of a fine mesh every second point or fewer.
    pub gap: Arc<Array2<f64>>,
}

/// A state by what a drive measures of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Standing {
    /// The value of the control.
    pub control: f64,
    /// Mean stress (E*).
    pub stress: f64,
    /// Energy per area, that of the machine with it (E* times length).
    pub energy: f64,
}

impl Standing {
    /// Of a recorded state under this machine.
    pub fn of(state: &StateRecord, machine: Control) -> Self {
        Self {
            control: state.control,
            stress: state.stress,
            energy: state.energy + machine.energy(state.control, state.mean_displacement),
        }
    }

    /// What a piece of a branch has at a value of the control.
    pub fn on(piece: &Piece<'_>, control: f64) -> Self {
        let State { stress, energy, .. } = piece.at(control);
        Self {
            control,
            stress,
            energy,
        }
    }

    /// How far another state is from it: stress over sigma_max and energy over gamma.
    fn apart(&self, stress: f64, energy: f64, law: &Law) -> f64 {
        let stress = (stress - self.stress) / law.traction_max();
        stress.hypot((energy - self.energy) / law.surface_energy)
    }
}

/// The scene whose saddles are looked for.
#[derive(Clone, Copy)]
pub struct Ground<'s> {
    /// It.
    pub scene: &'s Scene,
    /// What it was decided to be.
    pub model: &'s Model,
    /// Its branches.
    pub diagram: &'s Diagram,
    /// Interrupts the search.
    pub cancel: &'s Cancel,
}

impl Landscape {
    /// Around a state. `observe` hears of what is found until then: first the passes, then how
    /// their barriers change along the control, of which one `before`, of a state on the same
    /// branches, may know some.
    ///
    /// # Errors
    /// Somebody asked to stop.
    pub fn around(
        ground: Ground<'_>,
        state: Standing,
        before: Option<&Self>,
        observe: &mut dyn FnMut(f64, &Self),
    ) -> Result<Self, Lost> {
        let state = ground.inside(state);
        let mut landscape = Self {
            control: state.control,
            ..Self::default()
        };
        let Saddles { found, missing } = ground.saddles(state.control)?;
        landscape.missing = missing;
        let passes = found.into_iter().filter_map(|(saddle, piece)| {
            let mut pass = ground.pass(saddle, state)?;
            let known = before.and_then(|before| before.barriers(&pass, state.control));
            pass.barriers = known.unwrap_or_default();
            Some((pass, piece))
        });
        let mut passes: Vec<(Pass, Piece<'_>)> = passes.collect();
        passes.sort_by(|(a, _), (b, _)| a.barrier().total_cmp(&b.barrier()));
        let pieces: Vec<Piece<'_>>;
        (landscape.passes, pieces) = passes.into_iter().unzip();
        let count = pieces.len() as f64;
        for (i, piece) in pieces.iter().enumerate() {
            observe(i as f64 / count, &landscape);
            let pass = &mut landscape.passes[i];
            if pass.barriers.is_empty() {
                pass.barriers = ground.barriers(state, piece)?;
            }
        }
        Ok(landscape)
    }

    /// The barriers of this pass, if it has them at this value of the control.
    fn barriers(&self, pass: &Pass, control: f64) -> Option<Vec<[f64; 2]>> {
        let same = |known: &&Pass| (&known.branch, known.to) == (&pass.branch, pass.to);
        let known = &self.passes.iter().find(same)?.barriers;
        let (first, last) = (known.first()?, known.last()?);
        (first[0] <= control && control <= last[0]).then(|| known.clone())
    }
}

impl<'s> Ground<'s> {
    /// All saddles at one value of the control.
    ///
    /// # Errors
    /// Somebody asked to stop.
    pub fn saddles(self, control: f64) -> Result<Saddles<'s>, Lost> {
        let mut saddles = Saddles::default();
        let mut known: Vec<f64> = Vec::new();
        for piece in self.diagram.pieces(1).filter(|piece| piece.holds(control)) {
            match self.saddle(&piece, control, &mut known) {
                Ok(Some(saddle)) => saddles.found.push((saddle, piece)),
                Ok(None) => {}
                Err(Lost::Cancelled) => return Err(Lost::Cancelled),
                Err(_) => {
                    let branch = &piece.branch.name;
                    let words = format!("what lies beyond the saddle on \"{branch}\"");
                    saddles.missing.push(words);
                }
            }
        }
        Ok(saddles)
    }

    /// The state, or the one next to it on its branch that has room to the end.
    fn inside(self, state: Standing) -> Standing {
        let law = &self.model.law;
        let room = BEFORE * self.scene.control().unit(law);
        let moved = self.diagram.pieces(0).filter_map(|piece| {
            let [low, high] = piece.extent();
            if high - low < 2.0 * room {
                return None;
            }
            let here = Standing::on(&piece, state.control.clamp(low + room, high - room));
            let apart = here.apart(state.stress, state.energy, law);
            let way = (here.control - state.control).abs();
            let most = if way > 0.0 { CHANGED } else { SAME };
            (way <= 2.0 * room && apart < most).then_some((apart, here))
        });
        let nearest = moved.min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.map_or(state, |(_, here)| here)
    }

    /// The stable piece of a branch on which a state is.
    pub(super) fn stable(self, state: Standing) -> Option<Piece<'s>> {
        let stable = self.diagram.pieces(0);
        let here = stable.filter(|piece| piece.holds(state.control));
        let apart = |piece: &Piece<'_>| {
            let at = piece.at(state.control);
            state.apart(at.stress, at.energy, &self.model.law)
        };
        let near = here.map(|piece| (apart(&piece), piece));
        let near = near.filter(|(apart, _)| *apart < SAME);
        let nearest = near.min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.map(|(_, piece)| piece)
    }

    /// The saddle of a piece at a value of the control, with both sides; `None` if its energy is
    /// among the `known` ones: copies of one saddle by symmetry are one.
    fn saddle(
        self,
        piece: &Piece<'_>,
        control: f64,
        known: &mut Vec<f64>,
    ) -> Result<Option<Saddle>, Lost> {
        let driven = self.scene.control();
        let mut mechanics = piece.branch.on_whole_cell(self.model, driven, self.cancel);
        let saddle = self.equilibrium(piece, control, &mut mechanics)?;
        let (energy, copy) = (saddle.state.energy, COPY * self.model.law.surface_energy);
        if known.iter().any(|other| (other - energy).abs() < copy) {
            return Ok(None);
        }
        known.push(energy);
        let modes = negative_modes(&mut mechanics, &saddle)?;
        let [mode] = &modes[..] else {
            return Err(Lost::Unstable);
        };
        let mut back = mode.clone();
        scale(&mut back, -1.0);
        Ok(Some(Saddle {
            branch: piece.branch.name.clone(),
            place: seen(&mechanics.system, &saddle, 0.0),
            sides: [
                down(&mut mechanics, &saddle, mode)?,
                down(&mut mechanics, &saddle, &back)?,
            ],
        }))
    }

    /// Which side of a saddle is the `state`, if one is.
    fn side(self, saddle: &Saddle, state: Standing) -> Option<usize> {
        let far = saddle.sides.each_ref().map(|way| {
            let end = &way[way.len() - 1];
            state.apart(end.stress, end.energy, &self.model.law)
        });
        let nearer = usize::from(far[1] < far[0]);
        (far[nearer] < SAME).then_some(nearer)
    }

    /// The pass over a saddle if one of its sides is the `state`.
    fn pass(self, saddle: Saddle, state: Standing) -> Option<Pass> {
        let side = self.side(&saddle, state)?;
        let Saddle {
            branch,
            place: top,
            sides: [one, other],
        } = saddle;
        let [near, beyond] = if side == 0 {
            [one, other]
        } else {
            [other, one]
        };
        let (saddle, length) = (near.len(), near[near.len() - 1].arc);
        let to = self.pattern(&beyond[beyond.len() - 1], state.control);
        let inward = near.into_iter().rev().map(|place| Place {
            arc: length - place.arc,
            ..place
        });
        let outward = [top].into_iter().chain(beyond).map(|place| Place {
            arc: length + place.arc,
            ..place
        });
        Some(Pass {
            branch,
            to,
            path: inward.chain(outward).collect(),
            saddle,
            barriers: Vec::new(),
        })
    }

    /// The pattern at a place; a body that a load lifts off is flat before long.
    pub fn pattern(self, place: &Place, control: f64) -> Pattern {
        let is_flat = self.model.indenter == Indenter::Flat;
        let is_load = self.scene.control() == Control::Load;
        if is_flat && is_load && place.stress < OFF * control {
            return Pattern::Flat;
        }
        classify(place.gap.view(), &self.model.law, is_flat)
    }

    /// The height of a piece of saddles over the stable piece of a state, as far on both sides of
    /// it as these saddles lead there: looked at in some places.
    fn barriers(self, state: Standing, saddles: &Piece<'_>) -> Result<Vec<[f64; 2]>, Lost> {
        let stable = self.stable(state);
        let Some((stable, ends)) = stable.and_then(|s| Some((s.clone(), s.common(saddles)?)))
        else {
            return Ok(Vec::new());
        };
        let mut reached = [state.control; 2];
        for (reached, end) in reached.iter_mut().zip(ends) {
            let mut holds = true;
            for look in 1..=LOOKS {
                // The last look is short of the end, where saddle and state may be one.
                let share = look as f64 / (LOOKS as f64 + 0.5);
                let control = state.control + share * (end - state.control);
                let there = Standing::on(&stable, control);
                match self.saddle(saddles, control, &mut Vec::new()) {
                    Ok(Some(saddle)) if self.side(&saddle, there).is_some() => *reached = control,
                    Err(Lost::Cancelled) => return Err(Lost::Cancelled),
                    _ => {
                        holds = false;
                        break;
                    }
                }
            }
            if holds {
                *reached = end;
            }
        }
        let [low, high] = reached;
        let at = |i: usize| {
            // Closer towards both ends, where it may vanish.
            let share = 0.5 - 0.5 * (PI * i as f64 / CURVE as f64).cos();
            let control = low + share * (high - low);
            [
                control,
                saddles.at(control).energy - stable.at(control).energy,
            ]
        };
        Ok((0..=CURVE).map(at).collect())
    }

    /// The equilibrium of a piece at the `value` of the control, in the mechanics so `driven`.
    pub(super) fn equilibrium(
        self,
        piece: &Piece<'_>,
        value: f64,
        driven: &mut Mechanics,
    ) -> Result<Evaluation, Lost> {
        let control = driven.system.control();
        let mut fixed = piece
            .branch
            .on_whole_cell(self.model, Control::Displacement, self.cancel);
        let ends = piece
            .around(value)
            .map(|point| piece.branch.surface(point, &mut fixed).state);
        let off =
            |state: &State| control.balanced(state.mean_displacement, state.stress)[0] - value;
        let mut chord = way(ends[0].joint(), ends[1].joint());
        let length = norm(&chord);
        scale(&mut chord, 1.0 / length);
        let (mut low, mut high) = ((0.0, off(&ends[0])), (length, off(&ends[1])));
        for _ in 0..TRIALS {
            let s = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
            let mut z = ends[0].amplitudes.clone();
            add(&mut z, s, &chord);
            z[0] = 0.0;
            let u0 = ends[0].mean_displacement + s * chord[0];
            let (knot, _) = fixed.knot(z, u0, &chord)?;
            let State {
                mean_displacement,
                stress,
                ..
            } = knot.state;
            let now = off(&knot.state);
            if now.abs() < PLACED * control.unit(&self.model.law) {
                let [value, mean] = control.balanced(mean_displacement, stress);
                let mut z = knot.state.amplitudes;
                z[0] = mean;
                return Ok(driven.at(z, value));
            }
            // Regula falsi after Illinois: an end that stays counts half.
            if now * high.1 < 0.0 {
                low = high;
            } else {
                low.1 *= 0.5;
            }
            high = (s, now);
        }
        Err(Lost::Gone)
    }
}

/// Down from a saddle to a minimum of all modes, in the order of the way; under a load that lifts
/// the body off as far as it is held.
fn down(mechanics: &mut Mechanics, saddle: &Evaluation, mode: &[f64]) -> Result<Vec<Place>, Lost> {
    let system = mechanics.system.clone();
    let mut places: Vec<Place> = Vec::new();
    let (mut from, mut mode) = (saddle.clone(), mode.to_vec());
    let (is_load, mut is_off) = (system.control() == Control::Load, false);
    for _ in 0..LEGS {
        let before = places.last().map_or(0.0, |place| place.arc);
        let mut observe = |at: &Evaluation, arc: f64| {
            places.push(seen(&system, at, before + arc));
            let pull = at.fields.traction.iter().copied().fold(0.0, f64::max);
            is_off = is_load && pull < OFF * at.state.control;
            !is_off
        };
        from = steepest_descent(mechanics, &from, &mode, &mut observe)?;
        if is_off {
            return Ok(places);
        }
        // Where symmetry keeps the path it may end on another saddle.
        let Some(next) = negative_modes(mechanics, &from)?.into_iter().next() else {
            return Ok(places);
        };
        mode = next;
    }
    Err(Lost::Unstable)
}

/// A surface as a place of a path.
fn seen(system: &System, at: &Evaluation, arc: f64) -> Place {
    let fine = system.unfolded(&at.fields.gap);
    let (rows, columns) = fine.dim();
    let every = columns.div_ceil(PICTURE);
    let shape = (rows.div_ceil(every), columns.div_ceil(every));
    let gap = Array2::from_shape_fn(shape, |(i, j)| fine[[i * every, j * every]]);
    Place {
        arc,
        energy: at.state.energy,
        mean_displacement: at.state.mean_displacement,
        stress: at.state.stress,
        gap: Arc::new(gap),
    }
}
