//! The smallest Hessian eigenvalue: followed from state to state as an upper bound, and proved from
//! below.
//!
//! A mode that is carried along finds *its* eigenvalue, however well it converges, and not the
//! smallest one: the value from above is a Rayleigh quotient and no more. From below it is proved.
//!
//! From one state to another an eigenvalue falls by no more than gamma'' does anywhere on the mesh
//! (H. Weyl): where that leaves room the last proof still holds, and costs nothing.

use super::mechanics::Mechanics;
use super::method::{Lost, Stiffness};
pub use super::proof::CHANCE;
use super::proof::{Proof, Proved, odd_above, prove, prove_capped};
use crate::numerics::dense::{add, dot, norm, project_out, scale};
use crate::numerics::eigen::{EigenLimits, EigenPairs, smallest};
use crate::physics::system::{Evaluation, Fields, System, carried};
use rand::Rng;
use rand_pcg::Pcg64;

/// Follows the softest modes of a branch, and proves that nothing is softer.
#[derive(Clone, Debug)]
pub struct Tracker {
    modes: Vec<Vec<f64>>,
    rng: Pcg64,
    proof: Option<Proof>,
    /// Above which gamma'' is cut off for a proof, over [`System::stiffness_unit`].
    cap: f64,
    /// A coarser mesh of the same cell. Soft modes are long waves: what resolves the pattern
    /// resolves them, and the mesh in use may be finer than that by far.
    coarse: Option<Mechanics>,
    spent: usize,
}

/// Where modes are looked for: at a surface with these fields, beside the `removed` ones.
struct Place<'a> {
    mechanics: &'a mut Mechanics,
    fields: &'a Fields,
    removed: Vec<Vec<f64>>,
}

/// What is proved, as a share of the value from above. A larger share costs more products and is
/// more often refuted by the inexact value; a smaller one leaves less room for drift. From 0.5 to
/// 0.8 a loop of Fig. 2 costs 116, 104 and 113 transforms a state.
pub(super) const PROVED: f64 = 0.65;
/// The first cap. The softest modes of a tip lose less than a third of their stiffness by it; from
/// 5 to 10 a proof takes as many products, with 20 a third more, with 3 most are refuted and run
/// again.
const CAP: f64 = 6.0;
/// Below this value, over [`System::stiffness_unit`], the sign alone is proved: no residual tells
/// such values to a share of themselves.
const SIGN_ALONE: f64 = 5e-3;
/// The share to which it may fall by drift before it is proved anew.
const KEPT: f64 = 0.25;
/// Most rounds in search of all negative eigenvalues.
const NEGATIVE: usize = 60;
/// Softer modes that may be found one after the other at one state.
const FINDS: usize = 12;

/// When a mode is good enough: its error over its value, for one known from the state before and
/// for one found afresh.
const TRACKED: f64 = 0.25;
const AFRESH: f64 = 0.02;
/// The same over [`System::stiffness_unit`], near an instability.
const NEAR_ZERO: f64 = 1e-4;
/// How much better than that modes on the coarse mesh must be, so that the fine one finds them good
/// enough.
const REFINED: f64 = 0.4;

impl Tracker {
    /// Knows nothing yet; `rng` gives the random directions.
    pub fn new(rng: Pcg64) -> Self {
        Self {
            modes: Vec::new(),
            rng,
            proof: None,
            cap: CAP,
            coarse: None,
            spent: 0,
        }
    }

    /// The same, looking for modes on `coarse` first, a mesh of the same flat cell. The fine mesh
    /// then measures their eigenvalue, an upper bound, and its error by one product, and goes on
    /// from there only if that is too large.
    pub fn with_coarse(self, coarse: Mechanics) -> Self {
        Self {
            coarse: Some(coarse),
            ..self
        }
    }

    /// Transforms on the coarse mesh spent.
    pub fn coarse_transforms(&self) -> usize {
        self.coarse.as_ref().map_or(0, Mechanics::transforms)
    }

    /// Transforms, on any mesh, spent on proofs so far.
    pub fn proof_transforms(&self) -> usize {
        self.spent
    }

    /// Forgets the branch.
    pub fn reset(&mut self) {
        self.modes.clear();
        self.proof = None;
        self.cap = CAP;
    }

