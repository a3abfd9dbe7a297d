//! Measured heights: as a file has them, levelled, cut to a square, filled, made periodic; and the
//! statistics of any height field.
//!
//! The statistics are those of SurfaceTopography (<https://doi.org/10.1088/2051-672X/ac860a>):
//! root mean squares of the height about its mean (Sq), of the gradient by forward differences, and
//! of the Laplacian by central second differences; twice the area's rms curvature.

use super::parameter::Refusal;
use crate::numerics::dense::{add, dot, symmetric_eigen};
use crate::numerics::krylov::{CgLimits, conjugate_gradients};
use crate::numerics::threads::Cancel;
use ndarray::Array2;
use std::f64::consts::PI;
use std::path::PathBuf;

/// A height map as a file has it.
#[derive(Clone, Debug)]
pub struct Topography {
    /// Where it was read from; empty if from nowhere.
    pub file: PathBuf,
    /// What kind of file that is.
    pub format: &'static str,
    /// Heights, shape (ny, nx), y upwards; NaN where nothing was measured. One row is a profile.
    pub heights: Array2<f64>,
    /// Sides of the measured area along x and y, if the file says; points stand in the middle of
    /// equal rectangles.
    pub size: Option<[f64; 2]>,
    /// What heights and sides are in.
    pub unit: Unit,
}

/// The unit of a file's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// It does not say: the scene's.
    Scene,
    /// Metres.
    Metre,
}

/// The same file with the same numbers, also where nothing was measured.
impl PartialEq for Topography {
    fn eq(&self, other: &Self) -> bool {
        let bits = |map: &Self| map.heights.mapv(f64::to_bits);
        self.file == other.file
            && (self.size, self.unit) == (other.size, other.unit)
            && bits(self) == bits(other)
    }
}

/// What is taken away from the heights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detrend {
    /// Nothing.
    None,
    /// The plane of least squares.
    Tilt,
    /// The paraboloid of least squares.
    Curvature,
}

impl Detrend {
    /// The words of the scene file, in order.
    pub const WORDS: &'static [&'static str] = &["none", "tilt", "curvature"];
    /// All, in that order.
    pub const ALL: [Self; 3] = [Self::None, Self::Tilt, Self::Curvature];
}

/// How a map becomes periodic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Periodic {
    /// Beside its mirror images: twice the side, nothing altered but for kinks at the borders.
    Mirror,
    /// Faded to its mean towards the borders (a cosine over the outer eighth of each side).
    Window,
    /// Repeated as it is: it jumps at the borders, unless it is periodic already.
    AsIs,
}

impl Periodic {
    /// The words of the scene file, in order.
    pub const WORDS: &'static [&'static str] = &["mirror", "window", "as_is"];
    /// All, in that order.
    pub const ALL: [Self; 3] = [Self::Mirror, Self::Window, Self::AsIs];

    /// The word of the scene file.
    pub fn word(self) -> &'static str {
        Self::WORDS[self as usize]
    }
}

/// Share of a side over which a window fades, at either end.
const FADE: f64 = 0.125;

/// Least number of points along a side that is measured.
const POINTS_MIN: usize = 4;

/// A square map without holes, or a profile.
#[derive(Clone, Debug)]
pub struct Levelled {
    /// Heights (length), shape (ny, nx).
    pub heights: Array2<f64>,
    /// Its side (length).
    pub side: f64,
    /// Points that were not measured, and were filled.
    pub filled: usize,
    /// Points beyond the square, left out.
    pub cut: usize,
}

