//! What to compute: the scene, as a file or the window describes it.

use super::plan::{next_fast, points_for};
use crate::physics::grid::Grid;
use crate::physics::indenter::Indenter;
use crate::physics::law::{DoubleExponential, Law, Mie, Shape};
use crate::physics::mesh_rule;
use crate::physics::roughness::WAVES_MAX;

/// A complete description of an experiment. The contact modulus E* is 1; lengths are in any one unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// One line that names the scene.
    pub title: String,
    /// Where it comes from.
    pub source: String,
    /// The periodic cell.
    pub cell: Cell,
    /// The cohesive law.
    pub law: LawChoice,
    /// The rigid counter-surface.
    pub indenter: Indenter,
    /// The path of the mean displacement.
    pub drive: Drive,
    /// What the plan must meet: relative error of the dissipated energy.
    pub accuracy: f64,
    /// Seed of the perturbations that choose between equivalent patterns.
    pub seed: u64,
}

/// The periodic cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Side L.
    pub length: f64,
    /// The mesh.
    pub points: Points,
}

/// The mesh of the cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Points {
    /// Chosen from mu_rho and the asked accuracy (square).
    Auto,
    /// n x n points.
    Square(usize),
    /// n points along x, fields uniform along y.
    Line(usize),
}

/// The cohesive law with its scales.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LawChoice {
    /// Which law.
    pub shape: Shape,
    /// Work of adhesion gamma per area.
    pub surface_energy: f64,
    /// The range, directly or through the mesh rule.
    pub range: Range,
}

/// How the range of the law is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    /// rho itself.
    Length(f64),
    /// mu_rho of Eq. 10; the mesh then fixes rho.
    MuRho(f64),
}

/// The path of the mean displacement u0: from `start` down to `turn` and back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// u0 at the beginning and the end.
    pub start: f64,
    /// Where the approach turns into the retraction.
    pub turn: Turn,
    /// Largest change of u0 between two states.
    pub step: f64,
}

/// The turning point of the drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Turn {
    /// At this mean displacement.
    At(f64),
    /// Where the mean stress falls to zero after contact.
    ZeroLoad,
}

/// A scene with everything "auto" decided.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Cell and mesh.
    pub grid: Grid,
    /// Law with its range.
    pub law: Law,
    /// Counter-surface.
    pub indenter: Indenter,
    /// mu_rho of this law on this mesh (Eq. 10).
    pub mu_rho: f64,
    /// In words: which model, and why.
    pub reason: String,
}

impl Model {
    /// What a reader of the results must know, in words: jumps that belong to the mesh, waves of the ground that it cannot show.
    pub fn warning(&self) -> Option<String> {
        let law = (!mesh_rule::is_safe(self.mu_rho)).then(|| {
            format!(
                "mu_rho = {:.3} is above {}: the mesh is too coarse for this law, and some of the jumps may belong to the mesh and not \
                 to the physics",
                self.mu_rho,
                mesh_rule::SAFE
            )
        });
        let ground = match self.indenter {
            Indenter::Rough(roughness) if !roughness.fits(&self.grid) => {
                Some(format!("the mesh is too coarse for waves of length {}: the shortest ones are left out", roughness.shortest))
            }
            _ => None,
        };
        let words: Vec<_> = law.into_iter().chain(ground).collect();
        (!words.is_empty()).then(|| words.join("; "))
    }
}

/// A value of the scene that is not allowed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{key} = {value}: {allowed}")]
pub struct SceneError {
    /// Dotted key, as in `cell.points`.
    pub key: String,
    /// The offending value.
    pub value: String,
    /// What is allowed, and so how to mend it.
    pub allowed: String,
}

/// Largest number of points along one side.
pub const POINTS_MAX: usize = 4096;

impl Scene {
    /// Where the approach is to go (length): to the turning point, or, where the sign of the stress ends it, far below anything a tip
    /// under tension can need.
    pub fn depth(&self) -> f64 {
        let start = self.drive.start;
        match self.drive.turn {
            Turn::At(turn) => turn,
            Turn::ZeroLoad => start - 1e3 * (start.abs() + self.cell.length),
        }
    }

    /// Checks every value.
    ///
    /// # Errors
    /// The first value that is not allowed.
    pub fn validate(&self) -> Result<(), SceneError> {
        self.model().map(|_| ())
    }

