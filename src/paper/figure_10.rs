//! Fig. 10: pressure of the dimple in reduced units, for two ranges and for none.

use super::scenes::{self, decided, units_of};
use super::{Entry, Figure, Finding, Stopped, Task};
use crate::follow::atlas::{Atlas, Meshes};
use crate::physics::pattern::Pattern;
use crate::physics::theory::circular;
use crate::plot::panel::{Axis, Colour, Panel, Role, Series, Symbol};
use crate::plot::scale::steps;
use crate::scene::{Scene, Turn};

pub(super) const ENTRY: Entry = Entry {
    number: 10,
    title: "The dimple: p(u₀) tends to one curve as the range shrinks",
    look_for: "In units of the cell and the surface energy both ranges fall on nearly one curve, \
        that of an adhesion without range. Watch the dimple end: on the way up it stretches into a \
        ridge long before its own fold.",
    scene: scenes::figure_2,
    compute,
};

/// Points of a curve.
const POINTS: usize = 300;
/// Where the two ranges are held against the curve without range: both have a stable dimple there.
const COMPARED: [f64; 2] = [0.2, 0.33];

/// The stable dimple of a scene: its reduced range, and (u~, p~) by growing u~.
struct Branch {
    range: f64,
    points: Vec<[f64; 2]>,
}

fn dimple(scene: &Scene, points: usize, task: &mut Task<'_>) -> Result<Branch, Stopped> {
    let failed = |what: String| Stopped::Failed(format!("{}: {what}", scene.title));
    let model = decided(scene)?;
    let Turn::At(turn) = scene.drive.turn else {
        return Err(failed("turns at zero load".to_owned()));
    };
    task.tell(0.0, &scene.title)?;
    let mut atlas = Atlas::new(Meshes::new(&model.law, model.grid.length, points));
    atlas.obey(task.cancel);
    let cycle = atlas.cycle(scene.drive.start, turn);
    task.tell(1.0, &scene.title)?;
    cycle.map_err(|error| failed(error.to_string()))?;
    let known = atlas
        .branches()
        .iter()
        .find(|branch| branch.pattern == Pattern::Dimple);
    let branch = known.ok_or_else(|| failed("there is no dimple".to_owned()))?;
    let units = units_of(&model);
    let (low, high) = branch.extent();
    let points = steps(low, high, POINTS)
        .map(|u0| [units.reduce(u0), units.pressure(branch.at(u0).stress, u0)]);
    Ok(Branch {
        range: units.reduce(model.law.range),
        points: points.collect(),
    })
}

/// Largest deviation of p~ from the curve without range over [`COMPARED`].
fn deviation(branch: &Branch) -> f64 {
    let [low, high] = COMPARED;
    let compared = branch
        .points
        .iter()
        .filter(|p| (low..=high).contains(&p[0]));
    let deviation = |p: &[f64; 2]| {
        circular::dimple()
            .at(p[0])
            .map_or(f64::NAN, |s| (p[1] - s.pressure).abs())
    };
    compared.map(deviation).fold(f64::NAN, f64::max)
}

/// p~ next to the fold of the radial dimple, to leading order: p_c~ + c sqrt(u_c~ - u~), c from the
/// curve itself.
fn critical(fold: circular::State) -> Vec<[f64; 2]> {
    let step = 1e-3;
    let [before, after] = [-step, step].map(|d| circular::dimple().state(fold.size + d));
    let bend = (before.displacement - 2.0 * fold.displacement + after.displacement) / (step * step);
    let slope = (after.pressure - before.pressure) / (2.0 * step);
    let c = -slope * (-2.0 / bend).sqrt();
    let near = (0..=POINTS).map(|i| 0.1 * (i as f64 / POINTS as f64).powi(2));
    near.map(|d| [fold.displacement - d, fold.pressure + c * d.sqrt()])
        .collect()
}

fn compute(task: &mut Task<'_>) -> Result<Figure, Stopped> {
    let (small, large) = (scenes::figure_2(), scenes::figure_3());
    let wide = dimple(&small, 64, &mut task.part(0.0, 0.1))?;
    let narrow = dimple(&large, task.choose(192, 256), &mut task.part(0.1, 1.0))?;
    Ok(ENTRY.figure(
        vec![panel(&wide, &narrow)],
        words(&wide, &narrow),
        findings(&wide, &narrow),
    ))
}

