//! Equilibria of one symmetry on flat ground: ridges on half a line, bulges and dimples on the symmetric part of a quarter cell.
//!
//! With the symmetry imposed there is no sliding and little left to compute: an exact block of the longest waves leaves a Newton
//! step two to four products. Every node carries its tangent along u0, and how soft it is in each way its branch can end.

use super::method::{Lost, Problem, Slides};
use super::newton::{NewtonEnd, NewtonLimits, descend};
use crate::numerics::cancel::Cancel;
use crate::numerics::eigen::{EigenLimits, smallest};
use crate::numerics::krylov::{CgEnd, CgLimits, conjugate_gradients};
use crate::numerics::vector::{add, dot, norm, scale};
use crate::physics::grid::Grid;
use crate::physics::indenter::Indenter;
use crate::physics::law::Law;
use crate::physics::low_block::{Class, LowBlock};
use crate::physics::preconditioner::Preconditioner;
use crate::physics::system::{Evaluation, System, Workspace, carried};
use crate::physics::theory::flat;

/// Root mean square force over sigma_max of a node between the ends of a branch. The energy is stationary, and the stress is
/// corrected along the tangent: the errors of both are second order in this.
pub const NODE: f64 = 2e-4;
/// The same for the ends, whose place must be known, and for states that are shown.
pub const SHARP: f64 = 1e-5;
/// Longest step while settling, root mean square in ranges.
const SETTLING: f64 = 0.2;
/// Newton steps of one solve.
const STEPS: usize = 9;
/// A step of a bordered solve that leaves more than this share of the force asks for fresh derivatives.
const SLOW: f64 = 0.1;
/// Products of one linear solve.
const PRODUCTS: usize = 40;
/// Reach of the blocks in units of L/L_c, the number of periods of the shortest wave that can soften on a flat surface: pattern
/// edges are sharper than that. At most 180 waves of one class, whose factorisation costs as much as a dozen transforms.
const REACH: f64 = 3.3;
const LEAST_REACH: f64 = 8.0;
const MOST_REACH: f64 = 20.0;

/// One equilibrium with its first derivatives along the branch.
#[derive(Clone, Debug)]
pub struct Node {
    /// Mean displacement u0 (length).
    pub u0: f64,
    /// Amplitudes (length).
    pub z: Vec<f64>,
    /// Energy per area V (E* times length).
    pub energy: f64,
    /// Mean stress dV/du0 (E*).
    pub stress: f64,
    /// d stress/du0 along the branch; infinite at a fold.
    pub slope: f64,
    /// dz/du0 along the branch; at a fold the null vector instead, of norm 1.
    pub tangent: Vec<f64>,
    /// Smallest eigenvalue among modes of the state's own symmetry (E* per length): zero at a fold.
    pub own: f64,
    /// Smallest eigenvalue among modes that break it (E* per length).
    pub breaking: f64,
    /// True if that mode is odd, a ridge about to meander: beyond the reach of every even model.
    pub breaks_oddly: bool,
    /// Soft modes as amplitudes, where they are needed, and as coefficients of the blocks.
    breaking_mode: Vec<f64>,
    own_mode: Vec<f64>,
    breaking_waves: Vec<Vec<f64>>,
    own_waves: Vec<f64>,
}

impl Node {
    /// A node whose softness is not measured yet.
    fn bare(u0: f64, z: Vec<f64>, energy: f64, stress: f64, slope: f64, tangent: Vec<f64>) -> Self {
        Self {
            u0,
            z,
            energy,
            stress,
            slope,
            tangent,
            own: f64::NAN,
            breaking: f64::NAN,
            breaks_oddly: false,
            breaking_mode: Vec::new(),
            own_mode: Vec::new(),
            breaking_waves: Vec::new(),
            own_waves: Vec::new(),
        }
    }
}

/// Solver of the equilibria of one symmetry.
#[derive(Clone, Debug)]
pub struct Sector {
    system: System,
    class: Class,
    preconditioner: Preconditioner,
    breaking: Vec<LowBlock>,
    /// True if soft modes have waves beyond the blocks' reach.
    partial: bool,
    ws: Workspace,
    /// Amplitudes and mean of gamma'' at the last refresh: the derivative of forces and stress with u0.
    stiffness: Vec<f64>,
    mean_stiffness: f64,
}

