//! Work shared among the threads of the processor: large fields piece by piece, and whole
//! computations side by side.
//!
//! Small fields stay on the caller's thread: waking another takes longer than their transform.

use rayon::ThreadPoolBuilder;
use std::sync::atomic::{AtomicUsize, Ordering};

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

/// Does `work` on 0 to `count`, begun in this order, as many at a time as there are threads. They
/// are threads of their own: what takes seconds must not stand before the transforms of somebody
/// else.
pub fn side_by_side(count: usize, work: impl Fn(usize) + Sync) {
    let crew = count.min(rayon::current_num_threads());
    let Some(pool) = (crew > 1)
        .then(|| ThreadPoolBuilder::new().num_threads(crew).build().ok())
        .flatten()
    else {
        return (0..count).for_each(work);
    };
    // No more tasks than threads: a thread that waits for a transform would begin any that is left
    // over, and finish it first.
    let next = AtomicUsize::new(0);
    let run = || {
        std::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed))
            .take_while(|i| *i < count)
            .for_each(&work);
    };
    pool.in_place_scope(|scope| (0..crew).for_each(|_| scope.spawn(|_| run())));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_piece_of_work_is_done_once() {
        for count in [0, 1, 2, 3, 40] {
            let done: Vec<AtomicUsize> = (0..count).map(|_| AtomicUsize::new(0)).collect();
            side_by_side(count, |i| {
                done[i].fetch_add(1, Ordering::Relaxed);
            });
            assert!(
                done.iter().all(|times| times.load(Ordering::Relaxed) == 1),
                "of {count}"
            );
        }
    }
}
