//! The mechanical system: energy, residual and Hessian of an elastic body above an indenter, in
//! Fourier amplitudes.
//!
//! A displacement u = u0 + sum_{q != 0} u_q e^{iqr} is stored as **amplitudes** z: the half
//! spectrum of [`Fourier`] as pairs of reals, each times sqrt(w_q) with w_q = 2 where the mirrored
//! half is left out and 1 else. Then z.z = mean((u - u0)^2), and per area of the cell
//!
//! V = sum_q (q E*/4) z_q^2 + mean gamma(g),   dV/dz_q = (q E*/2) z_q + sqrt(w_q) FT[gamma'(g)]_q,
//! Hessian v -> (q E*/2) v + sqrt(w) FT[gamma''(g) v(r)],   mean stress = mean gamma'(g).
//!
//! That is a half-space; another [`Body`] has its own stiffness in place of q E*/2.
//!
//! A system of even fields, u(-x, y) = u(x, -y) = u(x, y), holds a quarter of the cell in cosine
//! waves; all sums and means are the same, and so is every function here but those that move a
//! pattern.
//!
//! The entry q = 0 of every amplitude vector is zero where the mean displacement u0 is the control.
//! Under a spring or a load ([`Control`]) it is an unknown like the others: u0 less the position of
//! the stage, with the spring's stiffness in place of q E*/2; or u0 itself, which nothing holds.

mod odd;

use super::body::Body;
use super::control::Control;
pub use super::control::{Evaluation, Fields, State};
use super::indenter::Indenter;
use super::law::Law;
use super::mesh::Grid;
use crate::numerics::cosine::Cosine;
use crate::numerics::dense::{max_abs, norm};
use crate::numerics::fourier::Fourier;
use crate::numerics::precision::{Basis, Precision, TransformScratch, Transforms};
use crate::numerics::threads::{each, piece};
use ndarray::Array2;
use rustfft::num_complex::Complex;

/// Body, law, ground and cell with their transforms. Immutable; working memory is a [`Workspace`].
#[derive(Clone, Debug)]
pub struct System {
    grid: Grid,
    body: Body,
    equivalent_length: f64,
    law: Law,
    height: Option<Array2<f64>>,
    /// Along which of x and y patterns can slide.
    uniform: [bool; 2],
    /// Along which of x and y fields are odd.
    odd: [bool; 2],
    transforms: Transforms,
    control: Control,
    /// The body's stiffness of every amplitude entry; for q = 0 that of a spring, or zero.
    elastic: Vec<f64>,
    /// Wave vector (q_x, q_y) of every amplitude pair; Nyquist components are zero, where the
    /// derivative of a real field vanishes. Empty for even fields, which cannot move.
    gradient: Vec<[f64; 2]>,
}

/// Working memory of one solver; what it holds between two calls means nothing.
#[derive(Clone, Debug)]
pub struct Workspace {
    /// Transforms done so far.
    pub transforms: usize,
    field: Array2<f64>,
    scratch: TransformScratch,
}

impl System {
    /// The system of a half-space with this law above an indenter.
    pub fn new(grid: Grid, law: Law, indenter: &Indenter) -> Self {
        let fourier = Fourier::new(grid.ny, grid.nx);
        let (m, ny) = fourier.spectrum_shape();
        let signed = |l: usize, n: usize| {
            if 2 * l > n {
                l as f64 - n as f64
            } else {
                l as f64
            }
        };
        let mut elastic = Vec::with_capacity(2 * m * ny);
        let mut gradient = Vec::with_capacity(m * ny);
        for k in 0..m {
            for l in 0..ny {
                let (qx, qy) = (grid.q1() * k as f64, grid.q1() * signed(l, ny));
                elastic.extend([qx.hypot(qy) / 2.0; 2]);
                gradient.push([
                    if 2 * k == grid.nx { 0.0 } else { qx },
                    if 2 * l == ny { 0.0 } else { qy },
                ]);
            }
        }
        Self {
            height: indenter.height(&grid),
            elastic,
            gradient,
            ..Self::by(Basis::Whole(fourier), grid, law, indenter)
        }
    }

