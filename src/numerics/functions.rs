//! Functions of one number: a vectorisable exponential, with the dispatch that lets it use the
//! widest vectors of the processor; smooth ones as series of Chebyshev polynomials; spherical Bessel
//! functions, many orders at once.

use pulp::Arch;
use std::f64::consts::PI;
use std::sync::OnceLock;

/// Independent partial sums: two registers of AVX2, one of AVX-512.
const LANES: usize = 8;

const LOG2_E: f64 = std::f64::consts::LOG2_E;
/// ln 2 in two parts (Cody and Waite): the first has zeros in its low bits, so that its products
/// with small integers are exact.
const LN2_HIGH: f64 = 6.931_471_803_691_238e-1;
const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;
/// Adding and subtracting 1.5 x 2^52 rounds to the nearest integer, and leaves that integer in the
/// low bits.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// e^x without branches or table, so that loops over it vectorise; relative error below 4e-16.
///
/// Arguments are clamped to [-708, 709]: the result stays finite and above zero (inputs that need
/// more overflow in their products, and NaN stays NaN).
#[inline(always)]
pub fn exp(x: f64) -> f64 {
    let x = if x > 709.0 { 709.0 } else { x };
    let x = if x < -708.0 { -708.0 } else { x };
    let shifted = x * LOG2_E + ROUND;
    let n = shifted - ROUND;
    let r = (x - n * LN2_HIGH) - n * LN2_LOW;
    // Taylor series to r^13: |r| <= ln(2)/2, so the first omitted term is below 5e-18.
    let mut s = 1.0 / 6_227_020_800.0;
    for c in [
        1.0 / 479_001_600.0,
        1.0 / 39_916_800.0,
        1.0 / 3_628_800.0,
        1.0 / 362_880.0,
        1.0 / 40_320.0,
        1.0 / 5_040.0,
        1.0 / 720.0,
        1.0 / 120.0,
        1.0 / 24.0,
        1.0 / 6.0,
        0.5,
        1.0,
        1.0,
    ] {
        s = s * r + c;
    }
    // The clamp keeps n within [-1022, 1023], so the exponent field never leaves the normal range.
    s * f64::from_bits((shifted.to_bits().wrapping_add(1023)) << 52)
}

/// Runs `work` compiled for the processor at hand. `work` must be `#[inline(always)]` all the way
/// down to gain from it.
fn dispatch<R>(work: impl FnOnce() -> R) -> R {
    static ARCH: OnceLock<Arch> = OnceLock::new();
    ARCH.get_or_init(Arch::new).dispatch(work)
}

/// Numbers of one block of [`map_sum`]: long enough for the loop vectoriser, short enough for the
/// first cache.
const BLOCK: usize = 64;

/// Applies `f`, which returns a summand and two outputs, to every input; returns the sum. One pass,
/// compiled for the processor at hand if `f` is `#[inline(always)]`.
pub fn map_sum(
    input: &[f64],
    [first, second]: [&mut [f64]; 2],
    f: impl Fn(f64) -> [f64; 3] + Copy,
) -> f64 {
    dispatch(
        #[inline(always)]
        || {
            let (mut xs, mut ys, mut zs) = (
                input.chunks(BLOCK),
                first.chunks_mut(BLOCK),
                second.chunks_mut(BLOCK),
            );
            let mut lanes = [0.0; LANES];
            while let (Some(x), Some(y), Some(z)) = (xs.next(), ys.next(), zs.next()) {
                // Fixed-size copies: loops of known length without bounds checks are what the
                // vectoriser takes.
                let (mut input, mut sums, mut one, mut two) =
                    ([0.0; BLOCK], [0.0; BLOCK], [0.0; BLOCK], [0.0; BLOCK]);
                input[..x.len()].copy_from_slice(x);
                for i in 0..BLOCK {
                    [sums[i], one[i], two[i]] = f(input[i]);
                }
                y.copy_from_slice(&one[..y.len()]);
                z.copy_from_slice(&two[..z.len()]);
                sums[x.len()..].fill(0.0);
                for part in sums.chunks_exact(LANES) {
                    for (lane, s) in lanes.iter_mut().zip(part) {
                        *lane += s;
                    }
                }
            }
            lanes.iter().sum()
        },
    )
}

