//! A loop of the atlas as a record: every increment a state solved, measured and watched, like the
//! walk's. While one is proved stable the next is solved.

use super::atlas::{Atlas, End, Leg, Place, Traversal, Unmapped};
use super::record::{Direction, JumpRecord, StateRecord};
use super::run::{Landing, LoopRun, Outcome, Report};
use super::walk::flat::apart;
use super::walk::symmetry::{Guard, Soft, slides_on};
use crate::numerics::threads::{Cancel, handed_on};
use crate::physics::pattern::{Pattern, classify, contact_area};
use crate::physics::system::{Fields, System, carried};
use crate::scene::{Model, Part, Scene};
use crate::solver::class_proof::Known;
use crate::solver::mechanics::Mechanics;
use crate::solver::method::{History, Stiffness, Stop, distance};
use crate::solver::sector::{Measured, Node, Side};
use ndarray::Array2;
use std::time::Instant;

/// Distance from a jump of the last state before it, in units of the control: half the walk's
/// bracket, and more than the jump is uncertain.
const HAIR: f64 = 5e-5;
/// Distance from where a pattern fades of the states next to it, in units of the control: nearer, the
/// flat state is as good as they are within [`TOLERANCE`].
const FAINT: f64 = 1e-3;
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
    /// The closed loop of `scene` from its start to its turning point and back in the scene's steps,
    /// every state solved and handed out.
    ///
    /// # Errors
    /// A state that is not stable against all modes of the whole cell, or not found: the walk must
    /// be asked.
    pub fn tour(
        &mut self,
        scene: &Scene,
        model: &Model,
        cancel: &Cancel,
        observe: &mut dyn FnMut(Report<'_>),
    ) -> Result<LoopRun, Unmapped> {
        self.obey(cancel);
        let mut whole = Mechanics::new(
            System::new(model.grid, model.law, &model.indenter).with_control(scene.control()),
            slides_on(model),
        );
        whole.cancel = cancel.clone();
        let even = self.square.system().clone().with_control(scene.control());
        let mut guard = Guard::new(&even, whole.slides, scene.seed);
        guard.cancel = cancel.clone();
        let mut tour = Tour {
            atlas: self,
            model,
            whole,
            last: None,
            history: History::default(),
            extrapolates: false,
        };
        let mut run = LoopRun::of(scene.control());
        let mut ended = None;
        let points = even.dimension();
        let solve = |hand_on: &mut dyn FnMut(Step) -> bool| tour.go_round(scene, cancel, hand_on);
        let solved = handed_on(points, solve, |step| {
            match step {
                Step::Jump(jump) => {
                    observe(Report::Jump(&jump));
                    run.record.jumps.push(jump);
                }
                Step::State(found) => match found.proved(&mut guard, model.grid.length) {
                    _ if cancel.requested() => ended = Some(Ok(Outcome::Cancelled)),
                    Ok(found) => found.tell(scene, &mut run, observe),
                    Err(reason) => ended = Some(Err(reason)),
                },
            }
            ended.is_none()
        });
        run.outcome = ended.unwrap_or(solved)?;
        run.counts.proof_transforms = guard.proof_transforms();
        run.counts.transforms = tour.transforms() + guard.transforms();
        Ok(run)
    }
}

/// What a tour comes past.
enum Step {
    State(Box<Found>),
    Jump(JumpRecord),
}

/// A state that was found.
struct Found {
    /// Without what is to be proved of it.
    record: StateRecord,
    gap: Array2<f64>,
    /// None where its stability is known in closed form.
    evidence: Option<Evidence>,
}

/// What is known of a patterned state, of which more is to be proved.
struct Evidence {
    /// The softest of the modes that were looked at.
    stiffness: Stiffness,
    others: Others,
    /// True for the first state of a branch.
    begins: bool,
    /// True where the branch ends.
    at_end: bool,
}