    /// The smallest eigenvalue and its mode at the surface `z` with these `fields`; the value is
    /// NaN if it was not found within the budget, or cancelled. Sliding modes are removed.
    ///
    /// The first check after a reset starts from random vectors; later ones from the modes of the
    /// state before.
    pub fn check(
        &mut self,
        mechanics: &mut Mechanics,
        z: &[f64],
        fields: &Fields,
    ) -> (Stiffness, Vec<f64>) {
        let mut fine = Place::of(mechanics, z, fields);
        let Some(mut coarse) = self.coarse.take() else {
            return self.at(&mut fine, 1.0);
        };
        let relative = if self.modes.is_empty() {
            AFRESH
        } else {
            TRACKED
        };
        let rough = shortened(&mut coarse, z, &fine);
        let removed = coarse.sliding_basis(&rough.state.amplitudes, &rough.fields);
        let (rough, mode) = self.at(
            &mut Place {
                removed,
                mechanics: &mut coarse,
                fields: &rough.fields,
            },
            REFINED,
        );
        let (seen, mode) = fine.measured(carried(&mode, &coarse.system, &fine.mechanics.system));
        // Where the coarse mesh does not resolve the mode, what it proved is not of the fine one
        // either.
        let (goal, apart) = (
            fine.goal(relative, seen.value),
            (seen.value - rough.value).abs(),
        );
        let decided =
            seen.value < 0.0 || rough.value >= 0.0 && apart <= REFINED * TRACKED * seen.value;
        let found = if decided && seen.error <= goal && apart <= REFINED * goal || fine.cancelled()
        {
            (
                Stiffness {
                    value: seen.value,
                    error: apart + rough.error,
                },
                mode,
            )
        } else {
            let up = |mode: &Vec<f64>| carried(mode, &coarse.system, &fine.mechanics.system);
            self.modes = self.modes.iter().map(up).collect();
            self.proof = None;
            let found = self.at(&mut fine, 1.0);
            self.modes = self
                .modes
                .iter()
                .map(|mode| carried(mode, &fine.mechanics.system, &coarse.system))
                .collect();
            self.proof = None;
            found
        };
        self.coarse = Some(coarse);
        found
    }

    /// The same from above alone: a Rayleigh quotient, with nothing proved, for whoever proves it
    /// among more modes than these. Where a coarse mesh has the modes, its proof costs little, and
    /// goes with them.
    pub fn above(
        &mut self,
        mechanics: &mut Mechanics,
        z: &[f64],
        fields: &Fields,
    ) -> (Stiffness, Vec<f64>) {
        if self.coarse.is_some() {
            return self.check(mechanics, z, fields);
        }
        let mut place = Place::of(mechanics, z, fields);
        let known = std::mem::take(&mut self.modes);
        let relative = if known.is_empty() { AFRESH } else { TRACKED };
        let found = place.softest(known, &mut self.rng, 2, relative);
        self.modes = found.vectors;
        let seen = Stiffness {
            value: found.values[0],
            error: found.residual,
        };
        (seen, self.modes[0].clone())
    }

    /// The proof alone that nothing is much softer than `value`, which is known to be an upper bound;
    /// `None` where something is, or where [`Tracker::check`] has more to say.
    pub fn bounded(
        &mut self,
        mechanics: &mut Mechanics,
        z: &[f64],
        fields: &Fields,
        value: f64,
    ) -> Option<Stiffness> {
        let mut place = Place::of(mechanics, z, fields);
        if self.coarse.is_some() || !self.modes.is_empty() || value < SIGN_ALONE * place.unit() {
            return None;
        }
        let mut least = self.room(&place);
        if !(least >= KEPT * value) {
            let before = place.mechanics.transforms();
            let proved = self.below(&mut place, PROVED * value);
            self.spent += place.mechanics.transforms() - before;
            match proved {
                Proved::Least(proof) => {
                    least = proof.least;
                    self.proof = Some(proof);
                }
                Proved::Softer(mode) => {
                    self.modes.push(mode);
                    return None;
                }
                Proved::Nothing => return None,
            }
        }
        Some(Stiffness {
            value,
            error: (value - least).max(0.0),
        })
    }

    /// These `fields` with gamma'' no larger than where the last proof was made, which holds of them as
    /// of the true ones; `None` without one.
    pub fn weakened(&self, fields: &Fields) -> Option<Fields> {
        Some(self.proof.as_ref()?.weakened(fields))
    }

    /// True where no odd mode at the even surface `z` lies below `shift` because no even one, of
    /// mean displacement zero, lies below `least` (E* per length; `[least, shift]`). False proves
    /// nothing.
    pub fn odd_above(
        &mut self,
        mechanics: &mut Mechanics,
        z: &[f64],
        [fields, weakened]: [&Fields; 2],
        goals: [f64; 2],
    ) -> bool {
        let removed = mechanics.sliding_basis(z, fields);
        let before = mechanics.transforms();
        let above = odd_above(mechanics, weakened, &removed, goals);
        self.spent += mechanics.transforms() - before;
        above
    }

    /// Below which the last proof leaves no eigenvalue at a place (E* per length).
    fn room(&self, place: &Place<'_>) -> f64 {
        self.proof.as_ref().map_or(f64::NEG_INFINITY, |proof| {
            proof.room(place.fields, &place.removed)
        })
    }

