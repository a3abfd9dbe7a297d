//! Why a surface snapped, in a sentence with the numbers of its criterion, and what is ahead of one
//! that has not yet.
//!
//! Stiffnesses are told in units of E*/L, lengths in ranges. A flat surface gives way where the law
//! softens faster than the body, or the machine, resists (Eq. 8); a pattern where its branch turns
//! back (a fold), or where a disturbance of another symmetry has no stiffness left.

mod mode;

pub use mode::{Balance, Shape, dominant_wave};

use super::forecast::forecast;
use crate::follow::flat_branch::FlatBranch;
use crate::follow::record::{Cause, Direction, JumpRecord, LoopRecord};
use crate::physics::body::Body;
use crate::physics::control::Control;
use crate::physics::indenter::Indenter;
use crate::physics::mesh_rule;
use crate::physics::parameter::Dimension;
use crate::physics::pattern::Pattern;
use crate::physics::theory::flat;
use crate::scene::units::fixed;
use crate::scene::{Model, Scene, window};
use ndarray::Array2;
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
        Cause::SymmetryBreaking => {
            Criterion::Symmetry(of.fields.map_or(Shape::Other, |[gap, mode]| {
                mode::shape(of.jump.from, gap, mode)
            }))
        }
        Cause::Mesh => Criterion::Mesh,
        Cause::Transition => Criterion::Continuous,
        Cause::PatternChange => Criterion::Unlocated,
        Cause::Push => Criterion::Pushed,
    };
    let control = scene.control();
    let balance = of
        .fields
        .map(|[gap, mode]| mode::balance(model, control, gap, mode));
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
        let points = mesh_rule::points_for_mu_rho(law, grid.length, mesh_rule::SAFE).ceil();
        format!(
            "The mesh lies: the edge of the contact moved on by one spacing, {}, which a \
             mesh of μᵨ = {:.2} had held back. With {points:.0} points a side (μᵨ = {}) there is no \
             such jump.",
            across.say(grid.spacing() / law.range, 2, "ranges"),
            self.model.mu_rho,
            mesh_rule::SAFE
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

/// What is driven at this value: "u₀ = 3.102 ρ".
fn told(control: Control, value: f64, model: &Model, digits: usize) -> String {
    let (natural, word, of) = match control {
        Control::Load => (model.law.traction_max(), "σₘₐₓ", Dimension::Stress),
        _ => (model.law.range, "ρ", Dimension::Length),
    };
    let value = model.unit(of).say(value / natural, digits, word);
    format!("{} = {}", control.symbol(), value.replace('-', "−"))
}

/// Why nothing can snap in a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Calm {
    /// What to change.
    pub remedy: &'static str,
    /// The reason with its numbers.
    pub reason: String,
}

/// Why nothing can snap in this scene; `None` where something can, or nobody knows.
pub fn calm(scene: &Scene, model: &Model) -> Option<Calm> {
    let branch = FlatBranch::new(model.law, model.equivalent_length, scene.control());
    if model.indenter != Indenter::Flat || branch.limits().is_some() {
        return None;
    }
    let rho = model.law.range;
    let across = model.unit_across();
    let (remedy, what) = if model.body == Body::HalfSpace {
        ("Make the cell longer.", "The cell has")
    } else {
        (
            "Make the layer thicker.",
            "The softest wave of the layer is that of a cell of",
        )
    };
    Some(Calm {
        remedy,
        reason: format!(
            "{what} {}, and below L_c = {} every wave is stiffer than the law is soft.",
            across.say(model.equivalent_length / rho, 1, "ranges"),
            across.say(flat::critical_length(&model.law) / rho, 1, "ranges")
        ),
    })
}

/// What can happen next, in words; nothing of a record without a state.
pub fn ahead(scene: &Scene, model: &Model, record: &LoopRecord) -> String {
    if let Some(calm) = calm(scene, model) {
        return format!("Here nothing snaps. {} {}", calm.remedy, calm.reason);
    }
    let control = scene.control();
    let Some(now) = record.states.last() else {
        return String::new();
    };
    let way = match now.direction {
        Direction::Approach => "down",
        Direction::Retraction => "up",
    };
    let Some(ahead) = forecast(record, model) else {
        return match model.indenter {
            Indenter::Flat => format!("No jump is near on the way {way}."),
            _ => "Where it snaps shows when it comes near: there its stiffness falls to zero."
                .to_owned(),
        };
    };
    let (low, high) = window::of_control(scene, model);
    let (near, far) = (
        ahead.nearest.min(ahead.farthest),
        ahead.nearest.max(ahead.farthest),
    );
    if high < near || far < low {
        return format!(
            "It would snap at {}, beyond the end of the drive.",
            told(control, ahead.nearest, model, 3)
        );
    }
    if near == far {
        return format!(
            "It snaps at {} on the way {way}: there the flat surface gives way.",
            told(control, near, model, 4)
        );
    }
    format!(
        "The next jump on the way {way} is between {} and {}.",
        told(control, near, model, 3),
        told(control, far, model, 3)
    )
}
