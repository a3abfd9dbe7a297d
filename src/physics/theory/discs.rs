//! A square lattice of round (or slightly elliptic) patches at zero range: the elastic energy as a
//! series, to eight digits or more.
//!
//! The displacement of an opened patch (dimple) is a sum of s^m sqrt(1 - s^2) P_j(s^2) cos(m phi),
//! s = r/a; the stress in a contact patch (bulge) is the same with 1/sqrt(1 - s^2). Edges are so
//! met exactly, and the energy is a quadratic form whose least value at given mean displacement
//! converges exponentially with the number of terms. The Fourier transform of a term is
//! j_{m+2j+1}(k)/k for a dimple and j_{m+2j}(k) for a bulge (times 2 pi a^2 cos(m phi)), k = q a,
//! so that the form is a lattice sum
//!
//! ```text
//! S = sum_{q != 0} j_mu j_nu cos(m phi) cos(m' phi) * (bulge: 1/q, dimple: q/k^2),
//! vhat = 9/(4 (1/S)_00) for a dimple, (1/S)_00/4 for a bulge.
//! ```
//!
//! The sum falls as 1/q^3 only. It is split by a smooth cut-off w: the part with 1 - w sees the
//! patch itself but no other, and is the integral of an isolated patch, which is known.

use crate::numerics::factor::Factor;
use crate::numerics::spherical_bessel;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Which side of the edge is out of contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// The patch is out of contact, the rest in contact.
    Dimple,
    /// The patch is in contact, the rest is not.
    Bulge,
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
            spherical_bessel::fill(k, &mut j);
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
                spherical_bessel::fill(k, &mut j);
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
