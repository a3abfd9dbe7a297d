//! Modes that are odd over the even patterns of a system, on the quarter of the cell that holds the
//! patterns.
//!
//! **What is odd both ways is no softer than what is odd one way**, on a half-space. A mode and the one
//! with the same values on the quarter that is even along y are weighed by the same gamma''; so are
//! they by the squares of their wave numbers along x. Of the squares along y the matrices between
//! points y_i = (i + 1/2) pi/m of the quarter differ by (-1)^(i+j)/sin^2((y_i + y_j)/2). By the
//! reflection of the trigamma function 1/sin^2 is the integral of e^(-st) and e^(-(pi-s)t) with a
//! positive weight, so that this is positive semidefinite. The stiffness q E*/2 is the root of the sum
//! of squares, and roots keep the order (K. Loewner, Math. Z. 38, 177 (1934)).

use super::{Body, Control, System};

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

    /// True if the softest mode that is odd along x and y is no softer than the softest one that is
    /// odd along one of them: see above. (Where patterns slide that one has no stiffness.)
    pub fn orders_odd_modes(&self) -> bool {
        self.body == Body::HalfSpace && !self.uniform[0] && !self.uniform[1]
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
