//! A branch as a curve: stress and energy between nodes, and how well they fit together.

use crate::numerics::dense::{add, hermite};
use crate::physics::control::Control;
use crate::physics::pattern::Pattern;
use crate::physics::theory::boundary;
use crate::solver::sector::{Node, Side};

/// How a branch of stable states ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum End {
    /// It turns back in what is driven.
    Fold,
    /// It goes on, unstable, where a mode of another symmetry has gone soft.
    Breaking,
}

/// A branch of stable states between its two ends.
#[derive(Clone, Debug)]
pub struct Branch {
    /// Its pattern.
    pub pattern: Pattern,
    /// True for states of the line problem.
    pub is_ridge: bool,
    /// By growing u0; the first and the last are the ends.
    pub nodes: Vec<Node>,
    /// How it ends below and above.
    pub ends: [End; 2],
}

/// What a branch says at one u0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Mean stress (E*).
    pub stress: f64,
    /// Energy per area (E* times length).
    pub energy: f64,
    /// d stress/du0 along the branch (E* per length).
    pub slope: f64,
}

impl Branch {
    /// u0 of the lower and the upper end (length).
    pub fn extent(&self) -> (f64, f64) {
        (
            self.nodes[0].state.mean_displacement,
            self.nodes[self.nodes.len() - 1].state.mean_displacement,
        )
    }

    /// Adds a node between the ends.
    pub(super) fn insert(&mut self, node: Node) {
        let i = self
            .nodes
            .partition_point(|n| n.state.mean_displacement < node.state.mean_displacement)
            .clamp(1, self.nodes.len() - 1);
        self.nodes.insert(i, node);
    }

    /// The upper or the lower end.
    pub fn end(&self, side: Side) -> &Node {
        if side == Side::Upper {
            &self.nodes[self.nodes.len() - 1]
        } else {
            &self.nodes[0]
        }
    }

    fn segment(&self, u0: f64) -> (&Node, &Node) {
        let last = self.nodes.len() - 1;
        let i = self
            .nodes
            .partition_point(|n| n.state.mean_displacement <= u0)
            .clamp(1, last);
        (&self.nodes[i - 1], &self.nodes[i])
    }

    /// Stress and energy at `u0`: quintic Hermite in the energy, whose derivatives are stress and
    /// slope; next to a fold a quartic in the square root of the distance. Meaningful between
    /// its ends.
    pub fn at(&self, u0: f64) -> Point {
        let (a, b) = self.segment(u0);
        Support::of(a).to(Support::of(b), u0)
    }

    /// The smallest eigenvalue under `control` at `u0` (E* per length), linear between nodes.
    pub fn softness(&self, control: Control, u0: f64) -> f64 {
        let (a, b) = self.segment(u0);
        let width = b.state.mean_displacement - a.state.mean_displacement;
        let t = ((u0 - a.state.mean_displacement) / width).clamp(0.0, 1.0);
        a.softness(control) + t * (b.softness(control) - a.softness(control))
    }

    /// u0 where the `control` has this `value`, which grows with u0 along what is stable; the nearer
    /// end where it has it nowhere.
    pub(super) fn place(&self, control: Control, value: f64) -> f64 {
        if control == Control::Displacement {
            return value;
        }
        let (low, high) = self.extent();
        let below = |u0: f64| control.balanced(u0, self.at(u0).stress)[0] < value;
        match (below(low), below(high)) {
            (false, _) => low,
            (_, true) => high,
            _ => boundary(low, high, below),
        }
    }

    /// Amplitudes at `u0`, a guess that one Newton step makes a state.
    pub fn guess(&self, u0: f64) -> Vec<f64> {
        let (a, b) = self.segment(u0);
        guess(a, b, u0)
    }
}

/// Amplitudes at `u0` between two nodes: cubic Hermite, next to a fold in the root of the distance.
pub(super) fn guess(a: &Node, b: &Node, u0: f64) -> Vec<f64> {
    let (fold, regular) = match (a.slope.is_finite(), b.slope.is_finite()) {
        (true, true) => return between(a, b, u0),
        (true, false) => (b, a),
        _ => (a, b),
    };
    // z = z_f + c1 s + c2 s^2 with s = sqrt((u0 - u_f)/(u_r - u_f)).
    let width = regular.state.mean_displacement - fold.state.mean_displacement;
    let s = ((u0 - fold.state.mean_displacement) / width)
        .max(0.0)
        .sqrt();
    let mut z = fold.state.amplitudes.clone();
    let mut change = regular.state.amplitudes.clone();
    add(&mut change, -1.0, &fold.state.amplitudes);
    if !regular.slope.is_finite() {
        add(&mut z, s * s, &change);
        return z;
    }
    add(&mut z, 2.0 * s - s * s, &change);
    add(&mut z, 2.0 * width * (s * s - s), &regular.tangent);
    z
}

