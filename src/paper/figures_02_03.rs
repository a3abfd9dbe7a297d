//! Figs 2 and 3: the loop of a square cell on flat ground, pressure over the largest traction
//! against u0/rho, with gap maps: in a cell of 256 ranges, with four patterns on the way, and in
//! one four times as long, where the bulge is missing.

use super::scenes::{self, planned};
use super::{Entry, Figure, Finding, Size, Stopped, Task};
use crate::follow::record::{Cause, Direction, JumpRecord, LoopRecord};
use crate::follow::run::{Landing, LoopRun};
use crate::physics::law::Law;
use crate::physics::pattern::{Island, Pattern, rolled, shift_to_middle};
use crate::physics::theory::flat_limits;
use crate::plot::curve::Curve;
use crate::plot::loop_panel;
use crate::plot::panel::{Axis, Colour, Content, Inset, Panel, Role, Series};
use crate::plot::scale::{ends, steps};
use crate::scene::{Model, Points, Scene};
use ndarray::Array2;

pub(super) const FIGURE_2: Entry = Entry {
    number: 2,
    title: "Four patterns: flat, bulge, ridge, dimple, flat",
    look_for: "On the way down the surface jumps to a bulge, a ridge, a dimple, and flat contact; \
        on the way up each pattern lives on beyond the place where it was born. The four shaded \
        areas between the two curves are energy that no slowness can save.",
    scene: scenes::figure_2,
    compute: figure_2,
};

pub(super) const FIGURE_3: Entry = Entry {
    number: 3,
    title: "A cell four times as long: no bulge, and more hysteresis",
    look_for: "The bulge is gone: the flat surface jumps straight to the ridge, from further away. \
        The areas are wider than in Fig. 2, and 3.5 times as much energy is lost per area.",
    scene: scenes::figure_3,
    compute: figure_3,
};

/// Points of the flat state's curve.
const POINTS: usize = 600;

fn figure_2(task: &mut Task<'_>) -> Result<Figure, Stopped> {
    let scene = scenes::figure_2();
    let (run, model) = planned(&scene, task, "the loop of Fig. 2")?;
    let findings = findings(&run, &model);
    let words = format!(
        "Mean pressure over the largest traction against mean displacement for L/ρ = 256 and \
         γ/(E*ρ) = 0.15: approach shows {}, retraction {}. All {} jumps are located on the \
         eigenvalue that vanishes; their releases add up to {:.4} γ, and so does the area between \
         the curves. The maps are the surfaces just after each jump of the approach.",
        chain(&run.record, Direction::Approach),
        chain(&run.record, Direction::Retraction),
        run.record.jumps.len(),
        run.record.released_energy_sum(),
    );
    let panels = vec![panel(&run, &model.law)];
    Ok(FIGURE_2.figure(panels, words, findings))
}

/// The scene on the mesh of `size`: the quick one has longer steps and still mu_rho below 0.45.
fn meshed(size: Size) -> Scene {
    let mut scene = scenes::figure_3();
    if size == Size::Quick {
        scene.cell.points = Points::Square(192);
        scene.drive.step = 0.2;
    }
    scene
}

fn figure_3(task: &mut Task<'_>) -> Result<Figure, Stopped> {
    let (small, _) = planned(
        &scenes::figure_2(),
        &mut task.part(0.0, 0.05),
        "the loop of Fig. 2",
    )?;
    let (run, model) = planned(
        &meshed(task.size),
        &mut task.part(0.05, 1.0),
        "the loop of Fig. 3",
    )?;
    let mut findings = findings(&run, &model);
    let ratio = run.record.released_energy_sum() / small.record.released_energy_sum();
    findings.push(Finding::new(
        "dissipated energy over that of Fig. 2",
        ratio,
        4.0,
        "\"a factor close to 4\", text at Fig. 3",
        None,
    ));
    let bulges = run
        .record
        .jumps
        .iter()
        .filter(|jump| jump.to == Pattern::Bulge)
        .count();
    findings.push(Finding::new(
        "jumps to a bulge",
        bulges as f64,
        0.0,
        "text at Fig. 3",
        Some(0.0),
    ));
    let words = format!(
        "As Fig. 2 with L/ρ = 1024: approach shows {}, retraction {}. The loss per area is {:.4} \
         γ, {ratio:.2} times that of Fig. 2 (the paper: close to 4).",
        chain(&run.record, Direction::Approach),
        chain(&run.record, Direction::Retraction),
        run.record.released_energy_sum(),
    );
    let panels = vec![panel(&run, &model.law)];
    Ok(FIGURE_3.figure(panels, words, findings))
}

/// The diagram of a loop as the paper draws it: pressure instead of stress, and gap maps.
fn panel(run: &LoopRun, law: &Law) -> Panel {
    let curve = Curve::of(&run.record, law);
    let (low, high) = ends(curve.points().map(|p| p[0]));
    let flat_curve =
        steps(low, high, POINTS).map(|u| [u, law.at(u * law.range).traction / law.traction_max()]);
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
fn findings(run: &LoopRun, model: &Model) -> Vec<Finding> {
    let (record, law) = (&run.record, &model.law);
    let mut findings = vec![Finding::new(
        "dissipated energy ∮σ du₀/γ",
        record.work() / law.surface_energy,
        record.released_energy_sum(),
        "sum of the energies released in the jumps",
        Some(5e-3 * record.released_energy_sum()),
    )];
    if let Some((lower, upper)) = flat_limits(law, model.grid.length) {
        for (branch, limit) in [(Direction::Approach, upper), (Direction::Retraction, lower)] {
            let left =
                |jump: &&JumpRecord| jump.direction == branch && jump.cause == Cause::FlatLimit;
            let found = record
                .jumps
                .iter()
                .find(left)
                .map_or(f64::NAN, |jump| jump.mean_displacement);
            findings.push(Finding::new(
                format!("u₀/ρ where the flat surface gives way on {branch}"),
                found / law.range,
                limit / law.range,
                "Eq. 8",
                Some(1e-3),
            ));
        }
    }
    findings
}

/// "flat, bulge, ridge, dimple, flat": the patterns of one branch in their order.
fn chain(record: &LoopRecord, direction: Direction) -> String {
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
