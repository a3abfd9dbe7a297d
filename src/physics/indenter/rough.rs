//! Self-affine random roughness: a periodic sum of waves with prescribed amplitudes and random
//! phases.
//!
//! h(r) = sum_q a_q cos(q r + phi_q) - crest, with the phases phi_q drawn uniformly and the
//! amplitudes a_q^2 proportional to the spectrum C(q): q^-2(1+H) between 2 pi/longest and 2
//! pi/shortest, constant below (a plateau down to the longest wave of the cell), zero above. A line
//! cell has profiles of the same Hurst exponent, C(q) ~ q^-(1+2H). As only the phases are random,
//! height and gradient have exactly their root mean squares, whatever the seed.

use super::wave::{Component, below_crest, crest};
use super::{Ground, Indenter};
use crate::physics::law::Law;
use crate::physics::mesh::Grid;
use crate::physics::parameter::{Dimension, LENGTHS, Refusal, SEED_MAX, Value, number, own};
use ndarray::Array2;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use rustfft::num_complex::Complex;
use std::f64::consts::TAU;

/// Most waves along a side of the cell: `longest` and `shortest` are at least this share of its
/// length.
pub const WAVES_MAX: usize = 512;

/// A self-affine random surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rough {
    /// Hurst exponent H, 0 to 1.
    pub hurst: f64,
    /// Root mean square height about the mean (length).
    pub rms: f64,
    /// Longest wavelength of the self-affine part (length): longer waves have the spectrum of this
    /// one.
    pub longest: f64,
    /// Shortest wavelength (length).
    pub shortest: f64,
    /// Seed of the phases.
    pub seed: u64,
}

impl Default for Rough {
    fn default() -> Self {
        Self {
            hurst: 0.8,
            rms: 1.0,
            longest: 8.0,
            shortest: 2.0,
            seed: 1,
        }
    }
}

own! { Rough {
    hurst: Number = "indenter.hurst", "Hurst exponent", "", Dimension::Pure(""),
        1e-12..=1.0, None, "a number above 0, at most 1, {range}, as in 0.8";
    rms: Number = "indenter.rms", "RMS height", "", Dimension::Length,
        LENGTHS, None, "the root mean square height, a finite number above 0, {range}";
    longest: Number = "indenter.longest", "Longest wave", "", Dimension::Length,
        LENGTHS, None, "a wavelength, at most cell.length, {range}";
    shortest: Number = "indenter.shortest", "Shortest wave", "", Dimension::Length,
        LENGTHS, None, "a wavelength from cell.length/512 to indenter.longest, {range}";
    seed: Whole = "indenter.seed", "Surface seed", "", Dimension::Pure(""),
        0.0..=SEED_MAX, Some(Value::Whole(1)), "a whole number {range}";
}}

// The hint of `shortest` quotes it.
const _: () = assert!(WAVES_MAX == 512);

impl Ground for Rough {
    fn name(&self) -> &'static str {
        "rough"
    }

    /// Four ranges high, in waves from the cell's length down to what its mesh shows well.
    fn suited(&self, law: &Law, grid: &Grid) -> Indenter {
        let shortest = (8.0 * grid.spacing())
            .max(grid.length / 16.0)
            .min(grid.length);
        Indenter::Rough(Self {
            hurst: 0.8,
            rms: 4.0 * law.range,
            longest: grid.length,
            shortest,
            seed: 1,
        })
    }

    fn at(&self, _x: f64, _y: f64, _length: f64) -> f64 {
        unreachable!("its waves are summed over a mesh")
    }

    /// Of every mesh of the same cell the same surface; one too coarse for the shortest waves shows
    /// it without them.
    fn height(&self, grid: &Grid) -> Option<Array2<f64>> {
        Some(below_crest(&self.shown(grid), grid))
    }

    fn is_even(&self) -> bool {
        false
    }

    fn points_needed(&self, length: f64) -> usize {
        (4.0 * length / self.shortest).ceil() as usize
    }

    /// About three times its root mean square.
    fn relief(&self, _law: &Law) -> f64 {
        3.0 * self.rms
    }

    fn check_in(&self, length: f64) -> Result<(), Refusal> {
        let Self {
            longest, shortest, ..
        } = *self;
        if longest > length {
            let allowed = format!("above 0, at most cell.length = {}", number(length));
            return Err(Refusal::new("indenter.longest", number(longest), &allowed));
        }
        let least = length / WAVES_MAX as f64;
        if !(shortest >= least && shortest <= longest) {
            let allowed = format!(
                "from {} (cell.length/{WAVES_MAX}) to indenter.longest = {}",
                number(least),
                number(longest)
            );
            return Err(Refusal::new(
                "indenter.shortest",
                number(shortest),
                &allowed,
            ));
        }
        Ok(())
    }

    fn left_out(&self, grid: &Grid) -> Option<String> {
        let words = format!(
            "the mesh is too coarse for waves of length {}: the shortest ones are left out",
            self.shortest
        );
        (!self.fits(grid)).then_some(words)
    }
}

