//! Every branch of the scene, stable and unstable: followed while somebody looks, and a click shows
//! the state at that point in map and profile.

use super::{Tab, Title, Update, doing};
use crate::follow::diagram::{Branch, Diagram, Kind, Point};
use crate::physics::parameter::Dimension;
use crate::plot::diagram_panel::{counts, diagram_panel};
use crate::plot::loop_panel::place;
use crate::plot::panel::{Colour, Panel, Role, Series, Symbol};
use crate::scene::{Model, Scene};
use crate::ui::action::Action;
use crate::ui::diagram;
use crate::ui::loop_plot::axes;
use crate::ui::view_state::ViewState;
use crate::ui::widgets::{described, progress};
use crate::worker::job::{Job, Reporter};
use crate::worker::protocol::Frame;
use crate::worker::{SolverHandle, background};
use egui::{RichText, Ui};
use ndarray::Array2;
use std::sync::Arc;

/// A click this near to a point means it, in screen points.
const NEAR: f32 = 14.0;

/// The tab.
#[derive(Default)]
pub struct Branches {
    /// The scene they are followed for, and how many were opened up to it.
    scene: Option<(usize, Arc<Scene>)>,
    /// The newest diagram; of an edited scene until its own is there.
    shown: Option<Shown>,
    /// The one that is being computed.
    job: Option<Job<Arc<Diagram>>>,
    /// Why there is none.
    missing: Option<String>,
    /// The point whose state map and profile show.
    at: Option<Seen>,
    /// The point that is to be pictured next.
    asked: Option<At>,
}

/// A point: its branch, and its place on it.
type At = [usize; 2];

/// Fields of the modes along which a state is unstable, the softest first.
type Modes = Arc<Vec<Arc<Array2<f64>>>>;

/// The state at a point, as it is pictured.
struct Seen {
    at: At,
    frame: Arc<Frame>,
    modes: Job<Modes>,
    /// Which of them is on the map; each click on the point shows the next.
    mode: usize,
}

/// A diagram with the model whose law scales it.
struct Shown {
    diagram: Arc<Diagram>,
    model: Model,
    /// As it is drawn.
    panel: Panel,
}

impl Tab for Branches {
    fn title(&self) -> Title {
        let what = "every state of equilibrium, stable and unstable: why there are jumps";
        Title::new("Branches", what)
    }

    fn show(&mut self, ui: &mut Ui, state: &ViewState, _: &mut Vec<Action>) {
        self.words(ui);
        let at = self.at.as_ref().map(|seen| seen.at);
        if let Some(shown) = &self.shown {
            self.asked = clicked(ui, state, shown, at);
        } else {
            ui.label(RichText::new("Every state of equilibrium, stable or not.").weak());
        }
    }

    fn panels(&self, _: &ViewState) -> Vec<Panel> {
        self.shown.iter().map(|shown| shown.panel.clone()).collect()
    }

    fn update(&mut self, with: Update<'_>) {
        let state = with.state;
        let asked = self.asked.take();
        let (opened, scene) = (state.opened.count, &state.scene);
        let before = self.scene.as_ref();
        if before.is_none_or(|(_, before)| !Arc::ptr_eq(before, scene)) {
            let edited = before.is_some_and(|(before, _)| *before == opened);
            *self = Self {
                shown: self.shown.take().filter(|_| edited),
                scene: Some((opened, scene.clone())),
                ..Self::default()
            };
        }
        // The words of a point end with what they speak of.
        let now = state.frame.as_ref();
        self.at
            .take_if(|seen| now.is_none_or(|now| !Arc::ptr_eq(now, &seen.frame)));
        match (asked, &mut self.at) {
            (Some(at), Some(seen)) if seen.at == at => seen.next(state),
            (Some(at), _) => self.picture(at, state, with.solver),
            _ => {}
        }
        if let Some(seen) = &mut self.at
            && seen.modes.poll().is_some()
        {
            seen.show_mode(state);
        }
        self.take_in(state);
        if (with.seen || state.plots.wants_branches) && self.job.is_none() {
            self.job = Some(with.solver.job(state.scene.clone(), background::diagram));
        }
    }
}

impl Branches {
    /// Takes in what the job has found, and lays what the loop cannot show beneath it: unstable
    /// branches, and where stable ones end.
    fn take_in(&mut self, state: &mut ViewState) {
        let Some(job) = &mut self.job else { return };
        let end = job.poll();
        if let Some(diagram) = job.so_far.take() {
            let model = state.model.clone();
            let panel = diagram_panel(&diagram, &model);
            let marks = [Symbol::Square, Symbol::Circle];
            let beneath = |series: &&Series| {
                series.role == Role::Unstable && series.colour != Colour::FLAT
                    || series.symbol.is_some_and(|symbol| marks.contains(&symbol))
            };
            state.plots.beneath = panel.series.iter().filter(beneath).cloned().collect();
            state.plots.branches = Some(diagram.clone());
            self.at = None;
            self.shown = Some(Shown {
                diagram,
                model,
                panel,
            });
        }
        if let Some(Err(why)) = end {
            self.missing = Some(why);
        }
    }

    /// Shows the state at a point in map and profile, until the surface moves.
    fn picture(&mut self, at: At, state: &mut ViewState, solver: &dyn SolverHandle) {
        let shown = self.shown.as_ref();
        let Some((branch, point)) = shown.and_then(|shown| shown.point(at)) else {
            return;
        };
        let at_point = [point.state.mean_displacement, point.state.stress];
        let gap = Arc::new(branch.picture(point, &state.model.grid));
        let frame = Arc::new(Frame::of_a_branch(state.run.actual, at_point, gap));
        state.frame = Some(frame.clone());
        let input = (self.diagram(), at, state.model.clone());
        let modes = solver.job(input, modes);
        self.at = Some(Seen {
            at,
            frame,
            modes,
            mode: 0,
        });
    }

