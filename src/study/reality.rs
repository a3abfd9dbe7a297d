//! The model's five equations, each with a sentence and with the numbers of a scene; and whether that
//! scene can be real: each assumption of the model with the numbers of the scene, and
//! whether it holds. Estimates, good to a factor of a few; what needs lengths in metres is asked of
//! scenes with units alone.
//!
//! Formulas are lines of text as diagrams have them: names of Greek letters, `_` and `^`. E* is 1.

use crate::follow::flat_branch::FlatBranch;
use crate::follow::record::{LoopRecord, StateRecord};
use crate::physics::control::Control;
use crate::physics::indenter::Indenter;
use crate::physics::mesh;
use crate::physics::parameter::Dimension;
use crate::physics::theory::{critical_length, tabor};
use crate::physics::topography::{Border, Statistics};
use crate::scene::parameter::{Units, significant};
use crate::scene::{Model, Scene};
use std::f64::consts::PI;
use std::fmt;

/// Distance between atoms that touch without a bond (m), 0.3 to 0.4 nm in most solids
/// (Israelachvili, Intermolecular and Surface Forces, 3rd edition, chapter 7).
const ATOMS: f64 = 0.3e-9;
/// So many of these distances may a law of van der Waals forces reach.
const REACH: f64 = 10.0;
/// Strains and slopes up to here are small: their squares are a hundredth.
const SMALL: f64 = 0.1;
/// From here on nothing of linear elasticity is left.
const LARGE: f64 = 0.5;
/// Tabor's parameter above which a tip is that of JKR, and below which it is that of DMT (Johnson
/// and Greenwood 1997, doi 10.1006/jcis.1997.4984).
const TABOR: [f64; 2] = [5.0, 0.1];
/// Barriers are about this share of gamma L^2 before they begin to vanish.
const BARRIER: f64 = 1e-3;
/// In kT: over lower barriers heat goes within seconds.
const HOT: f64 = 30.0;

/// Whether an assumption holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It does.
    Holds,
    /// To be read with care.
    Doubtful,
    /// It does not.
    Fails,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Verdict::Holds => "holds",
            Verdict::Doubtful => "doubtful",
            Verdict::Fails => "fails",
        })
    }
}

/// An assumption in this scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Check {
    /// What is assumed.
    pub name: &'static str,
    /// The numbers, as formulas are written.
    pub here: String,
    /// Whether it holds.
    pub verdict: Verdict,
    /// What that means.
    pub sentence: String,
}

impl Check {
    fn new(
        name: &'static str,
        here: String,
        verdict: Verdict,
        sentence: impl Into<String>,
    ) -> Self {
        Self {
            name,
            here,
            verdict,
            sentence: sentence.into(),
        }
    }
}

impl fmt::Display for Check {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            name,
            here,
            verdict,
            sentence,
        } = self;
        write!(f, "{name}: {here}; {verdict}. {sentence}")
    }
}

/// Up to `SMALL` it holds, from `LARGE` on it fails.
fn smallness(value: f64) -> Verdict {
    if value <= SMALL {
        Verdict::Holds
    } else if value < LARGE {
        Verdict::Doubtful
    } else {
        Verdict::Fails
    }
}

/// Every assumption that the scene of this model makes, in the order in which they fail.
pub fn reality(model: &Model) -> Vec<Check> {
    let mut checks = Vec::new();
    let atoms = model.units.map(|units| Atoms::new(model, units));
    if let Some(atoms) = &atoms {
        checks.extend([atoms.range(), atoms.strength()]);
    }
    checks.push(strain(model, atoms.as_ref()));
    checks.extend(slope(model));
    checks.push(cell(model, atoms.as_ref()));
    checks.extend(tip(model));
    checks.push(mesh(model, atoms.as_ref()));
    checks.extend(heat(model));
    checks
}

/// A scene beside the distance between atoms.
struct Atoms<'a> {
    model: &'a Model,
    units: Units,
    /// The range of the law in distances between atoms.
    range: f64,
}

impl<'a> Atoms<'a> {
    fn new(model: &'a Model, units: Units) -> Self {
        let range = model.law.range * units.si(Dimension::Length) / ATOMS;
        Self {
            model,
            units,
            range,
        }
    }

