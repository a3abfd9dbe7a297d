//! Floor 2: what to compute: the scene, as a file or the window describes it, its parameters with
//! limits and units, the decided model, the mesh an "auto" asks for, and the part of the cell that
//! is solved.
//!
//! May use `physics` and `numerics`; solves nothing. Lengths are in any one unit, E* is 1; what they
//! are to people is in [`parameter`].

pub mod edit;
pub mod parameter;

use crate::physics::body::Body;
use crate::physics::control::Control;
use crate::physics::indenter::Indenter;
use crate::physics::law::{Law, Shape};
use crate::physics::mesh::{self, Grid, POINTS_MAX, next_fast, points_for};
use crate::physics::parameter::{Refusal, number};
use crate::physics::theory::boundary;
use parameter::Units;
use serde::{Deserialize, Serialize};
use std::fmt;

/// A complete description of what is computed. The contact modulus E* is 1; lengths are in any one
/// unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// One line that names the scene.
    pub title: String,
    /// Where it comes from.
    pub source: String,
    /// The periodic cell.
    pub cell: Cell,
    /// The elastic body.
    pub body: Body,
    /// The cohesive law.
    pub law: LawChoice,
    /// The rigid counter-surface.
    pub indenter: Indenter,
    /// The path of what is driven.
    pub drive: Drive,
    /// What the plan must meet: relative error of the dissipated energy.
    pub accuracy: f64,
    /// Seed of the perturbations that choose between equivalent patterns.
    pub seed: u64,
    /// What the numbers of its file are in; nothing is computed otherwise for them.
    pub units: Option<Units>,
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

impl Points {
    /// So many points a side in place of these: a line cell stays a line.
    pub fn resized(self, n: usize) -> Self {
        match self {
            Points::Line(_) => Points::Line(n),
            Points::Auto | Points::Square(_) => Points::Square(n),
        }
    }
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

/// The path of what is driven: from `start` down to `turn` and back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// The machine: what it holds is u0, the stage of a spring, or the load; of a layer the plate
    /// in place of u0.
    pub control: Control,
    /// Its value at the beginning and the end (length; E* of a load).
    pub start: f64,
    /// Where the approach turns into the retraction.
    pub turn: Turn,
    /// Its largest change between two states.
    pub step: f64,
}

/// The turning point of the drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Turn {
    /// At this value of the control.
    At(f64),
    /// Where the mean stress falls to zero after contact.
    ZeroLoad,
}

/// A scene with everything "auto" decided.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Cell and mesh.
    pub grid: Grid,
    /// Elastic body.
    pub body: Body,
    /// [`Body::equivalent_length`] on this mesh (length).
    pub equivalent_length: f64,
    /// Law with its range.
    pub law: Law,
    /// Counter-surface.
    pub indenter: Indenter,
    /// mu_rho of this law on this mesh (Eq. 10).
    pub mu_rho: f64,
    /// In words: which model, and why.
    pub reason: String,
    /// Those of the scene.
    pub units: Option<Units>,
}

impl Model {
    /// What a reader of the results must know, in words: jumps that belong to the mesh, waves of
    /// the ground that it cannot show.
    pub fn warning(&self) -> Option<String> {
        let law = (!mesh::is_safe(self.mu_rho)).then(|| {
            format!(
                "mu_rho = {:.3} is above {}: the mesh is too coarse for this law, and some of the \
                 jumps may belong to the mesh and not to the physics",
                self.mu_rho,
                mesh::SAFE
            )
        });
        let ground = self.indenter.ground().left_out(&self.grid);
        let words: Vec<_> = law.into_iter().chain(ground).collect();
        (!words.is_empty()).then(|| words.join("; "))
    }
}

/// The mean height of a ground (length).
fn level(indenter: &Indenter, grid: &Grid) -> f64 {
    let height = indenter.height(grid);
    height.and_then(|height| height.mean()).unwrap_or(0.0)
}

/// Most steps from the start to the turn. What an interrupted loop of so many states has computed
/// is written within a second where nothing else keeps the machine busy.
const STEPS_MAX: f64 = 2e5;

/// The least step as a share of |u0|: a smaller one is lost in the digits of u0.
const STEP_SHARE: f64 = 1e-10;

