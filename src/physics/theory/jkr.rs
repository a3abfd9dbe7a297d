//! A tip without range of adhesion on an endless half-space: Johnson, Kendall, Roberts (1971), by
//! the radius a of the contact; and the same tip in a periodic cell.
//!
//! With E* = 1, forces positive in tension, and u0 the height of the far surface above the tip's
//! apex (so that -u0 is the depth d):
//!
//! ```text
//! F = sqrt(8 pi gamma a^3) - 4 a^3/(3 R),   u0 = sqrt(2 pi gamma a) - a^2/R,   F = dU/du0 along the branch.
//! ```
//!
//! Approaching, nothing happens before the surfaces touch at u0 = 0; there the contact jumps open.
//! Retracting, the branch turns back at `F = 5/9` of the pull-off force. Driven by force instead it
//! ends at the pull-off force.

use super::boundary;
use std::f64::consts::PI;

/// A tip and its adhesion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jkr {
    /// Radius of curvature R (length).
    pub radius: f64,
    /// Work of adhesion gamma (E* times length).
    pub surface_energy: f64,
}

/// A state of the contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Radius a of the contact (length).
    pub radius: f64,
    /// Height u0 of the far surface above the apex (length), minus the depth; in a cell the mean
    /// displacement.
    pub mean_displacement: f64,
    /// Force F, in a cell that on each (E* times area), positive in tension.
    pub force: f64,
}

impl Jkr {
    /// The state with a contact of radius `a`.
    pub fn contact(&self, a: f64) -> Contact {
        Contact {
            radius: a,
            mean_displacement: -self.depth(a),
            force: (8.0 * PI * self.surface_energy * a.powi(3)).sqrt()
                - 4.0 / 3.0 * a.powi(3) / self.radius,
        }
    }

    fn depth(&self, a: f64) -> f64 {
        a * a / self.radius - self.opening(a)
    }

    /// Elastic energy minus gamma times the area of a contact of radius `a` (E* times volume); zero
    /// out of contact.
    pub fn energy(&self, a: f64) -> f64 {
        let (radius, depth) = (self.radius, self.depth(a));
        // The work of pressing in with the contact held at a, as by a punch of the tip's shape.
        let elastic = a * depth * depth - 2.0 / 3.0 * a.powi(3) * depth / radius
            + 0.2 * a.powi(5) / (radius * radius);
        elastic - self.surface_energy * PI * a * a
    }

    /// The state at a^3 = `factor` pi gamma R^2.
    fn of_cube(&self, factor: f64) -> Contact {
        self.contact((factor * PI * self.surface_energy).cbrt() * self.radius.powf(2.0 / 3.0))
    }

    /// sqrt(2 pi gamma a): how far adhesion pulls the contact out of its Hertzian depth (length).
    /// By it the edge is in equilibrium.
    pub fn opening(&self, a: f64) -> f64 {
        (2.0 * PI * self.surface_energy * a).sqrt()
    }

    /// The pull-off force (3/2) pi gamma R, the largest there is.
    pub fn pull_off_force(&self) -> f64 {
        1.5 * PI * self.surface_energy * self.radius
    }

    /// The last stable state under a given force: dF/da = 0, a^3 = (9/8) pi gamma R^2.
    pub fn end_under_force(&self) -> Contact {
        self.of_cube(1.125)
    }

    /// The last stable state at a given displacement: du0/da = 0, a^3 = (1/8) pi gamma R^2.
    pub fn end_of_displacement(&self) -> Contact {
        self.of_cube(0.125)
    }

    /// The contact just after the surfaces have touched at u0 = 0: a^3 = 2 pi gamma R^2.
    pub fn touch(&self) -> Contact {
        self.of_cube(2.0)
    }

    /// The contact without force: a^3 = (9/2) pi gamma R^2.
    pub fn zero_load(&self) -> Contact {
        self.of_cube(4.5)
    }

    /// V_hys = 7.092196 (gamma^5 R^4/E*^2)^(1/3): the energy that a closed loop driven by
    /// displacement loses (E* times volume), where the surfaces touch and where the contact breaks.
    pub fn dissipation(&self) -> f64 {
        -self.energy(self.touch().radius) + self.energy(self.end_of_displacement().radius)
    }
}