/// Cubic Hermite between two regular nodes, at any u0.
pub fn between(a: &Node, b: &Node, u0: f64) -> Vec<f64> {
    let h = b.state.mean_displacement - a.state.mean_displacement;
    let t = (u0 - a.state.mean_displacement) / h;
    let (y, z) = (&a.state.amplitudes, &b.state.amplitudes);
    hermite([y, &a.tangent, z, &b.tangent], h, t)
}

/// What is known of a branch at one u0.
#[derive(Clone, Copy, Debug)]
pub(in crate::follow) struct Support {
    /// Mean displacement (length).
    pub u0: f64,
    /// Energy per area (E* times length).
    pub energy: f64,
    /// Mean stress (E*).
    pub stress: f64,
    /// d stress/du0; infinite at a fold.
    pub slope: f64,
}

impl Support {
    pub(super) fn of(node: &Node) -> Self {
        Self {
            u0: node.state.mean_displacement,
            energy: node.state.energy,
            stress: node.state.stress,
            slope: node.slope,
        }
    }

    /// The branch between two supports, at `u0`: as [`Branch::at`].
    pub fn to(self, b: Self, u0: f64) -> Point {
        match (self.slope.is_finite(), b.slope.is_finite()) {
            (true, true) => quintic(self, b, u0),
            (true, false) => root(b, self, u0),
            (false, true) => root(self, b, u0),
            (false, false) => {
                let t = (u0 - self.u0) / (b.u0 - self.u0);
                Point {
                    stress: self.stress + t * (b.stress - self.stress),
                    energy: self.energy + t * (b.energy - self.energy),
                    slope: (b.stress - self.stress) / (b.u0 - self.u0),
                }
            }
        }
    }
}

/// The quintic with the energies, stresses and slopes of two supports.
fn quintic(a: Support, b: Support, u0: f64) -> Point {
    let h = b.u0 - a.u0;
    let t = (u0 - a.u0) / h;
    // V = V_a + p_a h t + s_a h^2 t^2/2 + c3 t^3 + c4 t^4 + c5 t^5.
    let (p0, s0) = (a.stress * h, a.slope * h * h);
    let (v, p, s) = (
        b.energy - a.energy - p0 - 0.5 * s0,
        b.stress * h - p0 - s0,
        b.slope * h * h - s0,
    );
    let (c3, c4, c5) = (
        10.0 * v - 4.0 * p + 0.5 * s,
        -15.0 * v + 7.0 * p - s,
        6.0 * v - 3.0 * p + 0.5 * s,
    );
    Point {
        energy: a.energy + t * (p0 + t * (0.5 * s0 + t * (c3 + t * (c4 + t * c5)))),
        stress: (p0 + t * (s0 + t * (3.0 * c3 + t * (4.0 * c4 + t * 5.0 * c5)))) / h,
        slope: (s0 + t * (6.0 * c3 + t * (12.0 * c4 + t * 20.0 * c5))) / (h * h),
    }
}

/// Between a `fold` and a regular node: stress = p_f + c1 s + c2 s^2 + c3 s^3 with s the root of
/// the relative distance, which has the stress, the slope and the energy of the regular node.
fn root(fold: Support, regular: Support, u0: f64) -> Point {
    let width = regular.u0 - fold.u0;
    let s = ((u0 - fold.u0) / width).clamp(0.0, 1.0).sqrt();
    let p = regular.stress - fold.stress;
    let slope = 2.0 * width * regular.slope;
    let work = (regular.energy - fold.energy) / width - fold.stress;
    // c1 + c2 + c3 = p, c1 + 2 c2 + 3 c3 = slope, 2/3 c1 + 1/2 c2 + 2/5 c3 = work.
    let c1 = 1.5 * slope + 15.0 * work - 10.5 * p;
    let c2 = -4.0 * slope - 30.0 * work + 24.0 * p;
    let c3 = 2.5 * slope + 15.0 * work - 12.5 * p;
    Point {
        stress: fold.stress + s * (c1 + s * (c2 + s * c3)),
        energy: fold.energy
            + width * s * s * (fold.stress + s * (2.0 / 3.0 * c1 + s * (0.5 * c2 + s * 0.4 * c3))),
        slope: (0.5 * c1 / s + c2 + 1.5 * c3 * s) / width,
    }
}
