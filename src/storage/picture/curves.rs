//! What the diagram of a loop shows, in its own coordinates: x = u0/rho, y = stress/sigma_max.

use crate::experiment::record::{Branch, LoopRecord, StateRecord};
use crate::physics::law::Law;
use crate::physics::pattern::Pattern;
use std::ops::Range;

/// Points of a curve that lie closer than this share of the window are left out.
const THINNING: f64 = 5e-4;
/// Points of the flat state's curve.
const FLAT_POINTS: usize = 400;

pub(super) type Point = (f64, f64);

/// Axis ranges.
pub(super) struct Window {
    pub(super) x: Range<f64>,
    pub(super) y: Range<f64>,
}

/// A piece of curve between two jumps.
pub(super) struct Line {
    pub(super) branch: Branch,
    pub(super) pattern: Pattern,
    pub(super) points: Vec<Point>,
}

/// Everything to draw.
pub(super) struct Curves {
    pub(super) window: Window,
    pub(super) lines: Vec<Line>,
    /// The flat state, where it means anything.
    pub(super) flat: Option<Vec<Point>>,
    /// The area of the loop, if it is closed.
    pub(super) loss: Vec<Vec<Point>>,
}

impl Curves {
    pub(super) fn new(record: &LoopRecord, law: &Law) -> Self {
        let point = |s: &StateRecord| (s.mean_displacement / law.range, s.stress_over_max);
        let states: Vec<_> = record.states.iter().filter(|s| point(s).0.is_finite() && point(s).1.is_finite()).collect();
        let flat_ground = states.is_empty() || states.iter().any(|s| s.pattern == Pattern::Flat);
        let x = spread(states.iter().map(|s| point(s).0), (0.0, 5.0), 0.02);
        let flat = flat_ground.then(|| flat_curve(law, &x));
        let peak = flat.iter().flatten().map(|p| p.1).fold(0.0, f64::max);
        let y = spread(states.iter().map(|s| point(s).1).chain([0.0, peak]), (-0.2, 1.0), 0.05);
        // The flat state's curve is cut where it leaves the window of the states.
        let flat = flat.map(|curve| curve.into_iter().filter(|p| y.contains(&p.1)).collect());
        let closed = record.ledger(law.surface_energy).open.is_none();
        let window = Window { x, y };
        let lines = lines(&states, record, point, &window);
        let loss = if closed { loss(&states, point) } else { Vec::new() };
        Self { window, lines, flat, loss }
    }

    pub(super) fn lines_of(&self, branch: Branch) -> impl Iterator<Item = &Line> {
        self.lines.iter().filter(move |line| line.branch == branch)
    }

    /// Where to write the name of which pattern, and whether the curve rises there: the middle of every long piece that is not flat.
    pub(super) fn names(&self, branch: Branch) -> Vec<(Point, &'static str, bool)> {
        let width = self.window.x.end - self.window.x.start;
        let long = self.lines_of(branch).filter(|line| {
            let (first, last) = (line.points[0], line.points[line.points.len() - 1]);
            line.pattern != Pattern::Flat && (last.0 - first.0).abs() > 0.03 * width
        });
        let name = |line: &Line| {
            let middle = line.points.len() / 2;
            let (a, b) = (line.points[middle - 1], line.points[middle]);
            (b, line.pattern.word(), (b.1 - a.1) * (b.0 - a.0) >= 0.0)
        };
        long.map(name).collect()
    }
}

/// The range of the values with a margin on both sides, or `default` where there are none.
fn spread(values: impl Iterator<Item = f64>, default: Point, margin: f64) -> Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    let (low, high) = if low <= high { (low, high) } else { default };
    let width = if high > low { high - low } else { 1.0 };
    low - margin * width..high + margin * width
}

fn flat_curve(law: &Law, x: &Range<f64>) -> Vec<Point> {
    let at = |i: usize| x.start + (x.end - x.start) * i as f64 / (FLAT_POINTS - 1) as f64;
    let point = |x: f64| (x, law.at(x * law.range).traction / law.traction_max());
    (0..FLAT_POINTS).map(|i| point(at(i))).filter(|p| p.1.is_finite()).collect()
}

