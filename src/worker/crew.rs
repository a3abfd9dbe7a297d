//! Several figures at once: a crew of threads, one for each core, takes figures off a list and hands them back as they are done.

use crate::numerics::cancel::Cancel;
use crate::paper::{Entry, Figure, Size, Stopped, Task};
use crossbeam_channel::{Sender, unbounded};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Most threads.
const CREW_MAX: usize = 8;
/// Shortest time between two words on the progress of a figure.
const PACE: Duration = Duration::from_millis(100);

/// What the crew says.
#[derive(Debug)]
pub enum News {
    /// A figure goes on.
    Progress {
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

/// Computes the figures in this order, as many at a time as there are cores; `tell` is called on this thread. After a request to stop
/// every figure is still answered for, most of them by [`Stopped::Cancelled`].
pub fn compute(entries: &[&Entry], size: Size, cancel: &Cancel, tell: &mut dyn FnMut(News)) {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let next = AtomicUsize::new(0);
    let (post, letters) = unbounded();
    std::thread::scope(|scope| {
        for _ in 0..cores.min(CREW_MAX).min(entries.len()) {
            let (post, next) = (post.clone(), &next);
            scope.spawn(move || {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(entry) = entries.get(index) else { return };
                    let began = Instant::now();
                    let figure = one(entry, index, size, cancel, &post);
                    let _ = post.send(News::Done { index, figure, seconds: began.elapsed().as_secs_f64() });
                }
            });
        }
        drop(post);
        for news in letters {
            tell(news);
        }
    });
}

fn one(entry: &Entry, index: usize, size: Size, cancel: &Cancel, post: &Sender<News>) -> Result<Figure, Stopped> {
    let mut told: Option<Instant> = None;
    let mut observe = |done: f64, what: &str| {
        if told.is_none_or(|at| at.elapsed() >= PACE) {
            told = Some(Instant::now());
            let _ = post.send(News::Progress { index, done, what: what.to_owned() });
        }
    };
    if cancel.requested() {
        return Err(Stopped::Cancelled);
    }
    let mut task = Task::new(size, cancel, &mut observe);
    catch_unwind(AssertUnwindSafe(|| (entry.compute)(&mut task)))
        .unwrap_or_else(|_| Err(Stopped::Failed("the computation stopped with a fault of its own".to_owned())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::scene::Points;
    use crate::paper::scenes;

    fn entry(number: usize, compute: fn(&mut Task<'_>) -> Result<Figure, Stopped>) -> Entry {
        let scene = || scenes::flat("", 100.0, Points::Square(16), 2.0, 0.5, 0.1);
        Entry { number, title: "", look_for: "", scene, compute }
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
        compute(&list, Size::Quick, &Cancel::default(), &mut |news| {
            if let News::Done { index, figure, .. } = news {
                done[index] = Some(figure.map(|_| ()));
            }
        });
        assert_eq!(done[0], Some(Ok(())));
        assert_eq!(done[1], Some(Err(Stopped::Failed("no".to_owned()))));
        assert!(matches!(&done[2], Some(Err(Stopped::Failed(words))) if words.contains("fault of its own")));
        assert_eq!(done[3], Some(Ok(())));
    }

    #[test]
    fn a_request_to_stop_reaches_every_figure() {
        let entries: Vec<Entry> = (0..20).map(|i| entry(i, good)).collect();
        let list: Vec<&Entry> = entries.iter().collect();
        let cancel = Cancel::default();
        let (mut done, mut cancelled) = (0, 0);
        compute(&list, Size::Quick, &cancel, &mut |news| {
            if let News::Done { figure, .. } = news {
                cancel.request();
                if matches!(figure, Err(Stopped::Cancelled)) { cancelled += 1 } else { done += 1 }
            }
        });
        assert_eq!(done + cancelled, 20);
        assert!(done >= 1, "the first was done before the request");
    }
}
