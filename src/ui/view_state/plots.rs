//! What the diagrams show beside the present run, and their axes: the live loop, earlier loops,
//! those that are kept, theory.

use super::{KeptLoops, ViewState};
use crate::follow::diagram::Diagram;
use crate::paper::overlay::ZeroRange;
use crate::physics::parameter::Dimension;
use crate::physics::pattern::Pattern;
use crate::plot::curve::Curve;
use crate::plot::loop_panel::place;
use crate::plot::panel::Series;
use crate::plot::scale;
use crate::scene::Model;
use crate::scene::window;
use crate::study::landscape::Standing;
use crate::study::live_loop::Sample;
use crate::worker::protocol::{LiveState, RunId, Stored};
use std::collections::VecDeque;
use std::sync::Arc;

/// Most faint curves of earlier loops.
const GHOSTS_MAX: usize = 3;
/// Most guesses of a lecture.
const GUESSES_MAX: usize = 6;

/// A path that was left for another one.
#[derive(Debug)]
pub struct Ghost {
    /// All of it.
    pub curve: Curve,
    /// Its states that are on no other path, to be looked at and gone on from.
    pub states: Vec<Arc<Stored>>,
}

/// What the diagrams show beside the present run.
#[derive(Debug)]
pub struct Plots {
    /// The live loop.
    pub live: Option<LiveView>,
    /// Paths that were left.
    pub ghosts: VecDeque<Ghost>,
    /// The loops that are kept to compare with.
    pub kept: KeptLoops,
    /// The flat state's curve.
    pub flat_state: Vec<Series>,
    /// Axes fitted to the data instead of the scene: (lower left, upper right).
    pub fit: Option<([f64; 2], [f64; 2])>,
    /// What lies under the loop, of this very scene.
    pub beneath: Vec<Series>,
    /// The loop of another scene, at which somebody points.
    pub preview: Option<Series>,
    /// The branches of this very scene.
    pub branches: Option<Arc<Diagram>>,
    /// Somebody looks at what is made of them.
    pub wants_branches: bool,
    /// The lowest barrier that is known, per area (E* times length), and of which state.
    pub barrier: Option<(Standing, f64)>,
    /// Where the next jump is guessed to be (ranges), in a lecture.
    pub guesses: Vec<f64>,
    /// Theory is laid over the live plot, once it is known.
    pub overlay: bool,
    /// Theory.
    pub theory: Option<Arc<ZeroRange>>,
}

impl Plots {
    /// Nothing but the flat state.
    pub(super) fn new(flat_state: Vec<Series>) -> Self {
        Self {
            live: None,
            ghosts: VecDeque::new(),
            kept: KeptLoops::default(),
            flat_state,
            fit: None,
            beneath: Vec::new(),
            preview: None,
            branches: None,
            wants_branches: false,
            barrier: None,
            guesses: Vec::new(),
            overlay: false,
            theory: None,
        }
    }

    /// One more guess of u0 (ranges); the oldest goes.
    pub fn guess(&mut self, u0: f64) {
        self.guesses.insert(0, u0);
        self.guesses.truncate(GUESSES_MAX);
    }

    /// Keeps an earlier path in sight.
    pub(super) fn add_ghost(&mut self, old: Ghost) {
        if old.curve.points().nth(2).is_some() {
            self.ghosts.push_back(old);
            if self.ghosts.len() > GHOSTS_MAX {
                self.ghosts.pop_front();
            }
        }
    }
}

/// What is drawn of the live loop.
#[derive(Clone, Debug)]
pub struct LiveView {
    /// The run it was computed for.
    pub run: RunId,
    /// The loop with its numbers.
    pub state: Arc<LiveState>,
    /// Its pieces: (u0/rho, stress/sigma_max).
    pub pieces: Vec<Vec<[f64; 2]>>,
    /// Its jumps: (u0/rho, stress/sigma_max) before and after.
    pub jumps: Vec<[[f64; 2]; 2]>,
}

impl LiveView {
    /// Scales a loop by its own law.
    pub fn new(run: RunId, state: Arc<LiveState>) -> Self {
        let (mut pieces, mut jumps) = (Vec::new(), Vec::new());
        if let Ok(found) = &state.found {
            let at = |u0, stress| place(u0, stress, &found.law);
            let legs = found.legs.iter().map(|leg| found.points_of(leg));
            pieces = legs
                .map(|leg| leg.into_iter().map(|[u0, stress]| at(u0, stress)).collect())
                .collect();
            let ends = found.jumps.iter().map(|j| {
                [
                    at(j.mean_displacement, j.stress_before),
                    at(j.mean_displacement_after, j.stress_after),
                ]
            });
            jumps = ends.collect();
        }
        Self {
            run,
            state,
            pieces,
            jumps,
        }
    }

