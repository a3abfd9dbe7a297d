//! One column of a study against another, beside theory where there is one: the loss in the limit
//! of small range, and the limits of the flat state.

use super::panel::{Axis, Colour, Page, Panel, Role, Series, Symbol};
use super::scale::ends;
use crate::physics::body::Body;
use crate::physics::indenter::Indenter;
use crate::physics::parameter::{Parameter, number};
use crate::physics::theory::{flat, ridge};
use crate::scene::{Model, parameter};
use crate::study::axis::{Spacing, Span};
use crate::study::sweep::{Row, Study};

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

/// The picture of a study.
pub fn page(study: &Study, rows: &[Row]) -> Page<'static> {
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
    Page::new(&study.title, caption, vec![panel(study, rows, &study.plot)])
}

/// The numbers of `y` against those of `x`, keys or recorded columns of the study.
pub fn panel(study: &Study, rows: &[Row], [x, y]: &[String; 2]) -> Panel {
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
    Axis {
        logarithmic: is_logarithmic(values),
        ..Axis::linear(&label)
    }
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
        if axis.logarithmic {
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
        "approach_jumps" => |model| Some(flat::limits(&model.law, model.grid.length)?.1),
        "retraction_jumps" => |model| Some(flat::limits(&model.law, model.grid.length)?.0),
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
    let over = |model: &Model| model.grid.length / flat::critical_length(&model.law) - 1.0;
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
