//! Two-dimensional transform of real fields: realfft along rows, rustfft along columns, plans made
//! once, scratch owned by the caller; and the numbers it may be made of.
//!
//! Large fields are shared among threads, by rows and by columns; each row is transformed by the
//! same plan as without, so that the result does not depend on it by a single bit.

use super::threads::{each, lanes};
use ndarray::Array2;
use realfft::{ComplexToReal, FftNum, RealFftPlanner, RealToComplex};
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};
use std::sync::Arc;

/// Lines that are gathered and transformed together: 8 complex numbers side by side fill whole
/// cache lines.
const BAND: usize = 8;

/// Plans for fields of one shape (ny, nx).
///
/// A spectrum has shape (nx/2 + 1, ny): **wave numbers along x are rows**, those along y columns,
/// so that the second pass of the transform runs over contiguous memory. Row k holds k_x = 2 pi k /
/// L_x; column l holds k_y = 2 pi l / L_y for l <= ny/2 and 2 pi (l - ny) / L_y beyond. The missing
/// half follows from u(-k) = conj u(k).
#[derive(Clone)]
pub struct Fourier<T: Real = f64> {
    nx: usize,
    ny: usize,
    lanes: usize,
    row_forward: Arc<dyn RealToComplex<T>>,
    row_inverse: Arc<dyn ComplexToReal<T>>,
    column_forward: Arc<dyn Fft<T>>,
    column_inverse: Arc<dyn Fft<T>>,
}

impl<T: Real> std::fmt::Debug for Fourier<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Fourier({} x {})", self.ny, self.nx)
    }
}

/// Working memory of one transform at a time.
#[derive(Clone, Debug)]
pub struct Scratch<T: Real = f64> {
    rows: Vec<Complex<T>>,
    lanes: Vec<Lane<T>>,
}

/// Working memory of one line at a time.
#[derive(Clone, Debug)]
struct Lane<T> {
    line: Vec<T>,
    fft: Vec<Complex<T>>,
}

impl<T: Real> Fourier<T> {
    /// Plans for fields with `ny` rows and `nx` columns; `nx` even, `ny` even or 1. Large fields
    /// are shared among threads.
    pub fn new(ny: usize, nx: usize) -> Self {
        Self::with_lanes(ny, nx, lanes(ny * nx))
    }

    /// The same with the work cut into `lanes` pieces; 1 keeps it on the caller's thread.
    pub fn with_lanes(ny: usize, nx: usize, lanes: usize) -> Self {
        assert!(nx >= 2 && nx.is_multiple_of(2), "nx must be even");
        assert!(ny == 1 || ny.is_multiple_of(2), "ny must be even or 1");
        let ((row_forward, row_inverse), (column_forward, column_inverse)) =
            (T::row_plans(nx), T::column_plans(ny));
        Self {
            nx,
            ny,
            lanes: lanes.max(1),
            row_forward,
            row_inverse,
            column_forward,
            column_inverse,
        }
    }

    /// Shape (ny, nx) of a field.
    pub fn shape(&self) -> (usize, usize) {
        (self.ny, self.nx)
    }

    /// Shape (nx/2 + 1, ny) of a spectrum.
    pub fn spectrum_shape(&self) -> (usize, usize) {
        (self.nx / 2 + 1, self.ny)
    }

    /// A zero spectrum.
    pub fn spectrum(&self) -> Array2<Complex<T>> {
        Array2::zeros(self.spectrum_shape())
    }

    /// Scratch that fits these plans.
    pub fn scratch(&self) -> Scratch<T> {
        let (m, ny) = self.spectrum_shape();
        let longest = [
            self.row_forward.get_scratch_len(),
            self.row_inverse.get_scratch_len(),
            self.column_forward.get_inplace_scratch_len(),
            self.column_inverse.get_inplace_scratch_len(),
        ];
        let longest = longest.into_iter().max().unwrap_or(0);
        let lane = Lane {
            line: vec![T::default(); self.nx],
            fft: vec![Complex::default(); longest],
        };
        Scratch {
            rows: vec![Complex::default(); m * ny],
            lanes: vec![lane; self.lanes],
        }
    }

    /// Lines of each lane, of `lines` in all: whole bands.
    fn share(&self, lines: usize) -> usize {
        lines.div_ceil(self.lanes).next_multiple_of(BAND)
    }

    /// Amplitudes u_k = (1/N) sum_r u(r) e^{-i k r} of `field`.
    ///
    /// # Panics
    /// If shapes differ from the plans' or an array is not in standard layout.
    pub fn forward(
        &self,
        field: &Array2<T>,
        spectrum: &mut Array2<Complex<T>>,
        scratch: &mut Scratch<T>,
    ) {
        let (nx, (m, ny)) = (self.nx, self.spectrum_shape());
        assert_eq!(field.dim(), (ny, nx));
        assert_eq!(spectrum.dim(), (m, ny));
        let field = field.as_slice().expect("standard layout");
        let spectrum = spectrum.as_slice_mut().expect("standard layout");
        let Scratch { rows, lanes } = scratch;
        let scale = T::rounded(1.0 / (nx * ny) as f64);
        let share = self.share(ny);
        each(
            field
                .chunks(share * nx)
                .zip(rows.chunks_mut(share * m))
                .zip(&mut *lanes),
            |((field, rows), lane)| {
                for (input, output) in field.chunks_exact(nx).zip(rows.chunks_exact_mut(m)) {
                    for (to, from) in lane.line.iter_mut().zip(input) {
                        *to = *from * scale;
                    }
                    self.row_forward
                        .process_with_scratch(&mut lane.line, output, &mut lane.fft)
                        .expect("lengths fit the plan");
                }
            },
        );
        let share = self.share(m);
        each(
            spectrum.chunks_mut(share * ny).enumerate().zip(lanes),
            |((i, columns), lane)| {
                for (band, columns) in columns.chunks_mut(BAND * ny).enumerate() {
                    gather(rows, m, i * share + band * BAND, columns, ny);
                    if ny > 1 {
                        self.column_forward
                            .process_with_scratch(columns, &mut lane.fft);
                    }
                }
            },
        );
    }

