//! What is computed in the background, with partial results as they come: for the window, beside
//! the walk, which time steps GFMD survives, speed against accuracy, every branch of equilibria, a
//! page of the paper, the live loop and the states that it foresees; for the command line the paper's
//! figures, several at once, one on each core.

use super::job::{Pace, Reporter};
use super::protocol::{LiveState, Stored};
use super::system::{self, Instant};
use crate::follow::diagram::Diagram;
use crate::follow::walk::{Walk, WalkOptions};
use crate::numerics::threads::{Cancel, FAULT};
use crate::paper::errata::{Erratum, errata};
use crate::paper::{Entry, Figure, GALLERY, Size, Stopped, Task};
use crate::plot::curve::ZeroRange;
use crate::scene::{Model, Part, Scene};
use crate::solver::Lost;
use crate::study::chart::{self, Effort, Judged, News};
use crate::study::live_loop::{Fineness, LiveLoops, Spot};
use crate::study::plan;
use crate::study::time_step_map::{Progress as Step, Survey, TimeStepMap};
use crossbeam_channel::unbounded;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Most figures at once.
const THREADS_MAX: usize = 8;

/// A page of the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Page {
    /// The figure of this number.
    Figure(usize),
    /// What the print got wrong.
    Errata,
    /// Theory to lay over the live loop.
    Theory,
}

/// What stands on a page of the paper.
#[derive(Clone, Debug)]
pub enum PageContent {
    /// A figure.
    Figure(Arc<Figure>),
    /// The errata.
    Errata(Arc<Vec<Erratum>>),
    /// The theory.
    Theory(Arc<ZeroRange>),
}

/// A chart of speed against accuracy as far as it is measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ChartSoFar {
    /// What was measured, in that order.
    pub rows: Vec<Judged>,
    /// The reference's own error of the dissipated energy, once everything is measured.
    pub floor: Option<f64>,
}

/// Measures which time steps GFMD survives on an approach that ends at a u0 (length).
///
/// # Errors
/// Why it could not be finished, in words.
pub fn time_steps(
    (scene, turn): &(Arc<Scene>, f64),
    report: &Reporter<TimeStepMap>,
) -> Result<(), String> {
    let mut survey = Survey::new(scene, *turn).map_err(|error| error.to_string())?;
    let mut end = Ok(());
    while !report.cancel.requested() {
        match survey.step(&report.cancel) {
            Step::Working => {}
            Step::Done | Step::Cancelled => break,
            Step::Stuck(message) => {
                end = Err(message);
                break;
            }
        }
        if report.is_due() {
            report.progress(survey.map().fraction(), "time steps");
            report.result(survey.map().clone());
        }
    }
    report.result(survey.map().clone());
    end
}

/// Measures speed against accuracy of every method.
///
/// # Errors
/// Why it could not be finished, in words.
pub fn chart(
    (scene, effort): &(Arc<Scene>, Effort),
    report: &Reporter<ChartSoFar>,
) -> Result<(), String> {
    let mut so_far = ChartSoFar::default();
    let (mut done, mut doing) = (0.0, String::new());
    let chart = chart::run(scene, *effort, &report.cancel, &mut |news| {
        match news {
            News::Begun {
                what,
                reference: true,
            } => doing = format!("reference: {what}"),
            News::Begun {
                what,
                reference: false,
            } => doing = what.to_string(),
            News::Measured(row) => so_far.rows.push(row.clone()),
            News::Skipped(_) => return,
            News::Fraction(fraction) => {
                done = fraction;
                if !report.is_due() {
                    return;
                }
            }
        }
        report.progress(done, &doing);
        report.result(so_far.clone());
    })
    .map_err(|error| error.to_string())?;
    report.result(ChartSoFar {
        floor: chart.floor(),
        rows: chart.rows,
    });
    Ok(())
}

/// Follows every branch of the scene.
///
/// # Errors
/// Why it could not be, in words.
pub fn diagram(scene: &Arc<Scene>, report: &Reporter<Arc<Diagram>>) -> Result<(), String> {
    let mut tell = |branch: &str, points: usize, _: f64| {
        if report.is_due() {
            // How long a branch is shows only at its end.
            let share = points as f64 / (points as f64 + 40.0);
            report.progress(share, &format!("branch \"{branch}\", {points} points"));
        }
    };
    let found =
        plan::diagram(scene, &report.cancel, &mut tell).map_err(|error| error.to_string())?;
    report.result(Arc::new(found));
    Ok(())
}

