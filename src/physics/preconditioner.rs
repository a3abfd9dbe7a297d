//! An approximate inverse of the Hessian: diagonal in Fourier space, and exact in the block of the
//! longest waves.
//!
//! The diagonal 1/(q E*/2 + k) makes the number of iterations independent of the mesh. What it
//! misses is the coupling of the few longest waves through the pattern, where all soft modes live.
//! Between waves a and b the Hessian is a look-up in the transform D of gamma'': mean(gamma'' 2 cos
//! a cos b) = Re D(a-b) + Re D(a+b), and so on for sines. That small block is factorised exactly.

use super::low_block::{Class, FLOOR, LowBlock};
use super::system::{Fields, System, Workspace};
use super::theory::critical_length;
use crate::numerics::dense::Factor;
use rustfft::num_complex::Complex;
use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

/// Reach of an exact block of one symmetry class in units of L/L_c, the number of periods of the
/// shortest wave that can soften on a flat surface: pattern edges are sharper than that.
const CLASS_REACH: f64 = 3.3;
const CLASS_REACH_LEAST: f64 = 8.0;

/// Reach of such a block of an even system on flat ground, at `most` so far; all waves of a line.
/// With `most` the block leaves out waves that matter.
pub fn class_reach(system: &System, most: f64) -> f64 {
    if system.grid().is_line() {
        return f64::INFINITY;
    }
    let periods = system.grid().length / critical_length(system.law());
    (CLASS_REACH * periods).clamp(CLASS_REACH_LEAST, most)
}

/// Waves up to this many per cell side are in the block (112 unknowns in a square cell, 12 in a
/// line cell): all that can go soft in the cells of Figs 2 and 3, and few enough that the
/// factorisation is cheaper than two transforms of 64 x 64 points.
const WAVES: f64 = 6.0;
/// The same where a quarter cell has at least as many points along a side as to pay for it: 90
/// unknowns.
const FINE_WAVES: f64 = 10.0;
const FINE: usize = 40;
/// The same on half a line: nearly all of them.
const LINE_WAVES: f64 = 64.0;

/// A symmetric positive definite approximate inverse of the Hessian.
#[derive(Clone, Debug)]
pub struct Preconditioner {
    diagonal: Vec<f64>,
    /// Its roots: taken for every product of a proof they were a fifteenth of a loop over a tip.
    roots: Vec<f64>,
    /// In place of `modes` for even systems.
    even: Option<LowBlock>,
    modes: Vec<Mode>,
    /// Of their block; empty until [`Preconditioner::refresh`].
    factor: Factor,
}

/// One wave of the block: cosine and sine.
#[derive(Clone, Copy, Debug)]
struct Mode {
    /// Wave numbers in units of 2 pi/L.
    wave: [i64; 2],
    /// Index of its amplitude pair, and that of its conjugate where both are stored.
    pair: usize,
    mirror: Option<usize>,
}

impl Preconditioner {
    /// The diagonal part with constant `stiffness` k (E* per length); the block waits for a state.
    pub fn new(system: &System, stiffness: f64) -> Self {
        if system.is_even() {
            let reach = match system.shape() {
                (1, _) => LINE_WAVES,
                (_, m) if m < FINE => WAVES,
                _ => FINE_WAVES,
            };
            return Self::of_class(system, stiffness, Class::of(system), reach);
        }
        let mut diagonal = diagonal(system, stiffness);
        diagonal[1] = 0.0;
        Self {
            modes: modes(system),
            ..Self::by(diagonal, None)
        }
    }

    /// The same for one symmetry class of an even system, with a block of the waves no longer than
    /// `reach`.
    pub fn of_class(system: &System, stiffness: f64, class: Class, reach: f64) -> Self {
        let block = LowBlock::new(system, class, reach);
        Self::by(diagonal(system, stiffness), Some(block))
    }

