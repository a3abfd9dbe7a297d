//! What the print of the paper got wrong: where, what it says, what is right, and numbers that
//! decide between the two.
//!
//! The numbers are computed on the spot and from neither formula: by finding a root, by
//! integrating, by measuring a law or a mesh, by running a loop.

use super::scenes::{self, planned, units_of};
use super::{Stopped, Task};
use crate::physics::indenter::Indenter;
use crate::physics::law::{Cosine, Law, Morse, Shape};
use crate::physics::mesh::{self, Grid};
use crate::physics::system::System;
use crate::physics::theory::jkr::Jkr;
use crate::physics::theory::{circular, flat_limits, ridge};
use crate::scene::Points;
use std::f64::consts::{FRAC_PI_2, LN_2, PI, SQRT_2};

/// An error of the print.
#[derive(Clone, Debug, PartialEq)]
pub struct Erratum {
    /// Where it stands ("Eq. 24").
    pub place: &'static str,
    /// What is printed.
    pub printed: &'static str,
    /// What is right.
    pub right: &'static str,
    /// Why, in a sentence.
    pub because: &'static str,
    /// Numbers that decide; none where the error is one of notation only.
    pub evidence: Vec<Evidence>,
}

/// A number found here, beside the same number by the printed and by the right formula.
#[derive(Clone, Debug, PartialEq)]
pub struct Evidence {
    /// What it is, and how it was found.
    pub quantity: &'static str,
    /// Found here.
    pub found: f64,
    /// By the print.
    pub printed: f64,
    /// By what is right.
    pub right: f64,
    /// How near to `right` the found number must be to support it: what the way of finding leaves
    /// open.
    pub tolerance: f64,
}

impl Evidence {
    /// A number found here, the same by the print and by what is right, and how near the found one
    /// must be; see the fields.
    fn new(quantity: &'static str, found: f64, [printed, right]: [f64; 2], tolerance: f64) -> Self {
        Self {
            quantity,
            found,
            printed,
            right,
            tolerance,
        }
    }
}

/// What is said while the loop behind one of them is run.
const LOOP: &str = "errata: a loop of a line cell";

/// All of them, in the paper's order.
///
/// # Errors
/// [`Stopped`] if somebody asked to stop, or a computation behind the evidence has failed.
pub fn errata(task: &mut Task<'_>) -> Result<Vec<Erratum>, Stopped> {
    task.tell(0.0, "errata: meshes and laws")?;
    let mut list = vec![
        equation_9(),
        equation_22(),
        equation_24(),
        equation_25(),
        equation_27(),
    ];
    task.tell(0.2, "errata: circular patterns")?;
    list.extend([equation_28(), equation_29(), after_equation_29()]);
    task.tell(0.6, LOOP)?;
    list.extend([
        equation_30c(),
        text_at_equation_30(task)?,
        equation_31(),
        equation_33(),
    ]);
    list.extend([section_4(), notation()]);
    Ok(list)
}

/// Slips of the appendix that change no result.
fn notation() -> Erratum {
    Erratum {
        place: "Appendix: A1, A3, A8, A10, A11",
        printed: "σ_0 and u_0 without 1/abar and 1/alpha; q_n = n/(2 pi L); factors of two; alpha \
            for 1 - alpha",
        right: "A1 with 1/abar, A8 with 1/alpha; q_n = 2 pi n/L; the amplitudes of Eqs 4 and A5; \
            alpha is the share out of contact",
        because: "The mean of the printed profile is abar σ_0 and not σ_0, and its wave numbers \
            are not those of a cell of side L.",
        evidence: vec![wave_number()],
    }
}

const POINTS: usize = 16;

fn morse(range: f64) -> Law {
    Law {
        shape: Shape::Morse(Morse),
        surface_energy: 1.0,
        range,
    }
}

/// The elastic stiffness q E*/2 of a mesh of unit spacing, smallest and largest.
fn stiffness(grid: Grid) -> [f64; 2] {
    let system = System::new(grid, morse(1.0), &Indenter::Flat);
    // What has no wave has no stiffness either.
    let waves = system.elastic().iter().copied().filter(|e| *e > 0.0);
    waves.fold([f64::INFINITY, 0.0], |[low, high], e| {
        [low.min(e), high.max(e)]
    })
}

/// mu_rho at which softening overcomes the stiffest wave of the mesh, read off the mesh itself.
fn limit(grid: Grid) -> f64 {
    // max(-gamma'') = mu_rho^2 E*/da with da = 1.
    stiffness(grid)[1].sqrt()
}

