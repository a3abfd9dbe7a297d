//! A tip.

use super::{Ground, Indenter};
use crate::physics::law::Law;
use crate::physics::mesh::Grid;
use crate::physics::parameter::{Dimension, LENGTHS, POSITIVE, own};
use crate::physics::theory::jkr::Jkr;
use std::f64::consts::PI;

/// A Hertzian tip h = -r^2/(2R), its apex on the point (n/2, n/2) of the mesh (for a line cell a
/// cylinder).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hertz {
    /// Radius of curvature R (length).
    pub radius: f64,
}

impl Default for Hertz {
    fn default() -> Self {
        Self { radius: 1.0 }
    }
}

own! { Hertz {
    radius: Number = "indenter.radius", "Tip radius", "R", Dimension::Length,
        LENGTHS, None, POSITIVE;
}}

impl Ground for Hertz {
    fn name(&self) -> &'static str {
        "tip"
    }

    fn outline(&self, share: f64) -> f64 {
        1.0 - (2.0 * share - 1.0).powi(2)
    }

    fn suited(&self, _law: &Law, grid: &Grid) -> Indenter {
        Indenter::Hertz(Self {
            radius: grid.length,
        })
    }

    fn at(&self, x: f64, y: f64, _length: f64) -> f64 {
        -(x * x + y * y) / (2.0 * self.radius)
    }

    fn has_one_crest(&self) -> bool {
        true
    }

    fn turns_at_zero_load(&self) -> bool {
        true
    }

    /// a^2/R at zero load, where a^3 = 9 pi gamma R^2/2 (JKR), so written that no unit of length
    /// overflows.
    fn relief(&self, law: &Law) -> f64 {
        self.radius * (4.5 * PI * law.surface_energy / self.radius).cbrt().powi(2)
    }

    /// Of JKR without images: (3/2) pi gamma R over the cell, and 3 gamma (pi R/(16 gamma))^(1/3)
    /// per length for a cylinder (M. K. Chaudhury, T. Weaver, C. Y. Hui and E. J. Kramer, J. Appl.
    /// Phys. 80, 30 (1996)).
    fn pull_off(&self, law: &Law, grid: &Grid) -> Option<f64> {
        let (radius, surface_energy) = (self.radius, law.surface_energy);
        Some(if !grid.is_line() {
            Jkr {
                radius,
                surface_energy,
            }
            .pull_off_force()
                / grid.length.powi(2)
        } else {
            3.0 * surface_energy * (PI * radius / (16.0 * surface_energy)).cbrt() / grid.length
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tip_is_highest_in_the_middle_and_falls_as_a_parabola() {
        let grid = Grid::square(2.0, 8);
        let height = Hertz { radius: 3.0 }.height(&grid).unwrap();
        assert_eq!(height[[4, 4]], 0.0);
        assert!(height.iter().all(|&h| h <= 0.0));
        // Two and three spacings of 0.25 away: r^2 = 0.0625 (4 + 9); rounding only.
        assert!((height[[2, 7]] + 0.0625 * 13.0 / 6.0).abs() < 1e-15);
        assert_eq!(height.t(), height);
    }

    #[test]
    fn on_a_line_cell_the_tip_is_a_cylinder() {
        let grid = Grid::line(2.0, 8);
        let height = Hertz { radius: 3.0 }.height(&grid).unwrap();
        assert_eq!(height.dim(), (1, 8));
        assert_eq!(height[[0, 4]], 0.0);
        assert!((height[[0, 0]] + 1.0 / 6.0).abs() < 1e-15);
    }
}
