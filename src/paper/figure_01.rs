//! Fig. 1: the model from the side, drawn from a solved state.

use super::scenes::{self, decided, seen};
use super::{Entry, Figure, Finding, Stopped, Task};
use crate::follow::record::Direction;
use crate::follow::walk::WalkOptions;
use crate::physics::indenter::{Hertz, Indenter};
use crate::physics::mesh::Grid;
use crate::plot::panel::{Along, Area, Arrow, Axis, Colour, Label, Panel, Role, Series};
use crate::plot::scale::ends;

pub(super) const ENTRY: Entry = Entry {
    number: 1,
    title: "The model: an elastomer above a rigid indenter",
    look_for: "The elastomer's lower surface u bends freely, only its mean u0 is prescribed. The \
        gap g = u - h decides how strongly each point is pulled or pushed.",
    scene: scenes::figure_1,
    compute,
};

/// The surface at one state.
#[derive(Default)]
struct Profile {
    mean_displacement: f64,
    stress: f64,
    gap: Vec<f64>,
}

fn compute(task: &mut Task<'_>) -> Result<Figure, Stopped> {
    let scene = scenes::figure_1();
    let (grid, profile) = strongest_pull(task)?;
    let Some(height) = scene.indenter.height(&grid) else {
        return Err(Stopped::Failed("the ground is flat".to_owned()));
    };
    let place = |i: usize| i as f64 * grid.spacing() - 0.5 * grid.length;
    let mut rows: Vec<_> = profile
        .gap
        .iter()
        .zip(&height)
        .enumerate()
        .map(|(i, (g, h))| [place(i), *h, h + g])
        .collect();
    let mean = rows.iter().map(|row| row[2]).sum::<f64>() / rows.len() as f64;
    let law = decided(&scene)?.law;
    let traction = profile.gap.iter().map(|g| law.at(*g).traction).sum::<f64>() / rows.len() as f64;
    // The cell closes on itself.
    rows.push([0.5 * grid.length, rows[0][1], rows[0][2]]);
    let findings = vec![
        Finding::new(
            "mean of the drawn surface",
            mean,
            profile.mean_displacement,
            "the prescribed u0",
            Some(1e-9),
        ),
        Finding::new(
            "mean stress/E*",
            profile.stress,
            traction,
            "mean of the law's traction over the drawn gap",
            Some(1e-9),
        ),
    ];
    let words = format!(
        "A solved state, not a sketch: a periodic row of cylinders of radius R pulls an elastomer \
         of period L = 2R, γ = {} E*R and ρ = {} R, at the largest mean stress of its retraction. \
         u₀ is the mean of the lower surface, measured from the indenter's highest point.",
        law.surface_energy / radius(&scene.indenter),
        law.range / radius(&scene.indenter),
    );
    Ok(ENTRY.figure(vec![panel(&rows, mean)], words, findings))
}

fn radius(indenter: &Indenter) -> f64 {
    match indenter {
        Indenter::Hertz(Hertz { radius }) => *radius,
        _ => f64::NAN,
    }
}

/// The state of largest mean stress on retraction.
fn strongest_pull(task: &mut Task<'_>) -> Result<(Grid, Profile), Stopped> {
    let (scene, mut best) = (scenes::figure_1(), Profile::default());
    seen(&scene, WalkOptions::default(), task, &mut |record, gap| {
        if record.direction == Direction::Retraction && record.stress > best.stress {
            best = Profile {
                mean_displacement: record.mean_displacement,
                stress: record.stress,
                gap: gap.iter().copied().collect(),
            };
        }
    })?;
    let model = decided(&scene)?;
    Ok((model.grid, best))
}

/// `rows`: x, height of the indenter, height of the elastomer's surface.
fn panel(rows: &[[f64; 3]], mean: f64) -> Panel {
    let extent = |k: usize| ends(rows.iter().map(|row| row[k]));
    let ((left, right), (low, _), (_, high)) = (extent(0), extent(1), extent(2));
    let (bottom, top) = (low - 0.6, high + 1.2);
    let line = |k: usize| {
        let points = rows.iter().map(|row| [row[0], row[k]]);
        Series::line("", Role::Theory, Colour::Ink, points.collect())
    };
    let guide = |y: f64| {
        let points = vec![[left, y], [right, y]];
        Series::line("", Role::Guide, Colour::Grey, points)
    };
    // Half way out, where the gap is wide.
    let at = rows[rows.len() * 13 / 16];
    let middle = 0.5 * (at[1] + at[2]);
    let arrow = |x: f64, from: f64, to: f64| Arrow {
        name: "",
        tail: [x, from],
        head: [x, to],
        colour: Colour::Ink,
        direction: Direction::Approach,
    };
    let label = |x: f64, y: f64, text: &str| Label {
        at: [x, y],
        text: text.to_owned(),
        ..Label::default()
    };
    let area = |colour, spans| Area {
        name: String::new(),
        colour,
        spans,
        along: Along::X,
    };
    Panel {
        x: Axis::linear("x").from_to(left, right),
        y: Axis::linear("height above the crest").from_to(bottom, top),
        areas: vec![
            area(
                Colour::Blue,
                rows.iter().map(|row| [row[0], row[2], top]).collect(),
            ),
            area(
                Colour::Grey,
                rows.iter().map(|row| [row[0], bottom, row[1]]).collect(),
            ),
        ],
        series: vec![line(1), line(2), guide(mean), guide(0.0)],
        arrows: vec![
            arrow(at[0], middle, at[1]),
            arrow(at[0], middle, at[2]),
            arrow(0.8 * left, 0.0, mean),
            arrow(0.8 * left, mean, 0.0),
        ],
        labels: vec![
            label(0.0, high + 0.6, "elastomer"),
            label(0.0, 0.5 * low - 0.3, "rigid indenter"),
            label(at[0] + 0.25, middle, "g"),
            label(0.8 * left - 0.5, 0.5 * mean, "u0"),
        ],
        ..Panel::default()
    }
}
