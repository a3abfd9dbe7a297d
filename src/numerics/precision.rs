//! Of how many bits the numbers of a transform are: doubles, singles, or both where each does best.

use super::basis::{Basis, BasisScratch};
use super::fourier::Real;
use super::threads::{each, piece};
use ndarray::Array2;
use std::hint::black_box;
use std::sync::Once;

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