    /// Decides what the scene leaves open: mesh, range, mu_rho.
    ///
    /// # Errors
    /// The first value that is not allowed.
    pub fn model(&self) -> Result<Model, SceneError> {
        let length = positive("cell.length", self.cell.length)?;
        let surface_energy = positive("law.surface_energy", self.law.surface_energy)?;
        self.check_shape()?;
        self.check_drive()?;
        self.check_indenter()?;
        if !(self.accuracy > 0.0 && self.accuracy < 1.0) {
            return Err(refuse("accuracy.target", self.accuracy, "a number above 0 and below 1, as in 0.01"));
        }
        let unit = Law { shape: self.law.shape, surface_energy, range: 1.0 };
        let (grid, reason) = match (self.cell.points, self.law.range) {
            (Points::Square(n), _) => (Grid::square(length, even("cell.points", n)?), "points given".to_owned()),
            (Points::Line(n), _) => (Grid::line(length, even("cell.points", n)?), "line cell given".to_owned()),
            (Points::Auto, Range::MuRho(mu)) => {
                let allowed = "not together with cell.points = \"auto\": give law.range, or the number of points";
                return Err(refuse("law.mu_rho", mu, allowed));
            }
            (Points::Auto, Range::Length(range)) => {
                let range = positive("law.range", range)?;
                let law = Law { range, ..unit };
                let n = points_for(&law, length, self.accuracy).max(next_fast(self.indenter.points_needed(length)));
                let mu = mesh_rule::mu_rho(&law, length / n as f64);
                if n > POINTS_MAX {
                    let allowed = format!(
                        "this range needs {n} points a side, more than {POINTS_MAX}: a larger law.range or a smaller cell.length"
                    );
                    return Err(refuse("cell.points", "auto", &allowed));
                }
                // Elsewhere which jumps happen depends on the mesh, and no error of it is known.
                let reason = match self.indenter == Indenter::Flat && law.is_smooth() {
                    true => format!("mu_rho = {mu:.3} keeps the mesh error below the asked {}", self.accuracy),
                    false => format!("mu_rho = {mu:.3}, as for the asked {} of a smooth law on flat ground", self.accuracy),
                };
                (Grid::square(length, n), reason)
            }
        };
        let range = match self.law.range {
            Range::Length(range) => positive("law.range", range)?,
            Range::MuRho(mu) => mesh_rule::range_for_mu_rho(&unit, grid.spacing(), positive("law.mu_rho", mu)?),
        };
        if let Indenter::Wave { periods, .. } = self.indenter
            && (periods.iter().any(|&p| 4 * p > grid.nx) || grid.is_line() && periods[1] > 0)
        {
            let allowed = if grid.is_line() { "along x alone on a line cell, and " } else { "" };
            let allowed = format!("{allowed}at most a quarter of the points along a side ({})", grid.nx / 4);
            return Err(refuse("indenter.periods", format!("{periods:?}"), &allowed));
        }
        let law = Law { range, ..unit };
        let mu_rho = mesh_rule::mu_rho(&law, grid.spacing());
        if let Turn::At(turn) = self.drive.turn
            && self.indenter == Indenter::Flat
            && !law.at(turn).energy.is_finite()
        {
            return Err(refuse("drive.turn", turn, "a gap at which the law is finite: so deep in its wall it overflows"));
        }
        Ok(Model { grid, law, indenter: self.indenter, mu_rho, reason })
    }

    fn check_shape(&self) -> Result<(), SceneError> {
        match self.law.shape {
            Shape::Mie(Mie { m, n }) => {
                positive("law.n", n)?;
                if !(m.is_finite() && m > n && m <= 100.0) {
                    return Err(refuse("law.m", m, &format!("a number above law.n = {n}, at most 100")));
                }
            }
            Shape::DoubleExponential(DoubleExponential { ratio }) if !(ratio > 0.0 && ratio < 1.0) => {
                return Err(refuse("law.ratio", ratio, "a number above 0 and below 1 (repulsive over attractive range)"));
            }
            _ => {}
        }
        Ok(())
    }

    fn check_indenter(&self) -> Result<(), SceneError> {
        let length = self.cell.length;
        match self.indenter {
            Indenter::Flat => {}
            Indenter::Hertz { radius } => drop(positive("indenter.radius", radius)?),
            Indenter::Wave { amplitude, periods } => {
                positive("indenter.amplitude", amplitude)?;
                if periods == [0, 0] {
                    return Err(refuse("indenter.periods", "[0, 0]", "a whole number above 0 along x or y, as in 2 or [2, 1]"));
                }
            }
            Indenter::Rough(rough) => {
                if !(rough.hurst > 0.0 && rough.hurst <= 1.0) {
                    return Err(refuse("indenter.hurst", rough.hurst, "a number above 0, at most 1, as in 0.8"));
                }
                positive("indenter.rms", rough.rms)?;
                if !(rough.longest > 0.0 && rough.longest <= length) {
                    return Err(refuse("indenter.longest", rough.longest, &format!("above 0, at most cell.length = {length}")));
                }
                let least = length / WAVES_MAX as f64;
                if !(rough.shortest >= least && rough.shortest <= rough.longest) {
                    let allowed = format!("from {least} (cell.length/{WAVES_MAX}) to indenter.longest = {}", rough.longest);
                    return Err(refuse("indenter.shortest", rough.shortest, &allowed));
                }
            }
        }
        Ok(())
    }

    fn check_drive(&self) -> Result<(), SceneError> {
        let Drive { start, turn, step } = self.drive;
        if !start.is_finite() {
            return Err(refuse("drive.start", start, "a finite number"));
        }
        positive("drive.step", step)?;
        if let Turn::At(turn) = turn {
            if !(turn.is_finite() && turn < start) {
                return Err(refuse("drive.turn", turn, &format!("a number below drive.start = {start}, or \"zero_load\"")));
            }
            if (start - turn) / step > 1e6 {
                return Err(refuse("drive.step", step, "at least a millionth of drive.start - drive.turn"));
            }
            if turn <= 0.0 && matches!(self.law.shape, Shape::Mie(_)) && self.indenter == Indenter::Flat {
                return Err(refuse("drive.turn", turn, "above 0: the Mie law is infinite at zero gap"));
            }
        } else if self.indenter == Indenter::Flat {
            return Err(refuse("drive.turn", "zero_load", "a number on flat ground; zero_load is for uneven ground"));
        }
        Ok(())
    }
}

fn positive(key: &str, value: f64) -> Result<f64, SceneError> {
    if value.is_finite() && value > 0.0 { Ok(value) } else { Err(refuse(key, value, "a finite number above 0")) }
}

fn even(key: &str, n: usize) -> Result<usize, SceneError> {
    if n.is_multiple_of(2) && (4..=POINTS_MAX).contains(&n) {
        return Ok(n);
    }
    Err(refuse(key, n, &format!("an even number from 4 to {POINTS_MAX}, as in 64 or [64, 1], or \"auto\"")))
}

pub(super) fn refuse(key: &str, value: impl std::fmt::Display, allowed: &str) -> SceneError {
    SceneError { key: key.to_owned(), value: value.to_string(), allowed: format!("allowed is {allowed}") }
}