impl Sector {
    /// Ridges: fields of x alone.
    pub fn ridge(length: f64, n: usize, law: Law) -> Self {
        let system = System::even(Grid::line(length, n), law, &Indenter::Flat);
        let modulations = [Class::Varicose, Class::Sinuous].map(|class| LowBlock::new(&system, class, f64::INFINITY));
        Self::new(system, Class::Even, modulations.into(), f64::INFINITY)
    }

    /// Bulges and dimples: fields that keep x <-> y.
    pub fn square(length: f64, n: usize, law: Law) -> Self {
        let system = System::even(Grid::square(length, n), law, &Indenter::Flat);
        let periods = length / flat::critical_length(&law);
        let reach = (REACH * periods).clamp(LEAST_REACH, MOST_REACH);
        let block = LowBlock::new(&system, Class::Antisymmetric, reach);
        let mut sector = Self::new(system, Class::Symmetric, vec![block], reach);
        sector.partial = REACH * periods > MOST_REACH;
        sector
    }

    fn new(system: System, class: Class, breaking: Vec<LowBlock>, reach: f64) -> Self {
        let law = system.law();
        let constant = 0.25 * law.at(law.equilibrium_gap()).stiffness;
        Self {
            preconditioner: Preconditioner::of_class(&system, constant, class, reach),
            partial: false,
            class,
            breaking,
            ws: system.workspace(),
            stiffness: vec![0.0; system.dimension()],
            mean_stiffness: 0.0,
            system,
        }
    }

    /// The mechanics.
    pub fn system(&self) -> &System {
        &self.system
    }

    /// Transforms spent so far.
    pub fn transforms(&self) -> usize {
        self.ws.transforms
    }

    /// True for ridges.
    pub fn is_ridge(&self) -> bool {
        self.class == Class::Even
    }

    fn scale(&self) -> f64 {
        self.system.law().traction_max()
    }

    /// The derivatives of forces and stress with u0 at the last evaluated state. One transform.
    fn differentiate(&mut self) {
        self.mean_stiffness = self.system.stiffness_amplitudes(&mut self.stiffness, &mut self.ws);
    }

    /// These and the exact block.
    fn refresh(&mut self) {
        self.differentiate();
        let block = self.preconditioner.low_block_mut().expect("an even system has a block");
        block.assemble(&self.system, &self.stiffness, self.mean_stiffness);
    }

    /// Solves P H P x = P b, P removing the unit vectors `removed`.
    fn solve(&mut self, b: &[f64], removed: &[Vec<f64>], tolerance: f64) -> Result<Vec<f64>, Lost> {
        let Self { system, preconditioner, ws, class, .. } = self;
        let found = conjugate_gradients(
            |v, out| system.hessian(v, out, ws),
            b,
            |r, out| preconditioner.apply(r, out),
            removed,
            CgLimits { tolerance, products: PRODUCTS },
            &Cancel::default(),
        );
        if found.end == CgEnd::NegativeCurvature {
            return Err(Lost::Unstable);
        }
        let mut x = found.x;
        class.project(system, &mut x);
        Ok(x)
    }

    /// The equilibrium at `u0` next to the guess `z`, with everything a node knows; the force below `tolerance` ([`NODE`]).
    ///
    /// # Errors
    /// No equilibrium near, or negative curvature on the way.
    pub fn node(&mut self, u0: f64, z: Vec<f64>, before: Option<&Node>, tolerance: f64) -> Result<Node, Lost> {
        let (z, g, at) = self.converge(u0, z, tolerance)?;
        self.refresh();
        let b = self.stiffness.clone();
        let mut tangent = self.solve(&b, &[], 1e-2)?;
        tangent.iter_mut().for_each(|t| *t = -*t);
        let slope = self.mean_stiffness + dot(&b, &tangent);
        let mut node = Node::bare(u0, z, at.energy, at.stress + dot(&tangent, &g), slope, tangent);
        self.soften(&mut node, before);
        Ok(node)
    }

