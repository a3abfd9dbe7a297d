//! A loop of the atlas as a record: every increment a state solved, measured and watched, like the
//! walk's.

use super::atlas::{Atlas, End, Leg, Place, Traversal, Unmapped};
use super::flat_branch::FlatBranch;
use super::record::{Direction, StateRecord};
use super::run::{Landing, LoopRun, Outcome, Report};
use super::walk::symmetry::{Guard, slides_on};
use crate::numerics::cancel::Cancel;
use crate::physics::control::Control;
use crate::physics::pattern::{Pattern, classify, contact_area};
use crate::physics::system::{System, carried};
use crate::scene::part::Part;
use crate::scene::{Model, Scene};
use crate::solver::Stop;
use crate::solver::mechanics::Mechanics;
use crate::solver::sector::{Measured, Node};
use crate::solver::stability::Tracker;
use ndarray::Array2;
use rand::SeedableRng;
use rand_pcg::Pcg64;
use std::time::Instant;

/// Distance from a jump of the last state before it, in ranges: half the walk's bracket, and more
/// than the jump is uncertain.
const HAIR: f64 = 5e-5;
/// An eigenvalue (E*/L) below which a branch is at its end.
const SOFT: f64 = 0.02;
/// Residual of every recorded state.
const TOLERANCE: f64 = 1e-6;

impl Atlas {
    /// The closed loop of `scene` from its start to `turn` and back in the scene's steps, every
    /// state solved and handed out.
    ///
    /// # Errors
    /// A state that is not stable against all modes of the whole cell, or not found: the walk must
    /// be asked.
    pub fn tour(
        &mut self,
        scene: &Scene,
        turn: f64,
        model: &Model,
        cancel: &Cancel,
        observe: &mut dyn FnMut(Report<'_>),
    ) -> Result<LoopRun, Unmapped> {
        let law = model.law;
        let tracker = Tracker::new(Pcg64::seed_from_u64(scene.seed));
        let start = scene.drive.start;
        let mut traversal = Traversal::new(self, start, turn)?;
        self.obey(cancel);
        let mut whole = Mechanics::new(
            System::new(model.grid, model.law, &model.indenter),
            slides_on(model),
        );
        whole.cancel = cancel.clone();
        let mut tour = Tour {
            atlas: self,
            model,
            guard: Guard::new(whole, tracker),
            flat: FlatBranch::new(law, model.grid.length, Control::Displacement),
            last: None,
        };
        let mut run = LoopRun::empty();
        while let Some(leg) = traversal.leg(tour.atlas) {
            let edge = traversal.jumps_next().then_some(HAIR * law.range);
            for (i, u0) in
                stations(&leg, start, scene.drive.step, edge, tour.fold(&leg)).enumerate()
            {
                let told = tour.state(&leg, u0);
                if cancel.requested() {
                    break;
                }
                let (state, gap) = told?;
                let half = (start - u0) / (start - turn);
                let fraction = 0.5
                    * if leg.direction == Direction::Approach {
                        half
                    } else {
                        2.0 - half
                    };
                observe(Report::State {
                    record: &state,
                    index: run.record.states.len(),
                    fields: [&gap; 2],
                    fraction,
                });
                run.counts.patterned_increments += usize::from(state.pattern != Pattern::Flat);
                if i == 0 && leg.begins {
                    let (direction, pattern) = (state.direction, state.pattern);
                    run.landings.push(Landing {
                        direction,
                        mean_displacement: u0,
                        pattern,
                        gap,
                    });
                }
                run.record.states.push(state);
            }
            let jump = traversal.jump(tour.atlas);
            if cancel.requested() {
                run.outcome = Outcome::Cancelled;
                break;
            }
            if let Some(jump) = jump? {
                observe(Report::Jump(&jump));
                run.record.jumps.push(jump);
            }
        }
        if run.outcome == Outcome::Completed {
            traversal.closed()?;
        }
        (run.counts.transforms, run.counts.proof_transforms) =
            (tour.transforms(), tour.guard.proof_transforms());
        Ok(run)
    }
}

/// What a tour carries along.
struct Tour<'a> {
    atlas: &'a mut Atlas,
    model: &'a Model,
    guard: Guard,
    flat: FlatBranch,
    /// Place and node of the state before.
    last: Option<(Place, Node)>,
}

