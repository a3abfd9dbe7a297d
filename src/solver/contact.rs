//! Linear solves over uneven ground, where the surface is pressed in one place and free in another.
//!
//! The Hessian is H = K + D: K is diagonal in waves, D = gamma'' in points. An inverse that is
//! diagonal in waves serves where D is small, which it is off the contact; in contact gamma'' is
//! tens to hundreds of times the stiffness of long waves, and grows as the range shrinks with the
//! mesh. With D+ = max(D, 0) the approximate inverse is
//!
//! M = S (K + c)^-1 S + S' (D+ + k)^-1,  S^2 = c/(c + D+),  S' = 1 - S^2:
//!
//! off the contact the elastic body, in contact the law's stiffness alone, point by point. The
//! iteration is of fields, and a product takes four transforms in place of two, but their number
//! hardly grows with the mesh. In a prototype on the whole cell, without blocks of long waves, the
//! Newton steps of a state over the tip at mu_rho = 0.5 took 12, 14 and 18 products at n = 128, 256
//! and 512, with a diagonal in waves 34, 55 and 87; at mu_rho = 1.5 and n = 128 3 and 19.

use crate::numerics::krylov::{CgLimits, CgSolution, conjugate_gradients};
use crate::numerics::threads::Cancel;
use crate::physics::system::{Fields, System, Workspace};
use ndarray::Array2;

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
pub(super) fn pays(system: &System, fields: &Fields) -> bool {
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

/// As [`Mechanics::solve_linear`](super::mechanics::Mechanics::solve_linear), nothing removed. Four
/// transforms a product.
pub(super) fn solve(
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
        let found = solve((system, &mut ws), fields, &b, limits, &Cancel::default());
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
            assert!(pays(&system, &fields));
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