    /// The negative eigenvalues at the surface `z` with these `fields`, and the smallest of the
    /// others, with their modes: proved to be all but for the chance stated by [`CHANCE`]. Sliding
    /// modes are removed. The errors of the values are below `relative` or 1e-4 of q1.
    ///
    /// A Hessian that is negative on k modes, and positive beside them, has k negative eigenvalues.
    ///
    /// # Errors
    /// They were not found within the budget, or somebody asked to stop.
    pub fn negative(
        &mut self,
        mechanics: &mut Mechanics,
        z: &[f64],
        fields: &Fields,
        relative: f64,
    ) -> Result<EigenPairs, Lost> {
        let slides = mechanics.sliding_basis(z, fields);
        let mut place = Place {
            removed: slides.clone(),
            mechanics,
            fields,
        };
        for _ in 0..NEGATIVE {
            let known = std::mem::take(&mut self.modes);
            let pairs = known.len().max(1);
            let found = place.softest(known, &mut self.rng, pairs, relative);
            self.modes.clone_from(&found.vectors);
            if place.cancelled() {
                return Err(Lost::Cancelled);
            }
            let count = found.values.iter().filter(|v| **v < 0.0).count();
            if count == found.values.len() {
                self.modes
                    .push(random_smooth(&place.mechanics.system, &mut self.rng));
                continue;
            }
            let negative = found.vectors[..count].iter().cloned();
            place.removed = slides.iter().cloned().chain(negative).collect();
            match place.prove(0.0, &mut self.rng) {
                Proved::Least(_) => {
                    self.modes.truncate(count + 1);
                    return Ok(found);
                }
                Proved::Softer(mode) => self.modes.insert(count, mode),
                Proved::Nothing if place.cancelled() => return Err(Lost::Cancelled),
                Proved::Nothing => return Err(Lost::Gone),
            }
            place.removed.clone_from(&slides);
        }
        Err(Lost::Gone)
    }

    /// The smallest eigenvalue at a place, from above to `sharp` times the usual error and from
    /// below.
    fn at(&mut self, place: &mut Place<'_>, sharp: f64) -> (Stiffness, Vec<f64>) {
        let room = self.room(place);
        if room > 0.0
            && let Some(softest) = self.modes.first()
        {
            let (seen, mode) = place.measured(softest.clone());
            if seen.error <= sharp * place.goal(TRACKED, seen.value) && room >= KEPT * seen.value {
                return (
                    Stiffness {
                        value: seen.value,
                        error: (seen.value - room).max(0.0),
                    },
                    mode,
                );
            }
        }
        let mut relative = if self.modes.is_empty() {
            AFRESH
        } else {
            TRACKED
        };
        // Rounding may say softer, and not find it: an eigenvalue so close to zero is the end of
        // the branch.
        let mut undecided = f64::NAN;
        for find in 0..FINDS {
            let found = place.softest(
                std::mem::take(&mut self.modes),
                &mut self.rng,
                2,
                sharp * relative,
            );
            self.modes = found.vectors;
            let (value, mode) = (found.values[0], self.modes[0].clone());
            // A negative Rayleigh quotient is proof by itself.
            if value < 0.0 || place.cancelled() {
                return (
                    Stiffness {
                        value,
                        error: found.residual,
                    },
                    mode,
                );
            }
            if room >= KEPT * value {
                return (
                    Stiffness {
                        value,
                        error: (value - room).max(0.0),
                    },
                    mode,
                );
            }
            let (before, soft) = (
                place.mechanics.transforms(),
                value < SIGN_ALONE * place.unit(),
            );
            let sign_alone = soft || find + 2 >= FINDS;
            let proved = self.below(place, if sign_alone { 0.0 } else { PROVED * value });
            self.spent += place.mechanics.transforms() - before;
            match proved {
                Proved::Nothing => {
                    undecided = f64::NAN;
                    break;
                }
                Proved::Least(proof) => {
                    let error = value - proof.least;
                    self.proof = Some(proof);
                    return (Stiffness { value, error }, mode);
                }
                Proved::Softer(mode) => {
                    self.modes.insert(0, mode);
                    relative = AFRESH;
                    undecided = if soft { -value } else { f64::NAN };
                }
            }
        }
        (
            Stiffness {
                value: undecided,
                error: undecided.abs(),
            },
            self.modes.first().cloned().unwrap_or_default(),
        )
    }

    /// Whether an eigenvalue lies below `shift`: asked of a capped gamma'' first, with a higher cap
    /// from then on where that was too low.
    fn below(&mut self, place: &mut Place<'_>, shift: f64) -> Proved {
        let stiffest = place
            .fields
            .stiffness
            .fold(0.0, |most: f64, k| most.max(*k));
        let cap = self.cap * place.unit();
        if shift < cap && cap < stiffest {
            let goals = [cap, shift];
            let Place {
                mechanics,
                fields,
                removed,
            } = place;
            let found = prove_capped(mechanics, fields, removed, goals, &mut self.rng);
            match found {
                Proved::Least(_) => return found,
                Proved::Softer(mode) if place.measured(mode.clone()).0.value < shift => {
                    return Proved::Softer(mode);
                }
                _ if place.cancelled() => return Proved::Nothing,
                _ => {}
            }
            self.cap *= 2.0;
        }
        place.prove(shift, &mut self.rng)
    }
}

