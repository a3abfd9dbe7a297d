//! Folds: where a branch turns back, found with u0 as an unknown beside the amplitudes.

use super::{Evaluation, Fields, Lost, NODE, Node, SHARP, STEPS, Sector, Side, State};
use crate::numerics::dense::{add, dot, hermite, norm, scale};

/// A step of a bordered solve that leaves more than this share of the force asks for fresh
/// derivatives.
const SLOW: f64 = 0.1;
/// Longest step along the branch towards a fold, root mean square, in ranges.
const STRIDE: f64 = 0.5;
/// Rounds of the search for a fold.
const ROUNDS: usize = 12;
/// How far beyond the last point of the search u0 of a fold may lie, in ranges: it is off by some
/// hundredths of that.
const PARABOLA: f64 = 1e-9;
/// The same where the search comes no closer, whose linear solves are inexact.
const STALLED: f64 = 2e-5;

/// Whether a fold that lies `off` (ranges) beyond the last point, after `before`, is found.
fn is_found(off: f64, before: f64) -> bool {
    off < PARABOLA || off < STALLED && off > 0.5 * before
}

impl Sector {
    /// One solve of the bordered problem: equilibrium with prescribed component `a` along the unit
    /// vector `phi`, u0 free, the force below `tolerance` ([`NODE`]). Passes through folds. Returns
    /// the node (its tangent is dz/da), its fields, and du0/da.
    fn arc(
        &mut self,
        phi: &[f64],
        [a, u0]: [f64; 2],
        mut z: Vec<f64>,
        tolerance: f64,
    ) -> Result<(Node, Fields, f64), Lost> {
        let strongest = self.scale();
        let removed = [phi.to_vec()];
        let shift = a - dot(phi, &z);
        add(&mut z, shift, phi);
        let mut image = vec![0.0; z.len()];
        let mut at = self.mechanics.at(z, u0);
        // Found at the first step, again where steps help little, and, when it counts, at the last.
        let mut along_u = Vec::new();
        let mut before = 0.0;
        for step in 0..=STEPS {
            let force = norm(&at.gradient) / strongest;
            if !force.is_finite() || step == STEPS {
                break;
            }
            let converged = force <= tolerance;
            let slow = force > SLOW * before;
            before = force;
            let rates = if slow || converged {
                self.refresh(&at.fields)
            } else {
                self.mechanics.rates(&at.fields)
            };
            if slow || converged {
                along_u = self.solve(&at.fields, &rates.forces, &removed, 1e-2)?;
            }
            self.mechanics.hessian(&at.fields, phi, &mut image);
            let border = dot(phi, &rates.forces) - dot(&image, &along_u);
            if converged {
                // What is left of the force asks for one more step, which need not be evaluated:
                // close to a fold the null vector is another than phi, and all of the force moves
                // u0.
                let along_g = self.solve(&at.fields, &at.gradient, &removed, 1e-2)?;
                let du = -(dot(phi, &at.gradient) - dot(&image, &along_g)) / border;
                let mut dz = along_g;
                dz.iter_mut().for_each(|z| *z = -*z);
                add(&mut dz, -du, &along_u);
                // The rate is zero at the fold: what is asked of it is small beside its parts.
                let along_a = self.solve(&at.fields, &image, &removed, 1e-3)?;
                let rate = -(dot(phi, &image) - dot(&image, &along_a)) / border;
                let mut tangent = phi.to_vec();
                add(&mut tangent, -1.0, &along_a);
                add(&mut tangent, -rate, &along_u);
                let slope = rates.stress * rate + dot(&rates.forces, &tangent);
                let Evaluation {
                    mut state, fields, ..
                } = at;
                state.energy += du * state.stress;
                state.stress += rates.stress * du + dot(&rates.forces, &dz);
                state.drive_by(du);
                add(&mut state.amplitudes, 1.0, &dz);
                let mut node = Node::bare(state, slope, tangent);
                self.soften(&mut node, None, &fields, &rates);
                return Ok((node, fields, rate));
            }
            let along_g = self.solve(
                &at.fields,
                &at.gradient,
                &removed,
                (0.3 * tolerance / force).clamp(1e-3, 0.1),
            )?;
            let du = -(dot(phi, &at.gradient) - dot(&image, &along_g)) / border;
            add(&mut at.state.amplitudes, -1.0, &along_g);
            add(&mut at.state.amplitudes, -du, &along_u);
            at.state.drive_by(du);
            self.mechanics.update(&mut at);
        }
        Err(Lost::Gone)
    }

