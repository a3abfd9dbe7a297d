//! Why a surface snapped, in a sentence with the numbers of its criterion, and what is ahead of one
//! that has not yet.
//!
//! Stiffnesses are told in units of E*/L, lengths in ranges. A flat surface gives way where the law
//! softens faster than the body, or the machine, resists (Eq. 8); a pattern where its branch turns
//! back (a fold), or where a disturbance of another symmetry has no stiffness left.

use super::forecast::told;
use crate::follow::flat_branch::FlatBranch;
use crate::follow::record::{Cause, Direction, JumpRecord};
use crate::numerics::fourier::Fourier;
use crate::physics::body::Body;
use crate::physics::control::Control;
use crate::physics::mesh;
use crate::physics::parameter::Dimension;
use crate::physics::pattern::{Island, Pattern, rolled, shift_to_middle};
use crate::scene::parameter::fixed;
use crate::scene::{Model, Scene};
use ndarray::{Array2, ArrayView2, Axis};
use rustfft::num_complex::Complex;
use std::f64::consts::PI;

/// What resists the law at the limit of the flat state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holder {
    /// The longest wave of a half-space.
    LongestWave,
    /// The softest wave of a layer.
    SoftestWave,
    /// The spring, or the layer as one: the body moves as a block.
    Spring,
    /// Nothing: a load follows.
    Nothing,
}

/// What was lost where a surface gave way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Criterion {
    /// gamma'' and the stiffness that resists it add up to nothing (both in E*/L).
    Flat {
        /// gamma'' at the limit.
        law: f64,
        /// What resists.
        holder: Holder,
        /// How stiffly.
        held: f64,
    },
    /// The branch turns back.
    Fold,
    /// A disturbance of this shape has no stiffness left, on a branch that goes on.
    Symmetry(Shape),
    /// The mesh held the edge of the contact.
    Mesh,
    /// Nothing: one pattern goes over into the other.
    Continuous,
    /// Not known: the method does not locate it.
    Unlocated,
    /// None: the surface was pressed by hand.
    Pushed,
}

/// Why a surface snapped.
#[derive(Clone, Debug, PartialEq)]
pub struct Explanation {
    /// The criterion with its numbers.
    pub criterion: Criterion,
    /// Waves of the soft mode along x and y of the cell, where it is known.
    pub wave: Option<[usize; 2]>,
    /// What held against the soft mode just before, and what drove it, where it is known.
    pub balance: Option<Balance>,
    /// All of it in words.
    pub sentence: String,
}

/// What is known of a jump.
#[derive(Clone, Copy, Debug)]
pub struct Evidence<'a> {
    /// The jump.
    pub jump: &'a JumpRecord,
    /// The gap of the last state before it (length), and the mode that went soft; shape (ny, nx).
    pub fields: Option<[&'a Array2<f64>; 2]>,
}

/// Why the surface of this scene snapped.
pub fn explain(scene: &Scene, model: &Model, of: Evidence<'_>) -> Explanation {
    let wave = of.fields.map(|[_, mode]| dominant_wave(mode));
    let criterion = match of.jump.cause {
        Cause::FlatLimit => flat_criterion(scene, model, of.jump.mean_displacement),
        Cause::Fold => Criterion::Fold,
        Cause::SymmetryBreaking => Criterion::Symmetry(
            of.fields
                .map_or(Shape::Other, |[gap, mode]| shape(of.jump.from, gap, mode)),
        ),
        Cause::Mesh => Criterion::Mesh,
        Cause::Transition => Criterion::Continuous,
        Cause::PatternChange => Criterion::Unlocated,
        Cause::Push => Criterion::Pushed,
    };
    let control = scene.control();
    let balance = of
        .fields
        .map(|[gap, mode]| balance(model, control, gap, mode));
    let words = Words {
        scene,
        model,
        of,
        balance,
    };
    let mut sentence = match criterion {
        Criterion::Flat { law, holder, held } => words.flat(law, holder, held),
        Criterion::Fold => words.fold(),
        Criterion::Symmetry(shape) => words.symmetry(shape, wave),
        Criterion::Mesh => words.mesh(),
        Criterion::Continuous => words.continuous(),
        Criterion::Unlocated => words.unlocated(),
        Criterion::Pushed => words.pushed(),
    };
    if let Some(contested) = of.jump.contested_words() {
        sentence += &format!(
            " Two waves go soft together, and their mixture decides where it lands; {contested}."
        );
    }
    Explanation {
        criterion,
        wave,
        balance,
        sentence,
    }
}

