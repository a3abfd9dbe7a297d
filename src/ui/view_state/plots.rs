//! What the diagrams show beside the present run, and their axes: the live loop, earlier loops,
//! theory; and the loops that are kept, to compare others with them (another law, another mesh,
//! another machine): a list with names and looks.

use super::ViewState;
use crate::follow::diagram::Diagram;
use crate::physics::control::Control;
use crate::physics::parameter::Dimension;
use crate::physics::pattern::Pattern;
use crate::plot::curve::{Curve, ZeroRange};
use crate::plot::loop_panel::place;
use crate::plot::panel::{Colour, Dash, Role, Series};
use crate::plot::scale;
use crate::scene::parameter::fixed;
use crate::scene::{Model, Scene};
use crate::storage::scene_file;
use crate::study::landscape::Standing;
use crate::study::live_loop::Sample;
use crate::ui::action::{KeepFrom, KeptAct, Scales};
use crate::worker::protocol::{LiveState, RunId, Stored};
use serde::{Deserialize, Serialize};
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
#[derive(Debug, Default)]
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
        let [left, right] = self
            .scene
            .window_of_u0(&self.model)
            .map(|u0| u0 / self.rho());
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
        let [low, high] = self.scene.window_of_u0(&self.model);
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

    /// What the machine allows at the present value of the control: stress = k (w - u0) under a spring,
    /// stress = F under a load; from one side of the plot to the other.
    pub fn machine_line(&self, [left, right]: [f64; 2]) -> Option<Series> {
        let (control, law) = (self.scene.control(), &self.model.law);
        let value = self.run.state.as_ref()?.control;
        let stress = |u0: f64| match control {
            Control::Displacement => None,
            Control::Spring { stiffness } => Some(stiffness * (value - u0)),
            Control::Load => Some(value),
        };
        let points = [left, right].map(|x| Some([x, stress(x * law.range)? / law.traction_max()]));
        let points: Vec<[f64; 2]> = points.into_iter().flatten().collect();
        (!points.is_empty()).then(|| Series::line("machine", Role::Theory, Colour::MACHINE, points))
    }

    /// The live loop of this very scene: that of an edited one comes a moment later.
    pub(super) fn own_live(&self) -> Option<&LiveView> {
        let live = self.plots.live.as_ref();
        live.filter(|live| live.run == self.run.id)
    }

    /// Where the surface will stand at the target, read off the live loop of this very scene.
    pub fn foreseen(&self) -> Option<(Pattern, Sample)> {
        if self.target == self.run.actual {
            return None;
        }
        let found = self.own_live()?.state.found.as_ref().ok()?;
        found.reading(self.run.state.as_ref()?, self.target)
    }
}

/// Most loops that are kept: more cannot be told apart.
const MOST: usize = 8;
/// Their colours and dashes, each by turns, so that the first twelve differ.
const COLOURS: [Colour; 4] = [Colour::Purple, Colour::Green, Colour::Red, Colour::Gold];
const DASHES: [Dash; 3] = [Dash::Solid, Dash::Long, Dash::Dotted];

/// A loop that is kept.
#[derive(Clone, Debug)]
pub struct Kept {
    /// Its number, by which it is known.
    pub id: usize,
    /// Its name.
    pub name: String,
    /// Its scene.
    pub scene: Arc<Scene>,
    /// What that was decided to be.
    pub model: Model,
    /// Its pieces in u0 (length) and stress (E*).
    pub lines: Vec<Vec<[f64; 2]>>,
    /// What it loses (gamma), if it is closed.
    pub loss: Option<f64>,
    /// How many jumps it has.
    pub jumps: usize,
    /// The live loop of its scene, if that is known; it was kept of it where `is_walked` is false.
    pub live: Option<Arc<LiveState>>,
    /// It is what was walked.
    pub is_walked: bool,
    /// It is not drawn.
    pub is_hidden: bool,
}

impl Kept {
    /// Its look.
    pub fn look(&self) -> (Colour, Dash) {
        let id = self.id;
        (COLOURS[id % COLOURS.len()], DASHES[id % DASHES.len()])
    }

    /// Its natural units: the range, and the largest traction.
    pub fn natural(&self) -> [f64; 2] {
        [self.model.law.range, self.model.law.traction_max()]
    }

