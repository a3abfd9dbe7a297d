//! Equilibria of one symmetry on flat ground: ridges on half a line, bulges and dimples on the
//! symmetric part of a quarter cell.
//!
//! With the symmetry imposed there is no sliding and little left to compute: an exact block of the
//! longest waves leaves a Newton step two to four products. Every node carries its tangent along
//! u0, and how soft it is in each way its branch can end.

mod fold;

use super::class_proof::Known;
use super::mechanics::{Mechanics, Rates};
use super::method::{Lost, Stiffness};
use super::newton::{NewtonLimits, Residual, descend, downhill, solve};
use crate::numerics::dense::{dot, norm};
use crate::numerics::eigen::{EigenLimits, EigenPairs, smallest};
use crate::numerics::krylov::CgLimits;
use crate::numerics::threads::Cancel;
use crate::physics::control::Control;
use crate::physics::indenter::Indenter;
use crate::physics::law::Law;
use crate::physics::low_block::{Class, LowBlock};
use crate::physics::mesh::Grid;
use crate::physics::preconditioner::class_reach;
use crate::physics::system::{Evaluation, Fields, State, System, carried};

/// Root mean square force over sigma_max of a node between the ends of a branch. The energy is
/// stationary, and the stress is corrected along the tangent: the errors of both are second order
/// in this.
pub const NODE: f64 = 2e-4;
/// The same for the ends, whose place must be known, and for states that are shown.
pub const SHARP: f64 = 1e-8;
/// Longest step while settling, root mean square in ranges.
const SETTLING: f64 = 0.2;
/// Descents of six steps while settling.
const DESCENTS: usize = 12;
/// Newton steps of one solve.
const STEPS: usize = 9;
/// Of which the block of a node close by serves the first, and often the second.
const SERVES: usize = 2;
/// Error of a soft mode that is followed, over its eigenvalue.
const FOLLOWED: f64 = 0.02;
/// Products of one linear solve.
const PRODUCTS: usize = 40;
/// Longest reach of the blocks: at most 180 waves of one class, whose factorisation costs as much
/// as a dozen transforms.
const MOST_REACH: f64 = 20.0;

/// An end of a branch along u0, and the way towards it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// Smaller u0.
    Lower,
    /// Larger u0.
    Upper,
}

impl Side {
    /// Both, by their index.
    pub const BOTH: [Self; 2] = [Side::Lower, Side::Upper];

    /// Place in a pair of ends.
    pub fn index(self) -> usize {
        self as usize
    }

    /// The other one.
    pub fn opposite(self) -> Self {
        if self == Side::Upper {
            Side::Lower
        } else {
            Side::Upper
        }
    }

    /// Sign of du0 on the way.
    pub fn sign(self) -> f64 {
        if self == Side::Upper { 1.0 } else { -1.0 }
    }
}

/// One equilibrium with its first derivatives along the branch.
#[derive(Clone, Debug)]
pub struct Node {
    /// The state.
    pub state: State,
    /// d stress/du0 along the branch; infinite at a fold.
    pub slope: f64,
    /// dz/du0 along the branch; at a fold the null vector instead, of norm 1.
    pub tangent: Vec<f64>,
    /// Smallest eigenvalue among modes of the state's own symmetry (E* per length): zero at a fold.
    pub own: f64,
    /// Smallest eigenvalue among modes that break it (E* per length).
    pub breaking: f64,
    /// At a fold d2u0/da2 along the null vector, at the end where symmetry breaks d breaking/du0;
    /// NaN elsewhere.
    pub bend: f64,
    /// True if that mode is odd, a ridge about to meander: beyond the reach of every even model.
    pub breaks_oddly: bool,
    /// Soft modes as amplitudes, where they are needed, and as coefficients of the blocks.
    breaking_mode: Vec<f64>,
    own_mode: Vec<f64>,
    breaking_waves: Vec<Vec<f64>>,
    own_waves: Vec<f64>,
}

impl Node {
    /// Mean displacement (length).
    pub fn u0(&self) -> f64 {
        self.state.mean_displacement
    }

    /// True where amplitudes go with the root of the distance in u0: at a fold, and where the branch
    /// comes out of the flat state.
    pub fn is_vertical(&self) -> bool {
        !self.slope.is_finite() || norm(&self.state.amplitudes) == 0.0
    }

