//! The ticks of an axis, on short and on long ranges, and a number with the digits that a distance
//! asks for.

use super::panel::Spread;
use super::scale::Scale;

/// Ticks wanted along an axis, at least and at most.
const TICKS: [usize; 2] = [3, 8];
/// Ticks wanted along a linear axis.
const WANTED: f64 = 6.0;

/// A tick.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    /// Where, as a share of the axis.
    pub at: f64,
    /// Its number; a minor tick has none. Set with `^` for powers.
    pub label: Option<String>,
}

/// The ticks of an axis, and the power of ten by which their numbers are to be multiplied.
pub fn ticks(scale: &Scale) -> (Vec<Tick>, i32) {
    match scale.spread {
        Spread::Linear => linear_ticks(scale),
        Spread::Logarithmic => (logarithmic_ticks(scale), 0),
        Spread::Signed => (signed_ticks(scale), 0),
    }
}

/// Zero, and powers of ten of either sign.
fn signed_ticks(scale: &Scale) -> Vec<Tick> {
    let powers = (-1..=4).map(|k| 10f64.powi(k));
    let below = powers.clone().rev().map(|power| -power);
    let all = below.chain([0.0]).chain(powers);
    let tick = |value: f64| {
        let at = scale.place(value).filter(|_| scale.shows(value))?;
        let label = Some(label(value, value.abs()));
        Some(Tick { at, label })
    };
    all.filter_map(tick).collect()
}

fn linear_ticks(scale: &Scale) -> (Vec<Tick>, i32) {
    let [low, high] = scale.told();
    let largest = low.abs().max(high.abs());
    let exponent = largest.log10().floor() as i32;
    let factor = if (-2..5).contains(&exponent) {
        0
    } else {
        exponent
    };
    let unit = 10f64.powi(factor);
    let step = spacing((high - low) / unit, WANTED);
    let marks = multiples(low / unit, high / unit, step);
    let at = |value: f64| (value * unit - low) / (high - low);
    (
        marks
            .map(|v| Tick {
                at: at(v),
                label: Some(label(v, step)),
            })
            .collect(),
        factor,
    )
}

fn logarithmic_ticks(scale: &Scale) -> Vec<Tick> {
    let [from, to] = scale.told();
    let at = |value: f64| (value.log10() - from) / (to - from);
    let inside = |value: &f64| (-1e-9..=1.0 + 1e-9).contains(&at(*value));
    let decades = from.floor() as i32..=to.ceil() as i32;
    let values = |mantissas: &[u8], stride: usize| -> Vec<f64> {
        let powers = decades.clone().filter(|k| k.rem_euclid(stride as i32) == 0);
        let all = powers.flat_map(|k| mantissas.iter().map(move |m| f64::from(*m) * 10f64.powi(k)));
        all.filter(inside).collect()
    };
    let span = to - from;
    let stride = ((span / TICKS[1] as f64).ceil() as usize).max(1);
    let full: [&[u8]; 4] = [&[1], &[1, 3], &[1, 2, 5], &[1, 2, 3, 4, 5, 6, 7, 8, 9]];
    let wanted = TICKS[0]..=TICKS[1] + 1;
    let labelled = full
        .iter()
        .map(|m| values(m, stride))
        .find(|list| wanted.contains(&list.len()));
    let minor: &[u8] = if span > 8.0 { &[1] } else { full[3] };
    let mut ticks: Vec<Tick> = Vec::new();
    match labelled {
        Some(labelled) => {
            let fine = values(minor, 1)
                .into_iter()
                .filter(|v| !labelled.iter().any(|l| (l / v - 1.0).abs() < 1e-9));
            ticks.extend(fine.map(|v| Tick {
                at: at(v),
                label: None,
            }));
            ticks.extend(labelled.iter().map(|v| Tick {
                at: at(*v),
                label: Some(power(*v)),
            }));
        }
        None => {
            // Much less than a decade: steps as on a linear axis.
            let (low, high) = (10f64.powf(from), 10f64.powf(to));
            let step = spacing(high - low, WANTED);
            let marks = multiples(low, high, step).filter(|v| *v > 0.0);
            ticks.extend(marks.map(|v| Tick {
                at: at(v),
                label: Some(label(v, step)),
            }));
        }
    }
    ticks
}

