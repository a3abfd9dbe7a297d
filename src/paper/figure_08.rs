//! Fig. 8: what a coarse mesh does to the ridge: jumps that belong to the mesh from point to point.

use super::scenes::{ends, line_cell, on_part, reduced, units};
use super::{Entry, Figure, Finding, Stopped, Task};
use crate::follow::record::Direction;
use crate::follow::run::LoopRun;
use crate::physics::pattern::Pattern;
use crate::physics::theory::{flat_limits, ridge};
use crate::plot::panel::{Axis, Colour, Panel, Role, Series, letter};
use crate::scene::{Part, Range, Scene};

pub(super) const ENTRY: Entry = Entry {
    number: 8,
    title: "Sixteen points for a ridge",
    look_for: "With μ_ρ = 0.5 the mesh of 16 points still follows the exact ridge smoothly, over a \
        part of it. From 0.75 on the edge of the contact jumps from point to point: saw teeth, and \
        energy lost to the mesh.",
    scene: || loop_of(0.75),
    compute,
};

const POINTS: usize = 16;
const LENGTH: f64 = 256.0;
/// mu_rho of each diagram, and how many jumps from ridge to ridge were counted by an independent
/// prototype.
const PANELS: [(f64, f64); 4] = [(0.25, 0.0), (0.5, 0.0), (0.75, 18.0), (1.0, 18.0)];
/// Where the text says that the ridge of mu_rho = 0.5 flattens (u~): thick, thin.
const QUOTED: [f64; 2] = [0.15, 0.6];
/// mu_rho between which the quoted limits are looked for.
const SEARCH: [f64; 6] = [0.55, 0.6, 0.65, 0.7, SUSPECTED, 0.75];
/// What 0.5 would be if the paper's mu_rho lacked a factor sqrt(2).
const SUSPECTED: f64 = std::f64::consts::FRAC_1_SQRT_2;

fn loop_of(mu_rho: f64) -> Scene {
    let title = format!("Fig. 8: a line of {POINTS} points, μ_ρ = {mu_rho}");
    let mut scene = line_cell(&title, LENGTH, POINTS, [0.8, 0.02, 0.004]);
    scene.law.range = Range::MuRho(mu_rho);
    scene
}

fn compute(task: &mut Task<'_>) -> Result<Figure, Stopped> {
    let units = units(LENGTH);
    let (mut panels, mut findings) = (Vec::new(), Vec::new());
    let mut half = [f64::NAN; 2];
    for (i, (mu_rho, counted)) in PANELS.into_iter().enumerate() {
        let run = on_part(
            &loop_of(mu_rho),
            Part::Whole,
            &mut task.part(0.1 * i as f64, 0.1 + 0.1 * i as f64),
        )?;
        let points = (1..=300)
            .filter_map(|i| exact(f64::from(i) / 300.0 * ridge::critical().displacement))
            .collect();
        let exact = Series::line("exact, no range", Role::Theory, Colour::Ink, points);
        panels.push(Panel {
            title: format!("({}) μ_ρ = {mu_rho}", letter(i)),
            x: Axis::linear("ũ₀ = u₀/(γL/E*)^½").from_to(0.0, 0.8),
            y: Axis::linear("p̃ = p u₀/γ").from_to(-0.8, 0.1),
            series: vec![
                exact,
                path(&run, Direction::Approach),
                path(&run, Direction::Retraction),
            ],
            ..Panel::default()
        });
        findings.push(Finding::new(
            format!("jumps from ridge to ridge at μ_ρ = {mu_rho}"),
            spurious(&run) as f64,
            counted,
            "counted by an independent prototype",
            Some(0.0),
        ));
        if mu_rho == 0.5 {
            half = ends(&run, &units).unwrap_or(half);
        }
    }
    findings.extend(limits(half));
    let seen = search(&mut task.part(0.4, 1.0))?;
    let found = [0, 1].map(|end| crossing(&seen, end).unwrap_or(f64::NAN));
    let suspected = seen
        .iter()
        .find(|(mu_rho, _)| *mu_rho == SUSPECTED)
        .map_or([f64::NAN; 2], |(_, ends)| *ends);
    let names = [
        "thick ridge closes at ũ₀ = 0.15",
        "thin ridge flattens at ũ₀ = 0.6",
    ];
    findings.extend(names.iter().zip(found).map(|(name, found)| {
        Finding::new(
            format!("μ_ρ at which the {name}"),
            found,
            0.5,
            "Sect. 3.2.1, with μ_ρ by Eq. 11",
            None,
        )
    }));
    Ok(ENTRY.figure(panels, words(half, found, suspected), findings))
}

