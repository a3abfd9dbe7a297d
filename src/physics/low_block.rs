//! The Hessian among the longest waves of an even system, exact and dense.
//!
//! Between cosine waves the entries are look-ups in one transform D of gamma'': cos a cos b =
//! (cos(a+b) + cos(a-b))/2, so that mean(gamma'' cos(k) cos(l) cos(k') cos(l')) is the mean of D at
//! (k +- k', l +- l'). All soft modes live among the longest waves: the block is a preconditioner
//! that leaves two to four iterations, and its negative pivots tell the Morse index.

mod whole;

use super::system::{Fields, System, Workspace};
use crate::numerics::dense::{Factor, add, dot, scale};
use crate::numerics::eigen::{EigenLimits, EigenPairs, smallest};
use crate::numerics::threads::Cancel;
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, SQRT_2};

pub use whole::Unfolding;

/// Symmetry of a mode about the axes of an even pattern, and under x <-> y. A Hessian at an even
/// field keeps the first, at one with u(x, y) = u(y, x) also the second.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Class {
    /// Any even mode.
    Even,
    /// Even, v(x, y) = v(y, x): bulge and dimple themselves; where such a mode goes soft the branch
    /// folds.
    Symmetric,
    /// Even, v(x, y) = -v(y, x): where such a mode goes soft the symmetry breaks.
    Antisymmetric,
    /// On a line system: even in x times a wave cos(2 pi k y/L), outside the system itself if
    /// k > 0; where such a mode with k = 1 goes soft a ridge breaks up. (On a half-space one with
    /// more waves along y is always stiffer.)
    Varicose(usize),
    /// The same, odd in x: where such a mode with k = 1 goes soft a ridge meanders. With k = 0 the
    /// ridge slides.
    Sinuous(usize),
    /// Odd in x and in y.
    Odd,
    /// The same, v(x, y) = v(y, x).
    OddSymmetric,
    /// The same, v(x, y) = -v(y, x).
    OddAntisymmetric,
    /// Odd in x, even in y: where the pattern slides along x.
    OddAlongX,
    /// Odd in y, even in x.
    OddAlongY,
}

impl Class {
    /// Of all fields of a system of even or odd ones.
    pub fn of(system: &System) -> Self {
        match system.is_odd() {
            [false, false] => Class::Even,
            [true, false] => Class::OddAlongX,
            [false, true] => Class::OddAlongY,
            [true, true] => Class::Odd,
        }
    }

    /// 1 where modes are even along x and along y, -1 where they are odd.
    pub fn parity(self) -> [f64; 2] {
        match self {
            Class::Even | Class::Symmetric | Class::Antisymmetric | Class::Varicose(_) => {
                [1.0, 1.0]
            }
            Class::Odd | Class::OddSymmetric | Class::OddAntisymmetric => [-1.0, -1.0],
            Class::OddAlongX | Class::Sinuous(_) => [-1.0, 1.0],
            Class::OddAlongY => [1.0, -1.0],
        }
    }

    /// Factor that modes get under x <-> y, if it joins them.
    fn exchange(self) -> Option<f64> {
        match self {
            Class::Symmetric | Class::OddSymmetric => Some(1.0),
            Class::Antisymmetric | Class::OddAntisymmetric => Some(-1.0),
            _ => None,
        }
    }

    /// Waves along y beside those of the block.
    fn modulation(self) -> usize {
        match self {
            Class::Varicose(waves) | Class::Sinuous(waves) => waves,
            _ => 0,
        }
    }

    /// Projects amplitudes of an even square system onto the class.
    pub fn project(self, system: &System, z: &mut [f64]) {
        let (Some(sign), [1.0, _]) = (self.exchange(), self.parity()) else {
            return;
        };
        let n = system.shape().0;
        for k in 0..n {
            for l in 0..=k {
                let (a, b) = (z[k * n + l], z[l * n + k]);
                z[k * n + l] = 0.5 * (a + sign * b);
                z[l * n + k] = 0.5 * (b + sign * a);
            }
        }
    }
}