/// The modes that were not looked at, with what it takes.
enum Others {
    None,
    /// Those of a ridge whose u0 is free, with these amplitudes of the even cell at this control.
    OfRidge(Vec<f64>, f64),
    /// Those of a square state, beside the softest ones of its classes.
    OfSquare(Vec<f64>, Box<Fields>, Vec<Known>),
}

impl Found {
    /// The same with its smallest eigenvalue over all modes of the whole cell, of side `length`.
    fn proved(mut self, guard: &mut Guard, length: f64) -> Result<Self, Unmapped> {
        let Some(Evidence {
            mut stiffness,
            others,
            begins,
            at_end,
        }) = self.evidence.take()
        else {
            return Ok(self);
        };
        let began = Instant::now();
        let spent = guard.transforms();
        if begins {
            guard.reset();
        }
        let all = match &others {
            Others::None => stiffness,
            Others::OfRidge(z, control) => {
                let fields = guard.fields(z, *control);
                guard.check(Soft::Mode(stiffness.value, &[]), z, &fields)
            }
            Others::OfSquare(z, fields, known) => guard.check(Soft::Classes(known), z, fields),
        };
        let refusal = if all.value < 0.0 && !at_end {
            Some("a mode goes soft that is not mirror-symmetric")
        } else if all.value.is_nan() {
            Some("the stability against all modes was not decided")
        } else {
            None
        };
        if let Some(why) = refusal {
            return Err(Unmapped::at(self.record.mean_displacement, why));
        }
        if all.value >= 0.0 {
            stiffness = stiffness.among(all);
        }
        let record = &mut self.record;
        (record.stiffness_min, record.stiffness_error) =
            (stiffness.value * length, stiffness.error * length);
        // The residual is within tolerance, or there would be no state.
        record.stop = if stiffness.is_stable() {
            Stop::Stable
        } else {
            Stop::Unstable
        };
        record.transforms += guard.transforms() - spent;
        record.milliseconds += began.elapsed().as_secs_f64() * 1e3;
        Ok(self)
    }

