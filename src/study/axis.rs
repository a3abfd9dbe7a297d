//! Where the values of a study lie: between two ends, on a grid, or spread within it.

use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

/// Most points of a Sobol sequence.
pub const SOBOL_MAX: usize = 1 << 16;
/// Steps between the numbers of a Sobol sequence in [0, 1), which are of single precision.
const STEPS: f64 = 16_777_216.0;

/// How values lie between two ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spacing {
    /// Equal steps apart.
    Linear,
    /// Equal factors apart; both ends are above zero.
    Logarithmic,
}

/// Values between two ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// The first.
    pub from: f64,
    /// The last.
    pub to: f64,
    /// How they lie.
    pub spacing: Spacing,
}

impl Span {
    /// The value at this share of the way, 0 to 1.
    pub fn at(&self, share: f64) -> f64 {
        match self.spacing {
            Spacing::Logarithmic => self.from * (self.to / self.from).powf(share),
            Spacing::Linear => self.from + share * (self.to - self.from),
        }
    }

    /// So many values from end to end, two at least.
    pub fn values(&self, count: usize) -> Vec<f64> {
        let last = count.max(2) - 1;
        let share = |i: usize| i as f64 / last as f64;
        let inner = (0..last).map(|i| self.at(share(i)));
        inner.chain([self.to]).collect()
    }
}

/// Every combination of the values of the axes; the last axis goes fastest.
pub fn grid(axes: &[Vec<f64>]) -> Vec<Vec<f64>> {
    axes.iter().fold(vec![Vec::new()], |places, axis| {
        let longer = |place: &Vec<f64>, value: &f64| [&place[..], &[*value]].concat();
        let of = |place: &Vec<f64>| axis.iter().map(|value| longer(place, value)).collect();
        places
            .iter()
            .flat_map(|place| -> Vec<_> { of(place) })
            .collect()
    })
}

/// How places are chosen within the ends of the axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sequence {
    /// Independent of each other.
    Random,
    /// Sobol's low-discrepancy sequence, scrambled after Owen.
    Sobol,
}

impl Sequence {
    /// So many places within the `spans`, one an axis. The first ones stay when there are more.
    pub fn places(self, spans: &[Span], count: usize, seed: u32) -> Vec<Vec<f64>> {
        let mut chance = Pcg64::seed_from_u64(u64::from(seed));
        let mut share = |i: usize, axis: usize| match self {
            Sequence::Random => chance.random_range(0.0..1.0),
            // In the middle of its step, so that no place is an end.
            Sequence::Sobol => {
                let share = sobol_burley::sample(i as u32, axis as u32, seed);
                f64::from(share) + 0.5 / STEPS
            }
        };
        let mut place = |i: usize| -> Vec<f64> {
            let axes = spans.iter().enumerate();
            axes.map(|(axis, span)| span.at(share(i, axis))).collect()
        };
        (0..count).map(&mut place).collect()
    }
}
