//! Fig. 9: the elastic energy of dimple and bulge at zero range.

use super::boundary_elements::{self, Estimate, unsolved};
use super::scenes;
use super::{Entry, Figure, Finding, Stopped, Task};
use crate::physics::theory::circular::{self, Kind, Pattern};
use crate::plot::panel::{Axis, Colour, Panel, Role, Series, Symbol};

pub(super) const ENTRY: Entry = Entry {
    number: 9,
    title: "Elastic energy of dimple and bulge at zero range",
    look_for: "Boundary elements fall on the lines, which are sums that meet the edges of the \
        patterns exactly. The printed limits (dashed) miss both: a dimple costs 3/(2α³), a bulge \
        (1 − α)/2.",
    scene: scenes::figure_2,
    compute,
};

/// Diameters in units of L of the patches that symbols show.
const SIZES: [f64; 9] = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9];

fn compute(task: &mut Task<'_>) -> Result<Figure, Stopped> {
    let dimples = elements(Kind::Dimple, &mut task.part(0.0, 0.5))?;
    let bulges = elements(Kind::Bulge, &mut task.part(0.5, 1.0))?;
    let panel = Panel {
        x: Axis::logarithmic("contact dimension 1 − α").from_to(0.02, 1.0),
        y: Axis::logarithmic("elastic energy v̂ (E* u₀²/L)").from_to(0.005, 3000.0),
        series: series(&dimples, &bulges),
        ..Panel::default()
    };
    let (fold, limit) = (circular::bulge().fold(), circular::bulge().elliptic_limit());
    let words = format!(
        "Elastic energy of a dimple (disc of diameter αL out of contact) and of a bulge (disc of \
         diameter (1 − α)L in contact) in a square cell, at zero range. Lines: displacement \
         (dimple) or stress (bulge) as a series that meets the edge exactly, summed over the \
         lattice, to eight digits. Symbols: boundary elements as in Sect. 3.2, averaged over radii \
         and extrapolated over three meshes; they agree within {:.1e}. Errata: Eq. 28 has 8/(√(3π) \
         α³) = 2.606/α³ for the dimple, right is 3/(2α³); and √2 (1−α)^(3/2) for the bulge, right \
         is (1−α)/2 (the printed line crosses the data where they are neither small nor large). \
         Contrary to the text after Eq. 29 the bulge is metastable at zero range: between ũ₀ = \
         {:.4}, below which it stretches to an ellipse, and {:.4}, above which it shrinks and lets \
         go.",
        largest(circular::dimple(), &dimples).max(largest(circular::bulge(), &bulges)),
        limit.displacement,
        fold.displacement,
    );
    let findings = findings(&dimples, &bulges);
    Ok(ENTRY.figure(vec![panel], words, findings))
}

/// vhat of discs of [`SIZES`] by boundary elements.
fn elements(kind: Kind, task: &mut Task<'_>) -> Result<Vec<(f64, Estimate)>, Stopped> {
    let mut found = Vec::with_capacity(SIZES.len());
    for (i, size) in SIZES.into_iter().enumerate() {
        task.tell(
            i as f64 / SIZES.len() as f64,
            "boundary elements on a square",
        )?;
        let points = task.choose(64, 128);
        let estimate = boundary_elements::disc_extrapolated(
            kind,
            size,
            points,
            task.choose(6, 10),
            task.cancel,
        );
        found.push((size, estimate.ok_or_else(|| unsolved(task, size))?));
    }
    Ok(found)
}