/// The dense block with its factors, shortest waves first: only the last pivots, of the longest
/// waves, can be negative.
#[derive(Clone, Debug)]
pub struct LowBlock {
    class: Class,
    /// Wave numbers (k, l) in units of 2 pi/L, one of each pair (k, l), (l, k) where the class
    /// joins them.
    waves: Vec<[usize; 2]>,
    /// Half the norms of the waves.
    weights: Vec<f64>,
    /// The body's stiffness of the waves (E* per length).
    elastic: Vec<f64>,
    /// The least of all others on the mesh.
    beyond: f64,
    ny: usize,
    nx: usize,
    /// Lower triangle, row by row; empty before the first [`LowBlock::assemble`].
    hessian: Vec<f64>,
    /// The same of what joins it to all other waves, for [`LowBlock::most_below`].
    joined: Vec<f64>,
    /// The sliding mode that is left out.
    slide: Option<Vec<f64>>,
    factor: Factor,
    floor: f64,
}

/// Least pivot of a block over [`System::stiffness_unit`]: sliding modes have none, soft ones
/// little.
pub(super) const FLOOR: f64 = 0.01;
/// Least share of a pattern's amplitude, times its wave number, for it to slide.
const SLIDES: f64 = 1e-6;
/// Most iterations towards the softest modes.
const LOWEST: usize = 40;
/// Most steps towards the softest mode of a block.
const SOFTEST: usize = 300;
/// When it is good enough: its residual over its eigenvalue, or, where that vanishes, over the
/// floor of the pivots. The error of the eigenvalue goes with the square of the residual.
const RESIDUAL: f64 = 2e-3;
const NEAR_ZERO: f64 = 1e-4;

impl LowBlock {
    /// The waves of `class` no longer than `reach` of an even `system`, at least one.
    pub fn new(system: &System, class: Class, reach: f64) -> Self {
        let (ny, nx) = system.shape();
        let [first_x, first_y] = class.parity().map(|parity| usize::from(parity < 0.0));
        let mut waves: Vec<[usize; 2]> = (first_x..nx)
            .flat_map(|k| (first_y..ny).map(move |l| [k, l]))
            .filter(|&[k, l]| {
                let joined = match class.exchange() {
                    Some(1.0) => k >= l,
                    Some(_) => k > l,
                    None => true,
                };
                let still = k + l + class.modulation() == 0;
                joined && !still && (k as f64).hypot(l as f64) <= reach
            })
            .collect();
        waves.sort_by_key(|[k, l]| std::cmp::Reverse(k * k + l * l));
        let waves_of = |w: &[usize; 2]| (w[0] as f64).hypot((w[1] + class.modulation()) as f64);
        let body = system.body();
        let stiffness = |w: &[usize; 2]| body.elastic().stiffness(system.grid().q1() * waves_of(w));
        let elastic = waves.iter().map(stiffness).collect();
        // On the points of the mesh there is a sine of nx or ny waves, and no cosine.
        let beyond = (0..=nx)
            .flat_map(|k| (0..=ny).map(move |l| [k, l]))
            .filter(|w| w[0] == nx || w[1] == ny || (w[0] as f64).hypot(w[1] as f64) > reach)
            .map(|w| stiffness(&w))
            .fold(f64::INFINITY, f64::min);
        // A wave (k, k) stands alone where the class joins others in pairs.
        let alone = |w: &[usize; 2]| class.exchange() == Some(1.0) && w[0] == w[1];
        let single = |w: &[usize; 2]| if alone(w) { FRAC_1_SQRT_2 } else { 1.0 };
        let weights = waves
            .iter()
            .map(|w| single(w) * norm(w[0]) * norm(w[1]) / 2.0)
            .collect();
        Self {
            class,
            waves,
            weights,
            elastic,
            beyond,
            ny,
            nx,
            hessian: Vec::new(),
            joined: Vec::new(),
            slide: None,
            factor: Factor::default(),
            floor: 0.0,
        }
    }

    /// The symmetry of its modes.
    pub fn class(&self) -> Class {
        self.class
    }

    /// True once assembled.
    pub fn is_ready(&self) -> bool {
        !self.factor.is_empty()
    }

    /// Drops the block: it belongs to a state that is left behind.
    pub fn forget(&mut self) {
        self.factor.clear();
    }

    /// Assembles and factorises for a surface with these `fields`. One transform.
    pub fn refresh(&mut self, system: &System, fields: &Fields, ws: &mut Workspace) {
        let mut d = vec![0.0; system.dimension()];
        let mean = system.stiffness_amplitudes(fields, &mut d, ws);
        self.assemble(system, &d, mean);
    }