/// Highest k: the series goes by (2a/L)^2, and what comes after adds less than 1e-8 to V_hys for
/// contacts up to a = 0.15 L.
const ORDER: usize = 6;

/// A tip in a periodic square cell: what its images do.
///
/// Without q = 0 the surface of the periodic half-space moves under a unit of pressure at r' by
///
/// ```text
/// G(r - r') = (1/pi E*) [1/s + c_0/L + c_1 s^2/L^3 + c_2 s^4/L^5 + ...],   s = |r - r'|,
/// c_k = (1 3 .. (2k-1))^2/(4^k k!^2) sum' |R|^-(2k+1)   over the lattice without its origin (c_0 by continuation),
/// ```
///
/// up to terms of the lattice's fourfold symmetry, which do not act on a circular contact to first
/// order. The images thus add even powers of r to the shape of the tip, in proportion to the
/// moments of the pressure, and a tip of such a shape is solved in closed form (I. N. Sneddon, Int.
/// J. Eng. Sci. 3, 47 (1965)): with theta(t) the load density of concentric punches of radius t,
///
/// ```text
/// theta(t) = depth - sum_k m_k b_k t^2k for a tip sum_k b_k r^2k,  M_k = 2 m_k int_0^a theta t^2k dt,  m_k = 4^k k!^2/(2k)!,
/// ```
///
/// and adhesion demands theta(a) = -sqrt(2 pi gamma a) at the edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeriodicJkr {
    /// The tip alone.
    pub tip: Jkr,
    /// Side L of the cell (length).
    pub length: f64,
    /// Powers s^2k of the images' field that are kept. 0: images lift or lower the surface as a
    /// whole; 1: they bend it, and their own extent counts; ...
    pub order: usize,
}

impl PeriodicJkr {
    /// With everything that counts.
    pub fn new(tip: Jkr, length: f64) -> Self {
        Self {
            tip,
            length,
            order: ORDER,
        }
    }

    /// The state with a contact of radius `a`, well below L/2.
    pub fn contact(&self, a: f64) -> Contact {
        let coefficients = coefficients();
        let mut moments = [0.0; ORDER + 1];
        let depth = |shape: &[f64; ORDER + 1]| {
            let dents = (1..=ORDER).map(|k| punch(k) * shape[k] * a.powi(2 * k as i32));
            dents.sum::<f64>() - self.tip.opening(a)
        };
        // Each image changes the shape by a share of (a/L)^3 of the force: this converges at once.
        for _ in 0..40 {
            let shape = self.shape(&moments, &coefficients);
            let depth = depth(&shape);
            for (j, moment) in moments.iter_mut().enumerate() {
                let integral = |k: usize| a.powi(2 * (j + k) as i32 + 1) / (2 * (j + k) + 1) as f64;
                let dented: f64 = (1..=ORDER).map(|k| punch(k) * shape[k] * integral(k)).sum();
                *moment = 2.0 * punch(j) * (depth * integral(0) - dented);
            }
        }
        let shape = self.shape(&moments, &coefficients);
        let depth = depth(&shape);
        Contact {
            radius: a,
            mean_displacement: -depth - shape[0],
            force: -moments[0],
        }
    }

    /// The coefficients of r^2k in the tip's shape, images included.
    fn shape(
        &self,
        moments: &[f64; ORDER + 1],
        coefficients: &[f64; ORDER + 1],
    ) -> [f64; ORDER + 1] {
        let mut shape = [0.0; ORDER + 1];
        let order = self.order.min(ORDER);
        for i in 0..=order {
            for j in 0..=order - i {
                // The mean of |r - r'|^2k over the angle between them is the sum of binomial(k,
                // i)^2 r^2i r'^2j with i + j = k.
                let image = coefficients[i + j] * binomial(i + j, i).powi(2)
                    / self.length.powi(2 * (i + j) as i32 + 1);
                shape[i] += image * moments[j] / PI;
            }
        }
        shape[1] += 0.5 / self.tip.radius;
        shape
    }