/// The two sides of Eq. 8 at gap `u0`.
fn flat_criterion(scene: &Scene, model: &Model, u0: f64) -> Criterion {
    let (length, control) = (model.grid.length, scene.control());
    let branch = FlatBranch::new(model.law, model.equivalent_length, control);
    let (holder, held) = match control {
        Control::Load => (Holder::Nothing, 0.0),
        _ if branch.gives_way_as_a_block() => (Holder::Spring, length * control.stiffness()),
        _ => {
            let wave = if model.body == Body::HalfSpace {
                Holder::LongestWave
            } else {
                Holder::SoftestWave
            };
            (wave, PI * length / model.equivalent_length)
        }
    };
    Criterion::Flat {
        law: length * model.law.at(u0).stiffness,
        holder,
        held,
    }
}

/// The sentences.
struct Words<'a> {
    scene: &'a Scene,
    model: &'a Model,
    of: Evidence<'a>,
    balance: Option<Balance>,
}

impl Words<'_> {
    /// "Below" or "Above", as the drive goes.
    fn side(&self) -> &'static str {
        match self.of.jump.direction {
            Direction::Approach => "Below",
            Direction::Retraction => "Above",
        }
    }

    /// Where it happened.
    fn place(&self) -> String {
        match self.scene.control() {
            Control::Displacement => {
                let ranges = self.of.jump.mean_displacement / self.model.law.range;
                self.model.unit(Dimension::Length).say(ranges, 3, "ranges")
            }
            control => told(control, self.of.jump.control, self.model, 3),
        }
    }

    /// What gave way, with its article.
    fn pattern(&self) -> String {
        match self.of.jump.from {
            Pattern::Flat => "the flat surface".to_owned(),
            Pattern::Other => "the surface".to_owned(),
            pattern => format!("the {pattern}"),
        }
    }

    /// The two sides of the criterion, where they are known.
    fn sides(&self) -> String {
        self.balance
            .map_or_else(String::new, |Balance { body, law }| {
                let who = if self.scene.control().frees_mean() {
                    "body and machine give"
                } else {
                    "the body gives"
                };
                format!(
                    ": just before, {who} {}, the law {} (E*/L)",
                    minus(body, 2),
                    minus(law, 2)
                )
            })
    }

    fn flat(&self, law: f64, holder: Holder, held: f64) -> String {
        let faster = match self.of.jump.direction {
            Direction::Approach => "grows faster with depth",
            Direction::Retraction => "falls off faster with distance",
        };
        let at = self.of.jump.mean_displacement / self.model.law.range;
        let at = self.model.unit(Dimension::Length).say(at, 3, "ranges");
        let (resists, sum) = match holder {
            Holder::LongestWave => ("the longest wave of the cell can resist", "γ″ + πE*/L"),
            Holder::SoftestWave => ("the softest wave of the layer can resist", "γ″ + S"),
            Holder::Spring if self.scene.drive.control == self.scene.control() => (
                "the spring can resist, and the body gives way as a block",
                "γ″ + k",
            ),
            Holder::Spring => (
                "layer and machine can resist, and the surface gives way as a block",
                "γ″ + k",
            ),
            Holder::Nothing => {
                let change = match self.of.jump.direction {
                    Direction::Approach => "grows with depth",
                    Direction::Retraction => "falls off with distance",
                };
                return format!(
                    "{} {at} the pull {change} while the load stays what it is: the body gives \
                     way as a block, γ″ < 0 (at the limit {} E*/L).",
                    self.side(),
                    minus(law, 4)
                );
            }
        };
        format!(
            "{} {at} the pull {faster} than {resists}: {sum} < 0 (at the limit {} + \
             {}, in E*/L).",
            self.side(),
            minus(law, 4),
            minus(held, 4),
        )
    }

    fn fold(&self) -> String {
        format!(
            "{} {} {} has no equilibrium left: its branch turns back there (a fold), where nothing \
             holds it any more{}.",
            self.side(),
            self.place(),
            self.pattern(),
            self.sides()
        )
    }

    fn symmetry(&self, shape: Shape, wave: Option<[usize; 2]>) -> String {
        let length = self.model.grid.length / self.model.law.range;
        let across = self.model.unit_across();
        let what = match shape {
            Shape::BreakUp { waves } => format!(
                "a wave along it, {} long, that makes it thick and thin in turn",
                across.say(length / waves as f64, 1, "ranges")
            ),
            Shape::Meander { waves } => format!(
                "a wave along it, {} long, that moves it to and fro",
                across.say(length / waves as f64, 1, "ranges")
            ),
            Shape::Stretching => {
                "a disturbance that makes it longer along one axis and shorter along the other"
                    .to_owned()
            }
            Shape::Other => wave.map_or_else(
                || "a disturbance of another symmetry".to_owned(),
                |[x, y]| format!("a disturbance of another symmetry ({x} × {y} waves to the cell)"),
            ),
        };
        let end = match shape {
            Shape::BreakUp { .. } => ", and it breaks up",
            Shape::Meander { .. } => ", and it meanders",
            _ => "",
        };
        format!(
            "{} {} {} would go on, but nothing holds it against {what}{end}{}.",
            self.side(),
            self.place(),
            self.pattern(),
            self.sides()
        )
    }

    fn mesh(&self) -> String {
        let Model { grid, law, .. } = self.model;
        let across = self.model.unit_across();
        let points = mesh::points_for_mu_rho(law, grid.length, mesh::SAFE).ceil();
        format!(
            "The mesh lies: the edge of the contact moved on by one spacing, {}, which a \
             mesh of μᵨ = {:.2} had held back. With {points:.0} points a side (μᵨ = {}) there is no \
             such jump.",
            across.say(grid.spacing() / law.range, 2, "ranges"),
            self.model.mu_rho,
            mesh::SAFE
        )
    }

    fn continuous(&self) -> String {
        format!(
            "Nothing snapped: at {} {} passes into {} by and by, and nothing is lost.",
            self.place(),
            self.pattern(),
            match self.of.jump.to {
                Pattern::Flat => "the flat surface".to_owned(),
                to => format!("a {to}"),
            }
        )
    }

    fn unlocated(&self) -> String {
        format!(
            "Before {} it was {}, now it is {}. This method does not look for the place where a \
             state gives way, nor why; Newton-Krylov does.",
            self.place(),
            self.of.jump.from,
            self.of.jump.to
        )
    }

    fn pushed(&self) -> String {
        format!(
            "At {} nothing gave way by itself: the {} was pressed by hand over the barrier, and came \
             to rest as {}.",
            self.place(),
            self.of.jump.from,
            self.of.jump.to
        )
    }
}

