//! Where a surface lands is not always one place: at the limit of the flat state two waves go soft
//! together, and their mixture decides.
//!
//! The first waves along x and along y may come in any mixture, and what the flat state jumps to
//! can depend on it. All mixtures are tried; the one that most of them lead to is what the loop
//! follows, whatever its seed, and the others are said.

use crate::physics::pattern::Pattern;
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_4;

/// How many mixtures are tried: the angle from one wave alone to both alike, in equal parts.
/// Whatever less than a part leads to is not seen.
pub const MIXTURES: usize = 7;

/// Root mean square kick at a limit of the flat state, in ranges. While amplitudes are small nearly
/// all mixtures turn into the same: of two laws that were contested with a tenth of a range none is
/// with this.
pub const FLAT_KICK: f64 = 0.03;
/// The same at the end of any other branch, along the mode that gives way: far enough from the
/// saddle next to it.
pub const KICK: f64 = 0.1;

/// A pattern and the share of the mixtures that lead to it, 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Share {
    /// Where they lead.
    pub pattern: Pattern,
    /// How many of all.
    pub share: f64,
}

/// The angle of a mixture: amplitudes cos and sin of it. x and y may be exchanged, so that an
/// eighth of a turn is all.
pub fn angle(mixture: usize) -> f64 {
    FRAC_PI_4 * (mixture as f64 + 0.5) / MIXTURES as f64
}

/// Which mixture amplitudes `x` and `y` belong to.
pub fn mixture(x: f64, y: f64) -> usize {
    let (x, y) = (x.abs(), y.abs());
    let part = x.min(y).atan2(x.max(y)) / FRAC_PI_4 * MIXTURES as f64;
    (part as usize).min(MIXTURES - 1)
}

/// What all mixtures lead to, each looked at by `one`. Where the purest, the evenest and one in
/// between lead to the `same`, so do those between them.
pub fn tried<T: Clone>(mut one: impl FnMut(usize) -> T, same: impl Fn(&T, &T) -> bool) -> Vec<T> {
    const MIDDLE: usize = MIXTURES / 2;
    let seen = [0, MIDDLE, MIXTURES - 1].map(&mut one);
    let agree = same(&seen[0], &seen[1]) && same(&seen[1], &seen[2]);
    (0..MIXTURES)
        .map(|mixture| match mixture {
            0 => seen[0].clone(),
            MIDDLE => seen[1].clone(),
            _ if mixture == MIXTURES - 1 => seen[2].clone(),
            _ if agree => seen[1].clone(),
            _ => one(mixture),
        })
        .collect()
}

/// The shares of what each mixture leads to, the largest first; of equal ones that of the purer
/// wave.
pub fn shares(landings: &[Pattern]) -> Vec<Share> {
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
    fn every_angle_belongs_to_its_mixture_and_so_do_its_mirror_images() {
        for i in 0..MIXTURES {
            let (y, x) = angle(i).sin_cos();
            for (a, b) in [(x, y), (y, x), (-x, y), (x, -y)] {
                assert_eq!(mixture(3.0 * a, 3.0 * b), i);
            }
        }
        assert_eq!([mixture(1.0, 0.0), mixture(1.0, 1.0)], [0, MIXTURES - 1]);
    }

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