fn equation_9() -> Erratum {
    let spacing = 1.0;
    let range = (1.0 / (4.0 * PI) * spacing).sqrt();
    Erratum {
        place: "Eqs 9 to 11",
        printed: "Eq. 10 translates (back) to the rule of Eq. 9",
        right: "Eq. 9 is mu_rho = sqrt(pi) = 1.772, beyond the mesh's own limit of 1.2533 (line) \
            or 1.4905 (square); mu_rho = 0.5 keeps the shortest unstable wave at 4 pi da",
        because: "A mesh that obeys Eq. 9 to the letter is unstable on the scale of its own \
            spacing.",
        evidence: vec![
            Evidence::new(
                "mu_rho by Eq. 10 of a Morse law with the range of Eq. 9 (the print recommends \
                 0.5)",
                mesh::mu_rho(&morse(range), spacing),
                [mesh::SAFE, PI.sqrt()],
                1e-12,
            ),
            Evidence::new(
                "largest mu_rho that a line's stiffest wave bears, from the spectrum of a mesh",
                limit(Grid::line(POINTS as f64, POINTS)),
                [PI.sqrt(), FRAC_PI_2.sqrt()],
                1e-12,
            ),
            Evidence::new(
                "the same of a square mesh",
                limit(Grid::square(POINTS as f64, POINTS)),
                [PI.sqrt(), (SQRT_2 * FRAC_PI_2).sqrt()],
                1e-12,
            ),
        ],
    }
}

fn equation_33() -> Erratum {
    let law = morse(mesh::range_for_mu_rho(&morse(1.0), 1.0, mesh::SAFE));
    // The largest softening by looking for it, not by its formula.
    let softening = (0..40_000)
        .map(|i| -law.at(f64::from(i) * 2e-4 * law.range).stiffness)
        .fold(0.0, f64::max);
    Erratum {
        place: "Eq. 33",
        printed: "max(-gamma'') <= E*/da",
        right: "max(-gamma'') <= E*/(4 da) at the recommended mu_rho = 0.5",
        because: "E*/da is mu_rho = 1, at which edges of contact already jump from one mesh point \
            to the next.",
        evidence: vec![Evidence::new(
            "max(-gamma'') da/E* of a Morse law with mu_rho = 0.5, searched for on a fine raster",
            softening,
            [1.0, 0.25],
            1e-6,
        )],
    }
}

fn equation_31() -> Erratum {
    // Stiffness from differences of the traction on either side of zero.
    let jump = |smooth: bool| {
        let law = Law {
            shape: Shape::Cosine(Cosine { smooth }),
            surface_energy: 1.0,
            range: 1.0,
        };
        let traction = |gap: f64| law.at(gap).traction;
        let step = 1e-4;
        (traction(-step) - traction(-2.0 * step)) / (traction(2.0 * step) - traction(step))
    };
    Erratum {
        place: "Eq. 31",
        printed: "{1 - (pi g/g_c)^2/2} for g < 0",
        right: "{1 - (pi g/g_c)^2/4}, if the stiffness is to be continuous",
        because: "As printed, gamma'' jumps by a factor of two at contact. The program offers \
            both; the paper's is the default.",
        evidence: vec![
            Evidence::new(
                "gamma''(0-)/gamma''(0+) of the law as printed, from differences of its traction \
                 (continuous: 1)",
                jump(false),
                [1.0, 2.0],
                1e-5,
            ),
            Evidence::new(
                "the same of the variant with continuous stiffness (printed: 2)",
                jump(true),
                [2.0, 1.0],
                1e-5,
            ),
        ],
    }
}

/// The smallest wave number of a cell, from its stiffness.
fn wave_number() -> Evidence {
    let length = POINTS as f64;
    let [smallest, _] = stiffness(Grid::line(length, POINTS));
    Evidence::new(
        "smallest wave number q_1 of a cell times its side, from the stiffness q E*/2 of its \
         longest wave",
        2.0 * smallest * length,
        [1.0 / (2.0 * PI), 2.0 * PI],
        1e-12,
    )
}

