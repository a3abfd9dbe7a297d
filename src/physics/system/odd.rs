//! Modes that are odd over the even patterns of a system, on the quarter of the cell that holds the
//! patterns.
//!
//! **What is odd along an axis is no softer than what is even along it**, on a half-space: of the two
//! fields with the same values on the quarter the odd one has no less energy. They are weighed by the
//! same gamma''; so are they by the squares of their wave numbers along the other axis. Of the squares
//! along this one, y, the matrices between points y_i = (i + 1/2) pi/m of the quarter differ by
//! (-1)^(i+j)/sin^2((y_i + y_j)/2). By the reflection of the trigamma function 1/sin^2 is the integral
//! of e^(-st) and e^(-(pi-s)t) with a positive weight, so that this is positive semidefinite. The
//! stiffness q E*/2 is the root of the sum of squares, and roots keep the order (K. Loewner, Math. Z.
//! 38, 177 (1934)).
//!
//! Modes that are odd both ways are thus no softer than those that are odd one way. Those that are odd
//! one way are no softer than the even ones, of which the mean is one: where the mean displacement is
//! held this says something of fields without a mean on the quarter alone.

use super::{Body, Control, System, Workspace};
use ndarray::Array2;

impl System {
    /// Modes over the even patterns of an `even` system that are odd along x, y or both: only their
    /// [`System::hessian`] has a meaning, with the fields of the pattern.
    ///
    /// On m points sin(pi k (j + 1/2)/m) is (-1)^j cos(pi (m - k)(j + 1/2)/m), and the sign goes
    /// through the product with gamma'': the amplitude of a sine of k waves is stored as that of
    /// the cosine of m - k, and nothing is new but the body's stiffness.
    pub fn odd(even: &System, odd: [bool; 2]) -> Self {
        let (ny, nx) = even.shape();
        let waves = |i: usize, n: usize, odd| (if odd { n - i } else { i }) as f64;
        let mut system = Self {
            odd,
            ..even.clone()
        };
        for (i, elastic) in system.elastic.iter_mut().enumerate() {
            let waves = waves(i / ny, nx, odd[0]).hypot(waves(i % ny, ny, odd[1]));
            *elastic = even.body.elastic().stiffness(even.grid.q1() * waves);
        }
        // The first amplitude is a wave like the others, not the mean.
        system.control = Control::Spring {
            stiffness: system.elastic[0],
        };
        system
    }

    /// Along which of x and y fields are odd.
    pub fn is_odd(&self) -> [bool; 2] {
        self.odd
    }

    /// True if a mode that is odd along an axis has no less energy than the even one with the same
    /// values on the quarter: see above.
    pub fn orders_modes(&self) -> bool {
        self.body == Body::HalfSpace
    }

    /// Amplitudes of the field that is one all over the quarter. One transform.
    pub fn quarter(&self, ws: &mut Workspace) -> Vec<f64> {
        let sign = |i: usize, odd: bool| if odd && i % 2 == 1 { -1.0 } else { 1.0 };
        let [x, y] = self.odd;
        let ones = Array2::from_shape_fn(self.shape(), |(j, i)| sign(i, x) * sign(j, y));
        self.amplitudes(&ones, ws)
    }

    /// The mode in which the even pattern of amplitudes `z` slides, if it is among these modes and
    /// the ground is uniform.
    pub(super) fn slide_of_even(&self, z: &[f64]) -> Option<Vec<f64>> {
        let axis = (0..2).find(|&axis| self.odd[axis] && !self.odd[1 - axis])?;
        let (ny, nx) = self.shape();
        // No cosine has as many waves as the sine that is stored first.
        let slide = |i: usize| {
            let (mut place, m) = ([i / ny, i % ny], [nx, ny][axis]);
            let waves = m - place[axis];
            place[axis] = waves % m;
            let amplitude = if waves < m {
                z[place[0] * ny + place[1]]
            } else {
                0.0
            };
            self.grid.q1() * waves as f64 * amplitude
        };
        self.uniform[axis].then(|| (0..z.len()).map(slide).collect())
    }
}
