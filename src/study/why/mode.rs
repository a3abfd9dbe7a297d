//! What a soft mode does to a pattern: its dominant wave, its shape, and what holds against it.

use crate::numerics::fourier::Fourier;
use crate::physics::control::Control;
use crate::physics::pattern::{Island, Pattern, rolled, shift_to_middle};
use crate::scene::Model;
use ndarray::{Array2, ArrayView2, Axis};
use rustfft::num_complex::Complex;

/// What a disturbance of another symmetry does to a pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// Makes a ridge thick and thin in turn, so many times along the cell.
    BreakUp {
        /// How often.
        waves: usize,
    },
    /// Moves a ridge to and fro, so many times along the cell.
    Meander {
        /// How often.
        waves: usize,
    },
    /// Makes a round pattern longer along one axis and shorter along the other.
    Stretching,
    /// Anything else.
    Other,
}

/// Share of a mode that must change its sign under the exchange of the axes to be a stretching.
const ODD: f64 = 0.5;

/// What resists a mode and what drives it, as in Eq. 8: they add up to its eigenvalue (E*/L).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Balance {
    /// Stiffness of the body, and of the machine where the mode moves the mean.
    pub body: f64,
    /// gamma'' where the mode moves the surface, weighted with its square.
    pub law: f64,
}

/// The amplitudes of a field, as [`Fourier`] lays them out.
fn spectrum(field: &Array2<f64>) -> Array2<Complex<f64>> {
    let (ny, nx) = field.dim();
    let fourier: Fourier = Fourier::with_lanes(ny, nx, 1);
    let mut spectrum = fourier.spectrum();
    let field = field.as_standard_layout().into_owned();
    fourier.forward(&field, &mut spectrum, &mut fourier.scratch());
    spectrum
}

/// The wave of the largest amplitude in a field of shape (ny, nx): how often it fits into the cell
/// along x and along y. Zero both ways is the mean.
pub fn dominant_wave(field: &Array2<f64>) -> [usize; 2] {
    let ny = field.nrows();
    let spectrum = spectrum(field);
    let largest = spectrum
        .indexed_iter()
        .max_by(|a, b| a.1.norm_sqr().total_cmp(&b.1.norm_sqr()));
    largest.map_or([0, 0], |((x, y), _)| [x, y.min(ny - y)])
}

/// What holds against a `mode` of the state of this `gap`, and what drives it.
pub(super) fn balance(
    model: &Model,
    control: Control,
    gap: &Array2<f64>,
    mode: &Array2<f64>,
) -> Balance {
    let (ny, nx) = mode.dim();
    let body = model.body.elastic();
    let (mut all, mut held) = (0.0, 0.0);
    for ((x, y), amplitude) in spectrum(mode).indexed_iter() {
        let periods = (x as f64).hypot(y.min(ny - y) as f64);
        let stiffness = if periods == 0.0 {
            control.stiffness()
        } else {
            body.stiffness(periods * model.grid.q1())
        };
        // The half that is left out is the mirror image of what is there.
        let twice = if x == 0 || 2 * x == nx { 1.0 } else { 2.0 };
        let weight = twice * amplitude.norm_sqr();
        all += weight;
        // Nothing moves against a machine that does not give.
        if stiffness.is_finite() {
            held += weight * stiffness;
        }
    }
    let moved = gap.iter().zip(mode);
    let moved = moved.map(|(g, m)| m * m * model.law.at(*g).stiffness);
    let length = model.grid.length;
    Balance {
        body: length * held / all,
        law: length * moved.sum::<f64>() / mode.iter().map(|m| m * m).sum::<f64>(),
    }
}

/// What a `mode` does to the pattern of this `gap`.
pub(super) fn shape(pattern: Pattern, gap: &Array2<f64>, mode: &Array2<f64>) -> Shape {
    match pattern {
        Pattern::Ridge if gap.nrows() > 1 => ridge(gap, mode),
        Pattern::Bulge | Pattern::Dimple
            if gap.is_square() && is_stretching(pattern, gap, mode) =>
        {
            Shape::Stretching
        }
        _ => Shape::Other,
    }
}

fn ridge(gap: &Array2<f64>, mode: &Array2<f64>) -> Shape {
    let across_x = spread(gap, Axis(0)) >= spread(gap, Axis(1));
    let [x, y] = dominant_wave(mode);
    let waves = if across_x { y } else { x };
    if waves == 0 {
        return Shape::Other;
    }
    let parity = if across_x {
        parity(gap.view(), mode.view())
    } else {
        parity(gap.t(), mode.t())
    };
    if parity > 0.0 {
        Shape::BreakUp { waves }
    } else {
        Shape::Meander { waves }
    }
}

