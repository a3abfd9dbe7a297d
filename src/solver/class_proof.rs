//! Proofs of stability by exact blocks, class by class of symmetry: two transforms and no chance,
//! where few waves soften.
//!
//! Over an even pattern the Hessian falls into classes, and in each the number of eigenvalues below
//! a shift is bounded by its longest waves alone ([`LowBlock::most_below`]). Where it is one at
//! most, and a mode is known whose eigenvalue lies below the shift, that is the smallest; where it
//! is none nothing need be known.
//!
//! gamma'' is cut off above for that (a smaller gamma'' has smaller eigenvalues): what is stiff in
//! contact is joined to waves beyond a block more strongly than their elasticity allows for.

use super::index::Symmetry;
use super::mechanics::{Mechanics, Rates, Slides};
use super::method::Stiffness;
use super::stability::PROVED;
use crate::numerics::dense::{add, dot, norm, scale};
use crate::physics::low_block::{Class, LowBlock};
use crate::physics::system::{Fields, System};
use crate::physics::theory::critical_length;
use ndarray::Array2;

/// Most waves that may soften along a side of the cell: at 4.8 waves blocks prove 76 of 79 states of a
/// loop, at 6 a tenth of them.
const MOST_PERIODS: f64 = 5.0;
/// Reach of the blocks beyond those waves: of the 140 square states of Fig. 2 the first leaves 23
/// unproved, the second 3, the last none (with a cap of 2).
const BEYOND: [f64; 3] = [5.0, 8.0, 12.0];
/// The cap of gamma'' over [`System::stiffness_unit`]: with 2, 3 and 5 blocks prove 40, 76 and 74 of
/// 79 states at 4.8 waves.
const CAP: f64 = 3.0;
/// How far above a known mode no second one may lie, over [`System::stiffness_unit`].
const MARGIN: f64 = 0.1;

/// Blocks of the modes over the patterns of a system that are even and keep x <-> y.
#[derive(Clone, Debug)]
pub struct ClassProof {
    classes: Vec<[LowBlock; BEYOND.len()]>,
    slides: bool,
}

/// The softest mode of one class, as far as it is known.
#[derive(Clone, Copy, Debug)]
pub struct Known {
    /// Its symmetry.
    pub class: Class,
    /// Its Rayleigh quotient (E* per length).
    pub value: f64,
    /// An eigenvalue of the class lies no farther from `value`.
    pub residual: f64,
}

impl Known {
    /// The part of an even `mode` over a pattern that keeps x <-> y that belongs to one class, and
    /// most of it does. Two transforms.
    pub fn of(even: &mut Mechanics, fields: &Fields, mode: &[f64]) -> Self {
        let part = |class: Class| {
            let mut part = mode.to_vec();
            class.project(&even.system, &mut part);
            (class, norm(&part), part)
        };
        let [one, other] = [Class::Symmetric, Class::Antisymmetric].map(part);
        let (class, length, mut part) = if one.1 >= other.1 { one } else { other };
        scale(&mut part, 1.0 / length);
        let mut image = vec![0.0; part.len()];
        even.hessian(fields, &part, &mut image);
        let value = dot(&part, &image);
        add(&mut image, -value, &part);
        Self {
            class,
            value,
            residual: norm(&image),
        }
    }
}

/// The least value of those known (E* per length); infinite where none is.
pub fn softest(known: &[Known]) -> f64 {
    known
        .iter()
        .map(|known| known.value)
        .fold(f64::INFINITY, f64::min)
}

impl ClassProof {
    /// For patterns of an even `system`, which slide so on its whole cell; `None` where it would
    /// not pay.
    pub fn new(system: &System, slides: Slides) -> Option<Self> {
        let periods = system.grid().length / critical_length(system.law());
        let suits = system.is_flat()
            && !system.grid().is_line()
            && !system.control().frees_mean()
            && slides != Slides::UnlessPinned
            && periods <= MOST_PERIODS;
        let blocks = |(class, _)| BEYOND.map(|reach| LowBlock::new(system, class, reach + periods));
        suits.then(|| Self {
            classes: Symmetry::Square
                .classes(periods)
                .into_iter()
                .map(blocks)
                .collect(),
            slides: slides == Slides::Freely,
        })
    }

    /// The smallest eigenvalue over all modes at the surface `z` with these `fields`, sliding modes
    /// left out: that of the softest `known` mode, with what is proved of it. `None` where nothing
    /// is. Two transforms.
    pub fn least(
        &mut self,
        mechanics: &mut Mechanics,
        z: &[f64],
        fields: &Fields,
        known: &[Known],
    ) -> Option<Stiffness> {
        let softest = softest(known);
        let unit = mechanics.system.stiffness_unit();
        let cut = |k: f64| {
            if k > 0.0 {
                -CAP * unit * (-k / (CAP * unit)).exp_m1()
            } else {
                k
            }
        };
        let stiffness = fields.stiffness.mapv(cut);
        let least = stiffness.fold(f64::INFINITY, |least: f64, k| least.min(*k));
        let twice = rates(mechanics, &stiffness * &stiffness);
        let once = rates(mechanics, stiffness);
        let mut lower = softest;
        for blocks in &mut self.classes {
            let proved = blocks.iter_mut().find_map(|block| {
                let z = self.slides.then_some(z);
                block.bound(
                    &mechanics.system,
                    z,
                    [&once.forces, &twice.forces],
                    [once.stress, twice.stress],
                );
                let known = known.iter().find(|known| known.class == block.class());
                let alone = known.filter(|known| {
                    let shift = known.value + MARGIN * unit;
                    known.value + known.residual < shift && block.most_below(least, shift) <= 1
                });
                // The second eigenvalue is not below the shift (G. Temple).
                let off = |known: &Known| known.residual.powi(2) / (MARGIN * unit);
                alone.map(|known| known.value - off(known)).or_else(|| {
                    let shifts = [softest, PROVED * softest];
                    shifts
                        .into_iter()
                        .find(|shift| block.most_below(least, *shift) == 0)
                })
            });
            lower = lower.min(proved?);
        }
        (lower > 0.0).then_some(Stiffness {
            value: softest,
            error: softest - lower,
        })
    }
}

/// Amplitudes and mean of a gamma''.
fn rates(mechanics: &mut Mechanics, stiffness: Array2<f64>) -> Rates {
    mechanics.rates(&Fields::of(stiffness))
}