/// Computes a page at the quick size.
///
/// # Errors
/// Why it could not be finished, in words.
pub fn page(page: &Page, report: &Reporter<PageContent>) -> Result<(), String> {
    match content(*page, report) {
        Ok(content) => {
            report.result(content);
            Ok(())
        }
        Err(Stopped::Cancelled) => Ok(()),
        Err(Stopped::Failed(why)) => Err(why),
    }
}

fn content(page: Page, report: &Reporter<PageContent>) -> Result<PageContent, Stopped> {
    let cancel = &report.cancel;
    let mut observe = |done: f64, what: &str| {
        if report.is_due() {
            report.progress(done, what);
        }
    };
    let mut task = Task::new(Size::Quick, cancel, &mut observe);
    match page {
        Page::Figure(number) => match GALLERY.iter().find(|entry| entry.number == number) {
            Some(entry) => {
                (entry.compute)(&mut task).map(|figure| PageContent::Figure(Arc::new(figure)))
            }
            None => Err(Stopped::Failed(format!("there is no Fig. {number}"))),
        },
        Page::Errata => errata(&mut task).map(|list| PageContent::Errata(Arc::new(list))),
        Page::Theory => {
            task.tell(0.0, "curves of zero range")?;
            ZeroRange::compute(cancel)
                .map(|theory| PageContent::Theory(Arc::new(theory)))
                .ok_or(Stopped::Cancelled)
        }
    }
}

/// How far before the end of a branch (units of the control) its state is looked for, where nearer
/// there is none: the atlas knows the end on a mesh of its own.
const BEFORE: [f64; 3] = [0.0, 1e-3, 1e-2];

/// A place on the live loop of a scene.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// The scene.
    pub scene: Arc<Scene>,
    /// The part of the cell on which the state is to be solved.
    pub part: Part,
    /// Its live loop.
    pub live: Arc<LiveState>,
    /// The place.
    pub spot: Spot,
}

/// Finds the state at a place.
///
/// # Errors
/// Why there is none, in words.
pub fn foreseen(wanted: &Wanted, report: &Reporter<Arc<Stored>>) -> Result<(), String> {
    let live = wanted.live.found.as_ref().map_err(Clone::clone)?;
    let leg = &live.legs[wanted.spot.leg];
    let (low, high) = (leg.from.min(leg.to), leg.from.max(leg.to));
    let options = WalkOptions {
        part: wanted.part,
        ..WalkOptions::default()
    };
    let mut refused = Lost::Gone;
    let mut tried = None;
    for before in BEFORE {
        let inside = (before * live.control.unit(&live.law)).min(0.5 * (high - low));
        let control = wanted.spot.control.clamp(low + inside, high - inside);
        if tried.replace(control) == Some(control) {
            continue;
        }
        let walk = Walk::start(&wanted.scene, options, &report.cancel);
        let walk = walk.map_err(|error| error.to_string())?;
        let place = live.segments[leg.segment].place;
        let z = live.atlas.guess(place, control, walk.system());
        match walk.standing_near(z, control, leg.direction) {
            Ok(walk) => {
                report.result(Arc::new(Stored::of(&walk, wanted.part, [0, 0])));
                return Ok(());
            }
            Err(Lost::Cancelled) => return Ok(()),
            Err(lost) => refused = lost,
        }
    }
    Err(match refused {
        Lost::Unstable => "on this mesh the state there is not stable".to_owned(),
        _ => format!(
            "there is no such state on this mesh: the live loop is of {} points",
            live.points
        ),
    })
}

/// The live loop of a scene, as fine as it gets.
///
/// # Errors
/// The first value of the scene that is not allowed.
pub fn live_loop(scene: &Arc<Scene>, report: &Reporter<Arc<LiveState>>) -> Result<(), String> {
    let model = scene.model().map_err(|error| error.to_string())?;
    let mut loops = LiveLoops::obeying(&report.cancel);
    report.result(live_state(&mut loops, scene, &model, Fineness::Fine));
    Ok(())
}

/// The next of the live loops.
pub(super) fn live_state(
    loops: &mut LiveLoops,
    scene: &Scene,
    model: &Model,
    fineness: Fineness,
) -> Arc<LiveState> {
    let began = Instant::now();
    let found = catch_unwind(AssertUnwindSafe(|| loops.next(scene, model, fineness)));
    let found = match found {
        Ok(found) => found.map_err(|error| error.to_string()),
        // What it holds after a panic is not to be trusted; `next` has taken it out.
        Err(_) => Err("the atlas stopped with a fault of its own".to_owned()),
    };
    Arc::new(LiveState {
        found,
        fineness,
        milliseconds: began.elapsed().as_secs_f64() * 1e3,
    })
}