    /// Assembles and factorises from the amplitudes `d` and the `mean` of gamma''. No transform.
    pub fn assemble(&mut self, system: &System, d: &[f64], mean: f64) {
        self.fill(system, d, mean);
        self.floor = FLOOR * system.stiffness_unit();
        self.factor
            .factorise(&self.hessian, self.waves.len(), self.floor);
    }

    /// Assembles for a pattern `z`, whose sliding mode is left out of all counts; factorised by
    /// [`LowBlock::negative_below`].
    pub fn assemble_beside(&mut self, system: &System, d: &[f64], mean: f64, z: &[f64]) {
        self.fill(system, d, mean);
        self.floor = FLOOR * system.stiffness_unit();
        self.slide = self.sliding(z);
    }

    /// Number of eigenvalues below `shift` (E* per length) beside the sliding mode: a border of the
    /// matrix takes it out, and brings one positive and one negative eigenvalue itself. Factorises.
    pub fn negative_below(&mut self, shift: f64) -> usize {
        let mut shifted = self.hessian.clone();
        let n = self.waves.len();
        (0..n).for_each(|i| shifted[i * (i + 3) / 2] -= shift);
        if let Some(slide) = &self.slide {
            shifted.extend(slide);
            shifted.push(0.0);
        }
        let borders = usize::from(self.slide.is_some());
        self.factor
            .factorise(&shifted, n + borders, f64::MIN_POSITIVE);
        self.factor.negative() - borders
    }

    /// Coefficients of du/dx or du/dy of the even pattern `z`, of norm 1; `None` where it does not
    /// slide within the class.
    pub fn sliding(&self, z: &[f64]) -> Option<Vec<f64>> {
        let axis = match self.class {
            Class::OddAlongX | Class::Sinuous(0) => 0,
            Class::OddAlongY => 1,
            _ => return None,
        };
        let along = |w: &[usize; 2]| w[axis] as f64 * z[w[0] * self.ny + w[1]];
        let mut slide: Vec<f64> = self.waves.iter().map(along).collect();
        let size = dot(&slide, &slide).sqrt();
        // A trace of a wave is no motion of the pattern.
        (size > SLIDES * dot(z, z).sqrt()).then(|| {
            scale(&mut slide, 1.0 / size);
            slide
        })
    }

    /// The softest modes (E* per length; coefficients of norm 1), `count` of them, beside the
    /// sliding mode. The factors must be of [`LowBlock::negative_below`] zero.
    pub fn lowest(&self, count: usize) -> EigenPairs {
        let n = self.waves.len();
        let limits = EigenLimits {
            pairs: count,
            least: 1,
            most: LOWEST,
            relative: RESIDUAL,
            absolute: NEAR_ZERO * self.floor,
        };
        // The longest waves come last. Nothing smooth is orthogonal to these.
        let start = |mode: usize| {
            let wave = |i: usize| (1.0 + (2.0 * i as f64 + mode as f64).sin()) / (n - i) as f64;
            let unit = |i: usize| {
                if n - 1 - i == mode {
                    1.0
                } else {
                    0.1 * wave(i)
                }
            };
            (0..n).map(unit).collect()
        };
        smallest(
            |x, out| out.copy_from_slice(&self.product(x)),
            (0..(count + 1).min(n)).map(start).collect(),
            self.slide.as_slice(),
            |r, out| out.copy_from_slice(&self.positive(r)),
            limits,
            &Cancel::default(),
        )
    }

    /// The inverse of |block| times coefficients `r`.
    fn positive(&self, r: &[f64]) -> Vec<f64> {
        let mut x = r.to_vec();
        x.resize(self.factor.size(), 0.0);
        self.factor.solve_positive(&mut x);
        x.truncate(r.len());
        x
    }

    /// The same over all waves of the class, of which these are the last ones, by elasticity and
    /// `stiffness` (E* per length) where they are short.
    pub fn positive_among(&self, all: &Self, r: &[f64], stiffness: f64) -> Vec<f64> {
        let short = r.len() - self.waves.len();
        let mut x: Vec<f64> = r[..short]
            .iter()
            .zip(&all.elastic)
            .map(|(r, elastic)| r / (elastic + stiffness))
            .collect();
        x.extend(self.positive(&r[short..]));
        x
    }

