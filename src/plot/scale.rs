//! What an axis shows, and where a value stands on it: the same on paper and in the window. It
//! shows its data; or, of a scene, what is fixed before anything is computed (u0, gap and stress),
//! so that axes and colours keep their meaning while u0 moves.

use super::panel::{Axis, Panel, Spread};
use crate::physics::indenter::Indenter;
use crate::scene::window;
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
                let alone = match axis.spread {
                    Spread::Linear => 0.5 * size.max(1e-3),
                    Spread::Logarithmic | Spread::Signed => 0.5,
                };
                let room = if span > 1e-9 * size {
                    MARGIN * span
                } else {
                    alone
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
        let at_turn = law.at(window::of_u0(scene, model)[0]).traction / law.traction_max();
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
}
