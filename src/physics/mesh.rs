//! The periodic cell with its mesh; the mesh rule (Eqs 9 to 11 and 33), max(-gamma'') = mu_rho^2
//! E*/da, for every law; the mesh that an accuracy asks for on flat ground, and the accuracy that a
//! mesh gives.
//!
//! A mesh of spacing da resists a wave of wave number q with q E*/2. The larger mu_rho, the shorter
//! the waves that a softening law makes unstable: at sqrt(pi/2) on a line, and 2^(1/4) as much on a
//! square, the shortest one the mesh has, and jumps then belong to the mesh, not to the physics.

use super::law::Law;
use super::theory::critical_length;
use std::f64::consts::{PI, TAU};

/// Largest number of points along one side.
pub const POINTS_MAX: usize = 4096;

/// A square cell of `length` x `length` with `nx` = `ny` points, or a line cell with `ny` = 1
/// (fields uniform along y).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Side L of the cell (length unit of the scene).
    pub length: f64,
    /// Points along x.
    pub nx: usize,
    /// Points along y: `nx`, or 1 for a line cell.
    pub ny: usize,
}

impl Grid {
    /// A square cell with n x n points.
    pub fn square(length: f64, n: usize) -> Self {
        Self {
            length,
            nx: n,
            ny: n,
        }
    }

    /// A line cell with n points along x and none along y.
    pub fn line(length: f64, n: usize) -> Self {
        Self {
            length,
            nx: n,
            ny: 1,
        }
    }

    /// Spacing da = L/n of the mesh.
    pub fn spacing(&self) -> f64 {
        self.length / self.nx as f64
    }

    /// Number of points.
    pub fn points(&self) -> usize {
        self.nx * self.ny
    }

    /// Shape of a field, (rows, columns) = (ny, nx).
    pub fn shape(&self) -> (usize, usize) {
        (self.ny, self.nx)
    }

    /// True for a line cell.
    pub fn is_line(&self) -> bool {
        self.ny == 1
    }

    /// The smallest non-zero wave number q1 = 2 pi / L.
    pub fn q1(&self) -> f64 {
        TAU / self.length
    }
}

/// A cohesive-zone model of the literature (Table 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZoneModel {
    /// Its first author.
    pub author: &'static str,
    /// Its year as printed.
    pub year: u16,
    /// mu_rho that it uses implicitly, as printed.
    pub mu_rho: f64,
    /// M of the length l_cz = M E* gamma/sigma_max^2 of its cohesive zone, from which
    /// [`mu_rho_of_zone`] gives the same.
    pub zone: f64,
    /// M as a formula.
    pub formula: &'static str,
}

/// Table 1 in the paper's order.
pub const TABLE_1: [ZoneModel; 6] = [
    ZoneModel {
        author: "Dugdale",
        year: 1960,
        mu_rho: 0.798,
        zone: PI / 8.0,
        formula: "π/8",
    },
    ZoneModel {
        author: "Hillerborg",
        year: 1976,
        mu_rho: 0.5,
        zone: 1.0,
        formula: "1",
    },
    ZoneModel {
        author: "Irwin",
        year: 1997,
        mu_rho: 0.886,
        zone: 1.0 / PI,
        formula: "1/π",
    },
    ZoneModel {
        author: "Falk",
        year: 2001,
        mu_rho: 0.532,
        zone: 9.0 * PI / 32.0,
        formula: "9π/32",
    },
    ZoneModel {
        author: "Hui",
        year: 2003,
        mu_rho: 1.09,
        zone: 2.0 / (3.0 * PI),
        formula: "2/(3π)",
    },
    ZoneModel {
        author: "Popov",
        year: 2015,
        mu_rho: 0.729,
        zone: 0.47,
        formula: "0.47",
    },
];

/// The value the paper calls safe: the shortest unstable wave is 4 pi da.
pub const SAFE: f64 = 0.5;

/// True if a mesh of this mu_rho is safe for a smooth law; a range that was made for the safe value
/// may be rounded.
pub fn is_safe(mu_rho: f64) -> bool {
    mu_rho <= 1.001 * SAFE
}

