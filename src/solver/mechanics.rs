//! The mechanics at hand: a system with all that solving it takes, so that nobody carries the
//! pieces one by one.
//!
//! Linear solves over uneven ground, where the surface is pressed in one place and free in another,
//! have an approximate inverse of their own. The Hessian is H = K + D: K is diagonal in waves, D =
//! gamma'' in points. An inverse that is diagonal in waves serves where D is small, which it is off
//! the contact; in contact gamma'' is tens to hundreds of times the stiffness of long waves, and
//! grows as the range shrinks with the mesh. With D+ = max(D, 0) the approximate inverse is
//!
//! M = S (K + c)^-1 S + S' (D+ + k)^-1,  S^2 = c/(c + D+),  S' = 1 - S^2:
//!
//! off the contact the elastic body, in contact the law's stiffness alone, point by point. The
//! iteration is of fields, and a product takes four transforms in place of two, but their number
//! hardly grows with the mesh. In a prototype on the whole cell, without blocks of long waves, the
//! Newton steps of a state over the tip at mu_rho = 0.5 took 12, 14 and 18 products at n = 128, 256
//! and 512, with a diagonal in waves 34, 55 and 87; at mu_rho = 1.5 and n = 128 3 and 19.

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

    /// [`System::stiffness_amplitudes`] as the derivatives with u0. One transform.
    pub fn rates(&mut self, fields: &Fields) -> Rates {
        let mut forces = vec![0.0; self.system.dimension()];
        let ws = &mut self.workspace;
        let stress = self.system.stiffness_amplitudes(fields, &mut forces, ws);
        Rates { forces, stress }
    }

    /// The derivative of the forces with the control at fixed amplitudes. One transform at most.
    pub fn push(&mut self, fields: &Fields) -> Vec<f64> {
        let control = self.system.control();
        if control == Control::Load {
            let mut push = vec![0.0; self.system.dimension()];
            push[0] = -1.0;
            return push;
        }
        let Rates { mut forces, stress } = self.rates(fields);
        if control.frees_mean() {
            forces[0] = stress;
        }
        forces
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
        let mut found = if removed.is_empty() && contact_pays(system, fields) {
            solve_in_points((system, workspace), fields, b, limits, cancel)
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

/// `z` moved by less than a mesh spacing so that the pattern's centre lies, along each axis, on a
/// mesh point or `between` two. There the mesh's own weak pinning vanishes by symmetry; elsewhere
/// it would keep the residual from converging.
pub fn centred(system: &System, z: &[f64], between: [bool; 2]) -> Vec<f64> {
    let half = between.map(|between| if between { 0.5 } else { 0.0 });
    placed(system, z, |axis, x0| (x0 - half[axis]).round() + half[axis])
}

/// `z` moved to the nearest such place of all.
pub(super) fn held(system: &System, z: &[f64]) -> Vec<f64> {
    placed(system, z, |_, x0| 0.5 * (2.0 * x0).round())
}

/// `z` moved along each axis from where its centre lies (mesh spacings) to where that is wanted.
fn placed(system: &System, z: &[f64], wanted: impl Fn(usize, f64) -> f64) -> Vec<f64> {
    let grid = system.grid();
    let slides = system.slides_along();
    let shift = |axis: usize, pair: usize| {
        let (re, im) = (z[2 * pair], z[2 * pair + 1]);
        if !slides[axis] || re.hypot(im) < 1e-3 * norm(z) {
            return 0.0;
        }
        // u_q ~ e^{-i q x0}: the pattern's centre (or anti-centre) is x0.
        let x0 = -im.atan2(re) / grid.q1() / grid.spacing();
        (wanted(axis, x0) - x0) * grid.spacing()
    };
    system.moved(z, shift(0, grid.ny), shift(1, 1))
}

/// Stiffness c off the contact over that of the mesh's shortest wave: from .003 to .03 a solve takes
/// as many products.
const OFF_CONTACT: f64 = 0.01;
/// Stiffness k of points in contact over the same: three times as much costs a sixth more.
const IN_CONTACT: f64 = 1.0;
/// Stiffest point over the softest wave from which on this inverse pays for its transforms. From 30
/// to 150 two loops over tips cost the same to 3 %, that at mu_rho = 0.7 and n = 64 a tenth more at
/// 150; at mu_rho = 0.5 the share is 51, 97 and 185 at n = 64, 128 and 256.
const PAYS: f64 = 80.0;

/// Whether a surface with these `fields` is so stiff somewhere that this inverse pays.
fn contact_pays(system: &System, fields: &Fields) -> bool {
    let stiffest = fields.stiffness.fold(0.0, |most: f64, k| most.max(*k));
    !system.is_flat() && stiffest > PAYS * ends(system)[0]
}

/// The stiffness of the softest wave and of the stiffest (E* per length).
fn ends(system: &System) -> [f64; 2] {
    // The first entries are those of the mean, which a spring may hold as softly as it likes.
    let mean = if system.is_even() { 1 } else { 2 };
    let waves = system.elastic()[mean..].iter().copied();
    waves.fold([f64::INFINITY, 0.0], |[low, high], e| {
        [low.min(e), high.max(e)]
    })
}

/// As [`Mechanics::solve_linear`], nothing removed. Four
/// transforms a product.
fn solve_in_points(
    (system, workspace): (&System, &mut Workspace),
    fields: &Fields,
    b: &[f64],
    limits: CgLimits,
    cancel: &Cancel,
) -> CgSolution {
    let stiffness = flat(&fields.stiffness);
    let [c, k] = [OFF_CONTACT, IN_CONTACT].map(|share| share * ends(system)[1]);
    let body: Vec<f64> = system.elastic().iter().map(|e| 1.0 / (e + c)).collect();
    let of = |what: fn([f64; 3]) -> f64| -> Vec<f64> {
        stiffness.iter().map(|d| what([d.max(0.0), c, k])).collect()
    };
    let share = of(|[d, c, _]| (c / (c + d)).sqrt());
    let local = of(|[d, c, k]| d / (c + d) / (d + k));
    // The norm of amplitudes is a root mean square.
    let norm = (stiffness.len() as f64).sqrt();
    let rhs: Vec<f64> = flat(system.field(b, workspace))
        .iter()
        .map(|f| f / norm)
        .collect();
    let (mut elastic, mut inverse) = (Filter::new(system), Filter::new(system));
    let hessian = |v: &[f64], out: &mut [f64]| {
        let forces = elastic.applied(system.elastic(), v.iter().copied());
        for (((o, f), d), v) in out.iter_mut().zip(forces).zip(stiffness).zip(v) {
            *o = f + d * v;
        }
        centre(system, out);
    };
    let approximate_inverse = |r: &[f64], out: &mut [f64]| {
        let moved = inverse.applied(&body, r.iter().zip(&share).map(|(r, s)| r * s));
        let points = moved.iter().zip(&share).zip(&local);
        for ((o, r), ((m, s), l)) in out.iter_mut().zip(r).zip(points) {
            *o = s * m + l * r;
        }
        centre(system, out);
    };
    let CgSolution { mut x, end } =
        conjugate_gradients(hessian, &rhs, approximate_inverse, &[], limits, cancel);
    workspace.transforms += elastic.workspace.transforms + inverse.workspace.transforms;
    x.iter_mut().for_each(|x| *x *= norm);
    let field = Array2::from_shape_vec(system.shape(), x).expect("a value a point");
    CgSolution {
        x: system.amplitudes(&field, workspace),
        end,
    }
}

/// Takes the mean off where it is no unknown.
fn centre(system: &System, field: &mut [f64]) {
    if !system.control().frees_mean() {
        let mean = field.iter().sum::<f64>() / field.len() as f64;
        field.iter_mut().for_each(|f| *f -= mean);
    }
}

fn flat(field: &Array2<f64>) -> &[f64] {
    field.as_slice().expect("fields are contiguous")
}

/// Fields with each wave multiplied by a factor.
struct Filter<'a> {
    system: &'a System,
    workspace: Workspace,
    field: Array2<f64>,
}

impl<'a> Filter<'a> {
    fn new(system: &'a System) -> Self {
        Self {
            workspace: system.workspace(),
            field: Array2::zeros(system.shape()),
            system,
        }
    }

    /// The field with these `values` after that. Two transforms.
    fn applied(&mut self, factors: &[f64], values: impl Iterator<Item = f64>) -> &[f64] {
        self.field.iter_mut().zip(values).for_each(|(f, v)| *f = v);
        let mut waves = self.system.amplitudes(&self.field, &mut self.workspace);
        waves.iter_mut().zip(factors).for_each(|(w, f)| *w *= f);
        flat(self.system.field(&waves, &mut self.workspace))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::dense::{add, norm};
    use crate::numerics::krylov::CgEnd;
    use crate::physics::control::Control;
    use crate::physics::indenter::{Hertz, Indenter};
    use crate::physics::law::{Law, Morse, Shape};
    use crate::physics::mesh::Grid;

    /// A cell with a disc of contact in its middle, as much stiffer as the spacing is finer, and a
    /// little softness around it.
    fn pressed(make: fn(Grid, Law, &Indenter) -> System, n: usize) -> (System, Fields) {
        let law = Law {
            shape: Shape::Morse(Morse),
            surface_energy: 1e-3,
            range: 1e-3,
        };
        let tip = Indenter::Hertz(Hertz { radius: 1.0 });
        let system = make(Grid::square(1.0, n), law, &tip);
        // The heights tell how far from the middle a point is.
        let apart = system.gap_field(&vec![0.0; system.dimension()], 0.0);
        let nearest = apart.fold(f64::INFINITY, |least, g| g.min(least));
        let stiffness = apart.mapv(|g| {
            if g - nearest < 0.02 {
                40.0 * n as f64
            } else {
                -0.5
            }
        });
        let (gap, traction) = (apart, Array2::zeros(system.shape()));
        let fields = Fields {
            gap,
            traction,
            stiffness,
        };
        (system, fields)
    }

    /// Solves to a millionth for the push of u0; the residual over the right-hand side, and products.
    fn solved(system: &System, fields: &Fields) -> (f64, usize) {
        let mut ws = system.workspace();
        let mut b = vec![0.0; system.dimension()];
        let mean = system.stiffness_amplitudes(fields, &mut b, &mut ws);
        b[0] = if system.control().frees_mean() {
            mean
        } else {
            0.0
        };
        let before = ws.transforms;
        let limits = CgLimits::new(1e-6, 500);
        let found = solve_in_points((system, &mut ws), fields, &b, limits, &Cancel::default());
        let products = (ws.transforms - before) / 4;
        assert_eq!(found.end, CgEnd::Converged);
        let mut left = vec![0.0; b.len()];
        system.hessian(fields, &found.x, &mut left, &mut ws);
        add(&mut left, -1.0, &b);
        (norm(&left) / norm(&b), products)
    }

    #[test]
    fn what_is_solved_point_by_point_is_solved_wave_by_wave() {
        for make in [System::new, System::even] {
            let (system, fields) = pressed(make, 32);
            assert!(contact_pays(&system, &fields));
            for control in [Control::Displacement, Control::Spring { stiffness: 2.0 }] {
                let system = system.clone().with_control(control);
                let (left, _) = solved(&system, &fields);
                assert!(left < 1.001e-6, "{control:?}: {left:.1e}");
            }
        }
    }

    #[test]
    fn products_hardly_grow_with_the_mesh() {
        let [coarse, fine] = [32, 128].map(|n| {
            let (system, fields) = pressed(System::even, n);
            solved(&system, &fields).1
        });
        // Square roots of ratios of stiffness, which a diagonal in waves leaves, double.
        assert!(fine * 10 < coarse * 16, "{coarse} {fine}");
    }
}