/// A number with so many decimals and a minus sign that is none of a hyphen.
fn minus(value: f64, digits: usize) -> String {
    fixed(value, digits).replace('-', "−")
}

/// What a disturbance of another symmetry does to a pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// Makes a ridge thick and thin in turn, so many times along the cell.
    BreakUp {
        /// How often.
        waves: usize,
    },
    /// Moves a ridge to and fro, so many times along the cell.
    Meander {
        /// How often.
        waves: usize,
    },
    /// Makes a round pattern longer along one axis and shorter along the other.
    Stretching,
    /// Anything else.
    Other,
}

/// Share of a mode that must change its sign under the exchange of the axes to be a stretching.
const ODD: f64 = 0.5;

/// What resists a mode and what drives it, as in Eq. 8: they add up to its eigenvalue (E*/L).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Balance {
    /// Stiffness of the body, and of the machine where the mode moves the mean.
    pub body: f64,
    /// gamma'' where the mode moves the surface, weighted with its square.
    pub law: f64,
}

/// The amplitudes of a field, as [`Fourier`] lays them out.
fn spectrum(field: &Array2<f64>) -> Array2<Complex<f64>> {
    let (ny, nx) = field.dim();
    let fourier: Fourier = Fourier::with_lanes(ny, nx, 1);
    let mut spectrum = fourier.spectrum();
    let field = field.as_standard_layout().into_owned();
    fourier.forward(&field, &mut spectrum, &mut fourier.scratch());
    spectrum
}

