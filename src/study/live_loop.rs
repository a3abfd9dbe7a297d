//! A whole loop read off the atlas, as plain data: quick enough to follow a hand that drags a
//! parameter, and to say where the surface will stand before the walk has gone there.

use super::plan::rivals;
use crate::follow::atlas::{Atlas, Cycle, Meshes, Place, Unmapped};
use crate::follow::record::{Direction, JumpRecord, StateRecord};
use crate::follow::run::RivalLoop;
use crate::numerics::threads::Cancel;
use crate::physics::control::Control;
use crate::physics::law::Law;
use crate::physics::mesh;
use crate::physics::pattern::Pattern;
use crate::scene::{Model, Scene};
use crate::solver::sector::Side;
use std::f64::consts::PI;
use std::sync::Arc;

/// States sampled along one branch.
const SAMPLES: usize = 64;
/// States of one pattern that at the same control are no farther apart ([`Sample::apart`]) are of
/// one branch.
const SAME: f64 = 0.05;
/// Most points along a side: beyond it a loop takes too long to be live.
const POINTS_MAX: usize = 192;

/// How fine the mesh of the atlas is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Fineness {
    /// While the hand moves.
    Coarse,
    /// When it rests.
    Fine,
}

impl Fineness {
    /// Points along a side of a cell of this `length`.
    pub(super) fn points(self, law: &Law, length: f64) -> usize {
        mesh::points_at(law, length, self.mu_rho()).max(32)
    }

    /// The mesh number mu_rho that its mesh keeps.
    fn mu_rho(self) -> f64 {
        match self {
            Fineness::Coarse => 0.5,
            Fineness::Fine => 0.36,
        }
    }
}

/// One state of a branch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// What is driven: u0 or the position of the stage (length), or the load per area (E*).
    pub control: f64,
    /// u0 (length).
    pub mean_displacement: f64,
    /// Mean stress (E*).
    pub stress: f64,
    /// Smallest eigenvalue (E*/L), interpolated between the states of the branch.
    pub stiffness_min: f64,
}

/// A branch of stable states between its two ends.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Where it is in the atlas.
    pub place: Place,
    /// Its pattern.
    pub pattern: Pattern,
    /// By growing values of the control.
    pub samples: Vec<Sample>,
    /// The segment on which the surface lands when this one ends below, and above; `None` where the
    /// loop does not end it.
    pub next: [Option<usize>; 2],
}

/// A piece of the loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// Direction of the drive.
    pub direction: Direction,
    /// Index of the segment.
    pub segment: usize,
    /// The control where it begins.
    pub from: f64,
    /// The control where it ends.
    pub to: f64,
}

/// A place on the loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// Index of its piece.
    pub leg: usize,
    /// The control there.
    pub control: f64,
}

/// A closed loop with everything that is needed to draw it and to read it, and the atlas that holds
/// its states.
#[derive(Clone, Debug)]
pub struct LiveLoop {
    /// Of what it was read off.
    pub atlas: Arc<Atlas>,
    /// The law it belongs to, for the scales.
    pub law: Law,
    /// What is driven.
    pub control: Control,
    /// The branches it visits.
    pub segments: Vec<Segment>,
    /// Its pieces in order.
    pub legs: Vec<Leg>,
    /// Its jumps in order.
    pub jumps: Vec<JumpRecord>,
    /// Sum of the released energies, in units of gamma.
    pub dissipated_energy: f64,
    /// The loops of other landings, if it is contested where the surface lands; looked at when the
    /// hand rests.
    pub rivals: Vec<RivalLoop>,
    /// Expected relative error of that and of the jumps' places; 1 where nothing is promised.
    pub predicted_error: f64,
    /// Points along a side of the mesh it was computed on.
    pub points: usize,
}

/// Live loops one after the other: where law and cell are only a little different the last atlas is
/// taken over.
#[derive(Clone, Debug, Default)]
pub struct LiveLoops {
    last: Option<Last>,
    cancel: Cancel,
}

/// An atlas and the order of places in its loop.
#[derive(Clone, Debug)]
struct Last {
    atlas: Arc<Atlas>,
    order: Vec<Place>,
}

impl LiveLoops {
    /// Loops whose computation `cancel` interrupts; what is under way is then refused.
    pub fn obeying(cancel: &Cancel) -> Self {
        Self {
            last: None,
            cancel: cancel.clone(),
        }
    }

