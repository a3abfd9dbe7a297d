//! How far pictures of a scene reach, fixed before anything is computed: u0, gap and stress. Axes
//! and colours then keep their meaning while u0 moves.

use crate::physics::indenter::Indenter;
use crate::scene::{Model, Scene, Turn};

/// Ends of u0 (lower, upper; length).
pub fn limits(scene: &Scene, model: &Model) -> (f64, f64) {
    let lower = match scene.drive.turn {
        Turn::At(turn) => turn,
        Turn::ZeroLoad => -0.6 * model.indenter.ground().relief(&model.law) - model.law.range,
    };
    (lower, scene.drive.start)
}

/// The largest gap of the colour scale: fixed by the scene, so that colours keep their meaning
/// while u0 moves.
pub fn gap_scale(scene: &Scene, model: &Model) -> f64 {
    let rho = model.law.range;
    let wanted = match model.indenter {
        Indenter::Flat => 1.8 * scene.drive.start,
        _ => (2.5 * model.indenter.ground().relief(&model.law)).max(6.0 * rho),
    };
    nice(wanted / rho) * rho
}

/// Lower and upper end of the stress axis, in units of sigma_max.
pub fn stress_scale(scene: &Scene, model: &Model) -> (f64, f64) {
    let law = &model.law;
    if model.indenter == Indenter::Flat {
        let at_turn = law.at(limits(scene, model).0).traction / law.traction_max();
        return (at_turn.clamp(-1.5, 0.0) - 0.06, 1.08);
    }
    // Between full contact and a few asperities nothing is known beforehand.
    let Some(pull_off) = model.indenter.ground().pull_off(law, &model.grid) else {
        return (-0.6, 0.6);
    };
    let top = (1.5 * pull_off / law.traction_max()).min(1.08);
    (-0.5 * top, top)
}

/// The next of 1, 1.5, 2, 3, 4, 5, 6, 8, 10, ... at or above `x`.
pub fn nice(x: f64) -> f64 {
    let decade = 10f64.powf(x.max(1e-12).log10().floor());
    let steps = [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0];
    steps
        .into_iter()
        .map(|s| s * decade)
        .find(|&s| s >= x * (1.0 - 1e-9))
        .unwrap_or(10.0 * decade)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::indenter::Hertz;
    use crate::scene::tests::fig2;
    use crate::scene::{Drive, Range};

    #[test]
    fn the_relief_of_a_tip_is_that_of_jkr_in_any_unit_of_length() {
        let tip = |unit: f64| {
            let mut scene = fig2(64);
            scene.cell.length *= unit;
            scene.law.surface_energy *= unit;
            scene.law.range = Range::Length(unit);
            scene.indenter = Indenter::Hertz(Hertz {
                radius: 30.0 * unit,
            });
            scene.drive = Drive {
                start: 6.0 * unit,
                turn: Turn::ZeroLoad,
                step: 0.1 * unit,
            };
            let model = scene.model().unwrap();
            (
                model.indenter.ground().relief(&model.law) / unit,
                gap_scale(&scene, &model) / unit,
                stress_scale(&scene, &model),
            )
        };
        let a = (4.5 * std::f64::consts::PI * 0.15 * 900.0_f64).cbrt();
        let (relief, gap, stress) = tip(1.0);
        assert!((relief - a * a / 30.0).abs() < 1e-12 * relief);
        for unit in [1e-100, 1e100] {
            let (other, other_gap, other_stress) = tip(unit);
            assert!(
                (other / relief - 1.0).abs() < 1e-9 && (other_gap / gap - 1.0).abs() < 1e-9,
                "{unit}: {other}, {other_gap}"
            );
            assert!(
                (other_stress.1 / stress.1 - 1.0).abs() < 1e-9,
                "{unit}: {other_stress:?}"
            );
        }
    }

    #[test]
    fn nice_numbers_are_at_or_above_what_they_round() {
        assert_eq!(
            [nice(7.56), nice(1.0), nice(0.14), nice(99.0)],
            [8.0, 1.0, 0.15000000000000002, 100.0]
        );
    }
}
