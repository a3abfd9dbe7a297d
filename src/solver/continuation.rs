//! Pseudo-arclength continuation (H. B. Keller, in *Applications of Bifurcation Theory*, 1977):
//! equilibria followed in the joint space of amplitudes and mean displacement, stable or not,
//! through folds.
//!
//! The arc length s is the root mean square distance of whole surfaces, ds^2 = |dz|^2 + du0^2. The
//! mean displacement takes the entry q = 0 of its vectors, which amplitudes leave free.
//! A step solves the bordered system
//!
//! H dz + f du = -g,   t_z.dz + t_u du = 0
//!
//! for the Hessian H, the force g = dV/dz, its derivative f with u0 and the direction t of the
//! branch: regular at folds, where H is not.

use super::mechanics::{Mechanics, Rates};
use super::method::Lost;
use crate::numerics::dense::{add, dot, hermite, norm, project_out, scale};
use crate::numerics::krylov::{CgLimits, minimal_residual};
use crate::physics::system::{Evaluation, Fields, State};

/// Root mean square force over sigma_max of a point: its stress and energy are then exact to more
/// digits than are written.
const TOLERANCE: f64 = 1e-8;
/// Newton steps of one point.
const STEPS: usize = 8;
/// Products of one bordered solve.
const PRODUCTS: usize = 100;
/// Relative residual of the solve for a tangent. A distance s from where another branch is left the
/// system is singular but for some hundredths of s: the tangent is then good to 1e-4 at 0.05
/// ranges.
const TANGENT: f64 = 1e-6;

/// A point of a branch.
#[derive(Clone, Debug)]
pub struct Knot {
    /// The equilibrium.
    pub state: State,
    /// Unit tangent of the branch, the way it is gone.
    pub tangent: Vec<f64>,
    /// d stress/ds along it (E* per length).
    pub stress_rate: f64,
    /// Arc length from the first point (length).
    pub arc: f64,
    /// max |residual traction| / max(sigma_max, max |traction|).
    pub residual: f64,
}

impl Knot {
    /// du0/ds; zero at a fold.
    pub fn rate(&self) -> f64 {
        self.tangent[0]
    }

    /// Cubic Hermite through two knots at arc length `s`, beyond them too: amplitudes and u0.
    pub fn between(a: &Self, b: &Self, s: f64) -> (Vec<f64>, f64) {
        let h = b.arc - a.arc;
        let joint = |knot: &Self| {
            let mut joint = knot.state.amplitudes.clone();
            joint[0] = knot.state.mean_displacement;
            joint
        };
        let ends = [&joint(a), &a.tangent, &joint(b), &b.tangent];
        let mut z = hermite(ends.map(Vec::as_slice), h, (s - a.arc) / h);
        let u0 = std::mem::take(&mut z[0]);
        (z, u0)
    }
}

/// The way from one surface (amplitudes and u0) to another, in the joint space.
pub fn way(from: (&[f64], f64), to: (&[f64], f64)) -> Vec<f64> {
    let mut way = to.0.to_vec();
    add(&mut way, -1.0, from.0);
    way[0] = to.1 - from.1;
    way
}

/// A bordered system at one surface.
struct Bordered<'a> {
    mechanics: &'a mut Mechanics,
    fields: &'a Fields,
    rates: Rates,
    border: &'a [f64],
    removed: Vec<Vec<f64>>,
}

/// Which block the preconditioner has.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Block {
    /// One made anew.
    Anew,
    /// That of a surface a Newton step away.
    Kept,
}

impl<'a> Bordered<'a> {
    /// At the surface `z` with these `fields`. One transform, two where an uneven system has its
    /// block made anew.
    fn new(
        mechanics: &'a mut Mechanics,
        z: &[f64],
        fields: &'a Fields,
        border: &'a [f64],
        block: Block,
    ) -> Self {
        let removed = mechanics.sliding_basis(z, fields);
        let mut rates = mechanics.rates(fields);
        if block == Block::Anew {
            mechanics.renew(fields, &rates);
        }
        mechanics
            .class
            .project(&mechanics.system, &mut rates.forces);
        rates.forces[0] = 0.0;
        Self {
            mechanics,
            fields,
            rates,
            border,
            removed,
        }
    }

