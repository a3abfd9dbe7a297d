//! Speed against accuracy as a diagram: error of the dissipated energy against what the loop cost,
//! both logarithmic.

use super::panel::{Axis, Colour, Label, Page, Panel, Role, Series, Symbol, letter};
use super::scale::digits;
use crate::scene::Strategy;
use crate::solver::methods::MethodKind;
use crate::study::chart::{Chart, Judged, Point, Saved, Verdict, on_front, saved};

/// Height of the strip at the top, as a factor of the error's axis: the place of loops that have no
/// error.
const STRIP: f64 = 5.0;
/// Errors below this are not told apart, so that zero has a place on a logarithmic axis.
const LEAST: f64 = 1e-12;
/// Letters of a failure in the caption, at most.
const SHORT: usize = 50;

/// What a loop costs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Cost {
    /// Processor seconds.
    #[default]
    Time,
    /// Fourier transforms.
    Transforms,
}

impl Cost {
    /// The name of its axis.
    pub fn label(self) -> &'static str {
        match self {
            Cost::Time => "processor time of the loop / s",
            Cost::Transforms => "Fourier transforms of the loop",
        }
    }

    fn of(self, row: &Judged) -> f64 {
        match self {
            Cost::Time => row.processor_seconds,
            Cost::Transforms => row.transforms as f64,
        }
    }
}

/// Colours and symbols of the methods in their order.
const MARKS: [(Colour, Symbol); MethodKind::ALL.len()] = [
    (Colour::Blue, Symbol::Circle),
    (Colour::Green, Symbol::Square),
    (Colour::Gold, Symbol::Triangle),
    (Colour::Orange, Symbol::Diamond),
    (Colour::Purple, Symbol::Down),
    (Colour::Ink, Symbol::Left),
];

/// Colour and symbol of a way to compute the loop: one for each method, and one for the atlas.
pub fn mark(point: &Point) -> (Colour, Symbol) {
    if point.model == Strategy::Atlas {
        (Colour::Teal, Symbol::Plus)
    } else {
        MARKS[point.method.index()]
    }
}

/// The rows of a chart on its axes.
pub struct ChartPanel<'a> {
    rows: &'a [Judged],
    /// The reference's own error, below which nothing is told apart.
    floor: Option<f64>,
    cost: Cost,
    x: [f64; 2],
    y: [f64; 2],
}

impl<'a> ChartPanel<'a> {
    /// The rows against this cost; `floor` is the reference's own error, where it is known.
    pub fn new(rows: &'a [Judged], floor: Option<f64>, cost: Cost) -> Self {
        let floor = floor.filter(|floor| *floor > LEAST);
        let errors = rows
            .iter()
            .map(|row| row.errors.dissipated_energy)
            .filter(|error| error.is_finite());
        let (least, most) = bounds(
            errors
                .map(|error| error.max(floor.unwrap_or(LEAST)))
                .chain(floor),
        );
        let (cheapest, dearest) = bounds(rows.iter().map(|row| cost.of(row)));
        Self {
            rows,
            floor,
            cost,
            x: [cheapest / 4.0, 3.0 * dearest],
            y: [least / 4.0, 2.0 * STRIP * most],
        }
    }

    /// Where a row stands, (cost, error): below the reference's own error at that error, without an
    /// error in the strip at the top. `None` where nothing was spent.
    pub fn place(&self, row: &Judged) -> Option<[f64; 2]> {
        let (cost, error) = (self.cost.of(row), row.errors.dissipated_energy);
        let error = if error.is_finite() {
            error.max(self.floor.unwrap_or(LEAST))
        } else {
            self.y[1] / STRIP.sqrt()
        };
        (cost.is_finite() && cost > 0.0).then_some([cost, error])
    }

    /// The diagram.
    pub fn panel(&self) -> Panel {
        let ([left, right], [bottom, top]) = (self.x, self.y);
        let mut labels = vec![Label {
            at: [right, top / STRIP],
            text: "loop not closed".to_owned(),
            colour: Colour::Grey,
            side: [-1, 1],
        }];
        labels.extend(self.words());
        let strip = Series::line(
            "",
            Role::Guide,
            Colour::Grey,
            vec![[left, top / STRIP], [right, top / STRIP]],
        );
        let mut series = vec![strip, self.front()];
        if let Some(floor) = self.floor {
            let points = vec![[left, floor], [right, floor]];
            series.push(Series::line(
                "reference's own error",
                Role::Unstable,
                Colour::Grey,
                points,
            ));
        }
        series.extend(self.marks());
        Panel {
            x: Axis::logarithmic(self.cost.label()).from_to(left, right),
            y: Axis::logarithmic("relative error of the dissipated energy").from_to(bottom, top),
            series,
            labels,
            ..Panel::default()
        }
    }