    /// One with these transforms, without ground and elasticity.
    fn by(basis: Basis<f64>, grid: Grid, law: Law, indenter: &Indenter) -> Self {
        Self {
            grid,
            body: Body::HalfSpace,
            equivalent_length: grid.length,
            law,
            height: None,
            uniform: indenter.ground().is_uniform(),
            odd: [false; 2],
            transforms: Transforms::new(basis),
            control: Control::Displacement,
            elastic: Vec::new(),
            gradient: Vec::new(),
        }
    }

    /// The same for even fields only: a quarter of the cell `grid`, half of a line cell. The apex
    /// of a tip lies between points.
    ///
    /// # Panics
    /// Unless the cell's points along each side are a multiple of 4.
    pub fn even(grid: Grid, law: Law, indenter: &Indenter) -> Self {
        let (ny, nx) = (grid.ny.div_ceil(2), grid.nx / 2);
        let elastic = (0..nx * ny)
            .map(|i| grid.q1() * ((i / ny) as f64).hypot((i % ny) as f64) / 2.0)
            .collect();
        Self {
            height: indenter.even_height(&grid),
            elastic,
            ..Self::by(Basis::Even(Cosine::new(ny, nx)), grid, law, indenter)
        }
    }

    /// The whole cell of an even system under the same control: its ground unfolded, so that a tip's
    /// apex lies between points here too.
    pub fn whole(even: &System) -> Self {
        let height = even.height.as_ref().map(|height| even.unfolded(height));
        let flat = Self::new(even.grid, even.law, &Indenter::Flat).with_body(even.body);
        Self {
            height,
            uniform: even.uniform,
            ..flat.with_control(even.control)
        }
    }

    /// The same in another precision.
    pub fn with_precision(self, precision: Precision) -> Self {
        Self {
            transforms: self.transforms.with_precision(precision),
            ..self
        }
    }

    /// The same of another body than a half-space.
    pub fn with_body(mut self, body: Body) -> Self {
        debug_assert_eq!(
            self.body,
            Body::HalfSpace,
            "its waves are told by their stiffness"
        );
        let still = if self.is_even() { 1 } else { 2 };
        for e in &mut self.elastic[still..] {
            *e = body.elastic().stiffness(2.0 * *e);
        }
        self.equivalent_length = body.equivalent_length(&self.grid);
        self.body = body;
        self
    }

    /// The elastic body.
    pub fn body(&self) -> Body {
        self.body
    }

    /// [`Body::equivalent_length`] on this mesh (length): L of a half-space.
    pub fn equivalent_length(&self) -> f64 {
        self.equivalent_length
    }

    /// Twice the stiffness of the body's softest wave (E* per length), by which eigenvalues are
    /// measured: q1 of a half-space.
    pub fn stiffness_unit(&self) -> f64 {
        std::f64::consts::TAU / self.equivalent_length
    }

    /// The same driven otherwise than by its mean displacement.
    pub fn with_control(mut self, control: Control) -> Self {
        self.control = control;
        self.elastic[0] = Some(control.stiffness())
            .filter(|stiffness| stiffness.is_finite())
            .unwrap_or(0.0);
        self
    }

    /// What drives it.
    pub fn control(&self) -> Control {
        self.control
    }

    /// The entry q = 0 of amplitudes as a mean: zero where u0 is no unknown.
    fn mean(&self, v: &[f64]) -> f64 {
        if self.control.frees_mean() { v[0] } else { 0.0 }
    }

    /// Of which numbers its transforms and fields are.
    pub fn precision(&self) -> Precision {
        self.transforms.precision()
    }

    /// True if only even fields are represented.
    pub fn is_even(&self) -> bool {
        matches!(self.transforms.basis(), Basis::Even(_))
    }

    /// Shape (rows, columns) of a field: that of the grid, or of its even part.
    pub fn shape(&self) -> (usize, usize) {
        if self.is_even() {
            (self.grid.ny.div_ceil(2), self.grid.nx / 2)
        } else {
            self.grid.shape()
        }
    }

    /// The field of the whole cell: for an even system `field` with its mirror images, its own
    /// corner (0, 0) in the middle.
    pub fn unfolded(&self, field: &Array2<f64>) -> Array2<f64> {
        if !self.is_even() {
            return field.clone();
        }
        let mirrored = |i: usize, n: usize| if n == 1 { 0 } else { i.max(n - 1 - i) - n / 2 };
        let (ny, nx) = self.grid.shape();
        Array2::from_shape_fn((ny, nx), |(j, i)| field[[mirrored(j, ny), mirrored(i, nx)]])
    }