    /// The smallest eigenvalue under `control` (E* per length). With u0 free no more than that along
    /// the branch, (S + k)/(1 + |dz/du0|^2), which vanishes with it where the control turns back.
    pub fn softness(&self, control: Control) -> f64 {
        let fixed = self.own.min(self.breaking);
        if !control.frees_mean() || !self.slope.is_finite() {
            return fixed;
        }
        let along = 1.0 + dot(&self.tangent, &self.tangent);
        fixed.min((self.slope + control.stiffness()) / along)
    }

    /// A node whose softness is not measured yet.
    fn bare(state: State, slope: f64, tangent: Vec<f64>) -> Self {
        Self {
            state,
            slope,
            tangent,
            own: f64::NAN,
            breaking: f64::NAN,
            bend: f64::NAN,
            breaks_oddly: false,
            breaking_mode: Vec::new(),
            own_mode: Vec::new(),
            breaking_waves: Vec::new(),
            own_waves: Vec::new(),
        }
    }
}

/// A state with the evidence for it.
#[derive(Clone, Debug)]
pub struct Measured {
    /// The state; its slope and tangent are not computed.
    pub node: Node,
    /// Its gap, traction and stiffness.
    pub fields: Fields,
    /// max |residual traction| / max(sigma_max, max |traction|).
    pub residual: f64,
    /// Smallest eigenvalue among the modes that [`Sector::measure`] knows (E* per length).
    pub stiffness: Stiffness,
    /// The softest mode of each class of a square state.
    pub known: Vec<Known>,
}

/// Solver of the equilibria of one symmetry.
#[derive(Clone, Debug)]
pub struct Sector {
    /// A request to cancel it interrupts a solve, which is then lost.
    pub mechanics: Mechanics,
    breaking: Vec<LowBlock>,
    /// Of a ridge the modes along x that are odd, among which it slides.
    odd: Option<LowBlock>,
    /// True if soft modes have waves beyond the blocks' reach.
    partial: bool,
}

impl Sector {
    /// Ridges: fields of x alone.
    pub fn ridge(length: f64, n: usize, law: Law) -> Self {
        let system = System::even(Grid::line(length, n), law, &Indenter::Flat);
        let modulations = [Class::Varicose(1), Class::Sinuous(1)]
            .map(|class| LowBlock::new(&system, class, f64::INFINITY));
        let odd = LowBlock::new(&system, Class::Sinuous(0), f64::INFINITY);
        let mut sector = Self::new(system, Class::Even, modulations.into(), f64::INFINITY);
        sector.odd = Some(odd);
        sector
    }

    /// Bulges and dimples: fields that keep x <-> y.
    pub fn square(length: f64, n: usize, law: Law) -> Self {
        let system = System::even(Grid::square(length, n), law, &Indenter::Flat);
        let reach = class_reach(&system, MOST_REACH);
        let block = LowBlock::new(&system, Class::Antisymmetric, reach);
        let mut sector = Self::new(system, Class::Symmetric, vec![block], reach);
        sector.partial = reach == MOST_REACH;
        sector
    }

    fn new(system: System, class: Class, breaking: Vec<LowBlock>, reach: f64) -> Self {
        Self {
            mechanics: Mechanics::of_class(system, class, reach),
            partial: false,
            odd: None,
            breaking,
        }
    }

    /// Law and cell.
    pub fn system(&self) -> &System {
        &self.mechanics.system
    }

    /// True for ridges.
    fn is_ridge(&self) -> bool {
        self.mechanics.class == Class::Even
    }

    fn scale(&self) -> f64 {
        self.system().law().traction_max()
    }

    /// The derivatives with u0, with the exact block made of them. One transform.
    fn refresh(&mut self, fields: &Fields) -> Rates {
        let rates = self.mechanics.rates(fields);
        self.mechanics.renew(fields, &rates);
        rates
    }

    /// Solves P H P x = P b for the Hessian H of a surface with these `fields`, P removing the unit
    /// vectors `removed`.
    fn solve(
        &mut self,
        fields: &Fields,
        b: &[f64],
        removed: &[Vec<f64>],
        tolerance: f64,
    ) -> Result<Vec<f64>, Lost> {
        let found =
            self.mechanics
                .solve_linear(fields, b, removed, CgLimits::new(tolerance, PRODUCTS));
        downhill(found.end).map(|()| found.x)
    }

