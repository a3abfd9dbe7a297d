//! Cosine transform of even fields: one quarter of a periodic cell, mirror-symmetric about x = 0
//! and y = 0.
//!
//! Points sit half a spacing off the mirror, x_j = (j + 1/2) da, so that a quarter of an n x n cell
//! has n/2 x n/2 points and u = sum a_kl cos(pi k (i + 1/2)/m) cos(pi l (j + 1/2)/m) with m = n/2.
//!
//! By J. Makhoul (IEEE Trans. ASSP 28, 27 (1980)) a line's amplitudes are the Fourier transform of
//! its points in another order, even ones first and odd ones backwards, followed by a rotation. Two
//! lines go together, as the real and the imaginary part of one, in every step: so they fill the
//! registers of the processor.

use super::fourier::Real;
use super::threads::{each, lanes};
use rustfft::Fft;
use rustfft::num_complex::Complex;
use std::f64::consts::{FRAC_1_SQRT_2, PI};
use std::sync::Arc;

/// Pairs of lines that are turned from rows to columns together: four fill a cache line.
const BAND: usize = 4;

/// Plans for fields of one shape (ny, nx).
#[derive(Clone, Debug)]
pub struct Cosine<T: Real = f64> {
    lanes: usize,
    along_x: Axis<T>,
    along_y: Axis<T>,
}

/// Working memory of one transform at a time.
#[derive(Clone, Debug)]
pub struct CosineScratch<T: Real = f64> {
    /// Pairs of rows, or of columns.
    pairs: Vec<Complex<T>>,
    lanes: Vec<Lane<T>>,
}

/// Working memory of one band at a time.
#[derive(Clone, Debug)]
struct Lane<T> {
    band: Vec<Complex<T>>,
    fft: Vec<Complex<T>>,
}

impl<T: Real> Cosine<T> {
    /// Plans for fields with `ny` rows and `nx` columns; `nx` even, `ny` even or 1. Large fields
    /// are shared among threads.
    pub fn new(ny: usize, nx: usize) -> Self {
        assert!(nx >= 2 && nx.is_multiple_of(2), "nx must be even");
        assert!(ny == 1 || ny.is_multiple_of(2), "ny must be even or 1");
        Self {
            lanes: lanes(ny * nx),
            along_x: Axis::new(nx),
            along_y: Axis::new(ny),
        }
    }

    /// Shape (ny, nx) of a field.
    pub fn shape(&self) -> (usize, usize) {
        (self.along_y.points, self.along_x.points)
    }

    /// Scratch that fits these plans.
    pub fn scratch(&self) -> CosineScratch<T> {
        let (ny, nx) = self.shape();
        let axes = [&self.along_x, &self.along_y];
        let longest = axes.map(Axis::scratch).into_iter().max().unwrap_or(0);
        let lane = Lane {
            band: vec![Complex::default(); BAND * nx.max(ny)],
            fft: vec![Complex::default(); longest],
        };
        CosineScratch {
            pairs: vec![Complex::default(); nx * ny.div_ceil(2)],
            lanes: vec![lane; self.lanes],
        }
    }

