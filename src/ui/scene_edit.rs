//! What follows what when a value of the scene is edited: range or mesh after mu_rho, and the drive after the law.

use crate::physics::indenter::Indenter;
use crate::physics::law::{Law, Shape};
use crate::physics::mesh_rule;
use crate::physics::theory::flat;
use crate::scene::{Drive, Model, Points, Range, Scene, Turn};

/// What follows when mu_rho is changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Follows {
    /// The mesh stays, the range of the law follows.
    #[default]
    Range,
    /// The law stays, the mesh follows.
    Mesh,
}

/// Lower and upper end of the mu_rho slider.
pub const MU_RHO: (f64, f64) = (0.25, 2.0);

/// The named meshes of Table 1 by value, and before them the one above which the mesh lies.
pub const TICKS: [(&str, f64); 7] = [("safe", mesh_rule::SAFE), tick(1), tick(3), tick(5), tick(0), tick(2), tick(4)];

const fn tick(row: usize) -> (&'static str, f64) {
    (mesh_rule::TABLE_1[row].author, mesh_rule::TABLE_1[row].mu_rho)
}

/// The scene with another mu_rho.
pub fn with_mu_rho(scene: &Scene, model: &Model, mu_rho: f64, follows: Follows) -> Scene {
    let mut scene = frozen(scene, model);
    match follows {
        Follows::Range => {
            scene.law.range = Range::Length(mesh_rule::range_for_mu_rho(&model.law, model.grid.spacing(), mu_rho));
            fit_drive(&mut scene);
        }
        Follows::Mesh => {
            let n =
                (mesh_rule::points_for_mu_rho(&model.law, model.grid.length, mu_rho) / 2.0).round().clamp(4.0, 512.0) as usize * 2;
            scene.cell.points = if model.grid.is_line() { Points::Line(n) } else { Points::Square(n) };
        }
    }
    scene
}

/// The scene with another cohesive law of the same range and surface energy.
pub fn with_shape(scene: &Scene, model: &Model, shape: Shape) -> Scene {
    let mut scene = frozen(scene, model);
    scene.law.shape = shape;
    fit_drive(&mut scene);
    scene
}

/// The scene with another surface energy.
pub fn with_surface_energy(scene: &Scene, model: &Model, surface_energy: f64) -> Scene {
    let mut scene = frozen(scene, model);
    scene.law.surface_energy = surface_energy;
    fit_drive(&mut scene);
    scene
}

/// The scene with another range of its law.
pub fn with_range(scene: &Scene, model: &Model, range: f64) -> Scene {
    let mut scene = frozen(scene, model);
    scene.law.range = Range::Length(range);
    fit_drive(&mut scene);
    scene
}

/// The scene in another cell.
pub fn with_length(scene: &Scene, model: &Model, length: f64) -> Scene {
    let mut scene = frozen(scene, model);
    scene.cell.length = length;
    fit_drive(&mut scene);
    scene
}

/// The scene on another mesh; the range stays what it is.
pub fn with_points(scene: &Scene, model: &Model, points: Points) -> Scene {
    let mut scene = frozen(scene, model);
    scene.cell.points = points;
    scene
}

/// The scene with what was left open decided, so that editing one value does not move another.
fn frozen(scene: &Scene, model: &Model) -> Scene {
    let mut scene = scene.clone();
    scene.law.range = Range::Length(model.law.range);
    if scene.cell.points == Points::Auto {
        scene.cell.points = Points::Square(model.grid.nx);
    }
    scene
}

/// On flat ground: moves the drive if it no longer encloses the instabilities of the edited law, else leaves it alone.
fn fit_drive(scene: &mut Scene) {
    let (Indenter::Flat, Ok(model)) = (scene.indenter, Scene { drive: SAFE, ..scene.clone() }.model()) else { return };
    let law = model.law;
    let Some((lower, upper)) = flat::limits(&law, model.grid.length) else { return };
    let Drive { start, turn: Turn::At(turn), .. } = scene.drive else { return };
    let pressed = -law.at(turn).traction / law.traction_max();
    let fits =
        start > upper + 0.2 * law.range && start < upper + 6.0 * law.range && turn < lower - 0.1 * law.range && pressed < 1.0;
    if !fits {
        scene.drive = Drive { start: upper + 1.1 * law.range, turn: Turn::At(turn_for(&law, lower)), step: 0.02 * law.range };
    }
}

