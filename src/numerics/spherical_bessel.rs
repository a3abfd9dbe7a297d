//! Spherical Bessel functions of the first kind, many orders at once.

/// Fills `out` with j_0(x), j_1(x), ... for x >= 0.
///
/// Upwards from j_0 and j_1 while orders stay below x, where that loses nothing; else downwards (J.
/// C. P. Miller) from an order so high that what it leaves out is below rounding.
pub fn fill(x: f64, out: &mut [f64]) {
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

    /// Of j_0.
    const NEXT_TO_A_ZERO: f64 = 0.999_999 * std::f64::consts::PI;

    #[test]
    fn orders_two_and_three_are_their_closed_forms() {
        for x in [0.5_f64, 1.0, 3.0, NEXT_TO_A_ZERO, 12.5, 300.0] {
            let (s, c) = x.sin_cos();
            let two = (3.0 / (x * x) - 1.0) * s / x - 3.0 * c / (x * x);
            let three = (15.0 / x.powi(3) - 6.0 / x) * s / x - (15.0 / (x * x) - 1.0) * c / x;
            for orders in [4, 40] {
                let mut j = vec![0.0; orders];
                fill(x, &mut j);
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
    fn the_squares_add_up_to_one() {
        // sum (2n + 1) j_n^2 = 1.
        for x in [0.0, 1e-9, 1e-3, 0.7, 6.3, 25.0, 80.0, 500.0] {
            let mut j = vec![0.0; 600];
            fill(x, &mut j);
            let sum: f64 = j
                .iter()
                .enumerate()
                .map(|(n, j)| (2 * n + 1) as f64 * j * j)
                .sum();
            assert!((sum - 1.0).abs() < 1e-13, "{x}: {sum}");
        }
    }

    #[test]
    fn small_arguments_follow_the_power_law() {
        // j_n -> x^n/(2n + 1)!!
        let (x, mut j) = (1e-3_f64, vec![0.0; 12]);
        fill(x, &mut j);
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
