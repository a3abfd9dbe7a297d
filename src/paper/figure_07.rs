//! Fig. 7: the ridge alone, for two ranges of adhesion, against the ridge of zero range.

use super::scenes::{ends, line_cell, on_part, ridges, thinned, units};
use super::{Entry, Figure, Finding, Stopped, Task};
use crate::follow::record::Direction;
use crate::follow::run::LoopRun;
use crate::physics::theory::ridge::{self, FLATTENING_PRINTED};
use crate::plot::panel::{Arrow, Axis, Colour, Panel, Role, Series, Symbol};
use crate::scene::{Part, Scene};
use std::f64::consts::PI;

pub(super) const ENTRY: Entry = Entry {
    number: 7,
    title: "The ridge alone, for two ranges of adhesion",
    look_for: "Between its ends the ridge follows one curve, whatever the range: that of an \
        adhesion without range. The shorter the range, the further down it lives and the nearer it \
        comes to that curve's end.",
    scene: || loop_of(1024.0, 512, 0.1),
    compute,
};

/// Cells of the paper in ranges, and what they are called.
const CELLS: [(f64, &str); 2] = [(256.0, "ρ̃ = 0.1614"), (1024.0, "ρ̃ = 0.0807")];
/// The middle part of the stable ridge (u~), away from the ends at which the range counts.
const MIDDLE: [f64; 2] = [0.3, 0.5];

/// The whole loop, in steps of `step` ranges.
fn loop_of(length: f64, points: usize, step: f64) -> Scene {
    let range = units(length).reduce(1.0);
    line_cell(
        &format!("Fig. 7: a line cell of {length} ranges"),
        length,
        points,
        [0.75, 0.15 * range, step * range],
    )
}

fn compute(task: &mut Task<'_>) -> Result<Figure, Stopped> {
    let (mut series, mut arrows, mut findings) = (lines(), Vec::new(), Vec::new());
    let mut middle = Vec::new();
    let looks = [
        (Colour::Green, Symbol::Circle, Symbol::Cross),
        (Colour::Red, Symbol::Square, Symbol::Triangle),
    ];
    for (i, ((length, name), (colour, down, up))) in CELLS.into_iter().zip(looks).enumerate() {
        let (points, step) = task.choose((length / 4.0, 0.1), (length, 0.05));
        let run = on_part(
            &loop_of(length, points as usize, step),
            Part::Whole,
            &mut task.part(0.5 * i as f64, 0.5 + 0.5 * i as f64),
        )?;
        let units = units(length);
        let (approach, retraction) = (
            ridges(&run, &units, Direction::Approach),
            ridges(&run, &units, Direction::Retraction),
        );
        let deviation = approach
            .iter()
            .chain(&retraction)
            .map(|p| deviation(*p))
            .fold(0.0, f64::max);
        middle.push(deviation);
        findings.extend(judged(
            name,
            units.reduce(1.0),
            deviation,
            ends(&run, &units),
        ));
        arrows.extend(jumps(&run, length, colour));
        series.push(Series::symbols(
            &format!("{name}, approach"),
            down,
            colour,
            thinned(approach, 0.015),
        ));
        series.push(Series::symbols(
            &format!("{name}, retraction"),
            up,
            colour,
            thinned(retraction, 0.015),
        ));
    }
    findings.extend(printed());
    let panel = Panel {
        x: Axis::linear("ũ₀ = u₀/(γL/E*)^½").from_to(0.0, 0.7),
        y: Axis::linear("p̃ = p u₀/γ").from_to(-0.62, 0.05),
        series,
        arrows,
        ..Panel::default()
    };
    Ok(ENTRY.figure(
        vec![panel],
        format!(
            "Loops on line cells, in which dimples and bulges have no room. For {} ≤ ũ₀ ≤ {} the \
             pressure p̃ differs from the exact ridge without range by at most {:.4} for ρ̃ = \
             0.1614 and {:.4} for ρ̃ = 0.0807: with half the range the difference falls to {:.2} \
             of what it was. It should fall as ρ̃², as the length of the cohesive zone does. In \
             place of the paper's dashed line, read off simulations, stands the closed form v̂ = \
             −π/(4 ln cos(πα/2)). Erratum: Eq. 27 is printed with p̃_c = −0.3937 and p̃^(1/2) = \
             −0.360; right are −0.3550 and −0.6413 (the root of −2/u″ is missing). The right line \
             is within 1 % of the curve for ũ₀ > 0.655; the printed one runs along it for 0.57 < \
             ũ₀ < 0.64, like a fit, and misses its end by 11 %.",
            MIDDLE[0],
            MIDDLE[1],
            middle[0],
            middle[1],
            middle[1] / middle[0]
        ),
        findings,
    ))
}

