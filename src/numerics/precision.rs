//! Orthonormal waves of a periodic cell, and of how many bits the numbers of their transforms are:
//! doubles, singles, or both where each does best.
//!
//! A field has real amplitudes z with z.z = mean(field^2); it is whole or mirror-symmetric.

use super::cosine::{Cosine, CosineScratch};
use super::fourier::{Fourier, Real, Scratch};
use super::threads::{each, piece};
use ndarray::Array2;
use rustfft::num_complex::Complex;
use std::f64::consts::SQRT_2;
use std::hint::black_box;
use std::sync::Once;

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
    fn in_single(&self) -> Basis<f32> {
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

/// Of which numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Precision {
    /// 64 bits.
    #[default]
    Double,
    /// Products with the Hessian by transforms of 32 bits, all else 64: what is solved is the same,
    /// only the way to it is rougher.
    Mixed,
    /// Every transform and field of 32 bits, vectors that add them up of 64. No residual can be
    /// brought below a few millionths.
    Single,
}

impl Precision {
    /// Its word in tables.
    pub fn word(self) -> &'static str {
        match self {
            Precision::Double => "double",
            Precision::Mixed => "mixed",
            Precision::Single => "single",
        }
    }

    /// The residual to ask for, well above the one that rounding leaves.
    pub fn tolerance(self) -> f64 {
        if self == Precision::Single {
            1e-4
        } else {
            1e-6
        }
    }

    /// A residual below this may be all rounding: whoever asks for less must be ready not to get
    /// it.
    pub fn floor(self) -> f64 {
        if self == Precision::Single {
            1e-5
        } else {
            1e-13
        }
    }

    /// Mean energies that differ by less than this share of their scale may be the same.
    pub fn rounding(self) -> f64 {
        if self == Precision::Single {
            1e-7
        } else {
            1e-13
        }
    }
}

/// The transforms between amplitudes and fields in one precision. Vectors and fields are handed
/// over as doubles in any.
#[derive(Clone, Debug)]
pub struct Transforms {
    precision: Precision,
    double: Basis,
    single: Option<Basis<f32>>,
}

/// Working memory of one transform at a time.
#[derive(Clone, Debug)]
pub struct TransformScratch {
    double: BasisScratch,
    single: Option<(Array2<f32>, BasisScratch<f32>)>,
}

impl Transforms {
    /// Doubles.
    pub fn new(basis: Basis) -> Self {
        keep_freed();
        Self {
            precision: Precision::Double,
            double: basis,
            single: None,
        }
    }

    /// The same in another precision.
    pub fn with_precision(self, precision: Precision) -> Self {
        let single = (precision != Precision::Double).then(|| self.double.in_single());
        Self {
            precision,
            single,
            ..self
        }
    }

    /// Of which numbers.
    pub fn precision(&self) -> Precision {
        self.precision
    }

    /// The basis in doubles.
    pub fn basis(&self) -> &Basis {
        &self.double
    }

    /// Scratch that fits fields of `shape`.
    pub fn scratch(&self, shape: (usize, usize)) -> TransformScratch {
        let single = self
            .single
            .as_ref()
            .map(|basis| (Array2::zeros(shape), basis.scratch()));
        TransformScratch {
            double: self.double.scratch(),
            single,
        }
    }

    /// As [`Basis::synthesise`].
    pub fn synthesise(
        &self,
        z: &[f64],
        mean: f64,
        field: &mut Array2<f64>,
        scratch: &mut TransformScratch,
    ) {
        match (self.precision, &self.single, &mut scratch.single) {
            (Precision::Single, Some(basis), Some((single, scratch))) => {
                basis.synthesise(z, mean, single, scratch);
                copied(flat(single), flat(field));
            }
            _ => self.double.synthesise(z, mean, field, &mut scratch.double),
        }
    }

    /// As [`Basis::analyse`].
    pub fn analyse(
        &self,
        field: &Array2<f64>,
        z: &mut [f64],
        scratch: &mut TransformScratch,
    ) -> f64 {
        match (self.precision, &self.single, &mut scratch.single) {
            (Precision::Single, Some(basis), Some((single, scratch))) => {
                copied(field.as_slice().expect("standard layout"), flat(single));
                basis.analyse(single, z, scratch)
            }
            _ => self.double.analyse(field, z, &mut scratch.double),
        }
    }

    /// Amplitudes `out` of `factor` times the field of amplitudes `v` and a mean; `field` is
    /// working memory. Returns the mean of the product. Two transforms.
    pub fn multiply(
        &self,
        v: (&[f64], f64),
        factor: &Array2<f64>,
        out: &mut [f64],
        field: &mut Array2<f64>,
        scratch: &mut TransformScratch,
    ) -> f64 {
        match (&self.single, &mut scratch.single) {
            (Some(basis), Some((single, scratch))) => {
                multiply(basis, v, factor, out, single, scratch)
            }
            _ => multiply(&self.double, v, factor, out, field, &mut scratch.double),
        }
    }
}

fn multiply<T: Real>(
    basis: &Basis<T>,
    (v, mean): (&[f64], f64),
    factor: &Array2<f64>,
    out: &mut [f64],
    field: &mut Array2<T>,
    scratch: &mut BasisScratch<T>,
) -> f64 {
    basis.synthesise(v, mean, field, scratch);
    let (values, factor) = (flat(field), factor.as_slice().expect("standard layout"));
    let piece = piece(values.len());
    each(
        values.chunks_mut(piece).zip(factor.chunks(piece)),
        |(values, factor)| {
            values
                .iter_mut()
                .zip(factor)
                .for_each(|(value, f)| *value = *value * T::rounded(*f));
        },
    );
    basis.analyse(field, out, scratch)
}

/// Copies a field into one of other numbers.
fn copied<A: Real, B: Real>(from: &[A], to: &mut [B]) {
    let piece = piece(from.len());
    each(
        from.chunks(piece).zip(to.chunks_mut(piece)),
        |(from, to)| {
            to.iter_mut()
                .zip(from)
                .for_each(|(to, from)| *to = B::rounded(from.widened()));
        },
    );
}

fn flat<T>(array: &mut Array2<T>) -> &mut [T] {
    array.as_slice_mut().expect("standard layout")
}

/// Size of the largest block that raises the threshold of glibc when it is freed is 32 MiB: just
/// below.
const LARGE: usize = 31 << 20;

/// Makes the allocator keep freed vectors instead of handing them back to the system.
///
/// Every increment makes and drops dozens of vectors. The GNU C library returns what is freed at
/// once, until it has seen a larger block freed; that the system must clear each page anew then
/// took longer than the arithmetic. The block here is never touched and so costs nothing; with
/// other allocators nothing happens.
fn keep_freed() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| drop(black_box(Vec::<u8>::with_capacity(LARGE))));
}
