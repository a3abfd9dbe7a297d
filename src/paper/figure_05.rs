//! Fig. 5: the elastic energy of a ridge at zero range.

use super::boundary_elements::{Sample, ridge_energies, ridge_slopes};
use super::scenes;
use super::{Entry, Figure, Finding, Stopped, Task};
use crate::physics::theory::ridge::{
    self, FLATTENING_PRINTED, THIN_CONSTANT, THIN_CONSTANT_PRINTED,
};
use crate::plot::panel::{Axis, Colour, Content, Inset, Panel, Role, Series, Symbol};

pub(super) const ENTRY: Entry = Entry {
    number: 5,
    title: "Elastic energy of a ridge at zero range",
    look_for: "Boundary elements fall on the exact curve, which joins the two limits of a thick \
        and a thin ridge. In the inset the slope has a maximum: there a thin ridge flattens.",
    scene: scenes::ridge_line,
    compute,
};

/// Points of the mesh whose refinements give the slopes of the inset.
const POINTS: usize = 512;

fn compute(task: &mut Task<'_>) -> Result<Figure, Stopped> {
    let energies = ridge_energies(task.choose(15, 25), &mut task.part(0.0, 0.4))?;
    let step = task.choose(6, 4);
    let slopes = ridge_slopes(POINTS, (448..=484).step_by(step), &mut task.part(0.4, 1.0))?;
    let panel = Panel {
        x: Axis::logarithmic("1 − α (share of the cell in contact)").from_to(0.01, 1.0),
        y: Axis::logarithmic("elastic energy v̂ (E* u₀²/L)").from_to(0.15, 300.0),
        series: lines()
            .into_iter()
            .chain([symbols("boundary elements", &energies, |alpha| 1.0 - alpha)])
            .collect(),
        insets: vec![Inset {
            place: [0.08, 0.52, 0.42, 0.42],
            content: Content::Diagram(Box::new(inset(&slopes))),
        }],
        ..Panel::default()
    };
    let findings = findings(&energies, &slopes);
    let words = format!(
        "Elastic energy of a contact ridge (line cell, zero range) against the share of the cell \
         in contact. Symbols: boundary elements as in Sect. 3.2, extrapolated over {} meshes; they \
         agree with the exact −π/(4 ln cos(πα/2)) to {:.0e}. Erratum: Eq. 22 for the thin ridge \
         should read −π/(4 ln(π(1−α)) − 8c) with c = ln(2)/2 = 0.3466, not 0.3079: the appendix \
         takes a stress that vanishes at the edges, where it is infinite. (With ln(πα) and +8c, as \
         printed, the energy would be negative; the dashed line is Eq. A7.) The inset shows the \
         slope next to its maximum α_c = 0.91006, where the printed expansion has v̂_c = 0.420 for \
         0.4006 and v̂''' = −145 for −131.9.",
        task.choose(4, 5),
        largest(&energies),
    );
    Ok(ENTRY.figure(vec![panel], words, findings))
}

/// Places from `low` to `high` in equal ratios.
fn places([low, high]: [f64; 2]) -> impl Iterator<Item = f64> {
    (0..=200).map(move |i| low * (high / low).powf(f64::from(i) / 200.0))
}

fn lines() -> Vec<Series> {
    let thin = |c| move |abar: f64| ridge::thin(abar, c);
    vec![
        Series::curve(
            "exact",
            Role::Theory,
            Colour::Ink,
            places([0.01, 0.95]),
            |abar| ridge::elastic_energy(1.0 - abar)[0],
        ),
        Series::curve(
            "thick, Eq. 22",
            Role::Theory,
            Colour::Blue,
            places([0.01, 0.95]),
            |abar| ridge::thick(1.0 - abar),
        ),
        Series::curve(
            "thin, Eq. 22 corrected",
            Role::Theory,
            Colour::Red,
            places([0.01, 0.45]),
            thin(THIN_CONSTANT),
        ),
        Series::curve(
            "thin, Eq. A7 printed",
            Role::Printed,
            Colour::Red,
            places([0.01, 0.45]),
            thin(THIN_CONSTANT_PRINTED),
        ),
    ]
}

