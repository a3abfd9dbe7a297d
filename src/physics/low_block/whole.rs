//! What the block of a class says of the whole cell: how soft its modes can be at most over *all* waves
//! of the mesh, and where they lie.

use super::{LowBlock, System};
use crate::numerics::dense::dot;
use rustfft::num_complex::Complex;
use std::f64::consts::{FRAC_1_SQRT_2, PI};

impl LowBlock {
    /// Assembles for [`LowBlock::most_below`]: over the pattern `z`, if it slides, whose sliding
    /// mode is left out. Amplitudes and means are those of gamma'' and of its square. No transform.
    pub fn bound(
        &mut self,
        system: &System,
        z: Option<&[f64]>,
        [once, twice]: [&[f64]; 2],
        [mean, mean_square]: [f64; 2],
    ) {
        let n = self.waves.len();
        self.hessian = self.multiplication(system, once, mean);
        self.joined = self.multiplication(system, twice, mean_square);
        let mut full = vec![0.0; n * n];
        for i in 0..n {
            for (j, entry) in self.hessian[i * (i + 1) / 2..][..=i].iter().enumerate() {
                (full[i * n + j], full[j * n + i]) = (*entry, *entry);
            }
        }
        for (i, row) in full.chunks_exact(n.max(1)).enumerate() {
            let joined = &mut self.joined[i * (i + 1) / 2..][..=i];
            for (entry, other) in joined.iter_mut().zip(full.chunks_exact(n.max(1))) {
                *entry -= dot(row, other);
            }
            self.hessian[i * (i + 3) / 2] += self.elastic[i];
        }
        self.slide = z.and_then(|z| self.sliding(z));
    }

    /// An upper bound of the number of eigenvalues below `shift` (E* per length) of the Hessian
    /// over *all* waves of the class, the sliding mode left out, after [`LowBlock::bound`]; `least`
    /// is the least gamma'' on the mesh (E* per length). Factorises.
    ///
    /// With A the block, C the Hessian among the waves beyond it and B what joins them, it is the
    /// number of negative eigenvalues of A - shift - B (C - shift)^-1 B^T where C > shift (E. V.
    /// Haynsworth, Linear Algebra Appl. 1, 73 (1968)). C is no less than its softest wave and the
    /// least gamma'' together, and B B^T needs no wave beyond the block: with M multiplication by
    /// gamma'' among its waves it is multiplication by the square of gamma'' less M^2.
    pub fn most_below(&mut self, least: f64, shift: f64) -> usize {
        let stiffer = self.beyond + least - shift;
        if !(stiffer > 0.0) {
            return usize::MAX;
        }
        let entries = self.hessian.iter().zip(&self.joined);
        let bounded = entries.map(|(a, bb)| a - bb / stiffer).collect();
        let exact = std::mem::replace(&mut self.hessian, bounded);
        let most = self.negative_below(shift);
        self.hessian = exact;
        most
    }

    /// How the modes of the class lie in a `whole` system of the cell, unfolded as by
    /// [`System::unfolded`].
    pub fn unfolding(&self, whole: &System) -> Unfolding {
        let mut places = Vec::new();
        let (ny, nx) = whole.grid().shape();
        let parity = self.class.parity();
        // A cosine is (e^+ + e^-)/2, a sine (e^+ - e^-)/2i, about the middle between two points.
        let side = |k: usize, n: usize, axis: usize, sign: f64| {
            let phase = Complex::cis(sign * PI * k as f64 * (1.0 / n as f64 - 1.0));
            let odd = parity[axis] < 0.0;
            phase
                * if odd {
                    Complex::new(0.0, -sign)
                } else {
                    Complex::ONE
                }
        };
        for (wave, &[k, l]) in self.waves.iter().enumerate() {
            let (pair, mirrored) = match self.class.exchange().filter(|_| k != l) {
                Some(sign) => (FRAC_1_SQRT_2, Some(sign * FRAC_1_SQRT_2)),
                None => (1.0, None),
            };
            for ([k, l], weight) in [([k, l], Some(pair)), ([l, k], mirrored)] {
                let Some(weight) = weight else { continue };
                let along_x = weight * side(k, nx, 0, 1.0);
                if l == 0 {
                    places.push((wave, k * ny, along_x));
                    continue;
                }
                for (place, sign) in [(l, 1.0), (ny - l, -1.0)] {
                    let factor = FRAC_1_SQRT_2 * along_x * side(l, ny, 1, sign);
                    places.push((wave, k * ny + place, factor));
                }
            }
        }
        Unfolding {
            places,
            waves: self.waves.len(),
            dimension: whole.dimension(),
        }
    }
}

/// The waves of a class as amplitudes of the whole cell.
#[derive(Clone, Debug)]
pub struct Unfolding {
    /// Wave of the class, amplitude pair of the whole cell, and the value there.
    places: Vec<(usize, usize, Complex<f64>)>,
    waves: usize,
    dimension: usize,
}

impl Unfolding {
    /// Amplitudes of the whole cell of a mode given by coefficients of all waves of the class.
    pub fn unfolded(&self, coefficients: &[f64]) -> Vec<f64> {
        let mut z = vec![0.0; self.dimension];
        for &(wave, pair, factor) in &self.places {
            z[2 * pair] += factor.re * coefficients[wave];
            z[2 * pair + 1] += factor.im * coefficients[wave];
        }
        z
    }

    /// The part of amplitudes of the whole cell that belongs to the class.
    pub fn folded(&self, z: &[f64]) -> Vec<f64> {
        let mut coefficients = vec![0.0; self.waves];
        for &(wave, pair, factor) in &self.places {
            coefficients[wave] += factor.re * z[2 * pair] + factor.im * z[2 * pair + 1];
        }
        coefficients
    }
}
