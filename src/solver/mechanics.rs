//! The mechanics at hand: a system with all that solving it takes, so that nobody carries the
//! pieces one by one.

use super::contact;
use crate::numerics::dense::{dot, norm, orthonormalise};
use crate::numerics::krylov::{CgLimits, CgSolution, conjugate_gradients};
use crate::numerics::threads::Cancel;
use crate::physics::control::Control;
use crate::physics::low_block::Class;
use crate::physics::preconditioner::Preconditioner;
use crate::physics::system::{Evaluation, Fields, System, Workspace};
use ndarray::Array2;

/// A system, an approximate inverse of its Hessian, whether its patterns slide, and working memory.
///
/// The Hessian is that of the [`Fields`] it is given: an evaluation is a value, and no call depends
/// on what was evaluated last.
#[derive(Clone, Debug)]
pub struct Mechanics {
    /// Law, ground and cell.
    pub system: System,
    /// Approximate inverse of the Hessian.
    pub preconditioner: Preconditioner,
    /// Whether patterns can slide.
    pub slides: Slides,
    /// Symmetry of the surfaces that are solved, beside that of the system: forces and steps are
    /// projected onto it. A system that is not even has none.
    pub class: Class,
    /// Interrupts what is being solved.
    pub cancel: Cancel,
    pub(super) workspace: Workspace,
}

/// Amplitudes and mean of gamma'' at a surface: the derivatives of its forces and of its stress
/// with u0 at fixed amplitudes.
#[derive(Clone, Debug)]
pub struct Rates {
    /// Of the forces (E* per length).
    pub forces: Vec<f64>,
    /// Of the stress (E* per length).
    pub stress: f64,
}

/// Whether patterns can slide over the ground, which gives modes without stiffness that say nothing
/// about stability.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slides {
    /// Uneven ground holds them.
    Never,
    /// Flat ground under a fine mesh.
    Freely,
    /// Flat ground under a coarse mesh, which may pin them: where it does the modes are real and
    /// stay.
    UnlessPinned,
}

/// Stiffness of the preconditioner's diagonal as a share of that of the law's well: where patterns
/// are made of both contact and gap.
const SHARE: f64 = 0.25;
/// The same on the whole cell of uneven ground, most of which is out of contact.
const SHARE_UNEVEN: f64 = 0.04;
/// Sliding modes softer than this (E*/L, L the equivalent length of
/// [`Body`](crate::physics::body::Body)) are free; the flat state's softest mode has pi where
/// nothing attracts. With five times as much a line of 16 points at mu_rho = 0.75 shows one of its
/// 18 jumps of the mesh too few.
const PINNED: f64 = 0.02;
/// Share of the stiffness q1 of the longest wave below which a sliding mode, over the pattern it
/// moves, is no motion of the pattern: a ridge carries a trace of its softest modulation, whose
/// derivative is that modulation moved by a quarter wave; taken for a sliding mode it would hide
/// the coming instability.
const TRACE: f64 = 1e-3;

/// Stiffness k (E* per length) of the diagonal 1/(q E*/2 + k) of a system's preconditioner.
pub fn preconditioner_stiffness(system: &System) -> f64 {
    let law = system.law();
    let share = if system.is_flat() || system.is_even() {
        SHARE
    } else {
        SHARE_UNEVEN
    };
    law.at(law.equilibrium_gap()).stiffness * share
}

impl Mechanics {
    /// The mechanics of a system.
    pub fn new(system: System, slides: Slides) -> Self {
        let stiffness = preconditioner_stiffness(&system);
        Self::with_preconditioner(Preconditioner::new(&system, stiffness), system, slides)
    }

    /// The same with another preconditioner.
    pub fn with_preconditioner(
        preconditioner: Preconditioner,
        system: System,
        slides: Slides,
    ) -> Self {
        Self {
            workspace: system.workspace(),
            system,
            preconditioner,
            slides,
            class: Class::Even,
            cancel: Cancel::default(),
        }
    }

    /// The mechanics of one symmetry class of an even system, with an exact block of the waves no
    /// longer than `reach`.
    pub fn of_class(system: System, class: Class, reach: f64) -> Self {
        let stiffness = preconditioner_stiffness(&system);
        let preconditioner = Preconditioner::of_class(&system, stiffness, class, reach);
        Self {
            class,
            ..Self::with_preconditioner(preconditioner, system, Slides::Never)
        }
    }

    /// Transforms done so far.
    pub fn transforms(&self) -> usize {
        self.workspace.transforms
    }

    /// What `look` sees, as no part of the solution's cost.
    pub fn uncounted<T>(&mut self, look: impl FnOnce(&mut Self) -> T) -> T {
        let spent = self.workspace.transforms;
        let seen = look(self);
        self.workspace.transforms = spent;
        seen
    }

    /// The evaluation at amplitudes `z` where the control is `control`. Two transforms.
    pub fn at(&mut self, z: Vec<f64>, control: f64) -> Evaluation {
        let mut at = self.system.at(z, control, &mut self.workspace);
        self.class.project(&self.system, &mut at.gradient);
        at
    }

