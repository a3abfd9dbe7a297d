//! The paper's figures in the background: a page for the window, or several at once, one on each
//! core.

use super::job::{FAULT, Job, Pace, Reporter, Wake};
use super::protocol::{Page, PageContent};
use super::system::{self, Instant};
use crate::numerics::cancel::Cancel;
use crate::paper::errata::errata;
use crate::paper::overlay::ZeroRange;
use crate::paper::{Entry, Figure, GALLERY, Size, Stopped, Task};
use crossbeam_channel::unbounded;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Most figures at once.
const THREADS_MAX: usize = 8;

/// Computes a page at the quick size.
pub(super) fn page(page: Page, wake: Wake) -> Job<PageContent> {
    Job::start(wake, move |report| match content(page, report) {
        Ok(content) => {
            report.result(content);
            Ok(())
        }
        Err(Stopped::Cancelled) => Ok(()),
        Err(Stopped::Failed(why)) => Err(why),
    })
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

/// Computes the figures in this order, as many at a time as there are cores; `tell` is called on
/// this thread. After a request to stop every figure is still answered for, most of them by
/// [`Stopped::Cancelled`].
pub fn compute(entries: &[&Entry], size: Size, cancel: &Cancel, tell: &mut dyn FnMut(Progress)) {
    let next = AtomicUsize::new(0);
    let (sender, receiver) = unbounded();
    let work = || {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(entry) = entries.get(index) else {
                return;
            };
            let (began, pace) = (Instant::now(), Pace::default());
            let figure = one(entry, size, cancel, &mut |done, what| {
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
    cancel: &Cancel,
    tell: &mut (dyn FnMut(f64, &str) + Send),
) -> Result<Figure, Stopped> {
    if cancel.requested() {
        return Err(Stopped::Cancelled);
    }
    let mut task = Task::new(size, cancel, tell);
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
        compute(&list, Size::Quick, &Cancel::default(), &mut |progress| {
            if let Progress::Done { index, figure, .. } = progress {
                done[index] = Some(figure.map(|_| ()));
            }
        });
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
        compute(&list, Size::Quick, &cancel, &mut |progress| {
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