/// A distance between ticks of 1, 2 or 5 and a power of ten, such that about `count` fit into
/// `span`.
pub fn spacing(span: f64, count: f64) -> f64 {
    let raw = span / count;
    if !(raw.is_finite() && raw > 0.0) {
        return 1.0;
    }
    let unit = 10f64.powf(raw.log10().floor());
    [1.0, 2.0, 5.0]
        .into_iter()
        .map(|f| f * unit)
        .find(|s| *s >= raw * 0.999)
        .unwrap_or(10.0 * unit)
}

/// The ticks of an axis from `low` to `high`, about `count` of them, and their distance. Never
/// many, whatever the ends are.
pub fn within(low: f64, high: f64, count: f64) -> (Vec<f64>, f64) {
    let spacing = spacing(high - low, count);
    (multiples(low, high, spacing).collect(), spacing)
}

/// The words of a tick whose neighbours are `spacing` away, with a real minus sign.
pub fn label(value: f64, spacing: f64) -> String {
    digits(value, spacing).replace('-', "\u{2212}")
}

/// A number with the digits that tell it from another one `spacing` away, and no more.
pub fn digits(value: f64, spacing: f64) -> String {
    let power = |x: f64| (x.abs().log10() + 1e-9).floor();
    if !(value.is_finite() && spacing.is_finite() && spacing > 0.0) {
        return format!("{value}");
    }
    // A zero with the noise of a sum.
    let value = if value.abs() < 1e-6 * spacing {
        0.0
    } else {
        value
    };
    let decimals = -power(spacing);
    let signed = |text: String| {
        if text.contains(|c| ('1'..='9').contains(&c)) {
            text
        } else {
            text.replace('-', "")
        }
    };
    let plain = (decimals <= 6.0 || value.abs() >= 1e-3) && value.abs() < 1e7;
    if plain && decimals <= 17.0 {
        return signed(format!("{value:.*}", decimals.max(0.0) as usize));
    }
    let beyond = (power(value) + decimals).clamp(0.0, 17.0);
    if value == 0.0 {
        "0".to_owned()
    } else {
        format!("{value:.*e}", beyond as usize)
    }
}

fn multiples(low: f64, high: f64, step: f64) -> impl Iterator<Item = f64> {
    let (first, last) = (
        (low / step - 1e-9).ceil() as i64,
        (high / step + 1e-9).floor() as i64,
    );
    (first..=last.min(first.saturating_add(50))).map(move |i| i as f64 * step)
}

