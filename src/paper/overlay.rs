//! Theory over the live loop, in the units of the scene at hand: the flat state and the patterns of
//! zero range, or JKR's tip.

use super::scenes::units_of;
use crate::numerics::cancel::Cancel;
use crate::physics::body::Body;
use crate::physics::indenter::{Hertz, Indenter};
use crate::physics::theory::circular;
use crate::physics::theory::jkr::{Contact, Jkr, PeriodicJkr};
use crate::physics::theory::ridge;
use crate::plot::scale::steps;
use crate::scene::Model;

/// Points of a curve.
const POINTS: usize = 160;
/// The same for a tip, whose states are dearer.
const TIP_POINTS: usize = 60;
/// Largest contact radius over the length of the cell: beyond, images touch.
const LARGEST_CONTACT: f64 = 0.4;

/// p~(u~) of the patterns of an adhesion without range: the same for every scene on flat ground.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ZeroRange {
    curves: Vec<(&'static str, Vec<[f64; 2]>)>,
}

/// A curve of theory for a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct TheoryLine {
    /// Its name.
    pub name: &'static str,
    /// (u0 (length), mean stress (E*, tensile positive)) by growing u0.
    pub points: Vec<[f64; 2]>,
}

impl ZeroRange {
    /// Computes the curves; the first time takes some tenths of a second. `None` if cancelled.
    pub fn compute(cancel: &Cancel) -> Option<Self> {
        // Each from 0 (not included) to its end; stable parts only.
        let up_to = |end: f64| {
            steps(0.0, end, POINTS)
                .skip(1)
                .take_while(|_| !cancel.requested())
        };
        let ridge_end = ridge::critical().displacement;
        let ridge = up_to(ridge_end)
            .filter_map(|u| ridge::pressure(u.min(ridge_end)).map(|p| [u, p]))
            .collect();
        let circle = |pattern: &circular::Pattern| {
            let end = pattern.fold().displacement;
            up_to(end)
                .filter_map(|u| pattern.at(u.min(end)).map(|state| [u, state.pressure]))
                .collect()
        };
        let curves = vec![
            ("ridge", ridge),
            ("dimple", circle(circular::dimple())),
            ("bulge", circle(circular::bulge())),
        ];
        (!cancel.requested()).then_some(Self { curves })
    }

    /// The curves for a scene, together with its flat state between two mean displacements; for a
    /// tip in a square cell those of JKR, alone and in the cell; empty on other ground.
    ///
    /// Over a layer there is the flat state alone: the other theory is that of a half-space.
    ///
    /// The curves of zero range hold where the range is small: L/L_c well above 1, and u0 well
    /// above the range.
    pub fn lines(&self, model: &Model, from: f64, to: f64) -> Vec<TheoryLine> {
        let half_space = model.body == Body::HalfSpace;
        match model.indenter {
            Indenter::Flat => {}
            Indenter::Hertz(Hertz { radius }) if half_space && !model.grid.is_line() => {
                return tip(
                    Jkr {
                        radius,
                        surface_energy: model.law.surface_energy,
                    },
                    model.grid.length,
                    from,
                );
            }
            _ => return Vec::new(),
        }
        let units = units_of(model);
        let flat = |u0: f64| [u0, model.law.at(u0).traction];
        let mut lines = vec![TheoryLine {
            name: "flat",
            points: steps(from, to, POINTS).map(flat).collect(),
        }];
        for (name, curve) in self.curves.iter().filter(|_| half_space) {
            // A dimple and a bulge are patterns of a square cell.
            if model.grid.is_line() && *name != "ridge" {
                continue;
            }
            let restored = |[u, p]: [f64; 2]| {
                let u0 = units.restore(u);
                [u0, units.stress(p, u0)]
            };
            lines.push(TheoryLine {
                name,
                points: curve.iter().copied().map(restored).collect(),
            });
        }
        lines
    }
}

