//! Dimple and bulge of an adhesion without range (Griffith), in a periodic square cell: their
//! branches, their asymptotes (Eqs 28 and 29), right and as printed, and their elastic energy.
//!
//! A dimple of diameter alpha L is out of contact, or a bulge of diameter abar L in contact; `size`
//! is either. With u~ = u0/sqrt(gamma L/E*), energies per area in units of gamma and W = 0 for the
//! flat separated state,
//!
//! ```text
//! W = u~^2 vhat(size) - ahat(size),   ahat = 1 - pi alpha^2/4 (dimple), pi abar^2/4 (bulge),
//! ```
//!
//! and equilibrium is dW/dsize = 0 (Eq. 17), with p~ = -2 u~^2 vhat (Eqs 18 and 19). Each pattern
//! has one fold: a largest u~. The dimple is stable against growing and shrinking below the fold's
//! size, the bulge above it.

use super::boundary;
use crate::numerics::dense::Factor;
use crate::numerics::functions::{Chebyshev, spherical_bessel};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, SQRT_2, TAU};
use std::sync::OnceLock;

/// The largest diameter in units of L: neighbours that touch are singular.
pub const SIZE_MAX: f64 = 0.976;
/// The smallest diameter of which [`Pattern::size`] knows.
const SIZE_MIN: f64 = 1e-4;
/// Points of the interpolant: its relative error is below 1e-8, as that of the values.
const POINTS: usize = 24;

/// Which side of the edge is out of contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// The patch is out of contact, the rest in contact.
    Dimple,
    /// The patch is in contact, the rest is not.
    Bulge,
}

/// vhat of a pattern as a function of its size, and what follows.
#[derive(Debug)]
pub struct Pattern {
    kind: Kind,
    /// vhat times size^3 (dimple) or over size (bulge) and its two derivatives, as functions of
    /// -ln(1 - size): smooth up to 1.
    scaled: [Chebyshev; 3],
}

/// A state at zero range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// alpha of a dimple, abar of a bulge.
    pub size: f64,
    /// u~ = u0/sqrt(gamma L/E*).
    pub displacement: f64,
    /// p~ = p u0/gamma, negative in tension.
    pub pressure: f64,
    /// W, in units of gamma per area.
    pub energy: f64,
}

/// The dimple. The first call computes its table (a third of a second).
pub fn dimple() -> &'static Pattern {
    static PATTERN: OnceLock<Pattern> = OnceLock::new();
    PATTERN.get_or_init(|| Pattern::new(Kind::Dimple))
}

/// The bulge; as [`dimple`].
pub fn bulge() -> &'static Pattern {
    static PATTERN: OnceLock<Pattern> = OnceLock::new();
    PATTERN.get_or_init(|| Pattern::new(Kind::Bulge))
}

impl Pattern {
    fn new(kind: Kind) -> Self {
        let scaled = Chebyshev::interpolate(0.0, -(1.0 - SIZE_MAX).ln(), POINTS, |x| {
            // Nodes keep off the end x = 0.
            let size = -(-x).exp_m1();
            let vhat = elastic_energy(kind, size);
            if kind == Kind::Dimple {
                vhat * size.powi(3)
            } else {
                vhat / size
            }
        });
        let slope = scaled.derivative();
        let curvature = slope.derivative();
        Self {
            kind,
            scaled: [scaled, slope, curvature],
        }
    }

    /// vhat and its first two derivatives by size, for 0 < size <= [`SIZE_MAX`].
    pub fn elastic_energy(&self, size: f64) -> [f64; 3] {
        let x = -(-size).ln_1p();
        let [f, fx, fxx] = [0, 1, 2].map(|i| self.scaled[i].at(x));
        // dx/dsize = 1/(1 - size).
        let g = 1.0 / (1.0 - size);
        let (f1, f2) = (fx * g, (fxx + fx) * g * g);
        match self.kind {
            Kind::Dimple => {
                let s = 1.0 / size;
                let cube = s * s * s;
                [
                    f * cube,
                    (f1 - 3.0 * f * s) * cube,
                    (f2 - 6.0 * f1 * s + 12.0 * f * s * s) * cube,
                ]
            }
            Kind::Bulge => [f * size, f1 * size + f, f2 * size + 2.0 * f1],
        }
    }

    /// Share of the cell in contact, ahat (Eq. 16).
    pub fn contact_area(&self, size: f64) -> f64 {
        let disc = FRAC_PI_4 * size * size;
        if self.kind == Kind::Dimple {
            1.0 - disc
        } else {
            disc
        }
    }

