//! The Hessian among the longest waves of an even system, exact and dense.
//!
//! Between cosine waves the entries are look-ups in one transform D of gamma'': cos a cos b =
//! (cos(a+b) + cos(a-b))/2, so that mean(gamma'' cos(k) cos(l) cos(k') cos(l')) is the mean of D at
//! (k +- k', l +- l'). All soft modes live among the longest waves: the block is a preconditioner
//! that leaves two to four iterations, and its negative pivots tell the Morse index.

use super::system::{Fields, System, Workspace};
use crate::numerics::factor::Factor;
use crate::numerics::vector::{add, dot, scale};
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, SQRT_2};

/// Symmetry of even fields under x <-> y; both are kept by a Hessian at a field that has the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Any even field.
    Even,
    /// u(x, y) = u(y, x): bulge and dimple themselves; where such a mode goes soft the branch
    /// folds.
    Symmetric,
    /// u(x, y) = -u(y, x): where such a mode goes soft the symmetry breaks.
    Antisymmetric,
    /// On a line system: even in x times cos(2 pi y/L), outside the system itself; where such a
    /// mode goes soft a ridge breaks up. (A modulation with more waves along y is always stiffer.)
    Varicose,
    /// The same, odd in x: where such a mode goes soft a ridge meanders.
    Sinuous,
}

impl Class {
    /// Projects amplitudes of an even square system onto the class.
    pub fn project(self, system: &System, z: &mut [f64]) {
        let sign = match self {
            Class::Even | Class::Varicose | Class::Sinuous => return,
            Class::Symmetric => 1.0,
            Class::Antisymmetric => -1.0,
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
    /// q E*/2 of the waves.
    elastic: Vec<f64>,
    ny: usize,
    /// Lower triangle, row by row; empty before the first [`LowBlock::assemble`].
    hessian: Vec<f64>,
    factor: Factor,
    floor: f64,
}

/// Least pivot of a block, in units of q1, twice the stiffness of the longest wave: sliding modes
/// have none, soft ones little.
pub(super) const FLOOR: f64 = 0.01;
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
        let mut waves: Vec<[usize; 2]> = (0..nx)
            .flat_map(|k| (0..ny).map(move |l| [k, l]))
            .filter(|&[k, l]| {
                let joined = match class {
                    Class::Symmetric => k >= l && k > 0,
                    Class::Antisymmetric => k > l,
                    Class::Even | Class::Sinuous => k + l > 0,
                    Class::Varicose => true,
                };
                joined && (k as f64).hypot(l as f64) <= reach
            })
            .collect();
        waves.sort_by_key(|[k, l]| std::cmp::Reverse(k * k + l * l));
        let modulated = matches!(class, Class::Varicose | Class::Sinuous);
        let waves_of =
            |w: &[usize; 2]| (w[0] as f64).hypot(if modulated { 1.0 } else { w[1] as f64 });
        let elastic = waves
            .iter()
            .map(|w| 0.5 * system.grid().q1() * waves_of(w))
            .collect();
        // A wave (k, k) stands alone where the class joins others in pairs.
        let alone = |w: &[usize; 2]| class == Class::Symmetric && w[0] == w[1];
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
            ny,
            hessian: Vec::new(),
            factor: Factor::default(),
            floor: 0.0,
        }
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
        let table = Table::new(system, d, mean, &self.waves);
        let n = self.waves.len();
        self.hessian.clear();
        self.hessian.reserve(n * (n + 1) / 2);
        for (i, (&a, &weight)) in self.waves.iter().zip(&self.weights).enumerate() {
            for (&b, &other) in self.waves[..=i].iter().zip(&self.weights) {
                let sum = match self.class {
                    Class::Even | Class::Varicose => table.cosines(a, b),
                    Class::Sinuous => table.sines(a[0], b[0]),
                    // (e_kl +- e_lk)/sqrt 2 with itself and others.
                    Class::Symmetric => table.cosines(a, b) + table.cosines(a, [b[1], b[0]]),
                    Class::Antisymmetric => table.cosines(a, b) - table.cosines(a, [b[1], b[0]]),
                };
                self.hessian.push(weight * other * sum);
            }
            *self.hessian.last_mut().expect("just pushed") += self.elastic[i];
        }
        self.floor = FLOOR * system.grid().q1();
        self.factor.factorise(&self.hessian, n, self.floor);
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
        if self.class == Class::Varicose {
            let ny = system.shape().0;
            for (w, x) in self.waves.iter().zip(coefficients) {
                if w[0] * ny + 1 < z.len() {
                    z[w[0] * ny + 1] = *x;
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
        let mut x = self.gather(r);
        self.factor.solve_positive(&mut x);
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

    /// `out` gets, on the waves of the block, F y for the factors F F^T of that inverse; the rest
    /// is kept.
    pub fn spread(&self, y: &[f64], out: &mut [f64]) {
        let mut x = self.gather(y);
        self.factor.spread(&mut x);
        self.scatter(&x, out);
    }

    /// `out` gets, on the waves of the block, F^T r; the rest is kept.
    pub fn gathered(&self, r: &[f64], out: &mut [f64]) {
        let mut x = self.gather(r);
        self.factor.gather(&mut x);
        self.scatter(&x, out);
    }

    fn gather(&self, z: &[f64]) -> Vec<f64> {
        let at = |k: usize, l: usize| z[k * self.ny + l];
        let pick = |&[k, l]: &[usize; 2]| match self.class {
            _ if k == l => at(k, l),
            Class::Even | Class::Varicose | Class::Sinuous => at(k, l),
            Class::Symmetric => FRAC_1_SQRT_2 * (at(k, l) + at(l, k)),
            Class::Antisymmetric => FRAC_1_SQRT_2 * (at(k, l) - at(l, k)),
        };
        self.waves.iter().map(pick).collect()
    }

    fn scatter(&self, x: &[f64], z: &mut [f64]) {
        for (&[k, l], &x) in self.waves.iter().zip(x) {
            let mirrored = match self.class {
                Class::Symmetric if k != l => 1.0,
                Class::Antisymmetric => -1.0,
                _ => {
                    z[k * self.ny + l] = x;
                    continue;
                }
            };
            z[k * self.ny + l] = FRAC_1_SQRT_2 * x;
            z[l * self.ny + k] = mirrored * FRAC_1_SQRT_2 * x;
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

    /// Four times mean(gamma'' cos_a cos_b).
    #[inline]
    fn cosines(&self, a: [usize; 2], b: [usize; 2]) -> f64 {
        let (upper, lower) = ((a[0] + b[0]) * self.width, a[0].abs_diff(b[0]) * self.width);
        let (sum, difference) = (a[1] + b[1], a[1].abs_diff(b[1]));
        let at = |i: usize| self.means[i];
        at(upper + sum) + at(upper + difference) + at(lower + sum) + at(lower + difference)
    }

    /// Four times mean(gamma'' sin_a sin_b) on a line.
    fn sines(&self, a: usize, b: usize) -> f64 {
        2.0 * (self.means[a.abs_diff(b) * self.width] - self.means[(a + b) * self.width])
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