impl Topography {
    /// Cuts the square out of the middle, takes the trend away and fills the holes. `length` of
    /// the scene is the side along x of the whole area, heights are multiplied by `scale`.
    ///
    /// # Errors
    /// A map that is too small, or less than half of which was measured.
    pub fn level(&self, length: f64, scale: f64, detrend: Detrend) -> Result<Levelled, Refusal> {
        let (rows, columns) = self.heights.dim();
        let [x, y] = self.sides(length);
        let side = if rows == 1 { x } else { x.min(y) };
        let kept = |n: usize, whole: f64| ((n as f64 * side / whole).round() as usize).clamp(1, n);
        let (nx, ny) = (kept(columns, x), kept(rows, y));
        let (left, below) = ((columns - nx) / 2, (rows - ny) / 2);
        let mut heights = Array2::from_shape_fn((ny, nx), |(j, i)| {
            scale * self.heights[[below + j, left + i]]
        });
        let measured = heights.iter().filter(|h| h.is_finite()).count();
        let refuse = |allowed: &str| {
            let file = self.file.display();
            let value = format!("\"{file}\" with {nx} x {ny} points, {measured} of them measured");
            Err(Refusal::new("indenter.file", value, allowed))
        };
        if nx < POINTS_MIN || rows > 1 && ny < POINTS_MIN {
            return refuse("a map of at least 4 x 4 points, or a profile of at least 4");
        }
        if 2 * measured < heights.len() {
            return refuse("a map at least half of whose points were measured");
        }
        let before = heights.iter().fold(0.0, |most: f64, h| most.max(h.abs()));
        if before > 1e100 {
            return refuse("a map whose heights are at most 1e100");
        }
        remove(&mut heights, detrend);
        let filled = fill(&mut heights, [side / nx as f64, side / ny as f64]);
        Ok(Levelled {
            heights,
            side,
            filled,
            cut: self.heights.len() - nx * ny,
        })
    }

    /// Sides of the whole area where that along x is `length`; pixels are squares if the file does
    /// not say.
    fn sides(&self, length: f64) -> [f64; 2] {
        let (rows, columns) = self.heights.dim();
        let [x, y] = self.size.unwrap_or([columns as f64, rows as f64]);
        [length, length * y / x]
    }
}

/// Takes the least-squares polynomial away, fitted to what was measured.
fn remove(heights: &mut Array2<f64>, detrend: Detrend) {
    if detrend == Detrend::None {
        return;
    }
    let (rows, columns) = heights.dim();
    let place = |i: usize, n: usize| (2.0 * i as f64 + 1.0) / n as f64 - 1.0;
    let terms = |(j, i): (usize, usize)| {
        let (x, y) = (place(i, columns), place(j, rows));
        match detrend {
            Detrend::None => Vec::new(),
            Detrend::Tilt => vec![1.0, x, y],
            Detrend::Curvature => vec![1.0, x, y, x * x, x * y, y * y],
        }
    };
    let count = terms((0, 0)).len();
    let mut matrix = vec![vec![0.0; count]; count];
    let mut right = vec![0.0; count];
    for (at, h) in heights.indexed_iter().filter(|(_, h)| h.is_finite()) {
        let terms = terms(at);
        for (row, term) in matrix.iter_mut().zip(&terms) {
            add(row, *term, &terms);
        }
        add(&mut right, *h, &terms);
    }
    // A profile has no trend along y: what nothing tells stays zero.
    let (values, vectors) = symmetric_eigen(matrix);
    let mut trend = vec![0.0; count];
    for (value, vector) in values.iter().zip(&vectors) {
        if *value > 1e-9 {
            add(&mut trend, dot(vector, &right) / value, vector);
        }
    }
    for (at, h) in heights.indexed_iter_mut() {
        *h -= dot(&trend, &terms(at));
    }
}

/// Residual of the equation over its right-hand side: beyond it rounding is all that changes.
const TOLERANCE: f64 = 1e-12;

/// Most products with the matrix; a hole takes about as many as it is points wide.
const PRODUCTS_MAX: usize = 20_000;

/// No unknown.
const KNOWN: usize = usize::MAX;

