//! What is computed of a scene in one go, as diagrams. Its branches: mean stress against mean
//! displacement, x = u0/rho and y = stress/sigma_max, tension positive. Stable pieces are solid,
//! unstable ones dashed, a fold is a square, a bifurcation a circle, equal energies are a diamond.
//!
//! The energy landscape around a state: the paths over its saddles, x = arc length/rho from the
//! state and y = energy/gamma above it; and how the barriers change along the control.
//!
//! The ground: map, distribution of heights, power spectrum with its cut-offs.

use super::loop_panel::{MARGIN, axes, place};
use super::panel::{Area, Axis, Colour, Content, Inset, Label, Page, Panel, Role, Series, Symbol};
use super::scale::{digits, ends, nice};
use crate::follow::diagram::{Branch, Diagram, Kind, Point};
use crate::numerics::dense::hermite;
use crate::physics::law::Law;
use crate::physics::parameter::Dimension;
use crate::physics::pattern::Pattern;
use crate::physics::topography::Statistics;
use crate::scene::Model;
use crate::study::ground::GroundReport;
use crate::study::landscape::{Landscape, Pass, Place};

/// Points of a curve between two computed ones.
const BETWEEN: usize = 8;
/// What is shown of compression, in units of the largest tension.
const DEEP: f64 = 0.5;
/// Stable pieces narrower than this share of the axis bear no name, which would not fit.
const NAMED: f64 = 0.05;

/// The picture of a diagram under the scene's title.
pub fn page(diagram: &Diagram, model: &Model, title: &str) -> Page<'static> {
    let mut title = title.to_owned();
    if diagram.control.frees_mean() {
        title.push_str(&format!(" (under {})", diagram.control));
    }
    let mut caption = vec![counts(diagram)];
    caption.extend(
        diagram
            .missing
            .iter()
            .map(|words| format!("Missing: {words}.")),
    );
    if diagram.cancelled {
        caption.push("Stopped before all was found.".to_owned());
    }
    Page::new(&title, caption, vec![diagram_panel(diagram, model)])
}

/// What was found, in words.
pub fn counts(diagram: &Diagram) -> String {
    let many = |count: usize, one: &str, more: &str| {
        format!("{count} {}", if count == 1 { one } else { more })
    };
    // Where a branch begins or ends on another, the bifurcation is a point of that one.
    let inner = |branch: &Branch| branch.points.len().saturating_sub(2);
    let of = |kind: Kind| {
        let inside = diagram.branches.iter().flat_map(|branch| {
            let points = branch.points.iter().skip(1).take(inner(branch));
            points.filter(move |point| point.kind == kind)
        });
        inside.count()
    };
    format!(
        "{}, {}, {}, {} of equal energy",
        many(diagram.branches.len(), "branch", "branches"),
        many(of(Kind::Fold), "fold", "folds"),
        many(of(Kind::Bifurcation), "bifurcation", "bifurcations"),
        many(diagram.equal_energies.len(), "pair", "pairs"),
    )
}

/// The diagram itself.
pub fn diagram_panel(diagram: &Diagram, model: &Model) -> Panel {
    let law = &model.law;
    let at = |p: &Point| place(p.state.mean_displacement, p.state.stress, law);
    // Those of unstable states, of which a long cell has hundreds, must not hide the others.
    let places = |kind: Kind, between_unstable: bool| {
        let unstable = |p: &Point| !p.index.contains(&0);
        let of_kind = diagram.events().filter(|(_, p)| p.kind == kind);
        of_kind
            .filter(|(_, p)| unstable(p) == between_unstable)
            .map(|(_, p)| at(p))
            .collect::<Vec<_>>()
    };
    let equal = diagram.equal_energies.iter();
    let equal = equal
        .flat_map(|e| [0, 1].map(|k| place(e.mean_displacements[k], e.stresses[k], law)))
        .collect();
    let curves: Vec<Series> = diagram
        .branches
        .iter()
        .flat_map(|branch| pieces(branch, law))
        .collect();
    let symbols = |name: &str, symbol: Symbol, points: Vec<[f64; 2]>| {
        Series::symbols(name, symbol, Colour::Ink, points)
    };
    let (fold, bifurcation) = (Kind::Fold, Kind::Bifurcation);
    let among_unstable = [places(fold, true), places(bifurcation, true)].concat();
    let marks = [
        symbols(
            "fold or bifurcation of unstable states",
            Symbol::Dot,
            among_unstable,
        ),
        symbols("fold", Symbol::Square, places(fold, false)),
        symbols("bifurcation", Symbol::Circle, places(bifurcation, false)),
        symbols("equal energy", Symbol::Diamond, equal).filled(),
    ];
    let [x, y] = [0, 1].map(|k| {
        let values = curves.iter().flat_map(|s| &s.points).map(|p| p[k]);
        let (low, high) = ends(values.filter(|v| v.is_finite()));
        let [low, high] = if low < high { [low, high] } else { [0.0, 1.0] };
        // Deep in compression there is nothing to see.
        let low = if k == 1 {
            low.max(-DEEP * high.abs())
        } else {
            low
        };
        let room = MARGIN[k] * (high - low);
        [low - room, high + room]
    });
    let width = x[1] - x[0];
    let [x_axis, y_axis] = axes(model, [x, y]);
    Panel {
        x: x_axis,
        y: y_axis,
        labels: diagram
            .branches
            .iter()
            .flat_map(|branch| names(branch, width, &at))
            .collect(),
        series: curves
            .into_iter()
            .chain(marks.into_iter().filter(|s| !s.points.is_empty()))
            .collect(),
        ..Panel::default()
    }
}

