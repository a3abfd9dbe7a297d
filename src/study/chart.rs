//! Speed against accuracy: every relaxation method on the same loop, measured against a finer solution of the same problem.
//!
//! A [`Point`] says what is measured, [`measure`] walks its loop, [`Judged`] compares it with the [`Reference`]. Failures are
//! results like any other. [`run`] does it all within a budget of processor time, and says what it left out.

mod atlas;
mod front;
mod judge;
mod measure;
mod points;
mod reference;

pub use crate::numerics::precision::Precision;
pub use front::front;
pub use judge::{Errors, Judged, Verdict};
pub use measure::{Measured, measure};
pub use points::{Effort, Point, points};
pub use reference::Reference;

use crate::numerics::cancel::Cancel;
use crate::physics::parameter::Refusal;
use crate::scene::Scene;
use points::Predictor;
use std::fmt;

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
        write!(f, "it would take {:.1} processor seconds, and {:.1} are left for it", self.predicted_seconds, self.allowed_seconds)
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
pub fn run(scene: &Scene, effort: Effort, cancel: &Cancel, observe: &mut dyn FnMut(News<'_>)) -> Result<Chart, Refusal> {
    let scene = points::with_fixed_law(scene)?;
    let (list, finest) = points::points(&scene, effort)?;
    let mut predictor = Predictor::new(&scene)?;
    let total: f64 = list.iter().chain(&finest).map(|p| predictor.seconds(p)).sum();
    let (mut done, mut spent) = (0.0, 0.0);
    let mut chart = Chart::default();
    let mut loops = Vec::new();
    for point in &finest {
        observe(News::Begun { what: *point, reference: true });
        let expected = predictor.seconds(point);
        let loop_ = measure(&scene, point, points::REFERENCE * effort.seconds() - spent, cancel, &mut |f| {
            observe(News::Fraction((done + f * expected) / total));
        })?;
        done += expected;
        spent += loop_.processor_seconds;
        predictor.learn(&loop_);
        loops.push(loop_);
    }
    if cancel.requested() {
        chart.cancelled = true;
        return Ok(chart);
    }
    let Ok(loops) = <[Measured; 3]>::try_from(loops) else { unreachable!("a loop for each of three") };
    let reference = Reference::new(loops);
    for point in points::own(&scene)?.into_iter().filter(|own| matches!(effort, Effort::Full { .. }) && !list.contains(own)) {
        let allowed_seconds = effort.seconds() * points::SHARE;
        skip(
            &mut chart,
            observe,
            Skipped { point, predicted_seconds: predictor.seconds(&point), allowed_seconds, beyond_reference: true },
        );
    }
    for point in list {
        let predicted_seconds = predictor.seconds(&point);
        let allowed_seconds = (effort.seconds() - spent).clamp(0.0, effort.seconds() * points::SHARE);
        if predicted_seconds > allowed_seconds {
            skip(&mut chart, observe, Skipped { point, predicted_seconds, allowed_seconds, beyond_reference: false });
            continue;
        }
        observe(News::Begun { what: point, reference: false });
        let share = |f: f64| ((done + f * predicted_seconds) / total).min(1.0);
        let measured = measure(&scene, &point, allowed_seconds, cancel, &mut |f| observe(News::Fraction(share(f))))?;
        done += predicted_seconds;
        spent += measured.processor_seconds;
        predictor.learn(&measured);
        let judged = reference.judge(&measured, points::is_plan(&scene, &point)?, points::is_paper_budget(&scene, &point)?);
        observe(News::Measured(&judged));
        chart.rows.push(judged);
        if cancel.requested() {
            chart.cancelled = true;
            break;
        }
    }
    front::mark(&mut chart.rows, reference.errors.dissipated_energy);
    chart.reference = Some(reference);
    Ok(chart)
}

fn skip(chart: &mut Chart, observe: &mut dyn FnMut(News<'_>), skipped: Skipped) {
    observe(News::Skipped(&skipped));
    chart.skipped.push(skipped);
}