/// u~ where the dimple ends.
fn end(branch: &Branch) -> f64 {
    branch.points.last().map_or(f64::NAN, |p| p[0])
}

/// The two ranges on the curve without range and its expansions.
fn panel(wide: &Branch, narrow: &Branch) -> Panel {
    let pattern = circular::dimple();
    let fold = pattern.fold();
    let exact = steps(0.02, fold.size, POINTS)
        .skip(1)
        .map(|size| pattern.state(size))
        .map(|s| [s.displacement, s.pressure])
        .collect();
    let power = |law: fn(f64) -> f64| steps(0.0, 0.5, POINTS).map(|u| [u, law(u)]).collect();
    let symbols = |branch: &Branch, symbol, colour| {
        let points = branch.points.iter().step_by(POINTS / 25).copied().collect();
        Series::symbols(&format!("ρ̃ = {:.4}", branch.range), symbol, colour, points)
    };
    Panel {
        x: Axis::linear("reduced displacement ũ₀").from_to(0.0, 0.5),
        y: Axis::linear("reduced pressure p̃").from_to(-0.9, 0.0),
        series: vec![
            Series::line(
                "no range, stable until the fold",
                Role::Theory,
                Colour::Ink,
                exact,
            ),
            Series::line(
                "small dimples, Eq. 29 corrected (1.793 ũ₀)",
                Role::Theory,
                Colour::Blue,
                power(circular::small_dimple_pressure),
            ),
            Series::line(
                "small dimples, Eq. 29 as printed (4 ũ₀/3)",
                Role::Printed,
                Colour::Blue,
                power(circular::small_dimple_pressure_printed),
            ),
            Series::line(
                "next to the fold",
                Role::Theory,
                Colour::Orange,
                critical(fold),
            ),
            symbols(wide, Symbol::Circle, Colour::Green),
            symbols(narrow, Symbol::Square, Colour::Red),
        ],
        ..Panel::default()
    }
}

fn words(wide: &Branch, narrow: &Branch) -> String {
    let (far, near) = (deviation(wide), deviation(narrow));
    let [low, high] = COMPARED;
    let pattern = circular::dimple();
    format!(
        "The dimple's pressure against displacement in reduced units, where an adhesion without \
         range has one curve for all cells. It is left by at most {far:.3} (ρ̃ = {:.4}) and \
         {near:.3} (ρ̃ = {:.4}) for {low} < ũ₀ < {high}. Small dimples follow p̃ = -(1.7930 \
         ũ₀)^(4/5); the paper prints 4/3 in place of 1.7930. Without range a round dimple has its \
         fold at ũ₀ = {:.4}, but stretches already at {:.3}; with range it ends at {:.3} and \
         {:.3}.",
        wide.range,
        narrow.range,
        pattern.fold().displacement,
        pattern.elliptic_limit().displacement,
        end(wide),
        end(narrow),
    )
}

fn findings(wide: &Branch, narrow: &Branch) -> Vec<Finding> {
    let (far, near) = (deviation(wide), deviation(narrow));
    let [low, high] = COMPARED;
    vec![
        Finding::new(
            format!(
                "largest |p̃ - exact| on {low} < ũ₀ < {high}, ρ̃ = {:.4}",
                wide.range
            ),
            far,
            0.0,
            "no range",
            None,
        ),
        Finding::new(
            format!(
                "the same, ρ̃ = {:.4}: less than three quarters of it",
                narrow.range
            ),
            near,
            0.0,
            "no range",
            Some(0.75 * far),
        ),
        Finding::new(
            format!("ũ₀ where the dimple ends, ρ̃ = {:.4}", narrow.range),
            end(narrow),
            circular::dimple().elliptic_limit().displacement,
            "it stretches, no range",
            None,
        ),
        Finding::new(
            "ũ₀ of the fold of a round dimple",
            circular::dimple().fold().displacement,
            0.4891,
            "radial fold, boundary elements",
            Some(2e-4),
        ),
    ]
}
