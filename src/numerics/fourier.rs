//! Two-dimensional transform of real fields: realfft along rows, rustfft along columns, plans made once, scratch owned by the caller.

use ndarray::Array2;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};
use std::sync::Arc;

/// Side of the tiles of the transpose: 8 x 8 complex numbers read and write whole cache lines.
const TILE: usize = 8;

/// Plans for fields of one shape (ny, nx).
///
/// A spectrum has shape (nx/2 + 1, ny): **wave numbers along x are rows**, those along y columns, so that the second pass of the
/// transform runs over contiguous memory. Row k holds k_x = 2 pi k / L_x; column l holds k_y = 2 pi l / L_y for l <= ny/2 and
/// 2 pi (l - ny) / L_y beyond. The missing half follows from u(-k) = conj u(k).
#[derive(Clone)]
pub struct Fourier {
    nx: usize,
    ny: usize,
    row_forward: Arc<dyn RealToComplex<f64>>,
    row_inverse: Arc<dyn ComplexToReal<f64>>,
    column_forward: Arc<dyn Fft<f64>>,
    column_inverse: Arc<dyn Fft<f64>>,
}

impl std::fmt::Debug for Fourier {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Fourier({} x {})", self.ny, self.nx)
    }
}

/// Working memory of one transform at a time.
#[derive(Clone, Debug)]
pub struct Scratch {
    rows: Vec<Complex<f64>>,
    line: Vec<f64>,
    fft: Vec<Complex<f64>>,
}

impl Fourier {
    /// Plans for fields with `ny` rows and `nx` columns; `nx` even, `ny` even or 1.
    pub fn new(ny: usize, nx: usize) -> Self {
        assert!(nx >= 2 && nx.is_multiple_of(2), "nx must be even");
        assert!(ny == 1 || ny.is_multiple_of(2), "ny must be even or 1");
        let mut real = RealFftPlanner::new();
        let mut complex = FftPlanner::new();
        Self {
            nx,
            ny,
            row_forward: real.plan_fft_forward(nx),
            row_inverse: real.plan_fft_inverse(nx),
            column_forward: complex.plan_fft_forward(ny),
            column_inverse: complex.plan_fft_inverse(ny),
        }
    }

    /// Shape (nx/2 + 1, ny) of a spectrum.
    pub fn spectrum_shape(&self) -> (usize, usize) {
        (self.nx / 2 + 1, self.ny)
    }

    /// A zero spectrum.
    pub fn spectrum(&self) -> Array2<Complex<f64>> {
        Array2::zeros(self.spectrum_shape())
    }

    /// Scratch that fits these plans.
    pub fn scratch(&self) -> Scratch {
        let (m, ny) = self.spectrum_shape();
        let longest = [
            self.row_forward.get_scratch_len(),
            self.row_inverse.get_scratch_len(),
            self.column_forward.get_inplace_scratch_len(),
            self.column_inverse.get_inplace_scratch_len(),
        ];
        Scratch {
            rows: vec![Complex::default(); m * ny],
            line: vec![0.0; self.nx],
            fft: vec![Complex::default(); longest.into_iter().max().unwrap_or(0)],
        }
    }

    /// Amplitudes u_k = (1/N) sum_r u(r) e^{-i k r} of `field`.
    ///
    /// # Panics
    /// If shapes differ from the plans' or an array is not in standard layout.
    pub fn forward(&self, field: &Array2<f64>, spectrum: &mut Array2<Complex<f64>>, scratch: &mut Scratch) {
        let (m, ny) = self.spectrum_shape();
        assert_eq!(field.dim(), (ny, self.nx));
        assert_eq!(spectrum.dim(), (m, ny));
        let field = field.as_slice().expect("standard layout");
        let spectrum = spectrum.as_slice_mut().expect("standard layout");
        let scale = 1.0 / (self.nx * ny) as f64;
        for (input, output) in field.chunks_exact(self.nx).zip(scratch.rows.chunks_exact_mut(m)) {
            for (to, from) in scratch.line.iter_mut().zip(input) {
                *to = from * scale;
            }
            self.row_forward.process_with_scratch(&mut scratch.line, output, &mut scratch.fft).expect("lengths fit the plan");
        }
        transpose(&scratch.rows, spectrum, ny, m);
        if ny > 1 {
            self.column_forward.process_with_scratch(spectrum, &mut scratch.fft);
        }
    }

    /// The field of a `spectrum`, which is overwritten.
    ///
    /// # Panics
    /// If shapes differ from the plans' or an array is not in standard layout.
    pub fn inverse(&self, spectrum: &mut Array2<Complex<f64>>, field: &mut Array2<f64>, scratch: &mut Scratch) {
        let (m, ny) = self.spectrum_shape();
        assert_eq!(field.dim(), (ny, self.nx));
        assert_eq!(spectrum.dim(), (m, ny));
        let field = field.as_slice_mut().expect("standard layout");
        let spectrum = spectrum.as_slice_mut().expect("standard layout");
        if ny > 1 {
            self.column_inverse.process_with_scratch(spectrum, &mut scratch.fft);
        }
        transpose(spectrum, &mut scratch.rows, m, ny);
        for (input, output) in scratch.rows.chunks_exact_mut(m).zip(field.chunks_exact_mut(self.nx)) {
            // A real row has real end amplitudes; round-off of the columns must not reach realfft's check.
            input[0].im = 0.0;
            input[m - 1].im = 0.0;
            self.row_inverse.process_with_scratch(input, output, &mut scratch.fft).expect("lengths fit the plan");
        }
    }
}

/// Writes the transpose of the `rows` x `columns` matrix `from` into `to`, tile by tile.
fn transpose(from: &[Complex<f64>], to: &mut [Complex<f64>], rows: usize, columns: usize) {
    if rows == 1 || columns == 1 {
        to.copy_from_slice(from);
        return;
    }
    for top in (0..rows).step_by(TILE) {
        for left in (0..columns).step_by(TILE) {
            for r in top..(top + TILE).min(rows) {
                for c in left..(left + TILE).min(columns) {
                    to[c * rows + r] = from[r * columns + c];
                }
            }
        }
    }
}
