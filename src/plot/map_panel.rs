//! The map of patterns: which pattern stands where on the way down and on the way up, x = u0/rho
//! and y a parameter of the scene; and beside it what the loop loses.

use super::loop_panel::place;
use super::panel::{Along, Area, Axis, Colour, Label, Page, Panel, Role, Series};
use super::scale::ends;
use crate::follow::record::Direction;
use crate::physics::parameter::Parameter;
use crate::physics::pattern::Pattern;
use crate::scene::units::Units;
use crate::scene::{Scene, parameter};
use crate::study::map::{Found, PatternMap, Row};

/// Regions narrower than this share of the axis bear no name, which would not fit.
const NAMED: f64 = 0.06;

impl Colour {
    /// The colour of what is shown of a pattern.
    pub fn of_pattern(pattern: Pattern) -> Self {
        match pattern {
            Pattern::Flat => Self::FLAT,
            Pattern::Bulge => Self::Purple,
            Pattern::Ridge => Self::Green,
            Pattern::Dimple => Self::Red,
            Pattern::Contact => Self::Teal,
            Pattern::Other => Self::Ink,
        }
    }
}

/// The picture of a map of the `scene`.
pub fn page(map: &PatternMap, scene: &Scene) -> Page<'static> {
    let known = map.rows.iter().filter(|row| row.found.is_ok()).count();
    let mut caption = vec![format!(
        "{known} loops, {} from {} to {}.",
        map.vary.key, map.vary.from, map.vary.to
    )];
    let missing = map.rows.len() - known;
    if let Some((value, why)) = map.missing().next() {
        caption.push(format!(
            "Not known of {missing}, first at {value:.6}: {why}."
        ));
    }
    if map.cancelled {
        caption.push("Stopped before all was found.".to_owned());
    }
    Page::new(&scene.title, caption, map_panels(map, scene.units).to_vec())
}

/// Approach, retraction, and the loss; what goes is told in its unit, where the scene has units.
pub fn map_panels(map: &PatternMap, units: Option<Units>) -> [Panel; 3] {
    let parameter = parameter::find(&map.vary.key);
    let mut label = parameter.map_or_else(|| map.vary.key.clone(), Parameter::title);
    if let (Some(units), Some(parameter)) = (units, parameter) {
        let word = units.word(parameter.unit);
        label.push_str(&if word.is_empty() {
            word
        } else {
            format!(" ({word})")
        });
    }
    let (low, high) = (
        map.vary.from.min(map.vary.to),
        map.vary.from.max(map.vary.to),
    );
    let y = Axis {
        logarithmic: map.vary.is_geometric(),
        ..Axis::linear(&label).from_to(low, high)
    };
    let reach = map.rows.iter().flat_map(|row| {
        let legs = row.found.iter().flat_map(|found| found.legs.clone());
        let rho = row.law.map_or(f64::NAN, |law| law.range);
        // What is beyond every jump is flat, and bears no interest.
        legs.filter(|leg| leg.pattern != Pattern::Flat)
            .flat_map(move |leg| leg.ends().map(|u0| u0 / rho))
    });
    let (left, right) = ends(reach);
    let room = 0.15 * (right - left).max(1.0);
    let of = |direction: Direction| {
        let areas = regions(map, direction);
        let labels = names(&areas, right - left);
        Panel {
            title: direction.to_string(),
            x: Axis::linear("mean displacement u_0/rho").from_to(left - room, right + room),
            y: y.clone(),
            areas,
            labels,
            ..Panel::default()
        }
    };
    let lost = map.rows.iter().map(|row| match &row.found {
        Ok(found) => [found.dissipated_energy, row.value],
        Err(_) => [f64::NAN; 2],
    });
    let loss = Panel {
        title: "loss".to_owned(),
        x: Axis::linear("dissipated energy / gamma"),
        y: y.clone(),
        series: vec![Series::line(
            "",
            Role::Simulation,
            Colour::Ink,
            lost.collect(),
        )],
        ..Panel::default()
    };
    [of(Direction::Approach), of(Direction::Retraction), loss]
}

/// The loop of a row as one line, broken at its jumps, under this name: u0/rho and
/// stress/sigma_max, by its own law.
pub fn loop_of(row: &Row, name: &str) -> Option<Series> {
    let (Ok(Found { legs, .. }), Some(law)) = (&row.found, row.law) else {
        return None;
    };
    let place = |[u0, stress]: &[f64; 2]| place(*u0, *stress, &law);
    let points = legs.iter().flat_map(|leg| {
        let points = leg.points.iter().map(place);
        points.chain([[f64::NAN; 2]])
    });
    Some(Series::line(
        name,
        Role::Forecast,
        Colour::Ink,
        points.collect(),
    ))
}

/// u0/rho between which the piece `number` of a pattern stands in a row.
fn stretch(row: &Row, direction: Direction, pattern: Pattern, number: usize) -> Option<[f64; 2]> {
    let (Ok(Found { legs, .. }), Some(law)) = (&row.found, row.law) else {
        return None;
    };
    let mut of = legs
        .iter()
        .filter(|leg| (leg.direction, leg.pattern) == (direction, pattern));
    let [a, b] = of.nth(number)?.ends().map(|u0| u0 / law.range);
    Some([a.min(b), a.max(b)])
}

/// One area for each pattern, as often as it is passed on one way.
fn regions(map: &PatternMap, direction: Direction) -> Vec<Area> {
    let mut areas = Vec::new();
    for pattern in Pattern::ALL {
        for number in 0.. {
            let at = |i: usize| {
                let row = map.rows.get(i)?;
                Some((row.value, stretch(row, direction, pattern, number)?))
            };
            let mut spans = Vec::new();
            for i in 0..map.rows.len() {
                let Some((value, [low, high])) = at(i) else {
                    continue;
                };
                // Half the way to a row where it is not.
                let half = |j: usize| match (map.rows.get(j), at(j)) {
                    (Some(row), None) => Some(0.5 * (row.value + value)),
                    _ => None,
                };
                let before = i.checked_sub(1).and_then(half);
                spans.extend(before.map(|value| [value, low, high]));
                spans.push([value, low, high]);
                if let Some(value) = half(i + 1) {
                    spans.extend([[value, low, high], [f64::NAN; 3]]);
                }
            }
            if spans.is_empty() {
                break;
            }
            areas.push(Area {
                name: pattern.to_string(),
                colour: Colour::of_pattern(pattern),
                spans,
                along: Along::Y,
            });
        }
    }
    areas
}

/// The name of each region in its middle, if it is wide enough there.
fn names(areas: &[Area], width: f64) -> Vec<Label> {
    let named = areas.iter().filter(|area| area.colour != Colour::FLAT);
    named
        .filter_map(|area| {
            let spans: Vec<&[f64; 3]> = area.spans.iter().filter(|s| s[0].is_finite()).collect();
            let [value, low, high] = *spans.get(spans.len() / 2)?;
            (high - low > NAMED * width).then(|| Label {
                at: [0.5 * (low + high), *value],
                text: area.name.clone(),
                colour: area.colour,
                side: [0, 0],
            })
        })
        .collect()
}
