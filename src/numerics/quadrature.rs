//! The integral of a smooth function known at points.

/// Neighbouring intervals may differ by this factor before a slope over both is worth less than none.
const RATIO_MAX: f64 = 50.0;

/// Integral of y dx along `points` (x, y) with x rising or falling throughout.
///
/// The trapezoid corrected by the slopes at the ends of each interval (the Hermite cubic), those from parabolas through three points:
/// the error falls with the fourth power of the interval where the trapezoid's falls with the second. Where intervals of very different
/// lengths meet it is the trapezoid.
pub fn integral(points: &[[f64; 2]]) -> f64 {
    let rise = |i: usize| (points[i + 1][1] - points[i][1]) / (points[i + 1][0] - points[i][0]);
    let width = |i: usize| points[i + 1][0] - points[i][0];
    // At an inner point; `None` at the ends and where noise would be blown up.
    let slope = |i: usize| {
        if i == 0 || i + 1 == points.len() {
            return None;
        }
        let (before, after) = (width(i - 1), width(i));
        let ratio = before / after;
        let fair = ratio < RATIO_MAX && ratio > 1.0 / RATIO_MAX;
        fair.then(|| (rise(i - 1) * after + rise(i) * before) / (before + after))
    };
    (1..points.len())
        .map(|i| {
            let (h, mean) = (width(i - 1), 0.5 * (points[i - 1][1] + points[i][1]));
            // Of a parabola the chord has the mean of the slopes at the ends.
            let bend = match (slope(i - 1), slope(i)) {
                (Some(a), Some(b)) => b - a,
                (Some(a), None) => 2.0 * (rise(i - 1) - a),
                (None, Some(b)) => 2.0 * (b - rise(i - 1)),
                (None, None) => 0.0,
            };
            h * (mean - h * bend / 12.0)
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(n: usize, x: impl Fn(f64) -> f64, y: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
        (0..=n).map(|i| x(i as f64 / n as f64)).map(|x| [x, y(x)]).collect()
    }

    #[test]
    fn parabolas_are_integrated_exactly_on_any_points_in_either_direction() {
        let parabola = |x: f64| 1.0 - 2.0 * x + 3.0 * x * x;
        let up = points(9, |t| 2.0 * t * t, parabola);
        let down: Vec<_> = up.iter().rev().copied().collect();
        // x - x^2 + x^3 from 0 to 2; rounding only.
        assert!((integral(&up) - 6.0).abs() < 1e-14 && (integral(&down) + 6.0).abs() < 1e-14);
    }

    #[test]
    fn the_error_falls_with_the_fourth_power_of_the_interval() {
        let error = |n| integral(&points(n, |t| 3.0 * t, f64::exp)) - (3f64.exp() - 1.0);
        let order = (error(40) / error(80)).log2();
        assert!((order - 4.0).abs() < 0.3, "{order}");
    }

    #[test]
    fn few_or_uneven_points_leave_the_trapezoid() {
        assert_eq!(integral(&[]), 0.0);
        assert_eq!(integral(&[[1.0, 5.0]]), 0.0);
        assert_eq!(integral(&[[0.0, 1.0], [2.0, 3.0]]), 4.0);
        let noisy = [[0.0, 1.0], [1e-6, 1.0 + 1e-7], [1.0, 1.0]];
        assert!((integral(&noisy) - 1.0).abs() < 1e-6);
    }
}
