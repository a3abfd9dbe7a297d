//! Numbers and names as the chart writes them.

/// a, b, c, ...
pub(super) fn name(letter: usize) -> String {
    char::from_u32('a' as u32 + letter.min(25) as u32).unwrap_or('z').to_string()
}

/// A failure short enough for the legend.
pub(super) fn short(what: &str) -> String {
    if what.chars().count() <= 52 { what.to_owned() } else { what.chars().take(50).chain("...".chars()).collect() }
}

/// Least and largest of what can be shown on a logarithmic axis; a decade where there is nothing.
pub(super) fn bounds(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let shown = values.filter(|v| v.is_finite() && *v > 0.0);
    let (least, most) = shown.fold((f64::INFINITY, 0.0_f64), |(a, b), v| (a.min(v), b.max(v)));
    if most > 0.0 { (least, most) } else { (1.0, 10.0) }
}

/// A number with five digits, or that there is none.
pub(super) fn number(value: f64) -> String {
    if value.is_finite() { format!("{value:.5}") } else { "(not available)".to_owned() }
}

/// Powers of ten as such, other numbers as they are.
pub(super) fn power(value: f64) -> String {
    let exponent = value.log10().round();
    if (value / 10f64.powf(exponent) - 1.0).abs() > 1e-6 || (-1.0..=2.0).contains(&exponent) {
        return format!("{value}");
    }
    let digits = (exponent as i32).to_string();
    let raised = digits.chars().map(|c| match c {
        '-' => '\u{207b}',
        '1' => '\u{b9}',
        '2' => '\u{b2}',
        '3' => '\u{b3}',
        digit => char::from_u32(0x2070 + digit.to_digit(10).unwrap_or(0)).unwrap_or(digit),
    });
    std::iter::once('1').chain(['0']).chain(raised).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_ten_are_raised_and_other_numbers_are_left() {
        assert_eq!(
            [1e-5, 1e4, 1e-12, 0.1, 100.0].map(power),
            ["10\u{207b}\u{2075}", "10\u{2074}", "10\u{207b}\u{b9}\u{b2}", "0.1", "100"]
        );
    }

    #[test]
    fn an_axis_of_nothing_is_a_decade() {
        assert_eq!(bounds([f64::NAN, 0.0, -1.0].into_iter()), (1.0, 10.0));
        assert_eq!(bounds([3.0, f64::INFINITY, 0.5].into_iter()), (0.5, 3.0));
    }
}
