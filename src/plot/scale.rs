//! What an axis shows, where a value stands on it, and the ticks that it bears, on short and on long
//! ranges: the same on paper and in the window. It shows its data; or, of a scene, what is fixed
//! before anything is computed (u0, gap and stress), so that axes and colours keep their meaning
//! while u0 moves. And a number with the digits that a distance asks for.

use super::panel::{Axis, Panel, Spread};
use crate::physics::indenter::Indenter;
use crate::scene::parameter::unsigned_zero;
use crate::scene::{Model, Scene};

/// The least and the largest of some numbers; infinite, the wrong way round, if there are none.
pub fn ends(numbers: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    let both = |(low, high): (f64, f64), x: f64| (low.min(x), high.max(x));
    numbers.into_iter().fold(none, both)
}

/// From one number to another in so many equal steps, both included.
pub fn steps(from: f64, to: f64, count: usize) -> impl Iterator<Item = f64> {
    (0..=count).map(move |i| from + (to - from) * i as f64 / count as f64)
}

/// Share of the range that is left free at both ends where the data decide.
const MARGIN: f64 = 0.04;

/// The scale of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// How its values are spread.
    pub spread: Spread,
    /// Lower end, as it is shown: a logarithm (base 10) where it is logarithmic.
    pub low: f64,
    /// Upper end, likewise.
    pub high: f64,
    /// [`Axis::unit`].
    pub unit: f64,
}

impl Scale {
    /// The scale of an axis over these data.
    pub fn new(axis: &Axis, data: impl Iterator<Item = f64>) -> Self {
        let shown = |v: f64| axis.spread.shown(v);
        let given = axis
            .range
            .map(|[low, high]| (shown(low.min(high)), shown(low.max(high))));
        let (low, high) = match given {
            Some((low, high)) if low.is_finite() && high.is_finite() && high > low => (low, high),
            _ => {
                let (low, high) = ends(data.map(shown).filter(|v| v.is_finite()));
                let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
                let span = high - low;
                let size = low.abs().max(high.abs());
                let room = if span > 1e-9 * size {
                    MARGIN * span
                } else if axis.spread == Spread::Linear {
                    0.5 * size.max(1e-3)
                } else {
                    0.5
                };
                (low - room, high + room)
            }
        };
        Self {
            spread: axis.spread,
            low,
            high,
            unit: axis.unit,
        }
    }

    /// Both ends as they are told, logarithms where it is logarithmic.
    pub fn told(&self) -> [f64; 2] {
        [self.low, self.high].map(|end| {
            if self.spread == Spread::Logarithmic {
                end + self.unit.log10()
            } else {
                end * self.unit
            }
        })
    }

    /// Where a value stands, 0 to 1 within the axis; `None` if it has no place on it.
    pub fn place(&self, value: f64) -> Option<f64> {
        let share = (self.spread.shown(value) - self.low) / (self.high - self.low);
        // What is far away is as good as at the edge, and drawers count in small numbers.
        share.is_finite().then(|| share.clamp(-1e4, 1e4))
    }

    /// Whether a value lies on the axis.
    pub fn shows(&self, value: f64) -> bool {
        self.place(value)
            .is_some_and(|share| (-1e-9..=1.0 + 1e-9).contains(&share))
    }

    /// Where zero stands if it is inside an axis that shows it.
    pub fn zero(&self) -> Option<f64> {
        (self.spread != Spread::Logarithmic && self.low < 0.0 && self.high > 0.0)
            .then(|| -self.low / (self.high - self.low))
    }
}

/// Both scales of a diagram; where one axis is given, only what it shows counts for the other.
pub fn scales(panel: &Panel) -> [Scale; 2] {
    let given = panel
        .y
        .range
        .map(|_| Scale::new(&panel.y, std::iter::empty()));
    let seen = |p: &[f64; 2]| given.is_none_or(|y| y.shows(p[1]));
    let x = Scale::new(&panel.x, data(panel).filter(seen).map(|p| p[0]));
    let y = Scale::new(
        &panel.y,
        data(panel).filter(|p| x.shows(p[0])).map(|p| p[1]),
    );
    [x, y]
}