    /// The equilibrium of this `size` (Eqs 17 and 18), 0 < size <= [`SIZE_MAX`].
    pub fn state(&self, size: f64) -> State {
        let vhat = self.elastic_energy(size);
        let contact = FRAC_PI_2 * size * if self.kind == Kind::Dimple { -1.0 } else { 1.0 };
        let square = contact / vhat[1];
        let energy = square * vhat[0] - self.contact_area(size);
        State {
            size,
            displacement: square.sqrt(),
            pressure: -2.0 * square * vhat[0],
            energy,
        }
    }

    /// The fold: the largest u~ at which the pattern exists.
    pub fn fold(&self) -> State {
        // 1/u~^2 = vhat'/ahat' is least where vhat''/vhat' = 1/size; it falls before and rises
        // after.
        self.state(boundary(0.1, SIZE_MAX, |size| {
            let vhat = self.elastic_energy(size);
            vhat[2] / vhat[1] < 1.0 / size
        }))
    }

    /// Size of the pattern at `displacement` u~, on the part of its branch whose energy is smallest
    /// among neighbouring sizes; `None` where there is none, or beyond [`SIZE_MAX`].
    pub fn size(&self, displacement: f64) -> Option<f64> {
        let fold = self.fold();
        if !(displacement > 0.0 && displacement <= fold.displacement) {
            return None;
        }
        let below = |size: f64| self.state(size).displacement < displacement;
        let small = self.kind == Kind::Dimple;
        let end = if small { SIZE_MIN } else { SIZE_MAX };
        if !below(end) {
            return None;
        }
        Some(if small {
            boundary(end, fold.size, below)
        } else {
            boundary(fold.size, end, |size| !below(size))
        })
    }

    /// The equilibrium at `displacement` u~; `None` as in [`Pattern::size`].
    pub fn at(&self, displacement: f64) -> Option<State> {
        self.size(displacement).map(|size| self.state(size))
    }

    /// The equilibrium whose circle begins to give way to an ellipse (axes along the cell's): the
    /// curvature of vhat against the stretch at constant area vanishes. The dimple is stable below
    /// this size, the bulge above the fold and below this size.
    ///
    /// An upper estimate of the limit: edges may bend in other ways too. Takes a tenth of a second,
    /// once.
    pub fn elliptic_limit(&self) -> State {
        static LIMITS: [OnceLock<f64>; 2] = [OnceLock::new(), OnceLock::new()];
        let (dimple, place) = (
            self.kind == Kind::Dimple,
            &LIMITS[usize::from(self.kind == Kind::Dimple)],
        );
        let between = if dimple { [0.86, 0.87] } else { [0.65, 0.66] };
        self.state(
            *place.get_or_init(|| secant(between, |size| ellipse_curvature(self.kind, size))),
        )
    }
}

/// (vhat(stretch) - vhat(0))/stretch^2, which is half the curvature, without its next order.
fn ellipse_curvature(kind: Kind, size: f64) -> f64 {
    let circle = elastic_energy(kind, size);
    let at = |stretch: f64| (ellipse_energy(kind, size, stretch) - circle) / (stretch * stretch);
    (4.0 * at(0.005) - at(0.01)) / 3.0
}

/// A root near `a` and `b` of a function that is nearly straight between.
fn secant([mut a, mut b]: [f64; 2], f: impl Fn(f64) -> f64) -> f64 {
    let (mut fa, mut fb) = (f(a), f(b));
    for _ in 0..5 {
        if (b - a).abs() < 1e-5 {
            break;
        }
        (a, b) = (b, b - fb * (b - a) / (fb - fa));
        (fa, fb) = (fb, f(b));
    }
    b
}

/// vhat of a small dimple (Eq. 28 corrected): 3/(2 alpha^3).
pub fn small_dimple(alpha: f64) -> f64 {
    1.5 / alpha.powi(3)
}

/// vhat of a small dimple as printed in Eq. 28: 8/(sqrt(3 pi) alpha^3), 1.74 times too large.
pub fn small_dimple_printed(alpha: f64) -> f64 {
    8.0 / ((3.0 * PI).sqrt() * alpha.powi(3))
}

/// vhat of a small bulge (Eq. 28 corrected): abar/2.
pub fn small_bulge(abar: f64) -> f64 {
    0.5 * abar
}

/// vhat of a small bulge as printed in Eq. 28: sqrt(2) abar^(3/2).
pub fn small_bulge_printed(abar: f64) -> f64 {
    SQRT_2 * abar.powf(1.5)
}

/// p~ of a small dimple (Eq. 29 corrected): -3 (pi/9)^(3/5) u~^(4/5) = -(1.79301 u~)^(4/5).
pub fn small_dimple_pressure(displacement: f64) -> f64 {
    -3.0 * (PI / 9.0).powf(0.6) * displacement.powf(0.8)
}

