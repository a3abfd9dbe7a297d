//! The elastic energy vhat of a pattern at zero range by boundary elements (the paper's Sect. 3.2):
//! contact points are held at u = 0, the energy of the others is minimised at a given mean
//! displacement, and the mesh is extrapolated away.
//!
//! With w the displacement under a unit load on the free points, K w = 1 there, K = q E*/2, energy
//! is u0^2/(2 mean(w)): so vhat = L/(2 E* mean(w)). Patterns are mirror-symmetric, so that cosine
//! waves of half a line or a quarter of a square do.
//!
//! With each point a pixel of side da, the edge lies a fraction of da beyond the free pixels (0.19
//! if straight, 0.13 all around a circle of their area), which makes an error of first order in da;
//! a circle's ragged edge adds noise, averaged over radii within da.

use super::{Stopped, Task};
use crate::numerics::cosine::{Cosine, CosineScratch};
use crate::numerics::krylov::{CgEnd, CgLimits, conjugate_gradients};
use crate::numerics::threads::Cancel;
use crate::physics::theory::circular::Kind;
use std::cell::RefCell;
use std::f64::consts::PI;

/// Residual of a solve over its load; the energy's error is its square.
const TOLERANCE: f64 = 1e-9;
const PRODUCTS: usize = 1000;

/// A number with the uncertainty of its extrapolation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The number.
    pub value: f64,
    /// How far it may be off.
    pub error: f64,
}

/// Half of a line cell or a quarter of a square cell, L = 1.
struct Cell {
    cosine: Cosine,
    /// q E*/2 of the cosine waves.
    stiffness: Vec<f64>,
    /// The approximate inverse of the same.
    softness: Vec<f64>,
}

/// Working memory: field, amplitudes, and the transform's own.
struct Workspace {
    field: Vec<f64>,
    amplitudes: Vec<f64>,
    scratch: CosineScratch,
}

impl Cell {
    /// A quarter of a square cell with `half` points along a side, or with `ny` = 1 half a line.
    fn new(half: usize, ny: usize) -> Self {
        let waves = (0..half).flat_map(|k| (0..ny).map(move |l| (k as f64).hypot(l as f64)));
        let stiffness: Vec<f64> = waves.map(|waves| PI * waves).collect();
        let softness = stiffness.iter().map(|k| 1.0 / (k + 1.0)).collect();
        Self {
            cosine: Cosine::new(ny, half),
            stiffness,
            softness,
        }
    }

    /// `out` = sum over waves of `factors` times the field that is `x` on the `free` points and
    /// zero elsewhere, on the free points.
    fn convolve(
        &self,
        factors: &[f64],
        free: &[usize],
        x: &[f64],
        out: &mut [f64],
        ws: &mut Workspace,
    ) {
        ws.field.fill(0.0);
        free.iter().zip(x).for_each(|(&i, x)| ws.field[i] = *x);
        self.cosine
            .analyse(&ws.field, &mut ws.amplitudes, &mut ws.scratch);
        ws.amplitudes
            .iter_mut()
            .zip(factors)
            .for_each(|(z, factor)| *z *= factor);
        self.cosine.synthesise(
            &ws.amplitudes,
            ws.amplitudes[0],
            &mut ws.field,
            &mut ws.scratch,
        );
        free.iter()
            .zip(out)
            .for_each(|(&i, out)| *out = ws.field[i]);
    }

    /// vhat where only the `free` points may leave u = 0; `None` if cancelled.
    fn elastic_energy(&self, free: &[usize], cancel: &Cancel) -> Option<f64> {
        let points = self.stiffness.len();
        let ws = RefCell::new(Workspace {
            field: vec![0.0; points],
            amplitudes: vec![0.0; points],
            scratch: self.cosine.scratch(),
        });
        let solution = conjugate_gradients(
            |x, out| self.convolve(&self.stiffness, free, x, out, &mut ws.borrow_mut()),
            &vec![1.0; free.len()],
            |r, out| self.convolve(&self.softness, free, r, out, &mut ws.borrow_mut()),
            &[],
            CgLimits::new(TOLERANCE, PRODUCTS),
            cancel,
        );
        (solution.end == CgEnd::Converged)
            .then(|| 0.5 * points as f64 / solution.x.iter().sum::<f64>())
    }
}

/// vhat of a ridge with the inner `free` of `points` along a line cell out of contact (both even);
/// `None` if cancelled.
pub fn ridge(points: usize, free: usize, cancel: &Cancel) -> Option<f64> {
    assert!(0 < free && free < points && free.is_multiple_of(2));
    Cell::new(points / 2, 1).elastic_energy(&(0..free / 2).collect::<Vec<_>>(), cancel)
}

/// vhat of a ridge with a share alpha = free/points out of contact, extrapolated from that mesh and
/// ones with `levels` - 1 halved spacings (vhat is a power series in the spacing); `None` if
/// cancelled. The error is the change by the coarsest or the finest mesh, whichever is larger.
pub fn ridge_extrapolated(
    points: usize,
    free: usize,
    levels: usize,
    cancel: &Cancel,
) -> Option<Estimate> {
    let mut values = Vec::with_capacity(levels);
    for level in 0..levels {
        let spacing = 0.5_f64.powi(level as i32);
        values.push((spacing, ridge(points << level, free << level, cancel)?));
    }
    let value = at_zero_spacing(&values);
    let less =
        [&values[1..], &values[..levels - 1]].map(|fewer| (value - at_zero_spacing(fewer)).abs());
    Some(Estimate {
        value,
        error: less[0].max(less[1]),
    })
}

