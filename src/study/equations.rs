//! The model's five equations, each with a sentence and with the numbers of a scene.
//!
//! Formulas are lines of text as diagrams have them: names of Greek letters, `_` and `^`. E* is 1.

use crate::follow::flat_branch::FlatBranch;
use crate::follow::record::{LoopRecord, StateRecord};
use crate::physics::control::Control;
use crate::physics::parameter::Dimension;
use crate::scene::{Model, Scene};

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