impl Scene {
    /// What drives the mean displacement u0 of the surface: the machine, and in series with it the
    /// layer between its plate and the surface. The sum of their stretches is what is driven, so
    /// that u0 itself is driven only under an incompressible layer or a half-space.
    pub fn control(&self) -> Control {
        let mean = self.body.elastic().mean_stiffness();
        self.drive.control.in_series(mean)
    }

    /// u0 at which the approach turns (length), if u0 is what is driven, and to a given value.
    pub fn turn_of_u0(&self) -> Option<f64> {
        match (self.control(), self.drive.turn) {
            (Control::Displacement, Turn::At(turn)) => Some(turn),
            _ => None,
        }
    }

    /// Where the approach is to go (length): to the turning point, or, where the sign of the stress
    /// ends it, far below anything a tip under tension can need.
    pub fn depth(&self) -> f64 {
        let start = self.drive.start;
        match self.drive.turn {
            Turn::At(turn) => turn,
            Turn::ZeroLoad => start - 1e3 * (start.abs() + self.cell.length),
        }
    }

    /// Ends of what is driven (lower, upper; length, E* of a load).
    pub fn window_of_control(&self, model: &Model) -> (f64, f64) {
        let lower = match self.drive.turn {
            Turn::At(turn) => turn,
            Turn::ZeroLoad => -0.6 * model.indenter.ground().relief(&model.law) - model.law.range,
        };
        (lower, self.drive.start)
    }

    /// Ends of u0 (lower, upper; length) on the drive.
    pub fn window_of_u0(&self, model: &Model) -> [f64; 2] {
        let (control, law) = (self.control(), &model.law);
        let (lower, upper) = self.window_of_control(model);
        if !control.frees_mean() {
            return [lower, upper];
        }
        // The machine pulls where the body does not touch.
        let upper = match control {
            Control::Load => Control::stop(law, model.equivalent_length),
            _ => upper,
        };
        let contact = law.equilibrium_gap();
        if model.indenter != Indenter::Flat {
            let deepest = -0.6 * model.indenter.ground().relief(law) - law.range;
            let lower = match law.shape {
                // It has no gap at or below zero, nor then a mean one.
                Shape::Mie(_) => deepest.max(level(&model.indenter, &model.grid) + 0.3 * contact),
                _ => deepest,
            };
            return [lower, upper];
        }
        // The flat state in contact that the turn holds; a Mie law has no gap at or below zero.
        let pressed = |gap: f64| {
            let [held, _] = control.balanced(gap, law.at(gap).traction);
            !(held >= lower)
        };
        let deepest = contact - 0.9 * law.contact_gap().max(contact);
        [boundary(deepest, law.contact_gap(), pressed), upper]
    }

    /// Checks every value.
    ///
    /// # Errors
    /// The first value that is not allowed.
    pub fn validate(&self) -> Result<(), Refusal> {
        self.model().map(|_| ())
    }

    /// Decides what the scene leaves open: mesh, range, mu_rho.
    ///
    /// # Errors
    /// The first value that is not allowed: by itself, then beside the others.
    pub fn model(&self) -> Result<Model, Refusal> {
        for (parameter, value) in self.numbers() {
            parameter.check(value)?;
        }
        self.law.shape.check()?;
        self.check_drive()?;
        self.body.elastic().check_in(self.cell.length)?;
        self.indenter.check()?;
        if let (Some(units), Indenter::Measured(ground)) = (&self.units, &self.indenter)
            && let Some(unit) = ground.unit().filter(|unit| *unit != units.length.word)
        {
            let allowed = format!("\"{}\", as units.length has it", units.length.word);
            return Err(Refusal::new(
                "indenter.unit",
                format!("\"{unit}\""),
                &allowed,
            ));
        }
        self.indenter.ground().check_in(self.cell.length)?;
        let unit = Law {
            shape: self.law.shape,
            surface_energy: self.law.surface_energy,
            range: 1.0,
        };
        let (grid, reason) = self.mesh(&unit)?;
        let range = match self.law.range {
            Range::Length(range) => range,
            Range::MuRho(mu) => mesh::range_for_mu_rho(&unit, grid.spacing(), mu),
        };
        self.indenter.ground().check_on(&grid)?;
        let law = Law { range, ..unit };
        let mu_rho = mesh::mu_rho(&law, grid.spacing());
        if !parameter::MU_RHO.range.contains(&mu_rho) {
            let (low, high) = (
                parameter::MU_RHO.range.start(),
                parameter::MU_RHO.range.end(),
            );
            let allowed = format!(
                "a range at which mu_rho on this mesh, now {mu_rho:e}, is from {low:e} to {high:e}"
            );
            return Err(Refusal::new("law.range", number(range), &allowed));
        }
        if let (Some(turn), Shape::Mie(_)) = (self.turn_of_u0(), law.shape) {
            let level = level(&self.indenter, &grid);
            if turn <= level {
                let allowed = format!(
                    "above {}, the mean height of the ground: the Mie law is infinite at zero gap",
                    number(level)
                );
                return Err(Refusal::new("drive.turn", number(turn), &allowed));
            }
        }
        if let Some(turn) = self.turn_of_u0()
            && self.indenter == Indenter::Flat
            && !law.at(turn).energy.is_finite()
        {
            return Err(Refusal::new(
                "drive.turn",
                number(turn),
                "a gap at which the law is finite: so deep in its wall it overflows",
            ));
        }
        if let Turn::ZeroLoad = self.drive.turn
            && range / self.drive.step > STEPS_MAX
        {
            return Err(Refusal::new(
                "drive.step",
                number(self.drive.step),
                "at least a 200,000th of law.range",
            ));
        }
        Ok(Model {
            grid,
            body: self.body,
            equivalent_length: self.body.equivalent_length(&grid),
            law,
            indenter: self.indenter.clone(),
            mu_rho,
            reason,
            units: self.units,
        })
    }