/// Colour of a branch, and its name in the legend.
fn look(branch: &Branch) -> (Colour, &'static str) {
    let name = branch.name.split('_').next().unwrap_or_default();
    match name {
        "flat" => (Colour::FLAT, "flat state"),
        "ridge" => (Colour::Green, "ridge"),
        "square" => (Colour::Purple, "square pattern"),
        "mixed" => (Colour::Red, "mixed state"),
        _ => (Colour::Teal, "states"),
    }
}

/// A branch as stable and unstable curves.
fn pieces(branch: &Branch, law: &Law) -> Vec<Series> {
    let (colour, name) = look(branch);
    let mut pieces: Vec<Series> = Vec::new();
    for pair in branch.points.windows(2) {
        let stable = pair[0].index[1] == 0;
        let role = if stable {
            Role::Simulation
        } else {
            Role::Unstable
        };
        let curve = (0..=BETWEEN).map(|i| between(&pair[0], &pair[1], i, law));
        match pieces.last_mut() {
            Some(piece) if piece.role == role => piece.points.extend(curve.skip(1)),
            _ => {
                let name = format!("{name}{}", if stable { "" } else { ", unstable" });
                pieces.push(Series::line(&name, role, colour, curve.collect()));
            }
        }
    }
    pieces
}

/// u0/rho and stress/sigma_max at a share `i` of the way between two points: cubics in the arc
/// length.
fn between(a: &Point, b: &Point, i: usize, law: &Law) -> [f64; 2] {
    let (s, z) = (&a.state, &b.state);
    let ends = [
        &[s.mean_displacement, s.stress][..],
        &a.rates,
        &[z.mean_displacement, z.stress],
        &b.rates,
    ];
    let between = hermite(ends, b.arc - a.arc, i as f64 / BETWEEN as f64);
    place(between[0], between[1], law)
}

/// The pattern in the middle of each stable piece that is wide enough.
fn names(branch: &Branch, width: f64, at: &dyn Fn(&Point) -> [f64; 2]) -> Vec<Label> {
    let (colour, _) = look(branch);
    let named = [Pattern::Bulge, Pattern::Ridge, Pattern::Dimple];
    let stable = |p: &Point| p.index.contains(&0) && named.contains(&p.pattern);
    branch
        .points
        .chunk_by(|a, b| stable(a) == stable(b) && a.pattern == b.pattern)
        .filter(|piece| stable(&piece[0]))
        .filter_map(|piece| {
            let (first, last) = (at(&piece[0]), at(&piece[piece.len() - 1]));
            let middle = at(&piece[piece.len() / 2]);
            let wide = (first[0] - last[0]).abs() > NAMED * width;
            wide.then(|| Label {
                at: middle,
                text: piece[0].pattern.word().to_owned(),
                colour,
                side: [1, 1],
            })
        })
        .collect()
}

/// What both diagrams show at least and at most: axes that stay put while the barriers change.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extent {
    /// The longest path (ranges).
    pub arc: f64,
    /// The deepest neighbour (gamma).
    pub deepest: f64,
    /// The highest barrier (gamma).
    pub highest: f64,
}