    /// Hands it out, and adds it to the run of `scene`.
    fn tell(self, scene: &Scene, run: &mut LoopRun, observe: &mut dyn FnMut(Report<'_>)) {
        let (state, gap) = (self.record, self.gap);
        let (start, turn) = (scene.drive.start, scene.depth());
        let half = (start - state.control) / (start - turn);
        let way = if state.direction == Direction::Approach {
            half
        } else {
            2.0 - half
        };
        observe(Report::State {
            record: &state,
            index: run.record.states.len(),
            fields: [&gap; 2],
            fraction: 0.5 * way,
        });
        run.counts.patterned_increments += usize::from(state.pattern != Pattern::Flat);
        // The first state, and the first after each jump.
        if run.landings.len() <= run.record.jumps.len() {
            run.landings.push(Landing {
                direction: state.direction,
                pattern: state.pattern,
                gap,
            });
        }
        run.record.states.push(state);
    }
}

/// What a tour carries along.
struct Tour<'a> {
    atlas: &'a mut Atlas,
    model: &'a Model,
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
        self.atlas.transforms().iter().sum()
    }

    /// Hands on each state and jump of the loop of `scene`, until one is not wanted.
    fn go_round(
        &mut self,
        scene: &Scene,
        cancel: &Cancel,
        hand_on: &mut dyn FnMut(Step) -> bool,
    ) -> Result<Outcome, Unmapped> {
        let (start, turn, step) = (scene.drive.start, scene.depth(), scene.drive.step);
        let mut traversal = Traversal::new(self.atlas, start, turn)?;
        while let Some(leg) = traversal.leg(self.atlas) {
            let hair = HAIR * scene.control().unit(&self.model.law);
            let edge = traversal.jumps_next().then_some(hair);
            let fold = self.fold(&leg);
            for value in stations(&self.without_faint(leg), start, step, edge, fold) {
                let found = self.state(&leg, value);
                if cancel.requested() || !hand_on(Step::State(Box::new(found?))) {
                    return Ok(Outcome::Cancelled);
                }
            }
            let jump = traversal.jump(self.atlas);
            if cancel.requested() {
                return Ok(Outcome::Cancelled);
            }
            if let Some(jump) = jump? {
                hand_on(Step::Jump(jump));
            }
        }
        traversal.closed()?;
        Ok(Outcome::Completed)
    }

    /// The leg without what is next to where its pattern fades.
    fn without_faint(&self, mut leg: Leg) -> Leg {
        let Place::On(i) = leg.place else { return leg };
        let faint = FAINT * self.atlas.meshes().control.unit(&self.model.law);
        for (side, end) in Side::BOTH.into_iter().zip(self.atlas.extent(i)) {
            if self.atlas.fades(leg.place, side) {
                for control in [&mut leg.from, &mut leg.to] {
                    if *control == end {
                        *control -= side.sign() * faint;
                    }
                }
            }
        }
        leg
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

    /// The state of `leg` where the control has this `value`.
    fn state(&mut self, leg: &Leg, value: f64) -> Result<Found, Unmapped> {
        let began = Instant::now();
        let spent = self.transforms();
        let mut record = StateRecord {
            direction: leg.direction,
            control: value,
            ..StateRecord::placeholder(self.atlas.at(leg.place, value).mean_displacement)
        };
        let (gap, evidence) = match leg.place {
            Place::Flat(_) => (self.flat(&mut record), None),
            Place::On(i) => {
                let (gap, evidence) = self.patterned(i, leg, &mut record)?;
                (gap, Some(evidence))
            }
        };
        record.stress_over_max = record.stress / self.model.law.traction_max();
        record.contact_area = contact_area(gap.view(), &self.model.law);
        record.transforms = self.transforms() - spent;
        record.milliseconds = began.elapsed().as_secs_f64() * 1e3;
        Ok(Found {
            record,
            gap,
            evidence,
        })
    }

    fn flat(&mut self, record: &mut StateRecord) -> Array2<f64> {
        let mechanics = &mut self.whole;
        let u0 = record.mean_displacement;
        let (law, length) = (&self.model.law, self.model.equivalent_length);
        let flat = if mechanics.system.control().is_apart(law, length, u0) {
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
    ) -> Result<(Array2<f64>, Evidence), Unmapped> {
        let before = self
            .last
            .take()
            .filter(|(place, _)| *place == Place::On(i))
            .map(|(_, node)| node);
        if before.is_none() {
            self.history = History::default();
        }
        let Measured {
            node,
            residual,
            stiffness,
            known,
            fields,
        } = self.found(i, before.as_ref(), record)?;
        let (u0, is_ridge) = (record.mean_displacement, self.atlas.branches[i].is_ridge());
        let driven = self.atlas.meshes().control;
        let square = self.atlas.square.system();
        let mut z = carried(&node.state.amplitudes, self.atlas.system_of(i), square);
        let gap = square.unfolded(&square.gap_field(&z, u0));
        let control;
        [control, z[0]] = driven.balanced(u0, node.state.stress);
        let others = match (is_ridge, driven.frees_mean()) {
            (true, false) => Others::None,
            (true, true) => Others::OfRidge(z, control),
            (false, _) => Others::OfSquare(z, Box::new(fields), known),
        };
        // Right at an end the mesh of the whole cell may call it a hair sooner than that of the
        // branch.
        let edge = 2.0 * HAIR * driven.unit(&self.model.law);
        let at_end = stiffness.value * self.model.grid.length <= SOFT
            || driven.frees_mean() && (record.control - leg.to).abs() <= edge;
        (record.stress, record.energy, record.residual) =
            (node.state.stress, node.state.energy, residual);
        record.pattern = classify(gap.view(), &self.model.law, true);
        record.part = if is_ridge { Part::Ridge } else { Part::Quarter };
        self.history.push(&node.state);
        self.last = Some((Place::On(i), node));
        let evidence = Evidence {
            stiffness,
            others,
            begins: before.is_none(),
            at_end,
        };
        Ok((gap, evidence))
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
