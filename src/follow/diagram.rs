//! The whole diagram of a scene: every branch of equilibria, stable and unstable, with its folds
//! and bifurcations, and where two stable branches have the same energy.
//!
//! The walk and the atlas know what is stable. Between the stable pieces lie unstable ones, which
//! explain why there is a jump: a branch turns back at a fold, or meets another one at a
//! bifurcation, and its end is where the two cancel or exchange their stability. Every point bears
//! its index, the number of negative eigenvalues over all modes of the whole cell.

mod flat_ground;
mod meeting;
mod piece;
mod trace;
mod uneven;

use crate::follow::walk::symmetry::slides_on;
use crate::numerics::threads::Cancel;
use crate::physics::control::Control;
use crate::physics::indenter::Indenter;
use crate::physics::low_block::Class;
use crate::physics::mesh::Grid;
use crate::physics::parameter::Refusal;
use crate::physics::pattern::{Pattern, classify};
use crate::physics::system::{Evaluation, State, System};
use crate::scene::{Model, Part, Scene};
use crate::solver::Lost;
use crate::solver::mechanics::Mechanics;
use crate::solver::stability::Tracker;
use ndarray::Array2;
use rand::SeedableRng;
use rand_pcg::Pcg64;
use std::fmt;

pub use piece::{EqualEnergy, Piece};

/// Relative error of the eigenvalue of a mode that is shown.
const GOOD: f64 = 0.02;

/// All that is known of the equilibria of a scene.
#[derive(Clone, Debug, Default)]
pub struct Diagram {
    /// The branches, the flat state first on flat ground.
    pub branches: Vec<Branch>,
    /// Where stable pieces of two branches have the same energy.
    pub equal_energies: Vec<EqualEnergy>,
    /// What was not followed, and why; empty if the diagram is complete.
    pub missing: Vec<String>,
    /// What drives the body: folds, index and energy are those under it, equilibria and
    /// bifurcations those at fixed u0.
    pub control: Control,
    /// Transforms spent, of any size.
    pub transforms: usize,
    /// True if somebody asked to stop: what was found until then stands.
    pub cancelled: bool,
}

/// A curve of equilibria.
#[derive(Clone, Debug)]
pub struct Branch {
    /// Its name in the files: `flat`, `square`, `ridge`, `mixed_1`, ...
    pub name: String,
    /// The system whose states it has.
    pub system: System,
    /// The points in order along it.
    pub points: Vec<Point>,
    /// Why it ends.
    pub ending: Ending,
}

/// One equilibrium.
#[derive(Clone, Debug)]
pub struct Point {
    /// The state; no amplitudes where it is uniform.
    pub state: State,
    /// Arc length along the branch (length).
    pub arc: f64,
    /// du0/ds and d stress/ds along it.
    pub rates: [f64; 2],
    /// What it is.
    pub kind: Kind,
    /// Number of negative eigenvalues before and after it along the branch, over all modes of the
    /// whole cell and u0 where it is free, sliding ones left out; the same at a regular point.
    pub index: [usize; 2],
    /// Its pattern by topology.
    pub pattern: Pattern,
    /// max |residual traction| / max(sigma_max, max |traction|).
    pub residual: f64,
    /// Symmetry of the mode that has no stiffness at a bifurcation, where modes are told apart.
    pub class: Option<Class>,
    /// That mode, as coefficients of the class.
    pub mode: Vec<f64>,
}

/// What a point is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// One of many.
    Regular,
    /// The branch turns back in what is driven.
    Fold,
    /// Another branch meets this one.
    Bifurcation,
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Kind::Regular => "regular",
            Kind::Fold => "fold",
            Kind::Bifurcation => "bifurcation",
        })
    }
}

/// Why a branch ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// It comes out of, or goes into, the flat state.
    Flat,
    /// It meets another branch.
    Joined,
    /// It leaves the range of u0 that was asked for.
    Window,
    /// So many points were computed that no more are.
    Budget,
    /// It was not found further on.
    Lost(Lost),
}

impl fmt::Display for Ending {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Ending::Flat => "the flat state",
            Ending::Joined => "another branch",
            Ending::Window => "the end of the drive",
            Ending::Budget => "the budget",
            Ending::Lost(Lost::Cancelled) => "a request to stop",
            Ending::Lost(_) => "no equilibrium found",
        })
    }
}

impl Point {
    /// True if it bounds a piece that is stable at fixed u0, whatever drives the body.
    fn bounds_stable(&self, control: Control) -> bool {
        self.index
            .contains(&usize::from(control.softens(self.rates)))
    }
}

impl Branch {
    /// The gap over the whole cell at one of its points (length).
    pub fn gap(&self, point: &Point) -> Array2<f64> {
        let State {
            mean_displacement: u0,
            amplitudes,
            ..
        } = &point.state;
        if amplitudes.is_empty() {
            return Array2::from_elem(self.system.grid().shape(), *u0);
        }
        self.system
            .unfolded(&self.system.gap_field(amplitudes, *u0))
    }

    /// The same over the cell of the scene: ridges, and the flat state, are known on a line, and
    /// lie in a square where `grid` is one.
    pub fn picture(&self, point: &Point, grid: &Grid) -> Array2<f64> {
        let gap = self.gap(point);
        let (rows, columns) = gap.dim();
        if rows > 1 || grid.is_line() {
            return gap;
        }
        let square = gap.broadcast((columns, columns)).map(|gap| gap.to_owned());
        square.unwrap_or(gap)
    }

