//! Cosine transform of even fields: one quarter of a periodic cell, mirror-symmetric about x = 0
//! and y = 0.
//!
//! Points sit half a spacing off the mirror, x_j = (j + 1/2) da, so that a quarter of an n x n cell
//! has n/2 x n/2 points and u = sum a_kl cos(pi k (i + 1/2)/m) cos(pi l (j + 1/2)/m) with m = n/2.
//! By J. Makhoul (IEEE Trans. ASSP 28, 27 (1980)) it is the Fourier transform of the field in
//! another order, even points first and odd points backwards, followed by a rotation.

use super::fourier::Real;
use super::fourier::{Fourier, Scratch};
use ndarray::Array2;
use rustfft::num_complex::Complex;
use std::f64::consts::{FRAC_1_SQRT_2, PI, SQRT_2};

/// Plans for fields of one shape (ny, nx).
#[derive(Clone, Debug)]
pub struct Cosine<T: Real = f64> {
    nx: usize,
    ny: usize,
    fourier: Fourier<T>,
    /// e^{-i pi k/(2 nx)} for k <= nx/2, and the same along y.
    turn_x: Vec<Complex<T>>,
    turn_y: Vec<Complex<T>>,
    /// Where the points of the reordered axes come from.
    from_x: Vec<usize>,
    from_y: Vec<usize>,
}

/// Working memory of one transform at a time.
#[derive(Clone, Debug)]
pub struct CosineScratch<T: Real = f64> {
    field: Array2<T>,
    spectrum: Array2<Complex<T>>,
    fourier: Scratch<T>,
}

impl<T: Real> Cosine<T> {
    /// Plans for fields with `ny` rows and `nx` columns; `nx` even, `ny` even or 1.
    pub fn new(ny: usize, nx: usize) -> Self {
        let turns = |m: usize| {
            (0..=m / 2)
                .map(|k| rounded(Complex::cis(-PI * k as f64 / (2 * m) as f64)))
                .collect()
        };
        let order = |m: usize| (0..m).step_by(2).chain((1..m).step_by(2).rev()).collect();
        Self {
            nx,
            ny,
            fourier: Fourier::new(ny, nx),
            turn_x: turns(nx),
            turn_y: turns(ny),
            from_x: order(nx),
            from_y: order(ny),
        }
    }

    /// Shape (ny, nx) of a field.
    pub fn shape(&self) -> (usize, usize) {
        (self.ny, self.nx)
    }

    /// Scratch that fits these plans.
    pub fn scratch(&self) -> CosineScratch<T> {
        CosineScratch {
            field: Array2::zeros((self.ny, self.nx)),
            spectrum: self.fourier.spectrum(),
            fourier: self.fourier.scratch(),
        }
    }

    /// Orthonormal amplitudes z of `field` (ny rows): z.z = mean(field^2). Entry k ny + l belongs
    /// to wave numbers k along x and l along y, in units of half a turn per quarter cell.
    pub fn analyse(&self, field: &[T], z: &mut [f64], scratch: &mut CosineScratch<T>) {
        let (nx, ny) = (self.nx, self.ny);
        let ordered = scratch.field.as_slice_mut().expect("standard layout");
        for (to, &j) in ordered.chunks_exact_mut(nx).zip(&self.from_y) {
            let from = &field[j * nx..(j + 1) * nx];
            for (t, &i) in to.iter_mut().zip(&self.from_x) {
                *t = from[i];
            }
        }
        self.fourier
            .forward(&scratch.field, &mut scratch.spectrum, &mut scratch.fourier);
        let spectrum = scratch.spectrum.as_slice().expect("standard layout");
        let (low, high) = z.split_at_mut((nx / 2 + 1) * ny);
        for (k, (v, z)) in spectrum
            .chunks_exact(ny)
            .zip(low.chunks_exact_mut(ny))
            .enumerate()
        {
            // Both halves of the wave numbers along x come from one row of the spectrum: k, and
            // nx - k where it is another.
            let turn = self.turn_x[k] * T::rounded(if k == 0 { 1.0 } else { SQRT_2 });
            let mirror = if k == 0 || 2 * k == nx {
                None
            } else {
                Some(nx / 2 - 1 - k)
            };
            let mut spare = [];
            let other = mirror.map_or(&mut spare[..], |m| &mut high[m * ny..(m + 1) * ny]);
            self.turn_row(v, turn, z, other);
        }
    }

    /// Amplitudes of one row k of the spectrum along y, and of its mirror (if there is one).
    #[inline]
    fn turn_row(&self, v: &[Complex<T>], turn: Complex<T>, z: &mut [f64], other: &mut [f64]) {
        let ny = v.len();
        let half_root = T::rounded(FRAC_1_SQRT_2);
        let first = turn * v[0];
        z[0] = first.re.widened();
        let (v, z) = (&v[1..], &mut z[1..]);
        let half = ny / 2;
        let turns = &self.turn_y[1..];
        let has_other = !other.is_empty();
        if has_other {
            other[0] = -first.im.widened();
        }
        for l in 0..half {
            // v[l] and v[m] are the wave numbers l + 1 and -(l + 1); they meet in the middle.
            let m = ny - 2 - l;
            let (a, b) = (turns[l] * v[l], turns[l].conj() * v[m]);
            let (y, d) = (turn * ((a + b) * half_root), turn * ((a - b) * half_root));
            z[l] = y.re.widened();
            if m != l {
                z[m] = -d.im.widened();
            }
            if has_other {
                other[l + 1] = -y.im.widened();
                if m != l {
                    other[m + 1] = -d.re.widened();
                }
            }
        }
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
        let (nx, ny) = (self.nx, self.ny);
        let spectrum = scratch.spectrum.as_slice_mut().expect("standard layout");
        let half_root = T::rounded(FRAC_1_SQRT_2);
        for (k, v) in spectrum.chunks_exact_mut(ny).enumerate() {
            let mirror = (nx - k) % nx;
            let turn = self.turn_x[k].conj() * if k == 0 { T::one() } else { half_root };
            let get = |l: usize| {
                turn * rounded(Complex::new(
                    z[k * ny + l],
                    if k == 0 { 0.0 } else { -z[mirror * ny + l] },
                ))
            };
            v[0] = get(0);
            for l in 1..=ny / 2 {
                let (y, m) = (get(l) * half_root, get(ny - l) * half_root);
                let turned = Complex::new(-m.im, m.re);
                v[l] = self.turn_y[l].conj() * (y - turned);
                v[ny - l] = self.turn_y[l] * (y + turned);
            }
        }
        spectrum[0].re = spectrum[0].re + T::rounded(mean - z[0]);
        self.fourier.inverse(
            &mut scratch.spectrum,
            &mut scratch.field,
            &mut scratch.fourier,
        );
        let ordered = scratch.field.as_slice().expect("standard layout");
        for (from, &j) in ordered.chunks_exact(nx).zip(&self.from_y) {
            let to = &mut field[j * nx..(j + 1) * nx];
            for (f, &i) in from.iter().zip(&self.from_x) {
                to[i] = *f;
            }
        }
    }
}

/// The nearest complex number.
fn rounded<T: Real>(c: Complex<f64>) -> Complex<T> {
    Complex::new(T::rounded(c.re), T::rounded(c.im))
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn synthesis_inverts_analysis_and_keeps_the_mean_square() {
        for (ny, nx) in [(1, 96), (24, 24), (50, 50), (128, 128)] {
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
