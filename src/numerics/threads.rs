//! Work shared among the threads of the processor, large fields piece by piece and whole
//! computations side by side; and the flag that one thread raises and another reads.
//!
//! Small fields stay on the caller's thread: waking another takes longer than their transform.

use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::sync_channel;

/// Shared request to stop; clones refer to the same flag.
#[derive(Clone, Debug, Default)]
pub struct Cancel {
    flag: Arc<AtomicBool>,
    above: Option<Box<Cancel>>,
}

impl Cancel {
    /// A token for a part of the work: it hears a request to this one, and its own stops only the
    /// part.
    pub fn part(&self) -> Self {
        Self {
            flag: Arc::default(),
            above: Some(Box::new(self.clone())),
        }
    }

    /// Asks every holder of this token to stop at its next check.
    pub fn request(&self) {
        self.flag.store(true, Ordering::Relaxed);
    }

    /// True once a stop was requested.
    pub fn requested(&self) -> bool {
        self.flag.load(Ordering::Relaxed)
            || self.above.as_ref().is_some_and(|above| above.requested())
    }

    /// Takes the request back, so that the token can serve the next piece of work.
    pub fn clear(&self) {
        self.flag.store(false, Ordering::Relaxed);
    }
}

/// What is said of a computation that panicked.
pub const FAULT: &str = "the computation stopped with a fault of its own";

/// Fewest points of a field whose work is shared.
pub const POINTS_MIN: usize = 256 * 256;
/// Points of one piece of a shared field. Fixed, so that a sum over pieces does not depend on how
/// many threads there are.
const PIECE: usize = 1 << 14;

/// Length of the pieces of a field of `points`: all of it where sharing does not pay.
pub fn piece(points: usize) -> usize {
    if points < POINTS_MIN {
        points.max(1)
    } else {
        PIECE
    }
}

/// Most things that are handed on and not yet taken: they may hold fields of a whole cell.
const WAITING: usize = 2;

/// How many sets of working memory the transform of a field of `points` needs. Several per thread:
/// one that is held up by other programs leaves its share to the rest.
pub fn lanes(points: usize) -> usize {
    // In this order: asking for the number of threads starts them.
    if points < POINTS_MIN || rayon::current_num_threads() == 1 {
        1
    } else {
        4 * rayon::current_num_threads()
    }
}

/// Does `work` on every task: side by side if there are several, and threads to do them.
pub fn each<T: Send>(tasks: impl ExactSizeIterator<Item = T>, work: impl Fn(T) + Sync) {
    if tasks.len() <= 1 || rayon::current_num_threads() == 1 {
        return tasks.for_each(work);
    }
    let work = &work;
    rayon::in_place_scope(|scope| {
        for task in tasks {
            scope.spawn(move |_| work(task));
        }
    });
}

/// A thread beside the caller's, where there is more than one. Of its own: what takes seconds must
/// not stand before the transforms of somebody else.
fn another() -> Option<ThreadPool> {
    let several = rayon::current_num_threads() > 1;
    let pool = ThreadPoolBuilder::new().num_threads(1);
    several.then(|| pool.build().ok()).flatten()
}

/// What `other` and `here` give, the first on a thread of its own where there is more than one.
///
/// # Panics
/// As they do.
pub fn beside<A: Send, B>(other: impl FnOnce() -> A + Send, here: impl FnOnce() -> B) -> (A, B) {
    let Some(pool) = another() else {
        let here = here();
        return (other(), here);
    };
    let mut found = None;
    let here = pool.in_place_scope(|scope| {
        scope.spawn(|_| found = Some(other()));
        here()
    });
    (found.expect("the scope waits for it"), here)
}

/// What `make` returns, while `take` is given, in order, all that it hands on: at the same time where
/// there is more than one thread, unless those are busy with fields of so many `points`. `take` ends
/// it by false, which `make` is told when it hands on more.
///
/// # Panics
/// As they do.
pub fn handed_on<T: Send, R: Send>(
    points: usize,
    make: impl FnOnce(&mut dyn FnMut(T) -> bool) -> R + Send,
    mut take: impl FnMut(T) -> bool,
) -> R {
    let Some(pool) = (points < POINTS_MIN).then(another).flatten() else {
        return make(&mut take);
    };
    let (sender, receiver) = sync_channel(WAITING);
    let mut made = None;
    pool.in_place_scope(|scope| {
        let made = &mut made;
        scope.spawn(move |_| *made = Some(make(&mut |thing| sender.send(thing).is_ok())));
        receiver.into_iter().all(take)
    });
    made.expect("the scope waits for it")
}

/// Does `work` on these indices, begun in this order, as many at a time as there are threads, and
/// returns what came of each, by growing index. They are threads of their own, like that of [`beside`].
pub fn side_by_side<R: Send>(
    order: impl IntoIterator<Item = usize>,
    work: impl Fn(usize) -> R + Sync,
) -> Vec<R> {
    let order: Vec<usize> = order.into_iter().collect();
    let crew = order.len().min(rayon::current_num_threads());
    let pool = ThreadPoolBuilder::new().num_threads(crew);
    let pool = (crew > 1).then(|| pool.build().ok()).flatten();
    let next = AtomicUsize::new(0);
    let run = || -> Vec<(usize, R)> {
        std::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed))
            .map_while(|k| order.get(k))
            .map(|i| (*i, work(*i)))
            .collect()
    };
    // One task a thread: one that waits for a transform would begin any that is left over, and
    // finish it first.
    let mut done = match pool {
        Some(pool) => pool.broadcast(|_| run()).into_iter().flatten().collect(),
        None => run(),
    };
    done.sort_unstable_by_key(|(i, _)| *i);
    done.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_handed_on_is_taken_in_order_until_either_side_ends_it() {
        for points in [1, POINTS_MIN] {
            for most in [0, 1, 5, 100] {
                let mut taken = Vec::new();
                let make = |hand_on: &mut dyn FnMut(usize) -> bool| (0..20).all(hand_on);
                let all = handed_on(points, make, |i| {
                    taken.push(i);
                    taken.len() < most
                });
                let count = most.clamp(1, 20);
                assert!(taken.into_iter().eq(0..count), "{most} at {points} points");
                assert_eq!(all, most > 20, "{most} at {points} points");
            }
        }
    }

    #[test]
    fn every_piece_of_work_is_done_once() {
        for count in [0, 1, 2, 3, 40] {
            let done: Vec<AtomicUsize> = (0..count).map(|_| AtomicUsize::new(0)).collect();
            let results = side_by_side((0..count).rev(), |i| {
                done[i].fetch_add(1, Ordering::Relaxed);
                i
            });
            assert!(
                done.iter().all(|times| times.load(Ordering::Relaxed) == 1),
                "of {count}"
            );
            assert!(results.into_iter().eq(0..count), "of {count}");
        }
    }

    #[test]
    fn of_two_computations_each_comes_to_its_own_end() {
        let mut count = 0;
        let here = || {
            count += 1;
            "here"
        };
        assert_eq!(beside(|| 7, here), (7, "here"));
        assert_eq!(count, 1);
    }

    #[test]
    fn a_part_hears_the_whole_and_not_the_other_way_round() {
        let whole = Cancel::default();
        let (one, other) = (whole.part(), whole.part());
        let small = other.part();
        one.request();
        assert!(one.requested() && !other.requested() && !whole.requested());
        whole.request();
        assert!(other.requested() && small.requested());
    }
}
