//! A loop of the atlas as a record: every increment a state solved, measured and watched, like the
//! walk's.

use super::atlas::{Atlas, End, Leg, Place, Traversal, Unmapped};
use super::record::{Direction, StateRecord};
use super::run::{Landing, LoopRun, Outcome, Report};
use super::walk::flat::apart;
use super::walk::symmetry::{Guard, Soft, slides_on};
use crate::numerics::threads::Cancel;
use crate::physics::pattern::{Pattern, classify, contact_area};
use crate::physics::system::{System, carried};
use crate::scene::{Model, Part, Scene};
use crate::solver::mechanics::Mechanics;
use crate::solver::method::{History, Stop, distance};
use crate::solver::sector::{Measured, Node};
use ndarray::Array2;
use std::time::Instant;

/// Distance from a jump of the last state before it, in units of the control: half the walk's
/// bracket, and more than the jump is uncertain.
const HAIR: f64 = 5e-5;
/// An eigenvalue (E*/L) below which a branch is at its end.
const SOFT: f64 = 0.02;
/// Residual of every recorded state.
const TOLERANCE: f64 = 1e-6;
/// How often a state is sought at fixed u0 until its control is the one that was asked for, as far
/// as the residual lets its stress be known.
const ROUNDS: usize = 8;
/// Longest step in that search, in ranges.
const NEXT: f64 = 1e-2;

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
        let start = scene.drive.start;
        let mut traversal = Traversal::new(self, start, turn)?;
        self.obey(cancel);
        let mut whole = Mechanics::new(
            System::new(model.grid, model.law, &model.indenter).with_control(scene.control()),
            slides_on(model),
        );
        whole.cancel = cancel.clone();
        let even = self.square.system().clone().with_control(scene.control());
        let mut tour = Tour {
            atlas: self,
            model,
            guard: Guard::new(&even, whole.slides, scene.seed),
            whole,
            last: None,
            history: History::default(),
            extrapolates: false,
        };
        tour.guard.cancel = cancel.clone();
        let mut run = LoopRun::empty();
        while let Some(leg) = traversal.leg(tour.atlas) {
            let edge = traversal
                .jumps_next()
                .then_some(HAIR * scene.control().unit(&law));
            for (i, value) in
                stations(&leg, start, scene.drive.step, edge, tour.fold(&leg)).enumerate()
            {
                let told = tour.state(&leg, value);
                if cancel.requested() {
                    break;
                }
                let (state, gap) = told?;
                let half = (start - value) / (start - turn);
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
                    run.landings.push(Landing {
                        direction: state.direction,
                        pattern: state.pattern,
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
    /// Of flat states.
    whole: Mechanics,
    /// Place and node of the state before.
    last: Option<(Place, Node)>,
    /// States of the same branch before, and whether they foretold the last one better than its
    /// curve did.
    history: History,
    extrapolates: bool,
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
        let [low, high] = self.atlas.extent(i);
        (leg.to == low && branch.ends[0] == End::Fold)
            || (leg.to == high && branch.ends[1] == End::Fold)
    }

    /// The state of `leg` where the control has this `value`, with its gap field.
    fn state(&mut self, leg: &Leg, value: f64) -> Result<(StateRecord, Array2<f64>), Unmapped> {
        let began = Instant::now();
        let spent = self.transforms();
        let mut record = StateRecord {
            direction: leg.direction,
            control: value,
            ..StateRecord::placeholder(self.atlas.at(leg.place, value).mean_displacement)
        };
        let gap = match leg.place {
            Place::Flat(_) => self.flat(&mut record),
            Place::On(i) => self.patterned(i, leg, &mut record)?,
        };
        record.stress_over_max = record.stress / self.model.law.traction_max();
        record.contact_area = contact_area(gap.view(), &self.model.law);
        record.transforms = self.transforms() - spent;
        record.milliseconds = began.elapsed().as_secs_f64() * 1e3;
        Ok((record, gap))
    }

    fn flat(&mut self, record: &mut StateRecord) -> Array2<f64> {
        let mechanics = &mut self.whole;
        let u0 = record.mean_displacement;
        let flat = if mechanics.system.control().is_apart(&self.model.law, u0) {
            apart(mechanics, record.control)
        } else {
            self.atlas.flat().state(&mechanics.system, u0)
        };
        let stiffness = flat.stiffness_min.expect("closed form");
        let driven = self.atlas.meshes().control;
        (record.stress, record.energy, record.residual) = (
            flat.state.stress,
            flat.state.body_energy(driven),
            flat.residual,
        );
        (record.stiffness_min, record.stiffness_error) = (
            stiffness.value * self.model.grid.length,
            stiffness.error * self.model.grid.length,
        );
        (record.pattern, record.part, record.stop) = (Pattern::Flat, Part::Flat, flat.stop);
        flat.fields.gap
    }

    /// The state of branch `i` at `u0`, from its curve or from the states before, whichever is nearer
    /// as it seems; from the other where there is none.
    fn nearest(&mut self, i: usize, u0: f64, before: Option<&Node>) -> Result<Measured, Unmapped> {
        let curve = self.atlas.branches[i].guess(u0);
        let mut guesses: Vec<Vec<f64>> = self
            .history
            .predict(u0)
            .into_iter()
            .chain([curve])
            .collect();
        if !self.extrapolates {
            guesses.reverse();
        }
        let mut found = self.measure(i, u0, guesses[0].clone(), before);
        if let Some(other) = guesses.get(1) {
            match &found {
                Ok(measured) => {
                    let z = &measured.node.state.amplitudes;
                    self.extrapolates ^= distance(other, z) < distance(&guesses[0], z);
                }
                Err(_) => found = self.measure(i, u0, other.clone(), before),
            }
        }
        found
    }

    fn measure(
        &mut self,
        i: usize,
        u0: f64,
        guess: Vec<f64>,
        before: Option<&Node>,
    ) -> Result<Measured, Unmapped> {
        let pattern = self.atlas.branches[i].pattern;
        let sector = self.atlas.sector_mut(pattern);
        sector
            .measure(u0, guess, before, TOLERANCE)
            .map_err(|lost| Unmapped::at(u0, format!("the state was not found ({lost:?})")))
    }

    /// The state of branch `i` with the control of `record`, with its evidence.
    fn found(
        &mut self,
        i: usize,
        before: Option<&Node>,
        record: &mut StateRecord,
    ) -> Result<Measured, Unmapped> {
        let control = self.atlas.meshes().control;
        let near = TOLERANCE * control.unit(&self.model.law);
        // d control/du0, which vanishes where the control turns back; then by secants.
        let slope = self.atlas.branches[i].at(record.mean_displacement).slope;
        let [mut rate, _] = control.balanced(1.0, slope);
        let mut last: Option<[f64; 2]> = None;
        let mut measured = self.nearest(i, record.mean_displacement, before)?;
        for _ in 0..ROUNDS {
            let u0 = record.mean_displacement;
            let [value, _] = control.balanced(u0, measured.node.state.stress);
            let off = record.control - value;
            if off.abs() <= near {
                return Ok(measured);
            }
            if let Some([u, value_then]) = last {
                rate = (value - value_then) / (u0 - u);
            }
            last = Some([u0, value]);
            let longest = NEXT * self.model.law.range;
            record.mean_displacement += (off / rate).clamp(-longest, longest);
            let guess = measured.node.state.amplitudes;
            measured = self.measure(i, record.mean_displacement, guess, before)?;
        }
        let u0 = record.mean_displacement;
        Err(Unmapped::at(u0, "the state was not found at its control"))
    }

    fn patterned(
        &mut self,
        i: usize,
        leg: &Leg,
        record: &mut StateRecord,
    ) -> Result<Array2<f64>, Unmapped> {
        let length = self.model.grid.length;
        let before = self
            .last
            .take()
            .filter(|(place, _)| *place == Place::On(i))
            .map(|(_, node)| node);
        if before.is_none() {
            self.history = History::default();
            self.guard.reset();
        }
        let Measured {
            node,
            residual,
            mut stiffness,
            known,
            mut fields,
        } = self.found(i, before.as_ref(), record)?;
        let (u0, is_ridge) = (record.mean_displacement, self.atlas.branches[i].is_ridge());
        let driven = self.atlas.meshes().control;
        let square = self.atlas.square.system();
        let z = carried(&node.state.amplitudes, self.atlas.system_of(i), square);
        let gap = square.unfolded(&square.gap_field(&z, u0));
        // Of a ridge at fixed u0 these are all modes already.
        let all = if is_ridge && !driven.frees_mean() {
            stiffness
        } else {
            let mut z = z;
            let [control, mean] = driven.balanced(u0, node.state.stress);
            z[0] = mean;
            let soft = if is_ridge {
                fields = self.guard.fields(&z, control);
                Soft::Mode(stiffness.value, &[])
            } else {
                Soft::Classes(&known)
            };
            self.guard.check(soft, &z, &fields)
        };
        let cancelled = self.guard.cancel.requested();
        // Right at an end the mesh of the whole cell may call it a hair sooner than that of the
        // branch.
        let edge = 2.0 * HAIR * driven.unit(&self.model.law);
        let at_end = stiffness.value * length <= SOFT
            || driven.frees_mean() && (record.control - leg.to).abs() <= edge;
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
        self.history.push(&node.state);
        self.last = Some((Place::On(i), node));
        Ok(gap)
    }
}

/// The control of a leg's states: where it begins (a landing, or the start), the points start - k x
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