fn equation_22() -> Erratum {
    let share = 1e-3;
    // The print's alpha read as the share in contact, without which its logarithm means nothing.
    let thin = |constant: f64| -PI / (4.0 * (PI * share).ln() + constant);
    Erratum {
        place: "Eq. 22, thin ridge",
        printed: "-pi/(4 ln(pi alpha) + 8c), c = 0.3079",
        right: "-pi/(4 ln(pi abar) - 8c), c = ln(2)/2 = 0.34657",
        because: "The sign of 8c follows from Eq. A6e, and the constant from the stress under a \
            thin ridge, which goes as 1/sqrt(1 - x^2/a^2) and not as its inverse.",
        evidence: vec![
            Evidence::new(
                "vhat of a ridge with 0.1 % of the cell in contact, exact",
                ridge::elastic_energy(1.0 - share)[0],
                [thin(8.0 * 0.3079), thin(-4.0 * LN_2)],
                1e-7,
            ),
            Evidence::new(
                "c that the exact vhat gives there",
                (PI / ridge::elastic_energy(1.0 - share)[0] + 4.0 * (PI * share).ln()) / 8.0,
                [0.3079, 0.5 * LN_2],
                1e-6,
            ),
        ],
    }
}

fn equation_24() -> Erratum {
    let end = ridge::critical();
    Erratum {
        place: "Eq. 24",
        printed: "vhat_c = 0.4204, vhat'''_c = -145",
        right: "vhat_c = 0.40064, vhat'''_c = -131.92",
        because: "The exact energy of a periodic ridge, vhat = -pi/(4 ln cos(pi alpha/2)), has its \
            zero of vhat'' at alpha_c = 0.91006.",
        evidence: vec![
            Evidence::new(
                "vhat where vhat'' = 0, by finding the root",
                end.elastic_energy[0],
                [0.4204, 0.400642787],
                1e-8,
            ),
            Evidence::new(
                "vhat''' there",
                end.elastic_energy[3],
                [-145.0, -131.922250],
                1e-5,
            ),
        ],
    }
}

fn equation_25() -> Erratum {
    // In a stiffer medium u~ = u0 sqrt(E*/(gamma L)) grows by the root; p u0/gamma is p~ itself.
    let displacement = 1e-5;
    let pressure = |u: f64| ridge::pressure(u).unwrap_or(f64::NAN);
    Erratum {
        place: "Eq. 25",
        printed: "p/E* = -(4 gamma^2/(pi L E* u0))^{1/3}",
        right: "p/E* = -(4 gamma^2/(pi L E*^2 u0))^{1/3}",
        because: "Only with the square is the bracket a pure number, and only so does it agree \
            with Eq. 26.",
        evidence: vec![Evidence::new(
            "p at four times the modulus over p, same u0, exact ridge at u~ = 0.00001",
            pressure(2.0 * displacement) / pressure(displacement),
            [4f64.powf(2.0 / 3.0), 4f64.cbrt()],
            1e-4,
        )],
    }
}

fn equation_27() -> Erratum {
    let end = ridge::critical();
    // p~ a little before the end, less p_c~, over the root of the distance; once more at a quarter
    // of it, and extrapolated.
    let slope = |distance: f64| {
        ridge::pressure(end.displacement - distance)
            .map_or(f64::NAN, |p| (p - end.pressure) / distance.sqrt())
    };
    let root = 2.0 * slope(2.5e-7) - slope(1e-6);
    Erratum {
        place: "Eq. 27",
        printed: "p_c~ = -0.3937, p^{(1/2)} = -2/u'' = -0.360",
        right: "p_c~ = -0.35500, p^{(1/2)} = -sqrt(-2/u'') = -0.64132",
        because: "p_c~ is -2 u_c~^2 vhat_c. Near its largest value u~ is a parabola in p~, which \
            leaves a square root.",
        evidence: vec![
            Evidence::new(
                "p~ of the exact ridge where it flattens",
                ridge::pressure(end.displacement).unwrap_or(f64::NAN),
                [-0.3937, -0.354996680],
                1e-7,
            ),
            Evidence::new(
                "(p~ - p_c~)/sqrt(u_c~ - u~) next to that point, extrapolated",
                root,
                [-0.360, -0.641317722],
                1e-4,
            ),
        ],
    }
}

/// The area under the exact ridge, from u~ = 0 to its end, by Simpson's rule in the cube root of
/// u~, where it is smooth.
fn area_under_ridge() -> f64 {
    let end = ridge::critical().displacement.cbrt();
    let count = 400;
    // -p~ du~/u~ = -3 p~ dt/t with u~ = t^3; p~ goes as t^2.
    let value = |i: usize| {
        let t = end * i as f64 / count as f64;
        if i == 0 {
            0.0
        } else {
            ridge::pressure(t.powi(3)).map_or(f64::NAN, |p| -3.0 * p / t)
        }
    };
    let weight = |i: usize| {
        if i == 0 || i == count {
            1.0
        } else {
            2.0 + 2.0 * (i % 2) as f64
        }
    };
    (0..=count).map(|i| weight(i) * value(i)).sum::<f64>() * end / (3.0 * count as f64)
}