    /// The mesh, and in words why; `unit` is the law with a range of 1.
    fn mesh(&self, unit: &Law) -> Result<(Grid, String), Refusal> {
        let length = self.cell.length;
        let range = match (self.cell.points, self.law.range) {
            (Points::Square(n), _) => {
                return Ok((Grid::square(length, even(n)?), "points given".to_owned()));
            }
            (Points::Line(n), _) => {
                return Ok((Grid::line(length, even(n)?), "line cell given".to_owned()));
            }
            (Points::Auto, Range::MuRho(mu)) => {
                let allowed = "not together with cell.points = \"auto\": give law.range, or the \
                    number of points";
                return Err(Refusal::new("law.mu_rho", number(mu), allowed));
            }
            (Points::Auto, Range::Length(range)) => range,
        };
        self.indenter.ground().check_auto()?;
        let law = Law { range, ..*unit };
        let n = points_for(&law, length, self.accuracy)
            .max(next_fast(self.indenter.ground().points_needed(length)));
        if n > POINTS_MAX {
            let allowed = format!(
                "this range needs more than {POINTS_MAX} points a side: a larger law.range or a \
                 smaller cell.length"
            );
            return Err(Refusal::new("cell.points", "auto", &allowed));
        }
        let mu = mesh::mu_rho(&law, length / n as f64);
        // Elsewhere which jumps happen depends on the mesh, and no error of it is known.
        let reason = if self.indenter == Indenter::Flat && law.is_smooth() {
            format!(
                "mu_rho = {mu:.3} keeps the mesh error below the asked {}",
                self.accuracy
            )
        } else {
            format!(
                "mu_rho = {mu:.3}, as for the asked {} of a smooth law on flat ground",
                self.accuracy
            )
        };
        Ok((Grid::square(length, n), reason))
    }

    fn check_drive(&self) -> Result<(), Refusal> {
        let Drive {
            control,
            start,
            turn,
            step,
        } = self.drive;
        let told = |value: f64| number(self.number_given(parameter::START.unit, value));
        // At zero load u0 goes below the ground by no more than about the length of the cell.
        let reach = start.abs()
            + if turn == Turn::ZeroLoad {
                self.cell.length
            } else {
                0.0
            };
        if step < STEP_SHARE * reach {
            return Err(Refusal::new(
                "drive.step",
                told(step),
                &format!(
                    "at least {STEP_SHARE:e} of {:e}, else it is lost in the digits of u0",
                    self.number_given(parameter::START.unit, reach)
                ),
            ));
        }
        if control == Control::Load && start <= 0.0 {
            return Err(Refusal::new(
                "drive.start",
                told(start),
                "a load above 0, which pulls: the drive of a load begins apart from the ground",
            ));
        }
        if let Turn::At(turn) = turn {
            if turn >= start {
                return Err(Refusal::new(
                    "drive.turn",
                    told(turn),
                    &format!(
                        "a number below drive.start = {}, or \"zero_load\"",
                        told(start)
                    ),
                ));
            }
            if (start - turn) / step > STEPS_MAX {
                return Err(Refusal::new(
                    "drive.step",
                    told(step),
                    "at least a 200,000th of drive.start - drive.turn",
                ));
            }
        } else if self.indenter == Indenter::Flat {
            return Err(Refusal::new(
                "drive.turn",
                "zero_load",
                "a number on flat ground; zero_load is for uneven ground",
            ));
        }
        Ok(())
    }
}

