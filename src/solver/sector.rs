//! Equilibria of one symmetry on flat ground: ridges on half a line, bulges and dimples on the symmetric part of a quarter cell.
//!
//! With the symmetry imposed there is no sliding and little left to compute: an exact block of the longest waves leaves a Newton
//! step two to four products. Every node carries its tangent along u0, and how soft it is in each way its branch can end.

use super::method::Lost;
use crate::numerics::cancel::Cancel;
use crate::numerics::eigen::{EigenLimits, smallest};
use crate::numerics::krylov::{CgEnd, CgLimits, conjugate_gradients};
use crate::numerics::vector::{add, dot, norm};
use crate::physics::grid::Grid;
use crate::physics::indenter::Indenter;
use crate::physics::law::Law;
use crate::physics::low_block::{Class, LowBlock};
use crate::physics::preconditioner::Preconditioner;
use crate::physics::system::{System, Workspace};

/// Root mean square force of a node over sigma_max. The energy is stationary: its error is second order in this.
pub const NODE: f64 = 2e-5;
/// Newton steps of one solve.
const STEPS: usize = 9;
/// Products of one linear solve.
const PRODUCTS: usize = 40;
/// Longest wave numbers of the block of symmetry-breaking modes.
const BREAKING_WAVES: f64 = 10.0;

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
    /// The mode of `breaking`, as coefficients of [`Sector::breaking_mode`].
    pub breaking_mode: Vec<f64>,
    own_mode: Vec<f64>,
}