/// p~ of a small dimple as printed in Eq. 29: -(4 u~/3)^(4/5).
pub fn small_dimple_pressure_printed(displacement: f64) -> f64 {
    -(4.0 * displacement / 3.0).powf(0.8)
}

/// vhat of a disc of diameter `size` L (alpha of a dimple, abar of a bulge), 0 < size < 1. Relative
/// error at most about 1e-9 up to 0.9, 3e-9 up to 0.95 and 1e-8 up to 0.98.
pub fn elastic_energy(kind: Kind, size: f64) -> f64 {
    ellipse_energy(kind, size, 0.0)
}

/// vhat of an ellipse with the area of that disc, its axes along the lattice and longer and shorter
/// by factors e^{± stretch}.
pub fn ellipse_energy(kind: Kind, size: f64, stretch: f64) -> f64 {
    let sum = Sum::new(kind, size, stretch);
    let mut matrix = sum.apart();
    sum.add_lattice(&mut matrix);
    let mut x = vec![0.0; sum.terms.len()];
    x[0] = 1.0;
    let mut factor = Factor::default();
    factor.factorise(&matrix, x.len(), 0.0);
    assert_eq!(factor.negative(), 0, "an elastic energy is positive");
    factor.solve(&mut x);
    match kind {
        Kind::Dimple => 9.0 / (4.0 * x[0]),
        Kind::Bulge => x[0] / 4.0,
    }
}

/// One term of the series: its angular order m and the order of its spherical Bessel function.
#[derive(Clone, Copy)]
struct Term {
    turns: usize,
    order: usize,
}

/// The elastic energy of a square lattice of round (or slightly elliptic) patches as a series, to
/// eight digits or more.
///
/// The displacement of an opened patch (dimple) is a sum of s^m sqrt(1 - s^2) P_j(s^2) cos(m phi),
/// s = r/a; the stress in a contact patch (bulge) is the same with 1/sqrt(1 - s^2). Edges are so
/// met exactly, and the energy is a quadratic form whose least value at given mean displacement
/// converges exponentially with the number of terms. The Fourier transform of a term is
/// j_{m+2j+1}(k)/k for a dimple and j_{m+2j}(k) for a bulge (times 2 pi a^2 cos(m phi)), k = q a,
/// so that the form is a lattice sum
///
/// ```text
/// S = sum_{q != 0} j_mu j_nu cos(m phi) cos(m' phi) * (bulge: 1/q, dimple: q/k^2),
/// vhat = 9/(4 (1/S)_00) for a dimple, (1/S)_00/4 for a bulge.
/// ```
///
/// The sum falls as 1/q^3 only. It is split by a smooth cut-off w: the part with 1 - w sees the
/// patch itself but no other, and is the integral of an isolated patch, which is known.
struct Sum {
    kind: Kind,
    /// Semi-axes in units of L.
    axes: [f64; 2],
    terms: Vec<Term>,
    /// 1 + the highest order of a Bessel function.
    orders: usize,
    /// The cut-off w(k) = e^{-t} (1 + t + ... + t^{K-1}/(K-1)!), t = (k/scale)^2: flat at zero, and
    /// entire, so that its image in real space ends within the gap between patches.
    scale: f64,
    flatness: usize,
}

impl Sum {
    fn new(kind: Kind, size: f64, stretch: f64) -> Self {
        let axes = [0.5 * size * stretch.exp(), 0.5 * size * (-stretch).exp()];
        let gap = 1.0 - 2.0 * axes[0].max(axes[1]);
        assert!(gap > 0.0, "patches must not touch");
        // Edges that face each other across a gap bend the series over a share sqrt(gap) of the
        // circle.
        let highest = 4 * (0.84 / gap.sqrt()).ceil().max(3.0) as usize;
        let (step, offset) = (
            if stretch == 0.0 { 4 } else { 2 },
            usize::from(kind == Kind::Dimple),
        );
        let terms = (0..=highest).step_by(step).flat_map(|turns| {
            (turns..=highest).step_by(2).map(move |order| Term {
                turns,
                order: order + offset,
            })
        });
        // What reaches across a narrow gap is a small part of the whole.
        let (reach, flatness) = if gap < 0.1 { (10.0, 6) } else { (14.0, 10) };
        Self {
            kind,
            axes,
            terms: terms.collect(),
            orders: highest + 2,
            scale: reach / gap * 0.5 * size,
            flatness,
        }
    }

    fn cut_off(&self, k: f64) -> f64 {
        let t = (k / self.scale).powi(2);
        let (mut term, mut sum) = (1.0, 0.0);
        for i in 0..self.flatness {
            sum += term;
            term *= t / (i + 1) as f64;
        }
        sum * (-t).exp()
    }