    /// Takes over what a live loop tells of its scene.
    pub fn foretold(&mut self, live: Arc<LiveState>) {
        if let (Ok(found), true) = (&live.found, self.lines.is_empty()) {
            self.lines = found.legs.iter().map(|leg| found.points_of(leg)).collect();
            (self.loss, self.jumps) = (Some(found.dissipated_energy), found.jumps.len());
        }
        self.live = Some(live);
    }

    /// What it is, in few words.
    pub fn words(&self) -> String {
        let Model { grid, law, .. } = &self.model;
        let loss = self.loss.map(|loss| format!(", lost {} γ", fixed(loss, 4)));
        format!(
            "{}, {}, n = {}, {}{}, {} jumps",
            if self.is_walked {
                "walked"
            } else {
                "live loop"
            },
            law.shape.word().replace('_', " "),
            grid.nx,
            match self.scene.drive.control.word() {
                "displacement" => "stiff machine",
                word => word,
            },
            loss.unwrap_or_default(),
            self.jumps
        )
    }
}

/// The kept loops, in the order in which they came.
#[derive(Debug, Default)]
pub struct KeptLoops {
    /// They.
    pub list: Vec<Kept>,
    /// The one that was deleted last.
    pub deleted: Option<Kept>,
    /// How many there have been.
    count: usize,
}

/// A kept loop in a session file.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SavedLoop {
    name: String,
    /// The scene file.
    scene: String,
    lines: Vec<Vec<[f64; 2]>>,
    loss: Option<f64>,
    jumps: usize,
    is_walked: bool,
    is_hidden: bool,
}

impl SavedLoop {
    fn of(kept: &Kept) -> Self {
        Self {
            name: kept.name.clone(),
            scene: scene_file::to_text(&kept.scene),
            lines: kept.lines.clone(),
            loss: kept.loss,
            jumps: kept.jumps,
            is_walked: kept.is_walked,
            is_hidden: kept.is_hidden,
        }
    }

    /// Under this number; `None` if its scene is not allowed any more, as without its height file.
    fn kept(self, id: usize) -> Option<Kept> {
        let scene = scene_file::parse(&self.scene, &self.name).ok()?;
        Some(Kept {
            id,
            name: self.name,
            model: scene.model().ok()?,
            scene: Arc::new(scene),
            lines: self.lines,
            loss: self.loss,
            jumps: self.jumps,
            live: None,
            is_walked: self.is_walked,
            is_hidden: self.is_hidden,
        })
    }
}

impl KeptLoops {
    /// All of them for a session file.
    pub(super) fn saved(&self) -> Vec<SavedLoop> {
        self.list.iter().map(SavedLoop::of).collect()
    }

    /// Those of a session file.
    pub(super) fn new(saved: Vec<SavedLoop>) -> Self {
        let loops = saved.into_iter().take(MOST).enumerate();
        let list: Vec<Kept> = loops.filter_map(|(id, saved)| saved.kept(id)).collect();
        Self {
            count: MOST.max(list.len()),
            list,
            deleted: None,
        }
    }

    /// The one of this number.
    pub fn get(&self, id: usize) -> Option<&Kept> {
        self.list.iter().find(|kept| kept.id == id)
    }

    pub(super) fn get_mut(&mut self, id: usize) -> Option<&mut Kept> {
        self.list.iter_mut().find(|kept| kept.id == id)
    }

    /// Those that are drawn.
    pub fn drawn(&self) -> impl Iterator<Item = &Kept> {
        self.list.iter().filter(|kept| !kept.is_hidden)
    }

    /// A name that none of them has.
    fn unlike(&self, name: &str) -> String {
        let is_free = |name: &String| self.list.iter().all(|kept| kept.name != *name);
        let numbered = (2..).map(|k| format!("{name} ({k})"));
        let mut names = std::iter::once(name.to_owned()).chain(numbered);
        names.find(is_free).unwrap_or_default()
    }
}

impl ViewState {
    /// The u0 and the stress that are 1 where a kept loop is drawn: its own natural units, or those
    /// of the present law.
    pub fn units_of(&self, kept: &Kept) -> [f64; 2] {
        match self.view.scales {
            Scales::Own => kept.natural(),
            Scales::Absolute => [self.rho(), self.model.law.traction_max()],
        }
    }

