//! A tip without range of adhesion on an endless half-space: Johnson, Kendall, Roberts (1971), by
//! the radius a of the contact.
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
    /// Height u0 of the far surface above the apex (length); minus the depth.
    pub displacement: f64,
    /// Force F (E* times area), positive in tension.
    pub force: f64,
    /// Elastic energy minus gamma times the area of contact (E* times volume); zero out of contact.
    pub energy: f64,
}

impl Jkr {
    /// The state with a contact of radius `a`.
    pub fn contact(&self, a: f64) -> Contact {
        let Self {
            radius,
            surface_energy,
        } = *self;
        let depth = a * a / radius - self.opening(a);
        // The work of pressing in with the contact held at a, as by a punch of the tip's shape.
        let elastic = a * depth * depth - 2.0 / 3.0 * a.powi(3) * depth / radius
            + 0.2 * a.powi(5) / (radius * radius);
        Contact {
            radius: a,
            displacement: -depth,
            force: (8.0 * PI * surface_energy * a.powi(3)).sqrt() - 4.0 / 3.0 * a.powi(3) / radius,
            energy: elastic - surface_energy * PI * a * a,
        }
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

    /// Energy released when the surfaces touch (E* times volume).
    pub fn jump_in(&self) -> f64 {
        -self.touch().energy
    }

    /// Energy released when the contact breaks at a given displacement (E* times volume).
    pub fn snap_off(&self) -> f64 {
        self.end_of_displacement().energy
    }

    /// V_hys = 7.092196 (gamma^5 R^4/E*^2)^(1/3): the energy that a closed loop driven by
    /// displacement loses.
    pub fn dissipation(&self) -> f64 {
        self.jump_in() + self.snap_off()
    }
}