fn words(half: [f64; 2], found: [f64; 2], suspected: [f64; 2]) -> String {
    format!(
        "A line of 16 points with four ranges, μ_ρ by Eqs 10 and 11. With μ_ρ = 0.25 the cell is \
         shorter than L_c and nothing gives way. With 0.5 the ridge is smooth and lives for {:.3} \
         ≤ ũ₀ ≤ {:.3}, nearly between the limits of the flat surface (Eq. 8), as it must in a cell \
         of 1.27 L_c. With 0.75 and 1 every point pins the edge of the contact: the jumps from \
         ridge to ridge belong to the mesh and vanish with a finer one. The text quotes limits of \
         about 0.15 and 0.6 for μ_ρ = 0.5. In the convention of Eq. 11 these appear at μ_ρ = {:.3} \
         and {:.3}; both ask for nearly the same value, {:.2} times the one stated. A factor √2 in \
         the paper's μ_ρ (0.707 for 0.5) is suspected and comes close: its limits are {:.3} and \
         {:.3}.",
        half[0],
        half[1],
        found[0],
        found[1],
        (found[0] + found[1]) / 2.0 / 0.5,
        suspected[0],
        suspected[1]
    )
}

/// (u~, p~) of the exact ridge.
fn exact(displacement: f64) -> Option<[f64; 2]> {
    ridge::pressure(displacement).map(|pressure| [displacement, pressure])
}

/// The path of one direction, jumps as vertical lines.
fn path(run: &LoopRun, direction: Direction) -> Series {
    let units = units(LENGTH);
    let points = run
        .record
        .states
        .iter()
        .filter(|s| s.direction == direction)
        .map(|s| reduced(&units, s))
        .collect();
    Series::gone(direction, points)
}

/// Jumps that the continuum does not have.
fn spurious(run: &LoopRun) -> usize {
    run.record
        .jumps
        .iter()
        .filter(|j| j.from == Pattern::Ridge && j.to == Pattern::Ridge)
        .count()
}

/// The ends of the ridge at mu_rho = 0.5, against the flat limits and the text.
fn limits(found: [f64; 2]) -> Vec<Finding> {
    // In a cell of 1.27 L_c the ridge bifurcates from the flat surface almost without a fold: its
    // ends are the flat limits, but for a few thousandths.
    let units = units(LENGTH);
    let law = loop_of(0.5).model().map(|model| model.law).ok();
    let eq_8 = law
        .and_then(|law| flat_limits(&law, LENGTH))
        .map_or([f64::NAN; 2], |(low, high)| [low, high]);
    let tolerance = law.map(|law| 0.02 * units.reduce(law.range));
    let names = ["closes on approach", "flattens on retraction"];
    let mut findings = Vec::new();
    for i in 0..2 {
        let quantity = format!("ũ₀ where the ridge {} at μ_ρ = 0.5", names[i]);
        findings.push(Finding::new(
            quantity.clone(),
            found[i],
            units.reduce(eq_8[i]),
            "Eq. 8",
            tolerance,
        ));
        findings.push(Finding::new(
            quantity,
            found[i],
            QUOTED[i],
            "Sect. 3.2.1",
            None,
        ));
    }
    findings
}

/// The ends of the ridge (u~) for every mu_rho of the search.
fn search(task: &mut Task<'_>) -> Result<Vec<(f64, [f64; 2])>, Stopped> {
    let units = units(LENGTH);
    let mut seen = Vec::new();
    for (i, mu_rho) in SEARCH.into_iter().enumerate() {
        let share = SEARCH.len() as f64;
        let run = on_part(
            &loop_of(mu_rho),
            Part::Whole,
            &mut task.part(i as f64 / share, (i + 1) as f64 / share),
        )?;
        seen.extend(ends(&run, &units).map(|ends| (mu_rho, ends)));
    }
    Ok(seen)
}

/// mu_rho at which one end (0 closes, 1 flattens) is where the text says, by interpolation between
/// loops.
fn crossing(seen: &[(f64, [f64; 2])], end: usize) -> Option<f64> {
    seen.windows(2).find_map(|pair| {
        let [(mu, a), (mu_next, b)] = [pair[0], pair[1]];
        let share = (QUOTED[end] - a[end]) / (b[end] - a[end]);
        (0.0..=1.0)
            .contains(&share)
            .then_some(mu + share * (mu_next - mu))
    })
}