    /// The last stable state at a given displacement, where u0 is largest.
    pub fn end_of_displacement(&self) -> Contact {
        let alone = self.tip.end_of_displacement().radius;
        let rising = |a: f64| {
            self.contact(a * (1.0 + 1e-5)).mean_displacement
                > self.contact(a * (1.0 - 1e-5)).mean_displacement
        };
        self.contact(boundary(0.5 * alone, 1.5 * alone, rising))
    }

    /// The state of the largest force.
    pub fn pull_off(&self) -> Contact {
        let alone = self.tip.end_under_force().radius;
        let rising =
            |a: f64| self.contact(a * (1.0 + 1e-5)).force > self.contact(a * (1.0 - 1e-5)).force;
        self.contact(boundary(0.5 * alone, 1.5 * alone, rising))
    }

    /// The contact just after the flat surface has touched at u0 = 0.
    pub fn touch(&self) -> Contact {
        let alone = self.tip.touch().radius;
        self.contact(boundary(
            self.end_of_displacement().radius,
            1.5 * alone,
            |a| self.contact(a).mean_displacement > 0.0,
        ))
    }

    /// The contact without force.
    pub fn zero_load(&self) -> Contact {
        let alone = self.tip.zero_load().radius;
        self.contact(boundary(0.8 * alone, 1.3 * alone, |a| {
            self.contact(a).force > 0.0
        }))
    }

    /// V_hys: the energy (E* times volume) that a closed loop driven by displacement loses, the
    /// integral of F du0 from the touch to the end of the branch.
    pub fn dissipation(&self) -> f64 {
        const PIECES: usize = 256;
        let (from, to) = (self.touch().radius, self.end_of_displacement().radius);
        let states: Vec<Contact> = (0..=2 * PIECES)
            .map(|i| self.contact(from + (to - from) * i as f64 / (2 * PIECES) as f64))
            .collect();
        // Simpson's rule for F du0/da, with the slope of the parabola through the same three
        // states.
        states
            .windows(3)
            .step_by(2)
            .map(|s| {
                let [u, f] = [
                    [0, 1, 2].map(|i| s[i].mean_displacement),
                    [0, 1, 2].map(|i| s[i].force),
                ];
                let slope = [
                    -1.5 * u[0] + 2.0 * u[1] - 0.5 * u[2],
                    0.5 * (u[2] - u[0]),
                    0.5 * u[0] - 2.0 * u[1] + 1.5 * u[2],
                ];
                (f[0] * slope[0] + 4.0 * f[1] * slope[1] + f[2] * slope[2]) / 3.0
            })
            .sum()
    }
}

/// m_k.
fn punch(k: usize) -> f64 {
    (1..=k)
        .map(|i| 2.0 * i as f64 / (2 * i - 1) as f64)
        .product()
}

fn binomial(n: usize, k: usize) -> f64 {
    (1..=k).map(|i| (n + 1 - i) as f64 / i as f64).product()
}

/// c_k. Over the square lattice the sum of |R|^-2s is 4 zeta(s) beta(s), both of them from
/// alternating series.
fn coefficients() -> [f64; ORDER + 1] {
    std::array::from_fn(|k| {
        let s = k as f64 + 0.5;
        let zeta = alternating(|n| (n as f64 + 1.0).powf(-s)) / (1.0 - 2.0_f64.powf(1.0 - s));
        let beta = alternating(|n| (2.0 * n as f64 + 1.0).powf(-s));
        let ratio: f64 = (1..=k)
            .map(|i| ((2 * i - 1) as f64 / (2 * i) as f64).powi(2))
            .product();
        4.0 * zeta * beta * ratio
    })
}

/// The sum of (-1)^n a(n), to rounding (H. Cohen, F. Rodriguez Villegas, D. Zagier, Exp. Math. 9, 3
/// (2000), algorithm 1).
fn alternating(a: impl Fn(usize) -> f64) -> f64 {
    const TERMS: usize = 24;
    let n = TERMS as f64;
    let root = (3.0 + 8.0_f64.sqrt()).powi(TERMS as i32);
    let d = 0.5 * (root + 1.0 / root);
    let (mut b, mut c, mut sum) = (-1.0, -d, 0.0);
    for i in 0..TERMS {
        let k = i as f64;
        c = b - c;
        sum += c * a(i);
        b *= (k + n) * (k - n) / ((k + 0.5) * (k + 1.0));
    }
    sum / d
}