/// mu_rho of `law` on a mesh of `spacing` da (Eq. 10 with E* = 1).
pub fn mu_rho(law: &Law, spacing: f64) -> f64 {
    (law.softening_max() * spacing).sqrt()
}

/// The range (length) at which a law like this one (its own range is ignored) has `mu_rho` on a
/// mesh of `spacing` da (Eq. 11).
pub fn range_for_mu_rho(law: &Law, spacing: f64, mu_rho: f64) -> f64 {
    let unit = Law { range: 1.0, ..*law };
    (unit.softening_max() * spacing).sqrt() / mu_rho
}

/// The number of points n = L/da (not rounded) at which `law` has `mu_rho` in a cell of side
/// `length`.
pub fn points_for_mu_rho(law: &Law, length: f64, mu_rho: f64) -> f64 {
    law.softening_max() * length / (mu_rho * mu_rho)
}

/// mu_rho = 1/(2 sqrt(M)) of a model whose cohesive zone is l_cz = M E* gamma/sigma_max^2 long.
///
/// With Eq. 11 that is rho = sqrt(M gamma da/E*). All six entries of [`TABLE_1`] follow so from the
/// published values of M.
pub fn mu_rho_of_zone(zone: f64) -> f64 {
    0.5 / zone.sqrt()
}

/// Expected relative error of jumps and dissipated energy from the mesh, for smooth laws on flat
/// ground.
///
/// Fields are smooth, so that the error is exponential in the number of points: it falls by e^2.6
/// for each unit of 1/mu_rho^2, which is proportional to n. A longer cell (in units of L_c) has
/// sharper edges and smaller u0 at the lowest jumps. The constants are an envelope of measurements
/// over random scenes, which a test repeats.
///
/// A layer is stiffer than a half-space to every wave: the shortest that softens is no shorter.
pub fn mesh_error(law: &Law, length: f64, mu_rho: f64) -> f64 {
    let periods = length / critical_length(law);
    ANY_MESH + 0.42 * periods.max(1.0).powf(3.5) * (-2.6 / (mu_rho * mu_rho)).exp()
}

/// What is expected of a law under a half-space on flat ground and this mesh; 1 where which jumps
/// happen depends on the mesh itself: nothing is promised.
pub fn flat_error(law: &Law, length: f64, mu_rho: f64) -> f64 {
    if law.is_smooth() && is_safe(mu_rho) {
        mesh_error(law, length, mu_rho)
    } else {
        1.0
    }
}

/// Relative accuracy to which jumps and energies are located on any mesh, by either strategy.
const ANY_MESH: f64 = 5e-5;

/// The fewest points along a side, a multiple of 8 with small factors, that keep [`mesh_error`]
/// below `accuracy`.
pub fn points_for(law: &Law, length: f64, accuracy: f64) -> usize {
    let mut n = 16;
    loop {
        let mu_rho = mu_rho(law, length / n as f64);
        if n >= 1 << 13
            || is_safe(mu_rho) && mesh_error(law, length, mu_rho) <= accuracy.max(1.5 * ANY_MESH)
        {
            return n;
        }
        n = next_fast(n + 8);
    }
}

/// The fewest points along a side, a multiple of 8 with small factors, on which `law` has this
/// `mu_rho` at most.
pub fn points_at(law: &Law, length: f64, mu_rho: f64) -> usize {
    next_fast(points_for_mu_rho(law, length, mu_rho).ceil() as usize)
}

/// Largest count that [`next_fast`] looks beyond; larger ones are taken for it.
const COUNT_MAX: usize = 1 << 60;

/// The next multiple of 8 at or above `n` with no prime factors but 2, 3 and 5: quick to transform,
/// also on a quarter cell.
pub fn next_fast(n: usize) -> usize {
    let least = n.clamp(1, COUNT_MAX).div_ceil(8);
    let mut best = least.next_power_of_two();
    let mut fives = 1;
    while fives < best {
        let mut odd = fives;
        while odd < best {
            best = best.min(odd * least.div_ceil(odd).next_power_of_two());
            odd *= 3;
        }
        fives *= 5;
    }
    8 * best
}
