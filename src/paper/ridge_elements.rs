//! The ridge by boundary elements, as the symbols of Figs 5 and 6 need it.

use super::boundary_elements::{self, Estimate};
use super::task::{Stopped, Task};
use crate::numerics::cancel::Cancel;

/// Something of a ridge by boundary elements, by share alpha out of contact.
pub(super) type Sample = (f64, Estimate);

/// vhat at `count` shares alpha, dense towards both ends: equal steps of ln(abar/alpha), abar from
/// 1/64 to 15/16.
pub(super) fn energies(count: usize, task: &mut Task<'_>) -> Result<Vec<Sample>, Stopped> {
    let points = 128;
    let logit = |share: f64| (share / (1.0 - share)).ln();
    let (low, high) = (logit(2.0 / points as f64), logit(1.0 - 8.0 / points as f64));
    let held = (0..count).map(|i| {
        let x = (low + (high - low) * i as f64 / (count - 1) as f64).exp();
        2 * (0.5 * points as f64 * x / (1.0 + x)).round() as usize
    });
    collect(
        points,
        held.map(|held| points - held),
        task,
        boundary_elements::ridge_extrapolated,
    )
}

/// vhat' on a mesh of `points`, and on finer ones, with `free` of them out of contact.
pub(super) fn slopes(
    points: usize,
    free: impl IntoIterator<Item = usize>,
    task: &mut Task<'_>,
) -> Result<Vec<Sample>, Stopped> {
    collect(points, free, task, boundary_elements::ridge_slope)
}

/// Points, free points, meshes.
type Method = fn(usize, usize, usize, &Cancel) -> Option<Estimate>;

fn collect(
    points: usize,
    free: impl IntoIterator<Item = usize>,
    task: &mut Task<'_>,
    method: Method,
) -> Result<Vec<Sample>, Stopped> {
    let free: Vec<usize> = free.into_iter().collect();
    let mut samples = Vec::with_capacity(free.len());
    for (i, free) in free.iter().enumerate() {
        task.tell(
            i as f64 / samples.capacity() as f64,
            "boundary elements on a line",
        )?;
        let levels = task.choose(4, 5);
        let estimate = method(points, *free, levels, task.cancel);
        let alpha = *free as f64 / points as f64;
        samples.push((alpha, estimate.ok_or_else(|| unsolved(task, alpha))?));
    }
    Ok(samples)
}

/// Why boundary elements gave nothing.
pub(super) fn unsolved(task: &Task<'_>, size: f64) -> Stopped {
    if task.cancel.requested() {
        Stopped::Cancelled
    } else {
        Stopped::Failed(format!(
            "boundary elements did not converge at a share of {size}"
        ))
    }
}