    fn fill(&mut self, system: &System, d: &[f64], mean: f64) {
        self.hessian = self.multiplication(system, d, mean);
        for (i, elastic) in self.elastic.iter().enumerate() {
            self.hessian[i * (i + 3) / 2] += elastic;
        }
    }

    /// Multiplication by a field with amplitudes `d` and this `mean`, among the waves of the block:
    /// the lower triangle, row by row.
    fn multiplication(&self, system: &System, d: &[f64], mean: f64) -> Vec<f64> {
        let table = Table::new(system, d, mean, &self.waves);
        let (n, parity) = (self.waves.len(), self.class.parity());
        let mut lower = Vec::with_capacity(n * (n + 1) / 2);
        for (i, (&a, &weight)) in self.waves.iter().zip(&self.weights).enumerate() {
            for (&b, &other) in self.waves[..=i].iter().zip(&self.weights) {
                let mut sum = table.products(a, b, parity);
                // (e_kl +- e_lk)/sqrt 2 with itself and others.
                if let Some(sign) = self.class.exchange() {
                    sum += sign * table.products(a, [b[1], b[0]], parity);
                }
                lower.push(weight * other * sum);
            }
        }
        lower
    }

    /// Number of waves.
    pub fn size(&self) -> usize {
        self.waves.len()
    }

    /// Number of negative eigenvalues of the block.
    pub fn negative(&self) -> usize {
        self.factor.negative()
    }

    /// The smallest eigenvalue (E* per length), with its mode of norm 1 as coefficients of the
    /// block's waves, from the coefficients `start`: each step takes the softest combination of the
    /// mode and its residual over the factors. Their pivots are no smaller than the floor, so that
    /// they alone would lead to the mode of another matrix.
    pub fn softest(&self, start: Option<&[f64]>) -> (f64, Vec<f64>) {
        let n = self.waves.len();
        let mut x = match start {
            Some(x) => x.to_vec(),
            // Nothing smooth is orthogonal to this.
            None => (0..n)
                .map(|i| (1.0 + (2.0 * i as f64).sin()) / (n - i) as f64)
                .collect(),
        };
        normalise(&mut x);
        let mut image = self.product(&x);
        let mut value = dot(&x, &image);
        for _ in 0..SOFTEST {
            let mut d: Vec<f64> = image
                .iter()
                .zip(&x)
                .map(|(image, x)| image - value * x)
                .collect();
            if dot(&d, &d).sqrt() < (RESIDUAL * value.abs()).max(NEAR_ZERO * self.floor) {
                break;
            }
            self.factor.solve_positive(&mut d);
            let along = dot(&d, &x);
            add(&mut d, -along, &x);
            normalise(&mut d);
            let pushed = self.product(&d);
            let (mixed, other) = (dot(&x, &pushed), dot(&d, &pushed));
            let angle = 0.5 * (2.0 * mixed).atan2(value - other) + FRAC_PI_2;
            let (sin, cos) = angle.sin_cos();
            let turn = |a: &mut [f64], b: &[f64]| {
                a.iter_mut()
                    .zip(b)
                    .for_each(|(a, b)| *a = cos * *a + sin * b);
            };
            turn(&mut x, &d);
            turn(&mut image, &pushed);
            value = dot(&x, &image);
        }
        (value, x)
    }

    /// Amplitudes in an even `system` of a mode given by coefficients of the block's waves, as
    /// [`LowBlock::softest`] returns it. A modulation of a line becomes one of a square system.
    pub fn mode(&self, coefficients: &[f64], system: &System) -> Vec<f64> {
        let mut z = vec![0.0; system.dimension()];
        if let Class::Varicose(waves) = self.class {
            let ny = system.shape().0;
            for (w, x) in self.waves.iter().zip(coefficients) {
                if let Some(z) = z.get_mut(w[0] * ny + waves) {
                    *z = *x;
                }
            }
        } else {
            self.scatter(coefficients, &mut z);
        }
        z
    }

    /// `out` gets, on the waves of the block, the inverse of |block| (negative pivots turned
    /// positive) times `r`; the rest is kept.
    pub fn precondition(&self, r: &[f64], out: &mut [f64]) {
        self.within(r, out, Factor::solve_positive);
    }