    /// Down to the minimum at `u0` in whose valley `z` lies; `None` if it is not found. For guesses too far for [`Sector::node`].
    pub fn settle(&mut self, u0: f64, mut z: Vec<f64>) -> Option<Vec<f64>> {
        let radius = SETTLING * self.system.law().range;
        for _ in 0..ROUNDS {
            let mut g = vec![0.0; z.len()];
            self.system.evaluate(&z, u0, &mut g, &mut self.ws);
            self.refresh();
            let limits = NewtonLimits { tolerance: NODE, steps: 6, products: PRODUCTS, forcing: 0.3 };
            let problem = Problem { system: &self.system, preconditioner: &self.preconditioner, slides: Slides::Never };
            let state = descend(&problem, z, u0, radius, limits, &mut self.ws, &Cancel::default());
            z = state.z;
            self.class.project(&self.system, &mut z);
            match state.end {
                NewtonEnd::Converged => return Some(z),
                NewtonEnd::Stalled if state.residual.is_finite() => {}
                _ => return None,
            }
        }
        None
    }

    /// Newton's method at fixed u0; leaves the workspace evaluated at the result.
    fn converge(&mut self, u0: f64, mut z: Vec<f64>, tolerance: f64) -> Result<(Vec<f64>, Vec<f64>, Evaluation), Lost> {
        let strongest = self.scale();
        let mut g = vec![0.0; z.len()];
        let mut before = f64::INFINITY;
        for step in 0..=STEPS {
            let at = self.system.evaluate(&z, u0, &mut g, &mut self.ws);
            self.class.project(&self.system, &mut g);
            let force = norm(&g) / strongest;
            if force <= tolerance {
                return Ok((z, g, at));
            }
            // Written so that NaN ends here too.
            if !(force <= 3.0 * before) || step == STEPS {
                break;
            }
            before = force;
            // The block of the node before serves a first step, and often the second.
            if step > 1 || !self.preconditioner.low_block().is_some_and(LowBlock::is_ready) {
                self.refresh();
            }
            let dz = self.solve(&g, &[], (0.3 * tolerance / force).max(force.min(0.1)).min(0.3))?;
            add(&mut z, -1.0, &dz);
        }
        Err(Lost::Gone)
    }

    /// Fills in how soft the node is: from the blocks at the last refresh, and where those leave out waves that matter from the
    /// whole Hessian, starting from the modes of the node before.
    fn soften(&mut self, node: &mut Node, before: Option<&Node>) {
        let block = self.preconditioner.low_block().expect("an even system has a block");
        let known = before.map(|n| &n.own_waves[..]);
        let own;
        (own, node.own_waves) = block.softest(known);
        let all_positive = block.negative() == 0;
        node.own = if all_positive { own } else { own.min(-f64::MIN_POSITIVE) };
        node.breaking = f64::INFINITY;
        let is_ridge = self.is_ridge();
        for (i, block) in self.breaking.iter_mut().enumerate() {
            block.assemble(&self.system, &self.stiffness, self.mean_stiffness);
            let known = before.map(|n| &n.breaking_waves[i][..]);
            let (value, waves) = block.softest(known);
            if value < node.breaking {
                (node.breaking, node.breaks_oddly) = (value, i == 1);
            }
            node.breaking_waves.push(waves);
        }
        if !is_ridge {
            node.breaking_mode = self.breaking[0].mode(&node.breaking_waves[0], &self.system);
        }
        if self.partial {
            let block = self.preconditioner.low_block().expect("an even system has a block");
            node.own_mode = block.mode(&node.own_waves, &self.system);
            let limits = EigenLimits { pairs: 1, least: 1, most: 4, relative: 0.05, absolute: 1e-3 * self.system.grid().q1() };
            let start = |mode: &Vec<f64>, known: Option<&Vec<f64>>| known.into_iter().chain([mode]).cloned().collect();
            let own = self.refine(Class::Symmetric, start(&node.own_mode, before.map(|n| &n.own_mode)), limits);
            (node.own, node.own_mode) = own;
            let breaking = self.refine(Class::Antisymmetric, start(&node.breaking_mode, before.map(|n| &n.breaking_mode)), limits);
            (node.breaking, node.breaking_mode) = breaking;
        }
    }