    /// The equilibrium at `u0` next to the guess `z`, with everything a node knows, and its fields;
    /// the force below `tolerance` ([`NODE`]). The node `before`, if there is one, was found last.
    ///
    /// # Errors
    /// No equilibrium near, or negative curvature on the way.
    pub fn node(
        &mut self,
        u0: f64,
        z: Vec<f64>,
        before: Option<&Node>,
        tolerance: f64,
    ) -> Result<(Node, Fields), Lost> {
        let Evaluation {
            mut state,
            gradient,
            fields,
        } = self.converge(u0, z, before.map_or(0, |_| SERVES), tolerance)?;
        let rates = self.refresh(&fields);
        let mut tangent = self.solve(&fields, &rates.forces, &[], 1e-2)?;
        tangent.iter_mut().for_each(|t| *t = -*t);
        let slope = rates.stress + dot(&rates.forces, &tangent);
        state.stress += dot(&tangent, &gradient);
        let mut node = Node::bare(state, slope, tangent);
        self.soften(&mut node, before, &fields, &rates);
        Ok((node, fields))
    }

    /// The same as sharply as an end is known, and with its `breaking` over all waves of the mesh.
    ///
    /// # Errors
    /// As [`Sector::node`].
    pub fn sharp_node(
        &mut self,
        u0: f64,
        z: Vec<f64>,
        before: Option<&Node>,
    ) -> Result<Node, Lost> {
        let (mut node, fields) = self.node(u0, z, before, SHARP)?;
        self.sharpen(&mut node, &fields);
        Ok(node)
    }

    /// The flat state at its limit `u0`, where a branch comes out of it continuously and with this
    /// `slope`: nothing holds its waves there, of this symmetry or of another.
    pub fn out_of_flat(&self, u0: f64, slope: f64) -> Node {
        let flat = self.system().uniform(u0).state;
        let tangent = vec![0.0; flat.amplitudes.len()];
        Node {
            own: 0.0,
            breaking: 0.0,
            ..Node::bare(flat, slope, tangent)
        }
    }

    /// Down to the minimum at `u0` in whose valley `z` lies; `None` if it is not found. For guesses
    /// too far for [`Sector::node`].
    pub fn settle(&mut self, u0: f64, mut z: Vec<f64>) -> Option<Vec<f64>> {
        let radius = SETTLING * self.system().law().range;
        for _ in 0..DESCENTS {
            let at = self.mechanics.at(z, u0);
            self.refresh(&at.fields);
            let limits = NewtonLimits {
                tolerance: NODE,
                steps: 6,
                products: PRODUCTS,
                forcing: 0.3,
                ..NewtonLimits::default()
            };
            let found = descend(&mut self.mechanics, at.state.amplitudes, u0, radius, limits);
            z = found.at.state.amplitudes;
            match found.end {
                Ok(()) => return Some(z),
                Err(Lost::Gone) if found.residual.is_finite() => {}
                _ => return None,
            }
        }
        None
    }

    /// Newton's method at fixed u0, down to a root mean square force of `tolerance` (sigma_max);
    /// from step `refresh` on the block is made anew.
    fn converge(
        &mut self,
        u0: f64,
        z: Vec<f64>,
        refresh: usize,
        tolerance: f64,
    ) -> Result<Evaluation, Lost> {
        let limits = NewtonLimits {
            tolerance,
            residual: Residual::Mean,
            steps: STEPS,
            products: PRODUCTS,
            refresh,
            ..NewtonLimits::default()
        };
        solve(&mut self.mechanics, z, u0, limits)
            .converged()
            .map(|found| found.at)
    }

    /// Fills in how soft the node is, for which the block was refreshed: from the blocks, and where
    /// those leave out waves that matter from the whole Hessian, starting from the modes of the
    /// node before.
    fn soften(&mut self, node: &mut Node, before: Option<&Node>, fields: &Fields, rates: &Rates) {
        self.soften_in_blocks(node, before, rates);
        if !self.partial {
            return;
        }
        node.own_mode = block_of(&self.mechanics).mode(&node.own_waves, self.system());
        let limits = self.limits([1, 4], [0.05, 1e-3]);
        let start = |mode: &Vec<f64>, known: Option<&Vec<f64>>| {
            known.into_iter().chain([mode]).cloned().collect()
        };
        let from = start(&node.own_mode, before.map(|n| &n.own_mode));
        (node.own, node.own_mode, _) = self.refine(fields, Class::Symmetric, from, limits);
        let from = start(&node.breaking_mode, before.map(|n| &n.breaking_mode));
        (node.breaking, node.breaking_mode, _) =
            self.refine(fields, Class::Antisymmetric, from, limits);
    }

