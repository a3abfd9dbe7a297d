//! The whole diagram of a scene: every branch of equilibria, stable and unstable, with its folds
//! and bifurcations, and where two stable branches have the same energy.
//!
//! The walk and the atlas know what is stable. Between the stable pieces lie unstable ones, which
//! explain why there is a jump: a branch turns back at a fold, or meets another one at a
//! bifurcation, and its end is where the two cancel or exchange their stability. Every point bears
//! its index, the number of negative eigenvalues over all modes of the whole cell.
//!
//! In pieces of one index the control grows along a branch, for where it turns back a mode changes
//! its sign. Between two stable pieces of the same energy neither is favoured.

mod branches;
mod trace;

use super::atlas::Support;
use super::record::LOCATED;
use crate::follow::walk::symmetry::slides_on;
use crate::numerics::threads::Cancel;
use crate::physics::control::Control;
use crate::physics::indenter::Indenter;
use crate::physics::law::Law;
use crate::physics::low_block::Class;
use crate::physics::mesh::Grid;
use crate::physics::parameter::Refusal;
use crate::physics::pattern::{Pattern, classify};
use crate::physics::system::{Evaluation, State, System};
use crate::physics::theory::boundary;
use crate::scene::{Model, Part, Scene};
use crate::solver::mechanics::Mechanics;
use crate::solver::method::Lost;
use crate::solver::stability::Tracker;
use ndarray::Array2;
use rand::SeedableRng;
use rand_pcg::Pcg64;
use std::fmt;

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
        let (law, is_flat) = (*self.system.law(), self.system.is_flat());
        for i in 0..self.points.len() {
            let gap = self.gap(&self.points[i]);
            self.points[i].pattern = classify(gap.view(), &law, is_flat);
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
            branches::on_flat_ground(&mut diagram, &fixed, &model, cancel, observe);
        } else {
            branches::on_uneven_ground(&mut diagram, &fixed, part, cancel, observe)?;
        }
        for branch in &mut diagram.branches {
            branch.system = branch.system.clone().with_control(control);
            for point in &mut branch.points {
                point.state.put_under(control);
            }
        }
        diagram.equal_energies = equal_energies(&diagram);
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

    /// All pieces whose states have `index` negative eigenvalues.
    pub fn pieces(&self, index: usize) -> impl Iterator<Item = Piece<'_>> {
        self.branches
            .iter()
            .flat_map(move |branch| pieces(branch, index))
    }

    /// True if every branch was followed to its end.
    pub fn is_complete(&self) -> bool {
        self.missing.is_empty() && !self.cancelled
    }
}

/// Points of one branch in a row, by the growing control, between two of its ends, folds and
/// bifurcations.
#[derive(Clone, Debug)]
pub struct Piece<'d> {
    /// The branch.
    pub branch: &'d Branch,
    points: Vec<&'d Point>,
}

fn pieces(branch: &Branch, index: usize) -> Vec<Piece<'_>> {
    let mut pieces: Vec<Piece<'_>> = Vec::new();
    let mut open = false;
    for point in &branch.points {
        let [before, after] = point.index;
        // At an event it may end and begin again.
        if before == index
            && open
            && let Some(piece) = pieces.last_mut()
        {
            piece.points.push(point);
        }
        if after == index && (!open || point.kind != Kind::Regular) {
            pieces.push(Piece {
                branch,
                points: vec![point],
            });
        }
        open = after == index;
    }
    pieces.retain(|piece| piece.points.len() > 1);
    for piece in &mut pieces {
        if piece.points.first().map(|p| place(p)) > piece.points.last().map(|p| place(p)) {
            piece.points.reverse();
        }
    }
    pieces
}

fn place(point: &Point) -> f64 {
    point.state.control
}

impl<'d> Piece<'d> {
    /// Lowest and highest value of the control.
    pub fn extent(&self) -> [f64; 2] {
        [
            place(self.points[0]),
            place(self.points[self.points.len() - 1]),
        ]
    }

    /// True if it has a state at this value of the control, within its ends.
    pub fn holds(&self, control: f64) -> bool {
        let [low, high] = self.extent();
        low < control && control < high
    }

    /// Values of the control at its points, ascending.
    pub fn places(&self) -> impl Iterator<Item = f64> + '_ {
        self.points.iter().map(|p| place(p))
    }

    /// The two points around a value of the control.
    pub fn around(&self, control: f64) -> [&'d Point; 2] {
        let after = self.points.partition_point(|p| place(p) <= control);
        let after = after.clamp(1, self.points.len() - 1);
        [self.points[after - 1], self.points[after]]
    }

    /// The state at a value of the control, without its amplitudes; meaningful within its extent.
    pub fn at(&self, value: f64) -> State {
        let control = self.branch.system.control();
        let ends = self.around(value);
        // In a variable of its own, as which neither end is a fold.
        let steady = steady(ends, self.branch.system.law());
        let [a, b] = ends.map(|point| support(point, control, steady));
        let place = |at: f64| steady.place(at, a.to(b, at).stress);
        let falls_short = |at: f64| {
            let [u0, stress] = place(at);
            control.balanced(u0, stress)[0] < value
        };
        let at = boundary(a.u0, b.u0, falls_short);
        let [mean_displacement, stress] = place(at);
        let body = a.to(b, at).energy - steady.energy(at, mean_displacement);
        State {
            control: value,
            mean_displacement,
            amplitudes: Vec::new(),
            energy: body + control.energy(value, mean_displacement),
            stress,
        }
    }

    /// The values of the control that two pieces have in common, if any.
    pub fn common(&self, other: &Self) -> Option<[f64; 2]> {
        let ([a, b], [c, d]) = (self.extent(), other.extent());
        let common = [a.max(c), b.min(d)];
        (common[0] < common[1]).then_some(common)
    }
}