    fn places(&self, which: impl Fn(&Judged) -> bool) -> Vec<[f64; 2]> {
        self.rows
            .iter()
            .filter(|row| which(row))
            .filter_map(|row| self.place(row))
            .collect()
    }

    /// Symbols of each way to compute the loop, in the order of the legend; hollow for a quarter of
    /// the cell, a cross for a failure.
    fn marks(&self) -> Vec<Series> {
        let mut series: Vec<Series> = Vec::new();
        for first in ways(self.rows) {
            let (colour, symbol) = mark(&first);
            let quarter = |row: &Judged| row.point.model == Strategy::QUARTER;
            let own = |row: &Judged| row.point.strategy() == first.strategy();
            let done = |row: &Judged| own(row) && row.verdict == Verdict::Done;
            let points = self.places(|row| done(row) && !quarter(row));
            series.push(Series::symbols(first.strategy(), symbol, colour, points).filled());
            series.push(Series::symbols(
                "",
                symbol,
                colour,
                self.places(|row| done(row) && quarter(row)),
            ));
            series.push(Series::symbols(
                "",
                Symbol::Cross,
                colour,
                self.places(|row| own(row) && row.verdict != Verdict::Done),
            ));
        }
        for (name, symbol, points) in [
            ("plan's choice", Symbol::Ring, self.places(|row| row.plan)),
            (
                "paper's budget",
                Symbol::Frame,
                self.places(|row| row.paper_budget),
            ),
        ] {
            if !points.is_empty() {
                series.push(Series::symbols(name, symbol, Colour::Ink, points));
            }
        }
        // What marks of their own colour mean, for the legend alone.
        let said = |name, symbol, of: fn(&Judged) -> bool| {
            let some = self.rows.iter().any(of);
            some.then(|| Series::symbols(name, symbol, Colour::Ink, Vec::new()))
        };
        series.extend(said("failed", Symbol::Cross, |row| {
            matches!(row.verdict, Verdict::Failed { .. })
        }));
        series.extend(said("hollow: quarter cell", Symbol::Circle, |row| {
            row.point.model == Strategy::QUARTER
        }));
        series
    }

    /// Which rows nothing else beats.
    fn best(&self) -> Vec<&Judged> {
        let on = on_front(self.rows, self.floor.unwrap_or(0.0), |row| {
            self.cost.of(row)
        });
        self.rows
            .iter()
            .zip(on)
            .filter(|(_, on)| *on)
            .map(|(row, _)| row)
            .collect()
    }

    /// The front as stairs: to the right of a point nothing cheaper is better.
    fn front(&self) -> Series {
        let mut points: Vec<[f64; 2]> = self
            .best()
            .into_iter()
            .filter_map(|row| self.place(row))
            .collect();
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let end = points.last().map(|last| [self.x[1], last[1]]);
        let corners = points
            .windows(2)
            .flat_map(|pair| [pair[0], [pair[1][0], pair[0][1]]]);
        let stairs: Vec<[f64; 2]> = corners.chain(points.last().copied()).chain(end).collect();
        Series::line("Pareto front", Role::Simulation, Colour::Gold, stairs)
    }

    /// The letter of what failed beside its mark; mesh and step of what is on the front.
    fn words(&self) -> Vec<Label> {
        let failures = failures(self.rows);
        let letters = self.rows.iter().filter_map(|row| {
            let Verdict::Failed { what, .. } = &row.verdict else {
                return None;
            };
            let text = letter(failures.iter().position(|known| known == what)?).to_string();
            Some(Label {
                at: self.place(row)?,
                text,
                colour: mark(&row.point).0,
                side: [1, 1],
            })
        });
        let mut told: Vec<String> = Vec::new();
        let settings = self.best().into_iter().filter_map(|row| {
            let text = format!("n = {}, step {}", row.point.points, row.point.step);
            let new = !told.contains(&text);
            told.push(text.clone());
            let at = self.place(row)?;
            // Where there is room for the words.
            let left = (at[0] / self.x[0]).ln() < 0.3 * (self.x[1] / self.x[0]).ln();
            new.then_some(Label {
                at,
                text,
                side: if left { [1, 1] } else { [-1, -1] },
                ..Label::default()
            })
        });
        settings.chain(letters).collect()
    }
}

/// A point of each way to compute the loop that has its own mark, in the order of the legend.
pub fn ways(rows: &[Judged]) -> Vec<Point> {
    let mut ways: Vec<Point> = Vec::new();
    for row in rows {
        if !ways
            .iter()
            .any(|known| known.strategy() == row.point.strategy())
        {
            ways.push(row.point);
        }
    }
    ways.sort_by_key(|point| (point.model != Strategy::Atlas, point.method.index()));
    ways
}

