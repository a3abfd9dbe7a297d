//! A loop of the atlas as a record: every increment a state solved, measured and watched, like the walk's.

use super::cycle::Journey;
use super::{Atlas, End, Leg, Place, Unmapped};
use crate::experiment::flat_branch::FlatBranch;
use crate::experiment::record::{Branch, LoopRecord, StateRecord};
use crate::experiment::run::{Landing, LoopRun, Outcome, Report};
use crate::experiment::scene::{Model, Scene};
use crate::experiment::walk::guard::Guard;
use crate::experiment::walk::{Counts, slides_on};
use crate::numerics::cancel::Cancel;
use crate::physics::pattern::{Pattern, classify, contact_area};
use crate::physics::system::carried;
use crate::solver::Stop;
use crate::solver::sector::Node;
use crate::solver::stability::Tracker;
use ndarray::Array2;
use rand::SeedableRng;
use rand_pcg::Pcg64;
use std::time::Instant;

/// Largest distance, in ranges, between two looks at the whole cell.
const INTERVAL: f64 = 0.25;
/// Distance from a fold of the last state before it, in steps.
const HAIR: f64 = 1e-3;
/// Residual of every recorded state.
const TOLERANCE: f64 = 1e-6;

impl Atlas {
    /// The closed loop of `scene` from its start to `turn` and back in the scene's steps, every state solved and handed out.
    ///
    /// # Errors
    /// A state that is not stable against all modes of the whole cell, or not found: the walk must be asked.
    pub fn tour(
        &mut self,
        scene: &Scene,
        turn: f64,
        model: &Model,
        cancel: &Cancel,
        observe: &mut dyn FnMut(Report<'_>),
    ) -> Result<LoopRun, Unmapped> {
        let law = model.law;
        let well = law.at(law.equilibrium_gap()).stiffness;
        let tracker = Tracker::new(Pcg64::seed_from_u64(scene.seed));
        let start = scene.drive.start;
        let mut journey = Journey::new(self, start, turn)?;
        self.obey(cancel);
        let mut tour = Tour {
            atlas: self,
            model,
            guard: Guard::new(model, 0.25 * well, slides_on(model), tracker),
            flat: FlatBranch::new(law, model.grid.length),
            last: None,
            watched: None,
        };
        let mut run =
            LoopRun { record: LoopRecord::default(), outcome: Outcome::Completed, counts: Counts::default(), landings: Vec::new() };
        while let Some(leg) = journey.leg(tour.atlas) {
            let fold = tour.fold(&leg);
            for (i, u0) in stations(&leg, start, scene.drive.step, fold).enumerate() {
                let told = tour.state(&leg, u0, cancel);
                if cancel.requested() {
                    break;
                }
                let (state, gap) = told?;
                let half = (start - u0) / (start - turn);
                let fraction = 0.5 * if leg.direction == Branch::Approach { half } else { 2.0 - half };
                observe(Report::State { record: &state, fraction });
                run.counts.patterned_increments += usize::from(state.pattern != Pattern::Flat);
                if i == 0 && leg.begins {
                    let (branch, pattern) = (state.branch, state.pattern);
                    run.landings.push(Landing { branch, mean_displacement: u0, pattern, gap });
                }
                run.record.states.push(state);
            }
            let jump = journey.jump(tour.atlas);
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
            journey.closed()?;
        }
        run.counts.transforms = tour.transforms();
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
    /// Where the whole cell was last looked at and found no softer than its even part.
    watched: Option<f64>,
}

impl Tour<'_> {
    fn transforms(&self) -> usize {
        self.atlas.transforms().iter().sum::<usize>() + self.guard.transforms()
    }

    /// True if the leg runs into a fold.
    fn fold(&self, leg: &Leg) -> bool {
        let Place::On(i) = leg.place else { return false };
        let branch = &self.atlas.branches[i];
        let (low, high) = branch.extent();
        (leg.to == low && branch.ends[0] == End::Fold) || (leg.to == high && branch.ends[1] == End::Fold)
    }

    fn state(&mut self, leg: &Leg, u0: f64, cancel: &Cancel) -> Result<(StateRecord, Array2<f64>), Unmapped> {
        let began = Instant::now();
        let spent = self.transforms();
        let law = self.model.law;
        let length = self.model.grid.length;
        let mut record = StateRecord { branch: leg.direction, ..StateRecord::placeholder(u0) };
        let gap;
        match leg.place {
            Place::Flat => {
                let state = self.flat.state(u0, 0);
                let stiffness = state.stiffness_min.expect("closed form");
                // At its limits the flat state is neutral: the last digit must not call it unstable.
                let neutral = stiffness.value.abs() * length < 1e-6;
                (record.stress, record.energy, record.residual) = (state.stress, state.energy, 0.0);
                (record.stiffness_min, record.stiffness_error) = (stiffness.value * length, 0.0);
                (record.pattern, record.model) = (Pattern::Flat, "flat, closed form");
                record.contact_area = f64::from(u8::from(u0 < law.contact_gap()));
                record.stop = if neutral { Stop::Stable } else { state.stop };
                gap = Array2::from_elem(self.model.grid.shape(), u0);
            }
            Place::On(i) => {
                let branch = &self.atlas.branches[i];
                let (guess, is_ridge) = (branch.guess(u0), branch.is_ridge);
                let before = self.last.take().filter(|(place, _)| *place == leg.place).map(|(_, node)| node);
                let sector = if is_ridge { &mut self.atlas.ridge } else { &mut self.atlas.square };
                let end = u0 == leg.to && [branch.extent().0, branch.extent().1].contains(&u0);
                let measured = sector
                    .measure(u0, guess, before.as_ref(), TOLERANCE)
                    .map_err(|lost| Unmapped(format!("the state at u0 = {u0:.4} was not found ({lost:?})")))?;
                let square = self.atlas.square.system();
                let z = carried(&measured.node.z, self.atlas.system_of(i), square);
                gap = square.unfolded(&square.gap_field(&z, u0));
                let mut stiffness = measured.stiffness;
                if before.is_none() {
                    self.guard.reset();
                    self.watched = None;
                }
                // Where no other mode is softer than the even ones, which are measured at every state, a look now and then will do.
                let all = match self.watched.filter(|at| (at - u0).abs() < INTERVAL * law.range && !end) {
                    Some(_) => stiffness,
                    None => self.guard.check(&gap, u0, cancel),
                };
                if all.value >= 0.9 * stiffness.value && self.watched.is_none_or(|at| (at - u0).abs() >= INTERVAL * law.range) {
                    self.watched = Some(u0);
                } else if all.value < 0.9 * stiffness.value {
                    self.watched = None;
                }
                if all.value < -all.error && all.value < stiffness.value && stiffness.value > 0.02 / length && !cancel.requested() {
                    return Err(Unmapped(format!("at u0 = {u0:.4} a mode goes soft that is not mirror-symmetric")));
                }
                if all.value < stiffness.value && all.value > 0.0 {
                    stiffness = all;
                }
                (record.stress, record.energy, record.residual) = (measured.node.stress, measured.node.energy, measured.residual);
                (record.stiffness_min, record.stiffness_error) = (stiffness.value * length, stiffness.error * length);
                record.pattern = classify(gap.view(), &law, true);
                record.model = if is_ridge { "ridge on half a line" } else { "quarter cell" };
                record.contact_area = contact_area(gap.view(), &law);
                // An end is where the eigenvalue vanishes: its sign there is a matter of the last digit.
                let neutral = end && stiffness.value.abs() * length < 0.02;
                record.stop = match (record.residual <= TOLERANCE, stiffness.is_stable() || neutral) {
                    (true, true) => Stop::Stable,
                    (true, false) => Stop::Unstable,
                    (false, _) => Stop::NotConverged,
                };
                self.last = Some((leg.place, measured.node));
            }
        }
        record.stress_over_max = record.stress / law.traction_max();
        record.transforms = self.transforms() - spent;
        record.milliseconds = began.elapsed().as_secs_f64() * 1e3;
        Ok((record, gap))
    }
}

/// The u0 of a leg's states: where it begins (a landing, or the start), the points start - k x step, and where it ends. The turning
/// point is not repeated. Towards a `fold`, where the stress falls off like a square root, they close in, and stop a hair before it:
/// on the other side there is nothing.
fn stations(leg: &Leg, start: f64, step: f64, fold: bool) -> impl Iterator<Item = f64> {
    let (from, to) = (leg.from, leg.to);
    let (low, high) = (from.min(to), from.max(to));
    let near = 1e-9 * step;
    let (top, bottom) = (((start - high) / step).floor() as i64, ((start - low) / step).ceil() as i64);
    let mut inner: Vec<f64> = (top..=bottom).map(|k| start - k as f64 * step).collect();
    let onwards = if to > from { step } else { -step };
    let last = if fold { to - HAIR * onwards } else { to };
    if fold {
        inner.extend([0.4, 0.1, 0.02].map(|share| to - share * onwards));
    }
    inner.retain(|u| *u > low + near && *u < high - near && (u - last) * onwards < 0.0);
    inner.sort_by(|a, b| if onwards > 0.0 { a.total_cmp(b) } else { b.total_cmp(a) });
    let ends = (to != from).then_some(last);
    leg.begins.then_some(from).into_iter().chain(inner).chain(ends)
}
