//! Speed against accuracy: every relaxation method on the same loop, measured against a finer
//! solution of the same problem.
//!
//! A [`Point`] says what is measured, [`measure`] walks its loop, [`Judged`] compares it with the
//! [`Reference`]. Failures are results like any other. [`run`] does it all within a budget of
//! processor time, and says what it left out.

mod judge;
mod points;

pub use crate::numerics::precision::Precision;
pub use judge::{Errors, Judged, Reference, Verdict, front};
pub use points::{Effort, Point, points};

use super::plan::{plan, run_as_planned};
use crate::follow::atlas::{Atlas, Leg, Place, Unmapped};
use crate::follow::ledger::Ledger;
use crate::follow::record::{LoopRecord, StateRecord};
use crate::follow::run::{LoopRun, Outcome, Report, run_loop};
use crate::follow::walk::{Counts, Stuck, WalkOptions};
use crate::numerics::cancel::Cancel;
use crate::physics::law::Law;
use crate::physics::parameter::Refusal;
use crate::physics::pattern::Pattern;
use crate::scene::part::{Part, Strategy};
use crate::scene::{Model, Points, Scene};
use crate::solver::Stop;
use crate::solver::methods::MethodKind;
use cpu_time::ProcessTime;
use points::Predictor;
use std::fmt;
use std::time::Instant;

/// Everything a chart shows.
#[derive(Clone, Debug, Default)]
pub struct Chart {
    /// What all is compared with; `None` if the chart was cancelled before.
    pub reference: Option<Reference>,
    /// The points in the order in which they were measured.
    pub rows: Vec<Judged>,
    /// Points that were not measured.
    pub skipped: Vec<Skipped>,
    /// True if somebody asked to stop; what was measured stands.
    pub cancelled: bool,
}

/// What the cheapest loop that is no worse than one of the paper's method saves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Saved<'a> {
    /// The loop of the paper's method.
    pub paper: &'a Judged,
    /// The cheapest loop in processor time with an error of the loss as small, or below the
    /// reference's own.
    pub ours: &'a Judged,
}

impl Saved<'_> {
    /// Processor time of the one over that of the other.
    pub fn ratio(&self) -> f64 {
        self.paper.processor_seconds / self.ours.processor_seconds
    }
}

/// Against the paper's method with its own budget, and against the loop in which its error is least,
/// whatever its verdict; below the reference's own error, `floor`, nothing is told apart.
pub fn saved(rows: &[Judged], floor: f64) -> [Option<Saved<'_>>; 2] {
    let error = |row: &Judged| row.errors.dissipated_energy;
    let paper = |row: &&Judged| row.point.method == MethodKind::Gfmd && error(row).is_finite();
    let papers = || rows.iter().filter(paper);
    let budget = papers().find(|row| row.paper_budget);
    let best = papers().min_by(|a, b| error(a).total_cmp(&error(b)));
    [budget, best].map(|paper| {
        let paper = paper?;
        let done = rows.iter().filter(|row| row.verdict == Verdict::Done);
        let ours = done.filter(|row| error(row) <= error(paper).max(floor));
        let ours = ours.min_by(|a, b| a.processor_seconds.total_cmp(&b.processor_seconds))?;
        Some(Saved { paper, ours })
    })
}

/// A point that was left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Skipped {
    /// Which.
    pub point: Point,
    /// What it would have taken (processor seconds).
    pub predicted_seconds: f64,
    /// What was left for it.
    pub allowed_seconds: f64,
    /// True if it is finer than a reference within the budget, which cannot judge it.
    pub beyond_reference: bool,
}

impl fmt::Display for Skipped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.beyond_reference {
            return f.write_str("a reference fine enough to judge it is beyond the budget");
        }
        write!(
            f,
            "it would take {:.1} processor seconds, and {:.1} are left for it",
            self.predicted_seconds, self.allowed_seconds
        )
    }
}