/// |p~ - p~ of the exact ridge| in the middle part, zero elsewhere.
fn deviation([u, p]: [f64; 2]) -> f64 {
    let exact = (MIDDLE[0]..=MIDDLE[1])
        .contains(&u)
        .then(|| ridge::pressure(u))
        .flatten();
    exact.map_or(0.0, |exact| (p - exact).abs())
}

fn judged(name: &str, range: f64, deviation: f64, ends: Option<[f64; 2]>) -> Vec<Finding> {
    let [low, high] = ends.unwrap_or([f64::NAN; 2]);
    let finding = |quantity: String, found, expected, tolerance| {
        Finding::new(
            quantity,
            found,
            expected,
            "exact ridge, no range",
            tolerance,
        )
    };
    let end = ridge::critical().displacement;
    // A cohesive zone is as long as a few rho~^2 of the cell, and so are its effects; at the ends
    // only once the range is short.
    vec![
        finding(
            format!(
                "largest |p̃ - exact| on {} ≤ ũ₀ ≤ {}, {name}",
                MIDDLE[0], MIDDLE[1]
            ),
            deviation,
            0.0,
            Some(range * range),
        ),
        finding(
            format!("ũ₀ where the ridge flattens on retraction, {name}"),
            high,
            end,
            (range < 0.1).then_some(range * range),
        ),
        finding(
            format!("ũ₀ where the ridge closes on approach, {name}"),
            low,
            0.0,
            None,
        ),
    ]
}

/// What is printed at Eq. 27.
fn printed() -> Vec<Finding> {
    let end = ridge::critical();
    let values = [
        ("p̃_c", end.pressure, FLATTENING_PRINTED.pressure),
        (
            "p̃^(1/2)",
            end.pressure_root,
            FLATTENING_PRINTED.pressure_root,
        ),
    ];
    let finding = |(name, found, expected): (&str, f64, f64)| {
        Finding::new(
            format!("{name} where the ridge flattens"),
            found,
            expected,
            "printed at Eq. 27",
            None,
        )
    };
    values.into_iter().map(finding).collect()
}

fn lines() -> Vec<Series> {
    let end = ridge::critical();
    let over = |from: f64, to: f64, p: &dyn Fn(f64) -> f64| -> Vec<[f64; 2]> {
        // Denser towards both ends, where the curves are steep.
        let u = |i: i32| from + (to - from) * (0.5 * PI * f64::from(i) / 120.0).sin().powi(2);
        (0..=120).map(u).map(|u| [u, p(u)]).collect()
    };
    let exact = |u: f64| ridge::pressure(u).unwrap_or(f64::NAN);
    vec![
        Series::line(
            "exact, no range",
            Role::Theory,
            Colour::Ink,
            over(1e-4, end.displacement, &exact),
        ),
        Series::line(
            "thick, Eq. 26",
            Role::Theory,
            Colour::Blue,
            over(0.0, 0.3, &ridge::thick_pressure),
        ),
        Series::line(
            "flattening, Eq. 27 corrected",
            Role::Theory,
            Colour::Orange,
            over(0.56, end.displacement, &|u| end.pressure_at(u)),
        ),
        Series::line(
            "flattening, Eq. 27 as printed",
            Role::Printed,
            Colour::Orange,
            over(0.45, FLATTENING_PRINTED.displacement, &|u| {
                FLATTENING_PRINTED.pressure_at(u)
            }),
        ),
    ]
}

fn jumps(run: &LoopRun, length: f64, colour: Colour) -> Vec<Arrow> {
    let units = units(length);
    let arrow = |jump: &crate::follow::record::JumpRecord| {
        let u0 = jump.mean_displacement;
        let at = |stress| [units.reduce(u0), units.pressure(stress, u0)];
        Arrow {
            name: "",
            tail: at(jump.stress_before),
            head: at(jump.stress_after),
            colour,
            direction: jump.direction,
        }
    };
    run.record.jumps.iter().map(arrow).collect()
}