/// The states joined by lines, cut at the jumps and at the turn.
fn lines(states: &[&StateRecord], record: &LoopRecord, point: impl Fn(&StateRecord) -> Point, window: &Window) -> Vec<Line> {
    let mut lines: Vec<Line> = Vec::new();
    let near = |a: Point, b: Point| {
        let (w, h) = (window.x.end - window.x.start, window.y.end - window.y.start);
        (a.0 - b.0).abs() < THINNING * w && (a.1 - b.1).abs() < THINNING * h
    };
    for (i, pair) in states.windows(2).enumerate() {
        let (a, b) = (pair[0], pair[1]);
        if jumped(a, b, record) {
            continue;
        }
        let last = i + 2 == states.len() || jumped(b, states[i + 2], record) || states[i + 2].branch != b.branch;
        let starts = i == 0 || jumped(states[i - 1], a, record) || a.branch != b.branch;
        if starts {
            lines.push(Line { branch: b.branch, pattern: b.pattern, points: vec![point(a)] });
        }
        if let Some(line) = lines.last_mut() {
            let next = point(b);
            if last || line.points.last().is_none_or(|p| !near(*p, next)) {
                line.points.push(next);
            }
        }
    }
    lines
}

/// True if the surface jumped between two neighbours: they share one u0, or a recorded jump changed the pattern between them.
fn jumped(a: &StateRecord, b: &StateRecord, record: &LoopRecord) -> bool {
    let (low, high) = (a.mean_displacement.min(b.mean_displacement), a.mean_displacement.max(b.mean_displacement));
    let between = |u0: f64| (low..=high).contains(&u0);
    let recorded = || record.jumps.iter().any(|j| j.branch == b.branch && between(j.mean_displacement));
    a.branch == b.branch && (high - low == 0.0 || a.pattern != b.pattern) && recorded()
}

/// The area between approach and retraction as upright strips: stress is single valued on each branch but for its jumps.
fn loss(states: &[&StateRecord], point: impl Fn(&StateRecord) -> Point) -> Vec<Vec<Point>> {
    let turn = states.iter().position(|s| s.branch == Branch::Retraction).unwrap_or(states.len());
    let down: Vec<Point> = states[..turn].iter().map(|s| point(s)).collect();
    let up: Vec<Point> = states[turn.saturating_sub(1)..].iter().rev().map(|s| point(s)).collect();
    let mut strips = Vec::new();
    let mut strip: Vec<(Point, Point)> = Vec::new();
    let mut close = |strip: &mut Vec<(Point, Point)>| {
        if strip.len() > 1 {
            strips.push(strip.iter().map(|s| s.0).chain(strip.iter().rev().map(|s| s.1)).collect());
        }
        strip.clear();
    };
    for (a, b) in merged(&down, &up) {
        if (a.1 - b.1).abs() < 1e-6 {
            close(&mut strip);
        } else {
            strip.push((a, b));
        }
    }
    close(&mut strip);
    strips
}

/// Both descending curves at every x where either has a point (twice at a jump), the other one interpolated.
fn merged(down: &[Point], up: &[Point]) -> Vec<(Point, Point)> {
    let (mut i, mut j) = (0, 0);
    let mut pairs = Vec::new();
    while i < down.len() && j < up.len() {
        let (a, b) = (down[i], up[j]);
        let advance_down = a.0 > b.0 || (a.0 == b.0 && i + 1 < down.len() && down[i + 1].0 == a.0);
        if a.0 == b.0 {
            pairs.push((a, b));
        } else if a.0 > b.0 {
            pairs.push((a, (a.0, between(up, j, a.0))));
        } else {
            pairs.push(((b.0, between(down, i, b.0)), b));
        }
        if advance_down {
            i += 1;
        } else if a.0 < b.0 || (j + 1 < up.len() && up[j + 1].0 == b.0) {
            j += 1;
        } else {
            i += 1;
            j += 1;
        }
    }
    pairs
}

/// The value of a descending curve at `x`, just before its point `k`.
fn between(curve: &[Point], k: usize, x: f64) -> f64 {
    let Some(before) = k.checked_sub(1) else { return curve[k].1 };
    let (a, b) = (curve[before], curve[k]);
    if a.0 == b.0 { b.1 } else { a.1 + (b.1 - a.1) * (x - a.0) / (b.0 - a.0) }
}