    /// Cell and mesh.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The cohesive law.
    pub fn law(&self) -> &Law {
        &self.law
    }

    /// Height of the indenter, `None` where it is flat.
    pub fn height(&self) -> Option<&Array2<f64>> {
        self.height.as_ref()
    }

    /// True over a flat indenter: then flat states are closed forms, and patterns can slide.
    pub fn is_flat(&self) -> bool {
        self.height.is_none()
    }

    /// Length of an amplitude vector.
    pub fn dimension(&self) -> usize {
        self.elastic.len()
    }

    /// Fresh working memory.
    pub fn workspace(&self) -> Workspace {
        Workspace {
            transforms: 0,
            field: Array2::zeros(self.shape()),
            scratch: self.transforms.scratch(self.shape()),
        }
    }

    /// The body's stiffness of every amplitude entry, q E*/2 of a half-space (E* per length); for
    /// q = 0 that of a spring, or zero.
    pub fn elastic(&self) -> &[f64] {
        &self.elastic
    }

    /// The body's softest wave, of norm 1; of equal ones the first along x.
    pub fn softest_wave(&self) -> Vec<f64> {
        let first = if self.is_even() { 1 } else { 2 };
        let along_x = (first * self.shape().0..self.dimension()).step_by(first * self.shape().0);
        let softest = along_x
            .chain(first..self.dimension())
            .min_by(|a, b| self.elastic[*a].total_cmp(&self.elastic[*b]));
        let mut wave = vec![0.0; self.dimension()];
        softest.into_iter().for_each(|i| wave[i] = 1.0);
        self.make_real(&mut wave);
        let length = norm(&wave);
        wave.iter_mut().for_each(|z| *z /= length);
        wave
    }

    /// The gap field of amplitudes `z` at mean displacement `u0` into `gap`. One transform.
    pub fn gap(&self, z: &[f64], u0: f64, gap: &mut Array2<f64>, ws: &mut Workspace) {
        self.transforms.synthesise(z, u0, gap, &mut ws.scratch);
        ws.transforms += 1;
        if let Some(height) = &self.height {
            *gap -= height;
        }
    }

    /// The gap field alone, for a picture: with working memory of its own, and not counted.
    pub fn gap_field(&self, z: &[f64], u0: f64) -> Array2<f64> {
        let mut gap = Array2::zeros(self.shape());
        let basis = self.transforms.basis();
        basis.synthesise(z, u0, &mut gap, &mut basis.scratch());
        if let Some(height) = &self.height {
            gap -= height;
        }
        gap
    }

    /// The evaluation at amplitudes `z` where the control is `control`. Two transforms.
    pub fn at(&self, z: Vec<f64>, control: f64, ws: &mut Workspace) -> Evaluation {
        let zeros = || Array2::zeros(self.shape());
        let gradient = vec![0.0; z.len()];
        let state = State {
            control,
            mean_displacement: f64::NAN,
            amplitudes: z,
            energy: f64::NAN,
            stress: f64::NAN,
        };
        let mut at = Evaluation {
            state,
            gradient,
            fields: Fields {
                gap: zeros(),
                traction: zeros(),
                stiffness: zeros(),
            },
        };
        self.update(&mut at, ws);
        at
    }

    /// The uniform surface at gap `u0` over flat ground, exact, with the control that holds it
    /// there. No transform.
    pub fn uniform(&self, u0: f64) -> Evaluation {
        let (z, response) = (vec![0.0; self.dimension()], self.law.at(u0));
        let gradient = z.clone();
        let everywhere = |value: f64| Array2::from_elem(self.shape(), value);
        let (gap, traction, stiffness) = (
            everywhere(u0),
            everywhere(response.traction),
            everywhere(response.stiffness),
        );
        let mut state = State {
            control: u0,
            mean_displacement: u0,
            amplitudes: z,
            energy: response.energy,
            stress: response.traction,
        };
        state.put_under(self.control);
        Evaluation {
            gradient,
            state,
            fields: Fields {
                gap,
                traction,
                stiffness,
            },
        }
    }

