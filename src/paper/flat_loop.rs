//! A loop on flat ground as the paper draws it in Figs 2 and 3: pressure over the largest traction
//! against u0/rho, with gap maps.

use super::figure::Finding;
use super::task::{Stopped, Task};
use crate::follow::record::{Cause, Direction, LoopRecord};
use crate::follow::run::{Landing, LoopRun, Report};
use crate::paper::walked::{completed, refused};
use crate::physics::law::Law;
use crate::physics::pattern::Pattern;
use crate::physics::pattern::{Island, rolled, shift_to_middle};
use crate::physics::theory::flat;
use crate::plot::curve::Curve;
use crate::plot::loop_panel;
use crate::plot::panel::{Axis, Colour, Content, Inset, Panel, Role, Series};
use crate::scene::{Model, Scene};
use crate::solver::methods::MethodKind;
use crate::study::plan::run_planned;
use crate::study::plan::{self};
use ndarray::Array2;

/// Points of the flat state's curve.
const POINTS: usize = 600;

/// The closed loop of `scene` as planned.
pub(super) fn run(
    scene: &Scene,
    task: &mut Task<'_>,
    what: &str,
) -> Result<(LoopRun, Model), Stopped> {
    let model = scene.model().map_err(|error| refused(scene, error))?;
    let plan = plan::plan(scene, &model, None);
    let cancel = task.cancel.clone();
    let mut observe = |report: Report<'_>| {
        if let Report::State { fraction, .. } = report {
            // A request to stop ends the loop by itself.
            let _ = task.tell(fraction, what);
        }
    };
    let run = run_planned(
        scene,
        MethodKind::NewtonKrylov,
        &plan,
        &cancel,
        &mut observe,
    )
    .map_err(|error| refused(scene, error))?;
    Ok((completed(run, scene)?, model))
}

/// The diagram of a loop as the paper draws it: pressure instead of stress, and gap maps.
pub(super) fn panel(run: &LoopRun, law: &Law) -> Panel {
    let curve = Curve::of(&run.record, law);
    let ends = curve.points().map(|p| p[0]);
    let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), u| {
        (a.min(u), b.max(u))
    });
    let flat_curve = (0..=POINTS).map(|i| low + (high - low) * i as f64 / POINTS as f64);
    let flat_curve = flat_curve.map(|u| [u, law.at(u * law.range).traction / law.traction_max()]);
    let flat = Series::line(
        "flat surface",
        Role::Guide,
        Colour::FLAT,
        flat_curve.collect(),
    );
    let loop_ = Panel {
        areas: loop_panel::loss(&curve),
        series: std::iter::once(flat)
            .chain(loop_panel::branches(&curve))
            .collect(),
        arrows: loop_panel::jumps(&run.record.jumps, law),
        ..Panel::default()
    };
    Panel {
        x: Axis::linear("mean displacement u₀/ρ").from_to(0.0, high),
        // Room for the maps below.
        y: Axis::linear("mean pressure p/σ_max").from_to(-1.6, 0.1),
        insets: maps(&run.landings, law),
        ..upside_down(loop_)
    }
}

/// The diagram with -y for y.
fn upside_down(mut panel: Panel) -> Panel {
    for point in panel
        .series
        .iter_mut()
        .flat_map(|series| &mut series.points)
    {
        point[1] = -point[1];
    }
    for span in panel.areas.iter_mut().flat_map(|area| &mut area.spans) {
        *span = [span[0], -span[2], -span[1]];
    }
    for arrow in &mut panel.arrows {
        (arrow.tail[1], arrow.head[1]) = (-arrow.tail[1], -arrow.head[1]);
    }
    panel
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
    let approach: Vec<_> = landings
        .iter()
        .filter(|landing| landing.direction == Direction::Approach)
        .collect();
    let count = approach.len().max(1) as f64;
    let side = (0.8 / count).min(0.15);
    let inset = |(i, landing): (usize, &&Landing)| Inset {
        place: [
            0.02 + (count - 1.0 - i as f64) * 0.97 / count,
            0.03,
            side,
            1.6 * side,
        ],
        content: Content::Map {
            letter: letter(landing.pattern, i == 0).to_owned(),
            gap: upright(&landing.gap, landing.pattern, law),
        },
    };
    approach.iter().enumerate().map(inset).collect()
}

/// The pattern in the middle, a ridge along y.
fn upright(gap: &Array2<f64>, pattern: Pattern, law: &Law) -> Array2<f64> {
    let island = match pattern {
        Pattern::Dimple => Island::Hole,
        _ => Island::Contact,
    };
    let (dy, dx) = shift_to_middle(gap, island);
    let gap = rolled(gap, dy, dx);
    let across = |lanes: ndarray::iter::Lanes<'_, f64, ndarray::Ix1>| {
        lanes
            .into_iter()
            .map(|lane| {
                lane.iter()
                    .fold(0.0, |a: f64, g| a.max((g - lane[0]).abs()))
            })
            .fold(0.0, f64::max)
    };
    let uniform_along_x = across(gap.rows()) < 1e-3 * law.range;
    if pattern == Pattern::Ridge && uniform_along_x {
        gap.reversed_axes()
    } else {
        gap
    }
}

/// The loop's numbers: its loss, which must be the sum of its releases, and the flat surface's
/// limits, which must be Eq. 8.
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
        for (branch, limit) in [(Direction::Approach, upper), (Direction::Retraction, lower)] {
            let left = |jump: &&crate::follow::record::JumpRecord| {
                jump.direction == branch && jump.cause == Cause::FlatLimit
            };
            let found = record
                .jumps
                .iter()
                .find(left)
                .map_or(f64::NAN, |jump| jump.mean_displacement);
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
pub(super) fn chain(record: &LoopRecord, direction: Direction) -> String {
    let jumps: Vec<_> = record
        .jumps
        .iter()
        .filter(|jump| jump.direction == direction)
        .collect();
    let words: Vec<_> = jumps
        .first()
        .map(|jump| jump.from)
        .into_iter()
        .chain(jumps.iter().map(|jump| jump.to))
        .map(Pattern::word)
        .collect();
    words.join(", ")
}