fn series(dimples: &[(f64, Estimate)], bulges: &[(f64, Estimate)]) -> Vec<Series> {
    let (dimple, bulge) = (circular::dimple(), circular::bulge());
    let symbols = |name: &str, symbol, colour, found: &[(f64, Estimate)], x: fn(f64) -> f64| {
        let points = found.iter().map(|(size, vhat)| [x(*size), vhat.value]);
        Series::symbols(name, symbol, colour, points.collect())
    };
    let (theory, printed) = (Role::Theory, Role::Printed);
    let (all, low) = ([0.021, 0.97], [0.021, 0.9]);
    vec![
        Series::curve("dimple", theory, Colour::Red, places(low), |abar| {
            dimple.elastic_energy(1.0 - abar)[0]
        }),
        Series::curve(
            "3/(2α³), Eq. 28 corrected",
            theory,
            Colour::Orange,
            places(low),
            |abar| circular::small_dimple(1.0 - abar),
        ),
        Series::curve(
            "dimple, Eq. 28 printed",
            printed,
            Colour::Red,
            places(low),
            |abar| circular::small_dimple_printed(1.0 - abar),
        ),
        Series::curve("bulge", theory, Colour::Blue, places(all), |abar| {
            bulge.elastic_energy(abar)[0]
        }),
        Series::curve(
            "(1 − α)/2, Eq. 28 corrected",
            theory,
            Colour::Teal,
            places(all),
            circular::small_bulge,
        ),
        Series::curve(
            "bulge, Eq. 28 printed",
            printed,
            Colour::Blue,
            places(all),
            circular::small_bulge_printed,
        ),
        symbols(
            "dimple, boundary elements",
            Symbol::Square,
            Colour::Red,
            dimples,
            |alpha| 1.0 - alpha,
        ),
        symbols(
            "bulge, boundary elements",
            Symbol::Diamond,
            Colour::Blue,
            bulges,
            |abar| abar,
        ),
    ]
}

/// Places from `low` to `high`, dense towards both ends of a logarithmic axis.
fn places([low, high]: [f64; 2]) -> impl Iterator<Item = f64> {
    // Equal steps of ln(x/(1 - x)).
    let [from, to] = [low, high].map(|x: f64| (x / (1.0 - x)).ln());
    (0..=200).map(move |i| 1.0 / (1.0 + (-from - (to - from) * f64::from(i) / 200.0).exp()))
}

/// Relative deviation from the series, the largest.
fn largest(pattern: &Pattern, found: &[(f64, Estimate)]) -> f64 {
    found
        .iter()
        .map(|(size, vhat)| (vhat.value / pattern.elastic_energy(*size)[0] - 1.0).abs())
        .fold(0.0, f64::max)
}

fn findings(dimples: &[(f64, Estimate)], bulges: &[(f64, Estimate)]) -> Vec<Finding> {
    let (dimple, bulge) = (circular::dimple(), circular::bulge());
    // Deviations in units of the error that the extrapolation states for itself.
    let worst = |pattern: &Pattern, found: &[(f64, Estimate)]| {
        let share = |(size, vhat): &(f64, Estimate)| {
            (vhat.value - pattern.elastic_energy(*size)[0]).abs() / vhat.error
        };
        found.iter().map(share).fold(0.0, f64::max)
    };
    let mut all = Vec::new();
    for (name, pattern, found) in [("dimple", dimple, dimples), ("bulge", bulge, bulges)] {
        let stated =
            format!("largest deviation of v̂ by boundary elements over its stated error, {name}");
        all.push(Finding::new(
            stated,
            worst(pattern, found),
            0.0,
            "series",
            Some(1.0),
        ));
        let relative = format!("largest relative deviation of v̂ by boundary elements, {name}");
        all.push(Finding::new(
            relative,
            largest(pattern, found),
            0.0,
            "series",
            Some(2e-3),
        ));
    }
    all.extend([
        Finding::new(
            "v̂ of a dimple, α = 0.7",
            dimple.elastic_energy(0.7)[0],
            3.954593912,
            "reference table",
            Some(2e-8),
        ),
        Finding::new(
            "v̂ of a bulge, 1 − α = 0.65",
            bulge.elastic_energy(0.65)[0],
            1.234144938,
            "reference table",
            Some(1e-8),
        ),
        Finding::new(
            "ũ₀ at the bulge's fold",
            bulge.fold().displacement,
            0.620288,
            "reference",
            Some(1e-6),
        ),
        Finding::new(
            "ũ₀ below which a bulge stretches",
            bulge.elliptic_limit().displacement,
            0.403,
            "reference",
            Some(1e-3),
        ),
        Finding::new(
            "ũ₀ at the dimple's fold",
            dimple.fold().displacement,
            0.4891,
            "reference",
            Some(2e-4),
        ),
        Finding::new(
            "ũ₀ above which a dimple stretches",
            dimple.elliptic_limit().displacement,
            0.399,
            "reference",
            Some(1e-3),
        ),
        Finding::new(
            "α³ v̂ of a small dimple",
            1.5,
            circular::small_dimple_printed(1.0),
            "printed in Eq. 28",
            None,
        ),
    ]);
    all
}
