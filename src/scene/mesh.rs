//! The mesh that an accuracy asks for on flat ground, and the accuracy that a mesh gives.

use crate::physics::body::Body;
use crate::physics::law::Law;
use crate::physics::mesh_rule;
use crate::physics::theory::flat;

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
    let periods = length / flat::critical_length(law);
    ANY_MESH + 0.42 * periods.max(1.0).powf(3.5) * (-2.6 / (mu_rho * mu_rho)).exp()
}

/// What is expected of a body and law on flat ground and this mesh; 1 where which jumps happen
/// depends on the mesh itself, or for a layer, of which nothing is known: nothing is promised.
pub fn flat_error(body: &Body, law: &Law, length: f64, mu_rho: f64) -> f64 {
    if *body == Body::HalfSpace && law.is_smooth() && mesh_rule::is_safe(mu_rho) {
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
        let mu_rho = mesh_rule::mu_rho(law, length / n as f64);
        if n >= 1 << 13
            || mesh_rule::is_safe(mu_rho)
                && mesh_error(law, length, mu_rho) <= accuracy.max(1.5 * ANY_MESH)
        {
            return n;
        }
        n = next_fast(n + 8);
    }
}

/// The fewest points along a side, a multiple of 8 with small factors, on which `law` has this
/// `mu_rho` at most.
pub fn points_at(law: &Law, length: f64, mu_rho: f64) -> usize {
    next_fast(mesh_rule::points_for_mu_rho(law, length, mu_rho).ceil() as usize)
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