impl Extent {
    /// What holds these passes too; it grows to round numbers.
    pub fn with(self, landscape: &Landscape, law: &Law) -> Self {
        let gamma = law.surface_energy;
        let grown = |now: f64, wanted: f64| {
            if wanted > now { nice(wanted) } else { now }
        };
        let mut all = self;
        for pass in &landscape.passes {
            let longest = pass.path.last().map_or(0.0, |end| end.arc / law.range);
            let barriers = pass.barriers.iter().map(|[_, energy]| *energy);
            let highest = barriers.fold(pass.barrier(), f64::max) / gamma;
            all = Self {
                arc: grown(all.arc, longest),
                deepest: grown(all.deepest, pass.released() / gamma),
                highest: grown(all.highest, highest),
            };
        }
        all
    }
}

/// Arc length and energy of a place above the first of its path: ranges, and gamma.
pub fn at(place: &Place, pass: &Pass, law: &Law) -> [f64; 2] {
    let foot = pass.path[0].energy;
    [
        place.arc / law.range,
        (place.energy - foot) / law.surface_energy,
    ]
}

/// The paths over all saddles.
pub fn landscape_panel(landscape: &Landscape, model: &Model, extent: Extent) -> Panel {
    let law = &model.law;
    let (length, energy) = (model.unit(Dimension::Length), model.unit_of_barriers());
    let mut series = Vec::new();
    let mut labels = Vec::new();
    for pass in &landscape.passes {
        let points: Vec<[f64; 2]> = pass.path.iter().map(|place| at(place, pass, law)).collect();
        let colour = Colour::of_pattern(pass.to);
        let name = format!("to {} over \"{}\"", pass.to, pass.branch);
        let end = points[points.len() - 1];
        labels.push(Label {
            at: end,
            text: pass.to.word().to_owned(),
            colour,
            side: [-1, -1],
        });
        let top = vec![points[pass.saddle]];
        series.push(Series::line(&name, Role::Simulation, colour, points));
        series.push(Series::symbols("saddle", Symbol::Triangle, Colour::Ink, top).filled());
    }
    let Extent {
        arc,
        deepest,
        highest,
    } = extent;
    let room = 0.15 * (deepest + highest);
    Panel {
        title: energy.label(
            "path of steepest descent",
            "path of steepest descent: energy",
        ),
        x: Axis::of(&length, "way of the surface/rho", "way of the surface")
            .from_to(-0.05 * arc, 1.05 * arc),
        y: Axis::of(&energy, "energy/gamma", "energy").from_to(-deepest - room, highest + room),
        series,
        labels,
        ..Panel::default()
    }
}

/// The barriers along the control, whose values are told in this `unit` under this `label`.
pub fn barrier_panel(
    landscape: &Landscape,
    model: &Model,
    extent: Extent,
    (label, unit): (&str, f64),
) -> Panel {
    let gamma = model.law.surface_energy;
    let told = model.unit_of_barriers();
    let place = |[control, energy]: &[f64; 2]| [control / unit, energy / gamma];
    let curve = |pass: &Pass| {
        let points = pass.barriers.iter().map(place).collect();
        Series::line("", Role::Simulation, Colour::of_pattern(pass.to), points)
    };
    let now = landscape.passes.iter();
    let now = now.map(|pass| place(&[landscape.control, pass.barrier()]));
    let here = Series::symbols("", Symbol::Circle, Colour::Ink, now.collect()).filled();
    Panel {
        title: told.label("barrier", "barrier"),
        x: Axis::linear(label),
        y: Axis::of(&told, "barrier/gamma", "barrier").from_to(0.0, 1.15 * extent.highest),
        series: landscape.passes.iter().map(curve).chain([here]).collect(),
        ..Panel::default()
    }
}

/// Decades of the spectrum below its greatest value that are shown.
const DECADES: f64 = 9.0;

/// All three.
pub fn panels(report: &GroundReport) -> Vec<Panel> {
    vec![
        map_panel(report),
        distribution_panel(report),
        spectrum_panel(report),
    ]
}

/// All three under a title, with the numbers and what must be known.
pub fn ground_page<'a>(report: &GroundReport, title: &str) -> Page<'a> {
    let mut caption = vec![numbers("On the mesh", &report.cell, report.unit)];
    if let Some(file) = &report.file {
        let [nx, ny] = file.points;
        caption.push(numbers(
            &format!("In the file ({}, {nx} x {ny})", file.format),
            &file.before,
            report.unit,
        ));
    }
    caption.extend(report.words.iter().cloned());
    Page::new(title, caption, panels(report))
}