    /// All of `at` anew for its amplitudes and control, which were changed. Two transforms.
    pub fn update(&self, at: &mut Evaluation, ws: &mut Workspace) {
        let Evaluation {
            state,
            gradient,
            fields,
        } = at;
        state.mean_displacement = self
            .control
            .mean_displacement(state.control, state.amplitudes[0]);
        self.gap(
            &state.amplitudes,
            state.mean_displacement,
            &mut fields.gap,
            ws,
        );
        let (gap, traction, stiffness) = (
            flat(&mut fields.gap),
            flat(&mut fields.traction),
            flat(&mut fields.stiffness),
        );
        let points = gap.len() as f64;
        let adhesive = fill(&self.law, gap, traction, stiffness) / points;
        state.stress = self
            .transforms
            .analyse(&fields.traction, gradient, &mut ws.scratch);
        ws.transforms += 1;
        gradient[0] = match self.control {
            Control::Displacement => 0.0,
            Control::Spring { .. } => state.stress,
            Control::Load => state.stress - state.control,
        };
        let mut elastic = 0.0;
        for ((g, z), e) in gradient
            .iter_mut()
            .zip(&state.amplitudes)
            .zip(&self.elastic)
        {
            *g += e * z;
            elastic += e * z * z;
        }
        state.energy = 0.5 * elastic + adhesive;
        if self.control == Control::Load {
            state.energy -= state.control * state.mean_displacement;
        }
    }

    /// The Hessian of a surface with these `fields` times `v`. Two transforms.
    pub fn hessian(&self, fields: &Fields, v: &[f64], out: &mut [f64], ws: &mut Workspace) {
        let mean = self.transforms.multiply(
            (v, self.mean(v)),
            &fields.stiffness,
            out,
            &mut ws.field,
            &mut ws.scratch,
        );
        if self.control.frees_mean() {
            out[0] = mean;
        }
        ws.transforms += 2;
        for ((o, v), e) in out.iter_mut().zip(v).zip(&self.elastic) {
            *o += e * v;
        }
    }

    /// Amplitudes of the stiffness gamma'' into `out`, and its mean: the derivative of the gradient
    /// and of the stress with u0 at fixed amplitudes. One transform.
    pub fn stiffness_amplitudes(
        &self,
        fields: &Fields,
        out: &mut [f64],
        ws: &mut Workspace,
    ) -> f64 {
        ws.transforms += 1;
        self.transforms
            .analyse(&fields.stiffness, out, &mut ws.scratch)
    }

    /// Largest residual traction over the largest tractions that act: max |r| / max(sigma_max, max
    /// |gamma'|), with r the field of the gradient. In deep compression the second scale rules. NaN
    /// if anything is. One transform.
    pub fn residual(&self, at: &Evaluation, ws: &mut Workspace) -> f64 {
        self.field(&at.gradient, ws);
        let r = max_abs(flat(&mut ws.field));
        let t = at.fields.traction.as_slice().map_or(f64::NAN, max_abs);
        if t.is_nan() {
            t
        } else {
            r / self.law.traction_max().max(t)
        }
    }