/// Solver of the equilibria of one symmetry.
#[derive(Clone, Debug)]
pub struct Sector {
    system: System,
    class: Class,
    preconditioner: Preconditioner,
    breaking: Vec<LowBlock>,
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
        Self::new(system, Class::Even, modulations.into())
    }

    /// Bulges and dimples: fields that keep x <-> y.
    pub fn square(length: f64, n: usize, law: Law) -> Self {
        let system = System::even(Grid::square(length, n), law, &Indenter::Flat);
        let block = LowBlock::new(&system, Class::Antisymmetric, BREAKING_WAVES);
        Self::new(system, Class::Symmetric, vec![block])
    }

    fn new(system: System, class: Class, breaking: Vec<LowBlock>) -> Self {
        let law = system.law();
        let constant = 0.25 * law.at(law.equilibrium_gap()).stiffness;
        Self {
            preconditioner: Preconditioner::of_class(&system, constant, class),
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

    /// D(gamma'') at the last evaluated state: block, and derivatives along u0. One transform.
    fn refresh(&mut self) {
        self.mean_stiffness = self.system.stiffness_amplitudes(&mut self.stiffness, &mut self.ws);
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

    /// The equilibrium at `u0` next to the guess `z`, with everything a node knows.
    ///
    /// # Errors
    /// No equilibrium near, or negative curvature on the way.
    pub fn node(&mut self, u0: f64, z: Vec<f64>, before: Option<&Node>) -> Result<Node, Lost> {
        let (z, energy, stress) = self.converge(u0, z)?;
        self.refresh();
        let b = self.stiffness.clone();
        let mut tangent = self.solve(&b, &[], 1e-4)?;
        tangent.iter_mut().for_each(|t| *t = -*t);
        let slope = self.mean_stiffness + dot(&b, &tangent);
        let mut node = Node {
            u0,
            z,
            energy,
            stress,
            slope,
            tangent,
            own: f64::NAN,
            breaking: f64::NAN,
            breaking_mode: Vec::new(),
            own_mode: Vec::new(),
        };
        self.soften(&mut node, before);
        Ok(node)
    }

    /// Newton's method at fixed u0; leaves the workspace evaluated at the result.
    fn converge(&mut self, u0: f64, mut z: Vec<f64>) -> Result<(Vec<f64>, f64, f64), Lost> {
        let scale = self.scale();
        let mut g = vec![0.0; z.len()];
        let mut before = f64::INFINITY;
        for step in 0..=STEPS {
            let at = self.system.evaluate(&z, u0, &mut g, &mut self.ws);
            self.class.project(&self.system, &mut g);
            let force = norm(&g) / scale;
            if force <= NODE {
                return Ok((z, at.energy, at.stress));
            }
            // Written so that NaN ends here too.
            if !(force <= 3.0 * before) || step == STEPS {
                break;
            }
            before = force;
            self.refresh();
            let dz = self.solve(&g, &[], (0.3 * NODE / force).max(force.min(0.1)).min(0.3))?;
            add(&mut z, -1.0, &dz);
        }
        Err(Lost::Gone)
    }

    /// Fills in how soft the node is, from the blocks at the last refresh.
    fn soften(&mut self, node: &mut Node, before: Option<&Node>) {
        let block = self.preconditioner.low_block().expect("an even system has a block");
        (node.own, node.own_mode) = block.softest(before.map(|n| &n.own_mode[..]));
        if block.negative() > 0 {
            node.own = node.own.min(-f64::MIN_POSITIVE);
        }
        node.breaking = f64::INFINITY;
        for (i, block) in self.breaking.iter_mut().enumerate() {
            block.assemble(&self.system, &self.stiffness, self.mean_stiffness);
            let (value, mode) = block.softest(None);
            if value < node.breaking {
                (node.breaking, node.breaking_mode) = (value, std::iter::once(i as f64).chain(mode).collect());
            }
        }
    }

    /// The eigenvalue `breaking` of `node` over all waves of the mesh, not only the longest; the workspace must be evaluated there.
    /// On a line the block is complete already.
    pub fn sharpen(&mut self, node: &mut Node) {
        if self.is_ridge() {
            return;
        }
        let start = self.breaking_mode(node, &self.system);
        let Self { system, preconditioner, ws, breaking, .. } = self;
        let class = Class::Antisymmetric;
        let found = smallest(
            |v, out| {
                system.hessian(v, out, ws);
                class.project(system, out);
            },
            vec![start],
            &[],
            |r, out| {
                for ((o, r), m) in out.iter_mut().zip(r).zip(preconditioner.diagonal()) {
                    *o = r * m;
                }
                breaking[0].precondition(r, out);
            },
            EigenLimits { pairs: 1, least: 1, most: 6, relative: 0.02, absolute: 3e-4 * system.grid().q1() },
            &Cancel::default(),
        );
        node.breaking = found.values[0];
    }

    /// The mode in which `node` breaks its symmetry, as amplitudes in an even `system`; `None` for a meandering ridge, which no even
    /// system holds.
    pub fn breaking_mode(&self, node: &Node, system: &System) -> Vec<f64> {
        let (block, coefficients) = node.breaking_mode.split_first().expect("a measured node has a mode");
        self.breaking[*block as usize].mode(coefficients, system)
    }

    /// True if the softest breaking mode of `node` is odd: beyond the reach of every even model.
    pub fn breaks_oddly(&self, node: &Node) -> bool {
        self.is_ridge() && node.breaking_mode.first() == Some(&1.0)
    }

    /// One solve of the bordered problem: equilibrium with prescribed component `a` along the unit vector `phi`, u0 free. Passes
    /// through folds. Returns the node (its tangent is dz/da) and du0/da.
    fn arc(&mut self, phi: &[f64], a: f64, mut u0: f64, mut z: Vec<f64>) -> Result<(Node, f64), Lost> {
        let scale = self.scale();
        let removed = [phi.to_vec()];
        let mut g = vec![0.0; z.len()];
        let shift = a - dot(phi, &z);
        add(&mut z, shift, phi);
        let mut image = vec![0.0; z.len()];
        for step in 0..=STEPS {
            let at = self.system.evaluate(&z, u0, &mut g, &mut self.ws);
            self.class.project(&self.system, &mut g);
            let force = norm(&g) / scale;
            if !force.is_finite() || step == STEPS {
                break;
            }
            self.refresh();
            let b = self.stiffness.clone();
            let accurate = if force <= 100.0 * NODE { 1e-4 } else { 1e-2 };
            let along_u = self.solve(&b, &removed, accurate)?;
            self.system.hessian(phi, &mut image, &mut self.ws);
            let border = dot(phi, &b) - dot(&image, &along_u);
            if force <= NODE {
                let w = image.clone();
                let along_a = self.solve(&w, &removed, 1e-4)?;
                let rate = -(dot(phi, &image) - dot(&image, &along_a)) / border;
                let mut tangent = phi.to_vec();
                add(&mut tangent, -1.0, &along_a);
                add(&mut tangent, -rate, &along_u);
                let slope = self.mean_stiffness * rate + dot(&b, &tangent);
                let mut node = Node {
                    u0,
                    z,
                    energy: at.energy,
                    stress: at.stress,
                    slope,
                    tangent,
                    own: 0.0,
                    breaking: f64::NAN,
                    breaking_mode: Vec::new(),
                    own_mode: Vec::new(),
                };
                self.soften(&mut node, None);
                return Ok((node, rate));
            }
            let along_g = self.solve(&g, &removed, (0.3 * NODE / force).clamp(1e-3, 0.1))?;
            let du = -(dot(phi, &g) - dot(&image, &along_g)) / border;
            add(&mut z, -1.0, &along_g);
            add(&mut z, -du, &along_u);
            u0 += du;
        }
        Err(Lost::Gone)
    }

    /// The fold ahead of `node` in the direction of growing u0 if `up`, about `distance` away. The node returned has the null vector
    /// as tangent, pointing onwards, and an infinite slope.
    ///
    /// # Errors
    /// The branch was lost on the way.
    pub fn fold(&mut self, node: &Node, up: bool, distance: f64) -> Result<Node, Lost> {
        let range = self.system.law().range;
        let sign = if up { 1.0 } else { -1.0 };
        let length = norm(&node.tangent);
        let phi: Vec<f64> = node.tangent.iter().map(|t| sign * t / length).collect();
        // Arc length of z beyond the node, the displacement there, and its rate: falling from here to zero at the fold.
        let base = dot(&phi, &node.z);
        let mut known = (0.0, node.u0, sign / length);
        let mut state = (node.u0, node.z.clone(), phi.clone(), known.2);
        let mut trial = (2.0 * distance * length).min(STRIDE * range);
        for _ in 0..ROUNDS {
            let ahead = trial - known.0;
            let mut guess = state.1.clone();
            add(&mut guess, ahead, &state.2);
            let (mut found, rate) = self.arc(&phi, base + trial, state.0 + 0.5 * ahead * state.3, guess)?;
            let here = (trial, found.u0, rate);
            let top = extremum(known, here, up);
            if (top.1 - found.u0).abs() < LOCATED * range {
                let shift = top.0 - trial;
                add(&mut found.z, shift, &found.tangent.clone());
                found.energy += found.stress * (top.1 - found.u0);
                found.stress += shift * found.slope;
                found.u0 = top.1;
                let length = norm(&found.tangent);
                found.tangent.iter_mut().for_each(|t| *t /= length);
                found.slope = f64::INFINITY;
                return Ok(found);
            }
            state = (found.u0, found.z, found.tangent, rate);
            trial = top.0.clamp(trial - STRIDE * range, trial + STRIDE * range);
            known = here;
        }
        Err(Lost::Gone)
    }
}

/// Longest step along the branch towards a fold, root mean square, in ranges.
const STRIDE: f64 = 0.5;
/// Rounds of the search for a fold.
const ROUNDS: usize = 12;
/// Accuracy of the mean displacement of a fold, in ranges: the parabola through it is trusted that far.
const LOCATED: f64 = 2e-5;

/// Where the rate of the cubic through two points (position, value, rate) vanishes, and its value there: the maximum if `up`.
fn extremum(a: (f64, f64, f64), b: (f64, f64, f64), up: bool) -> (f64, f64) {
    let h = b.0 - a.0;
    let slope = (b.1 - a.1) / h;
    // Value = a.1 + a.2 s + c s^2 + d s^3 with s measured from a.
    let c = (3.0 * slope - 2.0 * a.2 - b.2) / h;
    let d = (a.2 + b.2 - 2.0 * slope) / (h * h);
    let root = (c * c - 3.0 * d * a.2).max(0.0).sqrt();
    // Of the two zeros of the rate the one where the second derivative, 2c + 6ds, has the right sign.
    let s = if up { -a.2 / (c - root) } else { -a.2 / (c + root) };
    if !s.is_finite() {
        return (b.0, f64::NAN);
    }
    (a.0 + s, a.1 + s * (a.2 + s * (c + s * d)))
}
