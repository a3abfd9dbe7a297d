//! A loop on flat ground as the paper draws it in Figs 2 and 3: pressure over the largest traction against u0/rho, with gap maps.

use super::figure::{Area, Arrow, Axis, Colour, Content, Finding, Inset, Panel, Role, Series};
use super::task::{Stopped, Task};
use crate::experiment::plan::{self, Wish};
use crate::experiment::record::{Branch, Cause, LoopRecord};
use crate::experiment::run::{Landing, LoopRun, Report, run_planned};
use crate::experiment::scene::{Model, Scene};
use crate::paper::walked::{completed, refused};
use crate::physics::law::Law;
use crate::physics::pattern::Pattern;
use crate::physics::pattern::centre::{rolled, shift_to_middle};
use crate::physics::theory::flat;
use crate::solver::method::MethodKind;
use ndarray::Array2;

/// Points of the flat state's curve and of the edges of the areas.
const POINTS: usize = 600;
/// Curves closer than this share of the largest traction enclose no area worth drawing.
const CLOSE: f64 = 2e-3;

/// The closed loop of `scene` as planned.
pub(super) fn run(scene: &Scene, task: &mut Task<'_>, what: &str) -> Result<(LoopRun, Model), Stopped> {
    let model = scene.model().map_err(|error| refused(scene, error))?;
    let plan = plan::plan(scene, &model, Wish::Plan);
    let cancel = task.cancel.clone();
    let mut observe = |report: Report<'_>| {
        if let Report::State { fraction, .. } = report {
            // A request to stop ends the loop by itself.
            let _ = task.tell(fraction, what);
        }
    };
    let run = run_planned(scene, MethodKind::NewtonKrylov, &plan, &cancel, &mut observe).map_err(|error| refused(scene, error))?;
    Ok((completed(run, scene)?, model))
}

/// The diagram of a loop.
pub(super) fn panel(run: &LoopRun, law: &Law) -> Panel {
    let span = run.record.states.iter().map(|s| s.mean_displacement / law.range);
    let (low, high) = span.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), u| (a.min(u), b.max(u)));
    let points = |branch| curve(&run.record, branch, law);
    let flat_curve = (0..=POINTS).map(|i| low + (high - low) * i as f64 / POINTS as f64);
    let flat_curve = flat_curve.map(|u| [u, -law.at(u * law.range).traction / law.traction_max()]);
    Panel {
        x: Axis::linear("mean displacement u₀/ρ").from_to(0.0, high),
        // Room for the maps below.
        y: Axis::linear("mean pressure p/σ_max").from_to(-1.6, 0.1),
        areas: areas(&points(Branch::Approach), &points(Branch::Retraction)),
        series: vec![
            Series::line("flat surface", Role::Guide, Colour::Grey, flat_curve.collect()),
            Series::line("approach", Role::Simulation, Colour::Blue, points(Branch::Approach)),
            Series::line("retraction", Role::Simulation, Colour::Red, points(Branch::Retraction)),
        ],
        arrows: arrows(&run.record, law),
        insets: maps(&run.landings, law),
        ..Panel::default()
    }
}

/// The states of one branch by growing u0, broken at the jumps.
fn curve(record: &LoopRecord, branch: Branch, law: &Law) -> Vec<[f64; 2]> {
    let mut points: Vec<[f64; 2]> = Vec::new();
    let mut pattern = None;
    for state in record.states.iter().filter(|s| s.branch == branch) {
        if pattern.is_some_and(|before| before != state.pattern) {
            points.push([f64::NAN; 2]);
        }
        pattern = Some(state.pattern);
        points.push([state.mean_displacement / law.range, -state.stress_over_max]);
    }
    if branch == Branch::Approach {
        points.reverse();
    }
    points
}

/// The value of a broken curve at `x`; `None` outside and in gaps wider than a hair.
fn value(curve: &[[f64; 2]], x: f64) -> Option<f64> {
    let known = |pair: &[[f64; 2]]| pair[0][0] <= x && x <= pair[1][0] && pair[1][0] > pair[0][0];
    curve.windows(2).find(|pair| known(pair)).map(|pair| {
        let t = (x - pair[0][0]) / (pair[1][0] - pair[0][0]);
        pair[0][1] + t * (pair[1][1] - pair[0][1])
    })
}

