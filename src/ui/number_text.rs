//! Numbers as people type them.

/// The finite number that a text means: with a point or a comma before its decimals, blanks between its digits, and either minus.
///
/// One comma alone is a decimal comma; with more, or beside a point, nobody can tell, and it is no number.
pub fn parse(text: &str) -> Option<f64> {
    let plain: String = text.chars().filter(|c| !c.is_whitespace()).map(|c| if c == '−' { '-' } else { c }).collect();
    let plain = if plain.matches(',').count() == 1 && !plain.contains('.') { plain.replace(',', ".") } else { plain };
    plain.parse().ok().filter(|number: &f64| number.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_decimal_comma_is_a_decimal_point() {
        assert_eq!(parse("0,15"), Some(0.15));
        assert_eq!(parse(" −1,5e−3 "), Some(-1.5e-3));
        assert_eq!(parse("1 000,5"), Some(1000.5));
        for unclear in ["1,000,000", "1,000.5", "", ",", "nan", "inf", "1e999", "three"] {
            assert_eq!(parse(unclear), None, "{unclear}");
        }
    }

    proptest! {
        #[test]
        fn a_number_is_read_as_it_was_written_with_either_sign_of_decimals(x in any::<f64>().prop_filter("finite", |x| x.is_finite())) {
            for text in [format!("{x}"), format!("{x:e}")] {
                prop_assert_eq!(parse(&text), Some(x));
                prop_assert_eq!(parse(&text.replace('.', ",")), Some(x));
            }
        }
    }
}