/// How much the mean of a field over an axis varies along the other.
fn spread(field: &Array2<f64>, axis: Axis) -> f64 {
    field
        .mean_axis(axis)
        .map_or(0.0, |profile| profile.std(0.0))
}

/// Whether a mode is even (1) or odd (-1) under the reflection across a ridge that runs along the
/// rows' axis.
fn parity(gap: ArrayView2<'_, f64>, mode: ArrayView2<'_, f64>) -> f64 {
    let nx = gap.ncols();
    let Some(profile) = gap.mean_axis(Axis(0)) else {
        return 0.0;
    };
    let mirrored = |about: usize, i: usize| (about + nx - i) % nx;
    // Twice the middle of the ridge, which may lie between two points.
    let even = |about: &usize| -> f64 {
        (0..nx)
            .map(|i| profile[i] * profile[mirrored(*about, i)])
            .sum()
    };
    let about = (0..nx)
        .max_by(|a, b| even(a).total_cmp(&even(b)))
        .unwrap_or(0);
    let both = mode.indexed_iter();
    let both = both.map(|((j, i), v)| v * mode[(j, mirrored(about, i))]);
    both.sum::<f64>() / mode.iter().map(|v| v * v).sum::<f64>()
}

/// Whether a mode changes its sign when x and y are exchanged about the middle of the pattern.
fn is_stretching(pattern: Pattern, gap: &Array2<f64>, mode: &Array2<f64>) -> bool {
    let island = if pattern == Pattern::Dimple {
        Island::Hole
    } else {
        Island::Contact
    };
    let (dy, dx) = shift_to_middle(gap, island);
    let mode = rolled(mode, dy, dx);
    let exchanged = (&mode * &mode.t()).sum();
    exchanged < -ODD * mode.iter().map(|v| v * v).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const N: usize = 32;

    fn field(f: impl Fn(f64, f64) -> f64) -> Array2<f64> {
        Array2::from_shape_fn((N, N), |(j, i)| {
            f(TAU * i as f64 / N as f64, TAU * j as f64 / N as f64)
        })
    }

    #[test]
    fn the_dominant_wave_is_counted_along_x_and_along_y_whatever_its_sign() {
        let wave = field(|x, y| (3.0 * x - 5.0 * y).cos() + 0.3 * x.sin());
        assert_eq!(dominant_wave(&wave), [3, 5]);
        assert_eq!(dominant_wave(&field(|_, y| y.sin())), [0, 1]);
        assert_eq!(dominant_wave(&field(|x, _| 2.0 + x.cos())), [0, 0]);
        let line = Array2::from_shape_fn((1, N), |(_, i)| (TAU * 2.0 * i as f64 / N as f64).sin());
        assert_eq!(dominant_wave(&line), [2, 0]);
    }

    #[test]
    fn a_ridge_breaks_up_by_an_even_wave_along_it_and_meanders_by_an_odd_one() {
        for middle in [0.0, 1.3, 4.0] {
            let gap = field(|x, _| 3.0 - (x - middle).cos());
            let broken = field(|x, y| (1.0 + 0.5 * (x - middle).cos()) * (2.0 * y).cos());
            let moved = field(|x, y| (x - middle).sin() * y.cos());
            let across = field(|x, _| (x - middle).sin());
            let turned = |field: &Array2<f64>| field.t().as_standard_layout().into_owned();
            for (mode, wanted) in [
                (broken, Shape::BreakUp { waves: 2 }),
                (moved, Shape::Meander { waves: 1 }),
                (across, Shape::Other),
            ] {
                assert_eq!(shape(Pattern::Ridge, &gap, &mode), wanted, "{middle}");
                let turned = shape(Pattern::Ridge, &turned(&gap), &turned(&mode));
                assert_eq!(turned, wanted, "{middle}");
            }
        }
    }

    #[test]
    fn a_bulge_is_stretched_by_what_is_odd_under_the_exchange_of_its_axes() {
        let at = TAU / N as f64 * 5.0;
        let gap = field(|x, y| 3.0 - (x - at).cos() - (y - 2.0 * at).cos());
        let odd = field(|x, y| (x - at).cos() - (y - 2.0 * at).cos());
        let even = field(|x, y| (x - at).cos() + (y - 2.0 * at).cos());
        assert_eq!(shape(Pattern::Bulge, &gap, &odd), Shape::Stretching);
        assert_eq!(shape(Pattern::Bulge, &gap, &even), Shape::Other);
    }
}