    /// The largest k at which the cut-off, times what it cuts off, counts.
    fn end(&self) -> f64 {
        self.scale * ((self.flatness as f64).sqrt() + 3.2)
    }

    /// 1/q or q/k^2, where q/k = `ratio`.
    fn weight(&self, k: f64, ratio: f64) -> f64 {
        if self.kind == Kind::Bulge {
            1.0 / (k * ratio)
        } else {
            ratio / k
        }
    }

    /// q/k in the direction (x, y)/k of stretched wave vectors.
    fn ratio(&self, [x, y]: [f64; 2]) -> f64 {
        (x / self.axes[0]).hypot(y / self.axes[1])
    }

    /// The share 1 - w of the matrix, as the integral of one patch (lower triangle).
    fn apart(&self) -> Vec<f64> {
        let n = self.orders;
        // int_0^inf j_mu j_nu dk is diagonal among orders of one parity, and w is even in k: the
        // trapezoidal rule is exact but for what wraps around.
        let step = TAU / (2.0 + 24.0 / self.scale);
        let mut radial = vec![0.0; n * n];
        let mut j = vec![0.0; n];
        for i in 0..(self.end() / step) as usize {
            let k = i as f64 * step;
            spherical_bessel(k, &mut j);
            let w = self.cut_off(k) * step * if i == 0 { 0.5 } else { 1.0 };
            for (row, a) in radial.chunks_exact_mut(n).zip(&j) {
                row.iter_mut().zip(&j).for_each(|(r, b)| *r -= w * a * b);
            }
        }
        for order in 0..n {
            radial[order * n + order] += FRAC_PI_2 / (2 * order + 1) as f64;
        }
        let angular = self.angular();
        let mut matrix = Vec::with_capacity(self.terms.len() * (self.terms.len() + 1) / 2);
        for (i, a) in self.terms.iter().enumerate() {
            for b in &self.terms[..=i] {
                let both =
                    angular[(a.turns + b.turns) / 2] + angular[a.turns.abs_diff(b.turns) / 2];
                matrix.push(radial[a.order * n + b.order] * both);
            }
        }
        matrix
    }

    /// Half the mean over angles of cos(2 i phi) weight/(2 pi a_x a_y), for the products of two
    /// cosines.
    fn angular(&self) -> Vec<f64> {
        let points = 256;
        let norm = 0.5 / (TAU * self.axes[0] * self.axes[1] * points as f64);
        let angle = |p: usize| TAU * p as f64 / points as f64;
        let weights: Vec<f64> = (0..points)
            .map(|p| norm * self.weight(1.0, self.ratio([angle(p).cos(), angle(p).sin()])))
            .collect();
        (0..self.orders)
            .map(|i| {
                weights
                    .iter()
                    .enumerate()
                    .map(|(p, w)| w * (2.0 * i as f64 * angle(p)).cos())
                    .sum()
            })
            .collect()
    }

    /// Adds the share w of the matrix, as the sum over wave vectors.
    fn add_lattice(&self, matrix: &mut [f64]) {
        let round = self.axes[0] == self.axes[1];
        let [ax, ay] = self.axes;
        let end = self.end();
        let mut j = vec![0.0; self.orders];
        let mut values = vec![0.0; self.terms.len()];
        for x in 0..=(end / (TAU * ax)) as usize {
            // A disc needs an eighth of the plane, an ellipse a quarter.
            let highest = if round {
                x
            } else {
                (end / (TAU * ay)) as usize
            };
            for y in usize::from(x == 0)..=highest {
                let [kx, ky] = [TAU * x as f64 * ax, TAU * y as f64 * ay];
                let k = kx.hypot(ky);
                if k > end {
                    break;
                }
                let mirrors = if x == 0 || y == 0 { 2.0 } else { 4.0 }
                    * if round && x != y { 2.0 } else { 1.0 };
                let factor =
                    mirrors * self.cut_off(k) * self.weight(k, self.ratio([kx / k, ky / k]));
                spherical_bessel(k, &mut j);
                let angle = ky.atan2(kx);
                let mut turns = (usize::MAX, 0.0);
                for (value, term) in values.iter_mut().zip(&self.terms) {
                    if term.turns != turns.0 {
                        turns = (term.turns, (term.turns as f64 * angle).cos());
                    }
                    *value = j[term.order] * turns.1;
                }
                let mut rest = &mut *matrix;
                for (i, a) in values.iter().enumerate() {
                    let (row, below) = rest.split_at_mut(i + 1);
                    row.iter_mut()
                        .zip(&values)
                        .for_each(|(m, b)| *m += factor * a * b);
                    rest = below;
                }
            }
        }
    }
}
