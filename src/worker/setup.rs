//! On which part of the cell the window's walk runs: what the plan says, what the user overrules,
//! and the whole cell where a part is not enough.

use super::protocol::{ModelChoice, Stored};
use crate::follow::walk::{Stuck, Walk, WalkOptions, Widened};
use crate::numerics::cancel::Cancel;
use crate::physics::parameter::Refusal;
use crate::scene::part::{Part, Strategy};
use crate::scene::{Model, Scene};
use crate::solver::methods::MethodKind;
use crate::study::plan::plan;
use std::sync::Arc;

/// A scene with the way it is computed.
#[derive(Clone, Debug)]
pub(super) struct Setup {
    /// The scene.
    pub scene: Arc<Scene>,
    method: MethodKind,
    /// The model in use.
    pub choice: ModelChoice,
}

impl Setup {
    /// Decides how the scene is computed.
    ///
    /// # Errors
    /// The first value of the scene that is not allowed.
    pub fn new(
        scene: Arc<Scene>,
        method: MethodKind,
        asked: Option<Strategy>,
    ) -> Result<Self, Refusal> {
        let model = scene.model()?;
        let plan = plan(&scene, &model, asked).by(method);
        let wanted = match plan.strategy {
            // A hand may go anywhere, so that the walk solves what is shown; the atlas only says
            // what is ahead.
            Strategy::Atlas => Part::Quarter,
            Strategy::Walk(part) => part,
        };
        let because = (wanted == Part::Quarter)
            .then(|| objection(&model, method, asked))
            .flatten();
        let part = if because.is_some() {
            Part::Whole
        } else {
            wanted
        };
        Ok(Self {
            scene,
            method,
            choice: ModelChoice {
                plan,
                part,
                because,
            },
        })
    }

    /// A walk at rest at the start of the drive.
    ///
    /// # Errors
    /// The first value of the scene that is not allowed.
    pub fn walk(&self, cancel: &Cancel) -> Result<Walk, Refusal> {
        Walk::start(
            &self.scene,
            WalkOptions {
                part: self.choice.part,
                ..self.method.into()
            },
            cancel,
        )
    }

    /// A walk that stands on a stored state, on the part of the cell on which it was walked; `None`
    /// if it is not of this scene.
    pub fn resume(&mut self, from: &Stored) -> Option<Walk> {
        if self.choice.part != from.part {
            (self.choice.part, self.choice.because) = (from.part, None);
        }
        let walk = self.walk(&Cancel::default()).ok()?;
        let fits = walk.system().dimension() == from.surface.state.amplitudes.len();
        fits.then(|| walk.standing_on(from.surface.clone(), from.record.clone()))
    }

    /// Goes over to the whole cell, for the reason given. `None` if it was the whole cell already.
    pub fn widen(&mut self, walk: &mut Walk, because: &Stuck, cancel: &Cancel) -> Option<Widened> {
        let widened = walk.widen(because, &self.scene, cancel)?;
        self.choice.part = Part::Whole;
        self.choice.because = Some(because.to_string());
        Some(widened)
    }
}

/// Why a part of the cell will not do; `None` if it will.
fn objection(model: &Model, method: MethodKind, asked: Option<Strategy>) -> Option<String> {
    if !model.grid.nx.is_multiple_of(4) {
        return Some(format!(
            "{} points a side are no multiple of 4",
            model.grid.nx
        ));
    }
    // The yardstick stays as it was published, unless somebody asks.
    (method == MethodKind::Gfmd && asked != Some(Strategy::QUARTER))
        .then(|| "the paper's method runs as it was published".to_owned())
}