/// A smooth function as a series of Chebyshev polynomials: sum c_k T_k(t) with t from -1 to 1 over the interval.
#[derive(Clone, Debug)]
pub struct Chebyshev {
    low: f64,
    high: f64,
    coefficients: Vec<f64>,
}

impl Chebyshev {
    /// The polynomial of `points` terms that agrees with `f` at as many points between `low` and
    /// `high`.
    pub fn interpolate(low: f64, high: f64, points: usize, f: impl Fn(f64) -> f64) -> Self {
        let angle = |i: usize| PI * (i as f64 + 0.5) / points as f64;
        let values: Vec<f64> = (0..points)
            .map(|i| f(low + (high - low) * 0.5 * (1.0 + angle(i).cos())))
            .collect();
        let coefficient = |k: usize| {
            let sum: f64 = values
                .iter()
                .enumerate()
                .map(|(i, v)| v * (k as f64 * angle(i)).cos())
                .sum();
            sum * if k == 0 { 1.0 } else { 2.0 } / points as f64
        };
        Self {
            low,
            high,
            coefficients: (0..points).map(coefficient).collect(),
        }
    }

    /// Its derivative.
    pub fn derivative(&self) -> Self {
        let n = self.coefficients.len();
        // c'_{k-1} = c'_{k+1} + 2 k c_k.
        let mut slope = vec![0.0; n + 1];
        for k in (1..n).rev() {
            slope[k - 1] =
                slope.get(k + 1).copied().unwrap_or(0.0) + 2.0 * k as f64 * self.coefficients[k];
        }
        slope[0] *= 0.5;
        slope.truncate(n.saturating_sub(1).max(1));
        slope
            .iter_mut()
            .for_each(|c| *c *= 2.0 / (self.high - self.low));
        Self {
            coefficients: slope,
            ..*self
        }
    }

    /// Its value at `x`, by Clenshaw's recurrence.
    pub fn at(&self, x: f64) -> f64 {
        let t = (2.0 * x - self.low - self.high) / (self.high - self.low);
        let (mut b1, mut b2) = (0.0, 0.0);
        for c in self.coefficients.iter().skip(1).rev() {
            (b1, b2) = (2.0 * t * b1 - b2 + c, b1);
        }
        t * b1 - b2 + self.coefficients[0]
    }
}

