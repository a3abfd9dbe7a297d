//! What a step of the walk tells: the record of its state, what is left to do and why it goes no
//! further, and what it costs.

use super::Walk;
use super::landing::FAINT;
use crate::follow::atlas::Unmapped;
use crate::follow::record::{Cause, JumpRecord, StateRecord};
use crate::physics::pattern::{Pattern, classify, contact_area};
use crate::scene::Part;
use crate::solver::method::{Cost, Stiffness};
use ndarray::Array2;

/// What one step of the walk brought.
#[derive(Clone, Debug)]
pub enum Observed {
    /// A new state on the path.
    State(StateRecord),
    /// The surface is moving at fixed u0; [`Walk::gap`] shows it.
    Moving {
        /// Mean stress at this instant (E*).
        stress: f64,
    },
    /// A jump was completed; the state after it follows.
    Jump(JumpRecord),
}

/// What is left to do.
#[derive(Clone, Debug, PartialEq)]
pub enum Progress {
    /// More steps are needed.
    Working,
    /// At the target.
    Resting,
    /// Interrupted by the cancel token; the last state stands.
    Cancelled,
    /// Cannot go on; the last state stands.
    Stuck(Stuck),
}

/// Why a loop goes no further.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Stuck {
    /// On a part of the cell: a mode that the part does not hold.
    #[error("a mode that is not mirror-symmetric goes soft here: this scene needs the whole cell")]
    LeavesSymmetry,
    /// On a part of the cell: a push, which may be pressed in anywhere.
    #[error("a push has no symmetry: it needs the whole cell")]
    Pushed,
    /// The numbers of a method stopped being finite.
    #[error("NaN: {why} ({method} at u0 = {mean_displacement:.6})")]
    Diverged {
        /// Where (length).
        mean_displacement: f64,
        /// By which method.
        method: &'static str,
        /// What it ran into.
        why: &'static str,
    },
    /// A method that locates nothing came to a state of higher energy than the work done on it.
    #[error(
        "energy gained: too hot a thermostat, or a run into the wall of the law ({gained:.1e} gamma, {method} at u0 = {mean_displacement:.6})"
    )]
    EnergyGained {
        /// Where (length).
        mean_displacement: f64,
        /// By which method.
        method: &'static str,
        /// How much (gamma).
        gained: f64,
    },
    /// The release found no way down.
    #[error("the release at u0 = {mean_displacement:.6} found no way down")]
    NoWayDown {
        /// Where (length).
        mean_displacement: f64,
    },
    /// Every place where a release came to rest was a saddle.
    #[error("after the jump at u0 = {mean_displacement:.6} every resting place found was unstable")]
    OnlyUnstable {
        /// Where (length).
        mean_displacement: f64,
    },
    /// A release ended at a higher energy than it began with.
    #[error(
        "the release at u0 = {mean_displacement:.6} would have gained energy ({released:.2e} gamma), which is a failure of the solver"
    )]
    NegativeRelease {
        /// Where (length).
        mean_displacement: f64,
        /// What it released (gamma), below zero.
        released: f64,
    },
    /// Stress or energy of a state overflow.
    #[error("stress or energy are no finite numbers")]
    NotFinite,
    /// The atlas does not hold the scene.
    #[error("{0}")]
    Unmapped(Unmapped),
    /// There is no loop from the first state.
    #[error("{what}; {remedy}")]
    NoStart {
        /// What is wrong with it.
        what: String,
        /// What may help.
        remedy: String,
    },
}

impl Stuck {
    /// What happened, in short and without the place.
    pub fn what(&self) -> String {
        match self {
            Stuck::LeavesSymmetry => "a mode that is not mirror-symmetric goes soft".to_owned(),
            Stuck::Pushed => "a push has no symmetry".to_owned(),
            Stuck::Diverged { why, .. } => format!("NaN: {why}"),
            Stuck::EnergyGained { .. } => "energy gained".to_owned(),
            Stuck::NoWayDown { .. } => "the release found no way down".to_owned(),
            Stuck::OnlyUnstable { .. } => "every resting place found was unstable".to_owned(),
            Stuck::NegativeRelease { .. } => "the release would have gained energy".to_owned(),
            Stuck::NotFinite => self.to_string(),
            Stuck::Unmapped(unmapped) => unmapped.what.clone(),
            Stuck::NoStart { what, .. } => what.clone(),
        }
    }
}