    /// The smallest eigenpair of one class over all waves of the mesh, at the state at which the workspace was last evaluated.
    fn refine(&mut self, class: Class, start: Vec<Vec<f64>>, limits: EigenLimits) -> (f64, Vec<f64>) {
        let Self { system, preconditioner, ws, breaking, .. } = self;
        let apply = |v: &[f64], out: &mut [f64]| {
            system.hessian(v, out, ws);
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
        (found.values[0], found.vectors.swap_remove(0))
    }

    /// The eigenvalue `breaking` of `node`, at which the workspace must be evaluated, over all waves of the mesh, not only the
    /// longest, and closely. On a line the block is complete already.
    pub fn sharpen(&mut self, node: &mut Node) {
        if self.is_ridge() {
            return;
        }
        let limits = EigenLimits { pairs: 1, least: 1, most: 10, relative: 0.02, absolute: 3e-4 * self.system.grid().q1() };
        (node.breaking, node.breaking_mode) = self.refine(Class::Antisymmetric, vec![node.breaking_mode.clone()], limits);
    }

    /// The mode in which `node` breaks its symmetry, as amplitudes of a square even system `to`: a modulation of a ridge, or the
    /// mode of a square state carried over. Of a meandering ridge nothing is in it.
    pub fn breaking_mode(&self, node: &Node, to: &System) -> Vec<f64> {
        if self.is_ridge() {
            self.breaking[0].mode(&node.breaking_waves[0], to)
        } else {
            carried(&node.breaking_mode, &self.system, to)
        }
    }

    /// One solve of the bordered problem: equilibrium with prescribed component `a` along the unit vector `phi`, u0 free. Passes
    /// through folds. Returns the node (its tangent is dz/da) and du0/da.
    fn arc(&mut self, phi: &[f64], a: f64, mut u0: f64, mut z: Vec<f64>) -> Result<(Node, f64), Lost> {
        let strongest = self.scale();
        let removed = [phi.to_vec()];
        let mut g = vec![0.0; z.len()];
        let shift = a - dot(phi, &z);
        add(&mut z, shift, phi);
        let mut image = vec![0.0; z.len()];
        // Found at the first step, again where steps help little, and, when it counts, at the last.
        let mut along_u = Vec::new();
        let mut before = 0.0;
        for step in 0..=STEPS {
            let at = self.system.evaluate(&z, u0, &mut g, &mut self.ws);
            self.class.project(&self.system, &mut g);
            let force = norm(&g) / strongest;
            if !force.is_finite() || step == STEPS {
                break;
            }
            let converged = force <= SHARP;
            let slow = force > SLOW * before;
            before = force;
            if slow || converged {
                self.refresh();
            } else {
                self.differentiate();
            }
            let b = self.stiffness.clone();
            if slow || converged {
                along_u = self.solve(&b, &removed, 1e-2)?;
            }
            self.system.hessian(phi, &mut image, &mut self.ws);
            let border = dot(phi, &b) - dot(&image, &along_u);
            if converged {
                // What is left of the force along phi is a matter of u0.
                u0 -= dot(phi, &g) / border;
                let w = image.clone();
                let along_a = self.solve(&w, &removed, 1e-2)?;
                let rate = -(dot(phi, &image) - dot(&image, &along_a)) / border;
                let mut tangent = phi.to_vec();
                add(&mut tangent, -1.0, &along_a);
                add(&mut tangent, -rate, &along_u);
                let slope = self.mean_stiffness * rate + dot(&b, &tangent);
                let mut node = Node::bare(u0, z, at.energy, at.stress, slope, tangent);
                self.soften(&mut node, None);
                return Ok((node, rate));
            }
            let along_g = self.solve(&g, &removed, (0.3 * SHARP / force).clamp(1e-3, 0.1))?;
            let du = -(dot(phi, &g) - dot(&image, &along_g)) / border;
            add(&mut z, -1.0, &along_g);
            add(&mut z, -du, &along_u);
            u0 += du;
        }
        Err(Lost::Gone)
    }

    /// The fold ahead of `here` in the direction of growing u0 if `up`; `before` is the node before it. The node returned has the
    /// null vector as tangent, pointing onwards, and an infinite slope.
    ///
    /// # Errors
    /// The branch was lost on the way.
    pub fn fold(&mut self, before: &Node, here: &Node, up: bool) -> Result<Node, Lost> {
        let range = self.system.law().range;
        let sign = if up { 1.0 } else { -1.0 };
        let length = norm(&here.tangent);
        let phi: Vec<f64> = here.tangent.iter().map(|t| sign * t / length).collect();
        let (mut behind, mut last) = (Arc::of(before, &phi), Arc::of(here, &phi));
        for _ in 0..ROUNDS {
            let a = Arc::extremum(&behind, &last, up).0;
            if !a.is_finite() {
                break;
            }
            let a = a.clamp(last.a - STRIDE * range, last.a + STRIDE * range);
            let (guess, u0) = Arc::between(&behind, &last, a);
            let (mut found, rate) = self.arc(&phi, a, u0, guess)?;
            let arc = Arc { a, u0: found.u0, rate, z: found.z.clone(), dz: found.tangent.clone() };
            let top = Arc::extremum(&last, &arc, up);
            if (top.1 - found.u0).abs() < LOCATED * range {
                let shift = top.0 - a;
                add(&mut found.z, shift, &arc.dz);
                found.energy += found.stress * (top.1 - found.u0);
                found.stress += shift * found.slope;
                found.u0 = top.1;
                let length = norm(&found.tangent);
                found.tangent.iter_mut().for_each(|t| *t /= length);
                found.slope = f64::INFINITY;
                return Ok(found);
            }
            (behind, last) = (last, arc);
        }
        Err(Lost::Gone)
    }
}

/// A point of a branch with its component `a` along a fixed direction as parameter.
struct Arc {
    a: f64,
    u0: f64,
    /// du0/da.
    rate: f64,
    z: Vec<f64>,
    /// dz/da.
    dz: Vec<f64>,
}

impl Arc {
    fn of(node: &Node, phi: &[f64]) -> Self {
        let rate = 1.0 / dot(phi, &node.tangent);
        let mut dz = node.tangent.clone();
        scale(&mut dz, rate);
        Self { a: dot(phi, &node.z), u0: node.u0, rate, z: node.z.clone(), dz }
    }

