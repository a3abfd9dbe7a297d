//! Fig. 6: the width of a ridge at zero range against displacement.

use super::boundary_elements::ridge_slopes;
use super::scenes;
use super::{Entry, Figure, Finding, Stopped, Task};
use crate::physics::theory::ridge::{self, Critical, FLATTENING_PRINTED};
use crate::plot::panel::{Axis, Colour, Panel, Role, Series, Symbol};
use crate::plot::scale::steps;

pub(super) const ENTRY: Entry = Entry {
    number: 6,
    title: "Width of a ridge at zero range",
    look_for: "Pulling opens the gap beside the ridge faster and faster, until at u₀ = 0.6656 \
        (γL/E*)^½ a tenth of the cell still sticks and the ridge flattens. The cube-root law of a \
        thick ridge is off by less than a tenth all the way.",
    scene: scenes::ridge_line,
    compute,
};

/// Points of the mesh whose refinements give the slopes.
const POINTS: usize = 256;

fn compute(task: &mut Task<'_>) -> Result<Figure, Stopped> {
    let step = task.choose(16, 8);
    let free = (24..=224).step_by(step).chain([230, 232]);
    let slopes = ridge_slopes(POINTS, free, task)?;
    // Eq. 17 with ahat' = -1.
    let found: Vec<[f64; 2]> = slopes
        .iter()
        .map(|(alpha, slope)| [1.0 / (-slope.value).sqrt(), *alpha])
        .collect();
    let worst = found
        .iter()
        .map(|[u, alpha]| (exact(*u) - alpha).abs())
        .fold(0.0, f64::max);
    let thick = thick_error();
    Ok(ENTRY.figure(
        vec![panel(found)],
        words(worst, thick),
        findings(worst, thick),
    ))
}

/// α of the exact ridge.
fn exact(u: f64) -> f64 {
    ridge::alpha(u).unwrap_or(f64::NAN)
}

/// Largest relative error of Eq. 23 up to the end of the ridge.
fn thick_error() -> f64 {
    let end = ridge::critical().displacement;
    let cube_root = |u: f64| (ridge::thick_alpha(u) / exact(u) - 1.0).abs();
    let reached = steps(0.0, end, 600).skip(1);
    reached.map(cube_root).fold(0.0, f64::max)
}

/// The exact ridge, its expansions, and the points `found` by boundary elements.
fn panel(found: Vec<[f64; 2]>) -> Panel {
    let end = ridge::critical();
    let expansion = |point: Critical| move |u: f64| point.alpha_at(u);
    Panel {
        x: Axis::linear("ũ₀ = u₀/(γL/E*)^½").from_to(0.0, 0.7),
        y: Axis::linear("α (share of the cell out of contact)").from_to(0.0, 1.0),
        series: vec![
            Series::curve(
                "exact",
                Role::Theory,
                Colour::Ink,
                places([0.0, end.displacement]),
                exact,
            ),
            Series::curve(
                "thick, Eq. 23",
                Role::Theory,
                Colour::Blue,
                places([0.0, 0.7]),
                ridge::thick_alpha,
            ),
            Series::curve(
                "flattening, Eq. 24 corrected",
                Role::Theory,
                Colour::Orange,
                places([0.5, end.displacement]),
                expansion(end),
            ),
            Series::curve(
                "flattening, Eq. 24 printed",
                Role::Printed,
                Colour::Orange,
                places([0.5, (-1.0 / FLATTENING_PRINTED.elastic_energy[1]).sqrt()]),
                expansion(FLATTENING_PRINTED),
            ),
            Series::symbols("boundary elements", Symbol::Circle, Colour::Ink, found),
        ],
        ..Panel::default()
    }
}

fn words(worst: f64, thick: f64) -> String {
    format!(
        "Share of the cell out of contact against displacement, at zero range. Symbols: Eq. 17 \
         with slopes of v̂ by boundary elements; they agree with the exact curve to {worst:.0e} in \
         α. Eq. 23 for a thick ridge is right and off by at most {:.1} % up to the end at ũ_c = \
         {:.6}. Erratum: Eq. 24 with v̂‴ = −145 (dashed) draws the parabola 5 % too narrow; \
         −131.92 is right.",
        100.0 * thick,
        ridge::critical().displacement,
    )
}

fn findings(worst: f64, thick: f64) -> Vec<Finding> {
    let end = ridge::critical();
    vec![
        Finding::new(
            "largest deviation of α by boundary elements",
            worst,
            0.0,
            "exact ridge",
            Some(1e-3),
        ),
        Finding::new(
            "α of the exact ridge at ũ₀ = 0.55",
            exact(0.55),
            0.7431812343,
            "reference table",
            Some(1e-9),
        ),
        Finding::new(
            "ũ_c",
            end.displacement,
            FLATTENING_PRINTED.displacement,
            "printed after Eq. 24",
            Some(1e-4),
        ),
        Finding::new(
            "α_c",
            end.alpha,
            FLATTENING_PRINTED.alpha,
            "printed before Eq. 24",
            None,
        ),
        Finding::new(
            "largest relative error of Eq. 23",
            thick,
            0.0,
            "exact ridge",
            None,
        ),
    ]
}

/// Places that crowd towards their upper end, where slopes are infinite.
fn places([low, high]: [f64; 2]) -> impl Iterator<Item = f64> {
    (0..=200).map(move |i| high - (high - low) * (1.0 - f64::from(i) / 200.0).powi(2))
}
