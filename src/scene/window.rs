//! Between which values of the control, and of u0, a drive goes.

use super::{Drive, Model, Scene, Turn};
use crate::physics::control::Control;
use crate::physics::indenter::Indenter;
use crate::physics::theory::boundary;

/// Ends of what is driven (lower, upper; length, E* of a load).
pub fn of_control(scene: &Scene, model: &Model) -> (f64, f64) {
    let lower = match scene.drive.turn {
        Turn::At(turn) => turn,
        Turn::ZeroLoad => -0.6 * model.indenter.ground().relief(&model.law) - model.law.range,
    };
    (lower, scene.drive.start)
}

/// Ends of u0 (lower, upper; length) on the drive.
pub fn of_u0(scene: &Scene, model: &Model) -> [f64; 2] {
    let (control, law) = (scene.control(), &model.law);
    let (lower, upper) = of_control(scene, model);
    if !control.frees_mean() {
        return [lower, upper];
    }
    // The machine pulls where the body does not touch.
    let upper = match control {
        Control::Load => Control::stop(law),
        _ => upper,
    };
    if model.indenter != Indenter::Flat {
        let depth = 0.6 * model.indenter.ground().relief(law) + law.range;
        return [-depth, upper];
    }
    // The flat state in contact that the turn holds; a Mie law has no gap at or below zero.
    let contact = law.equilibrium_gap();
    let pressed = |gap: f64| {
        let [held, _] = control.balanced(gap, law.at(gap).traction);
        !(held >= lower)
    };
    let deepest = contact - 0.9 * law.contact_gap().max(contact);
    [boundary(deepest, law.contact_gap(), pressed), upper]
}

/// The same scene with u0 driven over the window of u0.
pub fn at_fixed_u0(scene: &Scene, model: &Model) -> Scene {
    let mut fixed = scene.clone();
    if scene.control().frees_mean() {
        let [lower, upper] = of_u0(scene, model);
        fixed.drive = Drive {
            control: Control::Displacement,
            start: upper,
            turn: Turn::At(lower),
            step: STEP * model.law.range,
        };
    }
    fixed
}

/// Step of such a drive, in ranges.
const STEP: f64 = 0.1;
