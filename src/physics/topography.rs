//! Measured heights: as a file has them, levelled, cut to a square, filled, made periodic; and the
//! statistics of any height field.
//!
//! The statistics are those of SurfaceTopography (<https://doi.org/10.1088/2051-672X/ac860a>):
//! root mean squares of the height about its mean (Sq), of the gradient by forward differences, and
//! of the Laplacian by central second differences; twice the area's rms curvature.

use super::parameter::Refusal;
use crate::numerics::eigen::symmetric_eigen;
use crate::numerics::harmonic;
use crate::numerics::vector::{add, dot};
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
        let filled = harmonic::fill(&mut heights, [side / nx as f64, side / ny as f64]);
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