    /// Whether forces between atoms reach so far.
    fn range(&self) -> Check {
        let (verdict, sentence) = if self.range < 0.5 {
            let why = "Atoms cannot come closer: no law between continuous bodies is as short.";
            (Verdict::Fails, why)
        } else if self.range <= REACH {
            (Verdict::Holds, "Van der Waals forces reach as far.")
        } else {
            let why = "Forces between atoms do not reach so far. The law stands for what a mesh can \
                carry, or for longer things, such as chains: contact comes at larger gaps, and the \
                edges of contacts are blunter than they are.";
            (Verdict::Doubtful, why)
        };
        let range = self.units.say(Dimension::Length, self.model.law.range);
        let here = format!(
            "rho = {range}, {} distances of 0.3 nm between atoms",
            significant(self.range)
        );
        Check::new("Range", here, verdict, sentence)
    }

    /// sigma_max against that of a law of the same energy which reaches from atom to atom.
    fn strength(&self) -> Check {
        let top = self.model.law.traction_max();
        let [here, strongest] =
            [top, top * self.range].map(|stress| self.units.say(Dimension::Stress, stress));
        let (verdict, sentence) = if self.range < 0.5 {
            (Verdict::Fails, "Stronger than atoms hold each other.")
        } else if self.range <= REACH {
            (
                Verdict::Holds,
                "The pull is as strong as that between atoms.",
            )
        } else {
            let why = "Where pull-off is decided by strength, as under a load, flat surfaces hold \
                each other more strongly than this scene says; where by energy, as at the edge of a \
                wide contact, they do not.";
            (Verdict::Doubtful, why)
        };
        let here = format!("sigma_max = {here}, theoretical strength (range 0.3 nm) {strongest}");
        Check::new("Strength", here, verdict, sentence)
    }
}

/// The strain where the law pulls most.
fn strain(model: &Model, atoms: Option<&Atoms<'_>>) -> Check {
    let strain = model.law.traction_max();
    let verdict = smallness(strain);
    let mut sentence = match verdict {
        Verdict::Holds => "Linear elasticity holds up to the edges of contacts.".to_owned(),
        Verdict::Doubtful => {
            "At the edges of contacts linear elasticity is a rough guide.".to_owned()
        }
        Verdict::Fails => "At the edges of contacts linear elasticity does not hold.".to_owned(),
    };
    if let Some(atoms) = atoms.filter(|atoms| atoms.range > REACH) {
        let real = strain * atoms.range;
        if smallness(real) != Verdict::Holds {
            let real = significant(real);
            sentence += &format!(
                " A law of 0.3 nm would strain them by {real}: a body as soft blunts its edges, and \
                 the larger range may stand for that."
            );
        }
    }
    let here = format!("sigma_max/E* = {}", significant(strain));
    Check::new("Largest strain", here, verdict, sentence)
}

/// The slope of the ground where it is touched.
fn slope(model: &Model) -> Option<Check> {
    let (slope, what) = match model.indenter {
        Indenter::Flat => return None,
        Indenter::Hertz(tip) => {
            // JKR at zero load: a^3 = 9 pi gamma R^2/(2 E*).
            let gamma = model.law.surface_energy;
            let slope = (4.5 * PI * gamma / tip.radius).cbrt();
            (slope, "radius of the contact at zero load/R")
        }
        _ => {
            let height = model.indenter.height(&model.grid)?;
            let pitch = [model.grid.spacing(); 2];
            let slope = Statistics::of(&height, pitch, Border::Periodic).gradient;
            (slope, "root mean square slope of the ground")
        }
    };
    let verdict = smallness(slope);
    let sentence = match verdict {
        Verdict::Holds => "The ground is as good as level, as the half-space takes it.",
        Verdict::Doubtful => "The half-space takes slopes for small, which these hardly are.",
        Verdict::Fails => "The half-space takes slopes for small, which these are not.",
    };
    let here = format!("{what} = {}", significant(slope));
    Some(Check::new("Slopes", here, verdict, sentence))
}