    /// The modes along which the state at one of its points is unstable, the softest first, as
    /// fields of the whole cell with mean square 1; of the flat state none, whose modes are waves.
    ///
    /// # Errors
    /// They were not all found, or somebody asked to stop.
    pub fn negative_modes(
        &self,
        point: &Point,
        model: &Model,
        cancel: &Cancel,
    ) -> Result<Vec<Array2<f64>>, Lost> {
        if point.state.amplitudes.is_empty() {
            return Ok(Vec::new());
        }
        let mut mechanics = self.on_whole_cell(model, self.system.control(), cancel);
        let at = self.surface(point, &mut mechanics);
        let found = negative_modes(&mut mechanics, &at)?;
        Ok(found
            .iter()
            .map(|mode| mechanics.field(mode).clone())
            .collect())
    }

    /// The mechanics of the whole cell on the mesh of its states, driven by `control`.
    pub fn on_whole_cell(&self, model: &Model, control: Control, cancel: &Cancel) -> Mechanics {
        let own = self.system.grid();
        let whole = if own.is_line() && !model.grid.is_line() {
            let square = Grid::square(own.length, own.nx);
            System::new(square, *self.system.law(), &Indenter::Flat).with_body(self.system.body())
        } else if self.system.is_even() {
            System::whole(&self.system)
        } else {
            self.system.clone()
        };
        let mut mechanics = Mechanics::new(whole.with_control(control), slides_on(model));
        mechanics.cancel = cancel.clone();
        mechanics
    }

    /// The surface at one of its points, or next to it, in the mechanics of
    /// [`Branch::on_whole_cell`].
    pub fn surface(&self, point: &Point, mechanics: &mut Mechanics) -> Evaluation {
        let system = &mechanics.system;
        let mut displacement = self.picture(point, system.grid());
        if let Some(height) = system.height() {
            displacement += height;
        }
        let State {
            mean_displacement,
            stress,
            ..
        } = point.state;
        let [control, mean] = system.control().balanced(mean_displacement, stress);
        let mut z = mechanics.amplitudes(&displacement);
        z[0] = mean;
        mechanics.at(z, control)
    }

    /// Names the pattern of every point.
    fn classified(mut self) -> Self {
        let patterns: Vec<Pattern> = self
            .points
            .iter()
            .map(|point| {
                let gap = self.gap(point);
                classify(gap.view(), self.system.law(), self.system.is_flat())
            })
            .collect();
        for (point, pattern) in self.points.iter_mut().zip(patterns) {
            point.pattern = pattern;
        }
        self
    }
}

/// The modes along which a surface is unstable, the softest first, with norm 1.
///
/// # Errors
/// They were not all found, or somebody asked to stop.
pub fn negative_modes(mechanics: &mut Mechanics, at: &Evaluation) -> Result<Vec<Vec<f64>>, Lost> {
    mechanics.refresh(&at.fields);
    let mut tracker = Tracker::new(Pcg64::seed_from_u64(0));
    let found = tracker.negative(mechanics, &at.state.amplitudes, &at.fields, GOOD)?;
    let negative = found.values.iter().zip(found.vectors);
    let negative = negative.filter(|(value, _)| **value < 0.0);
    Ok(negative.map(|(_, mode)| mode).collect())
}

/// What is told while a diagram is computed: the name of the branch under way, its points so far,
/// and u0 (length).
pub type Observe<'r> = &'r mut dyn FnMut(&str, usize, f64);

impl Diagram {
    /// The diagram of `scene`, on uneven ground by the `part` of the cell that holds its loop.
    /// Branches are followed at fixed u0, where equilibria are the same.
    ///
    /// # Errors
    /// The first value of the scene that is not allowed. What could not be followed is in
    /// [`Diagram::missing`].
    pub fn of(
        scene: &Scene,
        part: Part,
        cancel: &Cancel,
        observe: Observe<'_>,
    ) -> Result<Self, Refusal> {
        let control = scene.control();
        let fixed = scene.at_fixed_u0(&scene.model()?);
        let model = fixed.model()?;
        let mut diagram = Self {
            control,
            ..Self::default()
        };
        if model.indenter == Indenter::Flat {
            flat_ground::fill(&mut diagram, &fixed, &model, cancel, observe);
        } else {
            uneven::fill(&mut diagram, &fixed, part, cancel, observe)?;
        }
        for branch in &mut diagram.branches {
            branch.system = branch.system.clone().with_control(control);
            for point in &mut branch.points {
                point.state.put_under(control);
            }
        }
        diagram.equal_energies = piece::equal_energies(&diagram);
        diagram.cancelled = cancel.requested();
        Ok(diagram)
    }

    /// Adds a branch as far as it was followed.
    fn add(&mut self, branch: Branch) {
        let Branch {
            name,
            points,
            ending,
            ..
        } = &branch;
        if matches!(ending, Ending::Budget | Ending::Lost(_)) {
            let last = points
                .last()
                .map_or(f64::NAN, |p| p.state.mean_displacement);
            self.missing.push(format!(
                "the branch \"{name}\" beyond u0 = {last:.5}: {ending}"
            ));
        }
        // Where it was lost at once there is only the state that it leaves.
        if points.len() > 1 {
            self.branches.push(branch.classified());
        }
    }

    /// Folds and bifurcations with the branch on which they are, in their order.
    pub fn events(&self) -> impl Iterator<Item = (&Branch, &Point)> {
        self.branches.iter().flat_map(|branch| {
            let events = branch.points.iter().filter(|p| p.kind != Kind::Regular);
            events.map(move |point| (branch, point))
        })
    }

    /// True if every branch was followed to its end.
    pub fn is_complete(&self) -> bool {
        self.missing.is_empty() && !self.cancelled
    }
}