    /// Orthonormal amplitudes z of `field` (ny rows): z.z = mean(field^2). Entry k ny + l belongs
    /// to wave numbers k along x and l along y, in units of half a turn per quarter cell.
    pub fn analyse(&self, field: &[T], z: &mut [f64], scratch: &mut CosineScratch<T>) {
        let (ny, nx) = self.shape();
        let CosineScratch { pairs, lanes } = scratch;
        let share = self.share(ny);
        let tasks = field
            .chunks(2 * share * nx)
            .zip(pairs.chunks_mut(share * nx));
        each(tasks.zip(&mut *lanes), |((field, pairs), lane)| {
            for (rows, pair) in field.chunks(2 * nx).zip(pairs.chunks_exact_mut(nx)) {
                // A single row is its own second.
                let (first, second) = (&rows[..nx], &rows[rows.len() - nx..]);
                ordered(first, second, pair);
            }
            self.along_x.analyse(pairs, &mut lane.fft);
        });
        let scale = 1.0 / (nx * ny) as f64;
        let share = self.share(nx);
        let tasks = z.chunks_mut(2 * share * ny).enumerate().zip(lanes);
        each(tasks, |((i, z), Lane { band, fft })| {
            for (b, z) in z.chunks_mut(2 * BAND * ny).enumerate() {
                let band = &mut band[..z.len() / 2];
                to_columns(pairs, nx, 2 * (i * share + b * BAND), band, ny);
                self.along_y.analyse(band, fft);
                for (pair, z) in band.chunks_exact(ny).zip(z.chunks_exact_mut(2 * ny)) {
                    let (first, second) = z.split_at_mut(ny);
                    for ((c, a), b) in pair.iter().zip(first).zip(second) {
                        (*a, *b) = (c.re.widened() * scale, c.im.widened() * scale);
                    }
                }
            }
        });
    }

    /// The field of orthonormal amplitudes `z`, whose first entry is ignored in favour of `mean`;
    /// inverse of [`Cosine::analyse`].
    pub fn synthesise(
        &self,
        z: &[f64],
        mean: f64,
        field: &mut [T],
        scratch: &mut CosineScratch<T>,
    ) {
        let (ny, nx) = self.shape();
        let CosineScratch { pairs, lanes } = scratch;
        let share = self.share(nx);
        let tasks = z
            .chunks(2 * share * ny)
            .zip(pairs.chunks_mut(share * ny))
            .enumerate();
        each(tasks.zip(&mut *lanes), |((i, (z, pairs)), lane)| {
            for (z, pair) in z.chunks_exact(2 * ny).zip(pairs.chunks_exact_mut(ny)) {
                let (first, second) = z.split_at(ny);
                for ((c, a), b) in pair.iter_mut().zip(first).zip(second) {
                    *c = Complex::new(T::rounded(*a), T::rounded(*b));
                }
            }
            if i == 0 {
                pairs[0].re = T::rounded(mean);
            }
            self.along_y.synthesise(pairs, &mut lane.fft);
        });
        let share = self.share(ny);
        let tasks = field.chunks_mut(2 * share * nx).enumerate().zip(lanes);
        each(tasks, |((i, field), Lane { band, fft })| {
            for (b, field) in field.chunks_mut(2 * BAND * nx).enumerate() {
                let band = &mut band[..field.len().div_ceil(2 * nx) * nx];
                to_rows(pairs, ny, i * share + b * BAND, band, nx);
                self.along_x.synthesise(band, fft);
                for (pair, rows) in band.chunks_exact(nx).zip(field.chunks_mut(2 * nx)) {
                    let (first, second) = rows.split_at_mut(nx);
                    restored(pair, first, second);
                }
            }
        });
    }

    /// Pairs of lines of each lane, of `lines` in all: whole bands.
    fn share(&self, lines: usize) -> usize {
        lines.div_ceil(2 * self.lanes).next_multiple_of(BAND)
    }
}

/// The transform of pairs of lines.
#[derive(Clone)]
struct Axis<T: Real> {
    points: usize,
    forward: Arc<dyn Fft<T>>,
    inverse: Arc<dyn Fft<T>>,
    /// Cosine and sine of pi k/(2 points), over the root of two, for 0 < k < points/2.
    turns: Vec<[T; 2]>,
}

impl<T: Real> std::fmt::Debug for Axis<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Axis({})", self.points)
    }
}

impl<T: Real> Axis<T> {
    fn new(points: usize) -> Self {
        let (forward, inverse) = T::column_plans(points);
        let turn = |k: usize| {
            let (sin, cos) = (PI * k as f64 / (2 * points) as f64).sin_cos();
            [cos, sin].map(|x| T::rounded(x * FRAC_1_SQRT_2))
        };
        Self {
            points,
            forward,
            inverse,
            turns: (1..points.div_ceil(2)).map(turn).collect(),
        }
    }