    /// Where the rate of the cubic through two points vanishes, and u0 there: the maximum if `up`.
    fn extremum(a: &Self, b: &Self, up: bool) -> (f64, f64) {
        let h = b.a - a.a;
        let slope = (b.u0 - a.u0) / h;
        // u0 = a.u0 + a.rate s + c s^2 + d s^3 with s measured from a.
        let c = (3.0 * slope - 2.0 * a.rate - b.rate) / h;
        let d = (a.rate + b.rate - 2.0 * slope) / (h * h);
        let root = (c * c - 3.0 * d * a.rate).max(0.0).sqrt();
        // Of the two zeros of the rate the one where the second derivative, 2c + 6ds, has the right sign.
        let s = if up { -a.rate / (c - root) } else { -a.rate / (c + root) };
        (a.a + s, a.u0 + s * (a.rate + s * (c + s * d)))
    }

    /// Cubic Hermite of amplitudes and u0 through two points, at any `at`.
    fn between(a: &Self, b: &Self, at: f64) -> (Vec<f64>, f64) {
        let h = b.a - a.a;
        let t = (at - a.a) / h;
        let (t2, t3) = (t * t, t * t * t);
        let weights = [2.0 * t3 - 3.0 * t2 + 1.0, (t3 - 2.0 * t2 + t) * h, 3.0 * t2 - 2.0 * t3, (t3 - t2) * h];
        let mut z = vec![0.0; a.z.len()];
        for (w, part) in weights.iter().zip([&a.z, &a.dz, &b.z, &b.dz]) {
            add(&mut z, *w, part);
        }
        (z, weights[0] * a.u0 + weights[1] * a.rate + weights[2] * b.u0 + weights[3] * b.rate)
    }
}

/// Longest step along the branch towards a fold, root mean square, in ranges.
const STRIDE: f64 = 0.5;
/// Rounds of the search for a fold.
const ROUNDS: usize = 12;
/// Accuracy of the mean displacement of a fold, in ranges: the parabola through it is trusted that far.
const LOCATED: f64 = 2e-5;