/// Harmonic filling: puts into every point of `field` that is not finite the solution of the discrete Laplace
/// equation (five points, spacings `pitch` along x and y) with the finite points as boundary values
/// and no slope across the border of the field; returns how many it filled.
///
/// # Panics
/// If no point is finite.
fn fill(field: &mut Array2<f64>, [dx, dy]: [f64; 2]) -> usize {
    let (rows, columns) = field.dim();
    let mut number = Array2::from_elem((rows, columns), KNOWN);
    let mut holes = Vec::new();
    for ((j, i), h) in field.indexed_iter() {
        if !h.is_finite() {
            number[[j, i]] = holes.len();
            holes.push((j, i));
        }
    }
    if holes.is_empty() {
        return 0;
    }
    assert!(holes.len() < field.len(), "no point is known");
    // The equation in units of the stiffer link, about the mean of what is known.
    let stiff = dx.min(dy);
    let (across, up) = ((stiff / dx).powi(2), (stiff / dy).powi(2));
    let known = (field.len() - holes.len()) as f64;
    let mean = field.iter().filter(|h| h.is_finite()).sum::<f64>() / known;
    let neighbours = |(j, i): (usize, usize)| {
        let left = (i > 0).then(|| ((j, i - 1), across));
        let right = (i + 1 < columns).then(|| ((j, i + 1), across));
        let below = (j > 0).then(|| ((j - 1, i), up));
        let above = (j + 1 < rows).then(|| ((j + 1, i), up));
        [left, right, below, above].into_iter().flatten()
    };
    let links: Vec<f64> = holes
        .iter()
        .map(|&hole| neighbours(hole).map(|(_, weight)| weight).sum())
        .collect();
    let b: Vec<f64> = holes
        .iter()
        .map(|&hole| {
            let known = neighbours(hole).filter(|(at, _)| number[*at] == KNOWN);
            known.map(|(at, weight)| weight * (field[at] - mean)).sum()
        })
        .collect();
    let apply = |x: &[f64], ax: &mut [f64]| {
        for (k, &hole) in holes.iter().enumerate() {
            let pulls = neighbours(hole).filter(|(at, _)| number[*at] != KNOWN);
            let pull: f64 = pulls.map(|(at, weight)| weight * x[number[at]]).sum();
            ax[k] = links[k] * x[k] - pull;
        }
    };
    let precondition = |r: &[f64], z: &mut [f64]| {
        for ((z, r), links) in z.iter_mut().zip(r).zip(&links) {
            *z = r / links;
        }
    };
    let limits = CgLimits::new(TOLERANCE, PRODUCTS_MAX);
    let never = Cancel::default();
    let solution = conjugate_gradients(apply, &b, precondition, &[], limits, &never);
    for (&hole, value) in holes.iter().zip(&solution.x) {
        field[hole] = mean + value;
    }
    holes.len()
}

impl Levelled {
    /// Spacings along x and y (length).
    pub fn pitch(&self) -> [f64; 2] {
        let (rows, columns) = self.heights.dim();
        [self.side / columns as f64, self.side / rows as f64]
    }

    /// One period of the periodic surface, its side `period`, on the points of the file.
    pub fn periodic(&self, how: Periodic) -> Array2<f64> {
        let (rows, columns) = self.heights.dim();
        let h = &self.heights;
        match how {
            Periodic::AsIs => h.clone(),
            Periodic::Mirror => {
                let tall = if rows == 1 { 1 } else { 2 * rows };
                let back = |i: usize, n: usize| i.min((2 * n - 1).saturating_sub(i));
                Array2::from_shape_fn((tall, 2 * columns), |(j, i)| {
                    h[[back(j, rows), back(i, columns)]]
                })
            }
            Periodic::Window => {
                let weight = |(j, i): (usize, usize)| fade(i, columns) * fade(j, rows);
                let weights = Array2::from_shape_fn(h.dim(), weight);
                let level = (h * &weights).sum() / weights.sum();
                (h - level) * weights
            }
        }
    }
}

/// Weight of a point of a window; a profile has none across.
fn fade(i: usize, n: usize) -> f64 {
    let from_end = (i.min(n - 1 - i) as f64 + 0.5) / n as f64;
    if n == 1 || from_end >= FADE {
        1.0
    } else {
        0.5 * (1.0 - (PI * from_end / FADE).cos())
    }
}

/// What lies beyond the border of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Border {
    /// Nothing: differences that would reach over it are left out.
    Open,
    /// The map again.
    Periodic,
}

/// Root mean squares of a height field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistics {
    /// Of the height about its mean (length).
    pub height: f64,
    /// Of the gradient (dimensionless).
    pub gradient: f64,
    /// Of the Laplacian (1/length).
    pub laplacian: f64,
    /// From the lowest to the highest point (length).
    pub span: f64,
}