    /// `out` gets, on the waves of the block, what `work` makes of `r` by its factors; the rest is
    /// kept.
    pub(super) fn within(&self, r: &[f64], out: &mut [f64], work: impl Fn(&Factor, &mut [f64])) {
        let mut x = self.gather(r);
        work(&self.factor, &mut x);
        self.scatter(&x, out);
    }

    /// The Hessian times coefficients.
    fn product(&self, x: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; x.len()];
        for i in 0..x.len() {
            let row = &self.hessian[i * (i + 1) / 2..][..=i];
            out[i] += dot(row, &x[..=i]);
            out[..i]
                .iter_mut()
                .zip(row)
                .for_each(|(out, h)| *out += h * x[i]);
        }
        out
    }

    /// Where the amplitude of a wave is stored ([`System::odd`]).
    fn place(&self, k: usize, l: usize) -> usize {
        let [x, y] = self.class.parity();
        let k = if x < 0.0 { self.nx - k } else { k };
        let l = if y < 0.0 { self.ny - l } else { l };
        k * self.ny + l
    }

    fn gather(&self, z: &[f64]) -> Vec<f64> {
        let at = |k: usize, l: usize| z[self.place(k, l)];
        let pick = |&[k, l]: &[usize; 2]| match self.class.exchange() {
            Some(sign) if k != l => FRAC_1_SQRT_2 * (at(k, l) + sign * at(l, k)),
            _ => at(k, l),
        };
        self.waves.iter().map(pick).collect()
    }

    fn scatter(&self, x: &[f64], z: &mut [f64]) {
        for (&[k, l], &x) in self.waves.iter().zip(x) {
            let Some(mirrored) = self.class.exchange().filter(|_| k != l) else {
                z[self.place(k, l)] = x;
                continue;
            };
            z[self.place(k, l)] = FRAC_1_SQRT_2 * x;
            z[self.place(l, k)] = mirrored * FRAC_1_SQRT_2 * x;
        }
    }
}

/// mean(gamma'' cos_p cos_q) for all sums and differences of the block's waves.
struct Table {
    means: Vec<f64>,
    width: usize,
}

impl Table {
    fn new(system: &System, d: &[f64], mean: f64, waves: &[[usize; 2]]) -> Self {
        let (ny, nx) = system.shape();
        let most = |axis: usize| waves.iter().map(|w| w[axis]).max().unwrap_or(0);
        let width = 2 * most(1).max(most(0).min(ny - 1)) + 1;
        // On the points of the mesh cos_(2m-p) = -cos_p.
        let fold = |p: usize, m: usize| {
            if p < m {
                (p, 1.0)
            } else {
                (2 * m - p, if p == m { 0.0 } else { -1.0 })
            }
        };
        let at = |p: usize, q: usize| {
            let ((p, a), (q, b)) = (fold(p, nx), fold(q, ny));
            match (p, q) {
                _ if a * b == 0.0 => 0.0,
                (0, 0) => a * b * mean,
                _ => a * b * d[p * ny + q] / (norm(p) * norm(q)),
            }
        };
        let height = 2 * most(0).max(most(1)) + 1;
        Self {
            means: (0..height * width)
                .map(|i| at(i / width, i % width))
                .collect(),
            width,
        }
    }

    /// Four times mean(gamma'' a b) of two waves, cosines or sines along each axis.
    #[inline]
    fn products(&self, a: [usize; 2], b: [usize; 2], [x, y]: [f64; 2]) -> f64 {
        let (upper, lower) = ((a[0] + b[0]) * self.width, a[0].abs_diff(b[0]) * self.width);
        let (sum, difference) = (a[1] + b[1], a[1].abs_diff(b[1]));
        let at = |i: usize| self.means[i];
        x * (y * at(upper + sum) + at(upper + difference))
            + y * at(lower + sum)
            + at(lower + difference)
    }
}

/// 1 over the root mean square of cos_k.
fn norm(k: usize) -> f64 {
    if k == 0 { 1.0 } else { SQRT_2 }
}

fn normalise(x: &mut [f64]) {
    let length = dot(x, x).sqrt();
    scale(x, 1.0 / length);
}