/// Whether anything can snap.
fn cell(model: &Model, atoms: Option<&Atoms<'_>>) -> Check {
    let critical = critical_length(&model.law);
    let ratio = model.equivalent_length / critical;
    let mut sentence = if ratio > 1.0 {
        "The cell is long enough for the surface to snap.".to_owned()
    } else {
        "In a cell as short nothing snaps, and nothing is lost.".to_owned()
    };
    let mut here = format!("L/L_c = {}", significant(ratio));
    if let Some(atoms) = atoms {
        // L_c goes as the range squared.
        let [now, real] = [critical, critical / (atoms.range * atoms.range)]
            .map(|length| atoms.units.say(Dimension::Length, length));
        here += &format!(", L_c = {now}");
        if atoms.range > REACH {
            sentence += &format!(" With a range of 0.3 nm L_c would be {real}.");
        }
    }
    Check::new("Length of the cell", here, Verdict::Holds, sentence)
}

/// Which theory of tips is near.
fn tip(model: &Model) -> Option<Check> {
    let Indenter::Hertz(tip) = model.indenter else {
        return None;
    };
    let mu = tabor(tip.radius, model.law.surface_energy, model.law.range);
    let sentence = match mu {
        mu if mu > TABOR[0] => "Soft: the theory of Johnson, Kendall and Roberts is near.",
        mu if mu < TABOR[1] => "Stiff: the theory of Derjaguin, Muller and Toporov is near.",
        _ => "Between soft and stiff tips: neither JKR nor DMT holds.",
    };
    let here = format!("mu_T = {}", significant(mu));
    Some(Check::new(
        "Tabor parameter",
        here,
        Verdict::Holds,
        sentence,
    ))
}

/// Whether the mesh shows the law, and no more than there is.
fn mesh(model: &Model, atoms: Option<&Atoms<'_>>) -> Check {
    let spacing = model.grid.spacing();
    let mut here = format!("mu_rho = {}", significant(model.mu_rho));
    let mut below = false;
    if let Some(Atoms { units, .. }) = atoms {
        here += &format!(", spacing {}", units.say(Dimension::Length, spacing));
        below = spacing * units.si(Dimension::Length) < ATOMS;
    }
    let (verdict, sentence) = if !mesh::is_safe(model.mu_rho) {
        let why = "Too coarse for this law: some jumps may belong to the mesh.";
        (Verdict::Doubtful, why)
    } else if below {
        let why = "The mesh is finer than atoms: a body of atoms has no such waves.";
        (Verdict::Doubtful, why)
    } else {
        (Verdict::Holds, "The mesh shows the law.")
    };
    Check::new("Mesh", here, verdict, sentence)
}

/// Whether heat takes the surface over its barriers.
fn heat(model: &Model) -> Option<Check> {
    let cell = model.in_kt(model.law.surface_energy)?;
    let (verdict, sentence) = if BARRIER * cell > HOT {
        let why = "Heat matters only where a barrier is about to vanish.";
        (Verdict::Holds, why)
    } else {
        let why = "Heat takes the surface over its barriers: it snaps earlier, and by chance.";
        (Verdict::Doubtful, why)
    };
    let temperature = model.units?.temperature;
    let here = format!(
        "gamma L^2 = {} kT at {temperature} K, barriers are a thousandth of it",
        significant(cell)
    );
    Some(Check::new("No heat", here, verdict, sentence))
}

/// One equation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Equation {
    /// What it is about.
    pub name: &'static str,
    /// The formula.
    pub formula: String,
    /// What it says.
    pub sentence: &'static str,
    /// What stands in it in this scene.
    pub here: String,
}

/// The five equations with the numbers of this scene, of its present state, and of what it lost so
/// far.
pub fn equations(scene: &Scene, model: &Model, record: &LoopRecord) -> [Equation; 5] {
    let now = record.states.last();
    [
        energy(model, now),
        law(model),
        equilibrium(model, now),
        limit(scene, model),
        loss(model, record),
    ]
}

fn energy(model: &Model, now: Option<&StateRecord>) -> Equation {
    let gamma = model.law.surface_energy;
    let now = now.map_or_else(String::new, |now| {
        let unit = model.unit(Dimension::SurfaceEnergy);
        format!(
            "; here V/A = {}",
            unit.say(now.energy / gamma, 4, "gamma_0")
        )
    });
    Equation {
        name: "Energy",
        formula: "V/A = ∑_{q≠0} (q E*/4) |u~_q|^2 + ⟨gamma(g)⟩".to_owned(),
        sentence: "Bending the surface costs elastic energy, the more the shorter the wave; the \
                   adhesion pays for it.",
        here: format!(
            "L = {}, longest wave q = 2pi/L = {:.4} /rho{now}",
            model
                .unit_across()
                .say(model.grid.length / model.law.range, 1, "rho"),
            model.grid.q1() * model.law.range
        ),
    }
}

