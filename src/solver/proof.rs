//! Proofs of stability from below: that nothing is softer than a shift t, whatever one is looking
//! for.
//!
//! The Hessian less the shift, H - t, is looked at through Lanczos vectors of a random start
//! ([`lowest`]), in coordinates y of amplitudes F y in which a preconditioner F F^T is one: H and
//! F^T H F have negative eigenvalues together, and the second has few near zero. Either no
//! eigenvalue lies below t, but for a chance of [`CHANCE`], or a softer mode has been found.
//!
//! **The cap.** gamma'' is tens to thousands of times stiffer where the surface is pressed than the
//! softest modes are, which hardly go there. A Hessian with a smaller gamma'' has smaller
//! eigenvalues: what is proved of one whose gamma'' is cut off above holds for the true one. Its
//! spectrum does not grow with the pressure: over the tip at mu_rho = 0.5, whole cell, a proof takes
//! 25 and 40 products at n = 64 and 128 where it took 42 and 84.

use super::mechanics::Mechanics;
use crate::numerics::dense::{add, dot, norm, products, project_out};
use crate::numerics::eigen::lowest;
use crate::numerics::krylov::{CgEnd, CgLimits, conjugate_gradients};
use crate::numerics::precision::Precision;
use crate::physics::system::Fields;
use ndarray::{Array2, Zip};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

/// Chance that an eigenvalue lies below a proof all the same. A loop has some hundred proofs, ten
/// thousand at most: below 1e-6 a loop.
pub const CHANCE: f64 = 1e-10;
/// The same in single precision, whose products hide what is a ten-millionth of the start.
const CHANCE_SINGLE: f64 = 1e-3;
/// Most products of one proof; 30 to 90 are normal.
const PRODUCTS: usize = 1000;
/// Most products of a solve that bounds odd modes.
const SOLVING: usize = 40;
/// Share of the square of the allowed residual to which it is done. What is allowed is not known
/// before y is, and foretold by the preconditioner, which is at most twice too soft.
const ENOUGH: f64 = 0.3;
/// Stiffness of the preconditioner's diagonal over the cap: from .1 to .5 a proof takes as many
/// products.
const UNDER_CAP: f64 = 0.5;

/// That no eigenvalue lay below `least` (E* per length) beside the `removed` modes, where gamma''
/// was `stiffness` or more.
#[derive(Clone, Debug)]
pub(super) struct Proof {
    pub least: f64,
    stiffness: Array2<f64>,
    removed: Vec<Vec<f64>>,
}

/// What a run of Lanczos came to.
pub(super) enum Proved {
    /// There is nothing softer.
    Least(Proof),
    /// This mode is.
    Softer(Vec<f64>),
    /// Cancelled, or the budget is spent.
    Nothing,
}

impl Proof {
    /// These `fields` with gamma'' no larger than where it was proved: it is proved of them as it is
    /// of the true ones.
    pub fn weakened(&self, fields: &Fields) -> Fields {
        let both = Zip::from(&self.stiffness).and(&fields.stiffness);
        Fields::of(both.map_collect(|then, now| then.min(*now)))
    }

    /// Below which no eigenvalue lies at another state of the same system, with these `fields` and
    /// `removed` modes (E* per length).
    ///
    /// By as much as gamma'' falls on some point an eigenvalue may fall. Sliding modes that were
    /// left out then, and are not quite those that are left out now, had no stiffness.
    pub fn room(&self, fields: &Fields, removed: &[Vec<f64>]) -> f64 {
        let fallen = self
            .stiffness
            .iter()
            .zip(&fields.stiffness)
            .fold(0.0, |most: f64, (then, now)| most.max(then - now));
        let kept = |row: &Vec<f64>| row.iter().map(|c| c * c).sum::<f64>();
        let tilt: f64 = products(&self.removed, removed)
            .iter()
            .map(|row| 1.0 - kept(row))
            .sum();
        // With none to compare with, those left out then are all back.
        let tilt = if removed.is_empty() {
            self.removed.len() as f64
        } else {
            tilt
        };
        self.least * (1.0 - tilt) - fallen
    }
}

/// True where no eigenvalue of the Hessian of a system of odd modes lies below `shift` beside the
/// `removed` modes, because none of the even ones, of mean displacement zero, lies below `least`.
/// False proves nothing. Two transforms a product, of which there are nine to fourteen.
///
/// An odd mode has no less energy than the even one with the same values on the quarter
/// ([`orders_modes`](crate::physics::system::System::orders_modes)). Let A be the Hessian less the
/// shift. Of odd modes w without a mean on the quarter, all directions but one, it is known
/// therefore that w A w >= (least - shift) w^2. The direction left is that of A y = 1, for which w A
/// y = 0: then A is positive if y A y is. With A y = 1 + e, a sum of y and w has no less energy than
/// y A y - 2 |e| |w| + (least - shift) w^2, which is positive for all w if e^2 < (least - shift) y A
/// y.
pub(super) fn odd_above(
    mechanics: &mut Mechanics,
    fields: &Fields,
    removed: &[Vec<f64>],
    [least, shift]: [f64; 2],
) -> bool {
    let stiffest = fields.stiffness.fold(0.0, |most: f64, k| most.max(*k));
    softened(mechanics, fields, stiffest, |mechanics| {
        odd_solved(mechanics, fields, removed, [least, shift])
    })
}

