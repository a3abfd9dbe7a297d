//! What a lesson knows of the model: its numbers by name, and the conditions that end a task.

use crate::follow::record::{Direction, LoopRecord, StateRecord};
use crate::physics::control::Control;
use crate::physics::theory::{flat, ridge};
use crate::scene::units::fixed;
use crate::scene::{Model, Scene};
use crate::solver::Stop;
use serde::Deserialize;
use std::collections::BTreeMap;

/// What the model shows now.
#[derive(Clone, Copy, Debug)]
pub struct Facts<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// What it was decided to be.
    pub model: &'a Model,
    /// The path so far.
    pub record: &'a LoopRecord,
    /// What a closed loop lost (gamma).
    pub loss: Option<f64>,
}

/// A condition on the model.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(rename_all = "snake_case")]
pub enum Condition {
    /// The present pattern, by its word.
    Pattern(String),
    /// On approach it jumped from this pattern.
    Jumped(String),
    /// On retraction it jumped from this pattern.
    JumpedBack(String),
    /// So many jumps belong to the mesh, or more.
    MeshJumps(usize),
    /// u0 is below so many ranges.
    Below(f64),
    /// A loop is closed.
    LoopClosed(bool),
    /// mu_rho is above.
    MuRhoAbove(f64),
    /// The cell is longer than so many ranges.
    LengthAbove(f64),
    /// The present state is stable, or is not.
    Stable(bool),
    /// The machine, by its word: displacement, spring or load.
    Machine(String),
}

impl Condition {
    /// True if it holds.
    pub fn holds(&self, facts: &Facts<'_>) -> bool {
        let now = facts.now();
        let jumped = |from: &str, direction: Direction| {
            let this = |pattern: &str| pattern == from;
            let mut jumps = facts.record.jumps.iter();
            jumps.any(|jump| jump.direction == direction && this(jump.from.word()))
        };
        match self {
            Self::Pattern(word) => now.is_some_and(|now| now.pattern.word() == word),
            Self::Jumped(from) => jumped(from, Direction::Approach),
            Self::JumpedBack(from) => jumped(from, Direction::Retraction),
            Self::MeshJumps(least) => facts.record.tally().of_the_mesh >= *least,
            Self::Below(ranges) => u0(facts).is_some_and(|u0| u0 < *ranges),
            Self::LoopClosed(closed) => facts.loss.is_some() == *closed,
            Self::MuRhoAbove(mu_rho) => facts.model.mu_rho > *mu_rho,
            Self::LengthAbove(ranges) => facts.length() > *ranges,
            Self::Stable(stable) => now.is_some_and(|now| (now.stop == Stop::Stable) == *stable),
            Self::Machine(word) => facts.scene.drive.control.word() == word,
        }
    }
}

/// A number that a text may have in it.
struct Number {
    name: &'static str,
    decimals: usize,
    of: fn(&Facts<'_>) -> Option<f64>,
}

const fn number(name: &'static str, decimals: usize, of: fn(&Facts<'_>) -> Option<f64>) -> Number {
    Number { name, decimals, of }
}

/// The numbers by name: lengths in ranges, energies in gamma, stiffnesses in E*/L.
const NUMBERS: [Number; 19] = [
    number("u0", 2, u0),
    number("first_jump", 3, |f| f.jump(Direction::Approach, 0)),
    number("last_jump", 3, |f| f.jump(Direction::Approach, -1)),
    number("first_jump_back", 3, |f| f.jump(Direction::Retraction, 0)),
    number("last_jump_back", 3, |f| f.jump(Direction::Retraction, -1)),
    number("first_release", 4, |f| {
        f.record.jumps.first().map(|jump| jump.released_energy)
    }),
    number("released", 4, |f| Some(f.record.released_energy_sum())),
    number("loss", 4, |f| f.loss),
    number("loss_percent", 0, |f| Some(100.0 * f.loss?)),
    number("jumps", 0, |f| Some(f.record.tally().jumps as f64)),
    number("mesh_jumps", 0, |f| {
        Some(f.record.tally().of_the_mesh as f64)
    }),
    number("mu_rho", 2, |f| Some(f.model.mu_rho)),
    number("flat_limit", 3, |f| f.limit(1)),
    number("flat_limit_back", 3, |f| f.limit(0)),
    number("stiffness", 2, |f| Some(f.now()?.stiffness_min)),
    // Of the flat state at the present u0, whatever the surface does.
    number("flat_stiffness", 2, |f| {
        let (law, length) = (&f.model.law, f.model.equivalent_length);
        Some(flat::stiffness_min(law, length, f.now()?.mean_displacement))
    }),
    number("length", 0, |f| Some(f.length())),
    number("critical_length", 1, |f| {
        Some(flat::critical_length(&f.model.law) / f.model.law.range)
    }),
    number("zero_range_loss", 3, |_| {
        Some(ridge::zero_range_dissipation())
    }),
];

/// The present u0 in ranges.
fn u0(facts: &Facts<'_>) -> Option<f64> {
    Some(facts.now()?.mean_displacement / facts.model.law.range)
}

impl Facts<'_> {
    /// The newest state.
    pub fn now(&self) -> Option<&StateRecord> {
        self.record.states.last()
    }

    /// The length of the cell in ranges.
    fn length(&self) -> f64 {
        self.model.grid.length / self.model.law.range
    }

    /// u0 of the first (0) or last (-1) jump of the physics in this direction.
    fn jump(&self, direction: Direction, which: isize) -> Option<f64> {
        let mut jumps = self
            .record
            .jumps
            .iter()
            .filter(|jump| jump.direction == direction);
        let jump = if which == 0 {
            jumps.next()
        } else {
            jumps.next_back()
        };
        Some(jump?.mean_displacement / self.model.law.range)
    }

    /// The lower (0) or upper (1) limit of the flat state, where u0 is held.
    fn limit(&self, which: usize) -> Option<f64> {
        if self.scene.control() != Control::Displacement {
            return None;
        }
        let (lower, upper) = flat::limits(&self.model.law, self.model.equivalent_length)?;
        Some([lower, upper][which] / self.model.law.range)
    }

    /// The number of this name.
    pub fn number(&self, name: &str) -> Option<f64> {
        let known = NUMBERS.iter().find(|number| number.name == name);
        known.and_then(|number| (number.of)(self))
    }

    /// All that is known, as it is written in a text.
    pub fn words(&self) -> BTreeMap<String, String> {
        let value = |number: &Number| {
            let value = (number.of)(self).filter(|value| value.is_finite())?;
            Some((number.name.to_owned(), fixed(value, number.decimals)))
        };
        let pattern = self.now().map(|now| now.pattern.word().to_owned());
        let pattern = pattern.map(|word| ("pattern".to_owned(), word));
        NUMBERS.iter().filter_map(value).chain(pattern).collect()
    }
}