    /// A kept loop as it is drawn.
    pub fn lines_of(&self, kept: &Kept) -> Vec<Vec<[f64; 2]>> {
        let [u0, stress] = self.units_of(kept);
        let scaled =
            |line: &Vec<[f64; 2]>| line.iter().map(|p| [p[0] / u0, p[1] / stress]).collect();
        kept.lines.iter().map(scaled).collect()
    }

    /// Keeps a loop.
    pub fn keep(&mut self, from: KeepFrom) {
        let live = self.own_live().map(|live| live.state.clone());
        let live = live.filter(|live| live.found.is_ok());
        let walked = self.run.curve.points().nth(2).is_some();
        let from = match from {
            // A closed loop goes before what is foreseen, which goes before a piece of one.
            KeepFrom::Best if self.run.closed_loop.is_some() || live.is_none() => KeepFrom::Walked,
            KeepFrom::Best => KeepFrom::Live,
            from => from,
        };
        if self.plots.kept.list.len() >= MOST {
            let words = format!("{MOST} loops are kept: delete one of them first");
            self.messages.notice = Some(words);
            return;
        }
        let mut kept = self.unnamed(self.scene.clone(), self.model.clone());
        match (from, live) {
            (KeepFrom::Walked, live) if walked => {
                let own = kept.natural();
                let lines = self.run.curve.pieces.iter().map(|piece| {
                    let points = piece.points.iter();
                    points.map(|p| [p[0] * own[0], p[1] * own[1]]).collect()
                });
                kept.lines = lines.collect();
                kept.loss = self.run.loss();
                kept.jumps = self.run.record.jumps.len();
                (kept.live, kept.is_walked) = (live, true);
            }
            (KeepFrom::Live, Some(live)) => kept.foretold(live),
            (KeepFrom::Live, None) => {
                self.messages.notice = Some("there is no live loop of this scene".to_owned());
                return;
            }
            _ => {
                self.messages.notice = Some("no loop to keep yet: play one first".to_owned());
                return;
            }
        }
        let words = format!("“{}” stays on the plot; see the tab Loops", kept.name);
        self.messages.notice = Some(words);
        self.add_kept(kept);
    }

    /// Keeps the scene before the last edit, and puts it beside this one.
    pub fn compare_with_before(&mut self) {
        let Some(scene) = self.history.before().cloned() else {
            self.messages.notice = Some("no scene came before this one".to_owned());
            return;
        };
        let known = |kept: &&Kept| kept.scene == scene;
        if let Some(id) = self.plots.kept.list.iter().find(known).map(|kept| kept.id) {
            return self.act_on_kept(id, KeptAct::Beside);
        }
        if let Ok(model) = scene.model() {
            let kept = self.unnamed(scene, model);
            let id = kept.id;
            self.add_kept(kept);
            self.act_on_kept(id, KeptAct::Beside);
        }
    }

    fn unnamed(&self, scene: Arc<Scene>, model: Model) -> Kept {
        Kept {
            id: self.plots.kept.count,
            name: self.plots.kept.unlike(&scene.title),
            scene,
            model,
            lines: Vec::new(),
            loss: None,
            jumps: 0,
            live: None,
            is_walked: false,
            is_hidden: false,
        }
    }

    fn add_kept(&mut self, kept: Kept) {
        self.plots.kept.count += 1;
        self.plots.kept.list.push(kept);
    }

    /// Does something with a kept loop.
    pub fn act_on_kept(&mut self, id: usize, act: KeptAct) {
        let Some(index) = self.plots.kept.list.iter().position(|kept| kept.id == id) else {
            return;
        };
        let kept = &mut self.plots.kept.list[index];
        match act {
            KeptAct::Rename(name) => kept.name = name,
            KeptAct::Hide => kept.is_hidden = !kept.is_hidden,
            KeptAct::Restore => {
                let scene = (*kept.scene).clone();
                self.open_scene(scene);
            }
            KeptAct::Delete => {
                self.plots.kept.deleted = Some(self.plots.kept.list.remove(index));
            }
            KeptAct::Beside => self.put_beside(id),
        }
    }

    /// Brings the loop back that was deleted last.
    pub fn bring_kept_back(&mut self) {
        let list = &mut self.plots.kept;
        if let Some(kept) = list.deleted.take() {
            let index = list.list.partition_point(|other| other.id < kept.id);
            list.list.insert(index, kept);
        }
    }
}