/// Root mean squares in one line, lengths with their unit where it is known.
pub fn numbers(what: &str, of: &Statistics, unit: Option<&str>) -> String {
    let told = |x: f64| digits(x, 1e-3 * x.abs());
    let [length, inverse] =
        ["", "1/"].map(|over| unit.map_or(String::new(), |u| format!(" {over}{u}")));
    format!(
        "{what}: rms height {}{length}, rms slope {}, rms curvature {}{inverse}, span {}{length}",
        told(of.height),
        told(of.gradient),
        told(0.5 * of.laplacian),
        told(of.span)
    )
}

/// The heights over the cell; of a profile, height over x.
pub fn map_panel(report: &GroundReport) -> Panel {
    let (length, unit) = (report.grid.length, report.length());
    let x = Axis::linear(&format!("x ({unit})")).from_to(0.0, length);
    if report.grid.is_line() {
        let places = report.height.iter().enumerate();
        let places = places.map(|(i, h)| [i as f64 * report.grid.spacing(), *h]);
        return Panel {
            title: "profile".to_owned(),
            x,
            y: Axis::linear(&format!("height above the mean ({unit})")),
            series: vec![Series::line(
                "",
                Role::Simulation,
                Colour::Blue,
                places.collect(),
            )],
            ..Panel::default()
        };
    }
    Panel {
        title: "height (dark is low)".to_owned(),
        x,
        y: Axis::linear(&format!("y ({unit})")).from_to(0.0, length),
        insets: vec![Inset {
            place: [0.0, 0.0, 1.0, 1.0],
            content: Content::Map {
                letter: String::new(),
                gap: report.height.clone(),
            },
        }],
        ..Panel::default()
    }
}

/// Share of the area per height.
pub fn distribution_panel(report: &GroundReport) -> Panel {
    let spans = report
        .distribution
        .iter()
        .map(|[h, share]| [*h, 0.0, *share]);
    let most = report
        .distribution
        .iter()
        .map(|[_, share]| *share)
        .fold(0.0, f64::max);
    Panel {
        title: "distribution of heights".to_owned(),
        x: Axis::linear(&format!("height above the mean ({})", report.length())),
        y: Axis::linear("share of the area per height").from_to(0.0, 1.05 * most),
        areas: vec![Area {
            colour: Colour::Blue,
            spans: spans.collect(),
            ..Area::default()
        }],
        series: vec![Series::line(
            "",
            Role::Simulation,
            Colour::Blue,
            report.distribution.clone(),
        )],
        ..Panel::default()
    }
}

/// C(q) with what cuts it off.
pub fn spectrum_panel(report: &GroundReport) -> Panel {
    let shown = report.spectrum.iter().filter(|[_, power]| *power > 0.0);
    let shown: Vec<[f64; 2]> = shown.copied().collect();
    let most = shown
        .iter()
        .map(|[_, power]| *power)
        .fold(f64::MIN_POSITIVE, f64::max);
    let least = shown.iter().map(|[_, power]| *power).fold(most, f64::min);
    let low = least.max(most * 10f64.powf(-DECADES)) / 2.0;
    let high = 3.0 * most;
    let ends = report.cutoffs.iter().map(|(_, q)| *q);
    let q1 = report.grid.q1();
    let last = ends.fold(2.0 * q1, f64::max);
    let line = |(_, q): &(&str, f64)| {
        Series::line("", Role::Guide, Colour::Grey, vec![[*q, low], [*q, high]])
    };
    let word = |(at, (name, q)): (usize, &(&'static str, f64))| Label {
        // One below the other: two may be the same place.
        at: [*q, high / (high / low).powf(0.06 * (at as f64 + 0.8))],
        text: (*name).to_owned(),
        colour: Colour::Ink,
        side: [-1, 0],
    };
    let unit = report.length();
    let power = if report.grid.is_line() { 3 } else { 4 };
    let simulated = Series::line("", Role::Simulation, Colour::Blue, shown);
    Panel {
        title: "power spectrum".to_owned(),
        x: Axis::logarithmic(&format!("wave number q (1/{unit})")).from_to(0.7 * q1, 1.5 * last),
        y: Axis::logarithmic(&format!("C(q) ({unit}^{power})")).from_to(low, high),
        series: report.cutoffs.iter().map(line).chain([simulated]).collect(),
        labels: report.cutoffs.iter().enumerate().map(word).collect(),
        ..Panel::default()
    }
}