/// Every place that must be seen.
fn data(panel: &Panel) -> impl Iterator<Item = [f64; 2]> + '_ {
    let points = panel.series.iter().flat_map(|s| s.points.iter().copied());
    let areas = panel.areas.iter().flat_map(|a| {
        a.spans
            .iter()
            .flat_map(|span| [a.edge(span, 1), a.edge(span, 2)])
    });
    let arrows = panel.arrows.iter().flat_map(|a| [a.tail, a.head]);
    points
        .chain(areas)
        .chain(arrows)
        .chain(panel.labels.iter().map(|label| label.at))
}

/// The largest gap of the colour scale: fixed by the scene, so that colours keep their meaning
/// while u0 moves.
pub fn gap_scale(scene: &Scene, model: &Model) -> f64 {
    let rho = model.law.range;
    let wanted = match model.indenter {
        Indenter::Flat if scene.control().frees_mean() => 8.0 * rho,
        Indenter::Flat => 1.8 * scene.drive.start,
        _ => (2.5 * model.indenter.ground().relief(&model.law)).max(6.0 * rho),
    };
    nice(wanted / rho) * rho
}

/// Lower and upper end of the stress axis, in units of sigma_max.
pub fn stress_scale(scene: &Scene, model: &Model) -> (f64, f64) {
    let law = &model.law;
    if model.indenter == Indenter::Flat {
        let at_turn = law.at(scene.window_of_u0(model)[0]).traction / law.traction_max();
        return (at_turn.clamp(-1.5, 0.0) - 0.06, 1.08);
    }
    // Between full contact and a few asperities nothing is known beforehand.
    let Some(pull_off) = model.indenter.ground().pull_off(law, &model.grid) else {
        return (-0.6, 0.6);
    };
    let top = (1.5 * pull_off / law.traction_max()).min(1.08);
    (-0.5 * top, top)
}

/// The next of 1, 1.5, 2, 3, 4, 5, 6, 8, 10, ... at or above `x`.
pub fn nice(x: f64) -> f64 {
    let decade = 10f64.powf(x.max(1e-12).log10().floor());
    let steps = [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0];
    steps
        .into_iter()
        .map(|s| s * decade)
        .find(|&s| s >= x * (1.0 - 1e-9))
        .unwrap_or(10.0 * decade)
}

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
    let exponent = low.abs().max(high.abs()).log10().floor() as i32;
    let usual = (-2..5).contains(&exponent);
    let factor = if usual { 0 } else { exponent };
    let unit = 10f64.powi(factor);
    let (marks, step) = within(low / unit, high / unit, WANTED);
    let tick = |value: f64| Tick {
        at: (value * unit - low) / (high - low),
        label: Some(label(value, step)),
    };
    (marks.into_iter().map(tick).collect(), factor)
}