    /// The loop in words: what it dissipates, how long it took, which model; or why there is none.
    pub fn words(&self, model: &Model) -> String {
        let energy = model.unit(Dimension::SurfaceEnergy);
        match &self.state.found {
            Ok(found) => format!(
                "loop {} in {:.0} ms (atlas, {} points)",
                energy.say(found.dissipated_energy, 4, "γ"),
                self.state.milliseconds,
                found.points
            ),
            Err(reason) => format!("no live loop: {reason}"),
        }
    }
}

impl ViewState {
    /// Fits the plot's axes to the data; without any, to the scene.
    pub fn fit_axes(&mut self) {
        let plots = &self.plots;
        let kept = plots.kept.drawn().flat_map(|kept| self.lines_of(kept));
        let earlier = plots.ghosts.iter().flat_map(|ghost| ghost.curve.points());
        let walked = self.run.curve.points().chain(earlier);
        let points: Vec<[f64; 2]> = walked.chain(kept.flatten()).collect();
        let side = |k: usize| {
            let (low, high) = scale::ends(points.iter().map(|p| p[k]));
            let margin = 0.06 * (high - low).max(1e-3);
            (low - margin, high + margin)
        };
        let ((left, right), (low, high)) = (side(0), side(1));
        self.plots.fit = (!points.is_empty()).then_some(([left, low], [right, high]));
    }

    /// Axes of the plot: (lower left, upper right) in u0/rho and stress/sigma_max.
    pub fn axes(&self) -> ([f64; 2], [f64; 2]) {
        self.plots.fit.unwrap_or_else(|| self.scene_axes())
    }

    /// The same of the scene, whatever was done to them.
    pub fn scene_axes(&self) -> ([f64; 2], [f64; 2]) {
        let (low, high) = scale::stress_scale(&self.scene, &self.model);
        let [left, right] = window::of_u0(&self.scene, &self.model).map(|u0| u0 / self.rho());
        let margin = 0.03 * (right - left);
        ([left - margin, low], [right + margin, high])
    }

    /// True if recorded data lie outside the axes.
    pub fn data_leave_view(&self) -> bool {
        let (low, high) = self.axes();
        let out = |p: &[f64; 2]| (0..2).any(|k| p[k] < low[k] || p[k] > high[k]);
        let pieces = &self.run.curve.pieces;
        let newest = pieces.last().and_then(|piece| piece.points.last());
        newest.is_some_and(out)
            || pieces
                .iter()
                .any(|piece| piece.points.first().is_some_and(out))
    }

    /// Theory in the units of the live plot: name, and (u0/rho, stress/sigma_max).
    pub fn overlay(&self) -> Vec<(&'static str, Vec<[f64; 2]>)> {
        let Some(theory) = self.plots.theory.as_ref().filter(|_| self.plots.overlay) else {
            return Vec::new();
        };
        let law = &self.model.law;
        let [low, high] = window::of_u0(&self.scene, &self.model);
        let lines = theory.lines(&self.model, low, high).into_iter();
        let scaled = |points: Vec<[f64; 2]>| {
            let points = points.into_iter();
            points.map(|[u0, stress]| place(u0, stress, law)).collect()
        };
        lines.map(|line| (line.name, scaled(line.points))).collect()
    }

    /// While a parameter is dragged every loop is late by a few frames; it is drawn all the same.
    pub(super) fn take_live(&mut self, run: RunId, live: Arc<LiveState>) {
        let shown = self.plots.live.as_ref().map(|shown| shown.run);
        if run >= shown.unwrap_or(self.opened.first_run) {
            self.plots.live = Some(LiveView::new(run, live));
        }
    }

    /// Where the surface will stand at the target, read off the live loop of this very scene.
    pub fn foreseen(&self) -> Option<(Pattern, Sample)> {
        let live = self.plots.live.as_ref();
        let live = live.filter(|live| live.run == self.run.id)?;
        if self.target == self.run.actual {
            return None;
        }
        let found = live.state.found.as_ref().ok()?;
        found.reading(self.run.state.as_ref()?, self.target)
    }
}
