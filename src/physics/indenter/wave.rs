//! Waves.

use super::{Ground, Indenter};
use crate::physics::grid::{Grid, POINTS_MAX};
use crate::physics::law::Law;
use crate::physics::parameter::{Dimension, LENGTHS, POSITIVE, Refusal, own};
use std::f64::consts::TAU;

/// Sinusoidal waves, h = -amplitude sum_i (1 - cos(2 pi periods_i r_i/L)), a crest in the middle of
/// the cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    /// Half the height from trough to crest of each wave (length).
    pub amplitude: f64,
    /// Waves along x and along y on the side of the cell; 0 is none.
    pub periods: [usize; 2],
}

/// Points along a side for each wave.
const POINTS: usize = 8;

impl Default for Wave {
    fn default() -> Self {
        Self {
            amplitude: 1.0,
            periods: [1, 0],
        }
    }
}

own! { Wave {
    amplitude: Number = "indenter.amplitude", "Amplitude", "", Dimension::Length,
        LENGTHS, None, POSITIVE;
    periods: Counts = "indenter.periods", "Waves", "", Dimension::Pure(""),
        0.0..=(POINTS_MAX / 4) as f64, None, "a whole number of waves along x, or along x and y as in [2, 1], each {range}";
}
    fn check(&self) -> Result<(), Refusal> {
        let allowed = "a whole number above 0 along x or y, as in 2 or [2, 1]";
        if self.periods == [0, 0] {
            Err(self.refuse(allowed))
        } else {
            Ok(())
        }
    }
}

impl Wave {
    fn refuse(&self, allowed: &str) -> Refusal {
        Refusal::new("indenter.periods", format!("{:?}", self.periods), allowed)
    }
}

impl Ground for Wave {
    fn name(&self) -> &'static str {
        "waves"
    }

    fn outline(&self, share: f64) -> f64 {
        0.5 - 0.5 * (2.0 * TAU * share).cos()
    }

    /// One crest in the cell, two ranges high.
    fn suited(&self, law: &Law, grid: &Grid) -> Indenter {
        Indenter::Wave(Self {
            amplitude: 2.0 * law.range,
            periods: [1, usize::from(!grid.is_line())],
        })
    }

    fn at(&self, x: f64, y: f64, length: f64) -> f64 {
        let depth =
            |r: f64, periods: usize| 2.0 * (0.5 * TAU * periods as f64 * r / length).sin().powi(2);
        -self.amplitude * (depth(x, self.periods[0]) + depth(y, self.periods[1]))
    }

    fn points_needed(&self, _length: f64) -> usize {
        self.periods[0].max(self.periods[1]).saturating_mul(POINTS)
    }

    fn is_uniform(&self) -> [bool; 2] {
        self.periods.map(|periods| periods == 0)
    }

    fn has_one_crest(&self) -> bool {
        self.periods.iter().all(|&periods| periods <= 1)
    }

    fn relief(&self, _law: &Law) -> f64 {
        self.amplitude * self.periods.iter().filter(|&&periods| periods > 0).count() as f64
    }

    fn check_auto(&self) -> Result<(), Refusal> {
        if self.points_needed(f64::NAN) > POINTS_MAX {
            let most = POINTS_MAX / POINTS;
            return Err(self.refuse(&format!(
                "with cell.points = \"auto\" at most {most}, each wave with its eight points"
            )));
        }
        Ok(())
    }

    fn check_on(&self, grid: &Grid) -> Result<(), Refusal> {
        let most = grid.nx / 4;
        if self.periods.iter().any(|&periods| periods > most)
            || grid.is_line() && self.periods[1] > 0
        {
            let line = if grid.is_line() {
                "along x alone on a line cell, and "
            } else {
                ""
            };
            return Err(self.refuse(&format!(
                "{line}at most a quarter of the points along a side ({most})"
            )));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waves_have_their_crest_in_the_middle_and_their_troughs_two_amplitudes_below() {
        let grid = Grid::square(8.0, 16);
        let height = Wave {
            amplitude: 0.5,
            periods: [2, 0],
        }
        .height(&grid)
        .unwrap();
        assert!(height[[3, 8]] == 0.0 && height[[3, 0]].abs() < 1e-15);
        assert!((height[[5, 4]] + 1.0).abs() < 1e-15 && height[[0, 2]] < 0.0);
        assert!((height[[5, 2]] + 0.5).abs() < 1e-15);
        let both = Wave {
            amplitude: 0.5,
            periods: [1, 1],
        }
        .height(&grid)
        .unwrap();
        assert!((both[[0, 0]] + 2.0).abs() < 1e-15 && both.t() == both);
    }
}