/// The areas between the two curves: what is lost.
fn areas(approach: &[[f64; 2]], retraction: &[[f64; 2]]) -> Vec<Area> {
    let ends = approach.iter().map(|p| p[0]).filter(|u| u.is_finite());
    let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), u| (a.min(u), b.max(u)));
    let mut areas: Vec<Area> = Vec::new();
    let mut open = false;
    for i in 0..=POINTS {
        let u = low + (high - low) * i as f64 / POINTS as f64;
        // Next to a jump a curve may have a hole a hair wide: the area goes on.
        let (Some(a), Some(b)) = (value(approach, u), value(retraction, u)) else { continue };
        let apart = (a - b).abs() > CLOSE;
        if apart && !open {
            let name = if areas.is_empty() { "lost energy" } else { "" };
            areas.push(Area { name: name.to_owned(), colour: Colour::Gold, spans: Vec::new() });
        }
        open = apart;
        if apart && let Some(area) = areas.last_mut() {
            area.spans.push([u, a.min(b), a.max(b)]);
        }
    }
    areas
}

fn arrows(record: &LoopRecord, law: &Law) -> Vec<Arrow> {
    let arrow = |jump: &crate::experiment::record::JumpRecord| {
        let at = |stress: f64| [jump.mean_displacement / law.range, -stress / law.traction_max()];
        let dashed = jump.branch == Branch::Retraction;
        Arrow { tail: at(jump.stress_before), head: at(jump.stress_after), colour: Colour::Red, dashed }
    };
    record.jumps.iter().map(arrow).collect()
}

/// The paper's letter for a pattern of the approach.
fn letter(pattern: Pattern, first: bool) -> &'static str {
    match pattern {
        Pattern::Flat if first => "a",
        Pattern::Bulge => "b",
        Pattern::Ridge => "c",
        Pattern::Dimple => "d",
        _ => "e",
    }
}

/// The gap where each pattern of the approach was reached, by growing u0 along the upper edge.
fn maps(landings: &[Landing], law: &Law) -> Vec<Inset> {
    let approach: Vec<_> = landings.iter().filter(|landing| landing.branch == Branch::Approach).collect();
    let count = approach.len().max(1) as f64;
    let side = (0.8 / count).min(0.15);
    let inset = |(i, landing): (usize, &&Landing)| Inset {
        place: [0.02 + (count - 1.0 - i as f64) * 0.97 / count, 0.03, side, 1.6 * side],
        content: Content::Map {
            letter: letter(landing.pattern, i == 0).to_owned(),
            gap: upright(&landing.gap, landing.pattern, law),
        },
    };
    approach.iter().enumerate().map(inset).collect()
}

/// The pattern in the middle, a ridge along y.
fn upright(gap: &Array2<f64>, pattern: Pattern, law: &Law) -> Array2<f64> {
    let (dy, dx) = shift_to_middle(gap, pattern == Pattern::Dimple);
    let gap = rolled(gap, dy, dx);
    let across = |lanes: ndarray::iter::Lanes<'_, f64, ndarray::Ix1>| {
        lanes.into_iter().map(|lane| lane.iter().fold(0.0, |a: f64, g| a.max((g - lane[0]).abs()))).fold(0.0, f64::max)
    };
    let uniform_along_x = across(gap.rows()) < 1e-3 * law.range;
    if pattern == Pattern::Ridge && uniform_along_x { gap.reversed_axes() } else { gap }
}

/// The loop's numbers: its loss, which must be the sum of its releases, and the flat surface's limits, which must be Eq. 8.
pub(super) fn findings(run: &LoopRun, model: &Model) -> Vec<Finding> {
    let (record, law) = (&run.record, &model.law);
    let mut findings = vec![Finding {
        quantity: "dissipated energy ∮σ du₀/γ".to_owned(),
        found: record.work() / law.surface_energy,
        expected: record.released_energy_sum(),
        source: "sum of the energies released in the jumps".to_owned(),
        tolerance: Some(5e-3 * record.released_energy_sum()),
    }];
    if let Some((lower, upper)) = flat::limits(law, model.grid.length) {
        for (branch, limit) in [(Branch::Approach, upper), (Branch::Retraction, lower)] {
            let left = |jump: &&crate::experiment::record::JumpRecord| jump.branch == branch && jump.cause == Cause::FlatLimit;
            let found = record.jumps.iter().find(left).map_or(f64::NAN, |jump| jump.mean_displacement);
            findings.push(Finding {
                quantity: format!("u₀/ρ where the flat surface gives way on {branch}"),
                found: found / law.range,
                expected: limit / law.range,
                source: "Eq. 8".to_owned(),
                tolerance: Some(1e-3),
            });
        }
    }
    findings
}

/// "flat, bulge, ridge, dimple, flat": the patterns of one branch in their order.
pub(super) fn chain(record: &LoopRecord, branch: Branch) -> String {
    let jumps: Vec<_> = record.jumps.iter().filter(|jump| jump.branch == branch).collect();
    let words: Vec<_> =
        jumps.first().map(|jump| jump.from).into_iter().chain(jumps.iter().map(|jump| jump.to)).map(Pattern::word).collect();
    words.join(", ")
}