/// Fills `out` with j_0(x), j_1(x), ... for x >= 0, the spherical Bessel functions of the first kind.
///
/// Upwards from j_0 and j_1 while orders stay below x, where that loses nothing; else downwards (J.
/// C. P. Miller) from an order so high that what it leaves out is below rounding.
pub fn spherical_bessel(x: f64, out: &mut [f64]) {
    let orders = out.len();
    if x < 1e-8 {
        // 1, x/3, and powers of x that are below the rounding of 1.
        out.iter_mut()
            .zip([1.0, x / 3.0].into_iter().chain(std::iter::repeat(0.0)))
            .for_each(|(j, small)| *j = small);
        return;
    }
    let (sin, cos) = x.sin_cos();
    let first = [sin / x, (sin / x - cos) / x];
    if orders as f64 <= x + 1.0 {
        let [mut here, mut next] = first;
        for (order, j) in out.iter_mut().enumerate() {
            *j = here;
            (here, next) = (next, (2 * order + 3) as f64 / x * next - here);
        }
        return;
    }
    let highest = orders.max(x as usize) + 20 + (12.0 * x.cbrt()) as usize;
    let (mut above, mut here) = (0.0, 1e-290);
    let mut found = [0.0; 2];
    for order in (0..=highest).rev() {
        if let Some(j) = out.get_mut(order) {
            *j = here;
        }
        if order < 2 {
            found[order] = here;
        }
        (above, here) = (here, (2 * order + 1) as f64 / x * here - above);
        if here.abs() > 1e250 {
            (above, here) = (above * 1e-250, here * 1e-250);
            out.iter_mut().skip(order).for_each(|j| *j *= 1e-250);
            found[1] *= 1e-250;
        }
    }
    // Scaled by the larger of the two, which is not near one of its zeros.
    let scale = if first[0].abs() > first[1].abs() {
        first[0] / found[0]
    } else {
        first[1] / found[1]
    };
    out.iter_mut().for_each(|j| *j *= scale);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exp_agrees_with_the_standard_library_to_four_units_in_1e16() {
        let mut worst = 0.0_f64;
        for i in 0..400_001 {
            let x = -700.0 + f64::from(i) * 0.0035;
            worst = worst.max((exp(x) / x.exp() - 1.0).abs());
        }
        assert!(worst < 5e-16, "{worst:e}");
    }

    #[test]
    fn exp_is_finite_and_positive_at_the_ends_and_keeps_nan() {
        for x in [
            -1e300,
            -745.0,
            709.5,
            1e300,
            f64::INFINITY,
            f64::NEG_INFINITY,
        ] {
            assert!(exp(x).is_finite() && exp(x) > 0.0, "{x}");
        }
        assert!(exp(f64::NAN).is_nan());
    }

    #[test]
    fn by_chebyshev_an_exponential_and_its_derivatives_are_met() {
        let series = Chebyshev::interpolate(-0.5, 2.0, 20, |x| (1.3 * x).exp());
        let (slope, curvature) = (series.derivative(), series.derivative().derivative());
        for x in [-0.5, 0.1, 0.77, 2.0_f64] {
            let expected = (1.3 * x).exp();
            assert!((series.at(x) - expected).abs() < 1e-13 * 14.0);
            assert!((slope.at(x) / 1.3 - expected).abs() < 1e-11);
            assert!((curvature.at(x) / 1.69 - expected).abs() < 1e-9);
        }
    }

    #[test]
    fn a_cubic_needs_four_points() {
        let series = Chebyshev::interpolate(1.0, 4.0, 4, |x| x * x * x - 2.0 * x);
        assert!((series.at(2.5) - 10.625).abs() < 1e-13);
        assert!((series.derivative().at(2.5) - 16.75).abs() < 1e-12);
    }

    /// Of j_0.
    const NEXT_TO_A_ZERO: f64 = 0.999_999 * PI;

    #[test]
    fn spherical_bessel_functions_of_orders_two_and_three_are_their_closed_forms() {
        for x in [0.5_f64, 1.0, 3.0, NEXT_TO_A_ZERO, 12.5, 300.0] {
            let (s, c) = x.sin_cos();
            let two = (3.0 / (x * x) - 1.0) * s / x - 3.0 * c / (x * x);
            let three = (15.0 / x.powi(3) - 6.0 / x) * s / x - (15.0 / (x * x) - 1.0) * c / x;
            for orders in [4, 40] {
                let mut j = vec![0.0; orders];
                spherical_bessel(x, &mut j);
                // The closed forms cancel for small x.
                let digits = 2e-16 * (1.0 + 15.0 / x.powi(4));
                assert!(
                    (j[2] - two).abs() < digits && (j[3] - three).abs() < digits,
                    "{x} {orders}: {j:?}"
                );
            }
        }
    }

    #[test]
    fn squares_of_spherical_bessel_functions_add_up_to_one() {
        // sum (2n + 1) j_n^2 = 1.
        for x in [0.0, 1e-9, 1e-3, 0.7, 6.3, 25.0, 80.0, 500.0] {
            let mut j = vec![0.0; 600];
            spherical_bessel(x, &mut j);
            let sum: f64 = j
                .iter()
                .enumerate()
                .map(|(n, j)| (2 * n + 1) as f64 * j * j)
                .sum();
            assert!((sum - 1.0).abs() < 1e-13, "{x}: {sum}");
        }
    }

    #[test]
    fn spherical_bessel_functions_of_small_arguments_follow_the_power_law() {
        // j_n -> x^n/(2n + 1)!!
        let (x, mut j) = (1e-3_f64, vec![0.0; 12]);
        spherical_bessel(x, &mut j);
        let mut expected = 1.0;
        for (n, j) in j.iter().enumerate() {
            expected *= if n == 0 { 1.0 } else { x / (2 * n + 1) as f64 };
            assert!(
                (j / expected - 1.0).abs() < 2e-7,
                "{n}: {j:e} for {expected:e}"
            );
        }
    }
}