impl Rough {
    /// Mean of the height (length), minus the height of the crest above it.
    pub fn mean_height(&self, grid: &Grid) -> f64 {
        -crest(&self.shown(grid), grid)
    }

    /// The waves that the points of `grid` can tell from longer ones.
    fn shown(&self, grid: &Grid) -> Vec<Component> {
        let mut waves = self.waves(grid);
        waves.retain(|wave| wave.is_shown(grid));
        waves
    }

    /// True if the mesh has at least the two points that each shortest wave needs.
    pub fn fits(&self, grid: &Grid) -> bool {
        self.shortest > 2.0 * grid.spacing()
    }

    /// Spectrum at wave number `q` (any unit) of a surface, or of a profile.
    fn spectrum(&self, q: f64, profile: bool) -> f64 {
        // The shortest wave itself counts, whatever rounding does to it.
        if q > TAU / self.shortest * (1.0 + 1e-9) {
            return 0.0;
        }
        let decay = 2.0 * self.hurst + if profile { 1.0 } else { 2.0 };
        (q * self.longest / TAU).max(1.0).powf(-decay)
    }

    /// All waves of one half plane. The phases are drawn ring by ring outwards, so that neither the
    /// mesh nor a shorter `shortest` changes those of the longer waves.
    fn waves(&self, grid: &Grid) -> Vec<Component> {
        let mut rng = Pcg64::seed_from_u64(self.seed);
        let mut waves = Vec::new();
        let mut sum = 0.0;
        for ring in 1..=(grid.length / self.shortest * (1.0 + 1e-9)) as i64 {
            for x in 0..=ring {
                let reach = if grid.is_line() { 0 } else { ring };
                for y in -reach..=reach {
                    if x.max(y.abs()) < ring || x == 0 && y < 0 {
                        continue;
                    }
                    let phase = rng.random_range(0.0..TAU);
                    let power =
                        self.spectrum(grid.q1() * (x as f64).hypot(y as f64), grid.is_line());
                    if power > 0.0 {
                        sum += 0.5 * power;
                        waves.push(Component {
                            wave: [x, y],
                            amplitude: Complex::from_polar(power.sqrt(), phase),
                        });
                    }
                }
            }
        }
        let scale = self.rms / sum.sqrt();
        waves.iter_mut().for_each(|w| w.amplitude *= scale);
        waves
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::fourier::Fourier;
    use proptest::prelude::*;

    fn surfaces() -> impl Strategy<Value = Rough> {
        (0.1..1.0, 0.1..3.0, 0.2..1.0, 0.1..0.15, any::<u64>()).prop_map(
            |(hurst, rms, longest, shortest, seed)| {
                // In a cell of side 20: at most 10 waves along a side.
                Rough {
                    hurst,
                    rms,
                    longest: 20.0 * longest,
                    shortest: 20.0 * shortest,
                    seed,
                }
            },
        )
    }

    fn grids(n: usize) -> [Grid; 2] {
        [Grid::square(20.0, n), Grid::line(20.0, n)]
    }

    /// Root mean square of |grad h|, wave by wave.
    fn rms_gradient(surface: &Rough, grid: &Grid) -> f64 {
        let square = |w: &Component| {
            let [x, y] = w.wave;
            0.5 * w.amplitude.norm_sqr() * (x * x + y * y) as f64 * grid.q1().powi(2)
        };
        surface.waves(grid).iter().map(square).sum::<f64>().sqrt()
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

        #[test]
        fn the_height_has_the_asked_root_mean_square_and_the_gradient_that_of_its_differences(surface in surfaces()) {
            for grid in grids(256) {
                let h = surface.height(&grid).unwrap();
                let mean = h.mean().unwrap();
                let rms = h.mapv(|h| (h - mean).powi(2)).mean().unwrap().sqrt();
                prop_assert!((rms / surface.rms - 1.0).abs() < 1e-10, "{}", rms);
                // Central differences over the periodic cell: each wave loses (q a)^2/6 of its
                // slope, at most 1 % here.
                let (ny, nx) = grid.shape();
                let square = |j: usize, i: usize| {
                    let x = h[[j, (i + 1) % nx]] - h[[j, (i + nx - 1) % nx]];
                    let y = if ny == 1 { 0.0 } else { h[[(j + 1) % ny, i]] - h[[(j + ny - 1) % ny, i]] };
                    (x * x + y * y) / (2.0 * grid.spacing()).powi(2)
                };
                let gradient = Array2::from_shape_fn((ny, nx), |(j, i)| square(j, i)).mean().unwrap().sqrt();
                let exact = rms_gradient(&surface, &grid);
                prop_assert!((gradient / exact - 1.0).abs() < 0.011 && gradient < exact, "{} {}", gradient, exact);
            }
        }

        #[test]
        fn a_finer_mesh_shows_the_same_surface_and_its_crest_is_at_zero(surface in surfaces()) {
            for (coarse, fine) in grids(32).into_iter().zip(grids(256)) {
                let (coarse, fine) = (surface.height(&coarse).unwrap(), surface.height(&fine).unwrap());
                for ((j, i), h) in coarse.indexed_iter() {
                    prop_assert!((h - fine[[8 * j, 8 * i]]).abs() < 1e-10 * surface.rms);
                }
                let highest = fine.iter().cloned().fold(f64::NEG_INFINITY, f64::max);
                // No mesh point is above the crest, and with 25 points on the shortest wave one is
                // close to it.
                prop_assert!(highest < 1e-12 * surface.rms && highest > -0.05 * surface.rms, "{}", highest);
            }
        }

        #[test]
        fn the_seed_decides_and_shorter_waves_leave_the_longer_ones_alone(surface in surfaces()) {
            for grid in grids(64) {
                prop_assert_eq!(surface.height(&grid).unwrap(), surface.height(&grid).unwrap());
                prop_assert_ne!(surface.height(&grid).unwrap(), Rough { seed: surface.seed ^ 1, ..surface }.height(&grid).unwrap());
                let longer = surface.waves(&grid);
                let shorter = Rough { shortest: 0.5 * surface.shortest, ..surface }.waves(&grid);
                for wave in longer {
                    let same = shorter.iter().find(|w| w.wave == wave.wave).unwrap();
                    prop_assert!((same.amplitude.arg() - wave.amplitude.arg()).abs() < 1e-12);
                }
            }
        }
    }

    /// Slope of ln of the mean square amplitude per wave against ln q, by least squares over rings
    /// of the transformed field.
    fn measured_decay(grid: &Grid, low: f64, high: f64) -> f64 {
        let surface = Rough {
            hurst: 0.7,
            rms: 1.0,
            longest: 5.0,
            shortest: 0.5,
            seed: 3,
        };
        let height = surface.height(grid).unwrap();
        let fourier: Fourier = Fourier::new(grid.ny, grid.nx);
        let mut spectrum = fourier.spectrum();
        fourier.forward(&height, &mut spectrum, &mut fourier.scratch());
        let (mut n, mut sums) = (0.0, [0.0; 4]);
        for ((x, y), a) in spectrum.indexed_iter() {
            let y = if 2 * y > grid.ny {
                y as f64 - grid.ny as f64
            } else {
                y as f64
            };
            let q = grid.q1() * (x as f64).hypot(y);
            if q > low && q < high {
                let (u, v) = (q.ln(), a.norm_sqr().ln());
                n += 1.0;
                sums = [sums[0] + u, sums[1] + v, sums[2] + u * u, sums[3] + u * v];
            }
        }
        (n * sums[3] - sums[0] * sums[1]) / (n * sums[2] - sums[0] * sums[0])
    }

    #[test]
    fn the_spectrum_is_flat_up_to_the_longest_wave_and_falls_with_the_hurst_exponent_from_there() {
        let edge = TAU / 5.0;
        let (square, line) = (Grid::square(20.0, 128), Grid::line(20.0, 128));
        assert!((measured_decay(&square, 1.01 * edge, 9.9 * edge) + 3.4).abs() < 1e-6);
        assert!((measured_decay(&line, 1.01 * edge, 9.9 * edge) + 2.4).abs() < 1e-6);
        assert!(measured_decay(&square, 0.0, 0.99 * edge).abs() < 1e-6);
    }

    #[test]
    fn a_ground_takes_no_more_waves_than_its_mesh_has_points_and_all_where_it_shows_them() {
        let most = Rough {
            longest: 20.0,
            shortest: 20.0 / WAVES_MAX as f64,
            seed: 5,
            ..Rough::default()
        };
        for grid in grids(16) {
            assert!(most.shown(&grid).len() <= grid.points() / 2);
            let height = most.height(&grid).unwrap();
            assert!(height.iter().all(|h| *h <= 1e-12 && h.is_finite()));
        }
        let some = Rough {
            shortest: 2.0,
            ..most
        };
        for grid in grids(24) {
            assert_eq!(some.shown(&grid).len(), some.waves(&grid).len());
        }
    }

    #[test]
    fn a_mesh_too_coarse_for_the_shortest_waves_shows_the_surface_without_them() {
        let surface = Rough {
            longest: 10.0,
            shortest: 1.0,
            seed: 5,
            ..Rough::default()
        };
        let coarse = Grid::square(20.0, 16);
        assert!(!surface.fits(&coarse) && surface.fits(&Grid::square(20.0, 64)));
        let height = surface.height(&coarse).unwrap();
        let mean = height.mean().unwrap();
        let rms = height.mapv(|h| (h - mean).powi(2)).mean().unwrap().sqrt();
        assert!(rms < 1.0 && rms > 0.9, "{rms}");
    }
}
