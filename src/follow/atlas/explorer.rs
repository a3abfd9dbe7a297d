//! Where a surface comes to rest when its branch ends: a release on a quarter cell, to learn which
//! pattern it is.

use crate::follow::contest::{FLAT_KICK, KICK, angle, tried};
use crate::numerics::dense::{add, norm, scale};
use crate::physics::control::Control;
use crate::physics::pattern::{Pattern, classify};
use crate::physics::system::{Evaluation, State, System};
use crate::solver::mechanics::{Mechanics, Slides};
use crate::solver::release::{Release, Slice};

/// Residual at which a fall ends: next to a saddle forces are small too.
const TOLERANCE: f64 = 1e-6;
/// Share of the amplitude below which a symmetry counts as kept.
const TRACE: f64 = 2e-2;
/// Time steps of a fall after which is asked whether the body has come apart.
const SLICE: usize = 500;

/// Where a surface came to rest.
#[derive(Clone, Debug)]
pub struct Rest {
    /// u0 (length).
    pub mean_displacement: f64,
    /// What it is.
    pub form: Form,
}

/// A form in which a surface can rest, by its symmetry.
#[derive(Clone, Debug)]
pub enum Form {
    /// The flat state.
    Flat,
    /// A ridge; amplitudes of the quarter cell, waves along x only.
    Ridge(Vec<f64>),
    /// A bulge or dimple; amplitudes of the quarter cell, x <-> y symmetric.
    Square(Pattern, Vec<f64>),
    /// Anything else.
    Other,
}

impl Rest {
    /// Its pattern.
    pub fn pattern(&self) -> Pattern {
        match &self.form {
            Form::Flat => Pattern::Flat,
            Form::Ridge(_) => Pattern::Ridge,
            Form::Square(pattern, _) => *pattern,
            Form::Other => Pattern::Other,
        }
    }
}

/// A quarter cell for releases.
#[derive(Clone, Debug)]
pub struct Explorer {
    /// A request to cancel it interrupts a fall.
    pub mechanics: Mechanics,
}

impl Explorer {
    /// Of an even square `system` on flat ground.
    pub fn new(system: System) -> Self {
        Self {
            mechanics: Mechanics::new(system, Slides::Never),
        }
    }

    /// Its mechanics.
    pub fn system(&self) -> &System {
        &self.mechanics.system
    }

    /// Where the flat state of gap `u0` comes to rest from each mixture of its soft modes, the
    /// first waves along x and y.
    pub fn off_flat(&mut self, u0: f64) -> Vec<Rest> {
        let flat = self.system().uniform(u0).state;
        let ny = self.system().shape().0;
        let from = |mixture: usize| {
            let mut mode = vec![0.0; flat.amplitudes.len()];
            (mode[1], mode[ny]) = angle(mixture).sin_cos();
            self.kicked(&flat.amplitudes, &mode, FLAT_KICK, flat.control)
        };
        tried(from, |a, b| a.pattern() == b.pattern())
    }

    /// Kicks the state `z` along the `mode`, to the side on which the energy is lower, and lets it
    /// fall at a fixed `control`.
    pub fn release(&mut self, z: &[f64], mode: &[f64], control: f64) -> Rest {
        self.kicked(z, mode, KICK, control)
    }

    fn kicked(&mut self, z: &[f64], mode: &[f64], kick: f64, control: f64) -> Rest {
        let size = kick * self.system().law().range / norm(mode);
        let mut side = |sign: f64| {
            let mut moved = z.to_vec();
            add(&mut moved, sign * size, mode);
            self.mechanics.at(moved, control)
        };
        let (one, other) = (side(1.0), side(-1.0));
        let start = if other.state.energy < one.state.energy {
            other
        } else {
            one
        };
        self.mechanics.preconditioner.forget();
        self.fall(start)
    }

    /// Down to the next minimum at fixed control by the walk's own release.
    fn fall(&mut self, start: Evaluation) -> Rest {
        let mut release = Release::new(start).with_tolerance(TOLERANCE);
        loop {
            let slice = release.advance(&mut self.mechanics, SLICE);
            let (system, u0) = (self.system(), release.at.state.mean_displacement);
            match slice {
                Slice::Moving if system.control().is_apart(system.law(), u0) => {
                    return Rest {
                        mean_displacement: Control::stop(system.law()),
                        form: Form::Flat,
                    };
                }
                Slice::Moving => {}
                Slice::Settled(found) => {
                    let State {
                        amplitudes,
                        mean_displacement,
                        ..
                    } = found.at.state;
                    return Rest {
                        mean_displacement,
                        form: self.recognise(amplitudes, mean_displacement),
                    };
                }
                Slice::Stuck | Slice::Cancelled => {
                    return Rest {
                        mean_displacement: u0,
                        form: Form::Other,
                    };
                }
            }
        }
    }

    /// Which symmetry a state has, in its normal position: centre in the corner, ridges along y.
    fn recognise(&mut self, mut z: Vec<f64>, u0: f64) -> Form {
        z[0] = 0.0;
        let size = norm(&z);
        if size < 0.02 * self.system().law().range {
            return Form::Flat;
        }
        let n = self.system().shape().0;
        let along_x: f64 = (1..n).map(|k| z[k * n].powi(2)).sum();
        let along_y: f64 = (1..n).map(|l| z[l].powi(2)).sum();
        if along_y > along_x {
            transpose(&mut z, n);
        }
        // Moved by half a cell, every wave with an odd number of periods changes its sign.
        let (flip_x, flip_y) = (z[n] < 0.0, z[1] < 0.0);
        for (i, z) in z.iter_mut().enumerate() {
            if flip_x && (i / n) % 2 == 1 {
                *z = -*z;
            }
            if flip_y && (i % n) % 2 == 1 {
                *z = -*z;
            }
        }
        let mut line = vec![0.0; z.len()];
        (0..n).for_each(|k| line[k * n] = z[k * n]);
        if (size * size - norm(&line).powi(2)).max(0.0).sqrt() < TRACE * size {
            return Form::Ridge(line);
        }
        let mut other = z.clone();
        transpose(&mut other, n);
        let mut odd = z.clone();
        add(&mut odd, -1.0, &other);
        if norm(&odd) > 2.0 * TRACE * size {
            return Form::Other;
        }
        add(&mut z, 1.0, &other);
        scale(&mut z, 0.5);
        match pattern_of(&mut self.mechanics, &z, u0) {
            pattern @ (Pattern::Bulge | Pattern::Dimple) => Form::Square(pattern, z),
            _ => Form::Other,
        }
    }
}

/// The pattern of amplitudes of a quarter cell on flat ground.
pub fn pattern_of(mechanics: &mut Mechanics, z: &[f64], u0: f64) -> Pattern {
    let gap = mechanics.gap(z, u0);
    let system = &mechanics.system;
    classify(system.unfolded(&gap).view(), system.law(), true)
}

fn transpose(z: &mut [f64], n: usize) {
    for k in 0..n {
        for l in 0..k {
            z.swap(k * n + l, l * n + k);
        }
    }
}
