//! Where a surface comes to rest when its branch ends: a release on a quarter cell, to learn which
//! pattern it is.
//!
//! That is not always one place: at the limit of the flat state the first waves along x and along y
//! go soft together, may come in any mixture, and what the flat state jumps to can depend on it. All
//! mixtures are tried; the one that most of them lead to is what the loop follows, whatever its
//! seed, and the others are said.

use crate::follow::record::Share;
use crate::numerics::dense::{add, norm, scale};
use crate::physics::control::Control;
use crate::physics::pattern::{Pattern, classify};
use crate::physics::system::{Evaluation, State, System};
use crate::solver::mechanics::{Mechanics, Slides};
use crate::solver::release::{Release, Slice};
use std::f64::consts::FRAC_PI_4;

/// How many mixtures are tried: the angle from one wave alone to both alike, in equal parts.
/// Whatever less than a part leads to is not seen.
const MIXTURES: usize = 7;

/// Root mean square kick at a limit of the flat state, in ranges. While amplitudes are small nearly
/// all mixtures turn into the same: of two laws that were contested with a tenth of a range none is
/// with this.
pub const FLAT_KICK: f64 = 0.03;
/// The same at the end of any other branch, along the mode that gives way: far enough from the
/// saddle next to it.
pub const KICK: f64 = 0.1;

/// Residual at which a fall ends: next to a saddle forces are small too.
const TOLERANCE: f64 = 1e-6;
/// Share of the amplitude below which a symmetry counts as kept.
const TRACE: f64 = 2e-2;
/// Time steps of a fall after which is asked whether the body has come apart.
const SLICE: usize = 500;

/// Where a surface came to rest.
#[derive(Clone, Debug)]
pub struct Rest {
    /// u0 (length).
    pub mean_displacement: f64,
    /// What it is: flat, a ridge, a bulge, a dimple, or other for anything else.
    pub pattern: Pattern,
    /// Of a ridge, a bulge or a dimple in its normal position the amplitudes of the quarter cell: waves
    /// along x only, or x <-> y symmetric.
    pub amplitudes: Vec<f64>,
}

impl Rest {
    fn without_amplitudes(mean_displacement: f64, pattern: Pattern) -> Self {
        Self {
            mean_displacement,
            pattern,
            amplitudes: Vec::new(),
        }
    }
}

/// Where some mixtures of the soft modes lead from a limit of the flat state.
#[derive(Clone, Debug)]
pub struct Fall {
    /// To what, and how many of all mixtures.
    pub share: Share,
    /// The mixture in the middle of them: next to those that lead elsewhere little decides.
    pub mixture: usize,
    /// Where that one comes to rest.
    pub rest: Rest,
}

/// A quarter cell for releases.
#[derive(Clone, Debug)]
pub struct Explorer {
    /// A request to cancel it interrupts a fall.
    pub mechanics: Mechanics,
}

impl Explorer {
    /// Of an even square `system` on flat ground.
    pub fn new(system: System) -> Self {
        Self {
            mechanics: Mechanics::new(system, Slides::Never),
        }
    }

    /// Its mechanics.
    pub fn system(&self) -> &System {
        &self.mechanics.system
    }

    /// Where the flat state of gap `u0` comes to rest from the mixtures of its soft modes, the first
    /// waves along x and y; most often first. Where the purest, the evenest and one in between lead
    /// to the same, so do those between them.
    pub fn off_flat(&mut self, u0: f64) -> Vec<Fall> {
        let flat = self.system().uniform(u0).state;
        let ny = self.system().shape().0;
        let mut from = |mixture: usize| {
            let mut mode = vec![0.0; flat.amplitudes.len()];
            (mode[1], mode[ny]) = angle(mixture).sin_cos();
            self.kicked(&flat.amplitudes, &mode, FLAT_KICK, flat.control)
        };
        let looked_at = [0, MIXTURES / 2, MIXTURES - 1];
        let seen = looked_at.map(&mut from);
        let agree = seen.iter().all(|rest| rest.pattern == seen[1].pattern);
        let rest = |mixture| match looked_at.iter().position(|known| *known == mixture) {
            Some(i) => seen[i].clone(),
            None if agree => seen[1].clone(),
            None => from(mixture),
        };
        let rests: Vec<Rest> = (0..MIXTURES).map(rest).collect();
        let shares = shares(&rests.iter().map(|rest| rest.pattern).collect::<Vec<_>>());
        let fall = |share: Share| {
            let those = (0..MIXTURES).filter(|i| rests[*i].pattern == share.pattern);
            let those: Vec<usize> = those.collect();
            let mixture = those[those.len() / 2];
            let rest = rests[mixture].clone();
            Fall {
                share,
                mixture,
                rest,
            }
        };
        shares.into_iter().map(fall).collect()
    }

    /// Kicks the state `z` along the `mode`, to the side on which the energy is lower, and lets it
    /// fall at a fixed `control`.
    pub fn release(&mut self, z: &[f64], mode: &[f64], control: f64) -> Rest {
        self.kicked(z, mode, KICK, control)
    }