impl Tour<'_> {
    fn transforms(&self) -> usize {
        self.atlas.transforms().iter().sum::<usize>() + self.guard.transforms()
    }

    /// True if the leg runs into a fold.
    fn fold(&self, leg: &Leg) -> bool {
        let Place::On(i) = leg.place else {
            return false;
        };
        let branch = &self.atlas.branches[i];
        let (low, high) = branch.extent();
        (leg.to == low && branch.ends[0] == End::Fold)
            || (leg.to == high && branch.ends[1] == End::Fold)
    }

    /// The state of `leg` at `u0`, with its gap field.
    fn state(&mut self, leg: &Leg, u0: f64) -> Result<(StateRecord, Array2<f64>), Unmapped> {
        let began = Instant::now();
        let spent = self.transforms();
        let mut record = StateRecord {
            direction: leg.direction,
            ..StateRecord::placeholder(u0)
        };
        let gap = match leg.place {
            Place::Flat => self.flat(&mut record),
            Place::On(i) => self.patterned(i, &mut record)?,
        };
        record.stress_over_max = record.stress / self.model.law.traction_max();
        record.contact_area = contact_area(gap.view(), &self.model.law);
        record.transforms = self.transforms() - spent;
        record.milliseconds = began.elapsed().as_secs_f64() * 1e3;
        Ok((record, gap))
    }

    fn flat(&self, record: &mut StateRecord) -> Array2<f64> {
        let flat = self
            .flat
            .state(&self.guard.mechanics.system, record.mean_displacement);
        let stiffness = flat.stiffness_min.expect("closed form");
        (record.stress, record.energy, record.residual) =
            (flat.state.stress, flat.state.energy, flat.residual);
        (record.stiffness_min, record.stiffness_error) =
            (stiffness.value * self.model.grid.length, stiffness.error);
        (record.pattern, record.part, record.stop) = (Pattern::Flat, Part::Flat, flat.stop);
        flat.fields.gap
    }

    fn patterned(&mut self, i: usize, record: &mut StateRecord) -> Result<Array2<f64>, Unmapped> {
        let (u0, length) = (record.mean_displacement, self.model.grid.length);
        let before = self
            .last
            .take()
            .filter(|(place, _)| *place == Place::On(i))
            .map(|(_, node)| node);
        if before.is_none() {
            self.guard.reset();
        }
        let branch = &self.atlas.branches[i];
        let (guess, is_ridge) = (branch.guess(u0), branch.is_ridge);
        let sector = if is_ridge {
            &mut self.atlas.ridge
        } else {
            &mut self.atlas.square
        };
        let Measured {
            node,
            residual,
            mut stiffness,
            ..
        } = sector
            .measure(u0, guess, before.as_ref(), TOLERANCE)
            .map_err(|lost| Unmapped::at(u0, format!("the state was not found ({lost:?})")))?;
        let square = self.atlas.square.system();
        let z = carried(&node.state.amplitudes, self.atlas.system_of(i), square);
        let gap = square.unfolded(&square.gap_field(&z, u0));
        let all = self.guard.check(&gap, u0);
        let cancelled = self.guard.mechanics.cancel.requested();
        // Right at an end the mesh of the whole cell may call it a hair sooner than that of the
        // branch.
        let at_end = stiffness.value * length <= SOFT;
        if all.value < 0.0 && !at_end && !cancelled {
            return Err(Unmapped::at(
                u0,
                "a mode goes soft that is not mirror-symmetric",
            ));
        }
        if all.value.is_nan() && !cancelled {
            return Err(Unmapped::at(
                u0,
                "the stability against all modes was not decided",
            ));
        }
        if all.value >= 0.0 {
            stiffness = stiffness.among(all);
        }
        (record.stress, record.energy, record.residual) =
            (node.state.stress, node.state.energy, residual);
        (record.stiffness_min, record.stiffness_error) =
            (stiffness.value * length, stiffness.error * length);
        record.pattern = classify(gap.view(), &self.model.law, true);
        record.part = if is_ridge { Part::Ridge } else { Part::Quarter };
        // The residual is within tolerance, or there would be no state.
        record.stop = if stiffness.is_stable() {
            Stop::Stable
        } else {
            Stop::Unstable
        };
        self.last = Some((Place::On(i), node));
        Ok(gap)
    }
}

/// The u0 of a leg's states: where it begins (a landing, or the start), the points start - k x
/// step, and where it ends. The turning point is not repeated. Where the leg ends in a jump the
/// last state stands the distance `edge` before it: at the edge itself an eigenvalue vanishes, and
/// beyond there may be nothing. Towards a `fold`, where the stress falls off like a square root,
/// states close in.
fn stations(
    leg: &Leg,
    start: f64,
    step: f64,
    edge: Option<f64>,
    fold: bool,
) -> impl Iterator<Item = f64> {
    let (from, to) = (leg.from, leg.to);
    let onwards = if to > from { 1.0 } else { -1.0 };
    let last = to - onwards * edge.unwrap_or(0.0);
    let (top, bottom) = (
        ((start - from.max(to)) / step).floor() as i64,
        ((start - from.min(to)) / step).ceil() as i64,
    );
    let mut inner: Vec<f64> = (top..=bottom).map(|k| start - k as f64 * step).collect();
    if fold {
        inner.extend([0.4, 0.1, 0.02].map(|share| to - share * step * onwards));
    }
    let near = 1e-9 * step;
    inner.retain(|u| (u - from) * onwards > near && (last - u) * onwards > near);
    inner.sort_by(|a, b| (a * onwards).total_cmp(&(b * onwards)));
    let ends = ((last - from) * onwards > 0.0).then_some(last);
    leg.begins
        .then_some(from)
        .into_iter()
        .chain(inner)
        .chain(ends)
}
