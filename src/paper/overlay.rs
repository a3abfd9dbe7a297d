//! Theory over the live loop: the flat state and the patterns of zero range, in the units of the scene at hand.

use crate::experiment::scene::Model;
use crate::physics::indenter::Indenter;
use crate::physics::theory::circular::{self, Part};
use crate::physics::theory::{ridge, units::Units};

/// Points of a curve.
const POINTS: usize = 160;

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
    /// Computes the curves; the first time takes some tenths of a second.
    pub fn compute() -> Self {
        // Each from 0 (not included) to its end; stable parts only.
        let up_to = |end: f64| (1..=POINTS).map(move |i| end * i as f64 / POINTS as f64);
        let ridge_end = ridge::critical().displacement;
        let ridge = up_to(ridge_end).filter_map(|u| ridge::pressure(u.min(ridge_end)).map(|p| [u, p])).collect();
        let circle = |pattern: &circular::Pattern| {
            let end = pattern.fold().displacement;
            up_to(end).filter_map(|u| pattern.at(u.min(end), Part::Stable).map(|state| [u, state.pressure])).collect()
        };
        let curves = vec![("ridge", ridge), ("dimple", circle(circular::dimple())), ("bulge", circle(circular::bulge()))];
        Self { curves }
    }

    /// The curves for a scene, together with its flat state between two mean displacements; empty on uneven ground.
    ///
    /// The curves of zero range hold where the range is small: L/L_c well above 1, and u0 well above the range.
    pub fn lines(&self, model: &Model, from: f64, to: f64) -> Vec<TheoryLine> {
        if model.indenter != Indenter::Flat {
            return Vec::new();
        }
        let units = Units { length: model.grid.length, surface_energy: model.law.surface_energy };
        let flat = |i: usize| {
            let u0 = from + (to - from) * i as f64 / POINTS as f64;
            [u0, model.law.at(u0).traction]
        };
        let mut lines = vec![TheoryLine { name: "flat", points: (0..=POINTS).map(flat).collect() }];
        for (name, curve) in &self.curves {
            // A dimple and a bulge are patterns of a square cell.
            if model.grid.is_line() && *name != "ridge" {
                continue;
            }
            let restored = |[u, p]: [f64; 2]| {
                let u0 = units.restore(u);
                [u0, units.stress(p, u0)]
            };
            lines.push(TheoryLine { name, points: curve.iter().copied().map(restored).collect() });
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::scene::Points;
    use crate::paper::scenes;

    #[test]
    fn the_lines_are_theory_in_the_units_of_the_scene() {
        let scene = scenes::flat("", 1024.0, Points::Square(64), 6.0, 0.2, 0.02);
        let model = scene.model().expect("a model");
        let lines = ZeroRange::compute().lines(&model, 0.2, 6.0);
        assert_eq!(lines.iter().map(|line| line.name).collect::<Vec<_>>(), ["flat", "ridge", "dimple", "bulge"]);
        // The ridge flattens at u_c~ = 0.665607924 with p_c~ = -0.354996680: here sqrt(gamma L) = sqrt(153.6), p = p~ gamma/u0.
        let end = lines[1].points.last().expect("points");
        let u0 = 0.665607924 * 153.6f64.sqrt();
        assert!((end[0] - u0).abs() < 1e-6 && (end[1] - 0.354996680 * 0.15 / u0).abs() < 1e-9, "{end:?}");
        // A small dimple: p~ = -(1.79301 u~)^(4/5) to leading order, approached as alpha^3, that is u~^(6/5).
        let [u0, stress] = lines[2].points[1];
        let u = u0 / 153.6f64.sqrt();
        assert!((stress * u0 / 0.15 / (1.79301 * u).powf(0.8) - 1.0).abs() < 2.0 * u.powf(1.2), "{u} {stress}");
        // The flat state feels the law itself: sigma_max = gamma/(2 rho) at rho ln 2.
        let top = lines[0].points.iter().map(|p| p[1]).fold(0.0, f64::max);
        assert!((top - 0.075).abs() < 1e-4, "{top}");
        let line = scenes::flat("", 1024.0, Points::Line(64), 6.0, 0.2, 0.02).model().expect("a model");
        assert_eq!(ZeroRange::compute().lines(&line, 0.2, 6.0).len(), 2);
    }
}