fn law(model: &Model) -> Equation {
    let law = &model.law;
    let here = match model.units {
        None => format!(
            "gamma_0 = {:.4} E* times length, rho = {:.4}, sigma_max = {:.4} E*",
            law.surface_energy,
            law.range,
            law.traction_max()
        ),
        Some(units) => {
            let gamma = units.say(Dimension::SurfaceEnergy, law.surface_energy);
            let rho = units.say(Dimension::Length, law.range);
            let [top, modulus] =
                [law.traction_max(), 1.0].map(|stress| units.say(Dimension::Stress, stress));
            format!("gamma_0 = {gamma}, rho = {rho}, sigma_max = {top}, E* = {modulus}")
        }
    };
    Equation {
        name: "Cohesive law",
        formula: format!("gamma(g) = gamma_0 {}", law.shape.form().formula()),
        sentence: "How the energy of two facing pieces of surface depends on the gap between them.",
        here,
    }
}

fn equilibrium(model: &Model, now: Option<&StateRecord>) -> Equation {
    Equation {
        name: "Equilibrium",
        formula: "(q E*/2) u~_q + gamma′(g)_q = 0,   sigma(u0) = ⟨gamma′(g)⟩".to_owned(),
        sentence: "At each wave the body pulls back as hard as the adhesion pulls; the mean stress \
                   is what the machine feels.",
        here: now.map_or_else(String::new, |now| {
            let off = if now.residual == 0.0 {
                "exact".to_owned()
            } else {
                format!("off by {:.0e} sigma_max at most", now.residual)
            };
            let [length, stress] = [Dimension::Length, Dimension::Stress].map(|of| model.unit(of));
            let u0 = length.say(now.mean_displacement / model.law.range, 4, "rho");
            let sigma = stress.say(now.stress_over_max, 4, "sigma_max");
            format!("u0 = {u0}, sigma = {sigma}, {off}")
        }),
    }
}

fn limit(scene: &Scene, model: &Model) -> Equation {
    let control = scene.control();
    let branch = FlatBranch::new(model.law, model.equivalent_length, control);
    let unit = model.unit(Dimension::Length);
    let say = |u0: f64| unit.say(u0 / model.law.range, 4, "rho");
    let here = match (branch.unstable_gaps(), control) {
        (None, _) => "nowhere: the law is never so soft".to_owned(),
        (Some((lower, _)), Control::Load) => {
            format!("at u0 = {} on retraction", say(lower))
        }
        (Some((lower, upper)), _) => format!(
            "at u0 = {} on approach, {} on retraction",
            say(upper),
            say(lower)
        ),
    };
    let (formula, sentence) = match control {
        _ if !branch.gives_way_as_a_block() => (
            "gamma″(u0) + pi E*/L = 0",
            "The flat surface snaps where the pull grows faster with depth than the longest wave \
             resists (of a layer: its softest).",
        ),
        Control::Load => (
            "gamma″(u0) = 0",
            "Under a load the flat surface snaps as a block, where the pull is strongest.",
        ),
        _ => (
            "gamma″(u0) + k = 0",
            "The flat surface snaps as a block where the pull grows faster with depth than the \
             spring resists.",
        ),
    };
    Equation {
        name: "Limit of the flat state",
        formula: formula.to_owned(),
        sentence,
        here,
    }
}

fn loss(model: &Model, record: &LoopRecord) -> Equation {
    let unit = model.unit(Dimension::SurfaceEnergy);
    Equation {
        name: "Loss",
        formula: "gamma_hys = ∮ sigma d u0 = ∑_jumps (V_before - V_after)/A".to_owned(),
        sentence: "What a closed loop loses is the area between its two curves, and just as well \
                   the sum of what each jump sets free.",
        here: format!(
            "{}, {} set free so far",
            record.tally(),
            unit.say(record.released_energy_sum(), 4, "gamma_0")
        ),
    }
}