/// Where u0 changes by less than this share of what the stress does (in ranges and sigma_max), it is
/// the stress that goes steadily.
const UPRIGHT: f64 = 1e-6;

/// What goes as steadily as can be from one point to the next, as if it were driven: along the mean
/// of both tangents in the plane of u0 and stress. Next to a fold the control goes as the square of
/// the way, this evenly with it.
fn steady([a, b]: [&Point; 2], law: &Law) -> Control {
    let (range, largest) = (law.range, law.traction_max());
    let [mut du, mut ds] = [0.0; 2];
    for [u, s] in [a.rates, b.rates] {
        let [u, s] = [u / range, s / largest];
        let length = u.hypot(s);
        // Where a branch meets another both are stationary.
        if length > 0.0 {
            (du, ds) = (du + u / length, ds + s / length);
        }
    }
    if ds == 0.0 {
        Control::Displacement
    } else if du.abs() < UPRIGHT * ds.abs() {
        Control::Load
    } else {
        // u0 + stress/k grows along (du, ds), also where k is negative.
        let stiffness = du / ds * largest / range;
        Control::Spring { stiffness }
    }
}

/// A point under `control` as it would be if `steady` were driven.
fn support(point: &Point, control: Control, steady: Control) -> Support {
    let (state, [du, ds]) = (&point.state, point.rates);
    let (u0, stress) = (state.mean_displacement, state.stress);
    let [at, _] = steady.balanced(u0, stress);
    Support {
        u0: at,
        energy: state.body_energy(control) + steady.energy(at, u0),
        stress: steady.conjugate(u0, stress),
        slope: steady.conjugate(du, ds) / steady.balanced(du, ds)[0],
    }
}

/// Stable pieces of two branches with the same energy at the same value of the control.
#[derive(Clone, Debug, PartialEq)]
pub struct EqualEnergy {
    /// Names of both branches.
    pub branches: [String; 2],
    /// Where: u0 or the position of the stage (length), or the load per area (E*).
    pub control: f64,
    /// u0 on each (length).
    pub mean_displacements: [f64; 2],
    /// Mean stress on each (E*).
    pub stresses: [f64; 2],
    /// Energy per area of both, that of the machine with it (E* times length).
    pub energy: f64,
}

/// Share of a range, or of sigma_max, within which states of the same energy at one value of the
/// control are the same, or copies of each other by symmetry.
const COPY: f64 = 1e-3;

impl EqualEnergy {
    fn of([a, b]: [&Piece<'_>; 2], control: f64) -> Self {
        let states = [a, b].map(|piece| piece.at(control));
        Self {
            branches: [a, b].map(|piece| piece.branch.name.clone()),
            control,
            mean_displacements: states.each_ref().map(|state| state.mean_displacement),
            stresses: states.each_ref().map(|state| state.stress),
            energy: states[0].energy,
        }
    }

    /// True if one of its states, and one of another pair, are copies of each other.
    fn has_copies(&self, i: usize, other: &Self, j: usize, law: &Law) -> bool {
        let way = self.mean_displacements[i] - other.mean_displacements[j];
        let pull = self.stresses[i] - other.stresses[j];
        way.abs() < COPY * law.range && pull.abs() < COPY * law.traction_max()
    }
}

/// All crossings of the energies of stable pieces, once where pieces are copies of each other.
fn equal_energies(diagram: &Diagram) -> Vec<EqualEnergy> {
    let pieces: Vec<Piece<'_>> = diagram.pieces(0).collect();
    let mut found: Vec<EqualEnergy> = Vec::new();
    for (i, a) in pieces.iter().enumerate() {
        let law = a.branch.system.law();
        let near = LOCATED * diagram.control.unit(law);
        for b in &pieces[i + 1..] {
            for control in crossings(a, b) {
                let pair = EqualEnergy::of([a, b], control);
                let is_known = |known: &EqualEnergy| {
                    (known.control - control).abs() < near
                        && (0..2).all(|k| pair.has_copies(k, known, k, law))
                };
                // The energies of copies differ by rounding alone.
                if !pair.has_copies(0, &pair, 1, law) && !found.iter().any(is_known) {
                    found.push(pair);
                }
            }
        }
    }
    found.sort_by(|a, b| b.control.total_cmp(&a.control));
    found
}

/// Where the energies of two pieces cross.
fn crossings(a: &Piece<'_>, b: &Piece<'_>) -> Vec<f64> {
    let Some([low, high]) = a.common(b) else {
        return Vec::new();
    };
    let within = |value: &f64| low < *value && *value < high;
    let mut places: Vec<f64> = a.places().chain(b.places()).filter(within).collect();
    places.extend([low, high]);
    places.sort_by(f64::total_cmp);
    let apart = |control: f64| a.at(control).energy - b.at(control).energy;
    let mut found = Vec::new();
    for pair in places.windows(2) {
        let (low, high) = (pair[0], pair[1]);
        // Pieces that meet at a bifurcation have the same energy there: no crossing.
        if apart(low) * apart(high) < 0.0 {
            found.push(boundary(low, high, |middle| {
                apart(low) * apart(middle) > 0.0
            }));
        }
    }
    found
}