    fn diagram(&self) -> Arc<Diagram> {
        let shown = self.shown.as_ref();
        shown.map_or_else(Arc::default, |shown| shown.diagram.clone())
    }

    /// How far the job is, or why there is nothing, or what is seen.
    fn words(&self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            match (&self.job, &self.missing, &self.shown) {
                (Some(job), ..) if job.is_running() => {
                    progress(ui, job);
                    doing(ui, job);
                }
                (_, Some(why), _) => {
                    ui.label(why);
                }
                (_, _, Some(shown)) => {
                    let at = self.at.as_ref();
                    let at = at.and_then(|seen| Some(shown.words(seen.at)? + &seen.words()));
                    let mut words = at.unwrap_or_else(|| counts(&shown.diagram));
                    let control = shown.diagram.control;
                    if control.frees_mean() {
                        words.insert_str(0, &format!("Under {control}: "));
                    }
                    for missing in &shown.diagram.missing {
                        words.push_str(&format!("; missing: {missing}"));
                    }
                    ui.add(egui::Label::new(RichText::new(words).small()).truncate());
                }
                _ => {}
            }
        });
    }
}

impl Seen {
    /// The next mode on the map.
    fn next(&mut self, state: &mut ViewState) {
        self.mode += 1;
        self.show_mode(state);
    }

    fn count(&self) -> usize {
        self.modes.so_far.as_ref().map_or(0, |modes| modes.len())
    }

    fn show_mode(&mut self, state: &mut ViewState) {
        let Some(modes) = self.modes.so_far.as_ref().filter(|modes| !modes.is_empty()) else {
            return;
        };
        let soft_mode = Some(modes[self.mode % modes.len()].clone());
        self.frame = Arc::new(Frame {
            soft_mode,
            ..(*self.frame).clone()
        });
        state.frame = Some(self.frame.clone());
    }

    /// Which mode is shown.
    fn words(&self) -> String {
        match self.count() {
            0 | 1 => String::new(),
            count => format!(
                " (on the map {} of {count}; click for the next)",
                self.mode % count + 1
            ),
        }
    }
}

/// The modes along which the state at a point is unstable.
fn modes(
    (diagram, [branch, point], model): &(Arc<Diagram>, At, Model),
    report: &Reporter<Modes>,
) -> Result<(), String> {
    let Some(branch) = diagram.branches.get(*branch) else {
        return Ok(());
    };
    let found = branch.negative_modes(&branch.points[*point], model, &report.cancel);
    let found = found.map_err(|lost| format!("{lost:?}"))?;
    report.result(Arc::new(found.into_iter().map(Arc::new).collect()));
    Ok(())
}

impl Shown {
    fn point(&self, at: At) -> Option<(&Branch, &Point)> {
        let branch = self.diagram.branches.get(at[0])?;
        Some((branch, branch.points.get(at[1])?))
    }

    /// A point in words: what it is, and along how many modes it is unstable.
    fn words(&self, at: At) -> Option<String> {
        let (branch, point) = self.point(at)?;
        let [before, after] = point.index;
        let softness = match before.min(after) {
            _ if point.kind == Kind::Fold => "a fold: its own mode has no stiffness".to_owned(),
            _ if point.kind == Kind::Bifurcation => "a bifurcation: other states leave".to_owned(),
            0 => "stable".to_owned(),
            1 => "unstable along one mode: a pass between two valleys".to_owned(),
            many => format!("unstable along {many} modes"),
        };
        let u0 = point.state.mean_displacement / self.model.law.range;
        Some(format!(
            "Map: {} on \"{}\" at {}, {softness}",
            point.pattern,
            branch.name,
            self.model.unit(Dimension::Length).say(u0, 3, "ρ")
        ))
    }
}

/// Draws the diagram with a frame around the point that is pictured; returns the point that was
/// clicked.
fn clicked(ui: &mut Ui, state: &ViewState, shown: &Shown, at: Option<At>) -> Option<At> {
    let mut panel = shown.panel.clone();
    let [x, y] = axes(&shown.model);
    (panel.x.label, panel.y.label) = (x.label, y.label);
    let now = state.run.state.as_ref();
    let now = now.map(|now| [now.mean_displacement / state.rho(), now.stress_over_max]);
    panel.series.extend(Series::here(now));
    let law = &shown.model.law;
    let seen = at.and_then(|at| shown.point(at));
    let seen = seen.map(|(_, at)| place(at.state.mean_displacement, at.state.stress, law));
    panel.series.push(Series::framed(seen, Colour::Ink));
    let height = ui.available_height().max(80.0);
    let drawn = diagram::show(ui, &panel, "branches", height, |_, _| None);
    let nearest = diagram::nearest(&drawn, NEAR, points(shown));
    if nearest.is_some() {
        ui.ctx().set_cursor_icon(egui::CursorIcon::PointingHand);
    }
    let sentence = format!("Every branch of equilibria: {}", counts(&shown.diagram));
    described(&drawn.response, &sentence);
    nearest.filter(|_| drawn.response.clicked())
}

/// Every point with its branch and place, and where it is drawn.
fn points(shown: &Shown) -> impl Iterator<Item = (At, [f64; 2])> + '_ {
    let law = &shown.model.law;
    shown
        .diagram
        .branches
        .iter()
        .enumerate()
        .flat_map(move |(i, branch)| {
            branch.points.iter().enumerate().map(move |(j, point)| {
                let (u0, stress) = (point.state.mean_displacement, point.state.stress);
                ([i, j], place(u0, stress, law))
            })
        })
}
