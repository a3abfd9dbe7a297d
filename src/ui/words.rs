//! What the words on the screen mean: each has a card of one sentence and, where there is one, an
//! equation, which shows while the pointer rests on it. Numbers of the scene have their symbol, unit
//! and what is allowed from the table of parameters.

use super::theme;
use crate::physics::parameter::Parameter;
use egui::{Response, RichText, Ui};

/// Width of a card, and the size of an equation (points).
const WIDTH: f32 = 320.0;
const EQUATION: f32 = 17.0;

/// Word, sentence, equation. Equations are written as [`crate::plot::typeset`] reads them.
const WORDS: &[(&str, &str, &str)] = &[
    // What the scene is made of.
    (
        "Ground",
        "The rigid body below; it never deforms.",
        "g = u - h",
    ),
    (
        "Law",
        "How the energy of two facing pieces of surface depends on the gap between them; its slope is the traction.",
        "sigma(g) = gamma′(g)",
    ),
    (
        "Machine",
        "What holds the body from above and moves it: stiff, through a spring, or by a weight.",
        "sigma = k (w - u0)",
    ),
    (
        "Length",
        "The side of the square cell, which repeats itself along x and y; the longest bump that fits in bends the body least.",
        "q_1 = 2pi/L",
    ),
    (
        "Range",
        "How far the stickiness reaches; far away a Morse law falls by a factor e over one range.",
        "gamma(g) ∼ e^{-g/rho}",
    ),
    (
        "Advanced",
        "Numbers for those who know them: mesh, units, law and drive, body, accuracy, method.",
        "",
    ),
    (
        "Mesh number μᵨ",
        "Compares the range of the adhesion with the spacing of the mesh; up to 0.5 jumps belong to the physics, above it the mesh makes jumps of its own.",
        "max(-gamma″) = mu_rho^2 E*/Δa",
    ),
    (
        "Follows",
        "What changes when the mesh number does: the range of the law, or the number of points.",
        "",
    ),
    (
        "range",
        "The mesh stays, and the range of the law follows the mesh number.",
        "mu_rho ∼ sqrt(Δa)/rho",
    ),
    (
        "mesh",
        "The range stays, and the number of points follows the mesh number.",
        "Δa = L/n",
    ),
    (
        "Points n",
        "Mesh points along a side of the cell.",
        "Δa = L/n",
    ),
    (
        "Line cell",
        "The surface varies along x alone: much faster, and without bulges and dimples.",
        "u(x, y) = u(x)",
    ),
    (
        "Units",
        "Without units the contact modulus is 1 and lengths are told in any one unit; with them the scene can be compared with a real one.",
        "",
    ),
    (
        "Contact modulus",
        "How stiff the body is against being dented.",
        "E* = E/(1 - nu^2)",
    ),
    (
        "Temperature",
        "Only for comparing barriers with thermal energy: nothing here is moved by heat.",
        "k_B T",
    ),
    (
        "Surface energy",
        "The energy that it takes to part one unit of area from the ground.",
        "gamma_0 = -min gamma(g)",
    ),
    (
        "Mie exponent",
        "How steeply the law repels (m) and attracts (n).",
        "m > n",
    ),
    (
        "Ratio of ranges",
        "The range of the repulsion over that of the attraction.",
        "",
    ),
    (
        "Start of the drive",
        "Where approach begins and retraction ends.",
        "",
    ),
    (
        "Turn of the drive",
        "Where approach becomes retraction.",
        "",
    ),
    (
        "Step of the drive",
        "The largest step from one equilibrium to the next; jumps are located much closer.",
        "",
    ),
    (
        "Stiffness of the spring",
        "How hard the spring pulls for each length by which it is drawn, per area.",
        "sigma = k (w - u0)",
    ),
    (
        "Body",
        "The soft body above: endless, or a layer bonded to a rigid plate.",
        "V_el/A = ∑_{q≠0} (q E*/4) |u~_q|^2",
    ),
    (
        "Layer thickness",
        "From the surface to the rigid plate.",
        "",
    ),
    (
        "Poisson's ratio",
        "How much the material gets thinner when it is drawn; at 0.5 it keeps its volume.",
        "",
    ),
    (
        "Accuracy",
        "The relative error of loss and jumps that an automatic mesh must meet.",
        "",
    ),
    (
        "Seed",
        "Begins the random numbers of the small disturbances; the same seed gives the same walk.",
        "",
    ),
    (
        "Model",
        "Which part of the cell is computed: the rest follows by symmetry, and is watched.",
        "",
    ),
    (
        "Method",
        "How a state is brought to rest after each step.",
        "(q E*/2) u~_q + gamma′(g)_q = 0",
    ),
    (
        "Newton-Krylov",
        "Solves the linearised balance again and again: fastest here, and exact.",
        "",
    ),
    (
        "L-BFGS",
        "Goes down in energy and learns the curvature from its last steps.",
        "",
    ),
    (
        "conjugate gradients",
        "Goes down in energy along directions that do not undo each other.",
        "",
    ),
    (
        "FIRE",
        "Slides down in energy with inertia, and stops where it would climb.",
        "",
    ),
    (
        "GFMD, tuned",
        "Damped motion of the waves with well chosen masses, until it rests.",
        "",
    ),
    (
        "GFMD, as in the paper",
        "The published dynamics: a fixed number of steps, after which states may not rest, and are drawn hollow.",
        "",
    ),
    (
        "Click at a snap",
        "A short sound whenever the surface jumps, by the desktop's own player of sounds.",
        "",
    ),
    // What is seen.
    (
        "u0",
        "The distance of the surface from the ground on average: what is moved.",
        "u0 = ⟨u⟩",
    ),
    (
        "Target",
        "Where the surface is asked to go; it follows in small steps along the whole way.",
        "",
    ),
    (
        "Surface",
        "The pattern of the surface, whether it is stable there, and its mean distance from the ground.",
        "u0 = ⟨u⟩",
    ),
    (
        "Loss",
        "The energy that a closed loop turns into heat, per area: the area between the two curves, and the sum over all jumps.",
        "gamma_hys = ∮ sigma du0 = ∑ (V_before - V_after)/A",
    ),
    ("flat", "Everywhere the same gap.", "u(x, y) = u0"),
    ("bulge", "An island of contact, closed all round.", ""),
    ("ridge", "A band of contact that runs through the cell.", ""),
    (
        "dimple",
        "Contact all around an island that is still apart.",
        "",
    ),
    ("contact", "The surfaces touch everywhere.", ""),
    (
        "apart",
        "They do not touch anywhere, though the gap varies.",
        "",
    ),
    (
        "pattern",
        "What the contact looks like before and after: flat, bulge, ridge or dimple.",
        "",
    ),
    (
        "stable",
        "At rest, and coming back after any small push.",
        "λ_min > 0",
    ),
    ("unstable", "At rest, but a small push grows.", "λ_min < 0"),
    (
        "not converged",
        "Not at rest: the method was left before forces balanced.",
        "",
    ),
    (
        "read off",
        "Between two states that were solved, and as exact as they.",
        "",
    ),
    (
        "approach",
        "Recorded while the distance became smaller.",
        "",
    ),
    (
        "retraction",
        "Recorded while the distance became larger.",
        "",
    ),
    (
        "flat state",
        "What the stress would be if the surface stayed flat.",
        "sigma(u0) = gamma′(u0)",
    ),
    (
        "flat state, unstable",
        "Here a flat surface would be at rest, but the smallest bump grows.",
        "gamma″(u0) + pi E*/L < 0",
    ),
    (
        "jump",
        "The surface snaps into another state at the same setting of the machine, and sets energy free.",
        "ΔV = V_before - V_after",
    ),
    (
        "lost energy",
        "The area between both ways: what one loop turns into heat.",
        "∮ sigma du0",
    ),
    (
        "live",
        "The loop as it is foreseen, computed while you change things; nobody has walked it yet.",
        "",
    ),
    (
        "next jump",
        "Where the present pattern is expected to give way.",
        "λ_min = 0",
    ),
    (
        "earlier",
        "A path that was left when the surface was put back into a stored state; a click shows its states.",
        "",
    ),
    ("guess", "Where somebody expects the next jump.", ""),
    (
        "machine",
        "What the machine allows: where its line touches the curve, the body snaps along it.",
        "sigma = k (w - u0)",
    ),
    ("theory", "What theory says for a range of zero.", ""),
    // Jumps.
    (
        "Released",
        "What all jumps so far turned into heat, per area.",
        "∑ (V_before - V_after)/A",
    ),
    (
        "released",
        "What a jump turned into heat, per area.",
        "(V_before - V_after)/A",
    ),
    ("cause", "Why the state before could not stay.", ""),
    (
        "The jump",
        "Which pattern jumped into which, and on which way.",
        "",
    ),
    (
        "Replay the jump",
        "Shows the jump again in map, profile and plot, slowly.",
        "",
    ),
    ("Moment of the jump", "Moves through the jump by hand.", ""),
    ("Close the replay", "Back to the present.", ""),
    (
        "Copy the jumps",
        "The list as text, to be pasted elsewhere.",
        "",
    ),
    (
        "Keep:",
        "Keeps a loop on the plot to compare others with it (L).",
        "",
    ),
    (
        "Keep what was walked",
        "Keeps the curve that is on the plot.",
        "",
    ),
    (
        "Keep the live loop",
        "Keeps what is foreseen, before it was walked.",
        "",
    ),
    (
        "states",
        "The smallest stiffness of the states along the way: where it reaches zero, the pattern gives way.",
        "λ_min",
    ),
    (
        "time steps",
        "How long a time step the paper's dynamics bears, and how short one it should have.",
        "",
    ),
    (
        "The next jump",
        "Extrapolated from the smallest stiffness on the way, or exact where theory knows it.",
        "λ_min(u0) = 0",
    ),
    ("time", "Errors against seconds of the processor.", ""),
    (
        "transforms",
        "Errors against the number of Fourier transforms, which is the same on every machine.",
        "",
    ),
    (
        "Energy",
        "Elastic energy of the waves, and the adhesion's.",
        "",
    ),
    ("Cohesive law", "Energy against gap.", ""),
    ("Equilibrium", "Forces balance at each wave.", ""),
    (
        "Limit of the flat state",
        "Where the flat surface gives way.",
        "",
    ),
    ("Cancel", "Ends the computation; what is known stays.", ""),
    (
        "Compute",
        "Computes the loops one after the other; their marks come as they are ready.",
        "",
    ),
    (
        "Number that goes",
        "The number of the scene that is varied, with a loop at each value.",
        "",
    ),
    ("from", "The value of the first loop.", ""),
    ("to", "The value of the last loop.", ""),
    ("loops", "How many values, both ends among them.", ""),
    (
        "log",
        "Values by equal factors, where both ends are above zero.",
        "",
    ),
    (
        "Quantity that is drawn",
        "What the marks tell of each loop.",
        "",
    ),
    (
        "height (dark is low)",
        "The ground as seen from above.",
        "h(x, y)",
    ),
    ("profile", "The ground along x.", "h(x)"),
    (
        "distribution of heights",
        "How much of the ground lies at which height.",
        "",
    ),
    (
        "power spectrum",
        "How much waves of each length contribute to the roughness.",
        "C(q) ∼ |h~_q|^2",
    ),
    ("Fig.", "A figure of the paper, computed anew.", ""),
];

