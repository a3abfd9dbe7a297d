//! Orthonormal waves of a periodic cell: real amplitudes z of a field with z.z = mean(field^2),
//! whole or mirror-symmetric.

use super::cosine::{Cosine, CosineScratch};
use super::fourier::Real;
use super::fourier::{Fourier, Scratch};
use super::threads::{each, piece};
use ndarray::Array2;
use rustfft::num_complex::Complex;
use std::f64::consts::SQRT_2;

/// Which waves represent a field, with their transforms.
#[derive(Clone, Debug)]
pub enum Basis<T: Real = f64> {
    /// All waves of the cell. Amplitudes are the half spectrum of [`Fourier`] as pairs of reals,
    /// each times sqrt(w) with w = 2 where the mirrored half is left out and 1 else.
    Whole(Fourier<T>),
    /// Cosine waves only: the field of a quarter cell, amplitudes as in [`Cosine`].
    Even(Cosine<T>),
}

/// Working memory of one transform at a time.
#[derive(Clone, Debug)]
pub enum BasisScratch<T: Real = f64> {
    /// Of [`Basis::Whole`].
    Whole(Array2<Complex<T>>, Scratch<T>),
    /// Of [`Basis::Even`].
    Even(CosineScratch<T>),
}

impl<T: Real> Basis<T> {
    /// The same waves in single precision.
    pub fn in_single(&self) -> Basis<f32> {
        match self {
            Basis::Whole(fourier) => {
                let (ny, nx) = fourier.shape();
                Basis::Whole(Fourier::new(ny, nx))
            }
            Basis::Even(cosine) => {
                let (ny, nx) = cosine.shape();
                Basis::Even(Cosine::new(ny, nx))
            }
        }
    }

    /// Scratch that fits.
    pub fn scratch(&self) -> BasisScratch<T> {
        match self {
            Basis::Whole(fourier) => BasisScratch::Whole(fourier.spectrum(), fourier.scratch()),
            Basis::Even(cosine) => BasisScratch::Even(cosine.scratch()),
        }
    }

    /// The `field` of amplitudes `z`, whose own entry for the mean is ignored in favour of `mean`.
    /// One transform.
    pub fn synthesise(
        &self,
        z: &[f64],
        mean: f64,
        field: &mut Array2<T>,
        scratch: &mut BasisScratch<T>,
    ) {
        match (self, scratch) {
            (Basis::Whole(fourier), BasisScratch::Whole(spectrum, scratch)) => {
                let (m, ny) = spectrum.dim();
                let rows = piece(2 * m * ny).div_ceil(2 * ny);
                each(
                    flat(spectrum)
                        .chunks_mut(rows * ny)
                        .zip(z.chunks(2 * rows * ny))
                        .enumerate(),
                    |(i, (spectrum, z))| {
                        for (k, (row, z)) in spectrum
                            .chunks_exact_mut(ny)
                            .zip(z.chunks_exact(2 * ny))
                            .enumerate()
                        {
                            let s = 1.0 / weight(i * rows + k, m);
                            for (c, z) in row.iter_mut().zip(z.chunks_exact(2)) {
                                *c = Complex::new(T::rounded(s * z[0]), T::rounded(s * z[1]));
                            }
                        }
                    },
                );
                spectrum[[0, 0]] = Complex::new(T::rounded(mean), T::default());
                fourier.inverse(spectrum, field, scratch);
            }
            (Basis::Even(cosine), BasisScratch::Even(scratch)) => {
                cosine.synthesise(z, mean, flat(field), scratch);
            }
            _ => unreachable!("scratch is made by the same basis"),
        }
    }

    /// Amplitudes `z` of `field`; returns its mean, whose own entry in `z` is zero. One transform.
    pub fn analyse(&self, field: &Array2<T>, z: &mut [f64], scratch: &mut BasisScratch<T>) -> f64 {
        match (self, scratch) {
            (Basis::Whole(fourier), BasisScratch::Whole(spectrum, scratch)) => {
                fourier.forward(field, spectrum, scratch);
                let (m, ny) = spectrum.dim();
                let rows = piece(2 * m * ny).div_ceil(2 * ny);
                each(
                    flat(spectrum)
                        .chunks(rows * ny)
                        .zip(z.chunks_mut(2 * rows * ny))
                        .enumerate(),
                    |(i, (spectrum, z))| {
                        for (k, (row, z)) in spectrum
                            .chunks_exact(ny)
                            .zip(z.chunks_exact_mut(2 * ny))
                            .enumerate()
                        {
                            let s = weight(i * rows + k, m);
                            for (c, z) in row.iter().zip(z.chunks_exact_mut(2)) {
                                z[0] = s * c.re.widened();
                                z[1] = s * c.im.widened();
                            }
                        }
                    },
                );
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