/// The surface `z` of `fine` without its shortest waves, for which `coarse` is made ready.
fn shortened(coarse: &mut Mechanics, z: &[f64], fine: &Place<'_>) -> Evaluation {
    let z = carried(z, &fine.mechanics.system, &coarse.system);
    let u0 = fine.fields.gap.mean().unwrap_or(f64::NAN);
    let control = coarse.system.control().value(u0, z[0]);
    let at = coarse.at(z, control);
    coarse.refresh(&at.fields);
    at
}

impl<'a> Place<'a> {
    /// The surface `z` of a mesh, with these `fields`.
    fn of(mechanics: &'a mut Mechanics, z: &[f64], fields: &'a Fields) -> Self {
        Self {
            removed: mechanics.sliding_basis(z, fields),
            mechanics,
            fields,
        }
    }
}

impl Place<'_> {
    /// [`System::stiffness_unit`].
    fn unit(&self) -> f64 {
        self.mechanics.system.stiffness_unit()
    }

    fn cancelled(&self) -> bool {
        self.mechanics.cancel.requested()
    }

    /// The error that a mode of this value may have.
    fn goal(&self, relative: f64, value: f64) -> f64 {
        (relative * value.abs()).max(NEAR_ZERO * self.unit())
    }

    /// Whether an eigenvalue lies below `shift`.
    fn prove(&mut self, shift: f64, rng: &mut Pcg64) -> Proved {
        prove(self.mechanics, self.fields, &self.removed, shift, rng)
    }

    /// The softest modes, from the `known` ones of the state before or from random vectors.
    fn softest(
        &mut self,
        known: Vec<Vec<f64>>,
        rng: &mut Pcg64,
        pairs: usize,
        relative: f64,
    ) -> EigenPairs {
        let Self {
            mechanics,
            fields,
            removed,
        } = self;
        let Mechanics {
            system,
            preconditioner,
            cancel,
            workspace,
            ..
        } = &mut **mechanics;
        let (strangers, least, most) = if known.is_empty() {
            (6, 8, 80)
        } else {
            (0, 1, 12)
        };
        let mut start = known;
        start.iter_mut().for_each(|mode| system.make_real(mode));
        start.extend((0..strangers).map(|_| random_smooth(system, rng)));
        let limits = EigenLimits {
            pairs,
            least,
            most,
            relative,
            absolute: NEAR_ZERO * system.stiffness_unit(),
        };
        let precondition = |r: &[f64], out: &mut [f64]| {
            preconditioner.apply(r, out);
            // Amplitudes that belong to no real field have elastic energy alone. In deep
            // compression that is less than any real mode has, and they would grow out of the
            // rounding.
            system.make_real(out);
        };
        smallest(
            |v, out| system.hessian(fields, v, out, workspace),
            start,
            removed,
            precondition,
            limits,
            cancel,
        )
    }

    /// The eigenvalue of a `mode`, its error, and the mode normalised.
    fn measured(&mut self, mut mode: Vec<f64>) -> (Stiffness, Vec<f64>) {
        self.mechanics.system.make_real(&mut mode);
        project_out(&mut mode, &self.removed);
        let length = norm(&mode);
        scale(&mut mode, 1.0 / length);
        let mut image = vec![0.0; mode.len()];
        self.mechanics.hessian(self.fields, &mode, &mut image);
        let value = dot(&mode, &image);
        add(&mut image, -value, &mode);
        project_out(&mut image, &self.removed);
        (
            Stiffness {
                value,
                error: norm(&image),
            },
            mode,
        )
    }
}

/// A random real field of soft waves, long ones of a half-space, as amplitudes: every symmetry is
/// in it.
pub fn random_smooth(system: &System, rng: &mut Pcg64) -> Vec<f64> {
    let unit = system.stiffness_unit();
    let mut z = random_amplitudes(system, rng);
    for (z, e) in z.iter_mut().zip(system.elastic()) {
        let waves = 2.0 * e / unit;
        *z *= (-0.3 * waves).exp();
    }
    z
}

/// White noise of variance 1/3 per amplitude with the symmetry of a real field, without mean.
pub fn random_amplitudes(system: &System, rng: &mut Pcg64) -> Vec<f64> {
    let mut z: Vec<f64> = (0..system.dimension())
        .map(|_| rng.random_range(-1.0..1.0))
        .collect();
    system.make_real(&mut z);
    z
}