impl Statistics {
    /// Of heights at these spacings along x and y. One row is a profile: it has derivatives along x
    /// alone.
    pub fn of(h: &Array2<f64>, [dx, dy]: [f64; 2], border: Border) -> Self {
        let (rows, columns) = h.dim();
        let mean = h.sum() / h.len() as f64;
        let ends = h.iter().fold([f64::MAX, f64::MIN], |[low, high], &h| {
            [low.min(h), high.max(h)]
        });
        // The points from `before` the first on, to `after` from the last.
        let root = |before: usize, after: usize, square: &dyn Fn(usize, usize) -> f64| {
            let inside = |n: usize| match border {
                Border::Periodic => 0..n,
                Border::Open if n == 1 => 0..1,
                Border::Open => before..n.saturating_sub(after),
            };
            let points = inside(rows).len() * inside(columns).len();
            let sum: f64 = inside(rows)
                .flat_map(|j| inside(columns).map(move |i| (j, i)))
                .map(|(j, i)| square(j, i))
                .sum();
            (sum / points as f64).sqrt()
        };
        let next = |i: usize, n: usize| (i + 1) % n;
        let last = |i: usize, n: usize| (i + n - 1) % n;
        let gradient = root(0, 1, &|j, i| {
            let x = (h[[j, next(i, columns)]] - h[[j, i]]) / dx;
            let y = (h[[next(j, rows), i]] - h[[j, i]]) / dy;
            x * x + y * y
        });
        let laplacian = root(1, 1, &|j, i| {
            let bend =
                |ahead: f64, behind: f64, d: f64| (ahead - 2.0 * h[[j, i]] + behind) / (d * d);
            let x = bend(h[[j, next(i, columns)]], h[[j, last(i, columns)]], dx);
            let y = bend(h[[next(j, rows), i]], h[[last(j, rows), i]], dy);
            (x + y).powi(2)
        });
        Self {
            height: root(0, 0, &|j, i| (h[[j, i]] - mean).powi(2)),
            gradient,
            laplacian,
            span: ends[1] - ends[0],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 32, ..ProptestConfig::default() })]

        #[test]
        fn holes_in_a_harmonic_function_are_filled_by_it(
            holes in prop::collection::vec((1..23_usize, 1..17_usize), 1..120),
            scale in 1e-3..1e3,
        ) {
            // x^2 - y^2 and x y are discrete harmonic, whatever the spacings.
            let (dx, dy) = (0.7, 0.4);
            let exact = Array2::from_shape_fn((18, 24), |(j, i)| {
                let (x, y) = (i as f64 * dx, j as f64 * dy);
                scale * (x * x - y * y + 0.3 * x * y + 2.0 * x - y + 5.0)
            });
            let mut field = exact.clone();
            holes.iter().for_each(|&(i, j)| field[[j, i]] = f64::NAN);
            let missing = field.iter().filter(|h| h.is_nan()).count();
            prop_assert_eq!(fill(&mut field, [dx, dy]), missing);
            for (filled, exact) in field.iter().zip(&exact) {
                prop_assert!((filled - exact).abs() < 1e-8 * scale, "{} {}", filled, exact);
            }
        }

        #[test]
        fn what_is_filled_lies_between_what_is_around_it(
            values in prop::collection::vec(prop::option::weighted(0.4, -1.0..1.0), 80),
        ) {
            prop_assume!(values.iter().any(Option::is_some));
            let known = || values.iter().flatten().copied();
            let (low, high) = (known().fold(1.0, f64::min), known().fold(-1.0, f64::max));
            let nan: Vec<f64> = values.iter().map(|h| h.unwrap_or(f64::NAN)).collect();
            let mut field = Array2::from_shape_vec((8, 10), nan).unwrap();
            fill(&mut field, [1.0, 2.0]);
            for (filled, given) in field.iter().zip(&values) {
                prop_assert!(*filled >= low - 1e-9 && *filled <= high + 1e-9);
                prop_assert!(given.is_none_or(|given| given == *filled));
            }
        }
    }
}
