//! Fig. 4: where the flat surface gives way, against the size of the cell.

use super::scenes;
use super::{Entry, Figure, Finding, Stopped, Task};
use crate::follow::record::Direction;
use crate::numerics::dense::norm;
use crate::numerics::threads::Cancel;
use crate::physics::indenter::Indenter;
use crate::physics::law::{Law, Morse, Shape};
use crate::physics::mesh::Grid;
use crate::physics::preconditioner::Preconditioner;
use crate::physics::system::System;
use crate::physics::theory::{critical_length, flat_limits};
use crate::plot::panel::{Axis, Colour, Panel, Role, Series, Symbol};
use crate::scene::Points;
use crate::solver::gfmd::{Gfmd, GfmdBudget};
use crate::solver::mechanics::{Mechanics, Slides};
use crate::solver::method::{Cost, Equilibrium, History, Lost, Method, Stop};
use crate::solver::stability::random_smooth;
use rand::SeedableRng;
use rand_pcg::Pcg64;

pub(super) const ENTRY: Entry = Entry {
    number: 4,
    title: "Where the flat surface gives way",
    look_for: "Below L = L_c the flat surface never gives way. Above it, approach and retraction \
        give way at different separations, and the distance between them grows with the logarithm \
        of the cell.",
    scene: || {
        scenes::flat(
            "Fig. 4: a cell of two critical lengths",
            167.55,
            Points::Square(32),
            3.4,
            0.6,
            0.02,
        )
    },
    compute,
};

/// Cells of the simulation, as L/L_c.
const CELLS: [f64; 13] = [
    1.02, 1.05, 1.1, 1.2, 1.5, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0, 100.0, 300.0,
];
/// The same for a quick figure.
const QUICK: [f64; 8] = [1.05, 1.2, 1.5, 2.0, 5.0, 10.0, 30.0, 100.0];
/// A cell in which the flat surface must never give way.
const SMALL: f64 = 0.95;
/// Agreement asked for, and a fifth of it, to which the simulation locates a limit (ranges).
const TOLERANCE: f64 = 0.01;

fn compute(task: &mut Task<'_>) -> Result<Figure, Stopped> {
    let law = Law {
        shape: Shape::Morse(Morse),
        surface_energy: scenes::SURFACE_ENERGY,
        range: 1.0,
    };
    let critical = critical_length(&law);
    let points = task.choose(12, 32);
    let cells: &[f64] = task.choose(&QUICK, &CELLS);
    let (mut approach, mut retraction, mut findings) = (Vec::new(), Vec::new(), Vec::new());
    for (i, &cell) in cells.iter().enumerate() {
        task.tell(
            i as f64 / cells.len() as f64,
            &format!("dynamics from noise in a cell of {cell} critical lengths"),
        )?;
        let surface = Surface::new(law, cell * critical, points);
        let softest = law.softest_gap();
        let found = [
            surface.limit(softest, -1.0, task.cancel)?,
            surface.limit(softest, 1.0, task.cancel)?,
        ];
        retraction.push([cell, found[0]]);
        approach.push([cell, found[1]]);
        let (lower, upper) = flat_limits(&law, cell * critical).unwrap_or((f64::NAN, f64::NAN));
        let names = ["retraction", "approach"];
        findings.extend(names.iter().zip(found).zip([lower, upper]).map(
            |((name, found), expected)| {
                Finding::new(
                    format!("u_c/ρ on {name} at L/L_c = {cell}"),
                    found,
                    expected,
                    "Eq. 8",
                    Some(TOLERANCE),
                )
            },
        ));
    }
    let small = Surface::new(law, SMALL * critical, points);
    let gaps: Vec<f64> = (0..=8).map(|i| 0.25 * f64::from(i) + 0.5).collect();
    let mut grown = 0;
    for &gap in gaps.iter().chain([&law.softest_gap()]) {
        grown += usize::from(small.gives_way(gap, task.cancel)?);
    }
    findings.push(Finding::new(
        format!(
            "separations, of {} tried, at which noise grows in a cell of {SMALL} L_c",
            gaps.len() + 1
        ),
        grown as f64,
        0.0,
        "Eq. 7",
        Some(0.0),
    ));
    let worst = findings
        .iter()
        .map(|f| (f.found - f.expected).abs())
        .fold(0.0, f64::max);
    let symbols =
        |name: &str, colour, points| Series::symbols(name, Symbol::Circle, colour, points);
    let [upper, lower] = lines(&law);
    let panel = Panel {
        x: Axis::logarithmic("L/L_c"),
        y: Axis::linear("u_c/ρ"),
        series: vec![
            upper,
            lower,
            symbols(
                "approach, noise grows",
                Colour::of(Direction::Approach),
                approach,
            ),
            symbols(
                "retraction, noise grows",
                Colour::of(Direction::Retraction),
                retraction,
            ),
        ],
        ..Panel::default()
    };
    Ok(ENTRY.figure(vec![panel], words(points, worst), findings))
}