/// The stable branch of a tip without range from u0 = `from` to its end, alone and in its cell of
/// side `length`.
fn tip(tip: Jkr, length: f64, from: f64) -> Vec<TheoryLine> {
    let largest = (0..40).fold(length, |a, _| {
        (tip.radius * (tip.opening(a) - from).max(0.0)).sqrt()
    });
    let (smallest, largest) = (
        0.7 * tip.end_of_displacement().radius,
        (1.1 * largest).min(LARGEST_CONTACT * length),
    );
    let area = length * length;
    let branch = |contact: &dyn Fn(f64) -> Contact| {
        let mut points: Vec<[f64; 2]> = Vec::new();
        for radius in steps(largest, smallest, TIP_POINTS) {
            let contact = contact(radius);
            let point = [contact.mean_displacement, contact.force / area];
            if points.last().is_some_and(|last| point[0] <= last[0]) {
                break;
            }
            points.push(point);
        }
        points.retain(|point| point[0] >= from);
        points
    };
    let periodic = PeriodicJkr::new(tip, length);
    vec![
        TheoryLine {
            name: "JKR",
            points: branch(&|a| tip.contact(a)),
        },
        TheoryLine {
            name: "JKR, periodic",
            points: branch(&|a| periodic.contact(a)),
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper::scenes;
    use crate::physics::body::Layer;
    use crate::scene::Points;

    #[test]
    fn a_tip_has_the_branch_of_jkr_alone_and_in_its_cell_up_to_their_ends() {
        let model = scenes::tip(64, 0.5).model().expect("a model");
        let lines = ZeroRange::compute(&Cancel::default())
            .unwrap()
            .lines(&model, -0.0145, 0.02);
        assert_eq!(
            lines.iter().map(|line| line.name).collect::<Vec<_>>(),
            ["JKR", "JKR, periodic"]
        );
        let gamma = scenes::TIP_SURFACE_ENERGY;
        let pull = |line: &TheoryLine| {
            line.points.iter().map(|p| p[1]).fold(0.0, f64::max)
                / (1.5 * std::f64::consts::PI * gamma)
        };
        assert!((pull(&lines[0]) - 1.0).abs() < 1e-3 && (pull(&lines[1]) - 1.0041178).abs() < 1e-3);
        for line in &lines {
            assert!(
                line.points.windows(2).all(|pair| pair[1][0] > pair[0][0])
                    && line.points[0][0] < -0.013,
                "{line:?}"
            );
        }
        // The branch alone turns back at 5/9 of the pull-off force, where a^3 = pi gamma R^2/8.
        let end = lines[0].points.last().expect("points");
        let a = (std::f64::consts::PI * gamma / 8.0).cbrt();
        assert!(
            (end[0] - ((2.0 * std::f64::consts::PI * gamma * a).sqrt() - a * a)).abs() < 1e-4,
            "{end:?}"
        );
    }

    #[test]
    fn over_a_layer_there_is_no_theory_but_the_flat_state() {
        let body = Body::Layer(Layer {
            thickness: 0.1,
            poisson: 0.5,
        });
        let theory = ZeroRange::compute(&Cancel::default()).unwrap();
        let flat = scenes::flat("", 1024.0, Points::Square(64), 6.0, 0.2, 0.02);
        for (scene, lines) in [(scenes::tip(64, 0.5), 0), (flat, 1)] {
            let mut model = scene.model().expect("a model");
            assert!(theory.lines(&model, -0.01, 1.0).len() > lines);
            model.body = body;
            assert_eq!(theory.lines(&model, -0.01, 1.0).len(), lines);
        }
    }

    #[test]
    fn the_lines_are_theory_in_the_units_of_the_scene() {
        let scene = scenes::flat("", 1024.0, Points::Square(64), 6.0, 0.2, 0.02);
        let model = scene.model().expect("a model");
        let lines = ZeroRange::compute(&Cancel::default())
            .unwrap()
            .lines(&model, 0.2, 6.0);
        assert_eq!(
            lines.iter().map(|line| line.name).collect::<Vec<_>>(),
            ["flat", "ridge", "dimple", "bulge"]
        );
        // The ridge flattens at u_c~ = 0.665607924 with p_c~ = -0.354996680: here sqrt(gamma L) =
        // sqrt(153.6), p = p~ gamma/u0.
        let end = lines[1].points.last().expect("points");
        let u0 = 0.665607924 * 153.6f64.sqrt();
        assert!(
            (end[0] - u0).abs() < 1e-6 && (end[1] - 0.354996680 * 0.15 / u0).abs() < 1e-9,
            "{end:?}"
        );
        // A small dimple: p~ = -(1.79301 u~)^(4/5) to leading order, approached as alpha^3, that is
        // u~^(6/5).
        let [u0, stress] = lines[2].points[1];
        let u = u0 / 153.6f64.sqrt();
        assert!(
            (stress * u0 / 0.15 / (1.79301 * u).powf(0.8) - 1.0).abs() < 2.0 * u.powf(1.2),
            "{u} {stress}"
        );
        // The flat state feels the law itself: sigma_max = gamma/(2 rho) at rho ln 2.
        let top = lines[0].points.iter().map(|p| p[1]).fold(0.0, f64::max);
        assert!((top - 0.075).abs() < 1e-4, "{top}");
        let line = scenes::flat("", 1024.0, Points::Line(64), 6.0, 0.2, 0.02)
            .model()
            .expect("a model");
        assert_eq!(
            ZeroRange::compute(&Cancel::default())
                .unwrap()
                .lines(&line, 0.2, 6.0)
                .len(),
            2
        );
    }
}