fn symbols(name: &str, samples: &[Sample], x: impl Fn(f64) -> f64) -> Series {
    let points = samples
        .iter()
        .map(|(alpha, found)| [x(*alpha), found.value]);
    Series::symbols(name, Symbol::Circle, Colour::Ink, points.collect())
}

fn inset(slopes: &[Sample]) -> Panel {
    let range = [0.87, 0.95];
    let right = ridge::critical();
    Panel {
        x: Axis::linear("α").from_to(range[0], range[1]),
        y: Axis::linear("v̂′").from_to(-2.42, -2.24),
        series: vec![
            Series::curve("", Role::Theory, Colour::Ink, places(range), |alpha| {
                ridge::elastic_energy(alpha)[1]
            }),
            Series::curve(
                "third order, corrected",
                Role::Theory,
                Colour::Orange,
                places(range),
                |alpha| right.slope_at(alpha),
            ),
            Series::curve(
                "third order, printed",
                Role::Printed,
                Colour::Orange,
                places(range),
                |alpha| FLATTENING_PRINTED.slope_at(alpha),
            ),
            symbols("", slopes, |alpha| alpha),
        ],
        ..Panel::default()
    }
}

/// The largest relative deviation from the exact energy.
fn largest(energies: &[Sample]) -> f64 {
    energies
        .iter()
        .map(|(alpha, found)| (found.value / ridge::elastic_energy(*alpha)[0] - 1.0).abs())
        .fold(0.0, f64::max)
}

fn findings(energies: &[Sample], slopes: &[Sample]) -> Vec<Finding> {
    let exact = ridge::critical();
    let (alpha, top) = vertex(slopes);
    vec![
        Finding::new(
            "largest relative deviation of v̂ by boundary elements",
            largest(energies),
            0.0,
            "exact ridge",
            Some(1e-4),
        ),
        Finding::new(
            "α_c, largest v̂′ by boundary elements",
            alpha,
            exact.alpha,
            "exact ridge",
            Some(1e-3),
        ),
        Finding::new(
            "v̂′_c by boundary elements",
            top,
            exact.elastic_energy[1],
            "exact ridge",
            Some(1e-3),
        ),
        Finding::new(
            "v̂_c",
            exact.elastic_energy[0],
            FLATTENING_PRINTED.elastic_energy[0],
            "printed before Eq. 24",
            None,
        ),
        Finding::new(
            "v̂‴_c",
            exact.elastic_energy[3],
            FLATTENING_PRINTED.elastic_energy[3],
            "printed before Eq. 24",
            None,
        ),
        Finding::new(
            "c of the thin ridge",
            THIN_CONSTANT,
            THIN_CONSTANT_PRINTED,
            "printed in Eq. 22",
            None,
        ),
    ]
}

/// Place and height of the maximum: the vertex of the parabola through the highest sample and its
/// neighbours.
fn vertex(samples: &[Sample]) -> (f64, f64) {
    let p: Vec<[f64; 2]> = samples
        .iter()
        .map(|(alpha, found)| [*alpha, found.value])
        .collect();
    let top = (0..p.len())
        .max_by(|a, b| p[*a][1].total_cmp(&p[*b][1]))
        .unwrap_or(0)
        .clamp(1, p.len() - 2);
    let [[x0, y0], [x1, y1], [x2, y2]] = [p[top - 1], p[top], p[top + 1]];
    let (first, second) = ((y1 - y0) / (x1 - x0), (y2 - y1) / (x2 - x1));
    let curvature = (second - first) / (x2 - x0);
    let x = 0.5 * (x0 + x1) - 0.5 * first / curvature;
    (x, y0 + (x - x0) * (first + (x - x1) * curvature))
}
