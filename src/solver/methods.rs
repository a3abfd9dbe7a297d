//! Every relaxation method: one row of the table `METHODS` each, and a variant of [`MethodKind`] to
//! name it by.

use super::descent::Descent;
use super::gfmd::{Gfmd, GfmdTuned};
use super::method::Method;
use super::newton::NewtonKrylov;
use serde::{Deserialize, Serialize};

/// Which relaxation method follows the branches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub enum MethodKind {
    /// Newton-Krylov with a predictor.
    #[default]
    NewtonKrylov,
    /// Limited-memory BFGS.
    Lbfgs,
    /// Nonlinear conjugate gradients.
    ConjugateGradients,
    /// Fast inertial relaxation.
    Fire,
    /// The paper's dynamics with tuned time step and damping, until it has relaxed.
    GfmdTuned,
    /// The paper's mass-weighted GFMD, 50 + 150 time steps per increment.
    Gfmd,
}

/// A method as it is offered.
struct Row {
    kind: MethodKind,
    /// The word of the command line and of tables.
    word: &'static str,
    /// Its name on the screen.
    title: &'static str,
    /// Fourier transforms of an increment of Fig. 2, roughly: what a chart reckons with before it
    /// has measured.
    transforms: f64,
    /// The method, its randomness seeded.
    build: fn(u64) -> Box<dyn Method>,
}

/// The methods in the order of lists and legends.
const METHODS: [Row; 6] = [
    Row {
        kind: MethodKind::NewtonKrylov,
        word: "newton",
        title: "Newton-Krylov",
        transforms: 60.0,
        build: |_| Box::new(NewtonKrylov),
    },
    Row {
        kind: MethodKind::Lbfgs,
        word: "lbfgs",
        title: "L-BFGS",
        transforms: 70.0,
        build: |_| Box::new(Descent::lbfgs()),
    },
    Row {
        kind: MethodKind::ConjugateGradients,
        word: "cg",
        title: "conjugate gradients",
        transforms: 60.0,
        build: |_| Box::new(Descent::conjugate()),
    },
    Row {
        kind: MethodKind::Fire,
        word: "fire",
        title: "FIRE",
        transforms: 110.0,
        build: |_| Box::new(Descent::fire()),
    },
    Row {
        kind: MethodKind::GfmdTuned,
        word: "gfmd_tuned",
        title: "GFMD, tuned",
        transforms: 150.0,
        build: |seed| Box::new(GfmdTuned::new(seed)),
    },
    Row {
        kind: MethodKind::Gfmd,
        word: "gfmd",
        title: "GFMD, as in the paper",
        transforms: 420.0,
        build: |seed| Box::new(Gfmd::new(seed)),
    },
];

impl MethodKind {
    /// Every method, in the order of lists and legends.
    pub const ALL: [Self; METHODS.len()] = {
        let mut all = [Self::NewtonKrylov; METHODS.len()];
        let mut i = 0;
        while i < all.len() {
            all[i] = METHODS[i].kind;
            i += 1;
        }
        all
    };

    /// Its place in [`Self::ALL`].
    pub fn index(self) -> usize {
        self as usize
    }

    /// The method, its randomness seeded.
    pub fn build(self, seed: u64) -> Box<dyn Method> {
        (METHODS[self.index()].build)(seed)
    }

    /// The word of the command line and of tables.
    pub fn word(self) -> &'static str {
        METHODS[self.index()].word
    }

    /// Its name on the screen.
    pub fn title(self) -> &'static str {
        METHODS[self.index()].title
    }

    /// Fourier transforms of an increment of Fig. 2, roughly.
    pub(crate) fn transforms(self) -> f64 {
        METHODS[self.index()].transforms
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_has_the_row_of_its_own_place() {
        for (i, kind) in MethodKind::ALL.into_iter().enumerate() {
            assert_eq!((kind.index(), METHODS[i].kind), (i, kind));
        }
    }
}