/// The wave of the largest amplitude in a field of shape (ny, nx): how often it fits into the cell
/// along x and along y. Zero both ways is the mean.
pub fn dominant_wave(field: &Array2<f64>) -> [usize; 2] {
    let ny = field.nrows();
    let spectrum = spectrum(field);
    let largest = spectrum
        .indexed_iter()
        .max_by(|a, b| a.1.norm_sqr().total_cmp(&b.1.norm_sqr()));
    largest.map_or([0, 0], |((x, y), _)| [x, y.min(ny - y)])
}

/// What holds against a `mode` of the state of this `gap`, and what drives it.
fn balance(model: &Model, control: Control, gap: &Array2<f64>, mode: &Array2<f64>) -> Balance {
    let (ny, nx) = mode.dim();
    let body = model.body.elastic();
    let (mut all, mut held) = (0.0, 0.0);
    for ((x, y), amplitude) in spectrum(mode).indexed_iter() {
        let periods = (x as f64).hypot(y.min(ny - y) as f64);
        let stiffness = if periods == 0.0 {
            control.stiffness()
        } else {
            body.stiffness(periods * model.grid.q1())
        };
        // The half that is left out is the mirror image of what is there.
        let twice = if x == 0 || 2 * x == nx { 1.0 } else { 2.0 };
        let weight = twice * amplitude.norm_sqr();
        all += weight;
        // Nothing moves against a machine that does not give.
        if stiffness.is_finite() {
            held += weight * stiffness;
        }
    }
    let moved = gap.iter().zip(mode);
    let moved = moved.map(|(g, m)| m * m * model.law.at(*g).stiffness);
    let length = model.grid.length;
    Balance {
        body: length * held / all,
        law: length * moved.sum::<f64>() / mode.iter().map(|m| m * m).sum::<f64>(),
    }
}

/// What a `mode` does to the pattern of this `gap`.
fn shape(pattern: Pattern, gap: &Array2<f64>, mode: &Array2<f64>) -> Shape {
    match pattern {
        Pattern::Ridge if gap.nrows() > 1 => ridge(gap, mode),
        Pattern::Bulge | Pattern::Dimple
            if gap.is_square() && is_stretching(pattern, gap, mode) =>
        {
            Shape::Stretching
        }
        _ => Shape::Other,
    }
}

fn ridge(gap: &Array2<f64>, mode: &Array2<f64>) -> Shape {
    let across_x = spread(gap, Axis(0)) >= spread(gap, Axis(1));
    let [x, y] = dominant_wave(mode);
    let waves = if across_x { y } else { x };
    if waves == 0 {
        return Shape::Other;
    }
    let parity = if across_x {
        parity(gap.view(), mode.view())
    } else {
        parity(gap.t(), mode.t())
    };
    if parity > 0.0 {
        Shape::BreakUp { waves }
    } else {
        Shape::Meander { waves }
    }
}

/// How much the mean of a field over an axis varies along the other.
fn spread(field: &Array2<f64>, axis: Axis) -> f64 {
    field
        .mean_axis(axis)
        .map_or(0.0, |profile| profile.std(0.0))
}

