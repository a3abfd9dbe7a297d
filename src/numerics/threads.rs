//! Work on large fields, shared among the threads of the processor. Small ones stay on the caller's: waking another thread takes
//! longer than their transform.

/// Fewest points of a field whose work is shared.
pub const POINTS_MIN: usize = 256 * 256;
/// Points of one piece of a shared field. Fixed, so that a sum over pieces does not depend on how many threads there are.
const PIECE: usize = 1 << 14;

/// Length of the pieces of a field of `points`: all of it where sharing does not pay.
pub fn piece(points: usize) -> usize {
    if points < POINTS_MIN { points.max(1) } else { PIECE }
}

/// How many sets of working memory the transform of a field of `points` needs. Several per thread: one that is held up by other
/// programs leaves its share to the rest.
pub fn lanes(points: usize) -> usize {
    // In this order: asking for the number of threads starts them.
    if points < POINTS_MIN || rayon::current_num_threads() == 1 { 1 } else { 4 * rayon::current_num_threads() }
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