/// The same with the preconditioner at hand.
fn odd_solved(
    mechanics: &mut Mechanics,
    fields: &Fields,
    removed: &[Vec<f64>],
    [least, shift]: [f64; 2],
) -> bool {
    let Mechanics {
        system,
        preconditioner,
        cancel,
        workspace,
        ..
    } = mechanics;
    let room = least - shift;
    let mut ones = system.quarter(workspace);
    project_out(&mut ones, removed);
    let mut guess = vec![0.0; ones.len()];
    preconditioner.apply(&ones, &mut guess);
    let energy = dot(&ones, &guess);
    let limits = CgLimits::new((ENOUGH * room * energy).sqrt() / norm(&ones), SOLVING);
    let mut shifted = |v: &[f64], out: &mut [f64]| {
        system.hessian(fields, v, out, workspace);
        add(out, -shift, v);
        project_out(out, removed);
    };
    let precondition = |r: &[f64], out: &mut [f64]| preconditioner.apply(r, out);
    let found = conjugate_gradients(&mut shifted, &ones, precondition, removed, limits, cancel);
    if found.end != CgEnd::Converged {
        return false;
    }
    let mut image = vec![0.0; ones.len()];
    shifted(&found.x, &mut image);
    let energy = dot(&found.x, &image);
    add(&mut image, -1.0, &ones);
    energy > 0.0 && dot(&image, &image) < room * energy
}

/// Whether an eigenvalue of the Hessian with these `fields` lies below `shift` beside the `removed`
/// modes: one run from a start drawn evenly from all real fields. Removed modes are made as stiff as
/// the preconditioner takes them for.
pub(super) fn prove(
    mechanics: &mut Mechanics,
    fields: &Fields,
    removed: &[Vec<f64>],
    shift: f64,
    rng: &mut Pcg64,
) -> Proved {
    let Mechanics {
        system,
        preconditioner,
        cancel,
        workspace,
        ..
    } = mechanics;
    let noise = Array2::from_shape_simple_fn(system.shape(), || StandardNormal.sample(rng));
    let start = system.amplitudes(&noise, workspace);
    let stiffened: Vec<f64> = removed
        .iter()
        .map(|mode| {
            let mut softened = vec![0.0; mode.len()];
            preconditioner.apply(mode, &mut softened);
            1.0 / dot(mode, &softened)
        })
        .collect();
    let (mut x, mut image, mut real) = (
        vec![0.0; start.len()],
        vec![0.0; start.len()],
        vec![0.0; start.len()],
    );
    let mut shifted = |y: &[f64], out: &mut [f64]| {
        real.copy_from_slice(y);
        system.make_real(&mut real);
        preconditioner.spread(&real, &mut x);
        let along: Vec<f64> = removed.iter().map(|mode| dot(mode, &x)).collect();
        project_out(&mut x, removed);
        system.hessian(fields, &x, &mut image, workspace);
        add(&mut image, -shift, &x);
        project_out(&mut image, removed);
        for ((mode, along), stiffness) in removed.iter().zip(along).zip(&stiffened) {
            add(&mut image, along * stiffness, mode);
        }
        system.make_real(&mut image);
        preconditioner.gather(&image, out);
        // Amplitudes that belong to no real field come from rounding alone. With an eigenvalue
        // of one they stay there; with one near zero they would grow as the bound does.
        add(out, 1.0, y);
        add(out, -1.0, &real);
    };
    let chance = if system.precision() == Precision::Double {
        CHANCE
    } else {
        CHANCE_SINGLE
    };
    let bound = lowest(&mut shifted, &start, chance, PRODUCTS, Some(0.0), cancel);
    if bound.lower >= 0.0 {
        return Proved::Least(Proof {
            least: shift,
            stiffness: fields.stiffness.clone(),
            removed: removed.to_vec(),
        });
    }
    if !(bound.upper < 0.0) {
        return Proved::Nothing;
    }
    let y = bound.vector(&mut shifted, &start);
    let mut softer = vec![0.0; y.len()];
    preconditioner.spread(&y, &mut softer);
    Proved::Softer(softer)
}

/// The same with gamma'' cut off above `cap` (E* per length), and a preconditioner made for that: a
/// proof holds for the true Hessian, a softer mode need not be one of it.
pub(super) fn prove_capped(
    mechanics: &mut Mechanics,
    fields: &Fields,
    removed: &[Vec<f64>],
    [cap, shift]: [f64; 2],
    rng: &mut Pcg64,
) -> Proved {
    let capped = Fields::of(fields.stiffness.mapv(|stiffness| stiffness.min(cap)));
    softened(mechanics, &capped, cap, |mechanics| {
        prove(mechanics, &capped, removed, shift, rng)
    })
}

/// What `work` finds with a preconditioner for these `fields`, whose gamma'' goes up to `cap`.
fn softened<T>(
    mechanics: &mut Mechanics,
    fields: &Fields,
    cap: f64,
    work: impl FnOnce(&mut Mechanics) -> T,
) -> T {
    let usual = mechanics.preconditioner.clone();
    let under = usual
        .clone()
        .with_stiffness(&mechanics.system, UNDER_CAP * cap);
    mechanics.preconditioner = under;
    mechanics.refresh(fields);
    let found = work(mechanics);
    mechanics.preconditioner = usual;
    found
}