/// Everything that failed, each once; the diagram calls them a, b, c.
fn failures(rows: &[Judged]) -> Vec<&str> {
    let mut list: Vec<&str> = Vec::new();
    for row in rows {
        if let Verdict::Failed { what, .. } = &row.verdict
            && !list.contains(&what.as_str())
        {
            list.push(what);
        }
    }
    list
}

/// The picture of a whole chart, against both costs.
pub fn page(chart: &Chart, title: &str) -> Page<'static> {
    let panels = [Cost::Transforms, Cost::Time]
        .map(|cost| ChartPanel::new(&chart.rows, chart.floor(), cost).panel());
    Page::new(
        &format!("Speed against accuracy: {title}"),
        caption(chart),
        panels.to_vec(),
    )
}

/// The caption of a whole chart: its reference, what was left out, what the letters mean.
fn caption(chart: &Chart) -> Vec<String> {
    let skipped = match chart.skipped.len() {
        0 => String::new(),
        n => format!("  {n} points were left out as too dear."),
    };
    let cut = if chart.cancelled {
        "  Interrupted: what was measured by then."
    } else {
        ""
    };
    let mut lines = vec![match &chart.reference {
        None => format!("Interrupted before there was a reference.{skipped}"),
        Some(reference) => format!(
            "Reference: {} γ lost, by n = {} and steps of {}; its own error {:.0e}.{skipped}{cut}",
            digits(reference.dissipated_energy, 1e-5),
            reference.point().points,
            reference.point().step,
            reference.errors.dissipated_energy,
        ),
    }];
    lines.extend(headline(&chart.rows, chart.floor()));
    let short = |what: &str| {
        if what.chars().count() <= SHORT {
            what.to_owned()
        } else {
            what.chars().take(SHORT).chain("...".chars()).collect()
        }
    };
    let failed: Vec<String> = failures(&chart.rows)
        .into_iter()
        .enumerate()
        .map(|(i, what)| format!("{}: {}", letter(i), short(what)))
        .collect();
    lines.extend(
        failed
            .chunks(3)
            .map(|three| format!("Failed  {}", three.join("     "))),
    );
    lines
}

/// How much cheaper the paper's loop is had, at its own error and at the least that its method
/// reached; `floor` is the reference's own error, where it is known.
pub fn headline(rows: &[Judged], floor: Option<f64>) -> Vec<String> {
    let [budget, best] = saved(rows, floor.unwrap_or(0.0));
    let said = |saved: Saved<'_>, of: &str| {
        format!(
            "{:.0} times less processor time ({}, n = {}) than {of}, {:.1} % off.",
            saved.ratio(),
            saved.ours.point.strategy(),
            saved.ours.point.points,
            100.0 * saved.paper.errors.dissipated_energy,
        )
    };
    let budget = budget.map(|saved| said(saved, "the paper's method with its budget"));
    let best = best.map(|saved| said(saved, "the best that method reaches"));
    budget.into_iter().chain(best).collect()
}

/// Least and largest of what can be shown on a logarithmic axis; a decade where there is nothing.
fn bounds(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let shown = values.filter(|v| v.is_finite() && *v > 0.0);
    let (least, most) = shown.fold((f64::INFINITY, 0.0_f64), |(a, b), v| (a.min(v), b.max(v)));
    if most > 0.0 {
        (least, most)
    } else {
        (1.0, 10.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_of_nothing_is_a_decade() {
        assert_eq!(bounds([f64::NAN, 0.0, -1.0].into_iter()), (1.0, 10.0));
        assert_eq!(bounds([3.0, f64::INFINITY, 0.5].into_iter()), (0.5, 3.0));
    }

    #[test]
    fn every_method_has_a_mark_of_its_own() {
        let base = Point {
            method: MethodKind::NewtonKrylov,
            model: Strategy::WHOLE,
            line: false,
            points: 64,
            precision: crate::numerics::precision::Precision::Double,
            step: 0.02,
        };
        let mut marks: Vec<_> = MethodKind::ALL
            .iter()
            .map(|method| {
                mark(&Point {
                    method: *method,
                    ..base
                })
            })
            .collect();
        marks.push(mark(&Point {
            model: Strategy::Atlas,
            ..base
        }));
        for (i, a) in marks.iter().enumerate() {
            assert!(marks[..i].iter().all(|b| a.0 != b.0 && a.1 != b.1), "{a:?}");
        }
    }
}
