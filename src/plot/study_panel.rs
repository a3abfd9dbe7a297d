//! Studies over a parameter of the scene. A sweep: one column against another, beside theory where
//! there is one, which is the loss in the limit of small range, and the limits of the flat state. A
//! map of patterns: which pattern stands where on the way down and on the way up, x = u0/rho and y a
//! parameter; and beside it what the loop loses.

use super::loop_panel::place;
use super::panel::{Along, Area, Axis, Colour, Label, Page, Panel, Role, Series, Spread, Symbol};
use super::scale::ends;
use crate::follow::record::Direction;
use crate::physics::body::Body;
use crate::physics::indenter::Indenter;
use crate::physics::parameter::{Parameter, number};
use crate::physics::pattern::Pattern;
use crate::physics::theory::{critical_length, flat_limits, ridge};
use crate::scene::parameter::Units;
use crate::scene::{Model, Scene, parameter};
use crate::study::map::{self, Found, PatternMap};
use crate::study::sweep::{Row, Spacing, Span, Study};

/// From this ratio of its ends on an axis is logarithmic where nothing else decides.
const DECADES: f64 = 30.0;
/// Values that are so nearly equal factors apart were chosen so.
const EQUAL: f64 = 1e-6;
/// Most sets of symbols that are told apart.
const SETS_MAX: usize = 6;
/// Room beside the marks, as a share of their way.
const MARGIN: f64 = 0.03;
/// Places of a theory's curve.
const PLACES: usize = 96;

/// The symbols of the sets.
const MARKS: [(Symbol, Colour); SETS_MAX] = [
    (Symbol::Circle, Colour::Blue),
    (Symbol::Square, Colour::Red),
    (Symbol::Triangle, Colour::Green),
    (Symbol::Diamond, Colour::Orange),
    (Symbol::Down, Colour::Purple),
    (Symbol::Right, Colour::Teal),
];

/// The picture of a sweep.
pub fn sweep_page(study: &Study, rows: &[Row]) -> Page<'static> {
    let complete = rows.iter().filter(|row| row.is_complete()).count();
    let mut caption = vec![format!("{complete} of {} loops.", study.places.len())];
    if let Some(row) = rows.iter().find(|row| !row.is_complete()) {
        let failed = rows.len() - complete;
        caption.push(format!(
            "{failed} failed, first row {}: {}.",
            row.index + 1,
            row.reason
        ));
    }
    Page::new(
        &study.title,
        caption,
        vec![sweep_panel(study, rows, &study.plot)],
    )
}

/// The numbers of `y` against those of `x`, keys or recorded columns of the study.
pub fn sweep_panel(study: &Study, rows: &[Row], [x, y]: &[String; 2]) -> Panel {
    let all = |name: &str| -> Vec<f64> {
        rows.iter()
            .flat_map(|row| study.numbers(row, name))
            .collect()
    };
    let (xs, ys) = (all(x), all(y));
    let mut sets: Vec<(String, Vec<&Row>)> = Vec::new();
    for row in rows {
        let name = others(study, row, x);
        match sets.iter_mut().find(|(known, _)| *known == name) {
            Some((_, set)) => set.push(row),
            None => sets.push((name, vec![row])),
        }
    }
    let mut series = Vec::new();
    if sets.len() <= SETS_MAX {
        for ((name, set), (symbol, colour)) in sets.iter().zip(MARKS) {
            series.extend(theory(study, set[0], [x, y], [&xs, &ys], colour));
            series.push(Series::symbols(name, symbol, colour, points(study, set, [x, y])).filled());
        }
    } else {
        let rows: Vec<&Row> = rows.iter().collect();
        let points = points(study, &rows, [x, y]);
        series.push(Series::symbols("", Symbol::Circle, Colour::Blue, points).filled());
    }
    // One name for the curves of all sets.
    let mut known: Vec<String> = Vec::new();
    for one in series.iter_mut().filter(|one| one.symbol.is_none()) {
        if known.contains(&one.name) {
            one.name.clear();
        } else {
            known.push(one.name.clone());
        }
    }
    let (least, _) = ends(ys.iter().copied());
    let floor = if least.is_finite() { least } else { 0.0 };
    let without = |row: &&Row| study.numbers(row, y).is_empty();
    let open = |row: &&Row| without(row) && row.is_complete() && !row.reason.is_empty();
    let at = |rows: Vec<&Row>| -> Vec<[f64; 2]> {
        let xs = rows.iter().flat_map(|row| study.numbers(row, x));
        xs.map(|x| [x, floor]).collect()
    };
    let failed = at(rows.iter().filter(|row| !row.is_complete()).collect());
    let open = at(rows.iter().filter(open).collect());
    for (name, symbol, points) in [
        ("failed", Symbol::Cross, failed),
        ("loop not closed", Symbol::Ring, open),
    ] {
        if !points.is_empty() {
            series.push(Series::symbols(name, symbol, Colour::Ink, points));
        }
    }
    let way = way(study, x);
    let mut across = axis(x, way.as_ref().unwrap_or(&xs));
    across.range = way.and_then(|way| shown(&way, &across));
    Panel {
        x: across,
        y: axis(y, &ys),
        series,
        ..Panel::default()
    }
}

fn points(study: &Study, rows: &[&Row], [x, y]: [&str; 2]) -> Vec<[f64; 2]> {
    let of = |row: &&Row| {
        let ys = study.numbers(row, y);
        let xs = study.numbers(row, x).into_iter().take(1);
        let all = xs.flat_map(|x| ys.iter().map(move |y| [x, *y]));
        all.collect::<Vec<_>>()
    };
    rows.iter().flat_map(of).collect()
}