/// A small whole number times a power of ten, as one reads it.
fn power(value: f64) -> String {
    let exponent = (value.log10() + 1e-9).floor() as i32;
    let mantissa = (value / 10f64.powi(exponent)).round() as i32;
    match exponent {
        0..=3 => format!("{}", i64::from(mantissa) * 10i64.pow(exponent as u32)),
        -2..0 => format!("{value:.*}", (-exponent) as usize),
        _ => {
            let raised = label(f64::from(exponent), 1.0);
            if mantissa == 1 {
                format!("10^{{{raised}}}")
            } else {
                format!("{mantissa}·10^{{{raised}}}")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::panel::Axis;

    fn labels(axis: Axis) -> Vec<String> {
        let scale = Scale::new(&axis, std::iter::empty());
        let (mut list, factor) = ticks(&scale);
        list.sort_by(|a, b| a.at.total_cmp(&b.at));
        assert!(
            list.iter().all(|t| (-1e-6..=1.000001).contains(&t.at)),
            "{list:?}"
        );
        let mut labels: Vec<String> = list.into_iter().filter_map(|t| t.label).collect();
        if factor != 0 {
            labels.push(format!("factor {factor}"));
        }
        labels
    }

    fn log(low: f64, high: f64) -> Vec<String> {
        labels(Axis::logarithmic("").from_to(low, high))
    }

    fn linear(low: f64, high: f64) -> Vec<String> {
        labels(Axis::linear("").from_to(low, high))
    }

    #[test]
    fn a_logarithmic_axis_has_readable_ticks_on_short_and_on_long_ranges() {
        assert_eq!(log(1.0, 1000.0), ["1", "10", "100", "1000"]);
        assert_eq!(
            log(1e-6, 1.0),
            [
                "10^{\u{2212}6}",
                "10^{\u{2212}5}",
                "10^{\u{2212}4}",
                "10^{\u{2212}3}",
                "0.01",
                "0.1",
                "1"
            ]
        );
        assert_eq!(log(0.9, 11.0), ["1", "3", "10"]);
        assert_eq!(log(2.0, 25.0), ["2", "5", "10", "20"]);
        assert_eq!(log(3.0, 7.0), ["3", "4", "5", "6", "7"]);
        assert_eq!(log(1.0, 1.5), ["1.0", "1.1", "1.2", "1.3", "1.4", "1.5"]);
        assert_eq!(
            log(1e-9, 1e3),
            [
                "10^{\u{2212}8}",
                "10^{\u{2212}6}",
                "10^{\u{2212}4}",
                "0.01",
                "1",
                "100"
            ]
        );
    }

    #[test]
    fn a_signed_axis_has_zero_and_powers_of_ten_on_both_sides_in_their_places() {
        let axis = Axis::signed("").from_to(-0.4, 30.0);
        let scale = Scale::new(&axis, std::iter::empty());
        let place = |value: f64| scale.place(value).expect("a place");
        // Near zero as on a linear axis, far from it as on a logarithmic one.
        assert!((place(0.002) + place(-0.002) - 2.0 * place(0.0)).abs() < 1e-12);
        let decades = [place(30.0) - place(3.0), place(3.0) - place(0.3)];
        assert!((decades[0] / decades[1] - 1.0).abs() < 0.02, "{decades:?}");
        for value in [-0.3, 0.0, 0.05, 20.0] {
            let back = axis.spread.value(axis.spread.shown(value));
            assert!((back - value).abs() < 1e-12, "{back} {value}");
        }
        assert_eq!(labels(axis), ["\u{2212}0.1", "0", "0.1", "1", "10"]);
    }

    #[test]
    fn a_linear_axis_steps_by_one_two_or_five() {
        assert_eq!(
            linear(-1.0, 0.2),
            [
                "\u{2212}1.0",
                "\u{2212}0.8",
                "\u{2212}0.6",
                "\u{2212}0.4",
                "\u{2212}0.2",
                "0.0",
                "0.2"
            ]
        );
        assert_eq!(linear(0.0, 4.2), ["0", "1", "2", "3", "4"]);
        assert_eq!(
            linear(0.0, 2e-4),
            ["0.0", "0.5", "1.0", "1.5", "2.0", "factor -4"]
        );
        assert_eq!(
            linear(0.0, 3e6),
            ["0.0", "0.5", "1.0", "1.5", "2.0", "2.5", "3.0", "factor 6"]
        );
    }

    #[test]
    fn a_number_has_the_digits_of_its_neighbours_distance() {
        let cases = [
            (3.41999, 2e-4),
            (3.4e-9, 2e-13),
            (0.0, 2e-13),
            (-0.0, 0.1),
            (1e-17, 0.1),
            (3.0000005, 5e-7),
            (3.4e12, 2e8),
        ];
        let words = cases.map(|(value, spacing)| digits(value, spacing));
        assert_eq!(
            words,
            [
                "3.4200",
                "3.4000e-9",
                "0",
                "0.0",
                "0.0",
                "3.0000005",
                "3.4000e12"
            ]
        );
        assert_eq!(
            [
                label(-2.0, 1.0),
                label(-0.5, 0.1),
                digits(f64::NAN, 1.0),
                digits(-1e-5, 1e-3)
            ],
            ["\u{2212}2", "\u{2212}0.5", "NaN", "0.000"]
        );
    }

    proptest::proptest! {
        #[test]
        fn neighbouring_ticks_never_have_the_same_words(
            at in -1e3..1e3f64,
            size in -9..9i32,
            narrow in 0.0..9.0f64,
            count in 2.0..12.0f64,
        ) {
            let unit = 10f64.powi(size);
            let (middle, span) = (at * unit, unit * 10f64.powf(3.0 - narrow));
            let step = spacing(span, count);
            proptest::prop_assert!(step >= 0.99 * span / count && step <= 2.51 * span / count);
            let first = (middle / step).ceil();
            let mut words: Vec<String> = (0..count as i32)
                .map(|i| label((first + f64::from(i)) * step, step))
                .collect();
            let all = words.len();
            words.dedup();
            proptest::prop_assert!(words.len() == all, "{words:?}");
        }
    }

    #[test]
    fn every_range_has_some_ticks_and_not_too_many() {
        for k in 0..200 {
            let (low, high) = (
                10f64.powf(-5.0 + 0.03 * f64::from(k)),
                10f64.powf(-4.97 + 0.075 * f64::from(k)),
            );
            for labels in [log(low, high), linear(low, high)] {
                assert!(
                    (2..=10).contains(&labels.len()),
                    "{low} to {high}: {labels:?}"
                );
            }
        }
    }

    #[test]
    fn nothing_a_point_and_broken_numbers_still_make_an_axis() {
        for data in [
            vec![],
            vec![3.0],
            vec![0.0, 0.0],
            vec![f64::NAN, f64::INFINITY],
            vec![-1.0],
        ] {
            for axis in [Axis::linear(""), Axis::logarithmic("")] {
                let scale = Scale::new(&axis, data.iter().copied());
                assert!(
                    scale.low < scale.high && !ticks(&scale).0.is_empty(),
                    "{data:?} {scale:?}"
                );
            }
        }
    }

    #[test]
    fn the_number_of_a_tick_is_its_value_in_the_unit_of_the_axis() {
        let read = |text: &str| text.replace('\u{2212}', "-").parse::<f64>().unwrap();
        for unit in [0.02, 1.0, 100.0, 4.9e6] {
            let axis = Axis {
                unit,
                ..Axis::linear("").from_to(-0.4, 4.3)
            };
            let scale = Scale::new(&axis, std::iter::empty());
            let (list, factor) = ticks(&scale);
            assert!(list.len() > 2);
            for tick in list {
                let value = scale.low + tick.at * (scale.high - scale.low);
                let told = read(&tick.label.unwrap()) * 10f64.powi(factor);
                assert!((told - value * unit).abs() < 1e-9 * unit, "{told} {value}");
            }
            let axis = Axis {
                unit,
                ..Axis::logarithmic("").from_to(1e-3, 7.0)
            };
            let scale = Scale::new(&axis, std::iter::empty());
            let first = ticks(&scale)
                .0
                .into_iter()
                .find(|tick| tick.label.is_some());
            let at = scale.low + first.unwrap().at * (scale.high - scale.low);
            // The first number is a power of ten in the unit.
            let power = at + unit.log10();
            assert!((power - power.round()).abs() < 1e-9, "{power}");
        }
    }

    #[test]
    fn ticks_are_few_whatever_the_ends_are() {
        assert_eq!(
            within(0.2, 1.0, 4.0),
            (vec![0.2, 0.4, 0.6000000000000001, 0.8, 1.0], 0.2)
        );
        for (low, high) in [
            (1e17 - 16.0, 1e17),
            (-1e220, 1e220),
            (1.0, 1.0),
            (0.0, f64::INFINITY),
            (f64::NAN, 1.0),
            (3.0, 2.0),
        ] {
            assert!(within(low, high, 9.0).0.len() <= 60, "{low} {high}");
        }
    }
}