    /// Length of the scratch of the plans.
    fn scratch(&self) -> usize {
        let [there, back] =
            [&self.forward, &self.inverse].map(|plan| plan.get_inplace_scratch_len());
        there.max(back)
    }

    /// Amplitudes of ordered pairs of lines, times the number of points. With Z_k and Z_{n-k} of
    /// their common Fourier transform Z, sums belong to the first line, differences to the second.
    fn analyse(&self, pairs: &mut [Complex<T>], fft: &mut [Complex<T>]) {
        self.forward.process_with_scratch(pairs, fft);
        for line in pairs.chunks_exact_mut(self.points) {
            self.each_two(line, |[c, s], z, u| {
                let (x, y) = (z + u, Complex::new(z.im - u.im, u.re - z.re));
                [x * c + y * s, x * s - y * c]
            });
        }
    }

    /// Ordered points of pairs of lines with these amplitudes.
    fn synthesise(&self, pairs: &mut [Complex<T>], fft: &mut [Complex<T>]) {
        for line in pairs.chunks_exact_mut(self.points) {
            self.each_two(line, |[c, s], a, b| {
                let (x, y) = (
                    Complex::new(a.re + b.im, a.im - b.re),
                    Complex::new(a.re - b.im, a.im + b.re),
                );
                let turned = |z: Complex<T>| Complex::new(T::default() - z.im, z.re);
                [x * c + turned(x) * s, y * c - turned(y) * s]
            });
        }
        self.inverse.process_with_scratch(pairs, fft);
    }

    /// Replaces entries k and n - k of a line, for all 0 < k < n/2. The rotation leaves the middle
    /// as it is.
    #[inline(always)]
    fn each_two(
        &self,
        line: &mut [Complex<T>],
        of: impl Fn([T; 2], Complex<T>, Complex<T>) -> [Complex<T>; 2],
    ) {
        let (low, high) = line[1..].split_at_mut(self.points / 2);
        for ((turn, a), b) in self.turns.iter().zip(low).zip(high.iter_mut().rev()) {
            [*a, *b] = of(*turn, *a, *b);
        }
    }
}

/// Two lines as one of complex numbers, even points first and odd ones backwards.
fn ordered<T: Real>(first: &[T], second: &[T], pair: &mut [Complex<T>]) {
    let (even, odd) = pair.split_at_mut(first.len() / 2);
    let points = first.chunks_exact(2).zip(second.chunks_exact(2));
    for (((a, b), even), odd) in points.zip(even).zip(odd.iter_mut().rev()) {
        (*even, *odd) = (Complex::new(a[0], b[0]), Complex::new(a[1], b[1]));
    }
}

/// Inverse of [`ordered`]; a single row has no `second`.
fn restored<T: Real>(pair: &[Complex<T>], first: &mut [T], second: &mut [T]) {
    let (even, odd) = pair.split_at(first.len() / 2);
    let points = || even.iter().zip(odd.iter().rev());
    for (a, (even, odd)) in first.chunks_exact_mut(2).zip(points()) {
        (a[0], a[1]) = (even.re, odd.re);
    }
    for (b, (even, odd)) in second.chunks_exact_mut(2).zip(points()) {
        (b[0], b[1]) = (even.im, odd.im);
    }
}

/// Pairs of columns from column `first` on, ordered, of `pairs` of rows of `width` entries each.
fn to_columns<T: Real>(
    pairs: &[Complex<T>],
    width: usize,
    first: usize,
    columns: &mut [Complex<T>],
    length: usize,
) {
    let count = 2 * columns.len() / length;
    for (p, rows) in pairs.chunks_exact(width).enumerate() {
        for (c, two) in rows[first..first + count].chunks_exact(2).enumerate() {
            let line = &mut columns[c * length..(c + 1) * length];
            line[length - 1 - p] = Complex::new(two[0].im, two[1].im);
            line[p] = Complex::new(two[0].re, two[1].re);
        }
    }
}

