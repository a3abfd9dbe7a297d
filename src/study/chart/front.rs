//! The Pareto front: what nothing else beats in both cost and error.

use super::{Judged, Verdict};

/// Which of the points (cost, error) are on the front: no other is at most as dear and at most as
/// wrong, and less of one of the two. A point with a number that is not finite is never on it, and
/// beats nothing.
pub fn front(points: &[(f64, f64)]) -> Vec<bool> {
    let finite = |(cost, error): (f64, f64)| cost.is_finite() && error.is_finite();
    let beats = |a: (f64, f64), b: (f64, f64)| finite(a) && a.0 <= b.0 && a.1 <= b.1 && a != b;
    points
        .iter()
        .map(|&b| finite(b) && !points.iter().any(|&a| beats(a, b)))
        .collect()
}

/// Marks the rows on the fronts of dissipated energy against transforms and against processor time.
/// Failures are on none; below `floor`, the reference's own error, nothing is told apart.
pub(super) fn mark(rows: &mut [Judged], floor: f64) {
    let on_front = |cost: fn(&Judged) -> f64| {
        let error = |row: &Judged| match row.verdict {
            Verdict::Done => row.errors.dissipated_energy.max(floor),
            _ => f64::NAN,
        };
        front(
            &rows
                .iter()
                .map(|row| (cost(row), error(row)))
                .collect::<Vec<_>>(),
        )
    };
    let by_transforms = on_front(|row| row.transforms as f64);
    let by_time = on_front(|row| row.processor_seconds);
    for ((row, transforms), time) in rows.iter_mut().zip(by_transforms).zip(by_time) {
        (row.pareto_transforms, row.pareto_time) = (transforms, time);
    }
}