fn logarithmic_ticks(scale: &Scale) -> Vec<Tick> {
    let [from, to] = scale.told();
    let at = |value: f64| (value.log10() - from) / (to - from);
    let tick = |value: f64, label| Tick {
        at: at(value),
        label,
    };
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
    let mut labelled = full.iter().map(|m| values(m, stride));
    let Some(labelled) = labelled.find(|list| wanted.contains(&list.len())) else {
        // Much less than a decade: steps as on a linear axis.
        let (marks, step) = within(10f64.powf(from), 10f64.powf(to), WANTED);
        let marks = marks.into_iter().filter(|v| *v > 0.0);
        return marks.map(|v| tick(v, Some(label(v, step)))).collect();
    };
    let minor: &[u8] = if span > 8.0 { &[1] } else { full[3] };
    let is_labelled = |v: &f64| labelled.iter().any(|l| (l / v - 1.0).abs() < 1e-9);
    let fine = values(minor, 1).into_iter().filter(|v| !is_labelled(v));
    let numbered = labelled.iter().map(|v| tick(*v, Some(power(*v))));
    fine.map(|v| tick(v, None)).chain(numbered).collect()
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
    let first = (low / spacing - 1e-9).ceil() as i64;
    let last = (high / spacing + 1e-9).floor() as i64;
    let marks = first..=last.min(first.saturating_add(50));
    (marks.map(|i| i as f64 * spacing).collect(), spacing)
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
    let plain = (decimals <= 6.0 || value.abs() >= 1e-3) && value.abs() < 1e7;
    if plain && decimals <= 17.0 {
        return unsigned_zero(format!("{value:.*}", decimals.max(0.0) as usize));
    }
    let beyond = (power(value) + decimals).clamp(0.0, 17.0);
    if value == 0.0 {
        "0".to_owned()
    } else {
        format!("{value:.*e}", beyond as usize)
    }
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
            let factor = if mantissa == 1 {
                String::new()
            } else {
                format!("{mantissa}·")
            };
            format!("{factor}10^{{{raised}}}")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::indenter::Hertz;
    use crate::plot::panel::Series;
    use crate::scene::tests::fig2;
    use crate::scene::{Drive, Range, Turn};

    #[test]
    fn an_axis_shows_its_data_with_some_room_or_what_it_is_told_to() {
        let scale = Scale::new(&Axis::linear(""), [1.0, f64::NAN, 3.0].into_iter());
        assert_eq!((scale.low, scale.high), (1.0 - 0.08, 3.0 + 0.08));
        let scale = Scale::new(
            &Axis::logarithmic("").from_to(1.0, 100.0),
            [1e-9].into_iter(),
        );
        assert_eq!(
            (scale.low, scale.high, scale.place(10.0)),
            (0.0, 2.0, Some(0.5))
        );
        assert!(
            !scale.shows(0.0) && !scale.shows(-1.0) && !scale.shows(101.0) && scale.shows(100.0)
        );
    }

    #[test]
    fn what_lies_outside_a_given_axis_does_not_stretch_the_other() {
        let points = vec![[1.0, 1.0], [2.0, 2.0], [50.0, 900.0]];
        let series = vec![Series {
            points,
            ..Series::default()
        }];
        let panel = Panel {
            x: Axis::linear("").from_to(0.0, 3.0),
            series,
            ..Panel::default()
        };
        assert!(scales(&panel)[1].high < 3.0);
    }

    #[test]
    fn the_relief_of_a_tip_is_that_of_jkr_in_any_unit_of_length() {
        let tip = |unit: f64| {
            let mut scene = fig2(64);
            scene.cell.length *= unit;
            scene.law.surface_energy *= unit;
            scene.law.range = Range::Length(unit);
            scene.indenter = Indenter::Hertz(Hertz {
                radius: 30.0 * unit,
            });
            scene.drive = Drive {
                control: Default::default(),
                start: 6.0 * unit,
                turn: Turn::ZeroLoad,
                step: 0.1 * unit,
            };
            let model = scene.model().unwrap();
            (
                model.indenter.ground().relief(&model.law) / unit,
                gap_scale(&scene, &model) / unit,
                stress_scale(&scene, &model),
            )
        };
        let a = (4.5 * std::f64::consts::PI * 0.15 * 900.0_f64).cbrt();
        let (relief, gap, stress) = tip(1.0);
        assert!((relief - a * a / 30.0).abs() < 1e-12 * relief);
        for unit in [1e-100, 1e100] {
            let (other, other_gap, other_stress) = tip(unit);
            assert!(
                (other / relief - 1.0).abs() < 1e-9 && (other_gap / gap - 1.0).abs() < 1e-9,
                "{unit}: {other}, {other_gap}"
            );
            assert!(
                (other_stress.1 / stress.1 - 1.0).abs() < 1e-9,
                "{unit}: {other_stress:?}"
            );
        }
    }

    #[test]
    fn nice_numbers_are_at_or_above_what_they_round() {
        assert_eq!(
            [nice(7.56), nice(1.0), nice(0.14), nice(99.0)],
            [8.0, 1.0, 0.15000000000000002, 100.0]
        );
    }

    /// The numbers of an axis in their order, with plain minus signs, and its factor.
    fn labels(axis: Axis) -> Vec<String> {
        let scale = Scale::new(&axis, std::iter::empty());
        let (mut list, factor) = ticks(&scale);
        list.sort_by(|a, b| a.at.total_cmp(&b.at));
        assert!(
            list.iter().all(|t| (-1e-6..=1.000001).contains(&t.at)),
            "{list:?}"
        );
        let labels = list.into_iter().filter_map(|t| t.label);
        let factor = (factor != 0).then(|| format!("factor {factor}"));
        let plain = |label: String| label.replace('\u{2212}', "-");
        labels.chain(factor).map(plain).collect()
    }

    fn log(low: f64, high: f64) -> Vec<String> {
        labels(Axis::logarithmic("").from_to(low, high))
    }

    fn linear(low: f64, high: f64) -> Vec<String> {
        labels(Axis::linear("").from_to(low, high))
    }

    #[test]
    fn a_logarithmic_axis_has_readable_ticks_on_short_and_on_long_ranges() {
        for (low, high, wanted) in [
            (1.0, 1000.0, "1 10 100 1000"),
            (1e-6, 1.0, "10^{-6} 10^{-5} 10^{-4} 10^{-3} 0.01 0.1 1"),
            (0.9, 11.0, "1 3 10"),
            (2.0, 25.0, "2 5 10 20"),
            (3.0, 7.0, "3 4 5 6 7"),
            (1.0, 1.5, "1.0 1.1 1.2 1.3 1.4 1.5"),
            (1e-9, 1e3, "10^{-8} 10^{-6} 10^{-4} 0.01 1 100"),
        ] {
            assert_eq!(log(low, high).join(" "), wanted);
        }
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
        assert_eq!(labels(axis), ["-0.1", "0", "0.1", "1", "10"]);
    }

    #[test]
    fn a_linear_axis_steps_by_one_two_or_five() {
        for (low, high, wanted) in [
            (-1.0, 0.2, "-1.0 -0.8 -0.6 -0.4 -0.2 0.0 0.2"),
            (0.0, 4.2, "0 1 2 3 4"),
            (0.0, 2e-4, "0.0 0.5 1.0 1.5 2.0 factor -4"),
            (0.0, 3e6, "0.0 0.5 1.0 1.5 2.0 2.5 3.0 factor 6"),
        ] {
            assert_eq!(linear(low, high).join(" "), wanted);
        }
    }

    #[test]
    fn a_number_has_the_digits_of_its_neighbours_distance() {
        for (value, spacing, wanted) in [
            (3.41999, 2e-4, "3.4200"),
            (3.4e-9, 2e-13, "3.4000e-9"),
            (0.0, 2e-13, "0"),
            (-0.0, 0.1, "0.0"),
            (1e-17, 0.1, "0.0"),
            (3.0000005, 5e-7, "3.0000005"),
            (3.4e12, 2e8, "3.4000e12"),
            (f64::NAN, 1.0, "NaN"),
            (-1e-5, 1e-3, "0.000"),
        ] {
            assert_eq!(digits(value, spacing), wanted);
        }
        assert_eq!(
            [label(-2.0, 1.0), label(-0.5, 0.1)],
            ["\u{2212}2", "\u{2212}0.5"]
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
        let broken = [f64::NAN, f64::INFINITY];
        for data in [&[][..], &[3.0], &[0.0, 0.0], &broken, &[-1.0]] {
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
        // Every numbered tick: its number, and its place as it is shown.
        let numbered = |axis: Axis| {
            let scale = Scale::new(&axis, std::iter::empty());
            let (list, factor) = ticks(&scale);
            let shown = |tick: Tick| {
                let at = scale.low + tick.at * (scale.high - scale.low);
                Some((tick.label?, at))
            };
            (
                list.into_iter().filter_map(shown).collect::<Vec<_>>(),
                factor,
            )
        };
        for unit in [0.02, 1.0, 100.0, 4.9e6] {
            let of = |axis: Axis| Axis { unit, ..axis };
            let (list, factor) = numbered(of(Axis::linear("").from_to(-0.4, 4.3)));
            assert!(list.len() > 2);
            for (number, value) in list {
                let told = read(&number) * 10f64.powi(factor);
                assert!((told - value * unit).abs() < 1e-9 * unit, "{told} {value}");
            }
            let (list, _) = numbered(of(Axis::logarithmic("").from_to(1e-3, 7.0)));
            // The first number is a power of ten in the unit.
            let power = list[0].1 + unit.log10();
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
