//! Orthonormal waves of a periodic cell: real amplitudes z of a field with z.z = mean(field^2), whole or mirror-symmetric.

use super::cosine::{Cosine, CosineScratch};
use super::fourier::{Fourier, Scratch};
use ndarray::Array2;
use rustfft::num_complex::Complex;
use std::f64::consts::SQRT_2;

/// Which waves represent a field, with their transforms.
#[derive(Clone, Debug)]
pub enum Basis {
    /// All waves of the cell. Amplitudes are the half spectrum of [`Fourier`] as pairs of reals, each times sqrt(w) with w = 2 where
    /// the mirrored half is left out and 1 else.
    Whole(Fourier),
    /// Cosine waves only: the field of a quarter cell, amplitudes as in [`Cosine`].
    Even(Cosine),
}

/// Working memory of one transform at a time.
#[derive(Clone, Debug)]
pub enum BasisScratch {
    /// Of [`Basis::Whole`].
    Whole(Array2<Complex<f64>>, Scratch),
    /// Of [`Basis::Even`].
    Even(CosineScratch),
}

impl Basis {
    /// Scratch that fits.
    pub fn scratch(&self) -> BasisScratch {
        match self {
            Basis::Whole(fourier) => BasisScratch::Whole(fourier.spectrum(), fourier.scratch()),
            Basis::Even(cosine) => BasisScratch::Even(cosine.scratch()),
        }
    }

    /// The `field` of amplitudes `z`, whose own entry for the mean is ignored in favour of `mean`. One transform.
    pub fn synthesise(&self, z: &[f64], mean: f64, field: &mut Array2<f64>, scratch: &mut BasisScratch) {
        match (self, scratch) {
            (Basis::Whole(fourier), BasisScratch::Whole(spectrum, scratch)) => {
                let (m, ny) = spectrum.dim();
                for (k, (row, z)) in flat(spectrum).chunks_exact_mut(ny).zip(z.chunks_exact(2 * ny)).enumerate() {
                    let s = 1.0 / weight(k, m);
                    for (c, z) in row.iter_mut().zip(z.chunks_exact(2)) {
                        *c = Complex::new(s * z[0], s * z[1]);
                    }
                }
                spectrum[[0, 0]] = Complex::new(mean, 0.0);
                fourier.inverse(spectrum, field, scratch);
            }
            (Basis::Even(cosine), BasisScratch::Even(scratch)) => cosine.synthesise(z, mean, flat(field), scratch),
            _ => unreachable!("scratch is made by the same basis"),
        }
    }

    /// Amplitudes `z` of `field`; returns its mean, whose own entry in `z` is zero. One transform.
    pub fn analyse(&self, field: &Array2<f64>, z: &mut [f64], scratch: &mut BasisScratch) -> f64 {
        match (self, scratch) {
            (Basis::Whole(fourier), BasisScratch::Whole(spectrum, scratch)) => {
                fourier.forward(field, spectrum, scratch);
                let (m, ny) = spectrum.dim();
                let rows = flat(spectrum).chunks_exact(ny);
                for (k, (row, z)) in rows.zip(z.chunks_exact_mut(2 * ny)).enumerate() {
                    let s = weight(k, m);
                    for (c, z) in row.iter().zip(z.chunks_exact_mut(2)) {
                        z[0] = s * c.re;
                        z[1] = s * c.im;
                    }
                }
                z[1] = 0.0;
            }
            (Basis::Even(cosine), BasisScratch::Even(scratch)) => {
                cosine.analyse(field.as_slice().expect("standard layout"), z, scratch);
            }
            _ => unreachable!("scratch is made by the same basis"),
        }
        std::mem::take(&mut z[0])
    }
}

/// sqrt(w) of row `k` of a half spectrum with `rows` rows.
fn weight(k: usize, rows: usize) -> f64 {
    if k == 0 || k + 1 == rows { 1.0 } else { SQRT_2 }
}

fn flat<T>(array: &mut Array2<T>) -> &mut [T] {
    array.as_slice_mut().expect("standard layout")
}