/// Pairs of rows from pair `first` on of ordered `pairs` of columns of `length` entries each;
/// inverse of [`to_columns`].
fn to_rows<T: Real>(
    pairs: &[Complex<T>],
    length: usize,
    first: usize,
    rows: &mut [Complex<T>],
    width: usize,
) {
    let columns = pairs.chunks_exact(length).take(width / 2);
    for (c, column) in columns.enumerate() {
        for (p, row) in rows.chunks_exact_mut(width).enumerate() {
            let (a, b) = (column[first + p], column[length - 1 - first - p]);
            row[2 * c] = Complex::new(a.re, b.re);
            row[2 * c + 1] = Complex::new(a.im, b.im);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::SQRT_2;

    fn field(ny: usize, nx: usize) -> Vec<f64> {
        (0..nx * ny)
            .map(|i| ((i * 7919 % 1009) as f64 / 504.5 - 1.0) + 0.3)
            .collect()
    }

    #[test]
    fn agrees_with_the_sum_that_defines_it_for_even_odd_and_line_shapes() {
        for (ny, nx) in [(1, 6), (4, 4), (2, 10), (12, 24), (6, 10)] {
            let (cosine, f) = (Cosine::new(ny, nx), field(ny, nx));
            let mut z = vec![0.0; nx * ny];
            cosine.analyse(&f, &mut z, &mut cosine.scratch());
            for k in 0..nx {
                for l in 0..ny {
                    let wave = |k: usize, i: usize, m: usize| {
                        (PI * k as f64 * (i as f64 + 0.5) / m as f64).cos()
                    };
                    let sum: f64 = (0..nx * ny)
                        .map(|p| f[p] * wave(k, p % nx, nx) * wave(l, p / nx, ny))
                        .sum();
                    let norm = SQRT_2.powi(i32::from(k > 0) + i32::from(l > 0)) / (nx * ny) as f64;
                    assert!(
                        (z[k * ny + l] - sum * norm).abs() < 1e-14,
                        "{ny} x {nx}: {k}, {l}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_wave_on_a_mesh_that_threads_share_has_one_amplitude() {
        let (ny, nx, k, l) = (260, 254, 37, 5);
        let wave = |k: usize, i: usize, m: usize| {
            SQRT_2 * (PI * k as f64 * (i as f64 + 0.5) / m as f64).cos()
        };
        let f: Vec<f64> = (0..nx * ny)
            .map(|p| wave(k, p % nx, nx) * wave(l, p / nx, ny))
            .collect();
        let cosine = Cosine::new(ny, nx);
        let mut z = vec![0.0; nx * ny];
        cosine.analyse(&f, &mut z, &mut cosine.scratch());
        z[k * ny + l] -= 1.0;
        assert!(z.iter().all(|z| z.abs() < 1e-14));
    }

    #[test]
    fn synthesis_inverts_analysis_and_keeps_the_mean_square() {
        for (ny, nx) in [(1, 96), (24, 24), (50, 50), (260, 254)] {
            let (cosine, f) = (Cosine::new(ny, nx), field(ny, nx));
            let (mut z, mut back, mut scratch) =
                (vec![0.0; nx * ny], vec![0.0; nx * ny], cosine.scratch());
            cosine.analyse(&f, &mut z, &mut scratch);
            cosine.synthesise(&z, z[0], &mut back, &mut scratch);
            let worst = f
                .iter()
                .zip(&back)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max);
            assert!(worst < 1e-13, "{ny} x {nx}: {worst:e}");
            let mean_square = f.iter().map(|f| f * f).sum::<f64>() / (nx * ny) as f64;
            assert!((z.iter().map(|z| z * z).sum::<f64>() / mean_square - 1.0).abs() < 1e-13);
        }
    }
}