/// The card of a word, shown while the pointer rests on what it names; nothing for a word that has
/// none.
pub fn explain(response: Response, word: &str) -> Response {
    let Some((word, sentence, equation)) = WORDS.iter().find(|(known, ..)| *known == word) else {
        return response;
    };
    card_of(response, |ui| card(ui, word, sentence, equation))
}

/// The card of a number of the scene.
pub fn explain_parameter(response: Response, parameter: &Parameter) -> Response {
    card_of(response, |ui| {
        let known = WORDS.iter().find(|(word, ..)| *word == parameter.label);
        let (_, sentence, equation) = known.copied().unwrap_or_default();
        card(ui, &parameter.title(), sentence, equation);
        let unit = parameter.unit.word();
        let unit = if unit.is_empty() {
            "a pure number"
        } else {
            unit
        };
        let words = format!(
            "Unit: {unit}. Allowed: {}. A double click on the name brings back what the scene was opened with.",
            parameter.allowed()
        );
        ui.label(RichText::new(words).small().weak());
    })
}

/// Shows a card over what is there, whether it can be used or not.
fn card_of(response: Response, show: impl Fn(&mut Ui)) -> Response {
    if response.enabled() {
        response.on_hover_ui(show)
    } else {
        response.on_disabled_hover_ui(show)
    }
}

/// What stands on a card.
pub fn card(ui: &mut Ui, title: &str, sentence: &str, equation: &str) {
    ui.set_max_width(WIDTH);
    ui.label(RichText::new(title).strong());
    if !sentence.is_empty() {
        ui.label(sentence);
    }
    if !equation.is_empty() {
        let ink = ui.visuals().strong_text_color();
        ui.label(theme::set(equation, EQUATION, ink));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_has_one_card_of_one_sentence() {
        for (i, (word, sentence, _)) in WORDS.iter().enumerate() {
            assert!(
                WORDS[..i].iter().all(|(other, ..)| other != word),
                "{word} twice"
            );
            assert!(
                sentence.ends_with('.') && !sentence.contains(". "),
                "{word}: {sentence}"
            );
        }
    }
}