impl std::ops::AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        let Self {
            transforms,
            proof_transforms,
            coarse_transforms,
            iterations,
            patterned_increments,
        } = other;
        self.transforms += transforms;
        self.proof_transforms += proof_transforms;
        self.coarse_transforms += coarse_transforms;
        self.iterations += iterations;
        self.patterned_increments += patterned_increments;
    }
}

/// What was spent so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counts {
    /// Fourier transforms.
    pub transforms: usize,
    /// Those of them that prove that no mode is softer than the ones that are followed.
    pub proof_transforms: usize,
    /// Those of a coarser mesh than the walk's, on which modes are followed and proved on flat ground.
    pub coarse_transforms: usize,
    /// Iterations of the method.
    pub iterations: usize,
    /// Recorded states with a pattern.
    pub patterned_increments: usize,
}

impl Walk {
    pub(super) fn pattern(&self) -> Pattern {
        let (law, is_flat) = (&self.model.law, self.system().is_flat());
        // What a thermostat roughens is no pattern.
        let thermal = !self.method.locates() && self.here.state.roughness() < 0.02 * law.range;
        if is_flat && (self.here.is_uniform() || thermal) {
            return Pattern::Flat;
        }
        let (gap, u0) = (&self.here.fields.gap, self.here.state.mean_displacement);
        let unstable = self.flat.is_some_and(|flat| !flat.is_stable(u0));
        match self.pattern_of(gap) {
            // No longer flat, however faint.
            Pattern::Flat if unstable && self.here.state.roughness() > FAINT * law.range => {
                let larger = law.range / self.here.state.roughness();
                self.pattern_of(&gap.mapv(|g| u0 + larger * (g - u0)))
            }
            pattern => pattern,
        }
    }

    /// The pattern of a surface with this `gap`.
    pub(super) fn pattern_of(&self, gap: &Array2<f64>) -> Pattern {
        let system = self.system();
        classify(system.unfolded(gap).view(), system.law(), system.is_flat())
    }

    /// A jump from this u0, stress and pattern to the present state and this pattern, with its released
    /// energy and the error of that.
    pub(super) fn jumped(
        &self,
        cause: Cause,
        [u0, stress]: [f64; 2],
        [from, to]: [Pattern; 2],
        [released_energy, release_error]: [f64; 2],
    ) -> JumpRecord {
        let here = &self.here.state;
        JumpRecord {
            direction: self.direction,
            control: here.control,
            mean_displacement: u0,
            mean_displacement_after: here.mean_displacement,
            from,
            to,
            stress_before: stress,
            stress_after: here.stress,
            released_energy,
            release_error,
            cause,
            landings: Vec::new(),
        }
    }

    /// Writes the record of the present state and hands it out.
    pub(super) fn accept(&mut self, observe: &mut dyn FnMut(Observed)) {
        let law = self.model.law;
        let uniform = self.here.is_uniform() && self.system().is_flat();
        let pattern = self.pattern();
        if self.method.locates() {
            self.note_transition(pattern, observe);
        }
        let contact_area = if uniform {
            f64::from(u8::from(
                self.here.state.mean_displacement < law.contact_gap(),
            ))
        } else {
            contact_area(self.here.fields.gap.view(), &law)
        };
        if pattern != Pattern::Flat {
            self.spent.counts.patterned_increments += 1;
        }
        self.pause_clock();
        let stiffness = self.here.stiffness_min.unwrap_or(Stiffness {
            value: f64::NAN,
            error: f64::NAN,
        });
        let length = self.model.grid.length;
        self.record = StateRecord {
            direction: self.direction,
            control: self.here.state.control,
            mean_displacement: self.here.state.mean_displacement,
            stress: self.here.state.stress,
            stress_over_max: self.here.state.stress / law.traction_max(),
            contact_area,
            pattern,
            residual: self.here.residual,
            stiffness_min: stiffness.value * length,
            stiffness_error: stiffness.error * length,
            energy: self.here.state.body_energy(self.control()),
            part: match self.options.part {
                _ if uniform && self.flat.is_some() => Part::Flat,
                part if self.model.grid.is_line() => part.of_line(),
                part => part,
            },
            stop: self.here.stop,
            iterations: self.spent.counts.iterations - self.spent.recorded.iterations,
            transforms: self.transforms() - self.spent.recorded.transforms,
            milliseconds: std::mem::take(&mut self.spent.worked).as_secs_f64() * 1e3,
        };
        self.spent.recorded = Cost {
            iterations: self.spent.counts.iterations,
            transforms: self.transforms(),
        };
        observe(Observed::State(self.record.clone()));
    }
}