    /// The fold ahead of `here` on a `side`; `before` is the node before it. The node returned has
    /// the null vector as tangent, pointing onwards, and an infinite slope; the fields are those of a
    /// state a hair from it.
    ///
    /// # Errors
    /// The branch was lost on the way.
    pub fn fold(&mut self, before: &Node, here: &Node, side: Side) -> Result<(Node, Fields), Lost> {
        let range = self.system().law().range;
        let sign = side.sign();
        let length = norm(&here.tangent);
        let phi: Vec<f64> = here.tangent.iter().map(|t| sign * t / length).collect();
        let (mut behind, mut last) = (Arc::of(before, &phi), Arc::of(here, &phi));
        let mut off_before = f64::INFINITY;
        // The first arc only leads near it.
        let mut tolerance = NODE;
        for _ in 0..ROUNDS {
            let a = Arc::extremum(&behind, &last, side).0;
            if !a.is_finite() {
                break;
            }
            let a = a.clamp(last.a - STRIDE * range, last.a + STRIDE * range);
            let (guess, u0) = Arc::between(&behind, &last, a);
            let (mut found, fields, rate) = self.arc(&phi, [a, u0], guess, tolerance)?;
            let arc = Arc::at(&found, a, rate);
            let top = Arc::extremum(&last, &arc, side);
            let off = (top.1 - arc.u0).abs() / range;
            if tolerance == SHARP && is_found(off, off_before) {
                found.shift_to(&arc, top, (arc.rate - last.rate) / (arc.a - last.a));
                return Ok((found, fields));
            }
            (behind, last, off_before) = (last, arc, off);
            tolerance = SHARP;
        }
        Err(Lost::Gone)
    }

    /// The fold next to `near`, a fold of a slightly different law or cell.
    ///
    /// # Errors
    /// It was not found.
    pub fn refold(&mut self, near: &Node, side: Side) -> Result<(Node, Fields), Lost> {
        let range = self.system().law().range;
        let length = norm(&near.tangent);
        let phi: Vec<f64> = near.tangent.iter().map(|t| t / length).collect();
        let mut a = dot(&phi, &near.state.amplitudes);
        let (mut u0, mut z, mut bend) = (near.u0(), near.state.amplitudes.clone(), near.bend);
        let mut last: Option<Arc> = None;
        let mut off_before = f64::INFINITY;
        let mut tolerance = NODE;
        for _ in 0..ROUNDS {
            let (mut found, fields, rate) = self.arc(&phi, [a, u0], z, tolerance)?;
            let arc = Arc::at(&found, a, rate);
            if let Some(last) = &last {
                bend = (arc.rate - last.rate) / (arc.a - last.a);
            }
            if !(side.sign() * bend < 0.0) {
                break;
            }
            let shift = -rate / bend;
            let top = (a + shift, arc.u0 + 0.5 * shift * rate);
            let off = (top.1 - arc.u0).abs() / range;
            if tolerance == SHARP && is_found(off, off_before) {
                found.shift_to(&arc, top, bend);
                return Ok((found, fields));
            }
            off_before = off;
            let shift = shift.clamp(-STRIDE * range, STRIDE * range);
            z = arc.z.clone();
            add(&mut z, shift, &arc.dz);
            (a, u0) = (a + shift, arc.u0 + shift * (rate + 0.5 * bend * shift));
            last = Some(arc);
            tolerance = SHARP;
        }
        Err(Lost::Gone)
    }
}

impl Node {
    /// Moves the node found at `arc` to the fold `top` (a, u0) close by; `bend` is d2u0/da2 there.
    fn shift_to(&mut self, arc: &Arc, top: (f64, f64), bend: f64) {
        let shift = top.0 - arc.a;
        add(&mut self.state.amplitudes, shift, &arc.dz);
        let du = top.1 - self.u0();
        self.state.energy += self.state.stress * du;
        self.state.stress += shift * self.slope;
        self.state.drive_by(du);
        // Per unit of the null vector instead of phi.
        let length = norm(&self.tangent);
        self.bend = bend / (length * length);
        scale(&mut self.tangent, 1.0 / length);
        self.slope = f64::INFINITY;
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
    /// A node whose tangent is dz/da.
    fn at(node: &Node, a: f64, rate: f64) -> Self {
        let State {
            mean_displacement: u0,
            amplitudes: z,
            ..
        } = node.state.clone();
        Self {
            a,
            u0,
            rate,
            z,
            dz: node.tangent.clone(),
        }
    }

    fn of(node: &Node, phi: &[f64]) -> Self {
        let rate = 1.0 / dot(phi, &node.tangent);
        let mut dz = node.tangent.clone();
        scale(&mut dz, rate);
        Self {
            dz,
            ..Self::at(node, dot(phi, &node.state.amplitudes), rate)
        }
    }

    /// Where the rate of the cubic through two points vanishes, and u0 there: the maximum towards the
    /// upper side.
    fn extremum(a: &Self, b: &Self, side: Side) -> (f64, f64) {
        let h = b.a - a.a;
        let slope = (b.u0 - a.u0) / h;
        // u0 = a.u0 + a.rate s + c s^2 + d s^3 with s measured from a.
        let c = (3.0 * slope - 2.0 * a.rate - b.rate) / h;
        let d = (a.rate + b.rate - 2.0 * slope) / (h * h);
        let root = (c * c - 3.0 * d * a.rate).max(0.0).sqrt();
        // Of the two zeros of the rate the one where the second derivative, 2c + 6ds, has the right
        // sign.
        let s = -a.rate / (c - side.sign() * root);
        (a.a + s, a.u0 + s * (a.rate + s * (c + s * d)))
    }

    /// Cubic Hermite of amplitudes and u0 through two points, at any `at`.
    fn between(a: &Self, b: &Self, at: f64) -> (Vec<f64>, f64) {
        let h = b.a - a.a;
        let t = (at - a.a) / h;
        let z = hermite([&a.z, &a.dz, &b.z, &b.dz], h, t);
        let u0 = hermite([&[a.u0], &[a.rate], &[b.u0], &[b.rate]], h, t);
        (z, u0[0])
    }
}