    /// The loop of a scene's drive. A fine one is always made afresh: landings that were taken over
    /// are then learnt again.
    ///
    /// # Errors
    /// Why the atlas does not hold this scene; the walk does.
    pub fn next(
        &mut self,
        scene: &Scene,
        model: &Model,
        fineness: Fineness,
    ) -> Result<LiveLoop, Unmapped> {
        let meshes = meshes_of(scene, model, fineness)?;
        let (start, turn) = (scene.drive.start, scene.depth());
        let last = self
            .last
            .take()
            .filter(|last| fineness == Fineness::Coarse && is_near(last.atlas.meshes(), &meshes));
        let adapted = last.and_then(|Last { atlas, order }| {
            let mut atlas = if *atlas.meshes() == meshes {
                Arc::unwrap_or_clone(atlas)
            } else {
                atlas.adapted(meshes).ok()?
            };
            let cycle = atlas.cycle(start, turn).ok()?;
            (places(&cycle) == order).then_some((atlas, cycle))
        });
        let (mut atlas, cycle) = match adapted {
            Some(found) => found,
            None => {
                let mut atlas = Atlas::new(meshes);
                atlas.obey(&self.cancel);
                let cycle = atlas.cycle(start, turn)?;
                (atlas, cycle)
            }
        };
        let rivals = match fineness {
            Fineness::Fine => rivals(&mut atlas, &cycle.jumps, start, turn),
            Fineness::Coarse => Vec::new(),
        };
        let atlas = Arc::new(atlas);
        let mut found = LiveLoop::read(&atlas, &cycle, start, turn);
        found.rivals = rivals;
        self.last = Some(Last {
            atlas,
            order: places(&cycle),
        });
        Ok(found)
    }
}

/// Largest change of law or cell, as a ratio, over which an atlas is taken over; over larger ones
/// its branches are mostly not found again.
const NEAR: f64 = 1.03;

fn is_near(a: &Meshes, b: &Meshes) -> bool {
    let close = |a: f64, b: f64| (a / b).max(b / a) <= NEAR;
    let kind = |meshes: &Meshes| meshes.control.word();
    let same = a.law.shape == b.law.shape && kind(a) == kind(b);
    same && (!a.control.frees_mean() || close(a.control.unit(&a.law), b.control.unit(&b.law)))
        && close(a.law.range, b.law.range)
        && close(a.law.surface_energy, b.law.surface_energy)
        && close(a.length, b.length)
}

fn places(cycle: &Cycle) -> Vec<Place> {
    cycle.legs.iter().map(|leg| leg.place).collect()
}

/// The atlas that a scene asks for.
fn meshes_of(scene: &Scene, model: &Model, fineness: Fineness) -> Result<Meshes, Unmapped> {
    if let Some(reason) = Atlas::refusal(scene) {
        return Err(reason);
    }
    let points = fineness.points(&model.law, model.grid.length);
    if points > POINTS_MAX {
        let why = format!("a live loop would need {points} points a side");
        return Err(Unmapped::anywhere(why));
    }
    Ok(Meshes::new(&model.law, model.grid.length, points).under(scene.control()))
}

impl LiveLoop {
    fn read(atlas: &Arc<Atlas>, cycle: &Cycle, start: f64, turn: f64) -> Self {
        let Meshes {
            law,
            length,
            square,
            control,
            ..
        } = *atlas.meshes();
        let mu_rho = mesh::mu_rho(&law, length / square as f64);
        let mut this = Self {
            atlas: atlas.clone(),
            law,
            control,
            segments: Vec::new(),
            legs: Vec::new(),
            jumps: cycle.jumps.clone(),
            dissipated_energy: cycle.dissipated_energy,
            rivals: Vec::new(),
            predicted_error: mesh::flat_error(&law, length, mu_rho),
            points: square,
        };
        let mut known: Vec<Place> = Vec::new();
        for leg in &cycle.legs {
            let segment = known.iter().position(|place| *place == leg.place);
            let segment = segment.unwrap_or_else(|| {
                known.push(leg.place);
                this.segments
                    .push(segment_of(atlas, leg.place, turn, start));
                known.len() - 1
            });
            this.legs.push(Leg {
                direction: leg.direction,
                segment,
                from: leg.from,
                to: leg.to,
            });
        }
        this.link();
        this
    }