/// The values of the other keys in words.
fn others(study: &Study, row: &Row, x: &str) -> String {
    let values = study
        .keys
        .iter()
        .zip(&row.values)
        .filter(|(key, _)| *key != x);
    let words = values.map(|(key, value)| format!("{key} = {}", number(*value)));
    words.collect::<Vec<_>>().join(", ")
}

fn axis(name: &str, values: &[f64]) -> Axis {
    let label = parameter::find(name).map_or_else(|| name.replace('_', " "), Parameter::title);
    let spread = if is_logarithmic(values) {
        Axis::logarithmic
    } else {
        Axis::linear
    };
    spread(&label)
}

/// All values of a number that goes.
fn way(study: &Study, name: &str) -> Option<Vec<f64>> {
    let k = study.keys.iter().position(|key| key == name)?;
    Some(study.places.iter().map(|place| place[k]).collect())
}

/// What an axis shows of a number that goes: all of its way, from the first loop on.
fn shown(way: &[f64], axis: &Axis) -> Option<[f64; 2]> {
    let (low, high) = ends(way.iter().copied());
    let room = MARGIN * (high - low);
    let factor = (high / low).powf(MARGIN);
    (low < high).then(|| {
        if axis.spread == Spread::Logarithmic {
            [low / factor, high * factor]
        } else {
            [low - room, high + room]
        }
    })
}

/// True of values that were chosen by equal factors, or go over decades.
fn is_logarithmic(values: &[f64]) -> bool {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup();
    let [first, second, .., last] = sorted[..] else {
        return false;
    };
    if first <= 0.0 {
        return false;
    }
    let factor = (second / first).ln();
    let equal = sorted
        .windows(2)
        .all(|pair| ((pair[1] / pair[0]).ln() / factor - 1.0).abs() < EQUAL);
    equal || last / first >= DECADES
}

/// What theory says where `x` goes and the other keys are those of `row`; `shown` are the values of
/// both axes.
fn theory(
    study: &Study,
    row: &Row,
    [x, y]: [&str; 2],
    shown: [&[f64]; 2],
    colour: Colour,
) -> Vec<Series> {
    let Some(k) = study.keys.iter().position(|key| key == x) else {
        return Vec::new();
    };
    let of: fn(&Model) -> Option<f64> = match y {
        "dissipated_energy" => |model| {
            // That of a ridge: squares have other patterns beside it.
            let line = model.grid.is_line();
            line.then(|| ridge::loss(&model.law, model.grid.length))?
        },
        "approach_jumps" => |model| Some(flat_limits(&model.law, model.grid.length)?.1),
        "retraction_jumps" => |model| Some(flat_limits(&model.law, model.grid.length)?.0),
        _ => return Vec::new(),
    };
    let name = match y {
        "dissipated_energy" => "flat to ridge and back, small range",
        _ => "flat limit, Eq. 8",
    };
    let [(from, to), (_, high)] = shown.map(|values| ends(values.iter().copied()));
    if !(from < to) {
        return Vec::new();
    }
    let spacing = if is_logarithmic(shown[0]) {
        Spacing::Logarithmic
    } else {
        Spacing::Linear
    };
    let model_at = |value: f64| {
        let mut place = row.values.clone();
        place[k] = value;
        study.scene_at(&place).ok()?.model().ok().filter(has_theory)
    };
    let places = Span { from, to, spacing }.values(PLACES);
    let models: Vec<_> = places
        .iter()
        .map(|value| (*value, model_at(*value)))
        .collect();
    let curve = models.iter().map(|(value, model)| {
        let number = model.as_ref().and_then(of);
        [*value, number.unwrap_or(f64::NAN)]
    });
    let mut series = vec![Series::line(name, Role::Theory, colour, curve.collect())];
    // Where the flat state is everywhere stable, on one side.
    let over = |model: &Model| model.grid.length / critical_length(&model.law) - 1.0;
    let excess = |(value, model): &(f64, Option<Model>)| Some((*value, over(model.as_ref()?)));
    let turn = models.windows(2).find_map(|pair| {
        let ((a, below), (b, above)) = (excess(&pair[0])?, excess(&pair[1])?);
        (below * above < 0.0).then(|| a + (b - a) * below / (below - above))
    });
    if let Some(x) = turn {
        let points = vec![[x, 0.0], [x, high.max(0.0)]];
        series.push(Series::line("L = L_c", Role::Guide, Colour::Grey, points));
    }
    series.retain(|one| one.points.iter().any(|[_, y]| y.is_finite()));
    series
}

/// Theory is that of a half-space on flat ground whose u0 is driven.
fn has_theory(model: &Model) -> bool {
    model.body == Body::HalfSpace && model.indenter == Indenter::Flat
}

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
pub fn map_page(map: &PatternMap, scene: &Scene) -> Page<'static> {
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
    let spread = if map.vary.is_geometric() {
        Axis::logarithmic
    } else {
        Axis::linear
    };
    let y = spread(&label).from_to(low, high);
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
pub fn loop_of(row: &map::Row, name: &str) -> Option<Series> {
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
fn interval(
    row: &map::Row,
    direction: Direction,
    pattern: Pattern,
    number: usize,
) -> Option<[f64; 2]> {
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
                Some((row.value, interval(row, direction, pattern, number)?))
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