    /// The same with another constant `stiffness` k (E* per length) of the diagonal.
    pub fn with_stiffness(mut self, system: &System, stiffness: f64) -> Self {
        self.diagonal = diagonal(system, stiffness);
        self.roots = roots(&self.diagonal);
        self
    }

    fn by(diagonal: Vec<f64>, even: Option<LowBlock>) -> Self {
        Self {
            roots: roots(&diagonal),
            diagonal,
            even,
            modes: Vec::new(),
            factor: Factor::default(),
        }
    }

    /// The block of an even system.
    pub fn low_block(&self) -> Option<&LowBlock> {
        self.even.as_ref()
    }

    /// The block of an even system.
    pub fn low_block_mut(&mut self) -> Option<&mut LowBlock> {
        self.even.as_mut()
    }

    /// The diagonal 1/(q E*/2 + k); zero for a mean that is no unknown.
    pub fn diagonal(&self) -> &[f64] {
        &self.diagonal
    }

    /// Drops the block: it belongs to a state that is left behind.
    pub fn forget(&mut self) {
        if let Some(block) = &mut self.even {
            block.forget();
        }
        self.factor.clear();
    }

    /// Assembles and factorises the block of a surface with these `fields`. One transform.
    ///
    /// Pivots are kept above a floor, and negative ones turned positive: along a sliding or an
    /// unstable mode the inverse is bounded, and stays positive. The longest waves come last, so
    /// that only they are touched.
    pub fn refresh(&mut self, system: &System, fields: &Fields, ws: &mut Workspace) {
        if let Some(block) = &mut self.even {
            return block.refresh(system, fields, ws);
        }
        let stiffness = stiffness_spectrum(system, fields, ws);
        let n = 2 * self.modes.len();
        let mut hessian = Vec::with_capacity(n * (n + 1) / 2);
        for i in 0..n {
            for j in 0..=i {
                let (a, b) = (self.modes[i / 2], self.modes[j / 2]);
                let sum = stiffness([a.wave[0] + b.wave[0], a.wave[1] + b.wave[1]]);
                let difference = stiffness([a.wave[0] - b.wave[0], a.wave[1] - b.wave[1]]);
                let elastic = if i == j {
                    system.elastic()[2 * a.pair]
                } else {
                    0.0
                };
                hessian.push(match (i % 2, j % 2) {
                    (0, 0) => difference.re + sum.re + elastic,
                    (1, 1) => difference.re - sum.re + elastic,
                    (0, _) => sum.im - difference.im,
                    _ => sum.im + difference.im,
                });
            }
        }
        self.factor
            .factorise(&hessian, n, FLOOR * system.stiffness_unit());
    }

    /// `out` = approximate inverse Hessian times `r`.
    pub fn apply(&self, r: &[f64], out: &mut [f64]) {
        scaled(&self.diagonal, r, out);
        self.within(r, out, Factor::solve_positive);
    }

    /// The same with the signs of the block: for equilibria that are no minima.
    pub fn apply_indefinite(&self, r: &[f64], out: &mut [f64]) {
        scaled(&self.diagonal, r, out);
        self.within(r, out, Factor::solve);
    }

    /// `out` = F y for the factors F F^T of the approximate inverse: y drawn evenly from all
    /// directions gives amplitudes as soft as the Hessian allows.
    pub fn spread(&self, y: &[f64], out: &mut [f64]) {
        scaled(&self.roots, y, out);
        self.within(y, out, Factor::spread);
    }

    /// `out` = F^T r.
    pub fn gather(&self, r: &[f64], out: &mut [f64]) {
        scaled(&self.roots, r, out);
        self.within(r, out, Factor::gather);
    }