    /// The same among the waves of the blocks alone.
    fn soften_in_blocks(&mut self, node: &mut Node, before: Option<&Node>, rates: &Rates) {
        let block = block_of(&self.mechanics);
        (node.own, node.own_waves) = block.softest(before.map(|n| &n.own_waves[..]));
        node.own = signed(node.own, block.negative());
        node.breaking = f64::INFINITY;
        let is_ridge = self.is_ridge();
        for (i, block) in self.breaking.iter_mut().enumerate() {
            block.assemble(&self.mechanics.system, &rates.forces, rates.stress);
            let known = before.map(|n| &n.breaking_waves[i][..]);
            let (value, waves) = block.softest(known);
            let value = signed(value, block.negative());
            if value < node.breaking {
                (node.breaking, node.breaks_oddly) = (value, i == 1);
            }
            node.breaking_waves.push(waves);
        }
        if !is_ridge {
            node.breaking_mode = self.breaking[0].mode(&node.breaking_waves[0], self.system());
        }
    }

    /// For one eigenpair: fewest and most iterations, and the error at which it is good enough, over
    /// the eigenvalue and over q1.
    fn limits(&self, [least, most]: [usize; 2], [relative, absolute]: [f64; 2]) -> EigenLimits {
        EigenLimits {
            pairs: 1,
            least,
            most,
            relative,
            absolute: absolute * self.system().grid().q1(),
        }
    }

    /// The smallest eigenpair of one class, with its residual, over all waves of the mesh.
    fn refine(
        &mut self,
        fields: &Fields,
        class: Class,
        start: Vec<Vec<f64>>,
        limits: EigenLimits,
    ) -> (f64, Vec<f64>, f64) {
        let Self {
            mechanics:
                Mechanics {
                    system,
                    preconditioner,
                    workspace,
                    ..
                },
            breaking,
            ..
        } = self;
        let apply = |v: &[f64], out: &mut [f64]| {
            system.hessian(fields, v, out, workspace);
            class.project(system, out);
        };
        let precondition = |r: &[f64], out: &mut [f64]| {
            if class == Class::Symmetric {
                return preconditioner.apply(r, out);
            }
            for ((o, r), m) in out.iter_mut().zip(r).zip(preconditioner.diagonal()) {
                *o = r * m;
            }
            breaking[0].precondition(r, out);
        };
        let mut found = smallest(apply, start, &[], precondition, limits, &Cancel::default());
        (
            found.values[0],
            found.vectors.swap_remove(0),
            found.residual,
        )
    }

    /// The softest eigenpair of one class over all waves of the mesh, with its residual, at a `node`
    /// whose blocks were refreshed: from the mode `before`, or from that of the block where there is
    /// none or where it has become another.
    fn followed(
        &mut self,
        fields: &Fields,
        class: Class,
        node: &Node,
        before: Option<&Vec<f64>>,
    ) -> (f64, Vec<f64>, f64) {
        let (block, waves, of_block) = if class == Class::Symmetric {
            (block_of(&self.mechanics), &node.own_waves, node.own)
        } else {
            (&self.breaking[0], &node.breaking_waves[0], node.breaking)
        };
        let afresh = block.mode(waves, self.system());
        let limits = |least| self.limits([least, 12], [FOLLOWED, 1e-4]);
        let (known, anew) = (limits(0), limits(1));
        if let Some(mode) = before.filter(|mode| !mode.is_empty()) {
            let found = self.refine(fields, class, vec![mode.clone()], known);
            // The block is stiffer than all waves together, as far as it is known.
            if found.0 <= of_block + FOLLOWED * of_block.abs() {
                return found;
            }
        }
        self.refine(fields, class, vec![afresh], anew)
    }