/// A drive that no law refuses, to ask for the model of a scene whose own drive may not fit any more.
const SAFE: Drive = Drive { start: 2.0, turn: Turn::At(1.0), step: 0.1 };

/// A turning point deep enough for the flat state to be stable again, yet not pressed hard: traction 0.6 sigma_max below its maximum.
fn turn_for(law: &Law, lower: f64) -> f64 {
    let (mut low, mut high) = (1e-3 * law.contact_gap(), law.contact_gap());
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if law.at(middle).traction < 0.6 * law.traction_max() {
            low = middle;
        } else {
            high = middle;
        }
    }
    high.min(lower - 0.2 * law.range)
}

/// Ends of the u0 slider (lower, upper).
pub fn limits(scene: &Scene, model: &Model) -> (f64, f64) {
    let lower = match scene.drive.turn {
        Turn::At(turn) => turn,
        Turn::ZeroLoad => -0.6 * relief(model) - model.law.range,
    };
    (lower, scene.drive.start)
}

/// The length that scales pictures of uneven ground: a^2/R of a tip's contact at zero load (JKR), else the depth of the mean height
/// below the crest (about three times its root mean square on rough ground); 0 on flat ground.
pub fn relief(model: &Model) -> f64 {
    match model.indenter {
        Indenter::Flat => 0.0,
        Indenter::Hertz { radius } => {
            // a^2/R with a^3 = 4.5 pi gamma R^2, so that no unit of length overflows.
            radius * (4.5 * std::f64::consts::PI * model.law.surface_energy / radius).cbrt().powi(2)
        }
        Indenter::Wave { amplitude, periods } => amplitude * periods.iter().filter(|&&p| p > 0).count() as f64,
        Indenter::Rough(rough) => 3.0 * rough.rms,
    }
}

/// The scene on other ground. The drive goes from where nothing touches to zero load on a tip, and far into the valleys of waves and
/// rough ground.
pub fn with_ground(scene: &Scene, model: &Model, indenter: Indenter) -> Scene {
    let mut scene = frozen(scene, model);
    scene.indenter = indenter;
    let (rho, depth) = (model.law.range, relief(&Model { indenter, ..model.clone() }));
    let (start, step) = (6.0 * rho, 0.1 * rho);
    match indenter {
        Indenter::Flat => {
            scene.drive = SAFE;
            fit_drive(&mut scene);
        }
        Indenter::Hertz { .. } => scene.drive = Drive { start, turn: Turn::ZeroLoad, step },
        _ => scene.drive = Drive { start, turn: Turn::At(-0.85 * depth), step },
    }
    scene
}

/// The largest gap of the colour scale: fixed by the scene, so that colours keep their meaning while u0 moves.
pub fn gap_scale(scene: &Scene, model: &Model) -> f64 {
    let rho = model.law.range;
    let wanted = match model.indenter {
        Indenter::Flat => 1.8 * scene.drive.start,
        _ => (2.5 * relief(model)).max(6.0 * rho),
    };
    nice(wanted / rho) * rho
}

/// Lower and upper end of the stress axis, in units of sigma_max.
pub fn stress_scale(scene: &Scene, model: &Model) -> (f64, f64) {
    let law = &model.law;
    let pull_off = match model.indenter {
        Indenter::Flat => {
            let at_turn = law.at(limits(scene, model).0).traction / law.traction_max();
            return (at_turn.clamp(-1.5, 0.0) - 0.06, 1.08);
        }
        Indenter::Hertz { radius } if !model.grid.is_line() => {
            1.5 * std::f64::consts::PI * law.surface_energy * radius / model.grid.length.powi(2)
        }
        // Between full contact and a few asperities nothing is known beforehand.
        Indenter::Wave { .. } | Indenter::Rough(_) => return (-0.6, 0.6),
        Indenter::Hertz { radius } => {
            3.0 * law.surface_energy * (std::f64::consts::PI * radius / (16.0 * law.surface_energy)).cbrt() / model.grid.length
        }
    };
    let top = (1.5 * pull_off / law.traction_max()).min(1.08);
    (-0.5 * top, top)
}