    /// Solves for the right-hand side `b`, whose entry 0 is that of the border.
    fn solve(&mut self, b: &[f64], tolerance: f64) -> Result<Vec<f64>, Lost> {
        let Self {
            mechanics,
            fields,
            rates: Rates { forces, .. },
            border,
            removed,
        } = self;
        let Mechanics {
            system,
            preconditioner,
            workspace,
            class,
            cancel,
            ..
        } = &mut **mechanics;
        // The inverse of the bordered matrix with the approximate inverse of H.
        let mut along = vec![0.0; b.len()];
        preconditioner.apply_indefinite(forces, &mut along);
        project_out(&mut along, removed);
        let corner = border[0] - dot(border, &along);
        let precondition = |r: &[f64], out: &mut [f64]| {
            preconditioner.apply_indefinite(r, out);
            out[0] = 0.0;
            project_out(out, removed);
            let du = (r[0] - dot(border, out)) / corner;
            add(out, -du, &along);
            out[0] = du;
        };
        let apply = |x: &[f64], out: &mut [f64]| {
            system.hessian(fields, x, out, workspace);
            add(out, x[0], forces);
            class.project(system, out);
            project_out(out, removed);
            out[0] = dot(border, x);
        };
        let limits = CgLimits::new(tolerance, PRODUCTS);
        let (mut x, left) = minimal_residual(apply, b, precondition, limits, cancel);
        if cancel.requested() {
            return Err(Lost::Cancelled);
        }
        if !(left < 0.5) || x.iter().any(|x| !x.is_finite()) {
            return Err(Lost::Gone);
        }
        let du = std::mem::take(&mut x[0]);
        class.project(system, &mut x);
        system.make_real(&mut x);
        x[0] = du;
        Ok(x)
    }
}

impl Mechanics {
    /// The equilibrium next to the guess `z`, `u0` in the plane through it with the normal
    /// `direction`, with its tangent (the way `direction` points) and fields.
    ///
    /// # Errors
    /// No equilibrium was found there, or somebody asked to stop.
    pub fn knot(
        &mut self,
        mut z: Vec<f64>,
        u0: f64,
        direction: &[f64],
    ) -> Result<(Knot, Fields), Lost> {
        let scale_of_force = self.system.law().traction_max();
        // Below the floor of the precision there is nothing but rounding to follow.
        let goal = scale_of_force * TOLERANCE.max(self.system.precision().floor());
        // Amplitudes that belong to no real field are seen by no force: extrapolation would let
        // them grow out of the rounding.
        self.system.make_real(&mut z);
        let mut at = self.at(z, u0);
        let mut before = f64::INFINITY;
        for step in 0..=STEPS {
            let force = norm(&at.gradient);
            if !force.is_finite() || !at.state.energy.is_finite() {
                return Err(Lost::Gone);
            }
            if force <= goal {
                let block = if step == 0 { Block::Anew } else { Block::Kept };
                return self.measured(at, direction, block);
            }
            if step == STEPS || force > 3.0 * before {
                return Err(Lost::Gone);
            }
            before = force;
            let forcing = (0.3 * goal / force)
                .max((force / scale_of_force).min(0.1))
                .min(0.1);
            let mut b = at.gradient.clone();
            scale(&mut b, -1.0);
            let (z, fields) = (&at.state.amplitudes, &at.fields);
            let mut bordered = Bordered::new(self, z, fields, direction, Block::Anew);
            project_out(&mut b, &bordered.removed);
            b[0] = 0.0;
            let mut dx = bordered.solve(&b, forcing)?;
            at.state.drive_by(std::mem::take(&mut dx[0]));
            add(&mut at.state.amplitudes, 1.0, &dx);
            self.update(&mut at);
        }
        Err(Lost::Gone)
    }

    /// An equilibrium with its tangent.
    fn measured(
        &mut self,
        at: Evaluation,
        direction: &[f64],
        block: Block,
    ) -> Result<(Knot, Fields), Lost> {
        let residual = self.residual(&at);
        let (z, fields) = (&at.state.amplitudes, &at.fields);
        let mut bordered = Bordered::new(self, z, fields, direction, block);
        let mut b = vec![0.0; direction.len()];
        b[0] = 1.0;
        let mut tangent = bordered.solve(&b, TANGENT)?;
        let length = norm(&tangent);
        scale(&mut tangent, 1.0 / length);
        let rates = &bordered.rates;
        let stress_rate = rates.stress * tangent[0] + dot(&rates.forces, &tangent);
        let knot = Knot {
            state: at.state,
            tangent,
            stress_rate,
            arc: 0.0,
            residual,
        };
        Ok((knot, at.fields))
    }
}
