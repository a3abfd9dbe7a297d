//! Cohesive laws: interaction energy gamma(g) per area against the gap g.
//!
//! Each law is a dimensionless form f(x) with x = g/rho and min f = -1; [`Law`] scales it: gamma(g)
//! = gamma f(g/rho), traction gamma' = (gamma/rho) f', stiffness gamma'' = (gamma/rho^2) f''.
//! Traction is positive where the surfaces attract. A new law is one file with a [`Form`] and an
//! [`Own`], its `mod` and its line in `kinds!`.

mod cosine;
mod double_exponential;
mod mie;
mod morse;

use super::parameter::{Own, Parameter, Refusal, Value, kinds};

/// A dimensionless cohesive law f(x), x = g/rho, with min f = -1.
pub trait Form {
    /// f, f' and f'' at x. Not finite where the law is not defined (a Mie law at x <= 0).
    fn at(&self, x: f64) -> [f64; 3];

    /// f in a line of text, of g and rho, as diagrams have formulas.
    fn formula(&self) -> String;

    /// Gap x and value of the largest traction, max f'.
    fn strongest(&self) -> (f64, f64);

    /// Gap x and value of the largest negative stiffness, max(-f''). Where f'' jumps (the cosine's
    /// cut-off) the one-sided limit.
    fn softest(&self) -> (f64, f64);

    /// Gap x of the minimum, f = -1 and f' = 0. Between here and [`Form::softest`] f'' falls
    /// steadily from above to below zero.
    fn equilibrium(&self) -> f64 {
        0.0
    }

    /// True if f'' is continuous: then a fine mesh does not pin patterns.
    fn is_smooth(&self) -> bool {
        true
    }

    /// f' and f'' of every gap g (in lengths, x = g/range) into the two of `out`; returns the
    /// sum of f. Each is multiplied by its `scale`, that of f first.
    ///
    /// One pass over the field; laws made of exponentials replace it by a vectorised kernel.
    fn fill(&self, gap: &[f64], range: f64, scale: [f64; 3], out: [&mut [f64]; 2]) -> f64 {
        fill_by_point(self, gap, range, scale, out)
    }
}

/// [`Form::fill`] by [`Form::at`], gap by gap.
fn fill_by_point(
    form: &(impl Form + ?Sized),
    gap: &[f64],
    range: f64,
    scale: [f64; 3],
    [first, second]: [&mut [f64]; 2],
) -> f64 {
    let mut sum = 0.0;
    for ((g, d1), d2) in gap.iter().zip(first).zip(second) {
        let [f, f1, f2] = form.at(g / range);
        sum += f;
        *d1 = scale[1] * f1;
        *d2 = scale[2] * f2;
    }
    scale[0] * sum
}

kinds! {
    /// Which law, with the parameters that only it has.
    #[derive(Clone, Copy, Debug, PartialEq)]
    Shape: form -> Form []
    morse::Morse = "morse",
    mie::Mie = "mie",
    cosine::Cosine = "cosine",
    double_exponential::DoubleExponential = "double_exponential"
}

/// A cohesive law with its scales.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    /// The dimensionless form.
    pub shape: Shape,
    /// Work of adhesion gamma per area (units of E* times length).
    pub surface_energy: f64,
    /// Range rho (for the cosine law its cut-off g_c), a length.
    pub range: f64,
}

/// Energy, traction and stiffness of a law at one gap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response {
    /// gamma(g), energy per area.
    pub energy: f64,
    /// gamma'(g), positive in tension.
    pub traction: f64,
    /// gamma''(g).
    pub stiffness: f64,
}

impl Law {
    /// Energy, traction and stiffness at gap `g` (length). All NaN where the law is not defined (a
    /// Mie law at g <= 0).
    pub fn at(&self, g: f64) -> Response {
        let [f, f1, f2] = self.shape.form().at(g / self.range);
        let (gamma, rho) = (self.surface_energy, self.range);
        Response {
            energy: gamma * f,
            traction: gamma / rho * f1,
            stiffness: gamma / (rho * rho) * f2,
        }
    }

    /// Traction and stiffness of every gap, in one pass; returns the sum of the energies gamma(g).
    pub fn fill(&self, gap: &[f64], traction: &mut [f64], stiffness: &mut [f64]) -> f64 {
        let (gamma, rho) = (self.surface_energy, self.range);
        let scale = [gamma, gamma / rho, gamma / (rho * rho)];
        let out = [traction, stiffness];
        self.shape.form().fill(gap, rho, scale, out)
    }

    /// True if the stiffness is a continuous function of the gap.
    pub fn is_smooth(&self) -> bool {
        self.shape.form().is_smooth()
    }

    /// Largest tensile traction sigma_max (E*).
    pub fn traction_max(&self) -> f64 {
        self.surface_energy / self.range * self.shape.form().strongest().1
    }

    /// Gap of the largest traction (length); a point with a smaller gap counts as contact.
    pub fn contact_gap(&self) -> f64 {
        self.range * self.shape.form().strongest().0
    }

    /// Gap of the minimum of the energy: gamma(g) = -surface_energy, no traction (0, for a Mie law
    /// its range).
    pub fn equilibrium_gap(&self) -> f64 {
        self.range * self.shape.form().equilibrium()
    }

    /// Largest negative stiffness max(-gamma''). For the cosine law the limit at its cut-off from
    /// inside.
    pub fn softening_max(&self) -> f64 {
        self.surface_energy / (self.range * self.range) * self.shape.form().softest().1
    }

    /// Gap of the largest negative stiffness (length).
    pub fn softest_gap(&self) -> f64 {
        self.range * self.shape.form().softest().0
    }
}