    /// The eigenvalue `breaking` of a `node` with these `fields` over all waves of the mesh, not
    /// only the longest, and closely. On a line the block is complete already.
    pub fn sharpen(&mut self, node: &mut Node, fields: &Fields) {
        if self.is_ridge() {
            return;
        }
        let (from, limits) = (
            vec![node.breaking_mode.clone()],
            self.limits([1, 10], [0.02, 3e-4]),
        );
        (node.breaking, node.breaking_mode, _) =
            self.refine(fields, Class::Antisymmetric, from, limits);
    }

    /// The mode in which `node` breaks its symmetry, as amplitudes of a square even system `to`: a
    /// modulation of a ridge, or the mode of a square state carried over. Of a meandering ridge
    /// nothing is in it.
    pub fn breaking_mode(&self, node: &Node, to: &System) -> Vec<f64> {
        if self.is_ridge() {
            self.breaking[0].mode(&node.breaking_waves[0], to)
        } else {
            carried(&node.breaking_mode, self.system(), to)
        }
    }

    /// The state at `u0` next to the guess, with the evidence for it: residual below `tolerance`,
    /// and the smallest eigenvalue over all waves of the mesh: of a ridge among all modes of the
    /// square cell but its sliding (those with more than one wave along y are stiffer: so is the
    /// body to each of their waves), of a square state among the even ones.
    ///
    /// # Errors
    /// As [`Sector::node`].
    pub fn measure(
        &mut self,
        u0: f64,
        guess: Vec<f64>,
        before: Option<&Node>,
        tolerance: f64,
    ) -> Result<Measured, Lost> {
        let mut mean = 0.5 * tolerance;
        let mut at = self.converge(u0, guess, before.map_or(0, |_| SERVES), mean)?;
        let mut residual = self.mechanics.residual(&at);
        while !(residual <= tolerance) {
            // The largest residual is more than the mean one promised.
            mean *= 0.2;
            if mean < 1e-3 * tolerance {
                return Err(Lost::Gone);
            }
            at = self.converge(u0, at.state.amplitudes, SERVES, mean)?;
            residual = self.mechanics.residual(&at);
        }
        let Evaluation { state, fields, .. } = at;
        let rates = self.refresh(&fields);
        let mut node = Node::bare(state, f64::NAN, Vec::new());
        self.soften_in_blocks(&mut node, before, &rates);
        let mut stiffness = Stiffness {
            value: node.own.min(node.breaking),
            error: 1e-4 * node.own.abs().min(node.breaking.abs()),
        };
        let mut known = Vec::new();
        if let Some(odd) = &mut self.odd {
            let (d, mean) = (&rates.forces, rates.stress);
            odd.assemble_beside(&self.mechanics.system, d, mean, &node.state.amplitudes);
            let negative = odd.negative_below(0.0);
            let EigenPairs {
                values, residual, ..
            } = odd.lowest(1);
            let value = signed(values[0], negative);
            if value < stiffness.value {
                stiffness = Stiffness {
                    value,
                    error: residual,
                };
            }
        } else {
            let known_before = before.map(|n| (&n.own_mode, &n.breaking_mode)).unzip();
            let own = self.followed(&fields, Class::Symmetric, &node, known_before.0);
            let breaking = self.followed(&fields, Class::Antisymmetric, &node, known_before.1);
            (node.own, node.own_mode) = (own.0, own.1.clone());
            (node.breaking, node.breaking_mode) = (breaking.0, breaking.1.clone());
            known = [(Class::Symmetric, &own), (Class::Antisymmetric, &breaking)]
                .map(|(class, &(value, _, residual))| Known {
                    class,
                    value,
                    residual,
                })
                .into();
            let softest = if own.0 < breaking.0 { own } else { breaking };
            stiffness = Stiffness {
                value: softest.0,
                error: softest.2,
            };
        }
        Ok(Measured {
            node,
            fields,
            residual,
            stiffness,
            known,
        })
    }
}

fn block_of(mechanics: &Mechanics) -> &LowBlock {
    let block = mechanics.preconditioner.low_block();
    block.expect("an even system has a block")
}

/// The softest eigenvalue of a block with the sign that is known of so many `negative` pivots.
fn signed(value: f64, negative: usize) -> f64 {
    if negative > 0 {
        value.min(-f64::MIN_POSITIVE)
    } else {
        value
    }
}