    /// Says of every branch on which the surface lands when it ends.
    fn link(&mut self) {
        for pair in self.legs.windows(2) {
            if pair[0].segment != pair[1].segment {
                let side = usize::from(pair[0].direction == Direction::Retraction);
                self.segments[pair[0].segment].next[side] = Some(pair[1].segment);
            }
        }
    }

    /// The states of a piece, in the order they are passed.
    pub fn samples_of(&self, leg: &Leg) -> Vec<Sample> {
        let segment = &self.segments[leg.segment];
        let (low, high) = (leg.from.min(leg.to), leg.from.max(leg.to));
        let inner = segment
            .samples
            .iter()
            .copied()
            .filter(|s| s.control > low && s.control < high);
        let ends = [low, high].map(|end| segment.at(end));
        let mut samples: Vec<Sample> = std::iter::once(ends[0])
            .chain(inner)
            .chain([ends[1]])
            .collect();
        if leg.direction == Direction::Approach {
            samples.reverse();
        }
        samples
    }

    /// The points (u0, stress) of a piece, in the order they are passed.
    pub fn points_of(&self, leg: &Leg) -> Vec<[f64; 2]> {
        let samples = self.samples_of(leg).into_iter();
        samples.map(|s| [s.mean_displacement, s.stress]).collect()
    }

    /// The place that is passed in this direction where the control has this value, if the loop
    /// goes there.
    pub fn spot(&self, direction: Direction, control: f64) -> Option<Spot> {
        let passes = |leg: &Leg| {
            leg.direction == direction
                && (leg.from.min(leg.to)..=leg.from.max(leg.to)).contains(&control)
        };
        let leg = self.legs.iter().position(passes)?;
        Some(Spot { leg, control })
    }

    /// The place that is passed first in this direction where the mean displacement is `u0`
    /// (length), if the loop goes there.
    pub fn spot_of(&self, direction: Direction, u0: f64) -> Option<Spot> {
        let legs = self.legs.iter().enumerate();
        let mut gone = legs.filter(|(_, leg)| leg.direction == direction);
        gone.find_map(|(leg, piece)| {
            let samples = self.samples_of(piece);
            let pairs = samples.windows(2);
            let mut around = pairs.map(|pair| {
                let [a, b] = [pair[0].mean_displacement, pair[1].mean_displacement];
                let t = (u0 - a) / (b - a);
                let control = pair[0].control + t * (pair[1].control - pair[0].control);
                (0.0..=1.0).contains(&t).then_some(Spot { leg, control })
            });
            around.find_map(|spot| spot)
        })
    }

