//! Waves as ground; and any surface as a sum of waves: its heights on a mesh, and its highest point
//! anywhere.

use super::{Ground, Indenter};
use crate::numerics::fourier::Fourier;
use crate::physics::law::Law;
use crate::physics::mesh::{Grid, POINTS_MAX};
use crate::physics::parameter::{Dimension, LENGTHS, POSITIVE, Refusal, own};
use ndarray::Array2;
use rustfft::num_complex::Complex;
use std::f64::consts::TAU;

/// Sinusoidal waves, h = -amplitude sum_i (1 - cos(2 pi periods_i r_i/L)), a crest in the middle of
/// the cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    /// Half the height from trough to crest of each wave (length).
    pub amplitude: f64,
    /// Waves along x and along y on the side of the cell; 0 is none.
    pub periods: [usize; 2],
}

/// Points along a side for each wave.
const POINTS: usize = 8;

impl Default for Wave {
    fn default() -> Self {
        Self {
            amplitude: 1.0,
            periods: [1, 0],
        }
    }
}

own! { Wave {
    amplitude: Number = "indenter.amplitude", "Amplitude", "", Dimension::Length,
        LENGTHS, None, POSITIVE;
    periods: Counts = "indenter.periods", "Waves", "", Dimension::Pure(""),
        0.0..=(POINTS_MAX / 4) as f64, None, "a whole number of waves along x, or along x and y as in [2, 1], each {range}";
}
    fn check(&self) -> Result<(), Refusal> {
        let allowed = "a whole number above 0 along x or y, as in 2 or [2, 1]";
        if self.periods == [0, 0] {
            Err(self.refuse(allowed))
        } else {
            Ok(())
        }
    }
}

impl Wave {
    fn refuse(&self, allowed: &str) -> Refusal {
        Refusal::new("indenter.periods", format!("{:?}", self.periods), allowed)
    }
}

impl Ground for Wave {
    fn name(&self) -> &'static str {
        "waves"
    }

    fn outline(&self, share: f64) -> f64 {
        0.5 - 0.5 * (2.0 * TAU * share).cos()
    }

    /// One crest in the cell, two ranges high.
    fn suited(&self, law: &Law, grid: &Grid) -> Indenter {
        Indenter::Wave(Self {
            amplitude: 2.0 * law.range,
            periods: [1, usize::from(!grid.is_line())],
        })
    }

    fn at(&self, x: f64, y: f64, length: f64) -> f64 {
        let depth =
            |r: f64, periods: usize| 2.0 * (0.5 * TAU * periods as f64 * r / length).sin().powi(2);
        -self.amplitude * (depth(x, self.periods[0]) + depth(y, self.periods[1]))
    }

    fn points_needed(&self, _length: f64) -> usize {
        self.periods[0].max(self.periods[1]).saturating_mul(POINTS)
    }

    fn is_uniform(&self) -> [bool; 2] {
        self.periods.map(|periods| periods == 0)
    }

    fn has_one_crest(&self) -> bool {
        self.periods.iter().all(|&periods| periods <= 1)
    }

    fn relief(&self, _law: &Law) -> f64 {
        self.amplitude * self.periods.iter().filter(|&&periods| periods > 0).count() as f64
    }

    fn check_auto(&self) -> Result<(), Refusal> {
        if self.points_needed(f64::NAN) > POINTS_MAX {
            let most = POINTS_MAX / POINTS;
            return Err(self.refuse(&format!(
                "with cell.points = \"auto\" at most {most}, each wave with its eight points"
            )));
        }
        Ok(())
    }

    fn check_on(&self, grid: &Grid) -> Result<(), Refusal> {
        let most = grid.nx / 4;
        if self.periods.iter().any(|&periods| periods > most)
            || grid.is_line() && self.periods[1] > 0
        {
            let line = if grid.is_line() {
                "along x alone on a line cell, and "
            } else {
                ""
            };
            return Err(self.refuse(&format!(
                "{line}at most a quarter of the points along a side ({most})"
            )));
        }
        Ok(())
    }
}

/// Points to climb from: the highest on a mesh of eight for each shortest wave. A top may hide
/// beside a higher mesh point.
const STARTS: usize = 24;

/// Most steps from a mesh point to the top of its hill.
const CLIMB_MAX: usize = 30;

/// One wave, Re(amplitude e^{i q r}) with q = 2 pi wave / L.
#[derive(Clone, Copy, Debug)]
pub(super) struct Component {
    pub wave: [i64; 2],
    pub amplitude: Complex<f64>,
}

impl Component {
    /// True if the points of `grid` can tell it from longer ones.
    pub(super) fn is_shown(&self, grid: &Grid) -> bool {
        let [x, y] = self.wave.map(|k| 2 * k.unsigned_abs() as usize);
        x < grid.nx.max(2) && (y == 0 || y < grid.ny.max(2))
    }
}

/// The sum of the waves on the points of `grid`, which must be able to show them.
fn synthesis(waves: &[Component], grid: &Grid) -> Array2<f64> {
    let fourier: Fourier = Fourier::new(grid.ny, grid.nx);
    let mut spectrum = fourier.spectrum();
    for Component {
        wave: [x, y],
        amplitude,
    } in waves
    {
        let column = |y: i64| y.rem_euclid(grid.ny as i64) as usize;
        spectrum[[*x as usize, column(*y)]] = 0.5 * amplitude;
        if *x == 0 {
            spectrum[[0, column(-y)]] = 0.5 * amplitude.conj();
        }
    }
    let mut height = Array2::zeros(grid.shape());
    fourier.inverse(&mut spectrum, &mut height, &mut fourier.scratch());
    height
}