    fn kicked(&mut self, z: &[f64], mode: &[f64], kick: f64, control: f64) -> Rest {
        let size = kick * self.system().law().range / norm(mode);
        let mut side = |sign: f64| {
            let mut moved = z.to_vec();
            add(&mut moved, sign * size, mode);
            self.mechanics.at(moved, control)
        };
        let (one, other) = (side(1.0), side(-1.0));
        let start = if other.state.energy < one.state.energy {
            other
        } else {
            one
        };
        self.mechanics.preconditioner.forget();
        self.fall(start)
    }

    /// Down to the next minimum at fixed control by the walk's own release.
    fn fall(&mut self, start: Evaluation) -> Rest {
        let mut release = Release::new(start).with_tolerance(TOLERANCE);
        loop {
            let slice = release.advance(&mut self.mechanics, SLICE);
            let (system, u0) = (self.system(), release.at.state.mean_displacement);
            let (law, length) = (system.law(), system.equivalent_length());
            match slice {
                Slice::Moving if system.control().is_apart(law, length, u0) => {
                    let stop = Control::stop(law, length);
                    return Rest::without_amplitudes(stop, Pattern::Flat);
                }
                Slice::Moving => {}
                Slice::Settled(found) => {
                    let State {
                        amplitudes,
                        mean_displacement,
                        ..
                    } = found.at.state;
                    return self.recognised(amplitudes, mean_displacement);
                }
                Slice::Stuck | Slice::Cancelled => {
                    return Rest::without_amplitudes(u0, Pattern::Other);
                }
            }
        }
    }

    /// Which symmetry a state has, in its normal position: centre in the corner, ridges along y.
    fn recognised(&mut self, mut z: Vec<f64>, u0: f64) -> Rest {
        z[0] = 0.0;
        let size = norm(&z);
        if size < 0.02 * self.system().law().range {
            return Rest::without_amplitudes(u0, Pattern::Flat);
        }
        let n = self.system().shape().0;
        let along_x: f64 = (1..n).map(|k| z[k * n].powi(2)).sum();
        let along_y: f64 = (1..n).map(|l| z[l].powi(2)).sum();
        if along_y > along_x {
            transpose(&mut z, n);
        }
        // Moved by half a cell, every wave with an odd number of periods changes its sign.
        let (flip_x, flip_y) = (z[n] < 0.0, z[1] < 0.0);
        for (i, z) in z.iter_mut().enumerate() {
            if flip_x && (i / n) % 2 == 1 {
                *z = -*z;
            }
            if flip_y && (i % n) % 2 == 1 {
                *z = -*z;
            }
        }
        let mut line = vec![0.0; z.len()];
        (0..n).for_each(|k| line[k * n] = z[k * n]);
        if (size * size - norm(&line).powi(2)).max(0.0).sqrt() < TRACE * size {
            return Rest {
                mean_displacement: u0,
                pattern: Pattern::Ridge,
                amplitudes: line,
            };
        }
        let mut other = z.clone();
        transpose(&mut other, n);
        let mut odd = z.clone();
        add(&mut odd, -1.0, &other);
        if norm(&odd) > 2.0 * TRACE * size {
            return Rest::without_amplitudes(u0, Pattern::Other);
        }
        add(&mut z, 1.0, &other);
        scale(&mut z, 0.5);
        match pattern_of(&mut self.mechanics, &z, u0) {
            pattern @ (Pattern::Bulge | Pattern::Dimple) => Rest {
                mean_displacement: u0,
                pattern,
                amplitudes: z,
            },
            _ => Rest::without_amplitudes(u0, Pattern::Other),
        }
    }
}

/// The pattern of amplitudes of a quarter cell on flat ground.
pub fn pattern_of(mechanics: &mut Mechanics, z: &[f64], u0: f64) -> Pattern {
    let gap = mechanics.gap(z, u0);
    let system = &mechanics.system;
    classify(system.unfolded(&gap).view(), system.law(), true)
}

fn transpose(z: &mut [f64], n: usize) {
    for k in 0..n {
        for l in 0..k {
            z.swap(k * n + l, l * n + k);
        }
    }
}

/// The angle of a mixture: amplitudes cos and sin of it. x and y may be exchanged, so that an
/// eighth of a turn is all.
pub fn angle(mixture: usize) -> f64 {
    FRAC_PI_4 * (mixture as f64 + 0.5) / MIXTURES as f64
}

/// The shares of what each mixture leads to, the largest first; of equal ones that of the purer
/// wave.
fn shares(landings: &[Pattern]) -> Vec<Share> {
    let mut shares: Vec<Share> = Vec::new();
    for &pattern in landings {
        let one = 1.0 / landings.len() as f64;
        match shares.iter_mut().find(|share| share.pattern == pattern) {
            Some(known) => known.share += one,
            None => shares.push(Share {
                pattern,
                share: one,
            }),
        }
    }
    shares.sort_by(|a, b| b.share.total_cmp(&a.share));
    shares
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_add_up_and_the_largest_is_first() {
        use Pattern::{Bulge, Ridge};
        let found = shares(&[Ridge, Bulge, Bulge, Bulge]);
        assert_eq!(
            found,
            [
                Share {
                    pattern: Bulge,
                    share: 0.75
                },
                Share {
                    pattern: Ridge,
                    share: 0.25
                }
            ]
        );
    }
}