    /// On the waves of the block `out` gets what `work` makes of `r` by its factors; the rest is
    /// kept.
    fn within(&self, r: &[f64], out: &mut [f64], work: impl Fn(&Factor, &mut [f64])) {
        if let Some(block) = self.even.as_ref().filter(|block| block.is_ready()) {
            block.within(r, out, &work);
        }
        if self.factor.is_empty() {
            return;
        }
        let mut x: Vec<f64> = self
            .modes
            .iter()
            .flat_map(|m| [r[2 * m.pair] * m.weight(), r[2 * m.pair + 1] * m.weight()])
            .collect();
        work(&self.factor, &mut x);
        for (m, x) in self.modes.iter().zip(x.chunks_exact(2)) {
            let (re, im) = (x[0] / m.weight(), x[1] / m.weight());
            (out[2 * m.pair], out[2 * m.pair + 1]) = (re, im);
            if let Some(mirror) = m.mirror {
                (out[2 * mirror], out[2 * mirror + 1]) = (re, -im);
            }
        }
    }
}

/// 1/(q E*/2 + k); a mean that is no unknown stays what it is.
fn diagonal(system: &System, stiffness: f64) -> Vec<f64> {
    let elastic = system.elastic().iter();
    let mut diagonal: Vec<f64> = elastic.map(|e| 1.0 / (e + stiffness)).collect();
    if !system.control().frees_mean() {
        diagonal[0] = 0.0;
    }
    diagonal
}

fn roots(diagonal: &[f64]) -> Vec<f64> {
    diagonal.iter().map(|m| m.sqrt()).collect()
}

/// `out` = `factors` times `r`, entry by entry.
fn scaled(factors: &[f64], r: &[f64], out: &mut [f64]) {
    for ((o, r), m) in out.iter_mut().zip(r).zip(factors) {
        *o = r * m;
    }
}

impl Mode {
    /// Where both an amplitude and its conjugate are stored, a wave of norm 1 has 1/sqrt 2 in each.
    fn weight(&self) -> f64 {
        if self.mirror.is_some() { SQRT_2 } else { 1.0 }
    }
}

/// The transform D(k) = mean(gamma'' e^{-ikr}) of the stiffness, by wave numbers in units of 2 pi/L
/// of either sign, short of the end of the mesh's spectrum. One transform.
fn stiffness_spectrum(
    system: &System,
    fields: &Fields,
    ws: &mut Workspace,
) -> impl Fn([i64; 2]) -> Complex<f64> + use<> {
    let mut d = vec![0.0; system.dimension()];
    d[0] = system.stiffness_amplitudes(fields, &mut d, ws);
    let ny = system.grid().ny as i64;
    move |[k, l]| {
        let at = |k: i64, l: i64| {
            let pair = 2 * (k * ny + l.rem_euclid(ny)) as usize;
            let weight = if k == 0 { 1.0 } else { FRAC_1_SQRT_2 };
            Complex::new(weight * d[pair], weight * d[pair + 1])
        };
        if k < 0 { at(-k, -l).conj() } else { at(k, l) }
    }
}

/// One of each pair (q, -q) of the long waves, shortest first.
fn modes(system: &System) -> Vec<Mode> {
    let grid = system.grid();
    // Sums of two waves must not reach the end of the mesh's spectrum.
    let most = WAVES.min(grid.nx as f64 / 4.0 - 1.0);
    let reach = most.max(0.0) as i64;
    let reach_y = if grid.is_line() { 0 } else { reach };
    let index = |k: i64, l: i64| k as usize * grid.ny + l.rem_euclid(grid.ny as i64) as usize;
    let mut modes = Vec::new();
    for k in 0..=reach {
        for l in -reach_y..=reach_y {
            if (k > 0 || l > 0) && ((k * k + l * l) as f64).sqrt() <= most {
                modes.push(Mode {
                    wave: [k, l],
                    pair: index(k, l),
                    mirror: (k == 0).then(|| index(0, -l)),
                });
            }
        }
    }
    modes.sort_by_key(|m| std::cmp::Reverse(m.wave[0] * m.wave[0] + m.wave[1] * m.wave[1]));
    modes
}