/// Whether a mode is even (1) or odd (-1) under the reflection across a ridge that runs along the
/// rows' axis.
fn parity(gap: ArrayView2<'_, f64>, mode: ArrayView2<'_, f64>) -> f64 {
    let nx = gap.ncols();
    let Some(profile) = gap.mean_axis(Axis(0)) else {
        return 0.0;
    };
    let mirrored = |about: usize, i: usize| (about + nx - i) % nx;
    // Twice the middle of the ridge, which may lie between two points.
    let even = |about: &usize| -> f64 {
        (0..nx)
            .map(|i| profile[i] * profile[mirrored(*about, i)])
            .sum()
    };
    let about = (0..nx)
        .max_by(|a, b| even(a).total_cmp(&even(b)))
        .unwrap_or(0);
    let both = mode.indexed_iter();
    let both = both.map(|((j, i), v)| v * mode[(j, mirrored(about, i))]);
    both.sum::<f64>() / mode.iter().map(|v| v * v).sum::<f64>()
}

/// Whether a mode changes its sign when x and y are exchanged about the middle of the pattern.
fn is_stretching(pattern: Pattern, gap: &Array2<f64>, mode: &Array2<f64>) -> bool {
    let island = if pattern == Pattern::Dimple {
        Island::Hole
    } else {
        Island::Contact
    };
    let (dy, dx) = shift_to_middle(gap, island);
    let mode = rolled(mode, dy, dx);
    let exchanged = (&mode * &mode.t()).sum();
    exchanged < -ODD * mode.iter().map(|v| v * v).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const N: usize = 32;

    fn field(f: impl Fn(f64, f64) -> f64) -> Array2<f64> {
        Array2::from_shape_fn((N, N), |(j, i)| {
            f(TAU * i as f64 / N as f64, TAU * j as f64 / N as f64)
        })
    }

    #[test]
    fn the_dominant_wave_is_counted_along_x_and_along_y_whatever_its_sign() {
        let wave = field(|x, y| (3.0 * x - 5.0 * y).cos() + 0.3 * x.sin());
        assert_eq!(dominant_wave(&wave), [3, 5]);
        assert_eq!(dominant_wave(&field(|_, y| y.sin())), [0, 1]);
        assert_eq!(dominant_wave(&field(|x, _| 2.0 + x.cos())), [0, 0]);
        let line = Array2::from_shape_fn((1, N), |(_, i)| (TAU * 2.0 * i as f64 / N as f64).sin());
        assert_eq!(dominant_wave(&line), [2, 0]);
    }

    #[test]
    fn a_ridge_breaks_up_by_an_even_wave_along_it_and_meanders_by_an_odd_one() {
        for middle in [0.0, 1.3, 4.0] {
            let gap = field(|x, _| 3.0 - (x - middle).cos());
            let broken = field(|x, y| (1.0 + 0.5 * (x - middle).cos()) * (2.0 * y).cos());
            let moved = field(|x, y| (x - middle).sin() * y.cos());
            let across = field(|x, _| (x - middle).sin());
            let turned = |field: &Array2<f64>| field.t().as_standard_layout().into_owned();
            for (mode, wanted) in [
                (broken, Shape::BreakUp { waves: 2 }),
                (moved, Shape::Meander { waves: 1 }),
                (across, Shape::Other),
            ] {
                assert_eq!(shape(Pattern::Ridge, &gap, &mode), wanted, "{middle}");
                let turned = shape(Pattern::Ridge, &turned(&gap), &turned(&mode));
                assert_eq!(turned, wanted, "{middle}");
            }
        }
    }

    #[test]
    fn a_bulge_is_stretched_by_what_is_odd_under_the_exchange_of_its_axes() {
        let at = TAU / N as f64 * 5.0;
        let gap = field(|x, y| 3.0 - (x - at).cos() - (y - 2.0 * at).cos());
        let odd = field(|x, y| (x - at).cos() - (y - 2.0 * at).cos());
        let even = field(|x, y| (x - at).cos() + (y - 2.0 * at).cos());
        assert_eq!(shape(Pattern::Bulge, &gap, &odd), Shape::Stretching);
        assert_eq!(shape(Pattern::Bulge, &gap, &even), Shape::Other);
    }
}