/// The same with the highest point of the surface, not of the mesh, at zero.
pub(super) fn below_crest(waves: &[Component], grid: &Grid) -> Array2<f64> {
    synthesis(waves, grid) - crest(waves, grid)
}

/// The highest value of the sum of the waves anywhere: by Newton's method from the highest points
/// of a mesh that depends on the waves alone.
pub(super) fn crest(waves: &[Component], grid: &Grid) -> f64 {
    let longest = waves
        .iter()
        .flat_map(|w| w.wave)
        .map(i64::unsigned_abs)
        .max()
        .unwrap_or(1) as usize;
    let n = (8 * longest).max(32);
    let mesh = if grid.is_line() {
        Grid::line(grid.length, n)
    } else {
        Grid::square(grid.length, n)
    };
    let height = synthesis(waves, &mesh);
    // The highest points, the highest first.
    let mut starts: Vec<((usize, usize), f64)> = Vec::with_capacity(STARTS + 1);
    for (point, &h) in height.indexed_iter() {
        if starts.len() < STARTS || h > starts[STARTS - 1].1 {
            starts.insert(starts.partition_point(|start| start.1 >= h), (point, h));
            starts.truncate(STARTS);
        }
    }
    let top = |&((j, i), _): &((usize, usize), f64)| {
        climb(waves, longest, [i, j].map(|i| TAU * i as f64 / n as f64))
    };
    starts.iter().map(top).fold(f64::NEG_INFINITY, f64::max)
}

/// Height of the top above `angle` = 2 pi r/L, by Newton's method: steps of at most a mesh spacing,
/// halved until they lead up, with the curvature of a hill in every direction, which a mesh point
/// beside a saddle does not have.
fn climb(waves: &[Component], longest: usize, mut angle: [f64; 2]) -> f64 {
    let reach = TAU / (4 * longest) as f64;
    let mut here = Hill::at(waves, longest, angle);
    for _ in 0..CLIMB_MAX {
        let step = here.step(reach);
        // What is left to gain is lost in the digits of the height.
        if here.slope[0] * step[0] + here.slope[1] * step[1] <= f64::EPSILON * here.height.abs() {
            break;
        }
        let ahead = (0..16).map(|k| 0.5_f64.powi(k)).find_map(|share| {
            let angle = [0, 1].map(|i| angle[i] + share * step[i]);
            let ahead = Hill::at(waves, longest, angle);
            (ahead.height > here.height).then_some((angle, ahead))
        });
        match ahead {
            Some(next) => (angle, here) = next,
            None => break,
        }
    }
    here.height
}

/// Height, slope and second derivatives (xx, xy, yy) of the sum of the waves at a point, with
/// respect to 2 pi r/L.
struct Hill {
    height: f64,
    slope: [f64; 2],
    bend: [f64; 3],
}

impl Hill {
    /// At `angle`, of waves up to `longest` in either direction.
    fn at(waves: &[Component], longest: usize, angle: [f64; 2]) -> Hill {
        // Sine and cosine of x and of y alone: a wave is their product.
        let [along_x, along_y] = angle.map(|angle| {
            (0..=longest)
                .map(|k| (k as f64 * angle).sin_cos())
                .collect::<Vec<_>>()
        });
        let mut hill = Hill {
            height: 0.0,
            slope: [0.0; 2],
            bend: [0.0; 3],
        };
        for Component {
            wave: [i, j],
            amplitude,
        } in waves
        {
            let (x, y) = (*i as f64, *j as f64);
            let (sin_x, cos_x) = along_x[*i as usize];
            let (sin_y, cos_y) = along_y[j.unsigned_abs() as usize];
            let sin_y = if *j < 0 { -sin_y } else { sin_y };
            let (sin, cos) = (sin_x * cos_y + cos_x * sin_y, cos_x * cos_y - sin_x * sin_y);
            let (value, turned) = (
                amplitude.re * cos - amplitude.im * sin,
                -amplitude.re * sin - amplitude.im * cos,
            );
            hill.height += value;
            hill.slope = [hill.slope[0] + x * turned, hill.slope[1] + y * turned];
            hill.bend = [
                hill.bend[0] - x * x * value,
                hill.bend[1] - x * y * value,
                hill.bend[2] - y * y * value,
            ];
        }
        hill
    }

    /// Newton's step, at most `reach`, with both principal curvatures taken as those of a hill:
    /// minus their magnitude.
    fn step(&self, reach: f64) -> [f64; 2] {
        let ([xx, xy, yy], [x, y]) = (self.bend, self.slope);
        let (sin, cos) = (0.5 * (2.0 * xy).atan2(xx - yy)).sin_cos();
        let (mean, radius) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
        let along = |slope: f64, bend: f64| {
            if slope == 0.0 {
                0.0
            } else {
                (slope / bend.abs()).clamp(-reach, reach)
            }
        };
        let (first, second) = (
            along(cos * x + sin * y, mean + radius),
            along(cos * y - sin * x, mean - radius),
        );
        [cos * first - sin * second, sin * first + cos * second]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waves_have_their_crest_in_the_middle_and_their_troughs_two_amplitudes_below() {
        let grid = Grid::square(8.0, 16);
        let height = Wave {
            amplitude: 0.5,
            periods: [2, 0],
        }
        .height(&grid)
        .unwrap();
        assert!(height[[3, 8]] == 0.0 && height[[3, 0]].abs() < 1e-15);
        assert!((height[[5, 4]] + 1.0).abs() < 1e-15 && height[[0, 2]] < 0.0);
        assert!((height[[5, 2]] + 0.5).abs() < 1e-15);
        let both = Wave {
            amplitude: 0.5,
            periods: [1, 1],
        }
        .height(&grid)
        .unwrap();
        assert!((both[[0, 0]] + 2.0).abs() < 1e-15 && both.t() == both);
    }
}