/// What a chart reports while it is made.
#[derive(Clone, Copy, Debug)]
pub enum News<'a> {
    /// A loop has begun.
    Begun {
        /// What it is: a point, or a loop of the reference.
        what: Point,
        /// True for a loop of the reference.
        reference: bool,
    },
    /// Share of all work that is done, by prediction.
    Fraction(f64),
    /// A point was measured.
    Measured(&'a Judged),
    /// A point was left out.
    Skipped(&'a Skipped),
}

/// Measures the chart of `scene`.
///
/// # Errors
/// The first value of the scene that is not allowed. Failures of methods are rows.
pub fn run(
    scene: &Scene,
    effort: Effort,
    cancel: &Cancel,
    observe: &mut dyn FnMut(News<'_>),
) -> Result<Chart, Refusal> {
    let scene = points::with_fixed_law(scene)?;
    let (list, finest) = points::points(&scene, effort)?;
    let predictor = Predictor::new(&scene)?;
    let total = list
        .iter()
        .copied()
        .chain(finest.iter().map(points::solved))
        .map(|p| predictor.seconds(&p))
        .sum();
    let mut work = Work {
        scene: &scene,
        effort,
        cancel,
        predictor,
        total,
        done: 0.0,
        spent: 0.0,
    };
    let mut chart = Chart::default();
    let Some(reference) = work.reference(&finest, observe)? else {
        chart.cancelled = true;
        return Ok(chart);
    };
    for point in points::own(&scene)?
        .into_iter()
        .filter(|own| matches!(effort, Effort::Full { .. }) && !list.contains(own))
    {
        let skipped = Skipped {
            point,
            predicted_seconds: work.predictor.seconds(&point),
            allowed_seconds: effort.seconds() * points::SHARE,
            beyond_reference: true,
        };
        skip(&mut chart, observe, skipped);
    }
    for point in list {
        let predicted_seconds = work.predictor.seconds(&point);
        let allowed_seconds =
            (effort.seconds() - work.spent).clamp(0.0, effort.seconds() * points::SHARE);
        if predicted_seconds > allowed_seconds {
            let skipped = Skipped {
                point,
                predicted_seconds,
                allowed_seconds,
                beyond_reference: false,
            };
            skip(&mut chart, observe, skipped);
            continue;
        }
        let measured = work.measured(&point, allowed_seconds, observe)?;
        let judged = Judged {
            plan: points::is_plan(&scene, &point)?,
            paper_budget: points::is_paper_budget(&scene, &point)?,
            ..reference.judge(&measured)
        };
        observe(News::Measured(&judged));
        chart.rows.push(judged);
        if cancel.requested() {
            chart.cancelled = true;
            break;
        }
    }
    judge::mark(&mut chart.rows, reference.errors.dissipated_energy);
    chart.reference = Some(reference);
    Ok(chart)
}

/// What is measured, and how much of it is done.
struct Work<'a> {
    scene: &'a Scene,
    effort: Effort,
    cancel: &'a Cancel,
    predictor: Predictor,
    /// All loops (predicted processor seconds).
    total: f64,
    /// The loops that are done (predicted processor seconds).
    done: f64,
    /// What they took (processor seconds).
    spent: f64,
}

impl Work<'_> {
    /// Measures the reference's three loops; `None` if the chart was cancelled by then.
    fn reference(
        &mut self,
        finest: &[Point; 3],
        observe: &mut dyn FnMut(News<'_>),
    ) -> Result<Option<Reference>, Refusal> {
        let mut loops = Vec::new();
        for point in finest {
            observe(News::Begun {
                what: *point,
                reference: true,
            });
            let (done, total) = (self.done, self.total);
            let expected = self.predictor.seconds(&points::solved(point));
            let loop_ = timed(
                self.scene,
                point,
                States::Solved,
                points::REFERENCE * self.effort.seconds() - self.spent,
                self.cancel,
                &mut |f| observe(News::Fraction(share(done + f * expected, total))),
            )?;
            self.done += expected;
            self.spent += loop_.processor_seconds;
            loops.push(loop_);
        }
        if self.cancel.requested() {
            return Ok(None);
        }
        let Ok(loops) = <[Measured; 3]>::try_from(loops) else {
            unreachable!("a loop for each of three")
        };
        Ok(Some(Reference::new(loops)))
    }

    /// Measures the loop of a point of the chart.
    fn measured(
        &mut self,
        point: &Point,
        allowed_seconds: f64,
        observe: &mut dyn FnMut(News<'_>),
    ) -> Result<Measured, Refusal> {
        observe(News::Begun {
            what: *point,
            reference: false,
        });
        let (done, total) = (self.done, self.total);
        let expected = self.predictor.seconds(point);
        let measured = measure(self.scene, point, allowed_seconds, self.cancel, &mut |f| {
            observe(News::Fraction(share(done + f * expected, total)));
        })?;
        self.finish(expected, &measured);
        Ok(measured)
    }

    fn finish(&mut self, expected: f64, measured: &Measured) {
        self.done += expected;
        self.spent += measured.processor_seconds;
        self.predictor.learn(measured);
    }
}

fn skip(chart: &mut Chart, observe: &mut dyn FnMut(News<'_>), skipped: Skipped) {
    observe(News::Skipped(&skipped));
    chart.skipped.push(skipped);
}

/// A loop as a point of the chart computed it.
#[derive(Clone, Debug)]
pub struct Measured {
    /// The point.
    pub point: Point,
    /// The law.
    pub law: Law,
    /// mu_rho on the point's mesh.
    pub mu_rho: f64,
    /// States and jumps.
    pub record: LoopRecord,
    /// How it ended.
    pub outcome: Outcome,
    /// True if it took more than it was allowed.
    pub out_of_time: bool,
    /// What was counted.
    pub counts: Counts,
    /// Time on the wall.
    pub seconds: f64,
    /// Time of the processor.
    pub processor_seconds: f64,
}

impl Measured {
    /// True if the drive went all the way.
    pub fn is_complete(&self) -> bool {
        self.outcome == Outcome::Completed
    }

    /// The loss over gamma; NaN unless the loop is closed.
    pub fn dissipated_energy(&self) -> f64 {
        self.ledger()
            .and_then(|ledger| ledger.dissipated_energy())
            .unwrap_or(f64::NAN)
    }

    /// The ledger, if the drive was completed.
    pub fn ledger(&self) -> Option<Ledger> {
        self.is_complete()
            .then(|| self.record.ledger(self.law.surface_energy))
    }

    /// Loop integral of stress du0 over gamma.
    pub fn integral(&self) -> f64 {
        self.record.work() / self.law.surface_energy
    }
}

/// Computes the loop of `scene` (its range given as a length) as `point` says, stopping after
/// `allowed` processor seconds.
///
/// # Errors
/// The first value of the scene that is not allowed.
pub fn measure(
    scene: &Scene,
    point: &Point,
    allowed: f64,
    cancel: &Cancel,
    progress: &mut dyn FnMut(f64),
) -> Result<Measured, Refusal> {
    timed(scene, point, States::ReadOff, allowed, cancel, progress)
}

/// What the states of an atlas are.
#[derive(Clone, Copy, PartialEq)]
enum States {
    /// Read off between its nodes.
    ReadOff,
    /// Each solved, as by `tackscope run`.
    Solved,
}

fn timed(
    scene: &Scene,
    point: &Point,
    states: States,
    allowed: f64,
    cancel: &Cancel,
    progress: &mut dyn FnMut(f64),
) -> Result<Measured, Refusal> {
    let mut scene = scene.clone();
    scene.drive.step = point.step;
    scene.cell.points = if point.line {
        Points::Line(point.points)
    } else {
        Points::Square(point.points)
    };
    let model = scene.model()?;
    let part = cancel.part();
    let (wall, processor) = (Instant::now(), ProcessTime::now());
    let mut out_of_time = false;
    let options = |part| WalkOptions {
        method: point.method,
        part,
        precision: point.precision,
        trapped_within: None,
    };
    let observe = &mut |report: Report<'_>| {
        if processor.elapsed().as_secs_f64() > allowed {
            out_of_time = true;
            part.request();
        }
        if let Report::State { fraction, .. } = report {
            progress(fraction);
        }
    };
    let LoopRun {
        record,
        outcome,
        counts,
        ..
    } = match point.model {
        Strategy::Atlas if states == States::ReadOff => read_off(&scene, &model),
        Strategy::Atlas => {
            let plan = plan(&scene, &model, Some(Strategy::Atlas));
            run_as_planned(&scene, point.method, &plan, &part, observe)?
        }
        Strategy::Walk(walked) => run_loop(&scene, options(walked), &part, observe)?,
    };
    Ok(Measured {
        point: *point,
        law: model.law,
        mu_rho: model.mu_rho,
        record,
        outcome,
        out_of_time,
        counts,
        seconds: wall.elapsed().as_secs_f64(),
        processor_seconds: processor.elapsed().as_secs_f64(),
    })
}

/// The share of all work that is done: short of all of it until it is, however long it takes.
fn share(done: f64, total: f64) -> f64 {
    (done / total).min(ALMOST)
}

/// As near to all as is told before the end.
const ALMOST: f64 = 0.99;

/// The loop of a scene on flat ground. Where the atlas has no answer the loop has not converged,
/// and says why.
fn read_off(scene: &Scene, model: &Model) -> LoopRun {
    // As the live loop does.
    let mut atlas = Atlas::of(scene, model);
    let start = scene.drive.start;
    let cycle = match scene.turn_of_atlas() {
        Some(turn) => atlas.cycle(start, turn),
        None => Err(Unmapped::anywhere("there is no atlas of this drive")),
    };
    let mut run = LoopRun::empty();
    match cycle {
        Ok(cycle) => {
            run.record.states = cycle
                .legs
                .iter()
                .flat_map(|leg| states(&atlas, leg, start, scene.drive.step, model))
                .collect();
            run.record.jumps = cycle.jumps;
        }
        Err(reason) => {
            run.outcome = Outcome::NotConverged {
                mean_displacement: start,
                reason: Stuck::Unmapped(reason),
            }
        }
    }
    run.counts.transforms = atlas.transforms().iter().sum();
    run.counts.patterned_increments = run
        .record
        .states
        .iter()
        .filter(|s| s.pattern != Pattern::Flat)
        .count();
    run
}

/// States along a leg: its ends, and the points start - k x step between them.
fn states(atlas: &Atlas, leg: &Leg, start: f64, step: f64, model: &Model) -> Vec<StateRecord> {
    let (low, high) = (leg.from.min(leg.to), leg.from.max(leg.to));
    let (first, last) = (
        ((start - high) / step).floor() as i64,
        ((start - low) / step).ceil() as i64,
    );
    let mut places: Vec<f64> = (first..=last)
        .map(|k| start - k as f64 * step)
        .filter(|u| *u > low && *u < high)
        .collect();
    places.extend([leg.from, leg.to]);
    places.sort_by(|a, b| {
        if leg.from < leg.to {
            a.total_cmp(b)
        } else {
            b.total_cmp(a)
        }
    });
    places
        .iter()
        .map(|&value| state(atlas, leg, value, model))
        .collect()
}

fn state(atlas: &Atlas, leg: &Leg, value: f64, model: &Model) -> StateRecord {
    let at = atlas.at(leg.place, value);
    let (pattern, part) = match leg.place {
        Place::Flat(_) => (Pattern::Flat, Part::Flat),
        Place::On(i) => {
            let branch = &atlas.branches()[i];
            (
                branch.pattern,
                if branch.is_ridge {
                    Part::Ridge
                } else {
                    Part::Quarter
                },
            )
        }
    };
    StateRecord {
        direction: leg.direction,
        stress: at.stress,
        stress_over_max: at.stress / model.law.traction_max(),
        energy: at.body_energy(atlas.meshes().control),
        pattern,
        part,
        stop: Stop::ReadOff,
        control: value,
        ..StateRecord::placeholder(at.mean_displacement)
    }
}