    /// All of `at` anew for its amplitudes and control, which were changed. Two
    /// transforms.
    pub fn update(&mut self, at: &mut Evaluation) {
        self.system.update(at, &mut self.workspace);
        self.class.project(&self.system, &mut at.gradient);
    }

    /// [`System::residual`]. One transform.
    pub fn residual(&mut self, at: &Evaluation) -> f64 {
        self.system.residual(at, &mut self.workspace)
    }

    /// The Hessian of a surface with these `fields` times `v`. Two transforms.
    pub fn hessian(&mut self, fields: &Fields, v: &[f64], out: &mut [f64]) {
        self.system.hessian(fields, v, out, &mut self.workspace);
    }

    /// [`System::stiffness_amplitudes`]. One transform.
    pub fn stiffness_amplitudes(&mut self, fields: &Fields, out: &mut [f64]) -> f64 {
        self.system
            .stiffness_amplitudes(fields, out, &mut self.workspace)
    }

    /// [`Mechanics::stiffness_amplitudes`] as the derivatives with u0. One transform.
    pub fn rates(&mut self, fields: &Fields) -> Rates {
        let mut forces = vec![0.0; self.system.dimension()];
        Rates {
            stress: self.stiffness_amplitudes(fields, &mut forces),
            forces,
        }
    }

    /// The derivative of the forces with the control at fixed amplitudes. One transform at most.
    pub fn push(&mut self, fields: &Fields) -> Vec<f64> {
        let mut push = vec![0.0; self.system.dimension()];
        match self.system.control() {
            Control::Displacement => {
                self.stiffness_amplitudes(fields, &mut push);
            }
            Control::Spring { .. } => push[0] = self.stiffness_amplitudes(fields, &mut push),
            Control::Load => push[0] = -1.0,
        }
        push
    }

    /// The preconditioner for the surface with these `fields`, of an even system from its `rates`
    /// without a transform; otherwise one.
    pub fn renew(&mut self, fields: &Fields, rates: &Rates) {
        match self.preconditioner.low_block_mut() {
            Some(block) => block.assemble(&self.system, &rates.forces, rates.stress),
            None => self.refresh(fields),
        }
    }

    /// The preconditioner for a surface with these `fields`. One transform.
    pub fn refresh(&mut self, fields: &Fields) {
        self.preconditioner
            .refresh(&self.system, fields, &mut self.workspace);
    }

    /// The gap field of amplitudes `z` at mean displacement `u0`. One transform.
    pub fn gap(&mut self, z: &[f64], u0: f64) -> Array2<f64> {
        let mut gap = Array2::zeros(self.system.shape());
        self.system.gap(z, u0, &mut gap, &mut self.workspace);
        gap
    }

    /// [`System::field`]. One transform.
    pub fn field(&mut self, v: &[f64]) -> &Array2<f64> {
        self.system.field(v, &mut self.workspace)
    }

    /// [`System::amplitudes`]. One transform.
    pub fn amplitudes(&mut self, field: &Array2<f64>) -> Vec<f64> {
        self.system.amplitudes(field, &mut self.workspace)
    }

    /// Solves H x = b for the Hessian H of a surface with these `fields`, in the complement of the
    /// orthonormal `removed` directions. Two transforms a product, or four where that takes fewer.
    pub fn solve_linear(
        &mut self,
        fields: &Fields,
        b: &[f64],
        removed: &[Vec<f64>],
        limits: CgLimits,
    ) -> CgSolution {
        let Self {
            system,
            preconditioner,
            workspace,
            class,
            cancel,
            ..
        } = self;
        let mut found = if removed.is_empty() && contact::pays(system, fields) {
            contact::solve((system, workspace), fields, b, limits, cancel)
        } else {
            conjugate_gradients(
                |v, out| system.hessian(fields, v, out, workspace),
                b,
                |r, out| preconditioner.apply(r, out),
                removed,
                limits,
                cancel,
            )
        };
        class.project(system, &mut found.x);
        found
    }

    /// Orthonormal basis of the directions in which the pattern `z` with these `fields` slides;
    /// none for a flat surface, one for a ridge.
    pub fn sliding_basis(&mut self, z: &[f64], fields: &Fields) -> Vec<Vec<f64>> {
        if self.slides == Slides::Never {
            return Vec::new();
        }
        let weakest = TRACE * self.system.grid().q1() * norm(z);
        let modes = self
            .system
            .sliding_modes(z)
            .into_iter()
            .filter(|m| norm(m) > weakest)
            .collect();
        let mut basis = orthonormalise(modes, 1e-6);
        if self.slides == Slides::UnlessPinned {
            let mut image = vec![0.0; z.len()];
            basis.retain(|mode| {
                self.hessian(fields, mode, &mut image);
                (dot(mode, &image) * self.system.equivalent_length()).abs() < PINNED
            });
        }
        basis
    }
}
