//! The ground as diagrams: map, distribution of heights, power spectrum with its cut-offs.

use super::panel::{Area, Axis, Colour, Content, Inset, Label, Page, Panel, Role, Series};
use super::ticks::digits;
use crate::physics::topography::Statistics;
use crate::study::ground::GroundReport;

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
pub fn page<'a>(report: &GroundReport, title: &str) -> Page<'a> {
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