    /// The field of a `spectrum`, which is overwritten.
    ///
    /// # Panics
    /// If shapes differ from the plans' or an array is not in standard layout.
    pub fn inverse(
        &self,
        spectrum: &mut Array2<Complex<T>>,
        field: &mut Array2<T>,
        scratch: &mut Scratch<T>,
    ) {
        let (nx, (m, ny)) = (self.nx, self.spectrum_shape());
        assert_eq!(field.dim(), (ny, nx));
        assert_eq!(spectrum.dim(), (m, ny));
        let field = field.as_slice_mut().expect("standard layout");
        let spectrum = spectrum.as_slice_mut().expect("standard layout");
        let Scratch { rows, lanes } = scratch;
        if ny > 1 {
            each(
                spectrum.chunks_mut(self.share(m) * ny).zip(&mut *lanes),
                |(columns, lane)| {
                    self.column_inverse
                        .process_with_scratch(columns, &mut lane.fft);
                },
            );
        }
        let share = self.share(ny);
        let tasks = field
            .chunks_mut(share * nx)
            .zip(rows.chunks_mut(share * m))
            .enumerate()
            .zip(lanes);
        each(tasks, |((i, (field, rows)), lane)| {
            for (band, (field, rows)) in field
                .chunks_mut(BAND * nx)
                .zip(rows.chunks_mut(BAND * m))
                .enumerate()
            {
                gather(spectrum, ny, i * share + band * BAND, rows, m);
                for (input, output) in rows.chunks_exact_mut(m).zip(field.chunks_exact_mut(nx)) {
                    // A real row has real end amplitudes; round-off of the columns must not reach
                    // realfft's check.
                    input[0].im = T::default();
                    input[m - 1].im = T::default();
                    self.row_inverse
                        .process_with_scratch(input, output, &mut lane.fft)
                        .expect("lengths fit the plan");
                }
            }
        });
    }
}

/// Copies columns of the matrix `from`, whose rows have `width` entries, beginning with column
/// `first`, into the lines of `to`, each of `length` entries.
fn gather<T: Copy>(from: &[T], width: usize, first: usize, to: &mut [T], length: usize) {
    let lines = to.len() / length;
    // Of a single row, or into one, nothing is turned.
    if length == 1 {
        return to.copy_from_slice(&from[first..first + lines]);
    }
    if width == 1 {
        return to.copy_from_slice(&from[..length]);
    }
    for top in (0..length).step_by(BAND) {
        for line in 0..lines {
            for r in top..(top + BAND).min(length) {
                to[line * length + r] = from[r * width + first + line];
            }
        }
    }
}

/// Amplitudes u_k = (1/N) sum_r u(r) e^{-i k r} of a field of any shape, those of wave numbers along y
/// in rows and along x in columns, in the order of numpy's `fft2`.
pub fn amplitudes(field: &Array2<f64>) -> Array2<Complex<f64>> {
    let (ny, nx) = field.dim();
    let share = 1.0 / field.len() as f64;
    let rows = f64::column_plans(nx).0;
    let mut along: Vec<Complex<f64>> = field.iter().map(|u| Complex::from(u * share)).collect();
    rows.process(&mut along);
    let along = Array2::from_shape_vec((ny, nx), along).expect("as many as there are points");
    let mut turned: Vec<Complex<f64>> = along.t().iter().copied().collect();
    f64::column_plans(ny).0.process(&mut turned);
    let turned = Array2::from_shape_vec((nx, ny), turned).expect("as many as there are points");
    turned.reversed_axes()
}

/// Plans along one axis, forward and inverse.
pub type Pair<F, I> = (Arc<F>, Arc<I>);

/// A floating-point number: `f64` or `f32`.
pub trait Real: FftNum + Default {
    /// The nearest number to `x`.
    fn rounded(x: f64) -> Self;

    /// The same value with 64 bits.
    fn widened(self) -> f64;

    /// Plans for rows of `n` numbers. Not generic, so that the transforms are compiled once, here,
    /// and not for every crate that asks.
    fn row_plans(n: usize) -> Pair<dyn RealToComplex<Self>, dyn ComplexToReal<Self>>;

    /// Plans for columns of `n` complex numbers.
    fn column_plans(n: usize) -> Pair<dyn Fft<Self>, dyn Fft<Self>>;
}

macro_rules! real {
    ($($number:ty)*) => { $(
        impl Real for $number {
            fn rounded(x: f64) -> Self {
                x as $number
            }

            fn widened(self) -> f64 {
                f64::from(self)
            }

            fn row_plans(n: usize) -> Pair<dyn RealToComplex<Self>, dyn ComplexToReal<Self>> {
                let mut planner = RealFftPlanner::new();
                (planner.plan_fft_forward(n), planner.plan_fft_inverse(n))
            }

            fn column_plans(n: usize) -> Pair<dyn Fft<Self>, dyn Fft<Self>> {
                let mut planner = FftPlanner::new();
                (planner.plan_fft_forward(n), planner.plan_fft_inverse(n))
            }
        }
    )* };
}

real! { f64 f32 }