fn equation_30c() -> Erratum {
    Erratum {
        place: "Eq. 30c",
        printed: "(3/2) alpha_c = 1.365",
        right: "1.08756",
        because: "3/2 alpha_c takes the asymptote of a thick ridge up to its end, where it is far \
            off.",
        evidence: vec![Evidence::new(
            "energy over gamma that a ridge of zero range loses: area under the exact p~(u~), by \
             Simpson's rule",
            area_under_ridge(),
            [1.365, 1.087557130],
            2e-4,
        )],
    }
}

fn text_at_equation_30(task: &mut Task<'_>) -> Result<Erratum, Stopped> {
    // Turned while the ridge is still a ridge: Eq. 30 is about the cycle from separation to the
    // ridge and back.
    let scene = scenes::flat(
        "a line cell of 1024 ranges",
        1024.0,
        Points::Line(256),
        9.5,
        3.5,
        0.1,
    );
    let (run, model) = planned(&scene, &mut task.part(0.6, 1.0), LOOP)?;
    let law = &model.law;
    let units = units_of(&model);
    let approach = flat_limits(law, units.length).map_or(f64::NAN, |limits| limits.1);
    let (from, to) = (units.reduce(approach), ridge::critical());
    let thick = ridge::energy(to.alpha, to.displacement)
        - ridge::alpha(from).map_or(f64::NAN, |alpha| ridge::energy(alpha, from));
    let flat = (law.at(approach).energy - law.at(units.restore(to.displacement)).energy)
        / units.surface_energy;
    Ok(Erratum {
        place: "text at Eq. 30",
        printed: "the correction v_int(u_c,nc) - v_int(u_c,lr) is subtracted",
        right: "it is added; it is negative",
        because: "On the way in, the flat surface is already drawn towards the ground: that much \
            less is lost when it jumps.",
        evidence: vec![Evidence::new(
            "energy over gamma that a loop of a line cell of 1024 ranges loses, computed",
            run.record.released_energy_sum(),
            [thick - flat, thick + flat],
            // The theory has no range in the ridge itself: good to about a percent.
            0.015 * (thick + flat).abs(),
        )],
    })
}

/// The limit at zero of what approaches it linearly (or as the cube) from `at`: by Richardson's
/// rule.
fn at_zero(at: f64, order: i32, value: impl Fn(f64) -> f64) -> f64 {
    let factor = 2f64.powi(order);
    (factor * value(0.5 * at) - value(at)) / (factor - 1.0)
}

fn equation_28() -> Erratum {
    let dimple = |alpha: f64| circular::dimple().elastic_energy(alpha)[0] * alpha.powi(3);
    let bulge = |size: f64| circular::bulge().elastic_energy(size)[0] / size;
    Erratum {
        place: "Eq. 28",
        printed: "dimple 8/(sqrt(3 pi) alpha^3), bulge sqrt(2) (1 - alpha)^{3/2}",
        right: "dimple 3/(2 alpha^3), bulge abar/2",
        because: "A single opened disc, and a single disc pressed on, are textbook solutions; the \
            lattice adds higher orders only.",
        evidence: vec![
            Evidence::new(
                "vhat alpha^3 of a small dimple, from a series on the lattice, extrapolated",
                at_zero(0.2, 3, dimple),
                [8.0 / (3.0 * PI).sqrt(), 1.5],
                1e-4,
            ),
            Evidence::new(
                "vhat/abar of a small bulge, from a series on the lattice, extrapolated (print: at \
                 abar = 0.02)",
                at_zero(0.02, 1, bulge),
                [SQRT_2 * 0.02f64.sqrt(), 0.5],
                1e-3,
            ),
        ],
    }
}

fn equation_29() -> Erratum {
    // k of p~ = -(k u~)^(4/5), which is approached as alpha^3.
    let factor = |size: f64| {
        let state = circular::dimple().state(size);
        (-state.pressure).powf(1.25) / state.displacement
    };
    Erratum {
        place: "Eq. 29",
        printed: "p~ = -(4 u~/3)^{4/5}",
        right: "p~ = -(1.79301 u~)^{4/5}",
        because: "It follows from the energy of a dimple, and inherits its factor.",
        evidence: vec![Evidence::new(
            "k of p~ = -(k u~)^{4/5} of a small dimple, extrapolated",
            at_zero(0.2, 3, factor),
            [4.0 / 3.0, 1.79300742],
            1e-3,
        )],
    }
}