    /// The real field of amplitudes `v`, its mean zero where u0 is no unknown. One transform.
    pub fn field<'w>(&self, v: &[f64], ws: &'w mut Workspace) -> &'w Array2<f64> {
        self.transforms
            .synthesise(v, self.mean(v), &mut ws.field, &mut ws.scratch);
        ws.transforms += 1;
        &ws.field
    }

    /// Amplitudes of a field; its mean is dropped where u0 is no unknown. One transform.
    pub fn amplitudes(&self, field: &Array2<f64>, ws: &mut Workspace) -> Vec<f64> {
        let mut z = vec![0.0; self.dimension()];
        let mean = self.transforms.analyse(field, &mut z, &mut ws.scratch);
        if self.control.frees_mean() {
            z[0] = mean;
        }
        ws.transforms += 1;
        z
    }

    /// Along which of x and y patterns can slide; even fields cannot.
    pub fn slides_along(&self) -> [bool; 2] {
        let fixed = self.is_even();
        [
            self.uniform[0] && !fixed,
            self.uniform[1] && !fixed && !self.grid.is_line(),
        ]
    }

    /// The sliding modes du/dx and du/dy of amplitudes `z`, not normalised, as far as the ground is
    /// uniform; those of even amplitudes are odd. No transform.
    pub fn sliding_modes(&self, z: &[f64]) -> Vec<Vec<f64>> {
        if self.odd != [false; 2] {
            return self.slide_of_even(z).into_iter().collect();
        }
        let along = self.slides_along();
        (0..2)
            .filter(|&axis| along[axis])
            .map(|axis| {
                let pairs = z.chunks_exact(2).zip(&self.gradient);
                pairs
                    .flat_map(|(z, q)| [-q[axis] * z[1], q[axis] * z[0]])
                    .collect()
            })
            .collect()
    }

    /// Amplitudes of the surface moved by (`dx`, `dy`) (lengths); even fields stay where they are.
    /// No transform.
    pub fn moved(&self, z: &[f64], dx: f64, dy: f64) -> Vec<f64> {
        if self.is_even() {
            return z.to_vec();
        }
        let pairs = z.chunks_exact(2).zip(&self.gradient);
        pairs
            .flat_map(|(z, q)| {
                let moved = Complex::new(z[0], z[1]) * Complex::cis(-(q[0] * dx + q[1] * dy));
                [moved.re, moved.im]
            })
            .collect()
    }

    /// Gives amplitudes the symmetry of a real field: u(-q) = conj u(q) where both halves are
    /// stored, real Nyquist terms, no mean where u0 is no unknown.
    pub fn make_real(&self, z: &mut [f64]) {
        z[0] = self.mean(z);
        if self.is_even() {
            return;
        }
        let ny = self.grid.ny;
        for k in [0, self.grid.nx / 2] {
            let row = &mut z[2 * k * ny..2 * (k + 1) * ny];
            for l in 0..=ny / 2 {
                let mirror = (ny - l) % ny;
                // The mean of both, so that this is a projection onto the nearest real field.
                let (re, im) = (
                    0.5 * (row[2 * l] + row[2 * mirror]),
                    0.5 * (row[2 * l + 1] - row[2 * mirror + 1]),
                );
                (row[2 * mirror], row[2 * mirror + 1]) = (re, -im);
                (row[2 * l], row[2 * l + 1]) = (re, im);
            }
        }
        z[1] = 0.0;
    }
}

/// Amplitudes carried from one system to another of the same cell, which is whole if the one is:
/// waves the other mesh lacks are dropped. A line becomes a square system's waves along x.
pub fn carried(z: &[f64], from: &System, to: &System) -> Vec<f64> {
    if from.is_even() && !to.is_even() {
        let (whole, gap) = (System::whole(from), from.gap_field(z, 0.0));
        let z = whole.amplitudes(&from.unfolded(&gap), &mut whole.workspace());
        return carried(&z, &whole, to);
    }
    let mut out = vec![0.0; to.dimension()];
    let ((ny, nx), (my, mx)) = (from.shape(), to.shape());
    if from.is_even() {
        for k in 0..nx.min(mx) {
            let rows = ny.min(my);
            out[k * my..k * my + rows].copy_from_slice(&z[k * ny..k * ny + rows]);
        }
        return out;
    }
    // Pairs of amplitudes with k from 0 and l of both signs; the shortest waves of the coarser mesh
    // are no waves of the finer one.
    let half = |n: usize, m: usize| {
        if n == m {
            n / 2 + 1
        } else {
            n.min(m).div_ceil(2)
        }
    };
    let (columns, rows) = (half(nx, mx), half(ny, my));
    for k in 0..columns {
        for l in 0..rows {
            for (i, o) in [(l, l), ((ny - l) % ny, (my - l) % my)] {
                let (i, o) = (2 * (k * ny + i), 2 * (k * my + o));
                out[o..o + 2].copy_from_slice(&z[i..i + 2]);
            }
        }
    }
    out
}

fn flat<T>(array: &mut Array2<T>) -> &mut [T] {
    array.as_slice_mut().expect("standard layout")
}

/// Traction and stiffness of every gap, and the sum of the energies: on several threads where that
/// pays, always in the same order.
fn fill(law: &Law, gap: &[f64], traction: &mut [f64], stiffness: &mut [f64]) -> f64 {
    let piece = piece(gap.len());
    let mut sums = vec![0.0; gap.len().div_ceil(piece)];
    let tasks = gap
        .chunks(piece)
        .zip(traction.chunks_mut(piece))
        .zip(stiffness.chunks_mut(piece))
        .zip(&mut sums);
    each(tasks, |(((gap, traction), stiffness), sum)| {
        *sum = law.fill(gap, traction, stiffness);
    });
    sums.iter().sum()
}