    /// The place that is drawn nearest to (u0, stress), where one unit along each axis is so much
    /// in `reach`; and how many such units it is away.
    pub fn nearest(&self, at: [f64; 2], reach: [f64; 2]) -> Option<(f64, Spot)> {
        let of_leg = |(leg, piece): (usize, &Leg)| {
            let samples = self.samples_of(piece);
            let near = samples.windows(2).map(|pair| {
                let [a, b] = [0, 1].map(|k| {
                    let Sample {
                        mean_displacement,
                        stress,
                        ..
                    } = pair[k];
                    [
                        (mean_displacement - at[0]) / reach[0],
                        (stress - at[1]) / reach[1],
                    ]
                });
                let way = [b[0] - a[0], b[1] - a[1]];
                let long = way[0] * way[0] + way[1] * way[1];
                let t = -(a[0] * way[0] + a[1] * way[1]) / long.max(f64::MIN_POSITIVE);
                let t = t.clamp(0.0, 1.0);
                let off = (a[0] + t * way[0]).hypot(a[1] + t * way[1]);
                let control = pair[0].control + t * (pair[1].control - pair[0].control);
                (off, Spot { leg, control })
            });
            near.min_by(|a, b| a.0.total_cmp(&b.0))
        };
        let legs = self.legs.iter().enumerate().filter_map(of_leg);
        legs.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// What the loop says of a place: the direction of the drive, the pattern, and the state
    /// interpolated on its branch.
    pub fn at(&self, spot: Spot) -> (Direction, Pattern, Sample) {
        let leg = &self.legs[spot.leg];
        let segment = &self.segments[leg.segment];
        (leg.direction, segment.pattern, segment.at(spot.control))
    }

    /// Where the surface will stand where the control is `target` if it goes there from `now`,
    /// with all jumps on the way. `None` if `now` is on none of the loop's branches, or the loop
    /// does not know the way.
    pub fn reading(&self, now: &StateRecord, target: f64) -> Option<(Pattern, Sample)> {
        let (here, margin) = (now.control, 0.01 * self.control.unit(&self.law));
        let off = |s: &Segment| {
            s.at(here)
                .apart([now.mean_displacement, now.stress], &self.law)
        };
        let same = |s: &&Segment| s.pattern == now.pattern && s.covers(here, margin);
        let start = self
            .segments
            .iter()
            .filter(same)
            .min_by(|a, b| off(a).total_cmp(&off(b)))?;
        if off(start) > SAME {
            return None;
        }
        let side = usize::from(target > here);
        let mut segment = start;
        // Every jump leads to a branch not yet passed.
        for _ in 0..=self.segments.len() {
            let (low, high) = segment.extent();
            let beyond = if side == 1 {
                target > high
            } else {
                target < low
            };
            match segment.next[side].filter(|_| beyond) {
                Some(next) => segment = &self.segments[next],
                None if segment.covers(target, margin) => {
                    return Some((segment.pattern, segment.at(target)));
                }
                None => return None,
            }
        }
        None
    }
}

impl Sample {
    /// How far another state, by u0 and stress, is from this one: in ranges, or in units of the
    /// largest traction, whichever is more.
    fn apart(&self, [u0, stress]: [f64; 2], law: &Law) -> f64 {
        let [du, ds] = [self.mean_displacement - u0, self.stress - stress];
        (du.abs() / law.range).max(ds.abs() / law.traction_max())
    }
}

impl Segment {
    /// The control at its lower and its upper end.
    pub fn extent(&self) -> (f64, f64) {
        let [first, last] = [0, self.samples.len() - 1].map(|i| self.samples[i].control);
        (first, last)
    }

    fn covers(&self, value: f64, margin: f64) -> bool {
        let (low, high) = self.extent();
        (low - margin..=high + margin).contains(&value)
    }

    /// Between its samples where the control has this `value`, or at its nearer end.
    pub fn at(&self, value: f64) -> Sample {
        let i = self
            .samples
            .partition_point(|s| s.control < value)
            .clamp(1, self.samples.len() - 1);
        let (a, b) = (self.samples[i - 1], self.samples[i]);
        let width = b.control - a.control;
        let t = if width > 0.0 {
            ((value - a.control) / width).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let between = |of: fn(&Sample) -> f64| of(&a) + t * (of(&b) - of(&a));
        Sample {
            control: value,
            mean_displacement: between(|s| s.mean_displacement),
            stress: between(|s| s.stress),
            stiffness_min: between(|s| s.stiffness_min),
        }
    }
}

/// Samples a place, densely towards both ends, where folds are steep.
fn segment_of(atlas: &Atlas, place: Place, turn: f64, start: f64) -> Segment {
    let Meshes {
        control, length, ..
    } = *atlas.meshes();
    let (pattern, [low, high]) = match (place, atlas.flat().limits()) {
        (Place::On(i), _) => (atlas.branches()[i].pattern, atlas.extent(i)),
        (Place::Flat(Side::Lower), Some((low, _))) => (Pattern::Flat, [turn, low]),
        (Place::Flat(Side::Upper), Some((_, high))) => (Pattern::Flat, [high, start]),
        (Place::Flat(_), None) => (Pattern::Flat, [turn, start]),
    };
    let stiffness = |u0: f64| match place {
        Place::Flat(_) => atlas.flat().stiffness(u0),
        Place::On(i) => atlas.branches()[i].softness(control, u0),
    };
    let samples = (0..=SAMPLES)
        .map(|k| {
            let value = low + (high - low) * 0.5 * (1.0 - (PI * k as f64 / SAMPLES as f64).cos());
            let at = atlas.at(place, value);
            Sample {
                control: value,
                mean_displacement: at.mean_displacement,
                stress: at.stress,
                stiffness_min: stiffness(at.mean_displacement) * length,
            }
        })
        .collect();
    Segment {
        place,
        pattern,
        samples,
        next: [None; 2],
    }
}