fn words(points: usize, worst: f64) -> String {
    format!(
        "A flat surface is stable while γ″(u₀) + πE*/L is positive, which for a Morse law ends \
             at u_c = −ρ ln([1 ∓ (1 − L_c/L)^½]/4) with L_c = 4πρ²E*/γ (Eq. 8; the upper sign on \
             approach). Both limits start from ρ ln 4 at L = L_c; for long cells the lower tends \
             to ρ ln 2 and the upper grows as ρ ln(8 L/L_c). Symbols are a second method that \
             knows nothing of Eq. 8: the surface is given noise of a millionth of ρ, moves by \
             mass-weighted GFMD without a thermostat on {points} x {points} points, and u₀ is \
             bisected on whether the noise grows or dies. Largest difference: {worst:.4} ρ."
    )
}

/// Eq. 8: the limits on approach and on retraction.
fn lines(law: &Law) -> [Series; 2] {
    let critical = critical_length(law);
    let ratios: Vec<f64> = (0..=400)
        .map(|i| 10f64.powf(3.0 * (f64::from(i) / 400.0).powi(2)))
        .collect();
    let line = |name: &str, direction, pick: fn((f64, f64)) -> f64| {
        let points = ratios
            .iter()
            .filter_map(|&r| flat_limits(law, r * critical).map(|limits| [r, pick(limits)]));
        Series::line(name, Role::Theory, Colour::of(direction), points.collect())
    };
    [
        line("approach, Eq. 8", Direction::Approach, |l| l.1),
        line("retraction, Eq. 8", Direction::Retraction, |l| l.0),
    ]
}

/// A flat surface over flat ground, to be shaken.
struct Surface {
    system: System,
    noise: Vec<f64>,
}

/// Time steps between two looks.
const STEPS: usize = 25;
/// Looks after which all waves but the softest have died, and looks after which the last word
/// counts.
const CALM: usize = 4;
const LOOKS: usize = 36;
/// Growth or decay of the softest wave that is an answer.
const CLEAR: f64 = 4.0;
/// Growth of the whole that is an answer at once: stable waves never grow.
const BURST: f64 = 30.0;

impl Surface {
    fn new(law: Law, length: f64, points: usize) -> Self {
        let system = System::new(Grid::square(length, points), law, &Indenter::Flat);
        let noise = random_smooth(&system, &mut Pcg64::seed_from_u64(4));
        let size = 1e-6 * law.range / norm(&noise);
        Self {
            noise: noise.iter().map(|z| size * z).collect(),
            system,
        }
    }

    /// Whether noise grows at the gap `u0`.
    fn gives_way(&self, u0: f64, cancel: &Cancel) -> Result<bool, Stopped> {
        // An inertia above all that pulls back or pushes on: then the default time step suits every
        // gap.
        let preconditioner =
            Preconditioner::new(&self.system, self.system.law().at(u0).stiffness.abs());
        let mut mechanics =
            Mechanics::with_preconditioner(preconditioner, self.system.clone(), Slides::Never);
        mechanics.cancel = cancel.clone();
        let budget = GfmdBudget {
            ramp: 1,
            relax: STEPS - 1,
            temperature: 0.0,
            ..GfmdBudget::default()
        };
        let mut gfmd = Gfmd::with_budget(budget, 4);
        let noisy = mechanics.at(self.noise.clone(), u0);
        let mut state =
            Equilibrium::unmeasured(noisy, f64::NAN, Stop::NotConverged, Cost::default());
        let start = norm(&self.noise);
        let mut calm = f64::NAN;
        for look in 1..=LOOKS {
            state = gfmd
                .follow(&mut mechanics, &History::default(), &state, u0)
                .map_err(|lost| match lost {
                    Lost::Cancelled => Stopped::Cancelled,
                    lost => {
                        Stopped::Failed(format!("dynamics from noise at u0 = {u0:.4}: {lost:?}"))
                    }
                })?;
            let now = state.state.roughness();
            if look == CALM {
                calm = now;
            }
            let clear = now / calm > CLEAR || calm / now > CLEAR;
            if now > BURST * start || clear || look == LOOKS {
                return Ok(now > BURST * start || now > calm);
            }
        }
        unreachable!("the last look returns")
    }

    /// The gap at which the flat surface stops giving way, on the side `sign` of the unstable gap
    /// `inside`; NaN if that is stable.
    fn limit(&self, inside: f64, sign: f64, cancel: &Cancel) -> Result<f64, Stopped> {
        let range = self.system.law().range;
        if !self.gives_way(inside, cancel)? {
            return Ok(f64::NAN);
        }
        let (mut unstable, mut width) = (inside, 0.2 * range);
        let mut stable = inside + sign * width;
        while self.gives_way(stable, cancel)? {
            width *= 2.0;
            (unstable, stable) = (stable, inside + sign * width);
        }
        while (stable - unstable).abs() > 0.2 * TOLERANCE * range {
            let middle = 0.5 * (stable + unstable);
            if self.gives_way(middle, cancel)? {
                unstable = middle;
            } else {
                stable = middle;
            }
        }
        Ok(0.5 * (stable + unstable))
    }
}