/// The next of 1, 1.5, 2, 3, 4, 5, 6, 8, 10, ... at or above `x`.
pub fn nice(x: f64) -> f64 {
    let decade = 10f64.powf(x.max(1e-12).log10().floor());
    let steps = [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0];
    steps.into_iter().map(|s| s * decade).find(|&s| s >= x * (1.0 - 1e-9)).unwrap_or(10.0 * decade)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::storage::{presets, scene_file};

    fn fig2() -> Scene {
        scene_file::parse(presets::find("fig2").unwrap().text, "fig2.toml").unwrap()
    }

    #[test]
    fn the_drive_encloses_both_instabilities_after_any_edit_of_law_or_mu_rho() {
        let scene = fig2();
        let model = scene.model().unwrap();
        let mut edited: Vec<Scene> = Shape::all().into_iter().map(|s| with_shape(&scene, &model, s)).collect();
        edited.extend([0.25, 0.35, 0.5, 0.7].map(|mu| with_mu_rho(&scene, &model, mu, Follows::Range)));
        for scene in edited {
            let model = scene.model().unwrap_or_else(|e| panic!("{e}"));
            let Some((lower, upper)) = flat::limits(&model.law, model.grid.length) else { continue };
            let (turn, start) = limits(&scene, &model);
            assert!(turn < lower && upper < start, "{turn} {lower} {upper} {start} of {}", scene.law.shape.word());
        }
    }

    #[test]
    fn mu_rho_comes_back_as_it_was_set_whatever_follows() {
        let scene = fig2();
        let model = scene.model().unwrap();
        for (follows, tolerance) in [(Follows::Range, 1e-12), (Follows::Mesh, 0.02)] {
            let model = with_mu_rho(&scene, &model, 0.45, follows).model().unwrap();
            assert!((model.mu_rho - 0.45).abs() < tolerance, "{}", model.mu_rho);
        }
    }

    #[test]
    fn ticks_are_few_whatever_the_ends_are() {
        use crate::plot::ticks::within;
        assert_eq!(within(0.2, 1.0, 4.0), (vec![0.2, 0.4, 0.6000000000000001, 0.8, 1.0], 0.2));
        for (low, high) in [(1e17 - 16.0, 1e17), (-1e220, 1e220), (1.0, 1.0), (0.0, f64::INFINITY), (f64::NAN, 1.0), (3.0, 2.0)] {
            assert!(within(low, high, 9.0).0.len() <= 60, "{low} {high}");
        }
    }

    #[test]
    fn the_reliefs_of_a_tip_is_that_of_jkr_in_any_unit_of_length() {
        let tip = |unit: f64| {
            let mut scene = fig2();
            scene.cell.length *= unit;
            scene.law.surface_energy *= unit;
            scene.law.range = Range::Length(unit);
            scene.indenter = Indenter::Hertz { radius: 30.0 * unit };
            scene.drive = Drive { start: 6.0 * unit, turn: Turn::ZeroLoad, step: 0.1 * unit };
            let model = scene.model().unwrap();
            (relief(&model) / unit, gap_scale(&scene, &model) / unit, stress_scale(&scene, &model))
        };
        let a = (4.5 * std::f64::consts::PI * 0.15 * 900.0_f64).cbrt();
        let (relief, gap, stress) = tip(1.0);
        assert!((relief - a * a / 30.0).abs() < 1e-12 * relief);
        for unit in [1e-100, 1e100] {
            let (other, other_gap, other_stress) = tip(unit);
            assert!((other / relief - 1.0).abs() < 1e-9 && (other_gap / gap - 1.0).abs() < 1e-9, "{unit}: {other}, {other_gap}");
            assert!((other_stress.1 / stress.1 - 1.0).abs() < 1e-9, "{unit}: {other_stress:?}");
        }
    }

    #[test]
    fn nice_numbers_are_at_or_above_what_they_round() {
        assert_eq!([nice(7.56), nice(1.0), nice(0.14), nice(99.0)], [8.0, 1.0, 0.15000000000000002, 100.0]);
    }
}