fn even(n: usize) -> Result<usize, Refusal> {
    if n.is_multiple_of(2) {
        Ok(n)
    } else {
        Err(parameter::POINTS.refuse(n))
    }
}

/// The part of the cell that is solved; the rest follows by symmetry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub enum Part {
    /// Nothing: the flat state over flat ground is a closed form.
    Flat,
    /// The even half of a line, for a ridge of a square cell.
    Ridge,
    /// All of a line cell.
    Line,
    /// The even half of a line cell. Modes of other symmetry are watched on all of it.
    HalfLine,
    /// The even quarter of a square cell. Modes of other symmetry are watched on all of it.
    Quarter,
    /// The even quarter or half, held mirror-symmetric: what a surface does that is held so. On a
    /// coarse mesh single points let go; in the whole cell their mirror images do so one by one, a
    /// little earlier or later.
    Mirrored,
    /// All of a square cell.
    #[default]
    Whole,
}

impl Part {
    /// The word of the command line and of tables.
    pub fn word(self) -> &'static str {
        match self {
            Part::Flat => "flat",
            Part::Ridge => "ridge",
            Part::Line => "line",
            Part::HalfLine => "half line",
            Part::Quarter => "quarter",
            Part::Whole => "whole",
            Part::Mirrored => "mirrored",
        }
    }

    /// The same part of a line cell: all of it, or its half.
    pub fn of_line(self) -> Self {
        match self {
            Part::Whole => Part::Line,
            Part::Quarter => Part::HalfLine,
            other => other,
        }
    }

    /// True if only even fields are solved.
    pub fn is_even(self) -> bool {
        matches!(
            self,
            Part::Ridge | Part::HalfLine | Part::Quarter | Part::Mirrored
        )
    }
}

/// As a state's record says which model it is of.
impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Part::Flat => "flat, closed form",
            Part::Ridge => "ridge on half a line",
            Part::Line => "line cell",
            Part::HalfLine => "half line cell",
            Part::Quarter => "quarter cell",
            Part::Mirrored => "mirrored quarter",
            Part::Whole => "whole cell",
        })
    }
}

/// How a loop is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Strategy {
    /// Read off the branches of an atlas, every state solved on the part that its pattern needs.
    Atlas,
    /// By the walk on a part of the cell.
    Walk(Part),
}

impl Strategy {
    /// The walk on the whole cell: the reference of all.
    pub const WHOLE: Self = Strategy::Walk(Part::Whole);
    /// The walk on the even quarter.
    pub const QUARTER: Self = Strategy::Walk(Part::Quarter);

    /// The word of the command line and of tables.
    pub fn word(self) -> &'static str {
        match self {
            Strategy::Atlas => "atlas",
            Strategy::Walk(part) => part.word(),
        }
    }
}

/// Why a mesh of n x n points has no quarter whose modes are resolved; `None` if it has.
pub fn no_quarter(n: usize) -> Option<String> {
    (!n.is_multiple_of(4) || n < 16).then(|| format!("{n} points are no multiple of 4 from 16 on"))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::physics::law::Morse;

    /// The scene of Fig. 2 on a mesh of `points` to the side.
    pub fn fig2(points: usize) -> Scene {
        Scene {
            title: String::new(),
            source: String::new(),
            cell: Cell {
                length: 256.0,
                points: Points::Square(points),
            },
            body: Body::HalfSpace,
            law: LawChoice {
                shape: Shape::Morse(Morse),
                surface_energy: 0.15,
                range: Range::Length(1.0),
            },
            indenter: Indenter::Flat,
            drive: Drive {
                control: Control::Displacement,
                start: 4.2,
                turn: Turn::At(0.2),
                step: 0.02,
            },
            accuracy: 0.01,
            seed: 1,
            units: None,
        }
    }
}