fn after_equation_29() -> Erratum {
    let bulge = circular::bulge();
    let fold = bulge.fold();
    // The energy of neighbouring sizes at u~ = 0.5, on the stable part of the branch.
    let displacement = 0.5;
    let size = bulge.size(displacement).unwrap_or(f64::NAN);
    let energy = |size: f64| {
        displacement * displacement * bulge.elastic_energy(size)[0] - bulge.contact_area(size)
    };
    let lowest = (1..980)
        .map(|i| 1e-3 * f64::from(i))
        .filter(|s| *s > fold.size)
        .min_by(|a, b| energy(*a).total_cmp(&energy(*b)));
    Erratum {
        place: "after Eq. 29",
        printed: "no stable bulge exists in the continuum limit",
        right: "a bulge is metastable for 0.403 < u~ < 0.620",
        because: "Its energy has a minimum against size where it covers enough of the cell for its \
            neighbours to be felt; below 0.403 it gives way to an ellipse.",
        evidence: vec![
            Evidence::new(
                "largest u~ of a metastable bulge of zero range (print: none)",
                fold.displacement,
                [0.0, 0.620288],
                1e-5,
            ),
            Evidence::new(
                "diameter over L at which the energy is least at u~ = 0.5, on a raster of 0.001 \
                 (print: none)",
                lowest.unwrap_or(f64::NAN),
                [0.0, size],
                1e-3,
            ),
        ],
    }
}

fn section_4() -> Erratum {
    let tip = Jkr {
        radius: 1.0,
        surface_energy: 0.5859e-3,
    };
    Erratum {
        place: "Sect. 4",
        printed: "contact radii a_c = 0.1278 (load) and 0.06315 (displacement)",
        right: "0.12746 and 0.06128 for gamma = 0.5859e-3 E* R",
        because: "They are the cube roots of (9/8) pi gamma R^2/E* and (1/8) pi gamma R^2/E*.",
        evidence: vec![
            Evidence::new(
                "contact radius where the pulling force is largest, searched for",
                turning(&tip, 0.10, 0.16, |tip, a| tip.contact(a).force),
                [0.1278, 0.127460],
                2e-6,
            ),
            Evidence::new(
                "contact radius where the displacement is largest, searched for",
                turning(&tip, 0.04, 0.09, |tip, a| tip.contact(a).mean_displacement),
                [0.06315, 0.061277],
                2e-6,
            ),
        ],
    }
}

/// Where a quantity of the contact turns round between two radii: by golden section, whichever way
/// it turns.
fn turning(tip: &Jkr, low: f64, high: f64, value: impl Fn(&Jkr, f64) -> f64) -> f64 {
    let middle = 0.5 * (low + high);
    let sign = (value(tip, middle) - 0.5 * (value(tip, low) + value(tip, high))).signum();
    let ratio = 0.5 * (5f64.sqrt() - 1.0);
    let (mut a, mut b) = (low, high);
    for _ in 0..80 {
        let (c, d) = (b - ratio * (b - a), a + ratio * (b - a));
        if sign * value(tip, c) > sign * value(tip, d) {
            b = d;
        } else {
            a = c;
        }
    }
    0.5 * (a + b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::threads::Cancel;
    use crate::paper::Size;

    #[test]
    fn all_evidence_supports_what_is_right_and_contradicts_the_print() {
        let list = errata(&mut Task::new(
            Size::Quick,
            &Cancel::default(),
            &mut |_, _| {},
        ))
        .expect("errata");
        assert_eq!(list.len(), 14);
        assert!(list.iter().all(|erratum| !erratum.evidence.is_empty()));
        let all = list.iter().flat_map(|erratum| {
            erratum
                .evidence
                .iter()
                .map(move |evidence| (erratum.place, evidence))
        });
        // Near what is right, and far from the print: by five tolerances or more.
        let decides = |e: &Evidence| {
            (e.found - e.right).abs() <= e.tolerance
                && (e.found - e.printed).abs() >= 5.0 * e.tolerance
        };
        let idle: Vec<_> = all.filter(|(_, evidence)| !decides(evidence)).collect();
        assert!(idle.is_empty(), "{idle:#?}");
    }
}