/// What is heard of several figures while they are computed.
#[derive(Debug)]
pub enum Progress {
    /// A figure goes on.
    Working {
        /// Its index in the list.
        index: usize,
        /// Share that is done, 0 to 1.
        done: f64,
        /// What is being done.
        what: String,
    },
    /// A figure is done, or has failed.
    Done {
        /// Its index in the list.
        index: usize,
        /// The figure, or why there is none.
        figure: Result<Figure, Stopped>,
        /// Wall seconds it took.
        seconds: f64,
    },
}

/// Computes the figures in this order, as many at a time as there are cores, those that can be of
/// another scene than the paper's of `scene`; `tell` is called on this thread. After a request to
/// stop every figure is still answered for, most of them by [`Stopped::Cancelled`].
pub fn compute(
    entries: &[&Entry],
    size: Size,
    scene: Option<&Scene>,
    cancel: &Cancel,
    tell: &mut dyn FnMut(Progress),
) {
    let next = AtomicUsize::new(0);
    let (sender, receiver) = unbounded();
    let work = || {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(entry) = entries.get(index) else {
                return;
            };
            let (began, pace) = (Instant::now(), Pace::default());
            let figure = one(entry, size, scene, cancel, &mut |done, what| {
                if pace.is_due() {
                    let _ = sender.send(Progress::Working {
                        index,
                        done,
                        what: what.to_owned(),
                    });
                }
            });
            let _ = sender.send(Progress::Done {
                index,
                figure,
                seconds: began.elapsed().as_secs_f64(),
            });
        }
    };
    system::on_every_core(THREADS_MAX.min(entries.len()), work, || {
        let mut left = entries.len();
        while left > 0
            && let Ok(progress) = receiver.recv()
        {
            left -= usize::from(matches!(progress, Progress::Done { .. }));
            tell(progress);
        }
    });
}

fn one(
    entry: &Entry,
    size: Size,
    scene: Option<&Scene>,
    cancel: &Cancel,
    tell: &mut (dyn FnMut(f64, &str) + Send),
) -> Result<Figure, Stopped> {
    if cancel.requested() {
        return Err(Stopped::Cancelled);
    }
    let mut task = Task::new(size, cancel, tell).of(scene);
    catch_unwind(AssertUnwindSafe(|| (entry.compute)(&mut task)))
        .unwrap_or_else(|_| Err(Stopped::Failed(FAULT.to_owned())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper::scenes;
    use crate::scene::Points;

    fn entry(number: usize, compute: fn(&mut Task<'_>) -> Result<Figure, Stopped>) -> Entry {
        let scene = || scenes::flat("", 100.0, Points::Square(16), 2.0, 0.5, 0.1);
        Entry {
            number,
            title: "",
            look_for: "",
            scene,
            compute,
        }
    }

    fn good(task: &mut Task<'_>) -> Result<Figure, Stopped> {
        task.tell(0.5, "half")?;
        Ok(Figure::default())
    }

    #[test]
    fn a_figure_that_fails_or_panics_does_not_take_the_others_along() {
        let entries = [
            entry(1, good),
            entry(2, |_| Err(Stopped::Failed("no".to_owned()))),
            entry(3, |_| panic!("for the test")),
            entry(4, good),
        ];
        let list: Vec<&Entry> = entries.iter().collect();
        let mut done = [None, None, None, None];
        compute(
            &list,
            Size::Quick,
            None,
            &Cancel::default(),
            &mut |progress| {
                if let Progress::Done { index, figure, .. } = progress {
                    done[index] = Some(figure.map(|_| ()));
                }
            },
        );
        assert_eq!(done[0], Some(Ok(())));
        assert_eq!(done[1], Some(Err(Stopped::Failed("no".to_owned()))));
        assert!(
            matches!(&done[2], Some(Err(Stopped::Failed(words))) if words.contains("fault of its \
                own"))
        );
        assert_eq!(done[3], Some(Ok(())));
    }

    #[test]
    fn a_request_to_stop_reaches_every_figure() {
        let entries: Vec<Entry> = (0..20).map(|i| entry(i, good)).collect();
        let list: Vec<&Entry> = entries.iter().collect();
        let cancel = Cancel::default();
        let (mut done, mut cancelled) = (0, 0);
        compute(&list, Size::Quick, None, &cancel, &mut |progress| {
            if let Progress::Done { figure, .. } = progress {
                cancel.request();
                if matches!(figure, Err(Stopped::Cancelled)) {
                    cancelled += 1;
                } else {
                    done += 1;
                }
            }
        });
        assert_eq!(done + cancelled, 20);
        assert!(done >= 1, "the first was done before the request");
    }
}
