//! Speed against accuracy: every relaxation method on the same loop, measured against a finer
//! solution of the same problem.
//!
//! A [`Point`] says what is measured, [`measure`] walks its loop, [`Judged`] compares it with the
//! [`Reference`]. Failures are results like any other. [`run`] does it all within a budget of
//! processor time, and says what it left out.

mod judge;
mod points;
mod read_off;

pub use crate::numerics::precision::Precision;
pub use judge::{Errors, Judged, Reference, Verdict, front, on_front};
pub use points::{Effort, Point, points};

use super::plan::{plan, run_as_planned};
use crate::follow::ledger::Ledger;
use crate::follow::record::LoopRecord;
use crate::follow::run::{LoopRun, Outcome, Report, run_loop};
use crate::follow::walk::{Counts, WalkOptions};
use crate::numerics::threads::Cancel;
use crate::physics::law::Law;
use crate::physics::parameter::Refusal;
use crate::scene::{Points, Scene, Strategy};
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

impl Chart {
    /// The reference's own error of the dissipated energy, below which nothing is told apart.
    pub fn floor(&self) -> Option<f64> {
        let reference = self.reference.as_ref();
        reference.map(|reference| reference.errors.dissipated_energy)
    }
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
    let points = list.iter().map(|p| predictor.seconds(p));
    let total = points.sum::<f64>() + predictor.of_reference(&finest);
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
    let walked = points::walked(&scene, &list, &finest)?;
    let Some(reference) = work.reference(&finest, &walked, observe)? else {
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
    let [planned, budget] = points::own(&scene)?;
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
            plan: point == planned,
            paper_budget: point == budget,
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
        walked: &[Point; 3],
        observe: &mut dyn FnMut(News<'_>),
    ) -> Result<Option<Reference>, Refusal> {
        let mut loops: Vec<Measured> = Vec::new();
        if finest != walked {
            let coarse = points::coarse(self.scene, &walked[1])?;
            let coarse = self.of_reference(&coarse, States::Solved, observe)?;
            for point in finest {
                let known = loops.last().filter(|last| last.point == *point).cloned();
                loops.push(match known {
                    Some(known) => known,
                    None => self.of_reference(point, States::Along(&coarse.record), observe)?,
                });
            }
        }
        // Where the branches along which it goes were not all found, or not in time, it is walked,
        // with the time for it anew.
        if loops.is_empty() || !loops.iter().all(Measured::is_complete) {
            loops.clear();
            self.spent = 0.0;
            for point in walked {
                loops.push(self.of_reference(point, States::Solved, observe)?);
            }
        }
        if self.cancel.requested() {
            return Ok(None);
        }
        let Ok(loops) = <[Measured; 3]>::try_from(loops) else {
            unreachable!("a loop for each of three")
        };
        let along = loops[0].point == finest[0] && finest != walked;
        let located = along.then(|| read_off::located(&loops[0]));
        let mut reference = Reference::new(loops);
        reference.errors = reference.errors.larger(located.unwrap_or_default());
        Ok(Some(reference))
    }

    /// Measures a loop of the reference.
    fn of_reference(
        &mut self,
        point: &Point,
        states: States<'_>,
        observe: &mut dyn FnMut(News<'_>),
    ) -> Result<Measured, Refusal> {
        observe(News::Begun {
            what: *point,
            reference: true,
        });
        let expected = self.predictor.of_reference_loop(point);
        let allowed = points::REFERENCE * self.effort.seconds() - self.spent;
        self.timed(point, states, [expected, allowed], observe)
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
        let seconds = [self.predictor.seconds(point), allowed_seconds];
        let measured = self.timed(point, States::ReadOff, seconds, observe)?;
        self.predictor.learn(&measured);
        Ok(measured)
    }

    /// Computes a loop that is expected to take so many processor seconds, and allowed so many.
    fn timed(
        &mut self,
        point: &Point,
        states: States<'_>,
        [expected, allowed]: [f64; 2],
        observe: &mut dyn FnMut(News<'_>),
    ) -> Result<Measured, Refusal> {
        let (done, total) = (self.done, self.total);
        let mut progress = |f: f64| observe(News::Fraction(share(done + f * expected, total)));
        let measured = timed(
            self.scene,
            point,
            states,
            allowed,
            self.cancel,
            &mut progress,
        )?;
        self.done += expected;
        self.spent += measured.processor_seconds;
        Ok(measured)
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

/// What the states of a loop are.
#[derive(Clone, Copy)]
enum States<'a> {
    /// Read off between the nodes of an atlas.
    ReadOff,
    /// Each solved, as by `tackscope run`.
    Solved,
    /// Read off the branches on which a loop on a coarser mesh lies.
    Along(&'a LoopRecord),
}

fn timed(
    scene: &Scene,
    point: &Point,
    states: States<'_>,
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
    } = match (point.model, states) {
        (_, States::Along(walked)) => {
            let tell = &mut || {
                if processor.elapsed().as_secs_f64() > allowed {
                    part.request();
                }
            };
            read_off::of_diagram(&scene, &model, walked, &part, tell)
        }
        (Strategy::Atlas, States::ReadOff) => read_off::of_atlas(&scene, &model),
        (Strategy::Atlas, States::Solved) => {
            let plan = plan(&scene, &model, Some(Strategy::Atlas));
            run_as_planned(&scene, point.method, &plan, &part, observe)?
        }
        (Strategy::Walk(walked), _) => run_loop(&scene, options(walked), &part, observe)?,
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