/// vhat'(alpha) of the same ridge, by differences of fourth order between shares 2/points and
/// 4/points to either side; the error contains what those of second order change.
pub fn ridge_slope(points: usize, free: usize, levels: usize, cancel: &Cancel) -> Option<Estimate> {
    let at = |free: usize| ridge_extrapolated(points, free, levels, cancel);
    let step = 2.0 / points as f64;
    let [a, b, c, d] = [at(free - 4)?, at(free - 2)?, at(free + 2)?, at(free + 4)?];
    let value = (8.0 * (c.value - b.value) - (d.value - a.value)) / (12.0 * step);
    let truncation = (value - (c.value - b.value) / (2.0 * step)).abs();
    Some(Estimate {
        value,
        error: truncation + (8.0 * (b.error + c.error) + a.error + d.error) / (12.0 * step),
    })
}

/// The polynomial through all (spacing, value) at spacing zero (Richardson).
fn at_zero_spacing(values: &[(f64, f64)]) -> f64 {
    let weight = |i: usize| -> f64 {
        values
            .iter()
            .enumerate()
            .filter(|(j, _)| *j != i)
            .map(|(_, (h, _))| h / (h - values[i].0))
            .product()
    };
    values
        .iter()
        .enumerate()
        .map(|(i, (_, value))| weight(i) * value)
        .sum()
}

/// vhat of a disc of diameter `size` L from a mesh of `points` along a side of a square cell and
/// ones of two and four times as many, with `radii` discs on each; `None` if cancelled.
///
/// A parabola in the spacing; its error is what the coarsest mesh changes, plus three standard
/// errors of the ragged edge.
pub fn disc_extrapolated(
    kind: Kind,
    size: f64,
    points: usize,
    radii: usize,
    cancel: &Cancel,
) -> Option<Estimate> {
    let mut values = Vec::with_capacity(3);
    let mut noise = 0.0_f64;
    // Weights of the parabola at spacing zero.
    for (level, weight) in [(0, 1.0 / 3.0), (1, -2.0), (2, 8.0 / 3.0)] {
        let mesh = disc_on_mesh(kind, size, points << level, radii, cancel)?;
        values.push((0.5_f64.powi(level), mesh.value));
        noise = noise.hypot(weight * mesh.error);
    }
    let value = at_zero_spacing(&values);
    Some(Estimate {
        value,
        error: (value - at_zero_spacing(&values[1..])).abs() + 3.0 * noise,
    })
}

/// vhat of a disc of diameter `size` L on a mesh of `points` along a side of a square cell,
/// averaged over `radii`, with its standard error; `None` if cancelled.
///
/// Each disc is taken for the circle of its area, and those of radii half a spacing smaller to half
/// a spacing larger are fitted by a straight line in the variable in which vhat is smooth.
pub fn disc_on_mesh(
    kind: Kind,
    size: f64,
    points: usize,
    radii: usize,
    cancel: &Cancel,
) -> Option<Estimate> {
    let half = points / 2;
    let cell = Cell::new(half, half);
    let smooth = |size: f64| {
        if kind == Kind::Dimple {
            size.powi(3)
        } else {
            1.0 / size
        }
    };
    let mut samples = Vec::with_capacity(radii);
    for i in 0..radii {
        let radius = 0.5 * size * points as f64 + (i as f64 + 0.5) / radii as f64 - 0.5;
        let inside = |i: &usize| ((i % half) as f64 + 0.5).hypot((i / half) as f64 + 0.5) <= radius;
        let (disc, rest): (Vec<usize>, Vec<usize>) = (0..half * half).partition(inside);
        let diameter = 4.0 * (disc.len() as f64 / PI).sqrt() / points as f64;
        let free = if kind == Kind::Dimple { &disc } else { &rest };
        samples.push([
            diameter - size,
            cell.elastic_energy(free, cancel)? * smooth(diameter),
        ]);
    }
    let (value, noise) = line_at_zero(&samples);
    Some(Estimate {
        value: value / smooth(size),
        error: noise / smooth(size),
    })
}

/// The straight line of least squares through (x, y) at x = 0, with the standard error of that
/// value.
fn line_at_zero(samples: &[[f64; 2]]) -> (f64, f64) {
    let n = samples.len() as f64;
    let mean = |of: &dyn Fn(&[f64; 2]) -> f64| samples.iter().map(of).sum::<f64>() / n;
    let (x, y) = (mean(&|s| s[0]), mean(&|s| s[1]));
    let xx = mean(&|s| (s[0] - x).powi(2));
    let slope = if xx > 0.0 {
        mean(&|s| (s[0] - x) * (s[1] - y)) / xx
    } else {
        0.0
    };
    let value = y - slope * x;
    let scatter = mean(&|s| (s[1] - value - slope * s[0]).powi(2));
    (
        value,
        (scatter / (n - 2.0).max(1.0) * (1.0 + x * x / xx.max(f64::MIN_POSITIVE))).sqrt(),
    )
}

/// Something of a ridge by boundary elements, by share alpha out of contact.
pub(super) type Sample = (f64, Estimate);

/// vhat at `count` shares alpha, dense towards both ends: equal steps of ln(abar/alpha), abar from
/// 1/64 to 15/16.
pub(super) fn ridge_energies(count: usize, task: &mut Task<'_>) -> Result<Vec<Sample>, Stopped> {
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
        ridge_extrapolated,
    )
}

/// vhat' on a mesh of `points`, and on finer ones, with `free` of them out of contact.
pub(super) fn ridge_slopes(
    points: usize,
    free: impl IntoIterator<Item = usize>,
    task: &mut Task<'_>,
) -> Result<Vec<Sample>, Stopped> {
    collect(points, free, task, ridge_slope)
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
